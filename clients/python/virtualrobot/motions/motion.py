"""Motions: a handle for each one that was started. Blocking is done here, by watching."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypedDict, Unpack

from virtualrobot._wire import interruptions
from virtualrobot._wire.arguments import checked
from virtualrobot._wire.messages import count_or_none, value_or_default
from virtualrobot._wire.options import check_options
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.transport import Stream
from virtualrobot.errors import (
    CallTimeoutError,
    InvalidArgumentError,
    VirtualRobotError,
    WrongStateError,
)
from virtualrobot.motions.moves import Move, messages_of
from virtualrobot.motions.state import MotionState, Phase, PlanNote, ProgramStepEvent, Search
from virtualrobot.v1 import kernel_pb2, motion_pb2

if TYPE_CHECKING:
    from virtualrobot.motions.program import Program

log = logging.getLogger(__name__)

BEAT_SECONDS = 0.05
"""Time (s) from one beat of a motion that is held to the next; the kernel takes 0.2 s without one for a key let go."""

_SILENT_SECONDS = 5.0
"""Time (s) without a word of its watch after which the kernel is asked how a motion is."""


@checked
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
        self.notes = tuple(map(PlanNote.of, notes))
        self._services = services
        self._changed = threading.Condition()
        self._state = MotionState.of(message)
        self._error: VirtualRobotError | None = None
        self._stream: Stream[motion_pb2.WatchMotionResponse] | None = None
        self._heard = time.monotonic()

    @property
    def state(self) -> MotionState:
        """State of the motion now, as the kernel tells it: after `clock.step` that of the last tick, or a later one."""
        if self._state.phase.ended:
            return self._state
        return self._told(self._services.motion.GetMotion(motion_pb2.GetMotionRequest(id=self.id)).motion)

    @property
    def id(self) -> str:
        """Its name in the kernel, never used again."""
        return self._state.id

    @property
    def robots(self) -> tuple[str, ...]:
        """The robots that it moves."""
        return self._state.robots

    @property
    def planned_duration(self) -> float:
        """Duration at full speed factors (s)."""
        return self._state.planned_duration

    @property
    def step_count(self) -> int:
        """Number of steps of its program; 0 for moves that are no program."""
        return self.state.step_count

    @property
    def phase(self) -> Phase:
        """Phase of the motion now."""
        return self.state.phase

    @property
    def progress(self) -> float:
        """Part of the planned time law that is done, 0 to 1."""
        return self.state.progress

    @property
    def step(self) -> int:
        """Number of the program's step that it is at, from 0."""
        return self.state.step

    @property
    def step_path(self) -> str:
        """Step that it is at as the program's text has it: `4[2].0` is the first step of step 4 in its third round."""
        return self.state.step_path

    @property
    def search(self) -> Search | None:
        """Result of its search; None before, and for motions that don't search."""
        return self.state.search

    def wait(self, timeout: float | None = None) -> Motion:
        """Wait until it has reached its goal; return itself. Ctrl-C cancels it.

        In STEPPED mode nothing moves while this program waits: `clock.run` lets time go on until the motion has ended.
        Where another program, or another thread of this one, steps the clock, wait with a `timeout`.

        Raises:
            MotionCancelledError: when somebody ended it; the message says why.
            MotionAbortedError: when the kernel had to end it before its goal; both are a MotionEndedError.
            CallTimeoutError: after `timeout` seconds of the wall clock; the motion goes on.
            WrongStateError: without a `timeout`, where the clock is stepped and the motion has not ended; it goes on.
            KernelGoneError: when the kernel ended.
        """
        return self._wait(timeout, checked=timeout is not None)

    def _wait(self, timeout: float | None, *, checked: bool) -> Motion:
        """Wait as `wait` does; `checked`: something lets time go on meanwhile."""
        end = math.inf if timeout is None else time.monotonic() + timeout
        try:
            if not checked and not self.state.phase.ended:
                check_time_follows_the_wall(self._services)
            self.keep_watching()
            while not self._has_ended_by(end):
                if time.monotonic() >= end:
                    raise CallTimeoutError(f"motion {self.id} has not ended after {timeout} s; it goes on: {self!r}")
                self._heard = time.monotonic()
                if self.state.phase.ended:  # where it has not, time stands still
                    log.warning("motion %s has ended, which its watch did not tell", self.id)
        except KeyboardInterrupt as interrupted:
            self.cancel(str(interrupted) or "interrupted from the keyboard")
            raise
        if self._error is not None:
            raise self._error
        self._state.raise_early_end()
        return self

    def _has_ended_by(self, end: float) -> bool:
        """Wait for its end, until a time of `time.monotonic` or until its watch is silent; return whether it came."""
        with self._changed:
            while self._error is None and not self._state.phase.ended:
                left = min(end, self._heard + _SILENT_SECONDS) - time.monotonic()
                if left <= 0.0:
                    return False
                # Never without a limit: on Windows Ctrl-C would not get through.
                interruptions.wait(self._changed, min(left, 0.5))
            return True

    def append(
        self,
        program: Program | None = None,
        *,
        last: bool = False,
        expected_step_count: int | None = None,
        expected_structure_revision: int | None = None,
        request_id: str | None = None,
    ) -> tuple[PlanNote, ...]:
        """Append the steps of a program to one that was started `open`.

        Returns notes on what the planner made other than it was asked to: a zone that is dropped says that the step
        after it begins from rest, and why.

        Args:
            program: the steps; none are needed to close it.
            last: closes it: it succeeds when it has done all of its steps.
            expected_step_count: refuse to append when it has another number of steps before (`WrongStateError`).
            expected_structure_revision: as of `StartOptions`.
            request_id: as of `StartOptions`.

        Raises:
            WrongStateError: when the program is not open, stops or has ended.
            VirtualRobotError: as a start, with the number of the step; then it goes on without these steps.

        Example:
            >>> motion = client.program().move(robot.linear(first), zone=0.02).start(open=True)
            >>> for pose in poses:
            ...     motion.append(client.program().move(robot.linear(pose), zone=0.02))
            >>> motion.append(last=True)
            >>> motion.wait()
        """
        request = motion_pb2.AppendMotionRequest(
            id=self.id,
            steps=() if program is None else program._steps,
            programs=None if program is None else program._spec.programs,
            last=last,
            expected_step_count=count_or_none(expected_step_count, "expected_step_count"),
            expected_structure_revision=expected_structure_revision,
            request_id=request_id,
        )
        response = self._services.motion.AppendMotion(request, timeout=LONG_TIMEOUT_SECONDS)
        self._told(response.motion)
        return tuple(map(PlanNote.of, response.notes))

    def pause(self) -> None:
        """Slow it to standstill on its path; it can go on by `resume`."""
        self._services.motion.PauseMotion(motion_pb2.PauseMotionRequest(id=self.id))

    def resume(self) -> None:
        """Let it go on after a pause."""
        self._services.motion.ResumeMotion(motion_pb2.ResumeMotionRequest(id=self.id))

    @contextmanager
    def held(self) -> Iterator[Motion]:
        """Hold it for the length of a block: hold-to-run.

        It runs while the block does, since a thread of this program sends beats meanwhile, and slows to standstill on
        its path when the block ends, the process is stopped or ends, or the connection is lost. Another block lets it
        go on. A motion that was started with `hold` runs in no other way. Where somebody holds a key, take `beats`:
        a block that hangs would hold on.

        Raises:
            WrongStateError: when somebody else holds it.
            LeasedError, LeaseEndedError: when somebody else has the robot.

        Example:
            >>> jog = robot.jog([0, 0, -0.05], hold=True)
            >>> with jog.held():
            ...     while key.is_down():
            ...         time.sleep(0.01)
            >>> jog.cancel()
        """
        released = threading.Event()
        with self._held(lambda: not released.wait(BEAT_SECONDS), released.set):
            yield self

    @contextmanager
    def beats(self) -> Iterator[Callable[[], None]]:
        """Hold it for as long as beats come, by the function that the block is given: hold-to-run by hand.

        Each beat is good for 0.2 s of the wall clock; call it from the loop that looks whether the key is down, never
        from a timer: so a loop that hangs lets go, too. The beginning of the block is the first beat. Else it is as
        `held`, which sends beats by itself.

        Example:
            >>> jog = robot.jog([0, 0, -0.05], hold=True)
            >>> with jog.beats() as beat:
            ...     while key.is_down():
            ...         beat()
            ...         time.sleep(0.02)
            >>> jog.cancel()
        """
        beaten, released = threading.Event(), threading.Event()

        def comes() -> bool:
            beaten.wait()
            beaten.clear()
            return not released.wait(BEAT_SECONDS / 4)  # a loop may beat more often than the kernel needs it

        def let_go() -> None:
            released.set()
            beaten.set()

        with self._held(comes, let_go):
            yield beaten.set

    @contextmanager
    def _held(self, comes: Callable[[], bool], let_go: Callable[[], None]) -> Iterator[None]:
        """Hold it for the length of a block, with a beat at its begin, and one each time that `comes` returns True.

        `let_go` has `comes` return False.
        """

        def beats() -> Iterator[motion_pb2.HoldMotionRequest]:
            yield motion_pb2.HoldMotionRequest(id=self.id, sent_seconds=time.monotonic())
            while comes():
                yield motion_pb2.HoldMotionRequest(id=self.id, sent_seconds=time.monotonic())

        call = self._services.motion.HoldMotion(beats())
        try:
            with call:
                next(call, None)
                try:
                    yield
                finally:
                    let_go()
                for response in call:
                    self._told(response.motion)
        finally:
            let_go()

    def run_step(self) -> None:
        """Let its program go on to the end of the present step and pause there; steps that zones join count as one."""
        self._services.motion.StepMotion(motion_pb2.StepMotionRequest(id=self.id))

    def cancel(self, reason: str = "") -> None:
        """Slow it to standstill on its path and end it."""
        self._services.motion.CancelMotion(motion_pb2.CancelMotionRequest(id=self.id, reason=reason))

    def watch(self, max_rate: float | None = None) -> Iterator[MotionState]:
        """Yield its state again and again until it has ended, at most `max_rate` (30 by default) times a second."""
        request = motion_pb2.WatchMotionRequest(id=self.id, max_rate_hertz=value_or_default(max_rate, "max_rate"))
        with self._services.motion.WatchMotion(request) as stream:
            for response in stream:
                yield MotionState.of(response.motion)

    def watch_steps(self, max_rate: float | None = None) -> Iterator[ProgramStepEvent]:
        """Yield what becomes of its steps with the tick of each event, none left out, until it has ended.

        The step that it is at comes first, as begun; who wants all starts it with a breakpoint at its first step, and
        resumes it then. Told at most `max_rate` (30 by default) times a second. It keeps no motion alive.

        Example:
            >>> for event in motion.watch_steps():
            ...     print(event.tick, event.step_path, event.kind)
        """
        rate = value_or_default(max_rate, "max_rate")
        request = motion_pb2.WatchMotionStepsRequest(id=self.id, max_rate_hertz=rate)
        with self._services.motion.WatchMotionSteps(request) as stream:
            for response in stream:
                yield from map(ProgramStepEvent.of, response.events)

    def keep_watching(self) -> None:
        """Watch it in a thread until it ends, so that the kernel knows that somebody cares."""
        with self._changed:
            if self._stream is not None or self._state.phase.ended:
                return
            stream = self._stream = self._services.motion.WatchMotion(motion_pb2.WatchMotionRequest(id=self.id))
        threading.Thread(target=self._follow, args=(stream,), name=f"motion {self.id}", daemon=True).start()

    def _told(self, message: motion_pb2.Motion) -> MotionState:
        """Take what the kernel told, and return it; the end that is known already is its last state."""
        with self._changed:
            self._heard = time.monotonic()
            if not self._state.phase.ended:
                self._state = MotionState.of(message)
                self._changed.notify_all()
            return self._state

    def _follow(self, stream: Stream[motion_pb2.WatchMotionResponse]) -> None:
        error = None
        try:
            for response in stream:
                self._told(response.motion)
        except VirtualRobotError as stopped:
            error = stopped
        with self._changed:
            if error is not None or not self._state.phase.ended:
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
        state = self._state
        step = f", step {state.step_path}" if state.step_path else ""
        return f"<Motion {state.title}: {state.phase.name.lower()}, {100 * state.progress:.0f}%{step}>"


