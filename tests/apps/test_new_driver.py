"""Drivers of one's own: what `virtualrobot driver new` writes passes as it is."""

from __future__ import annotations

import ast
import socket
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from click.testing import CliRunner
from virtualrobot_apps.new.driver import DRIVERS, driver

LINES = 50
"""A driver is to be shorter than that, blank lines left out."""


@pytest.mark.long
@pytest.mark.parametrize("pace", ["host", "jobs"])
def test_a_driver_keeps_the_laws_as_it_is_written(pace: str, tmp_path: Path) -> None:
    """Its files alone are enough, in others' project, too; nothing of the name that they were written under is left."""
    around = '[tool.pytest.ini_options]\nno_such_option = 1\naddopts = "--strict-config --import-mode=importlib"\n'
    (tmp_path / "pyproject.toml").write_text(around, "utf-8")
    folder = tmp_path / "mine"
    written = CliRunner().invoke(driver, ["new", "gantry_two", str(folder), "--pace", pace])
    assert written.exit_code == 0, written.output
    files = {file.name: file.read_text("utf-8") for file in folder.iterdir()}
    assert set(files) == {"README.md", "board.py", "gantry_two.py", "pyproject.toml", "test_gantry_two.py"}
    assert [name for name, text in files.items() if "my_robot" in text or "my-robot" in text or "MyRobot" in text] == []
    assert "class GantryTwo(Driver)" in files["gantry_two.py"]
    assert 'name = "gantry-two"' in files["pyproject.toml"]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "."]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "10 passed, 1 skipped" in done.stdout


@pytest.mark.parametrize("pace", ["host", "jobs"])
def test_who_else_answers_at_the_port_is_told_with_it(pace: str, tmp_path: Path) -> None:
    """As a server of the web does."""
    CliRunner().invoke(driver, ["new", "gantry", str(tmp_path), "--pace", pace])
    with socket.create_server(("127.0.0.1", 0)) as there:

        def answer() -> None:
            line, _ = there.accept()
            with line:
                line.recv(100)
                line.sendall(b"HTTP/1.1 400 Bad Request\n")
                line.recv(100)

        threading.Thread(target=answer, daemon=True).start()
        url = f"socket://127.0.0.1:{there.getsockname()[1]}"
        code = f"from gantry import Gantry, Settings; Gantry(Settings({url!r}, 10.0)).connect()"
        done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=100)
    assert f"DriverFault: {url}: " in done.stderr, done.stderr


TWO = """
from board import Board, pseudo_terminal
from gantry import Gantry, Settings

port = pseudo_terminal(Board())
first, second = Gantry(Settings(port, 1.0)), Gantry(Settings(port, 1.0))
first.connect()
first.line.write(bytes([10]))
print(first.line.readline())
try:
    second.connect()
except Exception as error:
    print(type(error).__name__, error)
print(first.read().positions.tolist())
"""


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo terminals are those of Linux and macOS")
@pytest.mark.parametrize("pace", ["host", "jobs"])
def test_a_port_is_one_drivers_and_noise_ends_no_board(pace: str, tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    assert CliRunner().invoke(driver, ["new", "gantry", str(folder), "--pace", pace]).exit_code == 0
    done = subprocess.run([sys.executable, "-c", TWO], cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    noise, refused, joints = done.stdout.splitlines()
    assert (noise, joints) == (r"b'ok\n'", "[10.0, -20.0, 30.0]")
    assert refused.startswith("DriverFault /dev/") and "lock" in refused


@pytest.mark.parametrize("pace", ["host", "jobs"])
def test_a_driver_is_under_fifty_lines(pace: str) -> None:
    text = (DRIVERS / pace / "my_robot.py").read_text("utf-8")
    (found,) = (one for one in ast.parse(text).body if isinstance(one, ast.ClassDef) and one.bases)
    lines = text.splitlines()[found.lineno - 1 : found.end_lineno]
    assert sum(bool(line.strip()) for line in lines) < LINES


@pytest.mark.parametrize("name", ["My_Robot", "2nd", "a-b", "", "class", "numpy", "board"])
def test_a_name_that_can_be_no_module_is_refused(name: str, tmp_path: Path) -> None:
    refused = CliRunner().invoke(driver, ["new", name, str(tmp_path / "mine")])
    assert refused.exit_code == 2
    assert "is no name" in refused.output or "already" in refused.output
    assert not (tmp_path / "mine").exists()


def test_nothing_is_written_over(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine", "utf-8")
    refused = CliRunner().invoke(driver, ["new", "gantry", str(tmp_path)])
    assert (refused.exit_code, list(tmp_path.iterdir())) == (2, [tmp_path / "mine.txt"])
    assert "is there already" in refused.output
