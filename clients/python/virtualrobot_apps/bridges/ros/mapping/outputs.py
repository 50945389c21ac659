"""Outputs of streams: topics with their types, conventional names, and how a sample becomes a message."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TypeAlias

import numpy as np
from virtualrobot._wire.messages import array_of
from virtualrobot.recording import topics as streams
from virtualrobot.streams.sample import Sample
from virtualrobot.streams.scans import ScanGeometry
from virtualrobot.streams.table import Stream
from virtualrobot.v1 import sensing_pb2, sensor_pb2

from virtualrobot_apps.bridges.ros.mapping import robots, sensors
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue
from virtualrobot_apps.bridges.ros.mapping.names import FrameNames, topic_name

Make: TypeAlias = Callable[[Sample], RosValue | None]

REST_NANOSECONDS = 20_000_000
"""Time (ns) after which what has not changed is told again, with a new stamp: late readers of frames need it."""

_IMAGES = {
    "color": (sensing_pb2.IMAGE_KIND_COLOR, "", "rgb8"),
    "depth": (sensing_pb2.IMAGE_KIND_DEPTH, "depth", "32FC1"),
    "segmentation": (sensing_pb2.IMAGE_KIND_SEGMENTATION, "segmentation", "32SC1"),
    "normals": (sensing_pb2.IMAGE_KIND_NORMALS, "normals", "32FC3"),
}
"""Kind, part of the name, and encoding of pictures, by content."""


@dataclass(frozen=True, slots=True)
class Output:
    """A topic that comes of a stream.

    Attributes:
        stream: name of the stream.
        topic: conventional name.
        type: type of its messages.
        make: gives the message of a sample, None where it has none.
        automatic: whether it is published without being asked for in a file.
        latched: whether who comes later gets the last one.
        reliable: False for sensor data, of which the newest counts.
        lazy: whether its stream is watched only while somebody reads it.
        same: tells whether two samples say the same; then the second one is left out, unless the first is 20 ms old.
    """

    stream: str
    topic: str
    type: str
    make: Make
    automatic: bool = True
    latched: bool = False
    reliable: bool = True
    lazy: bool = True
    same: Callable[[Sample, Sample], bool] | None = None


@dataclass(frozen=True, slots=True)
class Naming:
    """Knowledge of a world that names and messages need.

    Attributes:
        frames: names of frames.
        geometry: geometry of a range sensor by its name.
        bases: of robots whose base moves: the frame that it moves in, and the one that moves.
    """

    frames: FrameNames
    geometry: Callable[[str], ScanGeometry]
    bases: dict[str, tuple[str, str]] = field(default_factory=dict)


def outputs_of(stream: Stream, naming: Naming) -> Iterator[Output]:
    """Yield the topics that come of a stream."""
    told = partial(Output, stream.name)
    match stream.content:
        case "clock":
            yield told("/clock", "rosgraph_msgs/msg/Clock", robots.clock)
        case "joint_states":
            name = topic_name(stream.about, "joint_states")
            yield told(name, "sensor_msgs/msg/JointState", robots.joint_state, same=_same_message)
        case "commanded":
            name = topic_name(stream.about, "commanded_joint_states")
            yield told(name, "sensor_msgs/msg/JointState", robots.joint_state, automatic=False)
        case "tcp" | "pose":
            name = topic_name(stream.about, "tcp_pose" if stream.content == "tcp" else "pose")
            make_pose = partial(robots.pose_stamped, frame="world")
            yield told(name, "geometry_msgs/msg/PoseStamped", make_pose, automatic=False)
        case "base":
            frame, child = naming.bases.get(stream.about, ("world", naming.frames(stream.about)))
            make_odometry = partial(robots.odometry, frame=frame, child=child)
            name = topic_name(stream.about, "odom")
            yield told(name, "nav_msgs/msg/Odometry", make_odometry, same=_same_message)
        case "transforms":
            fixed = stream.name == streams.FIXED_TRANSFORMS
            make_frames = partial(robots.transforms, frames=naming.frames)
            name, same = ("/tf_static", None) if fixed else ("/tf", _same_poses)
            yield told(name, "tf2_msgs/msg/TFMessage", make_frames, latched=fixed, same=same)
        case _ if stream.watch == "readings":
            yield from _of_sensor(stream, naming)


def _of_sensor(stream: Stream, naming: Naming) -> Iterator[Output]:
    frame, content = naming.frames(stream.about), stream.content
    told = partial(_told, stream)
    if content == "scan":
        geometry = naming.geometry(stream.about)
        if geometry.single:
            yield told("range", "sensor_msgs/msg/Range", lambda m, t: sensors.single_range(m, geometry, frame, t))
        else:
            yield told("scan", "sensor_msgs/msg/LaserScan", lambda m, t: sensors.laser_scan(m, geometry, frame, t))
    elif content == "points":
        yield told("points", "sensor_msgs/msg/PointCloud2", lambda m, t: sensors.points_of(m, frame, t))
    elif content == "camera_info":
        info = "sensor_msgs/msg/CameraInfo"
        yield told("camera_info", info, lambda m, t: sensors.camera_info(m.camera, frame, t))
    elif content.removeprefix("right_") in _IMAGES:
        yield from _of_eye(stream, frame)
    elif stream.type == "ImuReading":
        yield told("imu", "sensor_msgs/msg/Imu", lambda m, t: sensors.imu(m, frame, t))
        yield told("mag", "sensor_msgs/msg/MagneticField", lambda m, t: sensors.magnetic_field(m, frame, t))
    elif stream.type == "WrenchReading":
        yield told("wrench", "geometry_msgs/msg/WrenchStamped", lambda m, t: sensors.wrench(m, frame, t))
    elif stream.type == "ContactReading":
        yield told("contacts", "sensor_msgs/msg/PointCloud2", sensors.contacts)
        yield replace(told("nearest", "std_msgs/msg/String", lambda m, _: sensors.nearest(m)), automatic=False)
    elif stream.type == "EncoderReading":
        yield told("joint_states", "sensor_msgs/msg/JointState", sensors.encoders)
    elif stream.type == "PoseReading":
        yield told("pose", "geometry_msgs/msg/PoseStamped", sensors.measured_pose)


def _of_eye(stream: Stream, frame: str) -> Iterator[Output]:
    right = stream.content.startswith("right_")
    kind, part, encoding = _IMAGES[stream.content.removeprefix("right_")]
    side = "right" if right else ""

    def pixels(reading: sensor_pb2.SensorReading) -> np.ndarray | None:
        found = (one for one in reading.camera.images if one.kind == kind and one.right == right)
        one = next(found, None)
        return None if one is None else array_of(one.pixels)

    def raw(reading: sensor_pb2.SensorReading, time: int) -> RosValue | None:
        found = pixels(reading)
        return None if found is None else sensors.image(found, encoding, frame, time)

    def jpeg(reading: sensor_pb2.SensorReading, time: int) -> RosValue | None:
        found = pixels(reading)
        return None if found is None else sensors.compressed(found, frame, time)

    def disparity(reading: sensor_pb2.SensorReading, time: int) -> RosValue | None:
        depth = next((one for one in reading.camera.images if one.kind == kind and not one.right), None)
        return None if depth is None else sensors.disparity(array_of(depth.pixels), reading.camera, frame, time)

    yield _told(stream, topic_name(side, part, "image_raw")[1:], "sensor_msgs/msg/Image", raw)
    if stream.content == "right_depth":
        yield _told(stream, "disparity", "stereo_msgs/msg/DisparityImage", disparity)
    if encoding == "rgb8":
        name = topic_name(side, part, "image_raw/compressed")[1:]
        yield _told(stream, name, "sensor_msgs/msg/CompressedImage", jpeg)
        if right:
            info = "sensor_msgs/msg/CameraInfo"
            yield _told(
                stream, "right/camera_info", info, lambda m, t: sensors.camera_info(m.camera, frame, t, right=True)
            )


def _told(
    stream: Stream, part: str, type: str, make_of: Callable[[sensor_pb2.SensorReading, int], RosValue | None]
) -> Output:
    """Return the output of a sensor's reading, which `make_of` makes from the reading and its time (ns)."""

    def of(sample: Sample) -> RosValue | None:
        assert isinstance(sample.message, sensor_pb2.SensorReading)
        return make_of(sample.message, sample.nanoseconds)

    sensor = topic_name(stream.about)
    own = sensor if sensor.endswith(f"/{part}") else topic_name(stream.about, part)  # /ugv/imu, not /ugv/imu/imu
    return Output(stream.name, own, type, of, reliable=False)


def _same_message(before: Sample, after: Sample) -> bool:
    """Return whether a robot's state is the one that was told before: a tick that changes nothing tells it again."""
    return before.message is after.message


def _same_poses(before: Sample, after: Sample) -> bool:
    first, second = before.values, after.values
    return first["children"] is second["children"] and np.array_equal(first["poses"], second["poses"])
