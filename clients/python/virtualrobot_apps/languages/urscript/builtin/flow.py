"""Time and messages."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from virtualrobot_apps.languages.urscript.builtin.arithmetic import number
from virtualrobot_apps.languages.urscript.faults import ScriptFault
from virtualrobot_apps.languages.urscript.table import function
from virtualrobot_apps.languages.urscript.values import Value, text, truth

if TYPE_CHECKING:
    from virtualrobot_apps.languages.urscript.task import ScriptTask


@function("sync", waits=True)
def _sync(task: ScriptTask) -> Iterator[None]:
    """Waits for the next cycle."""
    yield


@function("sleep", "t", waits=True)
def _sleep(task: ScriptTask, seconds: Value) -> Iterator[None]:
    """Waits for so many seconds."""
    if number(seconds, "t") < 0.0:
        raise ScriptFault(f"t is 0 or more seconds, not {text(seconds)}")
    for _ in range(round(seconds / task.dt)):
        yield


@function("get_steptime")
def _get_steptime(task: ScriptTask) -> float:
    """Duration of a cycle (s)."""
    return task.dt


@function("textmsg", 's1, s2=""')
def _textmsg(task: ScriptTask, first: Value, second: Value) -> None:
    """Writes one or two values, one after the other, to the log."""
    task.write(text(first) + text(second))


@function("popup", 's, title="Popup", warning=False, error=False, blocking=False', waits=True)
def _popup(
    task: ScriptTask, message: Value, title: Value, warning: Value, error: Value, blocking: Value
) -> Iterator[None]:
    """Writes words to the log; one that blocks waits until the dashboard closes it, and ends the script without one."""
    task.write(f"{text(title)}: {text(message)}")
    if truth(blocking):
        yield from task.shown(text(message))
