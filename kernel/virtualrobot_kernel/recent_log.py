"""Newest lines of the log, which a report has: those of this kernel, and those that kernels of a folder have left."""

from __future__ import annotations

import logging
from collections import deque
from logging.handlers import RotatingFileHandler
from pathlib import Path

MOST_LINES = 2000
"""Number of lines that are kept."""

MOST_BYTES = 1_000_000
"""Size of the log that a folder keeps, about: half of it in the file that is written, half in the one before."""

HIDDEN = "***"

FORM = "%(asctime)s %(levelname)s %(name)s: %(message)s"


class RecentLog(logging.Handler):
    """Handler that keeps the newest lines of the log."""

    def __init__(self) -> None:
        """Keep all that the log has."""
        super().__init__()
        self._lines: deque[str] = deque(maxlen=MOST_LINES)
        self.setFormatter(logging.Formatter(FORM))

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a record."""
        self._lines.append(self.format(record))

    def __str__(self) -> str:
        """Return the lines, oldest first."""
        return "".join(f"{line}\n" for line in list(self._lines))


class FolderLog(RotatingFileHandler):
    """Handler that keeps the log in a file, across kernels, without a secret; a disk that is full ends no kernel."""

    def __init__(self, path: Path, secret: str, before: str = "") -> None:
        """Go on with a file, with a line that says so and with what the log had `before`; see `kept_log`."""
        super().__init__(path, maxBytes=MOST_BYTES // 2, backupCount=1, encoding="utf-8", errors="replace", delay=True)
        self._secret = secret
        self.setFormatter(logging.Formatter(FORM))
        begun = {"name": __name__, "levelname": "INFO", "levelno": logging.INFO, "msg": "a kernel begins"}
        self.handle(logging.makeLogRecord(begun))
        for line in before.splitlines():
            self.handle(logging.makeLogRecord({**begun, "msg": f"before: {line}"}))

    def format(self, record: logging.LogRecord) -> str:
        """Return the text of a record, without the secret."""
        text = super().format(record)
        return text.replace(self._secret, HIDDEN) if self._secret else text

    def handleError(self, record: logging.LogRecord) -> None:
        """Go without the line: the log says on the standard error what there is to say."""


def kept_log(path: Path) -> str:
    """Return what a `FolderLog` has kept, oldest first; empty when there is nothing."""
    files = (path.with_name(f"{path.name}.1"), path)
    return "".join(file.read_text("utf-8", "replace") for file in files if file.is_file())
