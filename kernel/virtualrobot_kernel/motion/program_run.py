"""Program that runs: the stages of a Program, one after the other. Pure: methods return what it is afterwards.

A stage begins in the tick in which the one before has ended, with what remains of that tick, so a program takes as
long as its stages do. Signals are read as they were at the tick's beginning, those that the program itself has set in
the tick included. Every value that it sets holds for a tick at least: where a signal is set twice within one tick, the
later value is told a tick later, and the program does not leave its stage before.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion import plan_execution
from virtualrobot_kernel.motion.brake import StopAhead
from virtualrobot_kernel.motion.plan_execution import PlanExecution
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.program import Program, Stage, Wait
from virtualrobot_kernel.motion.quick import maker
from virtualrobot_kernel.motion.running_motion import ENDED, NOTHING, Phase, TickContext
from virtualrobot_kernel.motion.signals import SignalValue

MOST_STAGES = 64
"""Greatest number of stages that may end in one tick: a tick must stay short, whatever a program says."""

_TOLERANCE = 1e-9
_NO_SIGNALS: Mapping[str, SignalValue] = {}


@dataclass(frozen=True, slots=True, eq=False)
class ProgramRun:
    """State of a program that runs or has ended.

    at: the stage; all are done when it is their number. running: how far the stage's plan is; None where it has none
    or has not begun. waited: how long the stage has waited (s). held (n,): where the joints are that the stage does not
    move. marked: how many of the stage's marks have been passed. due: signals to set that no tick has told yet. asks:
    whether it has come to the stage's orders. steps: whether it pauses at the end of the stage.
    """

    program: Program
    phase: Phase
    at: int
    running: PlanExecution | None
    waited: float
    held: Array
    marked: int
    due: tuple[tuple[str, SignalValue], ...]
    signals: Mapping[str, SignalValue]
    found: bool | None = None
    fault: tuple[str, str] | None = None
    asks: bool = False
    steps: bool = False

    @property
    def ended(self) -> bool:
        """True once it has succeeded or been cancelled."""
        return self.phase in ENDED

    @property
    def duration(self) -> float:
        """Duration at full rate, in s; waiting for signals takes no time."""
        return self.program.duration

    @property
    def progress(self) -> float:
        """Share of its duration that is done, 0 to 1; 1 for a program without length."""
        total = self.program.duration
        if total <= 0.0:
            return 1.0
        return min(1.0, (self.program.begins[self.at] + self._gone) / total)

    @property
    def steps_done(self) -> int:
        """Number of steps done; for moves that are no program 1 once they have succeeded."""
        if self.phase is Phase.SUCCEEDED:
            return max(1, self.program.step_count)
        if self.at == len(self.program.stages):
            return self.program.step_count
        steps = self.program.stages[self.at].steps
        return steps[self._place][1]

    @property
    def step_path(self) -> str:
        """Step that it is at, or was at last, as the program's text calls it; empty where it has no name."""
        stages = self.program.stages
        if self.at == len(stages):
            return stages[-1].paths[-1] if stages and stages[-1].paths else ""
        paths = stages[self.at].paths
        return paths[self._place] if paths else ""

    @property
    def zone(self) -> int:
        """Number of the step whose zone it has entered last in its stage; -1 before."""
        if self.at == len(self.program.stages):
            return -1
        zones = self.program.stages[self.at].zones
        place = bisect_right(zones, self._gone, key=_time) - 1
        return zones[place][1] if place >= 0 else -1

    @property
    def orders(self) -> tuple[object, ...]:
        """Orders of the stage that it has come to; none while it is paused, or ends."""
        going = self.asks and self.phase in (Phase.RUNNING, Phase.WAITING)
        return self.program.stages[self.at].orders if going else ()

    @property
    def _place(self) -> int:
        """Place of the step that it is at among those of its stage."""
        return max(0, bisect_right(self.program.stages[self.at].steps, self._gone, key=_time) - 1)

    @property
    def _stands(self) -> bool:
        """True while nothing moves: no motion has begun, or it is over, as one without length is at once."""
        return self.running is None or self.running.ended

    @property
    def _gone(self) -> float:
        """Planned time of the stage that is over, in s."""
        if self.running is not None:
            return self.running.tau
        if self.at == len(self.program.stages):
            return 0.0
        return min(self.waited, self.program.stages[self.at].duration)

    @property
    def left(self) -> tuple[float, Program]:
        """Nominal time (s) that has gone by, and the program without the stages that are done; at least one is left."""
        program, at = self.program, min(self.at, len(self.program.stages) - 1)
        start = program.start.copy()
        for stage in program.stages[:at]:
            if stage.plan is not None:
                start[list(stage.columns)] = stage.plan.goal
        now = program.begins[self.at] + self._gone
        return now, replace(program, stages=program.stages[at:], start=start, done=program.begins[at])

    @property
    def whole(self) -> PlanExecution | None:
        """The motion on a plan that moves all of its joints now; None where there is none."""
        return self.running if self.running is not None and self.program.places[self.at] is None else None

    def sample(self) -> tuple[Array, Array, Array]:
        """Return joint positions, velocities and accelerations (n,): rad or m, per s, per s²."""
        if self.running is None:
            return self.held, np.zeros_like(self.held), np.zeros_like(self.held)
        moved, columns = self.running.sample(), self.program.places[self.at]
        if columns is None:
            return moved
        q, v, a = self.held.copy(), np.zeros_like(self.held), np.zeros_like(self.held)
        q[columns], v[columns], a[columns] = moved
        return q, v, a

    def advance(self, dt: float, override: float, context: TickContext = NOTHING) -> ProgramRun:
        """Return the program `dt` seconds later, with the speed `override` in (0, 1] of its motions."""
        if self.phase in ENDED:
            return self
        searches = self.running is not None and self.program.stages[self.at].until is not None
        run = _searched(self, context) if searches else self
        return _on_its_way(run, dt, override) or _advanced(run, dt, override, context)

    def pause(self) -> ProgramRun:
        """Return the program slowing to standstill; at once PAUSED where it stands; a pausing or paused one as it is.

        Raises KernelError (WRONG_STATE) when it is stopping or has ended.
        """
        if self.phase in (Phase.PAUSING, Phase.PAUSED):
            return self
        _refuse(self, "paused")
        if self.running is None or self._stands:
            return replace(self, phase=Phase.PAUSED)
        return replace(self, running=self.running.pause(), phase=Phase.PAUSING)

    def resume(self) -> ProgramRun:
        """Return the program going on after a pause, past the end of a step that was to be the last one.

        One that runs or waits does as it does. Raises KernelError (WRONG_STATE) when it is stopping or has ended.
        """
        if self.phase in (Phase.RUNNING, Phase.WAITING, Phase.STARVED):
            return replace(self, steps=False) if self.steps else self
        _refuse(self, "resumed")
        if self.running is not None and not self._stands:
            return replace(self, running=self.running.resume(), phase=Phase.RUNNING, steps=False)
        if self.at == len(self.program.stages):
            return replace(self, phase=Phase.STARVED, steps=False)
        waits = self.program.stages[self.at].wait is not None
        return replace(self, phase=Phase.WAITING if waits else Phase.RUNNING, steps=False)

    def step(self) -> ProgramRun:
        """Return the program going on to the end of its stage, where it pauses.

        Raises KernelError (WRONG_STATE) when it is stopping or has ended.
        """
        return replace(self.resume(), steps=True)

    def cancel(self) -> ProgramRun:
        """Return the program braking to its end; one that stands ends at once, one that stops or has ended stays so.

        Where a motion stands still no later at its goal than by braking it runs on to it; the program is cancelled
        there, unless nothing follows: then it has succeeded.
        """
        if self.phase in (*ENDED, Phase.STOPPING):
            return self
        stopping = self.running.cancel() if self.running is not None else None
        if self.due or (stopping is not None and stopping.phase is Phase.STOPPING):
            return replace(self, running=stopping, phase=Phase.STOPPING)
        return replace(self, running=stopping, phase=Phase.CANCELLED)

    def stop_ahead(self, dt: float, override: float, most: int) -> StopAhead | None:
        """Return the stop of the program if it is cancelled now, as `cancel` and at most so many ticks would have it.

        None where nothing moves, and where that can't be told at once.
        """
        if self.running is None or self.due or self.ended:
            return None
        ahead, columns = self.running.stop_ahead(dt, override, most), self.program.places[self.at]
        if ahead is None or columns is None:
            return ahead
        held = np.repeat(self.held[None], len(ahead.positions), axis=0)
        held[:, columns] = ahead.positions
        return ahead._replace(positions=held)

    def arrived(self) -> ProgramRun:
        """Return the program after a stop that ends at the goal of its stage (`stop_ahead`)."""
        if self.running is None:
            return self
        there = replace(self.running, phase=Phase.SUCCEEDED, tau=self.running.duration)
        return replace(self, running=there, phase=Phase.STOPPING).advance(0.0, there.override)

    def append(self, more: Program, cut: float | None) -> ProgramRun | None:
        """Return the program with the stages of `more` after its own, which are gone as far as they are done.

        more: begins where this ends, for the same joints or more; it says how many steps there are now, and whether it
        is still open. cut: its first stage takes the place of the last one, and is the same up to this nominal time (s)
        of its plan; None: all come after. Returns None when the motion is past the cut.
        """
        stages, running = self.program.stages[self.at :], self.running
        if cut is not None:
            plan = more.stages[0].plan
            if not stages or plan is None:
                return None
            if running is not None and len(stages) == 1 and (running := running.on(plan, cut)) is None:
                return None
            stages = stages[:-1]
            if running is not None and not stages:
                passed = self.program.stages[self.at].marks[: self.marked]
                more = replace(more, stages=(_after(more.stages[0], passed), *more.stages[1:]))
        stages = (*stages, *more.stages)
        held = np.concatenate([self.held, more.start[len(self.held) :]])
        program = replace(more, stages=stages, start=held, done=self.program.begins[self.at])
        phase = Phase.RUNNING if self.phase is Phase.STARVED else self.phase
        if phase is Phase.RUNNING and more.stages and not self.program.stages[self.at :] and more.stages[0].pauses:
            phase = Phase.PAUSED
        return replace(self, program=program, phase=phase, at=0, running=running, held=held)

    def obeyed(self) -> ProgramRun:
        """Return the program after the world has done the orders of its stage: it goes on with the next tick."""
        at = self.at + 1
        phase = Phase.PAUSED if _stops_before(self.program, at, self.steps) else Phase.RUNNING
        return replace(self, phase=phase, at=at, waited=0.0, marked=0, asks=False, steps=False)

    def abort(self) -> ProgramRun:
        """Return the program ended where it is: what it moved is gone."""
        return replace(self, phase=Phase.CANCELLED)


