"""Joints that are moved and solved together: those of a robot, or of a group of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np

from virtualrobot._wire.arguments import ArrayLike
from virtualrobot._wire.messages import joint_map
from virtualrobot._wire.services import Services
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.robots.description import coordinate_names, described, joints_now
from virtualrobot.v1 import nodes_pb2, robot_pb2

JointPositions: TypeAlias = Mapping[str, float] | Mapping[str, float | ArrayLike] | ArrayLike
"""Values by joint name, those of planar and floating joints as rows (x, y, theta; x, y, z and a quaternion) or each by
the name of its coordinate (`base/x`); or values in order."""


class Mechanism:
    """A robot by its name, or a group of it: its joints and chain."""

    def __init__(self, services: Services, name: str, group: nodes_pb2.GroupSelection | None = None) -> None:
        """Handle the robot of this name, or a group of it; `Client.robot` checks that there is one."""
        self._services = services
        self.name = name
        self._group = group

    @property
    def _description(self) -> robot_pb2.GetRobotResponse:
        """Joints, links, tools and postures; kept while the structure of the world is the same."""
        return described(self._services, self.name, self._group)

    @property
    def chain_joint_names(self) -> list[str]:
        """The joints that move the flange, in the order of inverse solutions; without a gripper's fingers."""
        return list(self._description.chain_joints)

    @property
    def joint_types(self) -> dict[str, str]:
        """Type of each joint of the robot, by name: `revolute`, `continuous`, `prismatic`, `planar` or `floating`."""
        name_of = nodes_pb2.JointType.Name
        joints = self._description.joints
        return {joint.name: name_of(joint.type).removeprefix("JOINT_TYPE_").lower() for joint in joints}

    def _joints_now(self) -> dict[str, float]:
        """Return where the coordinates of all joints are, by name."""
        return joints_now(self._services, self.name)

    @property
    def coordinates(self) -> dict[str, str]:
        """Joint of each coordinate of the robot, by name in the order of `positions`.

        A coordinate is called as its joint, those of a planar or floating joint `base` are `base/x` and so on.
        """
        return {name: joint.name for joint in self._description.joints for name in joint.coordinate_names}

    def _named(self, positions: JointPositions | None) -> dict[str, float]:
        """Return joint values by name; values in order are those of all joints or of the chain."""
        if positions is None:
            return {}
        if isinstance(positions, Mapping):
            return joint_map(self._spread(positions))
        values = np.asarray(positions, dtype=float)
        if values.ndim != 1:
            raise InvalidArgumentError(f"joint positions are one row of numbers, not an array of shape {values.shape}")
        return dict(zip(self._joints_for(len(values)), values.tolist(), strict=True))

    def _spread(self, positions: Mapping[str, float | ArrayLike]) -> dict[str, float]:
        """Return positions by name with the coordinates of a joint that has several each by its own name."""
        named: dict[str, float] = {}
        for joint, value in positions.items():
            own = self._row(joint, value) if np.ndim(value) else {joint: value}  # pyright: ignore[reportArgumentType]
            if twice := [name for name in own if name in named]:
                raise InvalidArgumentError(
                    f"{twice[0]!r} of {self.name!r} is given twice, by itself and in the row of its joint"
                )
            named |= own  # pyright: ignore[reportAssignmentType] what has no dimension is a number
        return named

    def _row(self, joint: str, row: ArrayLike) -> dict[str, float]:
        """Return the values of a joint's coordinates by their names."""
        values = np.asarray(row, dtype=float)
        names = next((list(one.coordinate_names) for one in self._description.joints if one.name == joint), [joint])
        if values.shape != (len(names),):
            raise InvalidArgumentError(
                f"the joint {joint!r} of {self.name!r} has {len(names)} values ({', '.join(names)}), not an array "
                f"of shape {values.shape}"
            )
        return dict(zip(names, values.tolist(), strict=True))

    def _joints_for(self, count: int) -> list[str]:
        """Return the joints that `count` values in order belong to."""
        every, chain = coordinate_names(self._description), self.chain_joint_names
        for names in [every, chain] if self._group is None else [chain]:
            if len(names) == count:
                return names
        if self._group is not None:
            said = f"a group of the robot {self.name!r}: it has {len(chain)} joints ({', '.join(chain)})"
        else:
            what = "joints" if len(every) == len(self._description.joints) else "coordinates"
            said = (
                f"the robot {self.name!r}: it has {len(every)} {what} ({', '.join(every)}), {len(chain)} of them in "
                "its chain; give values by name for others"
            )
        raise InvalidArgumentError(f"{count} values for {said}")
