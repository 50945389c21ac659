"""Examples of processes, which `virtualrobot process new` writes: each is read by its process; there is one of each."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import pytest
from click.testing import CliRunner
from virtualrobot_apps.cell_io.yaml_file import read_file
from virtualrobot_apps.processes.command import EXAMPLES, process
from virtualrobot_apps.processes.process import known

NAMES = sorted(one.stem for one in EXAMPLES.glob("*.yaml"))
READERS = {"arc_weld": "read_weld", "tool_path": "read_follow"}


def written(folder: Path, name: str) -> Path:
    """Return the file that the command writes."""
    file = folder / "work.yaml"
    done = CliRunner().invoke(process, ["new", name, str(file)])
    assert done.exit_code == 0 and done.output == f"an example of {name} is in {file}\n", done.output
    return file


@pytest.mark.parametrize("name", NAMES)
def test_an_example_is_read_by_its_process(name: str, tmp_path: Path) -> None:
    (tmp_path / "pocket.nc").write_text("G0 X0 Y0\nG1 X10 F300\n")
    item = read_file(written(tmp_path, name))
    assert item.mapping()["process"].text() == name
    module = import_module(f"virtualrobot_apps.processes.{name}")
    read: Callable[[object], object] = getattr(module, READERS.get(name, f"read_{name}"))
    assert read(item)


def test_there_is_an_example_of_each_process() -> None:
    assert known() == NAMES


def test_what_is_there_is_left(tmp_path: Path) -> None:
    file = written(tmp_path, "paint")
    for where, words in ((file, "is there already"), (tmp_path / "none" / "a.yaml", "can't be written: No such file")):
        done = CliRunner().invoke(process, ["new", "cut", str(where)])
        assert done.exit_code == 2 and words in done.output
    assert "process: paint" in file.read_text()
    assert "is not one of" in CliRunner().invoke(process, ["new", "forge", str(file)]).output
