"""Programs at work that everybody sees, stops and answers: each is told as a record of the kernel."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Protocol

from virtualrobot.connection import Client
from virtualrobot.errors import VirtualRobotError
from virtualrobot.records import Record, RecordHold
from virtualrobot.tasks import ANSWER, KIND, STOP

from virtualrobot_apps.languages.core.pendant import Pendant
from virtualrobot_apps.languages.core.task import TaskStopped

PERIOD_SECONDS = 0.2
"""Shortest time (s of the wall clock) from one word about a program to the next."""
LONGEST = 200
"""Greatest number of characters of a line, a question or a state that are told."""
MOST_FILES = 50
"""Number of a program's files, and of answers to a question, that are told."""
LAST_WORD_SECONDS = 2.0
"""Time (s of the wall clock) for which the end of a program waits until that is told."""


class Program(Protocol):
    """Program at work, as much of it as is told: a `Task`, for one."""

    def program_pointer(self) -> str:
        """Return file and line of the statement that is done, as `file:line`; empty where none is."""
        ...

    def motion_pointer(self) -> str:
        """Return file and line of the move that the robot makes, likewise."""
        ...

    def stop(self, why: str = "stopped") -> None:
        """End the program before its next statement; any thread may call it."""
        ...


@dataclass(frozen=True, slots=True)
class Label:
    """Name, language and files of a program, and the robot that it moves, if any: all that stays as it is."""

    name: str
    language: str
    files: Sequence[str]
    robot: str = ""


class Published:
    """Program at work whose record tells, at a bounded rate, how it is, until `close`.

    Threads of its own do so: the program never waits for the kernel here. Where the kernel refuses, as it does with an
    observer's token, nothing is told, and the program runs all the same.
    """

    def __init__(self, client: Client, program: Program, pendant: Pendant, label: Label) -> None:
        """Begin to tell, and to hear what others wish."""
        self._client, self._program, self._pendant, self._label = client, program, pendant, label
        self._over, self._end = threading.Event(), "ended"
        self._teller = threading.Thread(target=self._tell, name=f"{label.name} told", daemon=True)
        self._teller.start()

    def close(self, error: BaseException | None = None) -> None:
        """Tell how it has ended."""
        if isinstance(error, TaskStopped | KeyboardInterrupt):
            self._end = str(error) or "stopped"
        elif error is not None:
            self._end = f"failed: {error}"
        self._over.set()

    def join(self) -> None:
        """Wait until the end is told, or the kernel doesn't listen."""
        self._teller.join(LAST_WORD_SECONDS)

    def _tell(self) -> None:
        with suppress(VirtualRobotError):
            state, content, wishes = before = self._now()
            records, title = self._client.records, _line(self._label.name)
            record = records.create(KIND, content, title=title, state=state, wishes=wishes, keep=False)
            hold = records.hold(record)
            try:
                hearing = threading.Thread(target=self._hear, args=(hold,), name=f"{title} heard", daemon=True)
                hearing.start()
                while not self._over.wait(PERIOD_SECONDS):
                    state, content, wishes = now = self._now()
                    if now != before:
                        records.update(record.id, content, state=state, wishes=wishes)
                        before = now
                self._tell_end(record)
            finally:
                hold.close()

    def _tell_end(self, record: Record) -> None:
        content = {**self._now()[1], "program_pointer": "", "motion_pointer": "", "question": "", "choices": []}
        self._client.records.update(record.id, content, state=_line(self._end), wishes=(), keep=True, is_over=True)

    def _now(self) -> tuple[str, dict[str, object], list[str]]:
        """Return state, content and wishes."""
        question = self._pendant.question
        content: dict[str, object] = {
            "language": self._label.language,
            "robot": self._label.robot,
            "files": [_line(one) for one in self._label.files[:MOST_FILES]],
            "program_pointer": self._program.program_pointer(),
            "motion_pointer": self._program.motion_pointer(),
            "lines": [_line(one) for one in (*self._pendant.lines,)],
            "question": "" if question is None else _line(question.text),
            "choices": [] if question is None else [_line(one) for one in question.choices[:MOST_FILES]],
        }
        return ("running", content, [STOP]) if question is None else ("asking", content, [STOP, ANSWER])

    def _hear(self, hold: RecordHold) -> None:
        """Do what others wish, until the record is let go or the kernel is gone."""
        with suppress(VirtualRobotError):
            for wish in hold:
                if wish.word == STOP:
                    self._program.stop(f"stopped by {wish.author}")
                elif wish.word == ANSWER:
                    self._pendant.answer(wish.text)


@contextmanager
def published(programs: Iterable[tuple[Client, Program, Pendant, Label]]) -> Iterator[None]:
    """Tell of programs for the length of a block; how it ends they end."""
    told = [Published(*one) for one in programs]
    failed: BaseException | None = None
    try:
        yield
    except BaseException as error:
        failed = error
        raise
    finally:
        for one in told:
            one.close(failed)
        for one in told:
            one.join()


def _line(text: str) -> str:
    """Return text as a line that can be told: what can't be printed is a space."""
    return "".join(one if one.isprintable() else " " for one in text)[:LONGEST]
