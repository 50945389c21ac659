"""Motions: a handle for each one that was started. Blocking is done here, by watching."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import Enum
from typing import TypedDict, Unpack

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.messages import pose_of
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.transport import Stream
from virtualrobot.errors import (
    CallTimeoutError,
    InvalidArgumentError,
    MotionAbortedError,
    MotionCancelledError,
    VirtualRobotError,
)
from virtualrobot.motions.moves import unstarted
from virtualrobot.v1 import motion_pb2


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


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """Result of a search: joint positions (rad or m, by name), pose of the tool centre point (4x4) and time (s).

    `time_seconds` is simulation time. The values are those of the hit; where nothing was found, of the motion's end.
    """

    found: bool
    joint_positions: dict[str, float]
    world_t_tcp: NDArray[np.float64]
    time_seconds: float


def raise_early_end(motion: motion_pb2.Motion) -> None:
    """Raise MotionCancelledError, or MotionAbortedError, for a motion that has ended before its goal."""
    phase = Phase(motion.phase)
    if phase not in (Phase.CANCELLED, Phase.ABORTED):
        return
    error = MotionAbortedError if phase is Phase.ABORTED else MotionCancelledError
    raise error(
        f"motion {motion.id} of {', '.join(motion.robots)} was {phase.name.lower()} at {100 * motion.progress:.0f}%: "
        f"{motion.end_reason or 'no reason given'}",
        metadata={"motion": motion.id, "end_reason": motion.end_reason},
    )


class Motion:
    """One motion of a robot, of several that move together, or a program of many steps.

    A motion that was started here is watched by a thread of its own until it ends, since the kernel cancels motions
    that nobody watches any more: so it goes on as long as this program lives. As a context manager it is waited for at
    the end of the block, and cancelled when the block fails.

    Example:
        >>> motion = robot.move_joints(goal, wait=False)
        >>> motion.progress
        0.25
        >>> motion.wait()
    """

    def __init__(
        self, services: Services, message: motion_pb2.Motion, notes: Iterable[motion_pb2.PlanNote] = ()
    ) -> None:
        """Handle a motion that the kernel knows; `start` makes the usual ones.

        `notes` tell what the planner made other than it was asked to, such as smaller zones.
        """
        self.notes = tuple(notes)
        self._services = services
        self._changed = threading.Condition()
        self._message = message
        self._error: VirtualRobotError | None = None
        self._stream: Stream[motion_pb2.WatchMotionResponse] | None = None

    @property
    def id(self) -> str:
        """Its name in the kernel, never used again."""
        return self._message.id

    @property
    def robots(self) -> tuple[str, ...]:
        """The robots that it moves."""
        return tuple(self._message.robots)

    @property
    def _title(self) -> str:
        """Title of the motion for people: a program that only sets signals moves no robot."""
        return f"{self.id} of {', '.join(self.robots)}" if self.robots else self.id

    @property
    def planned_duration_seconds(self) -> float:
        """Duration at full speed factors (s)."""
        return self._message.planned_duration_seconds

    @property
    def phase(self) -> Phase:
        """Phase of the motion now."""
        return Phase(self.message.phase)

    @property
    def progress(self) -> float:
        """Part of the planned time law that is done, 0 to 1."""
        return self.message.progress

    @property
    def step(self) -> int:
        """Number of the program's step that it is at, from 0."""
        return self.message.step

    @property
    def step_count(self) -> int:
        """Number of steps of its program; 0 for moves that are no program."""
        return self._message.step_count

    @property
    def search(self) -> Search | None:
        """Result of its search; None before, and for motions that don't search."""
        message = self.message
        if not message.HasField("search"):
            return None
        found = message.search
        return Search(found.found, dict(found.joint_positions), pose_of(found.world_t_tcp), found.time_seconds)

    @property
    def message(self) -> motion_pb2.Motion:
        """The motion as the contract describes it, as it is now."""
        if self._stream is None and not Phase(self._message.phase).ended:
            response = self._services.motion.GetMotion(motion_pb2.GetMotionRequest(id=self.id))
            with self._changed:
                self._message = response.motion
        return self._message

    def wait(self, timeout: float | None = None) -> Motion:
        """Wait until it has reached its goal; return itself. Ctrl-C cancels it.

        In STEPPED mode time must go on meanwhile: another program, or another thread of this one, calls `clock.step`.

        Raises:
            MotionCancelledError: when it was cancelled; the message says why.
            MotionAbortedError: when the kernel had to end it before its goal.
            CallTimeoutError: after `timeout` seconds of the wall clock; the motion goes on.
            KernelGoneError: when the kernel ended.
        """
        end = None if timeout is None else time.monotonic() + timeout
        try:
            self.keep_watching()
            with self._changed:
                while self._error is None and not Phase(self._message.phase).ended:
                    left = None if end is None else end - time.monotonic()
                    if left is not None and left <= 0:
                        raise CallTimeoutError(f"motion {self.id} has not ended after {timeout} s; it goes on")
                    # Never without a limit: on Windows Ctrl-C would not get through.
                    self._changed.wait(0.5 if left is None else min(left, 0.5))
        except KeyboardInterrupt:
            self.cancel("interrupted from the keyboard")
            raise
        if self._error is not None:
            raise self._error
        raise_early_end(self._message)
        return self

    def append(self, steps: Iterable[motion_pb2.ProgramStep], *, last: bool = False) -> tuple[motion_pb2.PlanNote, ...]:
        """Append the steps of a `Program` to one that was started `open`; `last` closes it.

        Returns notes on what the planner made other than it was asked to: a zone that is dropped says that the step
        after it begins from rest, and why. Raises WrongStateError when the program is not open, stops or has ended,
        and errors that name the step as a start does; then it goes on without these steps.

        Example:
            >>> motion = client.program().move(robot.linear(first), zone=0.02).start(open=True)
            >>> for pose in poses:
            ...     motion.append(client.program().move(robot.linear(pose), zone=0.02))
            >>> motion.append([], last=True)
            >>> motion.wait()
        """
        request = motion_pb2.AppendMotionRequest(id=self.id, steps=steps, last=last)
        response = self._services.motion.AppendMotion(request, timeout=LONG_TIMEOUT_SECONDS)
        with self._changed:
            if not Phase(self._message.phase).ended:
                self._message = response.motion
        return tuple(response.notes)

    def pause(self) -> None:
        """Slow it to standstill on its path; it can go on by `resume`."""
        self._services.motion.PauseMotion(motion_pb2.PauseMotionRequest(id=self.id))

    def resume(self) -> None:
        """Let it go on after a pause."""
        self._services.motion.ResumeMotion(motion_pb2.ResumeMotionRequest(id=self.id))

    def cancel(self, reason: str = "") -> None:
        """Slow it to standstill on its path and end it."""
        self._services.motion.CancelMotion(motion_pb2.CancelMotionRequest(id=self.id, reason=reason))

    def watch(self, max_rate_hertz: float = 0.0) -> Iterator[motion_pb2.Motion]:
        """Yield the motion again and again until it has ended; at most 30 times a second by default."""
        request = motion_pb2.WatchMotionRequest(id=self.id, max_rate_hertz=max_rate_hertz)
        with self._services.motion.WatchMotion(request) as stream:
            for response in stream:
                yield response.motion

    def keep_watching(self) -> None:
        """Watch it in a thread until it ends, so that the kernel knows that somebody cares."""
        with self._changed:
            if self._stream is not None or Phase(self._message.phase).ended:
                return
            stream = self._stream = self._services.motion.WatchMotion(motion_pb2.WatchMotionRequest(id=self.id))
        threading.Thread(target=self._follow, args=(stream,), name=f"motion {self.id}", daemon=True).start()

    def _follow(self, stream: Stream[motion_pb2.WatchMotionResponse]) -> None:
        error = None
        try:
            for response in stream:
                with self._changed:
                    self._message = response.motion
                    self._changed.notify_all()
        except VirtualRobotError as stopped:
            error = stopped
        with self._changed:
            if error is not None or not Phase(self._message.phase).ended:
                self._error = error or VirtualRobotError(f"the kernel no longer tells of motion {self.id}")
            self._changed.notify_all()

    def __enter__(self) -> Motion:
        """Return itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Wait for it; cancel it when the block failed."""
        if kind is None:
            self.wait()
        else:
            self.cancel("the program that started it failed")

    def __repr__(self) -> str:
        """Return a line for people, as it was last told."""
        phase, progress = Phase(self._message.phase).name.lower(), self._message.progress
        return f"<Motion {self._title}: {phase}, {100 * progress:.0f}%>"


