"""Samples of streams: what one told at one instant, as plain values under their names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from google.protobuf.message import Message

from virtualrobot._wire.messages import array_of, pose_of
from virtualrobot._wire.signal_values import value_of
from virtualrobot.collisions.watch import event_of
from virtualrobot.recording.frames import FrameGroup
from virtualrobot.recording.joints import Coordinate
from virtualrobot.v1 import collision_pb2, geometry_pb2, nodes_pb2, robot_pb2, sensing_pb2, sensor_pb2, signal_pb2

_POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
_IMAGES = {"color": sensing_pb2.IMAGE_KIND_COLOR, "depth": sensing_pb2.IMAGE_KIND_DEPTH}
_IMAGES |= {"segmentation": sensing_pb2.IMAGE_KIND_SEGMENTATION, "normals": sensing_pb2.IMAGE_KIND_NORMALS}


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """Sample of a stream: all that it told at one instant.

    Attributes:
        stream: its name.
        tick: the tick of the world.
        time: simulation time (s).
        wall_time: the kernel's wall clock (s since 1970).
        values: numbers, words and arrays by name, such as `joint_1/position`, `x`, `distances`.
        told_by: the message that told it, or how many bytes it had.
        lost: how many samples of the stream before this one were lost, since this program or the kernel was too slow.
        message: the message of the contract that told it, with what `values` leave out; None where there is none.
    """

    stream: str
    tick: int
    time: float
    wall_time: float
    values: Mapping[str, Any]
    told_by: Message | int
    lost: int = 0
    message: Message | None = None

    @property
    def size(self) -> int:
        """Bytes that the message had that told it; counted when asked for, as a picture takes 0.7 ms."""
        return self.told_by if isinstance(self.told_by, int) else self.told_by.ByteSize()

    @property
    def nanoseconds(self) -> int:
        """Simulation time (ns)."""
        return round(self.time * 1e9)

    def numbers(self) -> dict[str, float]:
        """Return those values that are numbers, and of arrays the least and the mean of what is finite in them."""
        found: dict[str, float] = {}
        for name, value in self.values.items():
            if isinstance(value, np.ndarray):
                finite = value[np.isfinite(value)] if value.dtype.kind == "f" else value
                if finite.size:
                    found[f"{name}/least"], found[f"{name}/mean"] = float(finite.min()), float(finite.mean())
            elif isinstance(value, int | float):
                found[name] = float(value)
        return found


def sampled(
    stream: str,
    stamp: geometry_pb2.Stamp,
    values: Mapping[str, Any],
    told_by: Message | int,
    lost: int = 0,
    message: Message | None = None,
) -> Sample:
    """Return a sample at a stamp."""
    wall = stamp.wall_time.seconds + stamp.wall_time.nanos / 1e9
    return Sample(stream, stamp.tick, stamp.tick * stamp.tick_nanoseconds / 1e9, wall, values, told_by, lost, message)


def of_stamp(stamp: geometry_pb2.Stamp) -> dict[str, Any]:
    """Return the values of the clock."""
    return {"time": stamp.tick * stamp.tick_nanoseconds / 1e9, "tick": stamp.tick, "epoch": stamp.epoch}


def of_joints(state: robot_pb2.RobotState, known: list[Coordinate], commanded: bool = False) -> dict[str, float]:
    """Return positions, velocities and, under physics, efforts by the names of coordinates: `joint_1/position`."""
    positions, velocities = state.positions, state.velocities
    if commanded:
        positions, velocities = state.commanded_positions or positions, state.commanded_velocities or velocities
    found: dict[str, float] = {}
    for place, one in enumerate(known):
        found[f"{one.name}/position"] = positions[place]
        if one.velocity is not None:
            found[f"{one.name}/velocity"] = velocities[one.velocity]
            if state.efforts and not commanded:
                found[f"{one.name}/effort"] = state.efforts[one.velocity]
    return found


def of_base(state: robot_pb2.RobotState, joints: list[robot_pb2.JointDescription], base: str) -> dict[str, float]:
    """Return the pose of a base in its joint's frame, and its twist along and about its own axes (m/s, rad/s)."""
    positions = velocities = 0
    for joint in joints:
        if joint.name == base:
            q = list(state.positions[positions : positions + joint.coordinate_count])
            v = list(state.velocities[velocities : velocities + joint.velocity_count])
            return _planar(q, v) if joint.type == nodes_pb2.JOINT_TYPE_PLANAR else _floating(q, v)
        positions += joint.coordinate_count
        velocities += joint.velocity_count
    return {}