_made = maker(ProgramRun)


def start(program: Program, override: float) -> ProgramRun:
    """Return a program at its start, at rest; one that does nothing has succeeded already."""
    first = program.stages[0]
    begun = plan_execution.start(first.plan, override) if first.plan is not None else None
    empty = begun is not None and begun.ended and not first.marks and first.until is None
    phase = Phase.SUCCEEDED if empty and len(program.stages) == 1 and not program.open else Phase.RUNNING
    if first.pauses:
        phase, begun = Phase.PAUSED, None
    return ProgramRun(program, phase, 0, begun, 0.0, program.start, 0, (), _NO_SIGNALS)


def _searched(run: ProgramRun, context: TickContext) -> ProgramRun:
    """Brake where the signal of a search has its value as the tick begins, moving or about to move."""
    if run.found is not None or run.running is None or run.phase not in (Phase.RUNNING, Phase.PAUSING):
        return run
    until = run.program.stages[run.at].until
    if until is None or not until.holds(context.signals.get(until.signal)):
        return run
    return replace(run, running=run.running.cancel(), phase=Phase.STOPPING, found=True)


def _on_its_way(run: ProgramRun, dt: float, override: float) -> ProgramRun | None:
    """Return what `_advanced` does, sooner, where nothing but the stage's motion goes on; None where more happens."""
    if run.running is None or run.due:
        return None
    moving = run.running.advance(dt, override)
    if moving.phase in ENDED:
        return None
    marks = run.program.stages[run.at].marks
    if run.marked < len(marks) and marks[run.marked][0] <= moving.tau + _TOLERANCE:
        return None
    program, at, held, marked, found, steps = run.program, run.at, run.held, run.marked, run.found, run.steps
    return _made(*(program, moving.phase, at, moving, 0.0, held, marked, (), _NO_SIGNALS, found), *(None, False, steps))


