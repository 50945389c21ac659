"""Sensors and lights as parts of the tree: frozen settings, with the contract's names and meanings of their fields.

Lengths in meters, angles in radians, rates in hertz of simulation time. A 0 or None that the contract calls "not said"
stays so here: `virtualrobot_kernel.sensing.settings` fills it in.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

Vector = tuple[float, float, float]


class Projection(Enum):
    """Projection of a camera; the values are the contract's numbers, as in all enums here."""

    PINHOLE = 1
    FISHEYE = 2
    SPHERICAL = 3


class ImageKind(Enum):
    """Quantity of a picture's pixels."""

    COLOR = 1
    DEPTH = 2
    SEGMENTATION = 3
    NORMALS = 4


class LightKind(Enum):
    """Kind of light source."""

    POINT = 1
    SPOT = 2
    DIRECTIONAL = 3


@dataclass(frozen=True, slots=True)
class SingleBeam:
    """One beam along x."""


@dataclass(frozen=True, slots=True)
class Fan:
    """Beams in the plane z = 0 at equal steps of angle, from x towards y; both ends are cast."""

    count: int
    start_angle_radians: float
    end_angle_radians: float


@dataclass(frozen=True, slots=True)
class Spinning:
    """Head with beams above each other that turns once about z, from -x over -y, x and y."""

    columns: int
    elevations_radians: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Raster:
    """Beams as the pixels of a picture whose middle is x, from the upper left, at equal steps of angle."""

    columns: int
    rows: int
    horizontal_field_radians: float
    vertical_field_radians: float


@dataclass(frozen=True, slots=True)
class Ring:
    """Transducers on a circle in the plane z = 0, looking outwards."""

    count: int
    radius_meters: float
    start_angle_radians: float
    end_angle_radians: float


@dataclass(frozen=True, slots=True, eq=False)
class FreeBeams:
    """Any beams: `directions` (n, 3) of any length but zero; `origins` (n, 3), or None where all begin at (0, 0, 0)."""

    directions: NDArray[np.float64]
    origins: NDArray[np.float64] | None = None


Pattern = SingleBeam | Fan | Spinning | Raster | Ring | FreeBeams


@dataclass(frozen=True, slots=True, eq=False)
class RangeSensor:
    """Range sensor: measures distances (m) by rays, along x of its node, z up."""

    preset: str = ""
    pattern: Pattern | None = None
    rate_hertz: float = 0.0
    min_range_meters: float | None = None
    max_range_meters: float | None = None
    ray_caster: str = ""
    ray_caster_settings: Mapping[str, Any] | None = None
    sensor_model: str = ""
    sensor_model_settings: Mapping[str, Any] | None = None
    seed: int = 0
    motion_distortion: bool = False


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """Focal lengths and middle in pixels; the middle of the upper left pixel is (0, 0)."""

    fx: float
    fy: float
    cx: float
    cy: float


@dataclass(frozen=True, slots=True, eq=False)
class CameraSensor:
    """Camera: takes pictures, looking along z of its node, x to the right and y down."""

    width: int = 0
    height: int = 0
    projection: Projection = Projection.PINHOLE
    horizontal_field_radians: float = 0.0
    intrinsics: Intrinsics | None = None
    distortion: tuple[float, ...] = ()
    near_meters: float = 0.0
    far_meters: float = 0.0
    rate_hertz: float = 0.0
    images: tuple[ImageKind, ...] = ()
    color_noise: float = 0.0
    depth_noise_meters: float = 0.0
    seed: int = 0
    stereo_baseline_meters: float = 0.0
    water_attenuation_per_meter: Vector | None = None
    water_color: tuple[float, float, float, float] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ContactSensor:
    """Sensor of things near or at a node (`watched`, empty: the sensor's parent) and all below it; nodes by name."""

    watched: str = ""
    range_meters: float = 0.0
    region_size: Vector | None = None
    ignored: tuple[str, ...] = ()
    rate_hertz: float = 0.0


@dataclass(frozen=True, slots=True)
class NoiseModel:
    """Noise of a measured number, in its unit; a bias walks by `bias_walk` per square root of a second."""

    standard_deviation: float = 0.0
    bias_standard_deviation: float = 0.0
    bias_walk: float = 0.0
    resolution: float = 0.0
    range: float = 0.0


@dataclass(frozen=True, slots=True)
class Imu:
    """Turning rate (rad/s), acceleration (m/s^2) and magnetic field (tesla) in the node's frame."""

    gyroscope: NoiseModel = NoiseModel()
    accelerometer: NoiseModel = NoiseModel()
    magnetometer: NoiseModel = NoiseModel()
    magnetic_field: Vector | None = None


@dataclass(frozen=True, slots=True)
class Encoders:
    """Positions and speeds of joints (empty: all) of the robot that the node belongs to."""

    joints: tuple[str, ...] = ()
    position: NoiseModel = NoiseModel()


@dataclass(frozen=True, slots=True)
class PoseSensor:
    """Pose of the node in the world's frame; the orientation's noise is a rotation vector."""

    position: NoiseModel = NoiseModel()
    orientation: NoiseModel = NoiseModel()


@dataclass(frozen=True, slots=True)
class ForceTorqueSensor:
    """Force (N) and torque (N m) that its load puts on it, in the node's frame; the parent may be part of the load."""

    force: NoiseModel = NoiseModel()
    torque: NoiseModel = NoiseModel()
    include_parent: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class MotionSensor:
    """Sensor of the motion of its node, or of the node's robot."""

    kind: Imu | Encoders | PoseSensor | ForceTorqueSensor = field(default_factory=Imu)
    rate_hertz: float = 0.0
    seed: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Light:
    """Light for cameras; spots and directional ones shine along z of their node. Colour as red, green, blue."""

    kind: LightKind = LightKind.POINT
    color: tuple[float, float, float, float] | None = None
    intensity: float = 0.0
    cone_angle_radians: float = 0.0
    shadowless: bool = False


Sensor = RangeSensor | CameraSensor | ContactSensor | MotionSensor