@checked
@dataclass(frozen=True, slots=True)
class Tracking:
    """Node that a motion goes along with, moved by one joint of another robot, such as a conveyor's belt.

    `window` is the way of the joint in all from its position when the motion is planned, with the sign of its
    direction, in meters or radians. `max_velocity` is the greatest speed of the joint that the arm shall keep up with,
    in m/s or rad/s; without it the joint's limit.

    Example:
        >>> belt = virtualrobot.Tracking("conveyor.belt", window=0.6, max_velocity=0.2)
        >>> robot.move_linear(belt_t_tcp, reference="conveyor.belt", tracking=belt)
    """

    node: str
    window: float
    max_velocity: float | None = None

    @property
    def _message(self) -> motion_pb2.Tracking:
        velocity = value_or_default(self.max_velocity, "max_velocity")
        return motion_pb2.Tracking(node=self.node, window=self.window, max_velocity=velocity)


class StartOptions(TypedDict, total=False):
    """Options of a start; None leaves each at its default.

    Attributes:
        wait: whether to return only at the motion's end; True by default, but for jogs. In STEPPED mode, where nothing
            would move meanwhile, a start that waits is refused with `WrongStateError`.
        preempt: cancel motions in the way instead of being refused with `RobotBusyError` (the default).
        replace: of a trajectory of `segments`: take over from motions in the way, without stopping.
        on_disconnect: what the kernel does when this program vanishes: `stop` (the default) or `continue`.
        expected_structure_revision: refuse to start when the scene's structure has another one (`StaleRevisionError`).
        tracking: what it goes along with.
        hold: whether it stands at its start, which doesn't wait then, and runs only while it is held: `Motion.beats`,
            `Motion.held`.
        request_id: a name of this start, such as `str(uuid.uuid4())`: a call that is made again with it, because the
            answer was lost, starts nothing and returns the motion of the first one.
    """

    wait: bool | None
    preempt: bool | None
    replace: bool | None
    on_disconnect: str | None
    expected_structure_revision: int | None
    tracking: Tracking | None
    request_id: str | None
    hold: bool | None


