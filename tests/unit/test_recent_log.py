"""Log of a project folder: bounded, across kernels, without the token."""

from __future__ import annotations

import logging
from pathlib import Path

from virtualrobot_kernel.recent_log import MOST_BYTES, FolderLog, kept_log

TOKEN = "a-token-of-the-kernel"


def told(path: Path, *lines: str, before: str = "") -> None:
    """Log lines as a kernel does."""
    handler = FolderLog(path, TOKEN, before)
    for line in lines:
        handler.handle(logging.makeLogRecord({"msg": line, "levelname": "WARNING"}))
    handler.close()


def test_it_goes_on_with_the_next_kernel_and_has_no_token(tmp_path: Path) -> None:
    path = tmp_path / "kernel.log"
    assert kept_log(path) == ""
    told(path, f"refused {TOKEN}")
    told(path, "ended", before=f"a plugin saw {TOKEN}\n")
    kept = [line.partition(": ")[2] for line in kept_log(path).splitlines()]
    assert kept == ["a kernel begins", "refused ***", "a kernel begins", "before: a plugin saw ***", "ended"]


def test_the_newest_megabyte_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "kernel.log"
    told(path, *(f"{number} " + 1000 * "x" for number in range(2 * MOST_BYTES // 1000)), "last")
    kept = kept_log(path)
    assert MOST_BYTES // 2 <= len(kept) <= MOST_BYTES and kept.endswith("last\n")


def test_a_folder_that_cannot_be_written_ends_nothing(tmp_path: Path) -> None:
    told(tmp_path / "none" / "kernel.log", "lost")
    assert not list(tmp_path.iterdir())
