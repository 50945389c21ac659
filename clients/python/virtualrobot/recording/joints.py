"""Robots as their joints: messages of a recording, and columns of a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from virtualrobot._wire.services import Services
from virtualrobot.errors import UnknownNameError
from virtualrobot.v1 import geometry_pb2, nodes_pb2, robot_pb2

_LINEAR = ("x", "y", "z")
_UNITS = {nodes_pb2.JOINT_TYPE_PRISMATIC: "m"}


@dataclass(frozen=True, slots=True)
class Coordinate:
    """A coordinate of a robot.

    Attributes:
        name: its name: the joint's, or of a planar or floating joint `base/x`.
        unit: of its position: `rad`, `m`, or none for a part of a quaternion.
        velocity: its place among the velocities; None where it has none of its own.
    """

    name: str
    unit: str
    velocity: int | None


def coordinates(joints: Sequence[robot_pb2.JointDescription]) -> list[Coordinate]:
    """Return the coordinates of a robot in the order of its positions."""
    found: list[Coordinate] = []
    velocities = 0
    for joint in joints:
        single = joint.coordinate_count == 1
        for place, name in enumerate(joint.coordinate_names):
            part = name.rpartition("/")[2]
            unit = _UNITS.get(joint.type, "rad") if single else "m" if part in _LINEAR else "rad"
            if joint.type == nodes_pb2.JOINT_TYPE_FLOATING and part not in _LINEAR:
                found.append(Coordinate(name, "", None))
            else:
                found.append(Coordinate(name, unit, velocities + place))
        velocities += joint.velocity_count
    return found


class Robots:
    """Coordinates of robots by name, asked for again when the structure of the world is another."""

    def __init__(self, services: Services) -> None:
        """Ask one kernel."""
        self._services = services
        self._revision = (0, 0)
        self._known: dict[str, list[Coordinate]] = {}

    def coordinates(self, state: robot_pb2.RobotState, stamp: geometry_pb2.Stamp) -> list[Coordinate]:
        """Return the coordinates of a robot in a state; none where it is gone, or another one of this name is there."""
        revision = stamp.epoch, stamp.structure_revision
        if revision != self._revision:
            self._revision, self._known = revision, {}
        if state.name not in self._known:
            try:
                answer = self._services.robot.GetRobot(robot_pb2.GetRobotRequest(name=state.name))
                self._known[state.name] = coordinates(answer.joints)
            except UnknownNameError:
                self._known[state.name] = []
        found = self._known[state.name]
        return found if len(found) == len(state.positions) else []
