"""Writer of a program: which of its lines tells which statement. Each language has one."""

from __future__ import annotations

from abc import ABC, abstractmethod

from virtualrobot_apps.languages.writers.statements import (
    Comment,
    Dwell,
    Move,
    RobotProgram,
    SetSignal,
    Statement,
    UseTool,
    WaitSignal,
)


class Writer(ABC):
    """Lines of a program, statement by statement; raises InvalidArgumentError for what the language can't tell.

    Attributes:
        program: the program.
        signals: where each signal is, by its name.
    """

    def __init__(self, program: RobotProgram, signals: dict[str, str]) -> None:
        """Begin with the first statement."""
        self.program, self.signals = program, signals

    def body(self, indent: str = "") -> list[str]:
        """Return the lines of all statements."""
        return [f"{indent}{line}" for at, statement in self.program.statements for line in self._lines(at, statement)]

    def _lines(self, at: str, statement: Statement) -> list[str]:
        match statement:
            case UseTool(tool):
                return self.use(tool)
            case Comment(text):
                return [self.comment(text)]
            case Dwell(seconds):
                return [self.dwell(seconds)]
            case SetSignal():
                return [self.set(at, statement)]
            case WaitSignal():
                return self.wait(at, statement)
        return self.move(at, statement)

    @abstractmethod
    def use(self, tool: str) -> list[str]:
        """Return the lines that choose a tool."""

    @abstractmethod
    def comment(self, text: str) -> str:
        """Return the line of a comment."""

    @abstractmethod
    def dwell(self, seconds: float) -> str:
        """Return the line that stands for some seconds."""

    @abstractmethod
    def set(self, at: str, setting: SetSignal) -> str:
        """Return the line that sets a signal, of the step `at`."""

    @abstractmethod
    def wait(self, at: str, wait: WaitSignal) -> list[str]:
        """Return the lines that wait for a signal, of the step `at`."""

    @abstractmethod
    def move(self, at: str, move: Move) -> list[str]:
        """Return the lines of a move, of the step `at`."""
