"""Targets: places where robots work, as they were taught."""

from __future__ import annotations

from virtualrobot.scene.node import Node
from virtualrobot.v1 import nodes_pb2


class Target(Node):
    """Target of the scene by its name, a node like others: it is renamed, attached, hidden and removed as they are.

    Its pose is where the tool centre point goes, and moves along with its parent.
    """

    @property
    def robot(self) -> str:
        """The robot that it was taught with; empty for none, or one that is gone."""
        return self._taught.robot

    @property
    def tool(self) -> str:
        """The tool that the robot worked with; empty for none, or one that is gone."""
        return self._taught.tool

    @property
    def tool_center_point(self) -> str:
        """The name of that tool's tool centre point."""
        return self._taught.tool_center_point

    @property
    def joint_positions(self) -> dict[str, float]:
        """The posture in which it was taught, radians and meters by joint name."""
        return dict(self._taught.joint_positions)

    @property
    def _taught(self) -> nodes_pb2.Target:
        return self._message.target

    def __repr__(self) -> str:
        """Return a line for people."""
        message = self._message
        taught = f", taught with {message.target.robot!r}" if message.target.robot else ""
        return f"<Target {self.name!r} in {message.parent!r}{taught}>"
