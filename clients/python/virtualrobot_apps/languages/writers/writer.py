"""Writer of a program: which of its lines tells which statement. Each language has one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable

from virtualrobot_apps.languages.writers.statements import (
    Comment,
    Condition,
    Dwell,
    If,
    Move,
    Placed,
    RobotProgram,
    SetSignal,
    Statement,
    UseTool,
    WaitSignal,
    While,
)


class Writer(ABC):
    """Lines of a program, statement by statement; raises InvalidArgumentError for what the language can't tell.

    Attributes:
        program: the program.
        signals: where each signal is, by its name.
        tool: the tool that is used where the writer is, by its name.
    """

    def __init__(self, program: RobotProgram, signals: dict[str, str]) -> None:
        """Begin with the first statement."""
        self.program, self.signals, self.tool = program, signals, ""

    def body(self, indent: str = "") -> list[str]:
        """Return the lines of all statements."""
        return [f"{indent}{line}" for line in self._block(self.program.statements)]

    def _block(self, statements: Iterable[Placed]) -> list[str]:
        return [line for at, statement in statements for line in self._lines(at, statement)]

    def _branch(self, statements: Iterable[Placed]) -> list[str]:
        """Return the lines of what may be done or not: nothing is as it was set before, in it and after it."""
        self.forget()
        lines = self._block(statements)
        self.forget()
        return lines

    def _lines(self, at: str, statement: Statement) -> list[str]:
        match statement:
            case If():
                tool = self.tool
                then = self._branch(statement.then)
                self.tool = tool
                return self.decide(at, statement.condition, then, self._branch(statement.otherwise))
            case While():
                return self.repeat(at, statement.condition, self._branch(statement.body))
            case UseTool(tool):
                self.tool = tool
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

    @abstractmethod
    def decide(self, at: str, condition: Condition, then: list[str], otherwise: list[str]) -> list[str]:
        """Return the lines that do one or the other, maybe nothing otherwise, of the step `at`."""

    @abstractmethod
    def repeat(self, at: str, condition: Condition | None, body: list[str]) -> list[str]:
        """Return the lines that do something while a condition holds, None for ever, of the step `at`."""

    @abstractmethod
    def forget(self) -> None:
        """Take nothing for set any more: from here on what is set before may be otherwise."""


def indented(lines: Iterable[str]) -> list[str]:
    """Return lines one level deeper."""
    return [f"  {line}" for line in lines]
