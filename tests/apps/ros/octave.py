"""Programs for MATLAB and Octave that a test runs in Octave, without a window."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.apps.ros.bridges import GUARD

OCTAVE = shutil.which("octave-cli")
FUNCTIONS = Path(__file__).parents[3] / "clients" / "matlab"
needs_octave = pytest.mark.skipif(OCTAVE is None, reason="no Octave: install the package octave")


def command(program: Path) -> list[str]:
    """Return the command line that runs a program with the functions of the project."""
    assert OCTAVE is not None
    return [OCTAVE, "--norc", "--quiet", "--path", str(FUNCTIONS), str(program)]


def python_first() -> dict[str, str]:
    """Return an environment in which `python3` is the one that runs the test."""
    return {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}


def octave(folder: Path, text: str) -> str:
    """Return what a program prints that runs in a folder; one that fails or warns fails the test with its words."""
    program = folder / "program.m"
    program.write_text("1;\n" + text, "utf-8")  # with functions first it would be no script
    done = subprocess.run(
        command(program), cwd=folder, env=python_first(), capture_output=True, text=True, timeout=GUARD
    )
    assert done.returncode == 0, f"{done.stdout}{done.stderr}"
    assert "warning:" not in done.stderr, done.stderr
    return done.stdout


@contextmanager
def octave_process(folder: Path, text: str) -> Iterator[subprocess.Popen[str]]:
    """Give a program that goes on meanwhile, and is killed at the end of the block."""
    program = folder / "process.m"
    program.write_text("1;\n" + text, "utf-8")
    process = subprocess.Popen(
        command(program), cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()
