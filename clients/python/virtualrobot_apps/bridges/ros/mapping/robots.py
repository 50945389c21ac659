"""Clock, joints, frames and bases as messages, and twists back."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from virtualrobot.streams.sample import Sample

from virtualrobot_apps.bridges.ros.mapping.basics import (
    RosValue,
    header,
    pose,
    quaternion,
    time_of,
    twist,
    unknown_covariance,
    vector,
)
from virtualrobot_apps.bridges.ros.mapping.names import FrameNames
from virtualrobot_apps.bridges.ros.messages.types import make

_POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")


def clock(sample: Sample) -> RosValue:
    """Return the simulation time as `rosgraph_msgs/Clock`."""
    return make("rosgraph_msgs/msg/Clock", clock=time_of(sample.nanoseconds))


def joint_state(sample: Sample) -> RosValue:
    """Return the joints with one coordinate as `sensor_msgs/JointState`: positions and velocities as they are.

    A base that moves has more coordinates: it is in frames and odometry. `effort` (N m, N) is empty where the world
    tells none, as of all robots that no forces move.
    """
    names, places = _columns(tuple(sample.values))
    row = [*sample.values.values()]
    return make(
        "sensor_msgs/msg/JointState",
        header=header(sample.nanoseconds, ""),
        name=list(names),
        **{what: np.array([row[place] for place in of], float) for what, of in places.items()},
    )


@lru_cache(maxsize=1024)
def _columns(keys: tuple[str, ...]) -> tuple[list[str], dict[str, list[int]]]:
    """Return the names of a state's joints, and where among its values each of their numbers is."""
    places: dict[str, list[int]] = {"position": [], "velocity": [], "effort": []}
    names: list[str] = []
    for place, key in enumerate(keys):
        name, _, what = key.rpartition("/")
        if "/" in name or what not in places:
            continue
        places[what].append(place)
        if what == "position":
            names.append(name)
    return names, places


def pose_stamped(sample: Sample, frame: str) -> RosValue:
    """Return a pose in a frame as `geometry_msgs/PoseStamped`."""
    row = [sample.values[name] for name in _POSE]
    return make("geometry_msgs/msg/PoseStamped", header=header(sample.nanoseconds, frame), pose=pose(row))


def transforms(sample: Sample, frames: FrameNames) -> RosValue:
    """Return frames as `tf2_msgs/TFMessage`, each in its parent's."""
    rows: list[list[float]] = sample.values["poses"].tolist()
    found = [
        transform(sample.nanoseconds, frames(parent), frames(child), row)
        for parent, child, row in zip(sample.values["parents"], sample.values["children"], rows, strict=True)
    ]
    return make("tf2_msgs/msg/TFMessage", transforms=found)


def transform(nanoseconds: int, parent: str, child: str, row: Sequence[float]) -> RosValue:
    """Return a transform from x, y, z (m) and the quaternion x, y, z, w of the child in the parent's frame."""
    placed = make("geometry_msgs/msg/Transform", translation=vector(*row[:3]), rotation=quaternion(*row[3:7]))
    return make(
        "geometry_msgs/msg/TransformStamped",
        header=header(nanoseconds, parent),
        child_frame_id=child,
        transform=placed,
    )


def odometry(sample: Sample, frame: str, child: str) -> RosValue:
    """Return the true pose and twist of a base as `nav_msgs/Odometry`: the pose in `frame`, the twist in `child`."""
    told = sample.values
    if "heading" in told:
        half = 0.5 * told["heading"]
        row = [told["x"], told["y"], 0.0, 0.0, 0.0, math.sin(half), math.cos(half)]
        moving = twist((told["vx"], told["vy"], 0.0), (0.0, 0.0, told["omega"]))
    else:
        row = [told[name] for name in _POSE]
        moving = twist([told[one] for one in ("vx", "vy", "vz")], [told[one] for one in ("wx", "wy", "wz")])
    return make(
        "nav_msgs/msg/Odometry",
        header=header(sample.nanoseconds, frame),
        child_frame_id=child,
        pose=make("geometry_msgs/msg/PoseWithCovariance", pose=pose(row), covariance=unknown_covariance(36)),
        twist=make("geometry_msgs/msg/TwistWithCovariance", twist=moving, covariance=unknown_covariance(36)),
    )


def commanded_twist(value: RosValue) -> list[float]:
    """Return (vx, vy, omega) of a `Twist` or `TwistStamped`, in m/s and rad/s along and about the base's axes.

    Raises:
        ValueError: for what is not finite.
    """
    told = getattr(value, "twist", value)
    found = [told.linear.x, told.linear.y, told.angular.z]
    if not all(map(math.isfinite, found)):
        raise ValueError(f"a twist has finite numbers, not {found[0]:g}, {found[1]:g}, {found[2]:g}")
    return found
