"""Program: motions, waits and signals one after the other, as data."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.planned import Plan
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.signals import Condition, SignalValue


@dataclass(frozen=True, slots=True)
class Wait:
    """Standstill until a signal meets the condition, for at most `seconds` (0: without end); without one for `seconds`.

    seconds: simulation time, whatever the speed override is. cause: the name of the `EndCause` when the orders of its
    stage have not been done in time.
    """

    seconds: float
    condition: Condition | None = None
    cause: str = "PART_TIMEOUT"

    @property
    def duration(self) -> float:
        """Planned duration in s; 0 when it waits for a signal."""
        return 0.0 if self.condition else self.seconds


@dataclass(frozen=True, eq=False)
class Stage:
    """Stage of a program: all joints are at rest before and after it.

    plan: what moves; without one all joints stand still. columns (k,): which of the program's joints the plan's are.
    steps: nominal times (s) at which steps of the program begin, with their indexes; paths: what they are called in its
    text. marks: nominal times at which signals are set on the way; without a plan they are set at once. wait: what a
    stage without a plan waits for, after its marks. until: what ends the plan early (a search). orders: what the world
    shall do for a stage without a plan, which is over when it is done; what they are is the world's matter alone.
    pauses: whether the program stands PAUSED before it until it is resumed. zones: nominal times at which the zone at
    the end of a step is entered, with that step's index; a step without a zone has none.
    """

    plan: Plan | None
    columns: tuple[int, ...]
    steps: tuple[tuple[float, int], ...]
    marks: tuple[tuple[float, str, SignalValue], ...] = ()
    wait: Wait | None = None
    until: Condition | None = None
    orders: tuple[object, ...] = ()
    paths: tuple[str, ...] = ()
    pauses: bool = False
    zones: tuple[tuple[float, int], ...] = ()

    @property
    def duration(self) -> float:
        """Duration at full rate, in s; waiting for a signal or for the world takes no time."""
        if self.plan is not None:
            return self.plan.duration
        if self.orders:
            return 0.0
        return self.wait.duration if self.wait else 0.0


@dataclass(frozen=True, eq=False)
class Program:
    """Stages one after the other for n joints; at least one stage, unless it was open.

    start (n,): where the joints are when it starts. step_count: 0 for moves that are no program. open: more may be
    appended. done: how long the stages were (s) that it had before its first one and has no more. speeds: factors, by
    robot (empty: all others), by which moves that are appended are slowed. outer_count: how many steps its text has
    outside of others. Derived: begins, when
    each stage begins, in s at full rate, and when the last one ends; goal (n,): where the joints are then; lowest,
    highest (n,): the least and greatest value that each joint stands at between stages; places: the columns of each
    stage, None for all joints in their order; signals: those that it sets, waits for or searches by.
    """

    stages: tuple[Stage, ...]
    start: Array
    step_count: int = 0
    open: bool = False
    done: float = 0.0
    speeds: tuple[tuple[str, float], ...] = ()
    outer_count: int = 0
    begins: tuple[float, ...] = field(init=False)
    goal: Array = field(init=False)
    lowest: Array = field(init=False)
    highest: Array = field(init=False)
    places: tuple[NDArray[np.int64] | None, ...] = field(init=False)
    signals: frozenset[str] = field(init=False)

    def __post_init__(self) -> None:
        """Derive what each tick and each start would have to compute again."""
        start = np.array(self.start, dtype=np.float64)
        goal, lowest, highest, begins = start.copy(), start.copy(), start.copy(), [self.done]
        for stage in self.stages:
            begins.append(begins[-1] + stage.duration)
            if stage.plan is not None:
                columns = list(stage.columns)
                goal[columns] = stage.plan.goal
                lowest[columns] = np.minimum(lowest[columns], stage.plan.goal)
                highest[columns] = np.maximum(highest[columns], stage.plan.goal)
        every = tuple(range(len(start)))
        places = (None if stage.columns == every else np.array(stage.columns, np.int64) for stage in self.stages)
        named = {name for stage in self.stages for _, name, _ in stage.marks}
        named |= {stage.wait.condition.signal for stage in self.stages if stage.wait and stage.wait.condition}
        named |= {stage.until.signal for stage in self.stages if stage.until}
        object.__setattr__(self, "signals", frozenset(named))
        object.__setattr__(self, "begins", tuple(begins))
        object.__setattr__(self, "places", tuple(places))
        for name, values in (("start", start), ("goal", goal), ("lowest", lowest), ("highest", highest)):
            values.setflags(write=False)
            object.__setattr__(self, name, values)

    @property
    def duration(self) -> float:
        """Duration of all stages at full rate, in s; waiting for signals takes no time."""
        return self.begins[-1]

    def path_of(self, step: int) -> str:
        """Return what its text calls a step that it has not done."""
        named = (zip(stage.steps, stage.paths, strict=False) for stage in self.stages)
        return next((path for pairs in named for (_, number), path in pairs if number == step), str(step))

    def done_at(self, step: int) -> float:
        """Return the nominal time (s) at which a step is done: when a later one begins, or the end."""
        later = (
            begin + time
            for stage, begin in zip(self.stages, self.begins, strict=False)
            for time, number in stage.steps
            if number > step
        )
        return min(later, default=self.duration)


def of_plan(plan: Plan, until: Condition | None = None) -> Program:
    """Return the program that does nothing but follow one plan, as a search where `until` says by what."""
    return Program((Stage(plan, tuple(range(plan.q_count)), ((0.0, 0),), until=until),), plan.start)
