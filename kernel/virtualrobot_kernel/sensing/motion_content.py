"""Readings of motion sensors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class ImuContent:
    """Of an inertial unit, each (3,) in the sensor's frame: rad/s, m/s^2 (less gravity's), tesla."""

    angular_velocity: Floats
    linear_acceleration: Floats
    magnetic_field: Floats


@dataclass(frozen=True, slots=True, eq=False)
class EncoderContent:
    """Of encoders: the joints (k), positions (k,) in radians or meters, and velocities (k,) per second."""

    joint_names: tuple[str, ...]
    positions: Floats
    velocities: Floats


@dataclass(frozen=True, slots=True, eq=False)
class PoseContent:
    """Of a pose sensor: its pose (4, 4) and velocity (3,) in m/s, both in the world's frame."""

    world_t_node: Floats
    linear_velocity: Floats


@dataclass(frozen=True, slots=True, eq=False)
class WrenchContent:
    """Of a force and torque sensor: force (3,) in N and torque (3,) in N m about its origin, in its frame."""

    force: Floats
    torque: Floats


MotionContent = ImuContent | EncoderContent | PoseContent | WrenchContent
