"""The arm that an emulated controller moves: one of its own, simulated here, or the twin in a kernel.

A controller's loop calls, once in each of its cycles, `read`, then `follow` if it has got a new setpoint, and then
`advance`. Positions are radians and meters, one for each joint in the order of `joint_names`.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray
from virtualrobot.errors import RobotBusyError, UnreachableError, VirtualRobotError
from virtualrobot.motions.motion import Motion
from virtualrobot.motions.setpoints import SetpointStream
from virtualrobot.robots.robot import Robot

Floats: TypeAlias = NDArray[np.float64]


AHEAD_SECONDS = 0.02
"""Time (s) by which setpoints may be ahead of a twin's own clock; the kernel allows 0.05 s at the greatest speed."""
WAIT_SECONDS = 0.05
"""Longest time (s) that a cycle waits for that clock: a controller answers its clients all the same."""
SETTLED = 1e-6
"""Distance and velocity (rad, m, per s) below which a joint of a simulated arm is at its setpoint, at rest."""


class Body(Protocol):
    """An arm that follows. One thread calls it."""

    joint_names: tuple[str, ...]
    sliding: tuple[bool, ...]
    """Mask of the joints that slide: their positions are meters."""

    @property
    def complaint(self) -> str:
        """Words that say why it follows no longer, empty as long as it does; `follow` has no effect until `recover`."""
        ...

    def read(self) -> tuple[Floats, Floats]:
        """Return positions and velocities as they are now, (k,) each."""
        ...

    def tcp(self) -> Floats | None:
        """Return the pose of its tool centre point in its base's frame, 4x4; None where nobody knows."""
        ...

    def solve(self, base_t_tcp: Floats, near: Floats) -> Floats:
        """Return the positions (k,), nearest to `near` (k,), that bring its tool centre point to a pose.

        Raises:
            VirtualRobotError: there are none, or nobody knows.
        """
        ...

    def follow(self, positions: Floats) -> None:
        """Go towards `positions` (k,), finite, until others come, as fast as the arm's limits allow."""
        ...

    def halt(self) -> None:
        """Come to rest as fast as the arm's limits allow, and follow nothing; harmless at rest."""
        ...

    def recover(self) -> None:
        """Follow again from where the arm is, after a complaint."""
        ...

    def advance(self, seconds: float) -> None:
        """Let so much time pass (s)."""
        ...

    def close(self) -> None:
        """Give back what it has; harmless more than once."""
        ...


@dataclass(frozen=True, slots=True)
class ArmLimits:
    """Limits of a simulated arm.

    Attributes:
        lower, upper: positions (k,).
        velocity, acceleration: of each joint (k,), per s and s^2, above 0.
        lag: time (s) by which it is behind a setpoint that moves on at constant speed.
    """

    lower: Floats
    upper: Floats
    velocity: Floats
    acceleration: Floats
    lag: float = 0.02

    @classmethod
    def usual(cls, joints: int, lag: float = 0.02) -> ArmLimits:
        """Return those of a mid-sized arm with `joints` rotating joints: a turn each way, 3 rad/s and 15 rad/s^2."""
        return cls(
            *(np.full(joints, value) for value in (-2.0 * np.pi, 2.0 * np.pi, 3.0, 15.0)),
            lag=lag,
        )


class SimulatedArm:
    """Arm without a kernel: each joint goes to its setpoint with a lag, and within its limits. Pure arithmetic."""

    def __init__(
        self,
        positions: Sequence[float] | Floats,
        limits: ArmLimits | None = None,
        joint_names: Sequence[str] = (),
        sliding: Sequence[bool] = (),
    ) -> None:
        """Stand at `positions` (k,), at rest."""
        self._positions = np.array(positions, dtype=np.float64)
        count = len(self._positions)
        self._velocities = np.zeros(count)
        self._limits = limits or ArmLimits.usual(count)
        self._goal: Floats | None = None
        self.joint_names = tuple(joint_names) or tuple(f"joint_{number}" for number in range(1, count + 1))
        self.sliding = tuple(sliding) or (False,) * count
        self.complaint = ""

    def read(self) -> tuple[Floats, Floats]:
        """Return positions and velocities, (k,) each."""
        return self._positions.copy(), self._velocities.copy()

    def tcp(self) -> None:
        """Know nothing of a tool: there are joints alone."""

    def solve(self, base_t_tcp: Floats, near: Floats) -> Floats:
        """Refuse poses."""
        raise UnreachableError("an arm without a kernel has joints alone, and knows no poses")

    def follow(self, positions: Floats) -> None:
        """Go towards `positions`; one outside the range of its joint is a complaint, and the arm comes to rest."""
        if self.complaint:
            return
        positions = np.array(positions, dtype=np.float64)
        outside = (positions < self._limits.lower) | (positions > self._limits.upper)
        if outside.any():
            joint = int(np.argmax(outside))
            self.complain(
                f"joint {self.joint_names[joint]} would be at {positions[joint]:g}, its range is "
                f"{self._limits.lower[joint]:g} to {self._limits.upper[joint]:g}"
            )
            return
        self._goal = positions

    def complain(self, words: str) -> None:
        """Come to rest, and follow nothing until `recover`, as after a collision or an emergency stop."""
        self.complaint = words
        self.halt()

    def halt(self) -> None:
        """Come to rest and follow nothing."""
        self._goal = None

    def recover(self) -> None:
        """Follow again."""
        self.complaint = ""

    def advance(self, seconds: float) -> None:
        """Let `seconds` pass: the velocity is that which would be at the setpoint after the lag, within the limits."""
        limits, wanted = self._limits, np.zeros_like(self._velocities)
        if self._goal is not None:
            error = self._goal - self._positions
            # From any velocity below this a joint still comes to rest at the setpoint.
            most = np.minimum(limits.velocity, np.sqrt(2.0 * limits.acceleration * np.abs(error)))
            wanted = np.clip(error / max(limits.lag, seconds), -most, most)
        change = limits.acceleration * seconds
        self._velocities += np.clip(wanted - self._velocities, -change, change)
        self._positions += self._velocities * seconds
        if self._goal is not None:
            there = (np.abs(self._goal - self._positions) < SETTLED) & (np.abs(self._velocities) < SETTLED)
            self._positions[there], self._velocities[there] = self._goal[there], 0.0

    def close(self) -> None:
        """Have nothing to give back."""


