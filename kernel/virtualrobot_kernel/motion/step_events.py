"""Events of a motion's steps, from its states after each tick: begun, zone entered, done."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.motion.running_motion import RunningMotion
from virtualrobot_kernel.motion.tracking_motion import TrackingMotion


class StepEventKind(Enum):
    """Kind of an event; the names equal those of `ProgramStepEventKind` in the contract."""

    BEGUN = "begun"
    ZONE_ENTERED = "zone entered"
    DONE = "done"


class StepEvent(NamedTuple):
    """Event of a step by its number, and as its program's text calls it."""

    kind: StepEventKind
    step: int
    path: str


class StepEvents:
    """Events of one motion, looked at after each tick. The first look tells the step that it is at as begun."""

    def __init__(self) -> None:
        """Know nothing of it."""
        self._first = True
        self._done = self._begun = self._entered = -1
        self._program: Program | None = None
        self._zoned: set[int] = set()
        self._paths: dict[int, str] = {}

    def look(self, running: RunningMotion, step_count: int) -> list[StepEvent]:
        """Return what has happened since the last look; step_count: how many steps there are now, 0: moves alone."""
        run = running.inner if isinstance(running, TrackingMotion) else running
        count = max(1, step_count)
        at = min(run.steps_done, count)
        if isinstance(run, ProgramRun) and run.program is not self._program:
            self._program = run.program
            self._zoned |= {number for stage in run.program.stages for _, number in stage.zones}
        if self._first:
            self._first, self._done, self._begun = False, at - 1, at - 1
        told: list[StepEvent] = []
        for step in range(self._done + 1, at):
            self._begin(step, step_count, told)
            self._enter(step, told)
            told.append(StepEvent(StepEventKind.DONE, step, self._paths.pop(step, "")))
            self._zoned.discard(step)
            self._done = step
        if at < count and not running.ended:
            self._begin(at, step_count, told)
            if isinstance(run, ProgramRun) and run.zone == at:
                self._enter(at, told)
        return told

    def _begin(self, step: int, step_count: int, told: list[StepEvent]) -> None:
        if step <= self._begun:
            return
        self._begun = step
        self._paths[step] = self._program.path_of(step) if self._program is not None and step_count else ""
        told.append(StepEvent(StepEventKind.BEGUN, step, self._paths[step]))

    def _enter(self, step: int, told: list[StepEvent]) -> None:
        if step in self._zoned and step > self._entered:
            self._entered = step
            told.append(StepEvent(StepEventKind.ZONE_ENTERED, step, self._paths.get(step, "")))