def start(services: Services, moves: Iterable[Move], **options: Unpack[StartOptions]) -> Motion:
    """Start moves that go together."""
    return start_spec(services, motion_pb2.MotionSpec(moves=messages_of(moves)), **options)


def start_spec(
    services: Services,
    spec: motion_pb2.MotionSpec,
    *,
    open: bool = False,
    breakpoints: Iterable[str] = (),
    **options: Unpack[StartOptions],
) -> Motion:
    """Start a motion; return its handle, after its end with `wait` unless it is `open`."""
    check_not_empty(spec)
    asked = motion_pb2.StartMotionRequest(spec=spec, open=open, breakpoints=breakpoints)
    return start_request(services, asked, **options)


def start_request(services: Services, asked: motion_pb2.StartMotionRequest, **options: Unpack[StartOptions]) -> Motion:
    """Start what a request names, with these options; return its handle as `start_spec` does."""
    check_options(options, StartOptions, "besides its move's own a start")
    preempt, on_disconnect, tracking = (options.get(name) for name in ("preempt", "on_disconnect", "tracking"))
    revision = options.get("expected_structure_revision")
    asked.request_id, asked.hold = options.get("request_id") or "", bool(options.get("hold"))
    policies = {"stop": motion_pb2.DISCONNECT_POLICY_STOP, "continue": motion_pb2.DISCONNECT_POLICY_CONTINUE}
    if on_disconnect is not None:
        if on_disconnect not in policies:
            raise InvalidArgumentError(f"on_disconnect is 'stop' or 'continue', not {on_disconnect!r}")
        asked.on_disconnect = policies[on_disconnect]
    if preempt and options.get("replace"):
        raise InvalidArgumentError("a start either cancels what is in the way, preempt, or takes over from it, replace")
    if options.get("replace"):
        asked.busy_policy = motion_pb2.BUSY_POLICY_REPLACE
    elif preempt is not None:
        asked.busy_policy = motion_pb2.BUSY_POLICY_PREEMPT if preempt else motion_pb2.BUSY_POLICY_REJECT
    if revision is not None:
        asked.expected_structure_revision = revision
    if tracking is not None:
        if not asked.HasField("spec"):
            raise InvalidArgumentError("a plan is started as it was shown; leave out tracking")
        asked.spec.tracking.CopyFrom(tracking._message)
    if asked.hold and options.get("wait"):
        raise InvalidArgumentError(
            "a motion runs only while it is held, so its start can't wait for it; leave out wait"
        )
    waits = options.get("wait", True) and not asked.open and not asked.hold
    if waits:
        check_time_follows_the_wall(services)
    # A program of thousands of steps takes its time to plan.
    response = services.motion.StartMotion(asked, timeout=LONG_TIMEOUT_SECONDS)
    motion = Motion(services, response.motion, response.notes)
    for note in motion.notes:
        if note.kind == "TOUCHING":
            log.warning("%s", note.message)  # where nobody sets up logging, Python prints it
    if asked.on_disconnect != motion_pb2.DISCONNECT_POLICY_CONTINUE:
        motion.keep_watching()
    return motion._wait(None, checked=True) if waits else motion


