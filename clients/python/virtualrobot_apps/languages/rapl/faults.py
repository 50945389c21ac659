"""Faults of a running program in RAPL-II: nothing in the language handles them, so each ends the program."""

from __future__ import annotations

from virtualrobot.errors import WrongStateError


class RaplFault(Exception):
    """A command that could not be done, in words; the task adds where it stands."""


class RaplStopped(WrongStateError):
    """A program that a fault has ended; the message has file, line and the number of the line."""
