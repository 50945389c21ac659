"""Prediction of a running program, if nobody does anything about it. Pure.

It is told by laws that are known, not by ticks made in advance: the program's stages, how the rate changes that the
motion goes on at, and the brakes of one that stops.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass

from virtualrobot_kernel.motion.plan_execution import PlanExecution
from virtualrobot_kernel.motion.program import Program, Stage
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.motion.running_motion import ENDED, Phase
from virtualrobot_kernel.motion.signals import SignalValue

_TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Prediction:
    """Predicted rest of a program.

    program: the stage that it is in, whole, and the next ones as far as they are looked at. begin, end: from when (s
    from now) on `knots` tell the time, and until when it is told. knots: times (s from now) and the nominal times of
    `program` by then, evenly between them. running: the motion that goes on before, by its ramp or its brakes; None
    where there is none. goes_on: whether more comes after `end`; else it stands then.
    """

    program: Program
    begin: float
    end: float
    knots: tuple[tuple[float, ...], tuple[float, ...]]
    running: PlanExecution | None
    goes_on: bool

    @property
    def brakes(self) -> bool:
        """True while it brakes by laws of its own: then no nominal time tells where it is."""
        return self.running is not None and bool(self.running.brakes)

    def nominal(self, time: float) -> float:
        """Return the nominal time of `program` (s) at a time (s from now)."""
        if self.running is not None and time < self.begin:
            running = self.running
            return min(running.ramp_tau + running.ramp.state(running.elapsed + max(time, 0.0))[3], running.duration)
        times, nominal = self.knots
        place = bisect_right(times, time) - 1
        if place < 0:
            return nominal[0]
        if place >= len(times) - 1:
            return nominal[-1]
        share = (time - times[place]) / (times[place + 1] - times[place])
        return nominal[place] + share * (nominal[place + 1] - nominal[place])

    def when(self, nominal: float) -> float:
        """Return when (s from now) a nominal time of `program` is reached; inf for never, 0 where it was before."""
        nominal -= _TOLERANCE
        if self.brakes or self.nominal(self.end) < nominal:
            return math.inf
        low, high = 0.0, self.end
        for _ in range(50):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.nominal(middle) < nominal else (low, middle)
        return high


def predict(run: ProgramRun, override: float, signals: Mapping[str, SignalValue], seconds: float) -> Prediction | None:
    """Return the prediction of a program for the next `seconds` at the least; None where it stands.

    It goes on as it does now, from the end of its present stage on with the speed `override`. Pauses of given length
    take theirs. Where it must wait for a signal that has not its value yet, what comes after is not told: nobody knows
    when that is.
    """
    if run.phase in (*ENDED, Phase.PAUSED) or run.at == len(run.program.stages):
        return None
    stages, at, moving = run.program.stages, run.at, run.running
    slows = run.phase in (Phase.PAUSING, Phase.STOPPING)
    if moving is not None and (moving.ended or moving.phase is Phase.PAUSED):
        moving = None
    if slows and moving is None:
        return None
    if moving is not None and moving.brakes:
        end = max(brake.end for brake in moving.brakes) - moving.elapsed
        return Prediction(_rest(run, at + 1), max(end, 0.0), max(end, 0.0), ((0.0,), (0.0,)), moving, False)
    time, nominal, first = 0.0, 0.0, at
    if moving is not None:
        ramp = moving.ramp
        time = max(0.0, ramp.time_when(moving.duration - moving.ramp_tau) - moving.elapsed)
        nominal, first = moving.duration, at + 1
        if not math.isfinite(time):  # it stands before: a pause, or a stop by its rate
            time = max(0.0, ramp.length - moving.elapsed)
            nominal, slows = moving.ramp_tau + ramp.state(ramp.length)[3], True
    times, nominals, last = [time], [nominal], first
    waits = slows
    while not waits and last < len(stages) and times[-1] < seconds:
        stage = stages[last]
        if stage.pauses and last != at:
            waits = True
            break
        gone = run.waited if last == at else 0.0
        lasts = _lasts(stage, gone, override, signals)
        if lasts is None:
            waits = True
            break
        if last == at:
            nominals[0] = min(gone, stage.duration)
        last += 1
        if lasts > 0.0:
            end = run.program.begins[last] - run.program.begins[at]
            times.append(times[-1] + lasts)
            nominals.append(end)
    if times[-1] <= 0.0:
        return None
    goes_on = not waits and last < len(stages)
    return Prediction(_rest(run, max(last, at + 1)), time, times[-1], (tuple(times), tuple(nominals)), moving, goes_on)


def _rest(run: ProgramRun, last: int) -> Program:
    """Return the stages from the present one up to one that is not taken any more."""
    return Program(run.program.stages[run.at : last], run.held, run.program.step_count)


def _lasts(stage: Stage, gone: float, override: float, signals: Mapping[str, SignalValue]) -> float | None:
    """Return the remaining time of a stage, s; None for a wait whose signal has not its value, and for orders.

    What comes after orders happens in another world.
    """
    if stage.plan is not None:
        return stage.plan.duration / override
    if stage.orders:
        return None
    if stage.wait is None:
        return 0.0
    if condition := stage.wait.condition:
        return 0.0 if condition.holds(signals.get(condition.signal)) else None
    return max(0.0, stage.wait.seconds - gone)