@dataclass(frozen=True, slots=True)
class Tracking:
    """Node that a motion goes along with, moved by one joint of another robot, such as a conveyor's belt.

    `window` is the way of the joint in all from its position when the motion is planned, with the sign of its
    direction, in meters or radians. `max_velocity` is the greatest speed of the joint that the arm shall keep up with,
    in m/s or rad/s; 0 means the joint's limit.

    Example:
        >>> belt = virtualrobot.Tracking("conveyor.belt", window=0.6, max_velocity=0.2)
        >>> robot.move_linear(belt_t_tcp, reference="conveyor.belt", tracking=belt)
    """

    node: str
    window: float
    max_velocity: float = 0.0

    @property
    def message(self) -> motion_pb2.Tracking:
        """The same as a message of the contract."""
        return motion_pb2.Tracking(node=self.node, window=self.window, max_velocity=self.max_velocity)


class GoingOptions(TypedDict, total=False):
    """Options of every start besides `wait`; see `start_spec`."""

    preempt: bool | None
    on_disconnect: str | None
    expected_revision: int | None
    tracking: Tracking | None


class StartOptions(GoingOptions, total=False):
    """Options of a start; see `start_spec`."""

    wait: bool


def start(services: Services, moves: Iterable[motion_pb2.Move], **options: Unpack[StartOptions]) -> Motion:
    """Start moves that go together; the options are those of `start_spec`."""
    return start_spec(services, motion_pb2.MotionSpec(moves=unstarted(moves)), **options)


