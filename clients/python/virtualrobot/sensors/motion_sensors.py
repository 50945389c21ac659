"""Motion sensors (inertial units, encoders, pose sensors, force and torque sensors), and what they say."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import Wrapped, pose_of, seed_of, several, value_or_default, vector_message, vector_of
from virtualrobot._wire.showing import shown
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix
from virtualrobot.v1 import sensing_pb2, sensor_pb2


class Noise(Wrapped[sensing_pb2.NoiseModel]):
    """Noise of a measured number; `noise` makes it."""

    __slots__ = ()


class MotionSensorSettings(Wrapped[sensing_pb2.MotionSensor]):
    """Kind and settings of a motion sensor; `imu`, `encoders`, `pose_sensor` and `force_torque_sensor` make them."""

    __slots__ = ()


@checked
def noise(
    deviation: float = 0.0,
    *,
    bias: float = 0.0,
    bias_walk: float = 0.0,
    resolution: float | None = None,
    limit: float | None = None,
) -> Noise:
    """Return what spoils a measured number, in its unit; each axis has noise of its own.

    Args:
        deviation: the standard deviation of the white noise of each reading.
        bias: the standard deviation of a bias that is drawn once, when the sensor starts.
        bias_walk: random walk of the bias: its standard deviation after one second.
        resolution: numbers are told in steps of this; by default as they are.
        limit: numbers beyond this, on either side, are told as this; by default there is no limit.
    """
    message = sensing_pb2.NoiseModel(
        standard_deviation=deviation,
        bias_standard_deviation=bias,
        bias_walk=bias_walk,
        resolution=value_or_default(resolution, "resolution"),
        range=value_or_default(limit, "limit"),
    )
    return Noise(message)


@checked
def imu(
    *,
    gyroscope: Noise | None = None,
    accelerometer: Noise | None = None,
    magnetometer: Noise | None = None,
    magnetic_field: ArrayLike | None = None,
    rate: float | None = None,
    seed: int = 0,
    running: bool = False,
) -> MotionSensorSettings:
    """Return an inertial unit for `scene.add_motion_sensor`.

    Args:
        gyroscope: the noise of the turning rate, rad/s.
        accelerometer: that of the acceleration, m/s^2.
        magnetometer: that of the magnetic field, tesla.
        magnetic_field: the earth's (3,) in the world's frame, tesla; None: (0, 2e-5, -4.4e-5), y is north.
        rate: readings a second of simulation time while it runs, 100 by default.
        seed: the seed of the noise.
        running: whether it reads from the start.

    Example:
        >>> unit = virtualrobot.imu(gyroscope=virtualrobot.noise(0.002, bias=0.01))
        >>> scene.add_motion_sensor("imu", unit, parent="panda.hand")
    """
    field = None if magnetic_field is None else vector_message(magnetic_field, "the magnetic field")
    kind = sensing_pb2.Imu(
        gyroscope=_noise(gyroscope),
        accelerometer=_noise(accelerometer),
        magnetometer=_noise(magnetometer),
        magnetic_field=field,
    )
    return _settings(rate, seed, running, imu=kind)


@checked
def encoders(
    joints: Iterable[str] = (),
    *,
    position: Noise | None = None,
    counts_per_turn: int | None = None,
    rate: float | None = None,
    seed: int = 0,
    running: bool = False,
) -> MotionSensorSettings:
    """Return encoders for `scene.add_motion_sensor`, on any node of the robot.

    Args:
        joints: their names; none means all that turn or slide.
        position: the noise of the positions, radians or meters.
        counts_per_turn: the steps of the encoder, instead of `position`; by default as the joints are.
        rate: readings a second of simulation time while they run, 100 by default.
        seed: the seed of the noise.
        running: whether they read from the start.
    """
    if counts_per_turn is not None and (counts_per_turn <= 0 or position is not None):
        raise InvalidArgumentError(
            f"give `position` or `counts_per_turn` (above 0), not {position!r} and {counts_per_turn}"
        )
    if counts_per_turn is not None:
        position = noise(resolution=2.0 * np.pi / counts_per_turn)
    kind = sensing_pb2.Encoders(joints=several(joints), position=_noise(position))
    return _settings(rate, seed, running, encoders=kind)


@checked
def pose_sensor(
    *,
    position: Noise | None = None,
    orientation: Noise | None = None,
    rate: float | None = None,
    seed: int = 0,
    running: bool = False,
) -> MotionSensorSettings:
    """Return a pose sensor, as a satellite receiver or a tracker, for `scene.add_motion_sensor`.

    Args:
        position: the noise of the position, meters.
        orientation: that of the orientation, as a rotation vector in radians.
        rate: readings a second of simulation time while it runs, 100 by default.
        seed: the seed of the noise.
        running: whether it reads from the start.
    """
    kind = sensing_pb2.PoseSensor(position=_noise(position), orientation=_noise(orientation))
    return _settings(rate, seed, running, pose=kind)


@checked
def force_torque_sensor(
    *,
    force: Noise | None = None,
    torque: Noise | None = None,
    include_parent: bool = False,
    rate: float | None = None,
    seed: int = 0,
    running: bool = False,
) -> MotionSensorSettings:
    """Return a force and torque sensor for `scene.add_motion_sensor`; on a flange it feels tools and parts.

    Args:
        force: the noise of the force, newton.
        torque: that of the torque, newton meters.
        include_parent: whether the load is the node that it is fixed to with all below it, as in the joint before that
            link; else it is what hangs below that node, without itself.
        rate: readings a second of simulation time while it runs, 100 by default.
        seed: the seed of the noise.
        running: whether it reads from the start.
    """
    kind = sensing_pb2.ForceTorqueSensor(force=_noise(force), torque=_noise(torque), include_parent=include_parent)
    return _settings(rate, seed, running, force_torque=kind)


def _settings(rate: float | None, seed: int, running: bool, **kind: Any) -> MotionSensorSettings:  # noqa: ANN401 one field
    hertz = value_or_default(rate, "rate")
    message = sensing_pb2.MotionSensor(rate_hertz=hertz, seed=seed_of(seed), running=running, **kind)
    return MotionSensorSettings(message)


def _noise(noise: Noise | None) -> sensing_pb2.NoiseModel | None:
    return None if noise is None else noise._message


@shown
@dataclass(frozen=True, slots=True, eq=False)
class ImuReading:
    """Reading of an inertial measurement unit in its own frame, one tick before the stamp.

    Attributes:
        angular_velocity: (3,) rad/s.
        linear_acceleration: (3,) m/s^2, less gravity's: at rest 9.81 upwards.
        magnetic_field: (3,) tesla.
    """

    angular_velocity: NDArray[np.float64]
    linear_acceleration: NDArray[np.float64]
    magnetic_field: NDArray[np.float64]


@shown
@dataclass(frozen=True, slots=True, eq=False)
class EncoderReading:
    """Reading of the encoders of k joints: names, positions (k,) in rad or m, velocities (k,) in rad/s or m/s."""

    joint_names: tuple[str, ...]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]


@shown
@dataclass(frozen=True, slots=True, eq=False)
class PoseReading:
    """Pose `world_t_node` (4, 4) of a pose sensor, and its `linear_velocity` (3,) in m/s in the world's frame."""

    world_t_node: Matrix
    linear_velocity: NDArray[np.float64]


