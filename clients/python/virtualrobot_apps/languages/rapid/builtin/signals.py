"""Signals and waiting: outputs, inputs, times and conditions."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.table import function, instruction

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask

POLL_SECONDS = 0.02
"""Time (s of the wall clock) from one look at a condition to the next."""


@instruction("SetDO", "signaldo Signal, num Value", lacking="SDelay Sync")
def _set_do(task: RapidTask, signal: str, value: float) -> None:
    """Sets a digital output to 0 or 1."""
    task.world.set_signal(signal, value)


@instruction("Set", "signaldo Signal")
def _set(task: RapidTask, signal: str) -> None:
    """Sets a digital output to 1."""
    task.world.set_signal(signal, 1.0)


@instruction("Reset", "signaldo Signal")
def _reset(task: RapidTask, signal: str) -> None:
    """Sets a digital output to 0."""
    task.world.set_signal(signal, 0.0)


@instruction("InvertDO", "signaldo Signal")
def _invert_do(task: RapidTask, signal: str) -> None:
    """Sets a digital output to what it is not."""
    task.world.set_signal(signal, 1.0 - task.signal_value(signal))


@instruction("SetGO", "signalgo Signal, num Value", lacking="SDelay Dvalue")
def _set_go(task: RapidTask, signal: str, value: float) -> None:
    """Sets a group of outputs, a signal of whole numbers."""
    task.world.set_signal(signal, value)


@instruction("SetAO", "signalao Signal, num Value")
def _set_ao(task: RapidTask, signal: str, value: float) -> None:
    """Sets an analog output."""
    task.world.set_signal(signal, value)


@function("DOutput", "signaldo Signal", "num")
def _d_output(task: RapidTask, signal: str) -> float:
    """Value of a digital output."""
    return task.signal_value(signal)


@function("GOutput", "signalgo Signal", "num")
def _g_output(task: RapidTask, signal: str) -> float:
    """Value of a group of outputs."""
    return task.signal_value(signal)


@function("AOutput", "signalao Signal", "num")
def _a_output(task: RapidTask, signal: str) -> float:
    """Value of an analog output."""
    return task.signal_value(signal)


@function("GInput", "signalgi Signal", "num")
def _g_input(task: RapidTask, signal: str) -> float:
    """Value of a group of inputs."""
    return task.signal_value(signal)


@function("TestDI", "signaldi Signal", "bool")
def _test_di(task: RapidTask, signal: str) -> bool:
    """TRUE where a digital input is 1."""
    return task.signal_value(signal) == 1.0


@instruction("WaitTime", r"\switch InPos, num Time")
def _wait_time(task: RapidTask, in_position: bool | None, seconds: float) -> None:
    """Waits for some seconds of the simulation, the robot standing."""
    if seconds < 0.0:
        raise RapidFault("ERR_ARGVALERR", f"WaitTime takes 0 s or more, not {seconds:g}")
    task.world.queue.finish()
    if seconds > 0.0:
        task.world.queue.dwell(seconds)
        task.world.queue.finish()


def _wait_signal(
    task: RapidTask, signal: str, value: float, longest: float | None, flag: list[bool] | None, index: int
) -> None:
    try:
        task.world.wait_signal(signal, value, longest)
    except RapidFault as fault:
        if flag is None or fault.name != "ERR_WAIT_MAXTIME":
            raise
        flag[index] = True
    else:
        if flag is not None:
            flag[index] = False


@instruction(
    "WaitDI", r"signaldi Signal, num Value \num MaxTime \inout bool TimeFlag", lacking="ValueAtTimeout Visualize"
)
def _wait_di(
    task: RapidTask, signal: str, value: float, longest: float | None, flag: list[bool] | None, index: int
) -> None:
    """Waits until a digital input is 0 or 1; after MaxTime (s) it is ERR_WAIT_MAXTIME, or TimeFlag becomes TRUE."""
    _wait_signal(task, signal, value, longest, flag, index)


@instruction(
    "WaitDO", r"signaldo Signal, num Value \num MaxTime \inout bool TimeFlag", lacking="ValueAtTimeout Visualize"
)
def _wait_do(
    task: RapidTask, signal: str, value: float, longest: float | None, flag: list[bool] | None, index: int
) -> None:
    """Waits until a digital output is 0 or 1, as WaitDI does."""
    _wait_signal(task, signal, value, longest, flag, index)


@instruction(
    "WaitUntil",
    r"\switch InPos, bool Cond \num MaxTime \inout bool TimeFlag \num PollRate",
    lacking="Visualize",
    lazy="Cond",
)
def _wait_until(
    task: RapidTask,
    in_position: bool | None,
    condition: Callable[[], bool],
    longest: float | None,
    flag: list[bool] | None,
    index: int,
    rate: float | None,
) -> None:
    """Waits until a condition is TRUE, as WaitDI does; it is looked at every 20 ms, whatever PollRate says."""
    if in_position:
        task.world.queue.finish()
    task.settle()
    end = None if longest is None else task.time() + longest
    while not condition():
        if end is not None and task.time() >= end:
            if flag is None:
                raise RapidFault("ERR_WAIT_MAXTIME", f"the condition was not TRUE within {longest:g} s")
            flag[index] = True
            return
        task.pause(POLL_SECONDS)
    if flag is not None:
        flag[index] = False
