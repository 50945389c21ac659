"""A buoy with a thruster and a fin, exact and in plain NumPy; wrong ones of the same build."""

from __future__ import annotations

import math

import numpy as np
from virtualrobot_sdk.arguments import orthonormalise
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.poses import rotation_matrix, skew
from virtualrobot_sdk.vehicles import DriveQuantity, Surroundings, VehicleDrive

LAG = 0.2
"""Time constant of both drives (s)."""
DRAG = np.array([0.8, 0.8, 0.8, 1.5, 1.5, 1.5])
"""Deceleration by damping, as part of the velocity (1/s)."""
PUSH = 0.05
"""Acceleration by the thruster's speed (m/s^2 a rad/s)."""
YAW = 0.4
"""Angular acceleration by the fin's angle (rad/s^2 a rad)."""
PARTS = 20
"""Parts of a step, whose midpoints are reckoned with."""


class Buoy:
    """A ball without weight: linear damping along the world's axes, a thruster along x, a fin that turns it about z."""

    drives = (
        VehicleDrive("thruster", DriveQuantity.SPEED, -10.0, 10.0),
        VehicleDrive("fin", DriveQuantity.POSITION, -0.5, 0.5),
    )

    def step(
        self,
        world_t_base: Floats,
        twist: Floats,
        drive_states: Floats,
        commands: Floats,
        seconds: float,
        surroundings: Surroundings,
        /,
    ) -> tuple[Floats, Floats, Floats]:
        self.check(world_t_base, twist, drive_states, commands, seconds, surroundings)
        pose, state = world_t_base.copy(), drive_states
        flow = self.flow(surroundings)
        velocity = pose[:3, :3] @ twist[:3] - flow
        turning = twist[3:].copy()
        dt = seconds / PARTS
        for _ in range(PARTS):
            middle = self.follow(state, commands, dt / 2)
            state = self.follow(middle, commands, dt / 2)
            half = pose[:3, :3] @ rotation_matrix(turning * dt / 2)
            push = PUSH * middle[0] * half[:, 0]
            force = self.slowing(velocity) + push
            lift = np.array([0.0, 0.0, YAW * middle[1]])
            velocity_middle = velocity + dt / 2 * force
            turning_middle = turning + dt / 2 * (lift - DRAG[3:] * turning)
            velocity = velocity + dt * (self.slowing(velocity_middle) + push)
            turning = turning + dt * (lift - DRAG[3:] * turning_middle)
            pose[:3, 3] += dt * (velocity_middle + flow)
            pose[:3, :3] = self.turned(pose[:3, :3], turning_middle * dt)
        orthonormalise(pose)
        return pose, np.append(pose[:3, :3].T @ (velocity + flow), turning), state

    def flow(self, surroundings: Surroundings) -> Floats:
        return np.array(surroundings.current)

    def slowing(self, velocity: Floats) -> Floats:
        return -DRAG[:3] * velocity

    def follow(self, state: Floats, commands: Floats, seconds: float) -> Floats:
        return commands + (state - commands) * math.exp(-seconds / LAG)

    def turned(self, rotation: Floats, by: Floats) -> Floats:
        return rotation @ rotation_matrix(by)

    def check(
        self, pose: Floats, twist: Floats, states: Floats, commands: Floats, seconds: float, water: Surroundings
    ) -> None:
        """Refuse what makes no sense."""
        if pose.shape != (4, 4) or orthonormalise(pose.copy()) > 1e-6:
            raise ArgumentError(f"the base's pose {pose.tolist()} is not rigid")
        for what, values, count in (("twist", twist, 6), ("states", states, 2), ("commands", commands, 2)):
            if values.shape != (count,) or not np.isfinite(values).all():
                raise ArgumentError(f"{what} are {values.tolist()}; {count} finite numbers are needed")
        for drive, value in zip(self.drives, commands, strict=True):
            if not drive.lowest <= value <= drive.highest:
                raise ArgumentError(f"{drive.name} is told {value}; it takes {drive.lowest} to {drive.highest}")
        if not 0.0 < seconds < math.inf:
            raise ArgumentError(f"seconds is {seconds}; it must be a finite number above 0")
        numbers = [*water.current, water.density, water.surface, water.gravity]
        if not np.isfinite(numbers).all() or water.density <= 0.0 or water.gravity < 0.0:
            raise ArgumentError(f"the surroundings are {water}")


class Overshoots(Buoy):
    """Wrong: its drives go past their commands."""

    def follow(self, state: Floats, commands: Floats, seconds: float) -> Floats:
        return commands + 0.01


class Coarse(Buoy):
    """Wrong for the default tolerance: its damping is that of the time before (a step counts by its length)."""

    def step(
        self,
        world_t_base: Floats,
        twist: Floats,
        drive_states: Floats,
        commands: Floats,
        seconds: float,
        surroundings: Surroundings,
        /,
    ) -> tuple[Floats, Floats, Floats]:
        pose, after, states = super().step(world_t_base, twist, drive_states, commands, seconds, surroundings)
        return pose, after + 0.1 * seconds**2 * twist, states


class Idle(Buoy):
    """Wrong: what its drives are told moves nothing."""

    def step(
        self,
        world_t_base: Floats,
        twist: Floats,
        drive_states: Floats,
        commands: Floats,
        seconds: float,
        surroundings: Surroundings,
        /,
    ) -> tuple[Floats, Floats, Floats]:
        told = super().step(world_t_base, twist, drive_states, commands, seconds, surroundings)
        still = super().step(world_t_base, twist, 0.0 * drive_states, 0.0 * commands, seconds, surroundings)
        return still[0], still[1], told[2]


class NorthernDrag(Buoy):
    """Wrong: the world's x slows it more than y."""

    def slowing(self, velocity: Floats) -> Floats:
        return -np.array([1.6, 0.8, 0.8]) * velocity


class StillWater(Buoy):
    """Wrong: its damping knows no current, so that it is not carried along."""

    def flow(self, surroundings: Surroundings) -> Floats:
        return 0.5 * np.array(surroundings.current)


class Restless(Buoy):
    """Wrong: goes on by itself."""

    def slowing(self, velocity: Floats) -> Floats:
        return -DRAG[:3] * (velocity - np.array([0.0, 0.0, 1.0]))


class SmallAngles(Buoy):
    """Wrong: turns by the first terms of sine and cosine, which no rotation is made of."""

    def step(
        self,
        world_t_base: Floats,
        twist: Floats,
        drive_states: Floats,
        commands: Floats,
        seconds: float,
        surroundings: Surroundings,
        /,
    ) -> tuple[Floats, Floats, Floats]:
        pose, after, states = super().step(world_t_base, twist, drive_states, commands, seconds, surroundings)
        pose[:3, :3] = world_t_base[:3, :3] @ (np.eye(3) + skew(after[3:] * seconds))
        return pose, after, states


class Inertia(Buoy):
    """Wrong: keeps some of the call before."""

    def __init__(self) -> None:
        """Begin at rest."""
        self.last = 0.0

    def slowing(self, velocity: Floats) -> Floats:
        before, self.last = self.last, float(velocity[0])
        return super().slowing(velocity) + 1e-6 * before


class Unchecked(Buoy):
    """Wrong: takes anything."""

    def check(
        self, pose: Floats, twist: Floats, states: Floats, commands: Floats, seconds: float, water: Surroundings
    ) -> None:
        pass


def unlike_names() -> Buoy:
    """Return one whose drives have one name."""
    buoy = Buoy()
    buoy.drives = (Buoy.drives[0], Buoy.drives[0])  # pyright: ignore[reportAttributeAccessIssue]
    return buoy
