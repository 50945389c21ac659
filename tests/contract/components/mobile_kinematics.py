"""A craft with two driven wheels, exact; wrong ones of the same build."""

from __future__ import annotations

import numpy as np
from virtualrobot_sdk.arguments import orthonormalise
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats

WHEEL_RADIUS = 0.1
TRACK = 0.5
"""Distance of the wheels (m)."""


class DifferentialDrive:
    """Moves on exact arcs (Siegwart and Nourbakhsh, Introduction to Autonomous Mobile Robots, 3.2)."""

    drive_names = ("left_wheel", "right_wheel")
    passive_names = ()

    def step(
        self, world_t_base: Floats, drive_states: Floats, commands: Floats, seconds: float, /
    ) -> tuple[Floats, Floats]:
        self.check(world_t_base, drive_states, commands, seconds)
        left, right = WHEEL_RADIUS * commands * seconds
        way, turn = (left + right) / 2.0, (right - left) / TRACK
        return self.moved(world_t_base, way, turn), drive_states + commands * seconds

    def passive_states(
        self, passive_states: Floats, drive_states: Floats, commands: Floats, seconds: float, /
    ) -> Floats:
        return passive_states.copy()

    def base_twist(self, drive_states: Floats, commands: Floats, /) -> Floats:
        self.check(np.eye(4), drive_states, commands, 1.0)
        left, right = WHEEL_RADIUS * commands
        return np.array([(left + right) / 2.0, 0.0, (right - left) / TRACK])

    def drive_commands(self, twist: Floats, drive_states: Floats, seconds: float, /) -> Floats:
        self.check_twist(twist)
        vx, _, omega = twist
        return np.array([vx - omega * TRACK / 2.0, vx + omega * TRACK / 2.0]) / WHEEL_RADIUS

    def check_twist(self, twist: Floats) -> None:
        """Refuse what is none, and what its wheels cannot do."""
        if twist.shape != (3,) or not np.isfinite(twist).all() or twist[1]:
            raise ArgumentError(f"the twist is {twist.tolist()}; it must be three finite numbers, the second one 0")

    def moved(self, pose: Floats, way: float, turn: float) -> Floats:
        """Return the pose after an arc of this length (m) and angle (rad)."""
        # The chord, sinc so that no turn is no special case.
        chord = way * np.sinc(turn / (2.0 * np.pi))
        return pose @ planar(chord * np.cos(turn / 2.0), chord * np.sin(turn / 2.0), turn)

    def check(self, pose: Floats, states: Floats, commands: Floats, seconds: float) -> None:
        """Refuse what makes no sense."""
        if pose.shape != (4, 4) or orthonormalise(pose.copy()) > 1e-6:
            raise ArgumentError(f"the base's pose {pose.tolist()} is not rigid")
        for what, values in (("states", states), ("commands", commands)):
            if values.shape != (2,) or not np.isfinite(values).all():
                raise ArgumentError(f"{what} are {values.tolist()}; two finite numbers are needed")
        if not 0.0 < seconds < np.inf:
            raise ArgumentError(f"seconds is {seconds}; it must be a finite number above 0")


def planar(x: float, y: float, turn: float) -> Floats:
    """Return a pose in the plane."""
    c, s = np.cos(turn), np.sin(turn)
    return np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, 0], [0, 0, 0, 1.0]])


class Euler(DifferentialDrive):
    """Wrong for the default tolerance: goes straight, then turns (Euler's method)."""

    def moved(self, pose: Floats, way: float, turn: float) -> Floats:
        return pose @ planar(way, 0.0, turn)


class WorldFrame(DifferentialDrive):
    """Wrong: moves along the world's axes whatever its heading."""

    def moved(self, pose: Floats, way: float, turn: float) -> Floats:
        after = pose @ planar(0.0, 0.0, turn)
        after[0, 3] += way
        return after


class Drifts(DifferentialDrive):
    """Wrong: turns by itself."""

    def moved(self, pose: Floats, way: float, turn: float) -> Floats:
        return super().moved(pose, way, turn + 1e-4)


class SmallAngles(DifferentialDrive):
    """Wrong: turns by the first terms of sine and cosine, which no rotation is made of."""

    def moved(self, pose: Floats, way: float, turn: float) -> Floats:
        return pose @ np.array([[1, -turn, 0, way], [turn, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])


class Backwards(DifferentialDrive):
    """Wrong: its wheels turn against what they are told."""

    def step(
        self, world_t_base: Floats, drive_states: Floats, commands: Floats, seconds: float, /
    ) -> tuple[Floats, Floats]:
        pose, _ = super().step(world_t_base, drive_states, commands, seconds)
        return pose, drive_states - commands * seconds


class Inertia(DifferentialDrive):
    """Wrong: keeps some of the speed of the call before."""

    def __init__(self) -> None:
        """Begin at rest."""
        self.turn = 0.0

    def moved(self, pose: Floats, way: float, turn: float) -> Floats:
        self.turn = 0.5 * self.turn + 0.5 * turn
        return super().moved(pose, way, self.turn)


class Skates(DifferentialDrive):
    """Wrong: says nothing of a twist to the side, and doesn't make it."""

    def check_twist(self, twist: Floats) -> None:
        pass


class Degrees(DifferentialDrive):
    """Wrong: tells its turning in degrees."""

    def base_twist(self, drive_states: Floats, commands: Floats, /) -> Floats:
        vx, vy, omega = super().base_twist(drive_states, commands)
        return np.array([vx, vy, np.degrees(omega)])


class Flutters(DifferentialDrive):
    """Wrong: its passive wheel turns by itself."""

    passive_names = ("caster",)

    def passive_states(
        self, passive_states: Floats, drive_states: Floats, commands: Floats, seconds: float, /
    ) -> Floats:
        return passive_states + 0.1 * seconds


class Unchecked(DifferentialDrive):
    """Wrong: takes anything."""

    def check(self, pose: Floats, states: Floats, commands: Floats, seconds: float) -> None:
        pass
