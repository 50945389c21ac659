"""`pip install .` alone gives the client library and the command line, and no native robotics package."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import venv
from pathlib import Path

import pytest

pytestmark = pytest.mark.long  # installs from the network

ROOT = Path(__file__).resolve().parent.parent
WEB = Path("virtualrobot_apps/console/web")
"""Folder of the sources of the console's page, which only the repository has."""
SCRIPTS = "Scripts" if os.name == "nt" else "bin"

# All that the client may bring: what pyproject.toml names, what that needs, and the installer.
CLIENT_PACKAGES = {
    *("virtualrobot", "grpcio", "grpcio-status", "protobuf", "googleapis-common-protos", "typing-extensions"),
    *("numpy", "click", "colorama", "platformdirs", "prompt-toolkit", "pyyaml", "wcwidth", "pip", "setuptools"),
}
IMPORT_ALL = """
import importlib, pkgutil, virtualrobot, virtualrobot_apps
packages = (virtualrobot, virtualrobot_apps)
modules = [module for one in packages for module in pkgutil.walk_packages(one.__path__, f"{one.__name__}.")]
names = [module.name for module in modules]
for name in names:
    try:
        if not name.endswith(".__main__"):
            importlib.import_module(name)
    except ModuleNotFoundError as error:  # what extras bring
        extras = "abb_robot_client asyncua cbor2 cma cryptography cyclonedds fmpy foxglove foxglove_schemas_protobuf"
        extras = f"{extras} loky mcap gymnasium msgspec numba optuna paho PIL pyarrow pyastar2d pymodbus pytest"
        extras = f"{extras} pythonfmu3 ray rclpy rosbags scipy segno small_gicp trimesh uvicorn websockets"
        extras = f"{extras} zenoh".split()
        assert error.name.split(".")[0] in extras, error
assert "virtualrobot.v1.robot_pb2_grpc" in names and "virtualrobot.cli" in names, names
"""


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy, since setuptools would leave its build directory and read what an earlier build left there."""
    source = tmp_path_factory.mktemp("source") / "virtualrobot"
    leave = shutil.ignore_patterns(".git", ".venv", "node_modules", "build", "dist", "*.egg-info", "__pycache__")
    shutil.copytree(ROOT, source, ignore=leave)
    return source


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory, source: Path) -> Path:
    """Return a fresh environment that holds what `pip install .` installs."""
    home = tmp_path_factory.mktemp("client")
    venv.create(home, with_pip=True)
    run(home, "python", "-m", "pip", "install", "--quiet", str(source)).check_returncode()
    return home


def run(home: Path, program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a program of the environment `home`, away from the source tree."""
    environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONHOME")}
    command = [str(home / SCRIPTS / program), *arguments]
    return subprocess.run(command, cwd=home, env=environment, capture_output=True, text=True, stdin=subprocess.DEVNULL)


def test_nothing_but_the_client_is_installed(client: Path) -> None:
    listed = json.loads(run(client, "python", "-m", "pip", "list", "--format", "json").stdout)
    names = {re.sub(r"[-_.]+", "-", distribution["name"]).lower() for distribution in listed}
    assert {"virtualrobot", "grpcio"} <= names
    assert names <= CLIENT_PACKAGES


def test_every_module_of_the_client_imports(client: Path) -> None:
    result = run(client, "python", "-W", "error", "-c", IMPORT_ALL)
    assert result.returncode == 0, result.stderr


def test_every_file_of_the_packages_is_installed(client: Path) -> None:
    """Not only modules: types, robot models, licence-bearing notes beside them, the console's page as it is built."""
    (site,) = client.rglob("site-packages")
    packages = [
        *(ROOT / "clients" / "python" / name for name in ("virtualrobot", "virtualrobot_apps")),
        ROOT / "kernel" / "virtualrobot_kernel",
        *(ROOT / "plugins" / name for name in ("virtualrobot_sdk", "virtualrobot_plugins")),
    ]
    files = [(package, file) for package in packages for file in package.rglob("*") if file.is_file()]
    expected = {file.relative_to(package.parent) for package, file in files if "__pycache__" not in file.parts}
    sources = {file for file in expected if file.is_relative_to(WEB)}
    assert Path("virtualrobot/v1/robot_pb2.pyi") in expected and WEB / "package.json" in sources
    assert sorted(file for file in expected - sources if not (site / file).exists()) == []
    assert not (site / WEB).exists()