def _advanced(run: ProgramRun, dt: float, override: float, context: TickContext) -> ProgramRun:
    program, stages = run.program, run.program.stages
    phase, at, moving, waited, held, marked = run.phase, run.at, run.running, run.waited, run.held, run.marked
    due, told = list(run.due), dict[str, SignalValue]()
    found, fault, asks, steps = run.found, None, False, run.steps
    left = dt
    for _ in range(MOST_STAGES):
        over = False
        if at < len(stages) and not (phase is Phase.PAUSED and (moving is None or moving.ended)):
            stage = stages[at]
            if stage.plan is not None:
                if moving is None and phase is not Phase.STOPPING:
                    moving = plan_execution.start(stage.plan, override)
                if moving is not None:
                    if not moving.ended:
                        moving = moving.advance(left, override, context)
                        left = moving.left
                    marked = _mark(stage, moving.tau, marked, due)
                    over = moving.phase is Phase.SUCCEEDED
                    phase = phase if moving.ended else moving.phase
            elif phase is not Phase.STOPPING:
                marked = _mark(stage, 0.0, marked, due)
                asks = bool(stage.orders)
                over = stage.wait is None and not asks
                if stage.wait is not None:
                    over, waited, left, fault = _waited(stage, stage.wait, waited, left, told, context)
                    phase = Phase.WAITING
                    if fault:
                        phase = Phase.CANCELLED
        if over:
            if (until := stages[at].until) is not None and found is None:
                found = until.holds(
                    context.signals.get(until.signal)
                )  # only if it began with this tick: see `_searched`
            held = _arrived(program, at, held)
            at, moving, waited, marked = at + 1, None, 0.0, 0
            if phase in (Phase.RUNNING, Phase.WAITING) and _stops_before(program, at, steps):
                phase = Phase.PAUSED
            steps = steps and phase is not Phase.PAUSED
            if phase is Phase.WAITING:
                phase = Phase.RUNNING
            elif phase is Phase.PAUSING and (at < len(stages) or program.open):
                phase = Phase.PAUSED  # it stands before what comes next
        _tell(due, told)
        if due or not over or phase is not Phase.RUNNING or at == len(stages):
            break
    if not due and phase not in (Phase.PAUSED, *ENDED):
        if at == len(stages):
            end = Phase.CANCELLED if phase is Phase.STOPPING else Phase.STARVED
            phase = end if program.open else Phase.SUCCEEDED
        elif phase is Phase.STOPPING and (moving is None or moving.ended):
            phase = Phase.SUCCEEDED if found else Phase.CANCELLED
    return ProgramRun(program, phase, at, moving, waited, held, marked, tuple(due), told, found, fault, asks, steps)


