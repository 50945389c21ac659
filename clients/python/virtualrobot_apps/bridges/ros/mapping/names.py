"""Names of frames and topics: what ROS allows in them, and which robot a node belongs to."""

from __future__ import annotations

import re
from collections.abc import Iterable

_OTHERS = re.compile(r"[^A-Za-z0-9_/]+")
_FRAME_OTHERS = re.compile(r"[\s]+")


def topic_name(*parts: str) -> str:
    """Return a topic's name; a dot, as between a robot and its link, is a slash, and other letters an underscore.

    Source: the design of topic and service names (design.ros2.org): letters, digits, `_`, and `/`, no digit in front.
    """
    words = [word for part in parts for word in _OTHERS.sub("_", part.replace(".", "/")).split("/") if word]
    return "".join(f"/_{word}" if word[0].isdigit() else f"/{word}" for word in words)


class FrameNames:
    """Frames of nodes: `<robot>/<link>` of what belongs to a robot, else the node's name."""

    def __init__(self, robots: Iterable[str], *, bare: bool = False) -> None:
        """Know the robots; with `bare` links are called as in the URDF, without their robot."""
        self._robots = sorted(robots, key=len, reverse=True)
        self._bare = bare
        self._known: dict[str, str] = {}

    def __call__(self, node: str) -> str:
        """Return the frame of a node."""
        if node not in self._known:
            self._known[node] = self._of(node)
        return self._known[node]

    def _of(self, node: str) -> str:
        for robot in self._robots:
            if node.startswith(f"{robot}."):
                link = node.removeprefix(f"{robot}.")
                return _FRAME_OTHERS.sub("_", link if self._bare else f"{robot}/{link}")
        return _FRAME_OTHERS.sub("_", node)
