"""Scripts in URScript for tests: what is wrong in them, and what they write."""

from __future__ import annotations

import textwrap

import pytest
from virtualrobot_apps.languages.core.diagnostics import ProgramError
from virtualrobot_apps.languages.urscript.faults import ScriptFault
from virtualrobot_apps.languages.urscript.task import Loaded, ScriptTask, load


def loaded(text: str) -> Loaded:
    """Return the script of a text."""
    return load(textwrap.dedent(text).strip() + "\n", "test.script")


def written(text: str, cycles: int = 10_000) -> list[str]:
    """Return the messages of a script, which is over after so many cycles."""
    lines: list[str] = []
    task = ScriptTask(loaded(text), write=lines.append)
    for _ in range(cycles):
        if not task.cycle():
            return lines
    raise AssertionError(f"the script goes on after {cycles} cycles")


def said(statements: str) -> list[str]:
    """Return the messages of statements of a program."""
    return written(f"def tried():\n{textwrap.dedent(statements)}\nend")


def faults(text: str) -> list[str]:
    """Return the faults of a script as `line:column: message`."""
    with pytest.raises(ProgramError) as caught:
        loaded(text)
    return [str(one).removeprefix("test.script:") for one in caught.value.diagnostics]


def fault_of(statements: str) -> str:
    """Return the one fault of statements of a program, which begin in line 2, without its place."""
    (found,) = faults(f"def tried():\n{statements}\nend")
    return found.partition(": ")[2]


def stopped(text: str) -> str:
    """Return the fault by which a script ends while it runs."""
    with pytest.raises(ScriptFault) as caught:
        written(text)
    return str(caught.value)
