"""Ready cells: what `virtualrobot new` writes passes as it is."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from virtualrobot_apps.new.command import about, names, new

QUICK = "pick-and-place"


def test_cells_are_listed() -> None:
    listed = CliRunner().invoke(new, [])
    assert listed.output.splitlines() == [f"{name:<16}  {about(name)}" for name in names()]
    assert names() == ["conveyor", "machine-tending", "mobile", "palletizing", "pick-and-place"]


def test_nothing_is_written_over(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine", "utf-8")
    refused = CliRunner().invoke(new, [QUICK, str(tmp_path)])
    assert (refused.exit_code, list(tmp_path.iterdir())) == (2, [tmp_path / "mine.txt"])
    assert "is there already" in refused.output


@pytest.mark.long
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name == QUICK else pytest.mark.long) for name in names()]
)
def test_a_cell_passes_its_test(name: str, tmp_path: Path) -> None:
    """Its files alone are enough: the test runs in the folder, with a kernel of its own."""
    folder = tmp_path / "cell"
    written = CliRunner().invoke(new, [name, str(folder)])
    assert written.exit_code == 0, written.output
    assert {file.name for file in folder.iterdir()} >= {"README.md", "cell.yaml", "test_cell.py"}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(folder)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