def start_spec(
    services: Services,
    spec: motion_pb2.MotionSpec,
    *,
    wait: bool = True,
    preempt: bool | None = None,
    on_disconnect: str | None = None,
    expected_revision: int | None = None,
    tracking: Tracking | None = None,
    open: bool = False,
    **unknown: object,
) -> Motion:
    """Start a motion; return its handle, after its end with `wait` unless it is `open`.

    `preempt` cancels motions in the way instead of being refused. `on_disconnect` says what the kernel does when this
    program vanishes: `stop` or `continue`. With an `expected_revision` of the structure the start is refused
    (StaleRevisionError) when there is another one. With `tracking` it goes along with a frame that moves. None
    leaves that to the spec.
    """
    if unknown:
        # Python's own error would name this function, which nobody has called by hand.
        known = ", ".join(sorted(StartOptions.__optional_keys__))
        raise TypeError(f"there is no option {next(iter(unknown))!r}; besides its move's own a start takes {known}")
    asked = motion_pb2.StartMotionRequest(spec=spec, open=open)
    policies = {"stop": motion_pb2.DISCONNECT_POLICY_STOP, "continue": motion_pb2.DISCONNECT_POLICY_CONTINUE}
    if on_disconnect is not None:
        if on_disconnect not in policies:
            raise InvalidArgumentError(f"on_disconnect is 'stop' or 'continue', not {on_disconnect!r}")
        asked.on_disconnect = policies[on_disconnect]
    if preempt is not None:
        asked.busy_policy = motion_pb2.BUSY_POLICY_PREEMPT if preempt else motion_pb2.BUSY_POLICY_REJECT
    if expected_revision is not None:
        asked.expected_structure_revision = expected_revision
    if tracking is not None:
        if not isinstance(tracking, Tracking):
            raise InvalidArgumentError(f"tracking is a virtualrobot.Tracking(node, window), not {tracking!r}")
        asked.spec.tracking.CopyFrom(tracking.message)
    # A program of thousands of steps takes its time to plan.
    response = services.motion.StartMotion(asked, timeout=LONG_TIMEOUT_SECONDS)
    motion = Motion(services, response.motion, response.notes)
    if asked.on_disconnect != motion_pb2.DISCONNECT_POLICY_CONTINUE:
        motion.keep_watching()
    return motion.wait() if wait and not open else motion
