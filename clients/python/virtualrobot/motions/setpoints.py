"""Streams of setpoints: a program moves joints as it goes, by positions or velocities."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire import interruptions
from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import shown
from virtualrobot._wire.transport import Stream
from virtualrobot.errors import (
    CallTimeoutError,
    InvalidArgumentError,
    UnknownNameError,
    VirtualRobotError,
    WrongStateError,
)
from virtualrobot.geometry import checked_pose, pose_from_quaternion, rows_from_poses
from virtualrobot.motions.motion import Motion
from virtualrobot.motions.state import MotionState, Phase
from virtualrobot.v1 import motion_pb2

MODES = {"position": motion_pb2.SETPOINT_MODE_POSITION, "velocity": motion_pb2.SETPOINT_MODE_VELOCITY}

TOOL_MODES = {"twist": motion_pb2.SETPOINT_MODE_TOOL_TWIST, "pose": motion_pb2.SETPOINT_MODE_TOOL_POSE}

NAMES: Mapping[int, tuple[str, ...]] = {
    motion_pb2.SETPOINT_MODE_TWIST: ("vx", "vy", "omega"),
    motion_pb2.SETPOINT_MODE_TOOL_TWIST: ("vx", "vy", "vz", "wx", "wy", "wz"),
    motion_pb2.SETPOINT_MODE_TOOL_POSE: ("x", "y", "z", "qx", "qy", "qz", "qw"),
}
"""Names of the values of a craft's twist, a tool's, and its pose."""

_RATES = frozenset(
    (motion_pb2.SETPOINT_MODE_VELOCITY, motion_pb2.SETPOINT_MODE_TWIST, motion_pb2.SETPOINT_MODE_TOOL_TWIST)
)

Setpoint: TypeAlias = Mapping[str, float | ArrayLike] | ArrayLike


@shown
@dataclass(frozen=True, slots=True, eq=False)
class StreamState:
    """State of joints that follow their setpoints, or of a tool centre point.

    Attributes:
        joint_names: the joints, in the order of the arrays; else the names of what setpoints are made of.
        positions: their positions, shape (k,), radians or meters; of a tool its pose (7,): x, y, z and a quaternion.
        velocities: their velocities, shape (k,), rad/s or m/s; of a tool its twist (6,).
        time: simulation time of that state (s).
        phase: the phase of the motion.
        held_by: what keeps a tool slower than its setpoint: a joint's name, or `singularity`; empty when nothing does.
    """

    joint_names: tuple[str, ...]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]
    time: float
    phase: Phase
    held_by: str = ""

    @property
    def pose(self) -> NDArray[np.float64]:
        """Pose (4x4) of a tool centre point in the frame of its setpoints.

        Raises:
            WrongStateError: when the stream is one of joints or of a craft.
        """
        if self.joint_names not in (NAMES[mode] for mode in TOOL_MODES.values()):
            raise WrongStateError(f"a stream of {', '.join(self.joint_names)} tells no pose")
        return pose_from_quaternion(self.positions[:3].tolist(), self.positions[3:].tolist())


@checked
class SetpointStream:
    """Joints that follow the setpoints which this program sends; `Robot.stream` opens one. A context manager.

    It may be used from several threads. At the end of the block the joints come to rest, at their last setpoint where
    that is a position; when the block fails they stop at once, smoothly.

    Example:
        >>> with robot.stream("velocity", ["lbr_iiwa_joint_1"]) as stream:
        ...     for state in stream:
        ...         stream.send([0.5])
        ...         if state.positions[0] > 1.0:
        ...             break
    """

    def __init__(
        self,
        services: Services,
        target: motion_pb2.SetpointTarget,
        spread: Callable[[Mapping[str, float | ArrayLike]], Mapping[str, float]],
    ) -> None:
        """Start a motion that follows setpoints; `Robot.stream` makes the usual ones.

        `spread` gives each coordinate of a joint that has several its own name.
        """
        self._spread = spread
        self._is_pose = target.mode == motion_pb2.SETPOINT_MODE_TOOL_POSE
        self.joint_names = NAMES.get(target.mode) or tuple(target.joint_names)
        self._changed = threading.Condition()
        self._newest: NDArray[np.float64] | None = None
        self._version = 0
        self._sent = 0
        self._under_way: deque[tuple[int, int]] = deque()
        self._arrived = 0
        self._closed = False
        self._ended = False
        self._cancelled = False
        self._error: VirtualRobotError | None = None
        self._call: Stream[motion_pb2.StreamSetpointsResponse] = services.motion.StreamSetpoints(self._requests(target))
        try:
            first = next(self._call)
        except BaseException:
            self._end(None)
            raise
        self.motion = Motion(services, first.motion)
        self._response = first
        still = np.zeros(len(self.joint_names))
        self._last = still if target.mode in _RATES else np.array(first.positions)
        threading.Thread(target=self._read, name=f"setpoints of {first.motion.id}", daemon=True).start()

    @property
    def state(self) -> StreamState:
        """State of the joints, as it was last told: at most 60 times a second."""
        response = self._response
        return StreamState(
            self.joint_names,
            np.array(response.positions),
            np.array(response.velocities),
            response.stamp.simulation_time_seconds,
            Phase(response.motion.phase),
            response.held_by,
        )

    def send(self, setpoint: Setpoint, *, wait: bool = False) -> None:
        """Send a setpoint: radians or meters, or per second; one that has not left yet is replaced.

        Values in the order of `joint_names`, or by name, those of a planar or floating joint as a row or each by the
        name of its coordinate; joints that are not named keep their last setpoint. A pose of a tool may be a 4x4 one.
        With `wait` it returns once the motion has got it: so a program that steps the clock knows in which tick it
        counts.

        Raises:
            LimitError, InvalidArgumentError: when an earlier setpoint was refused; the motion has stopped.
            MotionCancelledError: when the motion was cancelled.
            MotionAbortedError: when the kernel had to end it, such as because no setpoint came in time.
            LeasedError, LeaseEndedError: when somebody else has the robot now.
            KernelGoneError: when the kernel ended.
        """
        with self._changed:
            self._last = self._newest = self._values(setpoint)
            self._version += 1
            version = self._version
            self._raise_if_over()
            self._changed.notify_all()
            while wait and self._arrived < version:
                interruptions.wait(self._changed, 0.5)
                self._raise_if_over()

    def check(self) -> None:
        """Raise what `send` would raise of the setpoints so far; nothing while all is well."""
        with self._changed:
            self._raise_if_over()

    def close(self, timeout: float | None = None) -> None:
        """End the stream well and wait until the joints rest, for at most `timeout` seconds; raises as `send` does."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
            if not interruptions.wait_for(self._changed, lambda: self._ended, timeout):
                raise CallTimeoutError(f"the joints of {self.motion.id} do not rest after {timeout} s; they go on")
            if Phase(self._response.motion.phase) is not Phase.SUCCEEDED:
                self._raise_if_over()

    def cancel(self, reason: str = "") -> None:
        """Stop the joints at once, smoothly, and end the stream; the motion is cancelled."""
        self._cancelled = True
        # Where the motion cannot be cancelled any more it has ended, or does so with its call.
        with suppress(VirtualRobotError):
            self.motion.cancel(reason)
        self._call.cancel()
        self._end(None)

    def __iter__(self) -> Iterator[StreamState]:
        """Yield the latest state again and again, each at most once; raises as `send` does when the motion is over."""
        seen = None
        while True:
            with self._changed:
                while self._response is seen:
                    self._raise_if_over()
                    interruptions.wait(self._changed, 0.5)
                seen = self._response
            yield self.state

    def __enter__(self) -> SetpointStream:
        """Return itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Let the joints come to rest; stop them when the block failed."""
        if kind is not None:
            self.cancel("the program that started it failed")
        elif not self._cancelled:
            self.close()

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<SetpointStream {self.motion.id} of {', '.join(self.joint_names)}>"

    def _values(self, setpoint: Setpoint) -> NDArray[np.float64]:
        if isinstance(setpoint, Mapping):
            values = self._last.copy()
            for name, value in self._spread(setpoint).items():
                if name not in self.joint_names:
                    raise UnknownNameError(f"the stream moves {', '.join(self.joint_names)}, not {name!r}")
                values[self.joint_names.index(name)] = value
            return values
        values = np.array(setpoint, dtype=float)
        if self._is_pose and values.shape == (4, 4):
            return rows_from_poses(checked_pose(values))[0]
        if values.shape != (len(self.joint_names),):
            raise InvalidArgumentError(
                f"a setpoint has one value for each of {', '.join(self.joint_names)}, not the shape {values.shape}"
            )
        return values

    def _raise_if_over(self) -> None:
        if self._error is not None:
            raise self._error
        if self._ended or self._closed:
            MotionState.of(self._response.motion).raise_early_end()
            raise VirtualRobotError(f"the stream of {self.motion.id} is closed")

    def _requests(self, target: motion_pb2.SetpointTarget) -> Iterator[motion_pb2.StreamSetpointsRequest]:
        """Yield the target and then the newest setpoint whenever gRPC has sent the one before."""
        yield motion_pb2.StreamSetpointsRequest(target=target)
        while True:
            with self._changed:
                while self._newest is None and not (self._closed or self._ended):
                    self._changed.wait(0.5)
                if self._newest is None or self._ended:
                    return
                values, self._newest = self._newest, None
                self._sent += 1
                self._under_way.append((self._sent, self._version))
            yield motion_pb2.StreamSetpointsRequest(values=values.tolist())

    def _read(self) -> None:
        try:
            for response in self._call:
                with self._changed:
                    self._response = response
                    while self._under_way and self._under_way[0][0] <= response.setpoint_count:
                        self._arrived = self._under_way.popleft()[1]
                    self._changed.notify_all()
        except VirtualRobotError as error:
            self._end(error)
        else:
            self._end(None)

    def _end(self, error: VirtualRobotError | None) -> None:
        with self._changed:
            self._ended = True
            self._error = self._error or error
            self._changed.notify_all()


def by_name(setpoint: Mapping[str, float | ArrayLike]) -> Mapping[str, float]:
    """Return numbers by the names of what a twist or a pose is made of."""
    return {name: float(np.asarray(value)) for name, value in setpoint.items()}
