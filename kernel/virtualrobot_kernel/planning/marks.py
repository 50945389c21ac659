"""Marks of a run: the nominal times at which signals are set on its way, also when it is extended."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

from virtualrobot_kernel.motion.signals import SignalValue
from virtualrobot_kernel.planning.blending import PlannedRun
from virtualrobot_kernel.planning.program import SetSignalStep, Step

Marks: TypeAlias = tuple[tuple[float, str, SignalValue], ...]
Leads: TypeAlias = tuple[tuple[float, int, float], ...]


def settings(steps: Sequence[Step]) -> list[SetSignalStep]:
    """Return those of the steps that set a signal."""
    return [step for step in steps if isinstance(step, SetSignalStep)]


def marked(run: PlannedRun, values: Mapping[int, Sequence[SetSignalStep]]) -> tuple[Marks, Leads]:
    """Return the marks of signals that are set where steps of a run begin, by their numbers, and their leads."""
    marks, leads = list[tuple[float, str, SignalValue]](), list[tuple[float, int, float]]()
    for begin, number in run.steps:
        for one in values.get(number, ()):
            time = ahead(begin, one.lead)
            marks.append((time, one.signal, one.value))
            if one.lead:
                leads.append((time, number, one.lead))
    return tuple(marks), tuple(leads)


def ahead(time: float, lead: float) -> float:
    """Return the nominal time (s) of a run that is so much before another one, but not before its begin."""
    return max(0.0, time - lead)


def moved(marks: Marks, before: PlannedRun, after: PlannedRun, cut: float) -> tuple[Marks, Leads]:
    """Return the marks of a run that was extended, and their leads.

    before, after: the run, and the extended one, which are the same up to the cut (s): so are their marks, and those
    that a lead brings there stay behind the cut.
    """
    times, numbers = {number: time for time, number in after.steps}, {time: number for time, number in before.steps}
    early = {time: (number, lead) for time, number, lead in before.leads}
    found, leads = list[tuple[float, str, SignalValue]](), list[tuple[float, int, float]]()
    for time, signal, value in marks:
        if time > cut and time in early:
            number, lead = early[time]
            time = max(cut, times[number] - lead)
            leads.append((time, number, lead))
        elif time > cut:
            time = times[numbers[time]]
        found.append((time, signal, value))
    return tuple(found), tuple(leads)
