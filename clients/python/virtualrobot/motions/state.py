"""State of motions: their phases, what ended them, what a search has found, and notes of the planner."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.messages import pose_of, words_of
from virtualrobot._wire.showing import shown
from virtualrobot.errors import MotionAbortedError, MotionCancelledError
from virtualrobot.v1 import motion_pb2

STEP_EVENTS = words_of(motion_pb2.ProgramStepEventKind, "PROGRAM_STEP_EVENT_KIND_")


class Phase(Enum):
    """Phase of a motion."""

    RUNNING = motion_pb2.MOTION_PHASE_RUNNING
    PAUSING = motion_pb2.MOTION_PHASE_PAUSING
    PAUSED = motion_pb2.MOTION_PHASE_PAUSED
    STOPPING = motion_pb2.MOTION_PHASE_STOPPING
    SUCCEEDED = motion_pb2.MOTION_PHASE_SUCCEEDED
    CANCELLED = motion_pb2.MOTION_PHASE_CANCELLED
    WAITING = motion_pb2.MOTION_PHASE_WAITING
    ABORTED = motion_pb2.MOTION_PHASE_ABORTED
    STARVED = motion_pb2.MOTION_PHASE_STARVED

    @property
    def ended(self) -> bool:
        """True where the motion is over."""
        return self in (Phase.SUCCEEDED, Phase.CANCELLED, Phase.ABORTED)


@shown
@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """Result of a search: joint positions (rad or m, by name), pose of the tool centre point (4x4) and time (s).

    `time` is simulation time. The values are those of the hit; where nothing was found, of the motion's end.
    """

    found: bool
    joint_positions: dict[str, float]
    world_t_tcp: NDArray[np.float64]
    time: float


@shown
@dataclass(frozen=True, slots=True)
class JointDeviation:
    """Joint of a robot that was off by more than its tolerance when that ended its motion.

    Attributes:
        robot: the robot.
        joint: the joint.
        kind: what is off, `position` or `velocity`.
        value: by how much, with the sign of where it is too far (rad or m, or these per second).
        tolerance: in the same unit.
    """

    robot: str
    joint: str
    kind: str
    value: float
    tolerance: float

    @staticmethod
    def of(message: motion_pb2.JointDeviation) -> JointDeviation:
        """Return what a message tells."""
        kind = motion_pb2.DeviationKind.Name(message.kind).removeprefix("DEVIATION_KIND_").lower()
        return JointDeviation(message.robot, message.joint, kind, message.value, message.tolerance)


@shown
@dataclass(frozen=True, slots=True)
class ProgramStepEvent:
    """Event of a step of a motion.

    Attributes:
        kind: `begun`, `zone_entered` or `done`; after a zone a step begins in its middle, where the one before is done.
        step: number of the step, from 0.
        step_path: the same as the program's text has it.
        tick: the tick with which that was so.
        time: the same in simulation time (s).
    """

    kind: str
    step: int
    step_path: str
    tick: int
    time: float

    @staticmethod
    def of(message: motion_pb2.ProgramStepEvent) -> ProgramStepEvent:
        """Return what a message tells."""
        kind = STEP_EVENTS[message.kind]
        return ProgramStepEvent(kind, message.step, message.step_path, message.tick, message.simulation_time_seconds)


@shown
@dataclass(frozen=True, slots=True, eq=False)
class MotionState:
    """State of a motion at one instant.

    Attributes:
        id: its name in the kernel, never used again.
        robots: the robots that it moves.
        phase: its phase.
        progress: part of the planned time law that is done, 0 to 1.
        step: number of the program's step that it is at, from 0.
        step_count: number of steps of its program; 0 for moves that are no program.
        planned_duration: duration at full speed factors (s).
        start_time: simulation time of its start (s).
        end_cause: cause of its end before its goal, such as `call`, `stop` or `collision`; empty without one.
        end_reason: the same in words.
        search: result of its search; None before, and for motions that don't search.
        step_path: the step as the program's text has it, such as `4[2].0`, the first step within step 4 in its third
            round; empty for moves that are no program.
        deviations: the joints beyond their tolerance that ended it (`path_tolerance`, `goal_tolerance`).
    """

    id: str
    robots: tuple[str, ...]
    phase: Phase
    progress: float
    step: int
    step_count: int
    planned_duration: float
    start_time: float
    end_cause: str
    end_reason: str
    search: Search | None
    step_path: str = ""
    deviations: tuple[JointDeviation, ...] = ()

    @staticmethod
    def of(message: motion_pb2.Motion) -> MotionState:
        """Return what a message tells."""
        cause = motion_pb2.EndCause.Name(message.end_cause).removeprefix("END_CAUSE_").lower()
        found = message.search
        return MotionState(
            message.id,
            tuple(message.robots),
            Phase(message.phase),
            message.progress,
            message.step,
            message.step_count,
            message.planned_duration_seconds,
            message.start_time_seconds,
            cause if message.end_cause else "",
            message.end_reason,
            Search(found.found, dict(found.joint_positions), pose_of(found.world_t_tcp), found.time_seconds)
            if message.HasField("search")
            else None,
            message.step_path,
            tuple(map(JointDeviation.of, message.deviations)),
        )

    @property
    def title(self) -> str:
        """Its name and its robots, for people."""
        return f"{self.id} of {', '.join(self.robots)}" if self.robots else self.id  # of a program without robots

    def raise_early_end(self) -> None:
        """Raise MotionCancelledError, or MotionAbortedError, for a motion that has ended before its goal."""
        if self.phase not in (Phase.CANCELLED, Phase.ABORTED):
            return
        error = MotionAbortedError if self.phase is Phase.ABORTED else MotionCancelledError
        raise error(
            f"motion {self.title} was {self.phase.name.lower()} at {100 * self.progress:.0f}%: "
            f"{self.end_reason or 'no reason given'}",
            metadata={"motion": self.id, "end_cause": self.end_cause, "end_reason": self.end_reason},
        )


@dataclass(frozen=True, slots=True)
class PlanReference:
    """Plan that the kernel remembers, by which it is started as it was shown, or checked.

    Attributes:
        id: its name, never used again.
        digest: SHA-256, in hexadecimal, of the plan and of all that it has used of the world.
    """

    id: str
    digest: str = ""

    @property
    def _message(self) -> motion_pb2.PlanReference:
        return motion_pb2.PlanReference(id=self.id, digest=self.digest)

    @staticmethod
    def of(message: motion_pb2.PlanMotionResponse | motion_pb2.CheckMotionResponse) -> PlanReference | None:
        """Return the plan that an answer names; None where it names none."""
        return PlanReference(message.plan.id, message.plan.digest) if message.HasField("plan") else None


@dataclass(frozen=True, slots=True)
class PlanNote:
    """Something that the planner made other than asked; `kind` is as in `PlanNoteKind` of the contract.

    wanted, kept: the value that was asked for and the one that became of it, in meters, radians or percent.
    step_path: the step as the program's text has it.
    """

    kind: str
    step: int
    robot: str
    wanted: float
    kept: float
    message: str
    step_path: str = ""

    @staticmethod
    def of(message: motion_pb2.PlanNote) -> PlanNote:
        """Return what a message tells."""
        kind = motion_pb2.PlanNoteKind.Name(message.kind).removeprefix("PLAN_NOTE_KIND_")
        return PlanNote(
            *(kind, message.step, message.robot, message.wanted, message.kept, message.message, message.step_path)
        )