class Twin:
    """The robot in a kernel: it follows by a stream of setpoints, so that the kernel's limits and guards hold.

    What the kernel refuses, or ends the motion for (a limit, a collision, a lease), is the complaint.
    """

    def __init__(self, robot: Robot, timeout: float = 1.0, world_t_base: Floats | None = None) -> None:
        """Take a robot, which moves only once something is to be followed; its kernel's clock goes on by itself.

        It stops after `timeout` seconds of simulation time without a setpoint. `world_t_base`: where it stands, 4x4.
        """
        self._robot, self._timeout = robot, timeout
        self._base_t_world = np.eye(4) if world_t_base is None else np.linalg.inv(world_t_base)
        self._stream: SetpointStream | None = None
        self._motion: Motion | None = None
        self._closed = False
        self.joint_names = tuple(robot.joint_names)
        types = robot.joint_types
        self.sliding = tuple(types[name] == "prismatic" for name in self.joint_names)
        self.complaint = ""
        self._state = robot.state
        self._news = threading.Condition()
        self._ahead, self._since = 0.0, 0.0
        threading.Thread(target=self._watch, name=f"states of {robot.name}", daemon=True).start()

    def read(self) -> tuple[Floats, Floats]:
        """Return the newest positions and velocities that the kernel has told, (k,) each."""
        state = self._state
        return np.array(state.positions), np.array(state.velocities)

    @property
    def time(self) -> float:
        """Simulation time (s) of the newest state that the kernel has told."""
        return self._state.stamp.simulation_time

    def tcp(self) -> Floats | None:
        """Return the pose of its chosen tool centre point in its base's frame, 4x4."""
        return self._base_t_world @ self._state.world_t_tcp

    def solve(self, base_t_tcp: Floats, near: Floats) -> Floats:
        """Return the positions (k,) that the kernel finds; raises UnreachableError with its words."""
        found = self._robot.solve_inverse(base_t_tcp, near, reference=self._robot.name)
        if not found.solved:
            raise UnreachableError(found.explanation)
        positions = np.array(near)
        positions[[self.joint_names.index(name) for name in found.joint_names]] = found.solutions[0]
        return positions

    def follow(self, positions: Floats) -> None:
        """Send a setpoint; the first one opens the stream, as soon as the one before has come to rest."""
        if self.complaint:
            return
        try:
            if self._stream is None:
                self._stream = self._robot.stream("position", timeout=self._timeout)
                self._motion = self._stream.motion
            self._stream.send(positions)
        except RobotBusyError as error:
            if self._motion is None or error.metadata.get("motion") != self._motion.id:
                self.complaint = str(error)
        except VirtualRobotError as error:
            self.complaint, self._stream = str(error), None

    def halt(self) -> None:
        """End the stream, so that the robot brakes."""
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.cancel("the emulated controller stopped the robot")

    def recover(self) -> None:
        """Follow again."""
        self.complaint = ""

    @property
    def rests(self) -> bool:
        """True where the robot follows nothing, and has come to rest from what it has followed."""
        return self._stream is None and (self._motion is None or self._motion.phase.ended)

    def advance(self, seconds: float) -> None:
        """Leave time to the kernel; while it is slower than the wall clock, cycles of an arm that moves wait for it."""
        with self._news:
            now = self._state.stamp.simulation_time
            # At rest nothing tells of time, and nothing can be too fast.
            moves = self._stream is not None and np.any(self._state.velocities)
            self._ahead = max(0.0, self._ahead + seconds - (now - self._since)) if moves else 0.0
            self._since = now
            if self._ahead > AHEAD_SECONDS:
                self._news.wait(WAIT_SECONDS)

    def close(self) -> None:
        """Stop the robot if it follows."""
        self._closed = True
        self.halt()

    def _watch(self) -> None:
        try:
            for state in self._robot.watch(max_rate=250.0):
                with self._news:
                    self._state = state
                    self._news.notify_all()
                if self._closed:
                    return
        except VirtualRobotError as error:
            self.complaint = str(error)
