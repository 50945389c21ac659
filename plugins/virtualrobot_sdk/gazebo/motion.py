"""Gazebo's sensors of motion and contact, whose noise is told for each axis."""

from __future__ import annotations

from dataclasses import fields
from itertools import chain

from virtualrobot_sdk.gazebo.tags import Element, Noise, Values, Warn, child, local, noise, said


def contact(sensor: Element, warn: Warn) -> Values:
    """Return the contact sensor of a <contact>: what touches the link."""
    return {}


def imu(sensor: Element, warn: Warn) -> Values:
    """Return the motion sensor of an <imu>; the old <noise> with <rate> and <accel> is read too."""
    tag = child(sensor, "imu")
    old = child(tag, "noise")
    gyroscope = _axes(child(tag, "angular_velocity"), warn) or _alike([child(old, "rate")], old, warn)
    accelerometer = _axes(child(tag, "linear_acceleration"), warn) or _alike([child(old, "accel")], old, warn)
    return {"imu": said(gyroscope=gyroscope or None, accelerometer=accelerometer or None)}


def magnetometer(sensor: Element, warn: Warn) -> Values:
    """Return the motion sensor of a <magnetometer>: an inertial unit of which only the field has noise."""
    return {"imu": said(magnetometer=_axes(child(sensor, "magnetometer"), warn) or None)}


def position(sensor: Element, warn: Warn) -> Values:
    """Return the motion sensor of a <gps> or <navsat> (noise of the position) or <altimeter> (of the height)."""
    tag = next((found for name in ("navsat", "gps", "altimeter") if (found := child(sensor, name)) is not None), None)
    axes = [child(tag, "position_sensing", axis, "noise") for axis in ("horizontal", "vertical")]
    axes.append(child(tag, "vertical_position", "noise"))
    return {"pose": said(position=_alike(axes, tag, warn) or None)}


def force_torque(sensor: Element, warn: Warn) -> Values:
    """Return the motion sensor of a <force_torque>: what the child of its joint puts on it, in the child's frame."""
    tag = child(sensor, "force_torque")
    frame = child(tag, "frame")
    if frame is not None and (frame.text or "").strip() == "parent":
        warn(frame, "the wrench is told in the child's frame, not in the parent's")
    direction = child(tag, "measure_direction")
    if direction is not None and (direction.text or "").strip() == "parent_to_child":
        warn(direction, "the wrench is that of the child on its parent, not the other way round")
    return {
        "force_torque": said(
            force=_axes(child(tag, "force"), warn) or None,
            torque=_axes(child(tag, "torque"), warn) or None,
            include_parent=True,
        )
    }


def _axes(tag: Element | None, warn: Warn) -> Values:
    """Return the noise model of <x>, <y> and <z> (older: of the element itself)."""
    if tag is None:
        return {}
    return _alike([child(tag, "noise"), *(child(tag, axis, "noise") for axis in "xyz")], tag, warn)


def _alike(tags: list[Element | None], named_by: Element | None, warn: Warn) -> Values:
    """Return the noise model of several axes: the greatest of each number, told where they differ."""
    found = [noise(tag, warn) for tag in tags if tag is not None]
    if not found:
        return {}
    if len(set(found)) > 1:
        warn(named_by, f"the axes of <{local(named_by)}> have different noise; the greatest is taken for all")
    if any(chain.from_iterable((one.mean, one.bias_mean) for one in found)):
        warn(
            named_by, f"the means of the noise of <{local(named_by)}> are left out; biases are drawn by their deviation"
        )
    most = Noise(*(max(getattr(one, field.name) for one in found) for field in fields(Noise)))
    return said(
        standard_deviation=most.deviation,
        bias_standard_deviation=most.bias_deviation,
        bias_walk=most.bias_walk,
        resolution=most.precision,
    )