@shown
@dataclass(frozen=True, slots=True, eq=False)
class WrenchReading:
    """Wrench of a load on a force and torque sensor, in its frame, one tick before the stamp; at rest, the weight.

    Attributes:
        force: (3,) newton.
        torque: (3,) newton meters about the sensor's origin.
    """

    force: NDArray[np.float64]
    torque: NDArray[np.float64]


def imu_reading_of(message: sensor_pb2.ImuReading) -> ImuReading:
    """Return what an inertial unit said from a message."""
    return ImuReading(
        vector_of(message.angular_velocity), vector_of(message.linear_acceleration), vector_of(message.magnetic_field)
    )


def encoder_reading_of(message: sensor_pb2.EncoderReading) -> EncoderReading:
    """Return what encoders said from a message."""
    return EncoderReading(tuple(message.joint_names), np.array(message.positions), np.array(message.velocities))


def pose_reading_of(message: sensor_pb2.PoseReading) -> PoseReading:
    """Return what a pose sensor said from a message."""
    return PoseReading(pose_of(message.world_t_node), vector_of(message.linear_velocity))


def wrench_reading_of(message: sensor_pb2.WrenchReading) -> WrenchReading:
    """Return what a force and torque sensor said from a message."""
    return WrenchReading(vector_of(message.force), vector_of(message.torque))
