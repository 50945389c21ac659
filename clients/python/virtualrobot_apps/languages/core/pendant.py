"""Pendant of programs: lines that they write, and answers to what they ask, from a list or from a terminal."""

from __future__ import annotations

import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from virtualrobot_apps.languages.core.task import Task

LOOK_SECONDS = 0.05
"""Time (s of the wall clock) from one look for an answer to the next."""
LINES = 20
"""Number of the last lines that are kept."""


@dataclass(frozen=True, slots=True)
class Question:
    """Question of a program: its words, and the answers that there are; none of these: any number or text."""

    text: str
    choices: tuple[str, ...] = ()


class NobodyAnswers(Exception):
    """There is no answer, and none will come."""


class Pendant:
    """Lines that a program writes, and answers in the order in which it asks.

    Answers are taken from an iterable, by a thread of their own: reading a terminal can't be given up otherwise.
    Anybody else may `answer`, too: what comes first counts.

    Attributes:
        lines: the last lines that were written.
        question: what the program waits for an answer to; None: it waits for none.
        asking: is told each question as the program begins to wait for its answer, and None as it waits no more.
    """

    def __init__(self, write: Callable[[str], object] = print, answers: Iterable[str] = ()) -> None:
        """Write by a function; `answers` are read when the program asks first."""
        self._write = write
        self.lines: deque[str] = deque(maxlen=LINES)
        self.question: Question | None = None
        self.asking: Callable[[Question | None], None] = lambda question: None
        self._source: Iterator[str] = iter(answers)
        self._come: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._wanted = threading.Semaphore(0)
        self._reader: threading.Thread | None = None
        self._reading = False

    def write(self, line: str) -> None:
        """Write a line."""
        self.lines.append(line)
        self._write(line)

    def answer(self, text: str) -> None:
        """Answer what is asked, or, if nothing is, what will be next; any thread may call it."""
        self._come.put(text)

    def ask(self, task: Task, question: Question, seconds: float | None = None) -> str | None:
        """Return the next answer, without its line end; None where none came within `seconds` of the wall clock.

        Raises NobodyAnswers at the end of the answers.
        """
        if self._reader is None:
            self._reader = threading.Thread(target=self._read, name="pendant", daemon=True)
            self._reader.start()
        if not self._reading and self._come.empty():  # an answer that comes too late is that of the next question
            self._reading = True
            self._wanted.release()
        self.question = question
        self.asking(question)
        try:
            return self._answer(task, seconds)
        finally:
            self.question = None
            self.asking(None)

    def _answer(self, task: Task, seconds: float | None) -> str | None:
        end = None if seconds is None else time.monotonic() + seconds
        while self._come.empty():
            left = LOOK_SECONDS if end is None else min(LOOK_SECONDS, end - time.monotonic())
            if left <= 0.0:
                return None
            task.pause(left)
        answer = self._come.get()
        if answer is None:
            raise NobodyAnswers
        return answer

    def _read(self) -> None:
        while True:
            self._wanted.acquire()
            answer = next(self._source, None)
            self._reading = False
            self._come.put(None if answer is None else answer.rstrip("\r\n"))
