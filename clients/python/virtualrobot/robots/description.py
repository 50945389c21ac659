"""Descriptions of robots, kept while the structure of the world is the same, and where their joints are."""

from __future__ import annotations

from collections.abc import Sequence

from virtualrobot._wire.services import Services
from virtualrobot.v1 import nodes_pb2, robot_pb2


def described(
    services: Services, robot: str, group: nodes_pb2.GroupSelection | None = None
) -> robot_pb2.GetRobotResponse:
    """Return what a robot, or a group of it, is made of; raises UnknownNameError when there is none."""
    chosen = () if group is None else (group.name, group.base_link, group.tip_link)
    return services.descriptions.get(("robot", robot, chosen), lambda: described_anew(services, robot, group))


def described_anew(
    services: Services, robot: str, group: nodes_pb2.GroupSelection | None = None
) -> robot_pb2.GetRobotResponse:
    """Return the same from the kernel: for what changes without the structure, as a component's fault does."""
    return services.robot.GetRobot(robot_pb2.GetRobotRequest(name=robot, group=group))


def joints_now(services: Services, robot: str) -> dict[str, float]:
    """Return where the coordinates of all joints are, radians or meters by name."""
    state = services.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest(names=[robot])).robots[0]
    return dict(zip(coordinate_names(described(services, robot)), state.positions, strict=True))


def coordinate_names(description: robot_pb2.GetRobotResponse, joints: Sequence[str] | None = None) -> list[str]:
    """Return the names of the coordinates of joints, or of all joints in the order of positions."""
    own = {joint.name: list(joint.coordinate_names) for joint in description.joints}
    return [coordinate for joint in (own if joints is None else joints) for coordinate in own.get(joint, [joint])]
