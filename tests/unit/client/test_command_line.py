"""What the command line does without a kernel: help, wrong usage, values; and that it starts quickly."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from importlib import metadata
from pathlib import Path

import click
import numpy as np
import pytest
from virtualrobot import cli
from virtualrobot.cli.options import Numbers, pose_of_numbers

COMMANDS = (
    *("serve", "demo", "load", "models", "save", "export", "ls", "state", "move", "stop", "signal", "step"),
    *("plugins", "kinematics", "rays", "grade"),
)
HANDED_OVER = ("serve", "grade")
"""Commands that are programs of the kernel's side, which have help of their own."""


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Return a function that runs the command line and gives exit code, output and error output."""

    def run(*arguments: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as ended:
            cli.main(arguments)
        captured = capsys.readouterr()
        return int(ended.value.code or 0), captured.out, captured.err

    return run


def test_alone_it_shows_the_first_steps(run: Callable[..., tuple[int, str, str]]) -> None:
    code, output, _ = run()
    assert code == 0
    assert "virtualrobot demo" in output
    for command in COMMANDS:
        assert f"  {command} " in output


@pytest.mark.parametrize("command", [name for name in COMMANDS if name not in HANDED_OVER])
def test_every_command_has_help(run: Callable[..., tuple[int, str, str]], command: str) -> None:
    code, output, _ = run(command, "--help")
    assert code == 0
    assert "--address" in output
    assert "--debug" in output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("foo",), "there is no command 'foo'"),
        (("load",), "Missing argument 'FILE'"),
        (("load", "x.stl", "--at", "1,2"), "has 2 numbers; 3 or 6 are wanted"),
        (("load", "x.stl", "--at", "a,b,c"), "is not numbers"),
        (("load", "x.urdf", "--package", "name"), "is not name=folder"),
        (("load", "x.yaml", "--set", "arguments.prefix=a"), "a scene file says all that itself"),
        (("load", "x.yaml", "--srdf", "x.srdf"), "a scene file says all that itself"),
        (("export", "arm"), "Missing argument 'FILE'"),
        (("rays", "--from", "0,0,1"), "--from and --along go together"),
        (("rays", "--frame", "arm"), "--frame and --ignored go with --from and --along"),
        (("rays", "a", "b", "--from", "0,0,1", "--along", "0,0,1"), "one ray is cast by one ray caster"),
        (("move", "arm"), "say where to, in one way"),
        (("move", "arm", "--to", "home", "--pose", "0,0,0"), "say where to, in one way"),
        (("move", "arm", "joint=1", "--linear"), "--linear goes with --pose"),
        (("move", "arm", "--to", "home", "--via", "0,0,1"), "--via goes with --pose"),
        (("move", "arm", "--pose", "1,0,0", "--linear", "--via", "0,0,1"), "and without --linear"),
        (("move", "arm", "--pose", "1,0,0", "--via", "0,1"), "has 2 numbers; 3 are wanted"),
        (("move", "arm", "--to", "home", "--speed", "2"), "--speed is above 0, up to 1, not 2"),
        (("add", "object"), "there is no 'object' to add; it is one of box, "),
        (("new", "mobile", ""), "the name of the folder is empty"),
        (("jog", "arm", "--keys"), "--keys needs a terminal"),
        (("signal", "--create"), "say which signal"),
        (("step", "0"), "0 is not in the range"),
        (("topic", "pub", "/robots/ugv/command/twist", "-0.1", "0", "0"), "negative stands behind --"),
        (("stop", "--quickly"), "No such option '--quickly'; there are --"),
    ],
)
def test_wrong_usage_is_told_with_exit_code_2(
    run: Callable[..., tuple[int, str, str]], arguments: tuple[str, ...], message: str
) -> None:
    code, _, errors = run(*arguments)
    assert code == 2
    assert message in errors
    assert "Traceback" not in errors


def test_a_kernel_that_is_not_there_is_one_line(run: Callable[..., tuple[int, str, str]]) -> None:
    # Port 1 (tcpmux) is never given to a program that asks for a free port.
    code, output, errors = run("ls", "--address", "127.0.0.1:1")
    assert (code, output) == (1, "")
    assert errors.count("\n") == 1
    assert "no kernel answers at 127.0.0.1:1" in errors
    assert "virtualrobot serve" in errors


def test_an_address_that_is_none_is_one_line(run: Callable[..., tuple[int, str, str]]) -> None:
    code, _, errors = run("--address", "127.0.0.1:abc", "ls")
    assert code == 1
    assert errors == (
        "virtualrobot: '127.0.0.1:abc' is no address: 'abc' is no port; give host:port with a port from 1 to 65535\n"
    )


def test_debug_shows_the_traceback() -> None:
    from virtualrobot.errors import KernelGoneError

    with pytest.raises(KernelGoneError):
        cli.main(["ls", "--debug", "--address", "127.0.0.1:1"])


@pytest.mark.parametrize("command", HANDED_OVER)
def test_without_kernel_it_is_told_how_to_install_it(
    run: Callable[..., tuple[int, str, str]], monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    monkeypatch.setattr("virtualrobot.cli.serve.entry_points", lambda **_: metadata.EntryPoints())
    code, _, errors = run(command)
    assert code == 1
    assert "pip install '.[kernel]'" in errors


@pytest.mark.parametrize("command", HANDED_OVER)
def test_with_half_a_kernel_it_is_told_how_to_install_it(
    run: Callable[..., tuple[int, str, str]], monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    missing = metadata.EntryPoint(command, "no_such_kernel_package.serve:main", "virtualrobot.kernel")
    monkeypatch.setattr("virtualrobot.cli.serve.entry_points", lambda **_: metadata.EntryPoints([missing]))
    code, _, errors = run(command, "--port", "0")
    assert code == 1
    assert "no_such_kernel_package is missing" in errors
    assert "pip install '.[kernel]'" in errors


def test_grade_gets_all_arguments_and_gives_the_exit_code(
    run: Callable[..., tuple[int, str, str]], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "test_kit_that_tells.py").write_text("def main(arguments):\n    print(*arguments)\n    return 3\n")
    monkeypatch.syspath_prepend(tmp_path)
    found = metadata.EntryPoint("grade", "test_kit_that_tells:main", "virtualrobot.kernel")
    monkeypatch.setattr("virtualrobot.cli.serve.entry_points", lambda **_: metadata.EntryPoints([found]))
    assert run("grade", "my_arm:MyArm", "--set", "gain=1", "--help") == (3, "my_arm:MyArm --set gain=1 --help\n", "")
    (tmp_path / "test_kit_that_tells.py").write_text("def main(arguments):\n    import no_module_of_the_component\n")
    sys.modules.pop("test_kit_that_tells")
    sys.path_importer_cache.clear()
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    code, _, errors = run("grade", "my_arm:MyArm")
    assert (code, "no_module_of_the_component" in errors, "install" in errors) == (1, True, False)


@pytest.fixture
def install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[[str, str], None]:
    """Return a function that installs an application: the name of its command, and the source of its module."""
    installed: list[metadata.EntryPoint] = []
    monkeypatch.setattr("virtualrobot.cli.applications.entry_points", lambda *, group: metadata.EntryPoints(installed))
    monkeypatch.syspath_prepend(tmp_path)

    def install(name: str, source: str) -> None:
        module = f"{tmp_path.name}_{len(installed)}"
        (tmp_path / f"{module}.py").write_text(source)
        installed.append(metadata.EntryPoint(name, f"{module}:command", "virtualrobot.commands"))

    return install


SWEEP = "import click\n@click.command()\ndef command():\n    'Sweep the floor.'\n    print('swept')\n"


def test_an_application_adds_its_command(
    run: Callable[..., tuple[int, str, str]], install: Callable[[str, str], None]
) -> None:
    install("sweep", SWEEP)
    assert "  sweep  Sweep the floor." in run("--help")[1]
    assert run("sweep") == (0, "swept\n", "")


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("import no_such_library", "ModuleNotFoundError: No module named 'no_such_library'"),
        ("raise SystemExit(3)", "SystemExit: 3"),
        ("command = 3", "no click command but 3"),
        ("", "no attribute 'command'"),
    ],
)
def test_an_application_that_cannot_be_imported_costs_its_own_command_only(
    run: Callable[..., tuple[int, str, str]], install: Callable[[str, str], None], source: str, said: str
) -> None:
    install("broken", source)
    install("sweep", SWEEP)
    code, output, _ = run("--help")
    assert code == 0 and "Sweep the floor." in output and "cannot be loaded" in " ".join(output.split())
    code, _, errors = run("broken")
    assert (code, errors.count("\n")) == (1, 1) and said in errors
    assert run("sweep")[0] == 0


def test_no_application_takes_a_name_that_is_taken(
    run: Callable[..., tuple[int, str, str]], install: Callable[[str, str], None]
) -> None:
    for name, said in (("ls", "mine"), ("sweep", "alpha"), ("sweep", "omega")):
        install(name, SWEEP.replace("Sweep the floor.", said).replace("swept", said))
    output = run("--help")[1]
    assert "Draw the scene tree." in output and "mine" not in output and "omega" not in output
    assert run("sweep")[1] == "alpha\n"


def test_numbers() -> None:
    convert = Numbers(3, 6).convert
    assert convert("1,2,3", None, None) == (1, 2, 3)
    assert convert(" -1 0.5, 2e-1 ", None, None) == (-1, 0.5, 0.2)
    for bad in ("", "1,2", "1,2,3,4", "1,2,nan", "1;2;3"):
        with pytest.raises(click.BadParameter):
            convert(bad, None, None)


def test_a_place_without_angles_keeps_the_orientation() -> None:
    now = pose_of_numbers((1, 2, 3, 90, 0, 0), degrees=True)
    np.testing.assert_allclose(now[:3, :3], [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=1e-15)  # 90 degrees about x
    moved = pose_of_numbers((4, 5, 6), degrees=False, turned_as=now)
    np.testing.assert_array_equal(moved[:3, :3], now[:3, :3])
    np.testing.assert_array_equal(moved[:3, 3], (4, 5, 6))


def test_help_and_resolver_load_no_heavy_library() -> None:
    """Start-up is quick because nothing heavy is imported; counted, since a clock on a busy machine lies."""
    code = (
        "import sys, virtualrobot.cli, virtualrobot.files.resolver, virtualrobot.session\n"
        "try: virtualrobot.cli.main(['--help'])\n"
        "except SystemExit: pass\n"
        "print(sorted({'grpc', 'numpy', 'google.protobuf', 'platformdirs'} & set(sys.modules)))"
    )
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert output.splitlines()[-1] == "[]"
