"""Sensors and lights: messages to frozen settings and back."""

from __future__ import annotations

from typing import Any, TypeVar

from google.protobuf.message import Message
from virtualrobot.v1 import sensing_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import Codec, EnumTable, Pair, rows
from virtualrobot_kernel.messages.sensing_limits import CHECKS
from virtualrobot_kernel.messages.table import OneOf, Table
from virtualrobot_kernel.messages.values import GREATEST, finite, not_negative
from virtualrobot_kernel.world import sensing

V = TypeVar("V")
M = TypeVar("M", bound=Message)


def _signed(value: float, what: str) -> float:
    if not abs(finite(value, what)) <= GREATEST:
        raise KernelError(f"{what} must be at most {GREATEST:g} in size, not {value:g}", field=what, value=value)
    return value


def _same(value: object) -> object:
    return value


SIGNED = Pair(_signed, _same)
AMOUNT = Pair(lambda value, what: _signed(not_negative(value, what), what), _same)


def _table(made: type[V], message: type[M], /, *without: str, **codecs: Codec | OneOf) -> Table[V, M]:
    """Return the table of a class whose numbers are 0 or above, where no codec says that they may be below."""
    return Table(made, message, names=None, without=without, numbers=AMOUNT, check=CHECKS.get(made), **codecs)


BEAMS = rows(None, 3)
PATTERN = OneOf(
    "pattern",
    beam=_table(sensing.SingleBeam, sensing_pb2.SingleBeam),
    fan=_table(sensing.Fan, sensing_pb2.Fan, start_angle_radians=SIGNED, end_angle_radians=SIGNED),
    spinning=_table(sensing.Spinning, sensing_pb2.Spinning, elevations_radians=SIGNED),
    raster=_table(sensing.Raster, sensing_pb2.Raster),
    ring=_table(sensing.Ring, sensing_pb2.Ring, start_angle_radians=SIGNED, end_angle_radians=SIGNED),
    free=_table(sensing.FreeBeams, sensing_pb2.FreeBeams, directions=BEAMS, origins=BEAMS),
)
RANGE_SENSOR = _table(
    sensing.RangeSensor,
    sensing_pb2.RangeSensor,
    "running",
    pattern=Pair(PATTERN.read, lambda pattern: sensing_pb2.ScanPattern(**PATTERN.write(pattern))),
)
INTRINSICS = _table(sensing.Intrinsics, sensing_pb2.CameraIntrinsics, cx=SIGNED, cy=SIGNED)
PROJECTIONS = EnumTable(sensing.Projection, sensing_pb2.CameraProjection)
IMAGE_KINDS = EnumTable(sensing.ImageKind, sensing_pb2.ImageKind)
NOISE = _table(sensing.NoiseModel, sensing_pb2.NoiseModel)

SENSORS: dict[str, Table[Any, Any]] = {
    "range_sensor": RANGE_SENSOR,
    "camera_sensor": _table(
        sensing.CameraSensor,
        sensing_pb2.CameraSensor,
        "running",
        projection=PROJECTIONS,
        intrinsics=INTRINSICS,
        distortion=SIGNED,
        images=IMAGE_KINDS,
    ),
    "contact_sensor": _table(sensing.ContactSensor, sensing_pb2.ContactSensor, "running"),
    "motion_sensor": _table(
        sensing.MotionSensor,
        sensing_pb2.MotionSensor,
        "running",
        kind=OneOf(
            "kind",
            imu=_table(sensing.Imu, sensing_pb2.Imu, gyroscope=NOISE, accelerometer=NOISE, magnetometer=NOISE),
            encoders=_table(sensing.Encoders, sensing_pb2.Encoders, position=NOISE),
            pose=_table(sensing.PoseSensor, sensing_pb2.PoseSensor, position=NOISE, orientation=NOISE),
            force_torque=_table(sensing.ForceTorqueSensor, sensing_pb2.ForceTorqueSensor, force=NOISE, torque=NOISE),
        ),
    ),
    "light": _table(sensing.Light, sensing_pb2.Light, kind=EnumTable(sensing.LightKind, sensing_pb2.LightKind)),
}
"""Tables of sensors and lights, by their fields in `Node`."""