def test_the_command_line_helps(client: Path) -> None:
    result = run(client, "virtualrobot", "--help")
    assert result.returncode == 0, result.stderr
    assert "serve" in result.stdout
    assert "Watch two robots palletize." in result.stdout


@pytest.mark.parametrize("command", [["serve"], ["grade", "chain"]], ids=lambda command: command[0])
def test_it_is_told_how_to_install_the_kernel(client: Path, command: list[str]) -> None:
    result = run(client, "virtualrobot", *command)
    assert result.returncode != 0
    assert "pip install '.[kernel]'" in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1, result.stderr


def test_the_lowest_versions_that_we_allow_will_do(client: Path) -> None:
    """The stubs check the version of their runtime when they are imported."""
    dependencies = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    lowest = [
        re.sub(r">=([\d.]+).*", r"==\1", dependency)
        for dependency in dependencies
        if dependency.startswith(("grpcio", "protobuf"))
    ]
    assert len(lowest) == 3
    run(client, "python", "-m", "pip", "install", "--quiet", *lowest).check_returncode()
    result = run(client, "python", "-W", "error", "-c", IMPORT_ALL)
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize("lock", [ROOT / "package-lock.json", ROOT / "clients" / "node" / "package-lock.json"])
def test_npm_locks_name_the_binaries_of_all_platforms(lock: Path) -> None:
    """`npm install` leaves out those that its registry doesn't have, and then `npm ci` refuses the lock."""
    packages = json.loads(lock.read_text())["packages"]
    wanted = {name for package in packages.values() for name in package.get("optionalDependencies", {})}
    assert "@bufbuild/buf-win32-x64" in wanted
    assert sorted(name for name in wanted if f"node_modules/{name}" not in packages) == []


def test_the_source_distribution_has_all_that_the_repository_has(tmp_path: Path) -> None:
    """Built as pip builds it, from the files that git has."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    files = {name for name in listed.split("\0") if name and (ROOT / name).is_file()}
    source = tmp_path / "source"
    for name in files:
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, source / name)
    build = "import sys; from setuptools import build_meta; print(build_meta.build_sdist(sys.argv[1]))"
    subprocess.run([sys.executable, "-c", build, str(tmp_path)], cwd=source, capture_output=True, check=True)
    with tarfile.open(next(tmp_path.glob("*.tar.gz"))) as packed:
        names = {name.partition("/")[2] for name in packed.getnames()}
    assert files - names == set()


@pytest.mark.timeout(3000)
@pytest.mark.parametrize("version", ["3.12", "3.13"])
def test_a_kernel_runs_on_later_pythons(version: str, tmp_path: Path, source: Path) -> None:
    """The cell stands there, with arms of a package that has wheels for it, and an arm moves."""
    python = shutil.which(f"python{version}")
    if python is None or subprocess.run([python, "-c", ""], capture_output=True).returncode:
        pytest.skip(f"no Python {version} on this machine")
    subprocess.run([python, "-m", "venv", str(tmp_path)], check=True)
    wanted = ["-c", str(ROOT / "constraints.txt"), f"{source}[kernel]"]
    run(tmp_path, "python", "-m", "pip", "install", "--quiet", *wanted).check_returncode()
    program = (
        "import virtualrobot\n"
        "from virtualrobot.kernel_process import KernelProcess\n"
        "from virtualrobot_apps.demos.palletizing import cell\n"
        "with KernelProcess(headless=True) as kernel, virtualrobot.connect(kernel.address) as client:\n"
        "    cell.load(client)\n"
        "    client.robot('iiwa').move_joints([0.1] * 7)\n"
        "    print(client.robot('iiwa').positions[0], client.scene.pose('panda.panda_hand').shape)\n"
    )
    done = run(tmp_path, "python", "-c", program)
    assert done.stdout.split("\n")[0].startswith("0.1"), done.stderr
    assert done.stdout.strip().endswith("(4, 4)"), done.stderr