def _after(stage: Stage, passed: Sequence[tuple[float, str, SignalValue]]) -> Stage:
    """Return a stage whose marks begin with those that are passed: a signal may be set earlier than others there."""
    left = list(stage.marks)
    for mark in passed:
        if mark in left:
            left.remove(mark)
    return replace(stage, marks=(*passed, *left))


def _stops_before(program: Program, at: int, steps: bool) -> bool:
    """Return whether a program that goes on stands before a stage, or at its end if it is open."""
    if at == len(program.stages):
        return steps and program.open
    return steps or program.stages[at].pauses


def _mark(stage: Stage, tau: float, marked: int, due: list[tuple[str, SignalValue]]) -> int:
    """Put the marks up to nominal time `tau` on the list of what is due; return how many have been passed."""
    while marked < len(stage.marks) and stage.marks[marked][0] <= tau + _TOLERANCE:
        due.append(stage.marks[marked][1:])
        marked += 1
    return marked


def _tell(due: list[tuple[str, SignalValue]], told: dict[str, SignalValue]) -> None:
    """Move from `due` to `told` what this tick can tell: one value of each signal, in order."""
    while due and told.get(due[0][0], due[0][1]) == due[0][1]:
        name, value = due.pop(0)
        told[name] = value


def _waited(
    stage: Stage, wait: Wait, waited: float, left: float, told: Mapping[str, SignalValue], context: TickContext
) -> tuple[bool, float, float, tuple[str, str] | None]:
    """Return whether a wait is over, how long it has taken, what is left of the tick, and the fault when it failed."""
    condition = wait.condition
    if condition and condition.holds(told.get(condition.signal, context.signals.get(condition.signal))):
        return True, waited, left, None
    waited += left
    if wait.seconds == 0.0 or waited < wait.seconds - _TOLERANCE:
        return False, waited, 0.0, None
    if condition is None and not stage.orders:
        return True, waited, max(0.0, waited - wait.seconds), None
    step = stage.paths[0] if stage.paths else stage.steps[0][1]
    if condition is None:
        what = ", ".join(map(str, stage.orders))
        return False, waited, 0.0, (wait.cause, f"step {step}: {what} for {wait.seconds:g} s")
    words = f"step {step}: the signal {condition.signal!r} was not {condition} within {wait.seconds:g} s"
    return False, waited, 0.0, ("SIGNAL_TIMEOUT", words)


def _arrived(program: Program, at: int, held: Array) -> Array:
    """Return the positions (n,) of the joints after the stage `at`."""
    plan = program.stages[at].plan
    if plan is None:
        return held
    columns = program.places[at]
    if columns is None:
        return plan.goal
    held = held.copy()
    held[columns] = plan.goal
    return held


def _time(step: tuple[float, int]) -> float:
    return step[0]


def _refuse(run: ProgramRun, what: str) -> None:
    if run.phase in (*ENDED, Phase.STOPPING):
        raise KernelError(
            f"a motion that is {run.phase.value} cannot be {what}; only one that is RUNNING, WAITING, PAUSING or "
            "PAUSED can",
            reason=Reason.WRONG_STATE,
            phase=run.phase.value,
        )
