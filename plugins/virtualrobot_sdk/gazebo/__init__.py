"""Gazebo's <sensor> tags, as URDF and SDFormat files have them, as sensors of scene files.

Both readers of such files use this. Plugins, visualisation and topics of a tag say nothing of the sensor itself and are
passed over; what cannot be read is told and left out, since a robot without one of its sensors is still a robot.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from virtualrobot_sdk.gazebo import motion, ranges
from virtualrobot_sdk.gazebo.cameras import IMAGES, cameras, old_camera
from virtualrobot_sdk.gazebo.tags import (
    BadTagError,
    Element,
    Values,
    Warn,
    child,
    local,
    not_negative,
    pose,
    said,
    text,
)
from virtualrobot_sdk.kinematics import Floats

__all__ = ["OLD_TAGS", "Element", "SensorTag", "Values", "Warn", "read_sensor", "sensor_tags"]

OLD_TAGS = ("ray", "camera", "contact")
"""Names behind `sensor:` in the tags of Gazebo before 1.0."""
_FASTEST = 10_000.0
_LIDARS = ("ray", "gpu_ray", "lidar", "gpu_lidar")
_READERS: dict[str, tuple[str, Callable[[Element, Warn], Values]]] = {
    **dict.fromkeys(_LIDARS, ("range_sensor", ranges.lidar)),
    "sonar": ("range_sensor", ranges.sonar),
    "contact": ("contact_sensor", motion.contact),
    "imu": ("motion_sensor", motion.imu),
    "magnetometer": ("motion_sensor", motion.magnetometer),
    "gps": ("motion_sensor", motion.position),
    "navsat": ("motion_sensor", motion.position),
    "altimeter": ("motion_sensor", motion.position),
    "force_torque": ("motion_sensor", motion.force_torque),
}


@dataclass(frozen=True, slots=True, eq=False)
class SensorTag:
    """A sensor as a node of a scene file.

    Attributes:
        name: as the tag has it.
        kind: of the node, such as `range_sensor`.
        values: its fields.
        link_t_sensor: (4, 4) the node's pose in the frame from which the tag's pose counts, a camera's turned so
            that it looks along z.
        relative_to: the frame that the tag's pose names; empty means the link or joint that it is in.
    """

    name: str
    kind: str
    values: Values
    link_t_sensor: Floats
    relative_to: str = ""


def sensor_tags(element: Element) -> list[Element]:
    """Return the <sensor> and <sensor:ray>, <sensor:camera>, <sensor:contact> in an element."""
    return [one for one in element if local(one) == "sensor" or _is_old(one)]


def read_sensor(element: Element, warn: Warn) -> list[SensorTag]:
    """Return the sensors that a tag describes: one, of a `multicamera` one for each camera, none where it is unknown.

    None of them runs. `warn` is told what is left out, with the element that is at fault.
    """
    name = element.get("name", "").strip() or "sensor"
    try:
        return [_checked(one) for one in (_old if _is_old(element) else _new)(element, name, warn)]
    except BadTagError as error:
        at = element if error.element is None else error.element
        warn(at, f"it is left out: {error}")
        return []


def _is_old(element: Element) -> bool:
    tag = element.tag if isinstance(element.tag, str) else ""
    prefix = getattr(element, "prefix", None) or tag.rpartition("}")[2].rpartition(":")[0]
    return local(element) in OLD_TAGS and (prefix == "sensor" or tag.partition("}")[0].endswith("#sensor"))


def _new(element: Element, name: str, warn: Warn) -> list[SensorTag]:
    kind = element.get("type", "").strip()
    rate = said(rate_hertz=_rate(element, "update_rate"))
    node_t_tag, placed = pose(element), child(element, "pose")
    relative_to = "" if placed is None else (placed.get("relative_to") or placed.get("frame") or "").strip()
    if kind in IMAGES:
        return [
            SensorTag(
                f"{name}_{own}" if own else name, "camera_sensor", {**values, **rate}, node_t_tag @ turned, relative_to
            )
            for own, turned, values in cameras(element, kind, warn)
        ]
    if kind not in _READERS:
        raise BadTagError(element, f"its type {kind!r} is none of {', '.join((*_READERS, *IMAGES))}")
    node, reader = _READERS[kind]
    return [SensorTag(name, node, {**reader(element, warn), **rate}, node_t_tag, relative_to)]


def _old(element: Element, name: str, warn: Warn) -> list[SensorTag]:
    rate = said(rate_hertz=_rate(element, "updateRate"))
    if local(element) == "camera":
        turned, values = old_camera(element)
        return [SensorTag(name, "camera_sensor", {**values, **rate}, pose(element) @ turned)]
    if local(element) == "contact":
        return [SensorTag(name, "contact_sensor", rate, np.eye(4))]
    return [SensorTag(name, "range_sensor", {**ranges.old_lidar(element, warn), **rate}, pose(element))]


def _rate(element: Element, tag: str) -> float:
    """Return the rate (Hz); 0, as fast as it can be in Gazebo, is what the sensor has by itself."""
    if text(element, tag).lower() in ("inf", "+inf"):
        return _FASTEST
    return min(not_negative(element, tag), _FASTEST)


def _checked(tag: SensorTag) -> SensorTag:
    near, far = tag.values.get("near_meters", 0.01), tag.values.get("far_meters", 100.0)
    least, most = tag.values.get("min_range_meters", 0.0), tag.values.get("max_range_meters", 10.0)
    if not (near < far and least < most):
        raise BadTagError(None, f"it would see from {max(near, least):g} m to {min(far, most):g} m")
    return tag
