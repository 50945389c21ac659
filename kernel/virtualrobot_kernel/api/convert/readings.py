"""Readings of sensors to messages; each kind of content has its own function in `CONTENTS`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot.v1 import geometry_pb2, sensor_pb2

from virtualrobot_kernel.api.convert.readings_camera import fill_camera
from virtualrobot_kernel.api.convert.readings_contact import contact_reading_message
from virtualrobot_kernel.api.convert.readings_motion import (
    encoder_message,
    imu_message,
    pose_reading_message,
    wrench_message,
)
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.values import array_message, check_enum, pose_message, stamp
from virtualrobot_kernel.sensing.camera_reader import CameraContent
from virtualrobot_kernel.sensing.contact_content import ContactContent
from virtualrobot_kernel.sensing.motion_content import EncoderContent, ImuContent, PoseContent, WrenchContent
from virtualrobot_kernel.sensing.range_content import RangeContent
from virtualrobot_kernel.sensing.reading import Reading
from virtualrobot_kernel.world.sensing import ImageKind
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

LARGE = 10_000
"""Number of beams or pixels from which a reading counts as large."""
FLOAT32 = geometry_pb2.NUMERIC_TYPE_FLOAT32

Filler = Callable[[sensor_pb2.SensorReading, Reading, sensor_pb2.ReadingOptions], None]


def checked_options(options: sensor_pb2.ReadingOptions) -> tuple[ImageKind, ...] | None:
    """Return the kinds of pictures that are asked for, None for those that the camera is set to.

    Raises KernelError for a frame or a kind that the contract does not name.
    """
    check_enum(options, "frame")
    for number in options.images:
        if number not in (kind.value for kind in ImageKind):
            names = ", ".join(f"IMAGE_KIND_{kind.name}" for kind in ImageKind)
            raise KernelError(f"options.images holds {number}; give some of {names}", field="images", value=number)
    return tuple(map(ImageKind, options.images)) or None


def fill_reading(message: sensor_pb2.SensorReading, reading: Reading, options: sensor_pb2.ReadingOptions) -> None:
    """Fill an empty message in with a reading, and what the options ask for."""
    message.stamp.CopyFrom(stamp(reading.snapshot))
    message.sensor, message.fault = reading.name, reading.fault
    message.state = reading.state.value  # pyright: ignore[reportAttributeAccessIssue] the values are the contract's
    message.number, message.missed = reading.number, reading.missed
    message.world_t_sensor.CopyFrom(pose_message(reading.world_t_sensor))
    if reading.content is not None:
        CONTENTS[type(reading.content)](message, reading, options)


def is_large(reading: Reading) -> bool:
    """Return whether a reading's message is so large that making it takes time."""
    content = reading.content
    if isinstance(content, RangeContent):
        return content.distances.size > LARGE
    return isinstance(content, CameraContent) and len(content.lens.directions) > LARGE


def robot_of(snapshot: Snapshot, uid: int) -> int:
    """Return the robot that a node belongs to (a uid), 0 where there is none."""
    nodes = snapshot.structure.nodes
    while uid and nodes[uid].kind is not Kind.ROBOT:
        uid = nodes[uid].parent
    return uid


def frame_t_sensor(reading: Reading, frame: sensor_pb2.ReadingFrame) -> NDArray[np.float64]:
    """Return the sensor's pose (4, 4) in the frame that points are asked for in."""
    if frame == sensor_pb2.READING_FRAME_WORLD:
        return reading.world_t_sensor
    if frame == sensor_pb2.READING_FRAME_ROBOT:
        robot = robot_of(reading.snapshot, reading.uid)
        world_t_robot = reading.snapshot.world_t(robot) if robot else np.eye(4)
        return np.linalg.inv(world_t_robot) @ reading.world_t_sensor
    return np.eye(4)


def _range(message: sensor_pb2.SensorReading, reading: Reading, options: sensor_pb2.ReadingOptions) -> None:
    content, told = reading.content, message.range
    assert isinstance(content, RangeContent)
    told.distances.CopyFrom(array_message(content.distances, FLOAT32))
    told.valid.CopyFrom(array_message(content.valid, geometry_pb2.NUMERIC_TYPE_UINT8))
    told.frame = options.frame or sensor_pb2.READING_FRAME_SENSOR
    if options.intensities:
        told.intensities.CopyFrom(array_message(content.intensities, FLOAT32))
    if options.elements:
        told.elements.CopyFrom(array_message(content.elements, geometry_pb2.NUMERIC_TYPE_INT32))
        told.element_names.extend(content.element_names)
    if options.points:
        told.points.CopyFrom(array_message(content.points(frame_t_sensor(reading, options.frame)), FLOAT32))
    if content.ages is not None:
        told.ages.CopyFrom(array_message(content.ages, FLOAT32))


def _camera(message: sensor_pb2.SensorReading, reading: Reading, options: sensor_pb2.ReadingOptions) -> None:
    assert isinstance(reading.content, CameraContent)
    fill_camera(message.camera, reading.content, options.images)


def _contact(message: sensor_pb2.SensorReading, reading: Reading, options: sensor_pb2.ReadingOptions) -> None:
    assert isinstance(reading.content, ContactContent)
    message.contact.CopyFrom(contact_reading_message(reading.content))


def _imu(message: sensor_pb2.SensorReading, reading: Reading, options: sensor_pb2.ReadingOptions) -> None:
    assert isinstance(reading.content, ImuContent)
    message.imu.CopyFrom(imu_message(reading.content))


def _encoders(message: sensor_pb2.SensorReading, reading: Reading, options: sensor_pb2.ReadingOptions) -> None:
    assert isinstance(reading.content, EncoderContent)
    message.encoders.CopyFrom(encoder_message(reading.content))


def _pose(message: sensor_pb2.SensorReading, reading: Reading, options: sensor_pb2.ReadingOptions) -> None:
    assert isinstance(reading.content, PoseContent)
    message.pose.CopyFrom(pose_reading_message(reading.content))


def _wrench(message: sensor_pb2.SensorReading, reading: Reading, options: sensor_pb2.ReadingOptions) -> None:
    assert isinstance(reading.content, WrenchContent)
    message.wrench.CopyFrom(wrench_message(reading.content))


CONTENTS: dict[type[Any], Filler] = {
    RangeContent: _range,
    CameraContent: _camera,
    ContactContent: _contact,
    ImuContent: _imu,
    EncoderContent: _encoders,
    PoseContent: _pose,
    WrenchContent: _wrench,
}
"""Function by the class of a content that fills in a reading's message."""
