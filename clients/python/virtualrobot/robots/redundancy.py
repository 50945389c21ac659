"""Redundancy resolution of an arm with more joints than its goal needs, as a message."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TypeAlias

from virtualrobot._wire.messages import joint_map
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.v1 import robot_pb2

Lock: TypeAlias = Mapping[str, float] | Iterable[str]
"""Joints that stand still: radians or meters by name, or names alone for where they are now."""

Prefer: TypeAlias = str | Mapping[str, float]
"""Preference for the free joints: `limits`, `manipulability`, `distance`, or a posture, radians or meters by name."""

_PREFERENCES = {
    "limits": robot_pb2.REDUNDANCY_PREFERENCE_JOINT_LIMITS,
    "manipulability": robot_pb2.REDUNDANCY_PREFERENCE_MANIPULABILITY,
    "distance": robot_pb2.REDUNDANCY_PREFERENCE_DISTANCE,
}


def redundancy(
    lock: Lock = (),
    arm_angle: float | None = None,
    prefer: Prefer | None = None,
    *,
    joints_now: Callable[[], Mapping[str, float]],
) -> robot_pb2.Redundancy | None:
    """Return a wish as a message, None without any; `joints_now` tells where joints are that are locked there."""
    message = robot_pb2.Redundancy(arm_angle_radians=arm_angle)
    if isinstance(lock, Mapping):
        message.locked_joints.update(joint_map(lock))
    elif isinstance(lock, str):
        raise InvalidArgumentError(f"lock is the text {lock!r}; give a list of joint names, or values by name")
    elif names := list(lock):
        now = joints_now()
        for name in names:
            if name not in now:
                raise InvalidArgumentError(f"there is no joint {name!r} to lock; there are {', '.join(now)}")
            message.locked_joints[name] = now[name]
    if isinstance(prefer, Mapping):
        message.preference = robot_pb2.REDUNDANCY_PREFERENCE_POSTURE
        message.posture.update(joint_map(prefer))
    elif prefer in _PREFERENCES:
        message.preference = _PREFERENCES[prefer]
    elif prefer is not None:
        raise InvalidArgumentError(
            f"prefer is {prefer!r}; give 'limits', 'manipulability', 'distance', or a posture to be near, by joint name"
        )
    return message if message.ListFields() else None
