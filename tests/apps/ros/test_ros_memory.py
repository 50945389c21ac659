"""Memory that the bridge's process has freed stays with it for the next picture."""

from __future__ import annotations

import ctypes
import subprocess
import sys

import pytest

MEGABYTE = 1 << 20
PROGRAM = """
import os, sys
from virtualrobot_apps.bridges.ros.memory import keep_memory

def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

if sys.argv[1] == "keep":
    keep_memory()
before = resident()
picture = b"x" * (16 << 20)
del picture
print(resident() - before)
"""


def is_glibc() -> bool:
    return sys.platform == "linux" and hasattr(ctypes.CDLL(None), "gnu_get_libc_version")


@pytest.mark.skipif(not is_glibc(), reason="the C library is not glibc")
@pytest.mark.parametrize("word", ["keep", "give back"])
def test_what_is_freed_stays_with_the_process(word: str) -> None:
    command = [sys.executable, "-c", PROGRAM, word]
    kept = int(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    assert (kept > 15 * MEGABYTE) == (word == "keep")
