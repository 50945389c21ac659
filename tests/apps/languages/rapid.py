"""Programs in RAPID for tests: what is wrong in them, and what they print."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

import pytest
from virtualrobot_apps.languages.core.diagnostics import ProgramError
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapid.debugger import DebuggedTask
from virtualrobot_apps.languages.rapid.task import Loaded, RapidTask, load, load_tasks


def loaded(text: str, signals: Iterable[str] = ()) -> Loaded:
    """Return the program of a text, in a world with signals."""
    return load([source(text)], signals)


def source(text: str) -> Source:
    """Return a text as a source."""
    return Source(textwrap.dedent(text).strip() + "\n", "test.mod")


def printed(text: str, *, once: bool = False) -> list[str]:
    """Return the lines that a program writes on the pendant, which are the same where a debugger looks at it.

    `once`: it can be run once alone.
    """
    lines: list[str] = []
    RapidTask(loaded(text), write=lines.append).run()
    if once:
        return lines
    debugged: list[str] = []
    DebuggedTask(load_tasks({"": [source(text)]}, debugged=True)[""], write=debugged.append).run()
    assert debugged == lines
    return lines


def main_prints(statements: str, more: str = "", *, once: bool = False) -> list[str]:
    """Return the lines that statements of the procedure main write, beside other declarations."""
    return printed(f"MODULE Tried\n{more}\nPROC main()\n{statements}\nENDPROC\nENDMODULE", once=once)


def faults(text: str) -> list[str]:
    """Return the faults of a program as `line:column: message`."""
    with pytest.raises(ProgramError) as caught:
        loaded(text)
    return [str(one).removeprefix("test.mod:") for one in caught.value.diagnostics]


def fault_of(statements: str, more: str = "") -> str:
    """Return the one fault of statements of the procedure main, which begin in line 1."""
    (found,) = faults(f"MODULE Tried {more} PROC main() {statements}\nENDPROC\nENDMODULE")
    return found.partition(": ")[2]


def numbers(text: str) -> list[float]:
    """Return the numbers of a value as text."""
    return [float(one) for one in text.replace("[", "").replace("]", "").split(",")]
