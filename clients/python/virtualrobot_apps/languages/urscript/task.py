"""A script at work: its threads, each with a turn in every cycle of the controller that runs it.

Whoever has a thread's turn keeps it until it waits (`sync`, `sleep`, a motion), as on a controller, where a turn lasts
a cycle (Universal Robots, "The URScript Programming Language", thread scheduling). One that computes for many turns
without a wait ends the script: a controller would have stopped.
"""

from __future__ import annotations

import re
import traceback
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from types import CodeType, GeneratorType
from typing import Any

from virtualrobot_apps.languages.core.diagnostics import Diagnostics, ProgramError
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.urscript import values
from virtualrobot_apps.languages.urscript.check import Checked, check
from virtualrobot_apps.languages.urscript.faults import ScriptFault, ScriptHalted
from virtualrobot_apps.languages.urscript.generate import MAIN, generate
from virtualrobot_apps.languages.urscript.parser import parse
from virtualrobot_apps.languages.urscript.table import BUILTINS

TURN = 2000
"""Rounds of loops and calls of functions in one turn."""
TURNS = 500
"""Turns in a row that a thread may compute without a wait: a second of a controller."""
THREADS = 100
"""Threads that may run at the same time."""


@dataclass(frozen=True, slots=True)
class Loaded:
    """A script without a fault.

    Attributes:
        name: that of the program; `line` where there are lines alone.
        secondary: it runs beside the program that runs already, and takes no time.
        code: defines its functions.
        source: its text.
        checked: what its names mean.
    """

    name: str
    secondary: bool
    code: CodeType
    source: Source
    checked: Checked


def load(text: str, file: str = "script") -> Loaded:
    """Return the script of a text; raises ProgramError with all faults that it has."""
    return load_source(Source(text, file))


def load_source(source: Source, debugged: bool = False) -> Loaded:
    """Return the script of a source, `debugged` for a debugger; raises ProgramError with all faults that it has."""
    diagnostics = Diagnostics()
    script = parse(source, diagnostics)
    checked = check(script, diagnostics)
    if len(diagnostics):
        raise ProgramError(diagnostics.sorted())
    return Loaded(script.main.name, script.main.kind == "sec", generate(checked, debugged), source, checked)


class Thread:
    """A thread, which is its own handle."""

    def __init__(self, name: str, work: Generator[bool | None, None, Any]) -> None:
        """Begin before its first statement."""
        self.name, self.work = name, work
        self.over = False
        self.turns = 0

    def end(self) -> None:
        """End it where it is."""
        self.over = True


class Own(dict[str, Any]):
    """Own variables of a function that is debugged, by their names in Python."""

    def __missing__(self, name: str) -> None:
        """Raise what reading a variable of Python does."""
        raise NameError(f"name {name!r} has no value")


class ScriptTask:
    """A script at work, of which somebody calls `cycle` once a cycle.

    Attributes:
        left: rounds and calls that the turn has left.
        dt: duration of a cycle (s).
        write: is told the script's messages.
        thread: the thread whose turn it is.
        names: those of the code; of a global variable it is `g_` and its own.
    """

    def __init__(self, loaded: Loaded, dt: float = 0.002, write: Callable[[str], object] = print) -> None:
        """Begin before the first statement."""
        self.loaded, self.dt, self.write = loaded, dt, write
        self.left = TURN
        self.names: dict[str, Any] = {
            "task": self,
            "Own": Own,
            **{name: getattr(values, name) for name in _VALUES},
            **{f"b_{name}": one.run for name, one in BUILTINS.items()},
        }
        exec(loaded.code, self.names)
        self.thread = Thread(loaded.name, self.names[MAIN]())
        self.main = self.thread
        self._threads = [self.thread]

    def cycle(self) -> bool:
        """Give each thread its turn; return whether the script goes on.

        Raises:
            ScriptFault: the script can't go on; the message has file and line.
        """
        if self.main.over:
            return False
        number = 0
        while number < len(self._threads):  # threads that are started meanwhile have a turn, too
            thread = self._threads[number]
            number += 1
            if thread.over:
                continue
            self.thread, self.left = thread, TURN
            try:
                self._turn(thread)
            except ScriptHalted:
                self.main.end()
            if self.main.over:
                return False
        self._threads = [one for one in self._threads if not one.over]
        return True

    def _turn(self, thread: Thread) -> None:
        try:
            heavy = next(thread.work)
        except StopIteration:
            thread.end()
            return
        except (ScriptFault, ArithmeticError, ValueError, NameError, RecursionError) as error:
            raise ScriptFault(f"{self._place(error)}: {told(error)}") from error
        thread.turns = thread.turns + 1 if heavy else 0
        if thread.turns > TURNS:
            said = "computes without a wait: put sync() or sleep() into its loop"
            frame = getattr(thread.work, "gi_frame", None)
            line = frame.f_lineno if frame is not None else 1
            raise ScriptFault(f"{self.loaded.source.file}:{line}: {thread.name!r} {said}")

    def pointer(self) -> str:
        """Return file and line of the statement at which its main thread is, as any thread asks for it."""
        work: object = self.main.work
        found = ""
        while isinstance(work, GeneratorType):
            if work.gi_code.co_filename == self.loaded.source.file and work.gi_frame is not None:
                found = f"{self.loaded.source.file}:{work.gi_frame.f_lineno}"
            work = work.gi_yieldfrom
        return found

    def _place(self, error: BaseException) -> str:
        file = self.loaded.source.file
        lines = [one.lineno for one in traceback.extract_tb(error.__traceback__) if one.filename == file]
        return f"{file}:{lines[-1] if lines else 1}"

    # What generated code calls.

    def start(self, name: str, work: Generator[bool | None, None, Any]) -> Thread:
        """Start a thread."""
        if sum(not one.over for one in self._threads) >= THREADS:
            raise ScriptFault(f"there can't be more than {THREADS} threads at the same time")
        thread = Thread(name, work)
        self._threads.append(thread)
        return thread

    def join(self, handle: object) -> Iterator[None]:
        """Wait until a thread is over; what is no thread is over already."""
        while isinstance(handle, Thread) and not handle.over:
            yield

    def kill(self, handle: object) -> Iterator[None]:
        """End a thread; what is no thread is over already."""
        if isinstance(handle, Thread) and not handle.over:
            handle.end()
            self.killed(handle)
        while self.thread.over:
            yield

    def killed(self, thread: Thread) -> None:
        """Be told that a thread was killed, which may have moved the robot."""

    def shown(self, words: str) -> Iterator[None]:
        """Wait until somebody has closed a popup."""
        raise ScriptFault(f"nobody can close a popup that blocks here: {words}")

    def lacks(self, name: str) -> None:
        """Refuse a function of the language that doesn't work here; a script may have it, and not call it."""
        raise ScriptFault(f"{name!r} can't be used here yet; see the table of what works")

    def halt(self) -> None:
        """End the script."""
        raise ScriptHalted


_VALUES = """add subtract multiply divide remainder negative truth order element put component put_component copied
pose Struct""".split()


def told(error: BaseException) -> str:
    """Return what an exception says, in words of the language."""
    if isinstance(error, ScriptFault):
        return str(error)
    if isinstance(error, NameError):
        found = re.search(r"[gv]_(\w+)", str(error))
        return f"{found[1] if found else 'a variable'!r} has no value yet"
    if isinstance(error, RecursionError):
        return "functions call each other too deeply"
    return f"this can't be computed: {error}"
