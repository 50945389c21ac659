"""Groups of a robot: an arm of several, a leg, a torso with an arm, a hand; solved and moved by themselves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import listed, told
from virtualrobot.geometry import Matrix
from virtualrobot.robots.mechanism import JointPositions
from virtualrobot.robots.mover import Mover
from virtualrobot.robots.read_only import read_only
from virtualrobot.robots.teacher import Teacher
from virtualrobot.robots.values import JointLimits
from virtualrobot.scene.editor import Direct
from virtualrobot.v1 import nodes_pb2


@checked
class Group(Mover, Teacher):
    """Group of a robot: one of its named groups, or the chain from one link to another.

    It is solved and moved as an arm is, by the methods of `Mover` and `Solver`; positions in order are those
    of `joint_names`. Its tool centre point is that of the robot's chosen tool if that is fixed to the end of the chain,
    else that of the first tool which is, else the end itself. All other joints stay where they are. Leases, `stop` and
    dynamics are of the whole robot.

    Example:
        >>> left, right = robot.group("left_arm"), robot.group("right_arm")
        >>> client.move_together([left.linear(goal), right.ptp("tucked")])
    """

    def __init__(self, services: Services, robot: str, name: str = "", base: str = "", tip: str = "") -> None:
        """Handle a group; `Robot.group` checks that there is one."""
        selection = nodes_pb2.GroupSelection(name=name, base_link=base, tip_link=tip)
        super().__init__(services, robot, selection)

    @property
    def joint_names(self) -> list[str]:
        """Joints of the group in the order of `positions`; of a chain from its base to its tip."""
        return self.chain_joint_names

    @property
    def tip(self) -> str:
        """Link that the group's chain ends at; empty for a group that is no chain."""
        return self._description.flange

    @property
    def limits(self) -> dict[str, JointLimits]:
        """Limits of the group's joints, by name."""
        description = self._description
        limits = {name: JointLimits.of(one.limits) for one in description.joints for name in one.coordinate_names}
        return {name: limits[name] for name in description.chain_joints}

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions of the group's joints now, (k,), radians and meters; to be read only, as of `Robot`."""
        here = self._joints_now()
        return read_only(np.array([here[name] for name in self.joint_names]))

    def set_positions(self, positions: JointPositions) -> None:
        """Put joints of the group somewhere at once, without a motion; values by name, or in order."""
        Direct(self._services).set_joint_positions(self.name, self._named(positions))

    @property
    def tcp(self) -> Matrix:
        """`world_t_tcp`, 4x4: where the group's tool centre point is."""
        return self.solve_forward().world_t_tcp

    def __repr__(self) -> str:
        """Return a line for people."""
        chosen = self._group
        assert chosen is not None
        words = repr(chosen.name) if chosen.name else f"{chosen.base_link or 'base'} to {chosen.tip_link or 'flange'}"
        return told(f"Group {words} of {self.name!r}", lambda: f"joints {listed(self.joint_names)}")
