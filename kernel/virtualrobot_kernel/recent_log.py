"""Newest lines of the log, which a report has."""

from __future__ import annotations

import logging
from collections import deque

MOST_LINES = 2000
"""Number of lines that are kept."""


class RecentLog(logging.Handler):
    """Handler that keeps the newest lines of the log."""

    def __init__(self) -> None:
        """Keep all that the log has."""
        super().__init__()
        self._lines: deque[str] = deque(maxlen=MOST_LINES)
        self.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a record."""
        self._lines.append(self.format(record))

    def __str__(self) -> str:
        """Return the lines, oldest first."""
        return "".join(f"{line}\n" for line in list(self._lines))
