"""Faults of a running program: errors that its handlers may catch, and what ends it."""

from __future__ import annotations

from virtualrobot.errors import WrongStateError

from virtualrobot_apps.languages.rapid.predefined import ERROR_NUMBERS


class RapidFault(Exception):
    """An error that handlers of the program may catch.

    Attributes:
        number: that of ERRNO.
        name: its name, where it has one.
        jumps: whether it is on its way to a handler for its number, and others leave it alone.
    """

    def __init__(self, name: str | float, message: str) -> None:
        """Keep the error by its name or number, and tell it in words."""
        told = name if isinstance(name, str) else f"error {name:g}"
        super().__init__(f"{told}: {message}" if message else told)
        self.name = name if isinstance(name, str) else ""
        self.number = ERROR_NUMBERS[name] if isinstance(name, str) else name
        self.jumps = False


class ProgramEnded(BaseException):
    """The program is over: by EXIT, or since somebody stopped it."""


class CycleEnded(ProgramEnded):
    """The round of main is over, by ExitCycle; the next one begins in a task that makes several."""


class Jump(BaseException):
    """GOTO on its way to its label."""

    def __init__(self, label: str) -> None:
        """Keep the label."""
        super().__init__(label)
        self.label = label


class RapidStopped(WrongStateError):
    """A program that ended by an error that nothing handled; the message has file and line."""


CAUGHT = (RapidFault, ZeroDivisionError, OverflowError)
"""Exceptions that a guard catches: faults, and those of Python's arithmetic."""


def as_fault(error: BaseException) -> RapidFault:
    """Return a fault, or the one that an error of Python's arithmetic is."""
    if isinstance(error, RapidFault):
        return error
    if isinstance(error, ZeroDivisionError):
        return RapidFault("ERR_DIVZERO", "a division by zero")
    return RapidFault("ERR_ARGVALERR", "a number is too large")
