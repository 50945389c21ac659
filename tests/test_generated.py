"""Stubs and reference are what the generators make of the contract; the packaging asks for a runtime for the stubs.

In one file, so that no two workers set up the generator at once.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
REFERENCE = ROOT / "docs" / "reference"
COMMITTED = ROOT / "clients" / "python" / "virtualrobot" / "v1"


@pytest.fixture(scope="module")
def fresh(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return the text of each freshly generated file by name."""
    output = tmp_path_factory.mktemp("stubs")
    subprocess.run([sys.executable, ROOT / "tools" / "generate_stubs.py", output], check=True)
    return texts(output / "virtualrobot" / "v1")


def texts(directory: Path) -> dict[str, str]:
    """Return the text of each Python file of `directory` by name, but for __init__.py, which is written by hand."""
    return {path.name: path.read_text() for path in directory.glob("*.py*") if path.name != "__init__.py"}


def test_committed_stubs_are_fresh(fresh: dict[str, str]) -> None:
    committed = texts(COMMITTED)
    changed = [name for name in sorted(fresh.keys() | committed.keys()) if fresh.get(name) != committed.get(name)]
    assert not changed, f"run `make stubs` and commit; these differ from the contract: {', '.join(changed)}"


def test_reference_is_fresh(tmp_path: Path) -> None:
    subprocess.run([sys.executable, ROOT / "tools" / "generate_reference.py", tmp_path], check=True)
    fresh, committed = (
        {file.name: file.read_text("utf-8") for file in folder.iterdir()} for folder in (tmp_path, REFERENCE)
    )
    changed = [name for name in sorted(fresh.keys() | committed.keys()) if fresh.get(name) != committed.get(name)]
    assert not changed, f"run `python tools/generate_reference.py` and commit; these differ: {', '.join(changed)}"


def test_table_of_functions_is_fresh(tmp_path: Path) -> None:
    """Nothing is missing in it either: the generator refuses what has no group."""
    file = tmp_path / "functions.md"
    subprocess.run([sys.executable, ROOT / "tools" / "generate_functions.py", file], check=True)
    committed = (ROOT / "docs" / "functions.md").read_text("utf-8")
    assert file.read_text("utf-8") == committed, "run `python tools/generate_functions.py` and commit"


@pytest.mark.parametrize(
    ("tool", "page"),
    [
        ("rapid", "rapid-instructions.md"),
        ("rapl", "rapl-commands.md"),
        ("urscript", "urscript-functions.md"),
        ("abb", "abb-resources.md"),
    ],
)
def test_tables_of_languages_are_fresh(tool: str, page: str, tmp_path: Path) -> None:
    file = tmp_path / page
    subprocess.run([sys.executable, ROOT / "tools" / f"generate_{tool}.py", file], check=True)
    committed = (ROOT / "docs" / page).read_text("utf-8")
    assert file.read_text("utf-8") == committed, f"run `python tools/generate_{tool}.py` and commit"


def test_every_proto_file_has_its_stubs(fresh: dict[str, str]) -> None:
    nouns = [path.stem for path in (ROOT / "proto").rglob("*.proto")]
    assert nouns
    assert sorted(fresh) == sorted(f"{noun}_{kind}" for noun in nouns for kind in ("pb2.py", "pb2.pyi", "pb2_grpc.py"))


def test_packaging_asks_for_a_runtime_that_takes_the_stubs(fresh: dict[str, str]) -> None:
    """The versions that the stubs themselves check when they are imported are the lower bounds in pyproject.toml."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    bounds = dict(re.findall(r"^([\w-]+)>=([\d.]+)", "\n".join(project["dependencies"]), re.MULTILINE))
    stubs = "\n".join(fresh.values())
    demanded_grpc = set(re.findall(r"GRPC_GENERATED_VERSION = '(.*)'", stubs))
    demanded_protobuf = set(re.findall(r"# Protobuf Python Version: ([\d.]+)", stubs))
    assert demanded_grpc == {bounds["grpcio"]} == {bounds["grpcio-status"]}
    assert demanded_protobuf == {f"{bounds['protobuf']}.0"}
