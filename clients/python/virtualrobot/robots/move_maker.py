"""Moves of one robot as data: what it can be told to do, not started yet."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from virtualrobot._wire.messages import joint_map
from virtualrobot._wire.services import Services
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.motions import moves
from virtualrobot.robots.description import coordinate_names, described, joints_now
from virtualrobot.robots.redundancy import Lock, Prefer, redundancy
from virtualrobot.v1 import motion_pb2, nodes_pb2, robot_pb2

JointPositions: TypeAlias = Mapping[str, float] | Mapping[str, float | ArrayLike] | ArrayLike
"""Values by joint name, those of planar and floating joints as rows (x, y, theta; x, y, z and a quaternion) or each by
the name of its coordinate (`base/x`); or values in order."""


class MoveMaker:
    """Makes moves of a robot, for `Client.move_together` and programs; the options are those of `Mover`."""

    def __init__(self, services: Services, name: str, group_selection: nodes_pb2.GroupSelection | None = None) -> None:
        """Handle the robot of this name, or a group of it; `Client.robot` checks that there is one."""
        self._services = services
        self.name = name
        self.group_selection = group_selection

    @property
    def _description(self) -> robot_pb2.GetRobotResponse:
        """Joints, links, tools and postures; kept while the structure of the world is the same."""
        return described(self._services, self.name, self.group_selection)

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

    @property
    def coordinates(self) -> dict[str, str]:
        """Joint of each coordinate of the robot, by name in the order of `positions`.

        A coordinate is called as its joint, those of a planar or floating joint `base` are `base/x` and so on.
        """
        return {name: joint.name for joint in self._description.joints for name in joint.coordinate_names}

    def ptp(
        self,
        goal: JointPositions | str,
        *,
        reference: str = "",
        configuration: str = "",
        speed_factor: float = 0.0,
        time_law: str = "",
        moving: bool = False,
        lock: Lock = (),
        arm_angle: float | None = None,
        prefer: Prefer = "",
    ) -> motion_pb2.Move:
        """Return a point-to-point move: all joints start and end together, straight in joint space.

        `goal` is joint values by name, joint values in order (all joints, or those of the chain), a 4x4 pose
        `reference_t_tcp` in the frame of the node `reference` (empty: world), or the name of a posture.
        `configuration` names the only configuration that will do for a pose, such as `right up noflip`, and
        `arm_angle` says where the elbow shall be, in radians. With `moving` the pose goes along when another move of
        the same step moves the reference.
        """
        if isinstance(goal, Mapping) or (not isinstance(goal, str) and np.shape(goal) != (4, 4)):
            goal = self._named(goal)
        move = moves.point_to_point(
            self.name,
            goal,
            reference=reference,
            configuration=configuration,
            speed_factor=speed_factor,
            time_law=time_law,
            moving=moving,
        )
        return self._wished(move, lock, prefer, arm_angle)

    def linear(
        self,
        reference_t_tcp: ArrayLike,
        *,
        reference: str = "",
        velocity: float = 0.0,
        acceleration: float = 0.0,
        speed_factor: float = 0.0,
        time_law: str = "",
        moving: bool = False,
        lock: Lock = (),
        prefer: Prefer = "",
        until: moves.Until | None = None,
    ) -> motion_pb2.Move:
        """Return a straight move of the tool centre point to a 4x4 pose.

        `velocity` in m/s and `acceleration` in m/s^2; 0 means 0.25 and 1. With `moving` the line is one in the frame of
        `reference` while another move of the same step moves that. With `until` it is a search; see `Mover.search`.
        """
        rates = velocity, acceleration, speed_factor
        move = moves.linear(self.name, reference_t_tcp, reference, *rates, time_law, moving, until)
        return self._wished(move, lock, prefer)

    def circular(
        self,
        via: ArrayLike | None = None,
        goal: ArrayLike | None = None,
        *,
        center: ArrayLike | None = None,
        axis: ArrayLike | None = None,
        angle: float | None = None,
        turn_with_arc: bool = False,
        reference: str = "",
        velocity: float = 0.0,
        acceleration: float = 0.0,
        speed_factor: float = 0.0,
        time_law: str = "",
        moving: bool = False,
        lock: Lock = (),
        prefer: Prefer = "",
    ) -> motion_pb2.Move:
        """Return a move of the tool centre point along an arc of a circle to the 4x4 pose `goal`.

        The arc passes the point `via`, or turns about the point `center` (3 numbers each, in m). Keywords:

        - `center`, `axis`, `angle`: instead of `via`. Without `axis` it goes the shorter way; with it, by the right
          hand, `angle` radians or, without an angle, until the goal. With an angle, up to ten turns, the goal may be
          left out; then the tool keeps its orientation.
        - `turn_with_arc`: the tool turns as the arc does, not evenly from its orientation to the goal's.
        - `reference`: the node in whose frame all this is given (empty: world).
        - `velocity`, `acceleration`, `speed_factor`, `moving`: as for `linear`.
        """
        move = moves.circular(
            self.name,
            via,
            goal,
            center=center,
            axis=axis,
            angle=angle,
            turn_with_arc=turn_with_arc,
            reference=reference,
            velocity=velocity,
            acceleration=acceleration,
            speed_factor=speed_factor,
            time_law=time_law,
            moving=moving,
        )
        return self._wished(move, lock, prefer)

    def spline(
        self,
        goals: Iterable[ArrayLike],
        *,
        reference: str | Sequence[str] = "",
        velocity: float = 0.0,
        acceleration: float = 0.0,
        speed_factor: float = 0.0,
        time_law: str = "",
        moving: bool = False,
        lock: Lock = (),
        prefer: Prefer = "",
    ) -> motion_pb2.Move:
        """Return a move of the tool centre point along a smooth curve through 4x4 poses, up to 1,000.

        `reference` is the node in whose frame all poses are given, or one node for each (empty: world). `velocity` and
        `acceleration` in m/s and m/s^2; 0 means 0.25 and 1. With `moving` the curve is one in the frame of `reference`
        while another move of the same step moves that.
        """
        move = moves.spline(self.name, goals, reference, velocity, acceleration, speed_factor, time_law, moving)
        return self._wished(move, lock, prefer)

    def trajectory(
        self,
        times: ArrayLike,
        positions: ArrayLike,
        velocities: ArrayLike | None = None,
        *,
        joints: list[str] | None = None,
        speed_factor: float = 0.0,
    ) -> motion_pb2.Move:
        """Return a move through `positions` (n, k) at `times` (n,) in seconds from 0; the first row is where it is now.

        `velocities` (n, k) are 0 at both ends; without them the curve is smooth. `joints` names the columns, those
        of a planar or floating joint together; without it they are all joints, or those of the chain.
        """
        columns = np.asarray(positions, dtype=float)
        if columns.ndim != 2:
            raise InvalidArgumentError(f"positions have the shape (times, joints), not {columns.shape}")
        every = self._joints_for(columns.shape[1]) if joints is None else joints
        names = coordinate_names(self._description, every)
        return self._of_group(moves.trajectory(self.name, names, times, columns, velocities, speed_factor))

    def _wished(
        self, move: motion_pb2.Move, lock: Lock, prefer: Prefer, arm_angle: float | None = None
    ) -> motion_pb2.Move:
        """Return a move with what is wished of joints that its goal does not need."""
        wish = redundancy(lock, arm_angle, prefer, joints_now=self._joints_now)
        if wish is not None:
            move.redundancy.CopyFrom(wish)
        return self._of_group(move)

    def _of_group(self, move: motion_pb2.Move) -> motion_pb2.Move:
        """Return a move of this robot, for its group where one is handled."""
        if self.group_selection is not None and move.robot == self.name and not move.HasField("group"):
            move.group.CopyFrom(self.group_selection)
        return move

    def _joints_now(self) -> dict[str, float]:
        """Return where the coordinates of all joints are, by name."""
        return joints_now(self._services, self.name)

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
            if np.ndim(value) == 0:  # pyright: ignore[reportArgumentType]
                named[joint] = value  # pyright: ignore[reportArgumentType]
                continue
            values = np.asarray(value, dtype=float)
            names = next((list(one.coordinate_names) for one in self._description.joints if one.name == joint), [joint])
            if values.shape != (len(names),):
                raise InvalidArgumentError(
                    f"the joint {joint!r} of {self.name!r} has {len(names)} values ({', '.join(names)}), not an array "
                    f"of shape {values.shape}"
                )
            named |= zip(names, values.tolist(), strict=True)
        return named

    def _joints_for(self, count: int) -> list[str]:
        """Return the joints that `count` values in order belong to."""
        description = self._description
        every = coordinate_names(description)
        chain = list(description.chain_joints)
        own = [chain] if self.group_selection is not None else [every, chain]
        for names in own:
            if len(names) == count:
                return names
        if self.group_selection is not None:
            said = f"a group of the robot {self.name!r}: it has {len(chain)} joints ({', '.join(chain)})"
        else:
            said = (
                f"the robot {self.name!r}: it has {len(every)} joints ({', '.join(every)}), {len(chain)} of them in "
                "its chain; give values by name for others"
            )
        raise InvalidArgumentError(f"{count} values for {said}")
