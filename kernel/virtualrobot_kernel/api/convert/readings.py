"""Readings of sensors to messages."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from virtualrobot.v1 import geometry_pb2, sensor_pb2

from virtualrobot_kernel.api.convert.readings_camera import fill_camera
from virtualrobot_kernel.messages.codecs import NUMBERS, EnumTable
from virtualrobot_kernel.messages.sensing import IMAGE_KINDS
from virtualrobot_kernel.messages.table import OneOf, Table
from virtualrobot_kernel.messages.values import array_message, check_enum, pose_message, stamp
from virtualrobot_kernel.sensing.camera_reader import CameraContent
from virtualrobot_kernel.sensing.contact_content import Contact, ContactContent
from virtualrobot_kernel.sensing.motion_content import EncoderContent, ImuContent, PoseContent, WrenchContent
from virtualrobot_kernel.sensing.range_content import RangeContent
from virtualrobot_kernel.sensing.reading import Reading, SensorState
from virtualrobot_kernel.world.sensing import ImageKind
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

LARGE = 10_000
"""Number of beams or pixels from which a reading counts as large."""
FLOAT32 = geometry_pb2.NUMERIC_TYPE_FLOAT32

STATES = EnumTable(SensorState, sensor_pb2.SensorState)
CONTENT = OneOf(
    "content",
    contact=Table(ContactContent, sensor_pb2.ContactReading, contacts=Table(Contact, sensor_pb2.Contact)),
    imu=Table(ImuContent, sensor_pb2.ImuReading),
    encoders=Table(EncoderContent, sensor_pb2.EncoderReading, positions=NUMBERS, velocities=NUMBERS),
    pose=Table(PoseContent, sensor_pb2.PoseReading),
    wrench=Table(WrenchContent, sensor_pb2.WrenchReading),
)
"""Contents that are small and told whole."""


def checked_options(options: sensor_pb2.ReadingOptions) -> tuple[ImageKind, ...] | None:
    """Return the kinds of pictures that are asked for, None for those that the camera is set to.

    Raises KernelError for a frame or a kind that the contract does not name.
    """
    check_enum(options, "frame")
    return tuple(IMAGE_KINDS.read(kind, "options.images") for kind in options.images) or None


def fill_reading(message: sensor_pb2.SensorReading, reading: Reading, options: sensor_pb2.ReadingOptions) -> None:
    """Fill an empty message in with a reading, and what the options ask for."""
    message.stamp.CopyFrom(stamp(reading.snapshot))
    message.sensor, message.fault = reading.name, reading.fault
    message.state = STATES.write(reading.state)
    message.number, message.missed = reading.number, reading.missed
    message.world_t_sensor.CopyFrom(pose_message(reading.world_t_sensor))
    content = reading.content
    if isinstance(content, RangeContent):
        _fill_range(message.range, content, reading, options)
    elif isinstance(content, CameraContent):
        fill_camera(message.camera, content, options.images)
    elif content is not None:
        for field, told in CONTENT.write(content).items():
            getattr(message, field).CopyFrom(told)


def is_large(reading: Reading) -> bool:
    """Return whether a reading's message is so large that making it takes time."""
    content = reading.content
    if isinstance(content, RangeContent):
        return content.distances.size > LARGE
    return isinstance(content, CameraContent) and len(content.lens.directions) > LARGE


def content_bytes(reading: Reading | None) -> int:
    """Return about how many bytes a reading keeps."""
    content = reading.content if reading is not None else None
    if isinstance(content, RangeContent):
        return 32 * content.distances.size
    return 32 * len(content.lens.directions) if isinstance(content, CameraContent) else 1000


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


def _fill_range(
    told: sensor_pb2.RangeReading, content: RangeContent, reading: Reading, options: sensor_pb2.ReadingOptions
) -> None:
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
