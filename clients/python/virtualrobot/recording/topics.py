"""Topics of a recording: their names, and which of them somebody wants."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from fnmatch import fnmatchcase

from virtualrobot._wire.names import nearest, unknown_name
from virtualrobot.v1 import sensing_pb2, sensor_pb2

TRANSFORMS, FIXED_TRANSFORMS = "/transforms", "/transforms/fixed"
SCENE, LATER_SCENE = "/scene", "/scene/later"
MOTIONS, COLLISIONS, LOG = "/motions", "/collisions", "/log"

OF_WORLD = (TRANSFORMS, FIXED_TRANSFORMS, SCENE, LATER_SCENE, MOTIONS, COLLISIONS, LOG)
"""Topics that every world has."""

_GROUPS = ("/robots/", "/signals/", "/sensors/")
_PICTURES = ("color", "depth", "segmentation", "normals")
CONTENTS = {
    sensor_pb2.SENSOR_KIND_RANGE: ("scan", "points"),
    sensor_pb2.SENSOR_KIND_CAMERA: (
        *(*_PICTURES, *(f"right_{one}" for one in _PICTURES)),
        *("element_names", "camera_info"),
    ),
}
"""Last parts of the topics that a sensor of a kind may have; one of another kind has `reading` alone."""


def joint_states(robot: str) -> str:
    """Return the topic of a robot's joints."""
    return f"/robots/{robot}/joint_states"


def commanded_joint_states(robot: str) -> str:
    """Return the topic of a robot's joints as motions command them, where that is not what is measured."""
    return f"/robots/{robot}/commanded_joint_states"


def tool_center_point(robot: str) -> str:
    """Return the topic of a robot's tool centre point."""
    return f"/robots/{robot}/tcp"


def of_robot(robot: str) -> tuple[str, ...]:
    """Return the topics of a robot."""
    return joint_states(robot), commanded_joint_states(robot), tool_center_point(robot)


def signal(name: str) -> str:
    """Return the topic of a signal."""
    return f"/signals/{name}"


def sensor(name: str, content: str) -> str:
    """Return the topic of what a sensor tells: `scan`, `points`, `color`, `depth`, `reading` and others."""
    return f"/sensors/{name}/{content}"


def scan_angles(pattern: sensing_pb2.ScanPattern) -> tuple[float, float] | None:
    """Return the angles of the first and the last beam about z, from x towards y, of beams in one plane from one point.

    None for other patterns, whose readings are clouds of points.
    """
    kind = pattern.WhichOneof("pattern")
    if kind in (None, "beam"):
        return 0.0, 0.0
    if kind == "fan":
        return pattern.fan.start_angle_radians, pattern.fan.end_angle_radians
    if kind == "spinning" and list(pattern.spinning.elevations_radians) == [0.0]:
        return -math.pi, math.pi - 2.0 * math.pi / pattern.spinning.columns
    return None


class Selection:
    """Choice of topics by their names or by patterns such as `/robots/*`; without any, all are chosen."""

    def __init__(self, patterns: Iterable[str] = ()) -> None:
        """Choose what one of these names or patterns fits; `*` stands for any letters, `/` among them."""
        self.patterns = tuple(patterns)
        self._chosen: dict[str, bool] = {}

    def check(self, known: Iterable[str]) -> None:
        """Raise UnknownNameError for what fits none of these topics, unless it is a pattern that later ones may fit."""
        names = list(dict.fromkeys(known))
        for pattern in self.patterns:
            later = _literal(pattern) != pattern and _literal(pattern).startswith(_GROUPS)
            if not (later or any(fnmatchcase(name, pattern) for name in names)):
                raise unknown_name("no topic", pattern, names)

    def __contains__(self, topic: str) -> bool:
        """Return whether a topic is chosen."""
        if topic not in self._chosen:
            self._chosen[topic] = not self.patterns or any(fnmatchcase(topic, one) for one in self.patterns)
        return self._chosen[topic]

    def unmet(self) -> list[str]:
        """Return in words which patterns nothing fits that was asked for so far, and what there is."""
        return [
            f"nothing came of {pattern!r}; {nearest(pattern, self._chosen)}"
            for pattern in self.patterns
            if not any(fnmatchcase(name, pattern) for name in self._chosen)
        ]

    def may_have(self, beginning: str) -> bool:
        """Return whether a topic that begins so may be chosen."""
        literals = list(map(_literal, self.patterns))
        return not literals or any(one.startswith(beginning) or beginning.startswith(one) for one in literals)


def _literal(pattern: str) -> str:
    """Return a pattern up to its first letter that stands for others."""
    return re.split(r"[*?\[]", pattern, maxsplit=1)[0]