def _planar(q: list[float], v: list[float]) -> dict[str, float]:
    cos, sin = float(np.cos(q[2])), float(np.sin(q[2]))
    along = {"vx": cos * v[0] + sin * v[1], "vy": cos * v[1] - sin * v[0], "omega": v[2]}
    return {"x": q[0], "y": q[1], "heading": q[2]} | along


def _floating(q: list[float], v: list[float]) -> dict[str, float]:
    message = geometry_pb2.Pose()
    for name, value in zip("xyz", q[:3], strict=True):
        setattr(message.position, name, value)
    for name, value in zip("xyzw", q[3:], strict=True):
        setattr(message.orientation, name, value)
    along = pose_of(message)[:3, :3].T @ np.array(v[:3])
    names = (*_POSE, "vx", "vy", "vz", "wx", "wy", "wz")
    return dict(zip(names, (*q, *along.tolist(), *v[3:]), strict=True))


def of_pose(pose: geometry_pb2.Pose) -> dict[str, float]:
    """Return x, y, z (m) and the quaternion of a pose."""
    one, turn = pose.position, pose.orientation
    return dict(zip(_POSE, (one.x, one.y, one.z, turn.x, turn.y, turn.z, turn.w), strict=True))


def of_frames(group: FrameGroup, poses: np.ndarray) -> dict[str, Any]:
    """Return the names of frames, those of their parents, and `parent_t_child` of each (n, 7)."""
    return {"children": group.children, "parents": group.parents, "poses": poses}


def of_row(row: np.ndarray) -> dict[str, float]:
    """Return x, y, z (m) and the quaternion of a pose's row (7,)."""
    return dict(zip(_POSE, row.tolist(), strict=True))


def of_signal(signal: signal_pb2.Signal) -> dict[str, Any]:
    """Return the value of a signal; of a group each of its booleans too."""
    value = value_of(signal.value)
    if isinstance(value, tuple):
        return {"value": value} | {f"value/{place}": one for place, one in enumerate(value)}
    return {"value": value}


def of_reading(reading: sensor_pb2.SensorReading, content: str) -> dict[str, Any] | None:
    """Return what a reading tells of a content; None where it tells nothing of it."""
    kind = reading.WhichOneof("reading")
    if kind is None:
        return None
    message = getattr(reading, kind)
    if kind == "range":
        trusted = np.where(array_of(message.valid) != 0, array_of(message.distances), np.nan)
        return {"distances": trusted, "nearest": float(np.nanmin(trusted)) if np.isfinite(trusted).any() else np.inf}
    if kind == "camera":
        if content == "camera_info":
            info = message.intrinsics
            return {"width": message.width, "height": message.height} | dict(_flat(info, ""))
        wanted = content.removeprefix("right_")
        for image in message.images:
            if image.kind == _IMAGES[wanted] and image.right == content.startswith("right_"):
                return {wanted: array_of(image.pixels)}
        return None
    if kind == "encoders":
        names = message.joint_names
        return {f"{name}/position": value for name, value in zip(names, message.positions, strict=True)} | {
            f"{name}/velocity": value for name, value in zip(names, message.velocities, strict=True)
        }
    if kind == "contact":
        nearest = min((one.distance_meters for one in message.contacts), default=np.inf)
        told = [f"{one.element} {one.other} {one.distance_meters:.4f}" for one in message.contacts]
        forces = {f"force/{axis}": sum(getattr(one.force, axis) for one in message.contacts) for axis in "xyz"}
        return {"count": len(told), "nearest": nearest, "contacts": "; ".join(told)} | forces
    return dict(_flat(message, ""))


def of_event(event: collision_pb2.CollisionEvent) -> dict[str, Any]:
    """Return what began or ended, of what, and in words."""
    told = event_of(event)
    return {"kind": told.kind, "nodes": ", ".join(told.nodes or told.robots), "text": str(told)}


def _flat(message: Message, beginning: str) -> Iterator[tuple[str, Any]]:
    """Yield the plain fields of a message under their names, those of messages within behind a slash."""
    for field in message.DESCRIPTOR.fields:
        value = getattr(message, field.name)
        if field.message_type is None:
            yield f"{beginning}{field.name}", value
        elif isinstance(value, Message):
            yield from _flat(value, f"{beginning}{field.name}/")
