"""Tasks: programs of robots' languages at work, as anybody sees and stops them; each is a record of the kind `task`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from virtualrobot._wire.arguments import Text, checked
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import listed, shown, told
from virtualrobot.errors import UnknownNameError, WrongStateError
from virtualrobot.records import Record, Records

KIND = "task"
STOP, ANSWER = "stop", "answer"


@shown
@dataclass(frozen=True, slots=True, eq=False)
class ProgramTask:
    """A program at work, as it was at one instant.

    Attributes:
        id: the name of its record.
        name: that of the task.
        state: `running`, `asking`, `ended`, `stopped`, or `failed` with its error.
        language: that of the program.
        robot: the robot that it moves; empty for one that moves none.
        files: its files.
        program_pointer: file and line of the statement that is done, as `file:line`; empty where none is.
        motion_pointer: file and line of the move that the robot makes, likewise.
        lines: the last lines that it has written on its pendant.
        question: what it asks now; empty where it asks nothing.
        choices: the answers that there are; none: any number or text.
        author: who runs it.
        is_over: it has ended.
        is_held: its client is there, and hears wishes.
    """

    id: str
    name: str
    state: str
    language: str
    robot: str
    files: tuple[str, ...]
    program_pointer: str
    motion_pointer: str
    lines: tuple[str, ...]
    question: str
    choices: tuple[str, ...]
    author: str
    is_over: bool
    is_held: bool

    @staticmethod
    def of(record: Record) -> ProgramTask:
        """Return what a record tells; a content that is another one than a task's tells nothing."""
        content = record.content if isinstance(record.content, Mapping) else {}

        def text(name: str) -> str:
            return str(content.get(name) or "")

        def texts(name: str) -> tuple[str, ...]:
            found = content.get(name)
            return tuple(map(str, found)) if isinstance(found, list) else ()

        return ProgramTask(
            id=record.id,
            name=record.title,
            state=record.state,
            language=text("language"),
            robot=text("robot"),
            files=texts("files"),
            program_pointer=text("program_pointer"),
            motion_pointer=text("motion_pointer"),
            lines=texts("lines"),
            question=text("question"),
            choices=texts("choices"),
            author=record.author,
            is_over=record.is_over,
            is_held=record.is_held,
        )


@checked
class Tasks:
    """The programs at work that clients of one kernel tell of, whoever runs them.

    Example:
        >>> for task in client.tasks.list():
        ...     print(task.name, task.state, task.program_pointer)
        >>> client.tasks.stop("T_ROB1")
    """

    def __init__(self, services: Services) -> None:
        """Handle the tasks of one kernel."""
        self._records = Records(services)

    def list(self) -> list[ProgramTask]:
        """Return those that are at work, and the last ones that have ended, oldest first."""
        return [ProgramTask.of(one) for one in self._records.list(KIND)]

    def get(self, task: str) -> ProgramTask:
        """Return a task by its record's name, or by its own: of several that of the one at work.

        Raises:
            UnknownNameError: when there is none.
            WrongStateError: when several of this name are at work.
        """
        found = [one for one in self.list() if task in (one.id, one.name)]
        at_work = [one for one in found if not one.is_over]
        if len(at_work) > 1:
            named = ", ".join(one.id for one in at_work)
            raise WrongStateError(f"{len(at_work)} tasks are called {task!r}; name one by its record: {named}")
        if not found:
            there = ", ".join(f"{one.name} ({one.id})" for one in self.list()) or "none"
            raise UnknownNameError(f"there is no task named {task!r}; there are: {there}")
        return (at_work or found)[-1]

    def stop(self, task: str) -> None:
        """Have a program stop before its next statement, and its robot brake on its path; errors as of `get`.

        Raises:
            WrongStateError: when it has ended, or its client is gone.
        """
        self._records.wish(self._at_work(task), STOP)

    def answer(self, task: str, text: Text) -> None:
        """Answer what a program asks on its pendant; errors as of `stop`.

        Raises:
            InvalidArgumentError: when it asks nothing.
        """
        self._records.wish(self._at_work(task), ANSWER, text)

    def _at_work(self, task: str) -> str:
        """Return the record's name of a task that has not ended."""
        found = self.get(task)
        if found.is_over:
            raise WrongStateError(f"no task {found.name} runs: {found.id} is over ({found.state})")
        return found.id

    def watch(self) -> Iterator[list[ProgramTask]]:
        """Yield those tasks that are new or have changed, all at first, until the iterator is closed."""
        with self._records.watch(KIND) as changes:
            for change in changes:
                yield [ProgramTask.of(one) for one in change.records]

    def __repr__(self) -> str:
        """Return names and states."""
        return told("Tasks", lambda: listed((f"{one.name} {one.state}" for one in self.list()), "none at work"))