def check_time_follows_the_wall(services: Services) -> None:
    """Raise WrongStateError where the clock is stepped: who waits then waits for ever, but for others that step.

    Not of a replay, whose clock is stepped at its end, too: it refuses by itself what would move anything.
    """
    clock = services.kernel.GetClock(kernel_pb2.GetClockRequest()).clock
    if clock.mode == kernel_pb2.CLOCK_MODE_STEPPED and not clock.HasField("recorded"):
        raise WrongStateError(
            "the clock is stepped, so nothing moves while this program waits; start with wait=False and let time go on "
            "by client.clock.run(motion) or client.clock.step(ticks); where somebody else steps, wait with a timeout: "
            "motion.wait(timeout=60)"
        )


def check_not_empty(spec: motion_pb2.MotionSpec) -> None:
    """Raise InvalidArgumentError for a motion that does nothing, and say what would make it one."""
    if not spec.steps and not spec.moves:
        raise InvalidArgumentError(
            "there is nothing to do: give a first step or move, as by program.move(robot.ptp(goal)); an open program "
            "needs one too, and gets more by append"
        )


def stop(services: Services, robots: Iterable[str]) -> list[Motion]:
    """Cancel every motion, or every motion of these robots; return them."""
    response = services.motion.Stop(motion_pb2.StopRequest(robots=robots))
    return [Motion(services, message) for message in response.motions]
