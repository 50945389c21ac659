"""The picking program in each language does and prints the same: built by its own compiler, against a real kernel."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.apps.console.consoles import consoles
from tests.kernels import KernelProcess, emptied

ROOT = Path(__file__).resolve().parent.parent.parent
OCTAVE = shutil.which("octave-cli")
BUILT = ROOT / "build" / "clients"
"""Folder of the builds, which are kept between runs."""

PRINTED = """kernel: virtualrobot.v1
measured: 1.40 m
planned: 0.51 s
moved: SUCCEEDED
picked: the part is at 0.25 m
measured: 0.91 m
touching: part and post
refused: UNKNOWN_NAME, nearest is lbr_iiwa_joint_4
"""
"""Output of the program. By hand: the eye is at 1.5 m above the table, the part is 0.1 m high, its middle at 0.05 m
is lifted by 0.2 m; the other numbers are those of the Python program, which the other languages have to meet."""

pytestmark = pytest.mark.long


def command(language: str) -> list[str]:
    """Return the command of a language's program, after it was built."""
    if language == "python":
        return [sys.executable, str(ROOT / "clients" / "python" / "pick.py")]
    if shutil.which("apt-get") is None:
        pytest.skip("compilers and libraries of the clients in other languages are Debian's packages")
    builder = [sys.executable, str(ROOT / "tools" / "build_client.py"), language, str(BUILT / language)]
    done = subprocess.run(builder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return [*done.stdout.split(), str(ROOT / "clients" / "cell.yaml")]


@pytest.mark.parametrize("language", ["python", "cpp", "go", "java"])
def test_it_prints_the_same_in_each_language(language: str, kernel: KernelProcess) -> None:
    program = command(language)
    with emptied(kernel):
        where = os.environ | {"VIRTUALROBOT_ADDRESS": kernel.address}
        done = subprocess.run(program, env=where, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr, done.stdout) == (0, "", PRINTED)


@pytest.mark.skipif(OCTAVE is None, reason="no Octave: install the package octave to run clients/matlab/pick.m")
def test_octave_prints_the_same(kernel: KernelProcess) -> None:
    program = [str(OCTAVE), "--norc", "--quiet", "--path", str(ROOT / "clients" / "matlab")]
    with emptied(kernel), consoles(kernel.address) as console:
        done = subprocess.run(
            [*program, "--eval", f"pick('{ROOT / 'clients' / 'cell.yaml'}')"],
            env=os.environ | {"VIRTUALROBOT_CONSOLE": console.url},
            capture_output=True,
            text=True,
            timeout=120,
        )
    assert (done.returncode, done.stdout) == (0, PRINTED), done.stderr


@pytest.mark.parametrize("language", ["cpp", "go", "java"])
def test_a_kernel_that_is_not_there_is_one_readable_line(language: str) -> None:
    where = os.environ | {"VIRTUALROBOT_ADDRESS": "127.0.0.1:9"}
    done = subprocess.run(command(language), env=where, capture_output=True, text=True, timeout=120)
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1, done.stderr
