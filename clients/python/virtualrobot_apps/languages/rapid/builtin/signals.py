"""Signals and waiting: outputs, inputs, times and conditions."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.table import function, instruction

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask

POLL_SECONDS = 0.02
"""Time (s of the wall clock) from one look at a condition to the next."""


@instruction("SetDO", r"\num SDelay | switch Sync, signaldo Signal, num Value")
def _set_do(task: RapidTask, delay: float | None, waits: bool | None, signal: str, value: float) -> None:
    """Sets a digital output to 0 or 1, SDelay seconds later while the program goes on; Sync: waits for it."""
    if delay:
        task.signals.signal_later([(delay, signal, value)])
    else:
        task.signals.set_signal(signal, value)
    if waits:
        task.settle()


@instruction("PulseDO", r"\switch High \num PLength, signaldo Signal")
def _pulse_do(task: RapidTask, high: bool | None, length: float | None, signal: str) -> None:
    """Inverts a digital output for 0.2 s or PLength while the program goes on; High: it becomes 1, and 0 then."""
    seconds = 0.2 if length is None else length
    if not 0.001 <= seconds <= 2000.0:
        raise RapidFault("ERR_ARGVALERR", f"a pulse has 0.001 to 2000 s, not {seconds:g}")
    before = 0.0 if high else task.signal_value(signal)
    task.signals.signal_later([(0.0, signal, 1.0 - before), (seconds, signal, before)])


@instruction("Set", "signaldo Signal")
def _set(task: RapidTask, signal: str) -> None:
    """Sets a digital output to 1."""
    task.signals.set_signal(signal, 1.0)


@instruction("Reset", "signaldo Signal")
def _reset(task: RapidTask, signal: str) -> None:
    """Sets a digital output to 0."""
    task.signals.set_signal(signal, 0.0)


@instruction("InvertDO", "signaldo Signal")
def _invert_do(task: RapidTask, signal: str) -> None:
    """Sets a digital output to what it is not."""
    task.signals.set_signal(signal, 1.0 - task.signal_value(signal))


@instruction("SetGO", r"\num SDelay, signalgo Signal, num Value", lacking="Dvalue")
def _set_go(task: RapidTask, delay: float | None, signal: str, value: float) -> None:
    """Sets a group of outputs, a signal of whole numbers, SDelay seconds later while the program goes on."""
    if delay:
        task.signals.signal_later([(delay, signal, value)])
    else:
        task.signals.set_signal(signal, value)


@instruction("SetAO", "signalao Signal, num Value")
def _set_ao(task: RapidTask, signal: str, value: float) -> None:
    """Sets an analog output."""
    task.signals.set_signal(signal, value)


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


@function("DInput", "signaldi Signal", "num")
def _d_input(task: RapidTask, signal: str) -> float:
    """Value of a digital input."""
    return task.signal_value(signal)


@function("AInput", "signalai Signal", "num")
def _a_input(task: RapidTask, signal: str) -> float:
    """Value of an analog input."""
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
    queue = task.signals.queue
    if queue.free and not in_position:
        end = task.time() + seconds
        while task.time() < end:
            task.pause(POLL_SECONDS)
        return
    queue.finish()
    if seconds > 0.0:
        queue.dwell(seconds)
        queue.finish()


@instruction("WaitRob", r"\switch InPos | switch ZeroSpeed")
def _wait_rob(task: RapidTask, in_position: bool | None, at_rest: bool | None) -> None:
    """Waits until the robot stands."""
    task.signals.queue.finish()


def _wait_signal(
    task: RapidTask,
    signal: str,
    value: float,
    longest: float | None,
    flag: list[bool] | None,
    index: int,
    comparison: str = "==",
) -> None:
    try:
        task.signals.wait_signal(signal, value, longest, comparison)
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


def _wait_compared(
    task: RapidTask,
    signal: str,
    comparisons: dict[str, bool | None],
    value: float,
    longest: float | None,
    flag: list[bool] | None,
    index: int,
    reached: list[float] | None,
    at: int,
) -> None:
    """Wait until a signal compares so with a value; after MaxTime tell what it is."""
    comparison = next((one for one, wanted in comparisons.items() if wanted), "==")
    try:
        _wait_signal(task, signal, value, longest, flag, index, comparison)
    finally:
        if reached is not None and (flag is None or flag[index]):
            reached[at] = task.signal_value(signal)


_ENDS = r"num Value \num MaxTime \inout bool TimeFlag \inout num ValueAtTimeout"


@instruction("WaitAI", rf"signalai Signal \switch LT | switch GT, {_ENDS}", lacking="Visualize")
def _wait_ai(task: RapidTask, signal: str, lower: bool | None, greater: bool | None, *ends: Any) -> None:  # noqa: ANN401
    """Waits until an analog input is above (GT) or below (LT) a value, or it; otherwise as WaitDI does."""
    _wait_compared(task, signal, {"<": lower, ">": greater}, *ends)


@instruction("WaitAO", rf"signalao Signal \switch LT | switch GT, {_ENDS}", lacking="Visualize")
def _wait_ao(task: RapidTask, signal: str, lower: bool | None, greater: bool | None, *ends: Any) -> None:  # noqa: ANN401
    """Waits for an analog output as WaitAI does."""
    _wait_compared(task, signal, {"<": lower, ">": greater}, *ends)


@instruction("WaitGI", rf"signalgi Signal \switch NOTEQ | switch LT | switch GT, {_ENDS}", lacking="Dvalue Visualize")
def _wait_gi(
    task: RapidTask,
    signal: str,
    other: bool | None,
    lower: bool | None,
    greater: bool | None,
    *ends: Any,  # noqa: ANN401
) -> None:
    """Waits until a group of inputs is a value, or another one, below or above it; otherwise as WaitDI does."""
    _wait_compared(task, signal, {"!=": other, "<": lower, ">": greater}, *ends)


@instruction("WaitGO", rf"signalgo Signal \switch NOTEQ | switch LT | switch GT, {_ENDS}", lacking="Dvalue Visualize")
def _wait_go(
    task: RapidTask,
    signal: str,
    other: bool | None,
    lower: bool | None,
    greater: bool | None,
    *ends: Any,  # noqa: ANN401
) -> None:
    """Waits for a group of outputs as WaitGI does."""
    _wait_compared(task, signal, {"!=": other, "<": lower, ">": greater}, *ends)


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
        task.signals.queue.finish()
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
