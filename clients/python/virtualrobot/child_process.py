"""Commands of `virtualrobot` as child processes of this program, which end with it."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping


def start_child(
    *arguments: str, stderr: int | None = None, environment: Mapping[str, str] | None = None
) -> subprocess.Popen[str]:
    """Start `virtualrobot` with these arguments, one of which must end it when its standard input ends.

    So it ends with this program, even one that is killed. Ctrl-C reaches this program alone, which ends the child when
    it is done. Its output comes by a pipe, and `stderr` is what `subprocess.Popen` takes; `environment` is this
    program's by default.
    """
    return subprocess.Popen(
        [sys.executable, "-m", "virtualrobot", *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=stderr,
        text=True,
        encoding="utf-8",
        env=environment,
        process_group=None if os.name == "nt" else 0,
        creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
    )


def end_child(process: subprocess.Popen[str], timeout: float) -> int:
    """End a child and return its exit code; one that does not end in time (s) is killed."""
    assert process.stdin is not None
    process.stdin.close()
    try:
        return process.wait(timeout)
    except subprocess.TimeoutExpired:
        process.kill()
        return process.wait()
