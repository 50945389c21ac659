"""Interrupts: traps that signals and times call between two statements. CONNECT gives an interrupt its trap."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.interrupts import EDGE
from virtualrobot_apps.languages.rapid.table import instruction

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask


def _on_signal(task: RapidTask, single: bool | None, signal: str, value: float, number: float) -> None:
    if value not in (0.0, 1.0, EDGE):
        raise RapidFault("ERR_ARGVALERR", f"an interrupt is ordered at 0, 1 or edge (2), not {value:g}")
    task.settle()
    task.interrupts.on_signal(number, task.signals.signal_name(signal), value, bool(single))


@instruction(
    "ISignalDI", r"\switch Single, signaldi Signal, num TriggValue, var intnum Interrupt", lacking="SingleSafe"
)
def _i_signal_di(
    task: RapidTask, single: bool | None, signal: str, value: float, holder: list[float], index: int
) -> None:
    """Orders an interrupt when a digital input becomes 0 or 1, or at each change (edge)."""
    _on_signal(task, single, signal, value, holder[index])


@instruction(
    "ISignalDO", r"\switch Single, signaldo Signal, num TriggValue, var intnum Interrupt", lacking="SingleSafe"
)
def _i_signal_do(
    task: RapidTask, single: bool | None, signal: str, value: float, holder: list[float], index: int
) -> None:
    """Orders an interrupt when a digital output becomes 0 or 1, or at each change (edge)."""
    _on_signal(task, single, signal, value, holder[index])


@instruction("ISignalGI", r"\switch Single, signalgi Signal, var intnum Interrupt", lacking="SingleSafe")
def _i_signal_gi(task: RapidTask, single: bool | None, signal: str, holder: list[float], index: int) -> None:
    """Orders an interrupt at each change of a group of inputs."""
    _on_signal(task, single, signal, EDGE, holder[index])


@instruction("ISignalGO", r"\switch Single, signalgo Signal, var intnum Interrupt", lacking="SingleSafe")
def _i_signal_go(task: RapidTask, single: bool | None, signal: str, holder: list[float], index: int) -> None:
    """Orders an interrupt at each change of a group of outputs."""
    _on_signal(task, single, signal, EDGE, holder[index])


@instruction("ITimer", r"\switch Single, num Time, var intnum Interrupt", lacking="SingleSafe")
def _i_timer(task: RapidTask, single: bool | None, seconds: float, holder: list[float], index: int) -> None:
    """Orders an interrupt each so many seconds of the simulation, or once."""
    task.settle()
    task.interrupts.on_time(holder[index], seconds, bool(single))


@instruction("IPers", r"\switch Single, pers any Name, var intnum Interrupt", lacking="SingleSafe")
def _i_pers(task: RapidTask, single: bool | None, data: list[Any], place: int, holder: list[float], index: int) -> None:
    """Orders an interrupt each time a persistent has another value, which is looked at 50 times a second."""
    task.interrupts.on_change(holder[index], data, place, bool(single))


@instruction("IDelete", "var intnum Interrupt")
def _i_delete(task: RapidTask, holder: list[float], index: int) -> None:
    """Forgets an interrupt, with its trap."""
    task.interrupts.delete(holder[index])


@instruction("ISleep", "var intnum Interrupt")
def _i_sleep(task: RapidTask, holder: list[float], index: int) -> None:
    """Leaves an interrupt out for a while."""
    task.interrupts.sleep(holder[index], True)


@instruction("IWatch", "var intnum Interrupt")
def _i_watch(task: RapidTask, holder: list[float], index: int) -> None:
    """Lets an interrupt that sleeps call its trap again."""
    task.interrupts.sleep(holder[index], False)


@instruction("IDisable")
def _i_disable(task: RapidTask) -> None:
    """Keeps all traps back; interrupts wait."""
    task.interrupts.enable(False)


@instruction("IEnable")
def _i_enable(task: RapidTask) -> None:
    """Calls the traps that were kept back, and all later ones."""
    task.interrupts.enable(True)
