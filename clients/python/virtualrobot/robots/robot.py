"""Robots: where they are, where they can go, and their motions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, PoseLike, checked
from virtualrobot._wire.messages import value_or_default
from virtualrobot._wire.newest import newest
from virtualrobot._wire.showing import told
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix
from virtualrobot.leases import Lease, acquire
from virtualrobot.motions.setpoints import MODES, SetpointStream
from virtualrobot.motions.steps import NodeNamed, name_of
from virtualrobot.robots.description import coordinate_names
from virtualrobot.robots.driving import Driving
from virtualrobot.robots.group import Group
from virtualrobot.robots.mechanism import JointPositions
from virtualrobot.robots.mounting import mount
from virtualrobot.robots.postures import Postures
from virtualrobot.robots.read_only import read_only
from virtualrobot.robots.teacher import Teacher
from virtualrobot.robots.tool import Tool
from virtualrobot.robots.values import (
    Actuator,
    JointGroup,
    JointLimits,
    LinkPair,
    RobotState,
)
from virtualrobot.scene.editor import Batch, Direct, pick_command
from virtualrobot.v1 import motion_pb2, robot_pb2


@checked
class Robot(Driving, Teacher):
    """A robot by its name: an arm, a conveyor, a turntable, a vehicle, whatever has joints.

    Positions are radians or meters, poses 4x4 arrays. Its motions are those of `Mover`, its targets those of `Teacher`,
    what is computed of it is in `Solver`.
    """

    @property
    def joint_names(self) -> list[str]:
        """The joints that can be moved, in the order of `positions`."""
        return [joint.name for joint in self._description.joints]

    @property
    def limits(self) -> dict[str, JointLimits]:
        """Limits of each joint, by name."""
        return {joint.name: JointLimits.of(joint.limits) for joint in self._description.joints}

    @property
    def links(self) -> list[str]:
        """The names of the links, parents before children."""
        return list(self._description.links)

    @property
    def flange(self) -> str:
        """The link that tools are mounted on."""
        return self._description.flange

    @property
    def rated_payload(self) -> float:
        """Greatest load at the flange by the data sheet (kg), with tools; 0 where none is told."""
        return self._description.robot.payload_kilograms

    @property
    def postures(self) -> Postures:
        """Postures with a name, for `move_to`: joint values by name, like a dictionary, with `add` and `remove`."""
        return Postures(self)

    @property
    def groups(self) -> dict[str, JointGroup]:
        """Groups of joints by name, as an SRDF file or `set_groups` gives them; `group` handles one of them."""
        return {group.name: JointGroup.of(group) for group in self._description.robot.groups}

    def group(self, name: str | None = None, *, base: str | None = None, tip: str | None = None) -> Group:
        """Return a handle for a part of the robot that is solved and moved by itself.

        Args:
            name: one of `groups`.
            base: instead of a name, the link that a chain begins at; without it the robot's base.
            tip: the link that it ends at, below `base`; without it the flange.

        Raises:
            UnknownNameError: when the robot has no such group or link; it lists the right ones.
            InvalidArgumentError: when no chain leads from `base` to `tip`.

        Example:
            >>> robot.group("left_arm").move_linear(goal)
            >>> robot.group(base="torso", tip="left_gripper").solve_inverse(goal)
        """
        if not (name or base or tip):
            raise InvalidArgumentError(f"name a group of {self.name!r}, or the base and tip link of a chain")
        group = Group(self._services, self.name, name or "", base or "", tip or "")
        _ = group._description  # raises when there is none
        return group

    def set_groups(self, groups: Iterable[JointGroup]) -> None:
        """Give the robot these groups, in place of those that it has; chains need no joint names.

        Example:
            >>> robot.set_groups([virtualrobot.JointGroup("left_arm", base_link="torso", tip_link="left_gripper")])
        """
        Direct(self._services).set_groups(self.name, groups)

    @property
    def actuators(self) -> list[Actuator]:
        """Actuators of the joints, in the order of `RobotState.actuator_positions`; empty where motors are joints."""
        return [Actuator.of(message) for message in self._description.robot.actuators]

    @property
    def allowed_collisions(self) -> list[LinkPair]:
        """Pairs of links that may touch: adjacent ones, and those that the model says."""
        return [LinkPair(pair.first, pair.second, pair.reason) for pair in self._description.robot.allowed_collisions]

    @property
    def state(self) -> RobotState:
        """State of joints, tool centre point and tools now."""
        request = robot_pb2.GetRobotStatesRequest(names=[self.name])
        response = self._services.robot.GetRobotStates(request)
        return RobotState.of(response.robots[0], response.stamp)

    @property
    def positions(self) -> NDArray[np.float64]:
        """All joint coordinates now, in radians and meters; to be read only, `copy()` is an array of one's own."""
        return read_only(self.state.positions)

    @property
    def tcp(self) -> Matrix:
        """`world_t_tcp`, 4x4: where the chosen tool centre point is (without a tool: the flange).

        The flange of a robot of several arms is the last link before it branches; `group` has the tcp of an arm.
        """
        return self.state.world_t_tcp

    def watch(self, max_rate: float | None = None) -> Iterator[RobotState]:
        """Yield the state now and whenever it has changed, at most `max_rate` (30 by default) times a second."""
        rate = value_or_default(max_rate, "max_rate")
        request = robot_pb2.WatchRobotStatesRequest(names=[self.name], max_rate_hertz=rate)
        stream = self._services.robot.WatchRobotStates(request)
        with closing(newest(stream, lambda said: ((one.name, (one, said.stamp)) for one in said.robots))) as states:
            for robot, stamp in states:
                yield RobotState.of(robot, stamp)

    @property
    def speed_factor(self) -> float:
        """Factor by which its motions are slowed, above 0, up to 1; setting it changes running ones smoothly."""
        return self.state.speed_factor

    @speed_factor.setter
    def speed_factor(self, factor: float) -> None:
        Direct(self._services).set_speed_factor(factor, self.name)

    @property
    def tcp_speed_limit(self) -> float:
        """Greatest speed of its tool centre point (m/s), as 0.25 for teaching; 0: it has none.

        While there is one, motions and jogs are planned as much slower as it takes, whoever starts them; setpoints, and
        motions that go along with a frame, are refused. Setting it is refused while the robot moves.
        """
        return self.state.tcp_speed_limit

    @tcp_speed_limit.setter
    def tcp_speed_limit(self, limit: float) -> None:
        Direct(self._services).set_tcp_speed_limit(limit, self.name)

    def set_positions(self, positions: JointPositions) -> None:
        """Put joints somewhere at once, without a motion; values by name, or all coordinates in order."""
        named = self._named(positions) if isinstance(positions, Mapping) else positions
        Direct(self._services).set_joint_positions(self.name, named)

    def lease(self, *, take: bool = False, owner: str | None = None) -> Lease:
        """Lease it, so that nobody but this client moves it; see `Client.lease`.

        Example:
            >>> with robot.lease():
            ...     robot.move_to("home")
        """
        return acquire(self._services, [self.name], owner, take)

    def stream(
        self,
        mode: str = "position",
        joints: Sequence[str] | None = None,
        *,
        timeout: float = 0.2,
        preempt: bool = False,
    ) -> SetpointStream:
        """Open a stream of setpoints, which moves joints as this program sends them.

        Args:
            mode: the quantity of the setpoints, `position` or `velocity`.
            joints: the joints, in the order of the values; without them all. A planar or floating one stands for its
                coordinates (x, y, theta; x, y, z and a quaternion, of which velocities are the angular velocity and 0).
            timeout: after how many seconds of simulation time without a setpoint the joints stop.
            preempt: cancel motions in the way instead of being refused.

        Raises:
            RobotBusyError: when one of the joints moves already.
            UnknownNameError: when the robot has no such joint.
            LeasedError: when somebody else has leased the robot.

        Example:
            >>> with robot.stream("velocity", ["lbr_iiwa_joint_1"]) as stream:
            ...     stream.send([0.5])
        """
        if mode not in MODES:
            raise InvalidArgumentError(f"mode is 'position' or 'velocity', not {mode!r}")
        if joints is None:
            joints = self.joint_names
        if not joints:
            raise InvalidArgumentError(f"a stream of {self.name!r} needs joints to move")
        target = motion_pb2.SetpointTarget(
            robot=self.name,
            joint_names=coordinate_names(self._description, joints),
            mode=MODES[mode],
            timeout_seconds=timeout,
            busy_policy=motion_pb2.BUSY_POLICY_PREEMPT if preempt else motion_pb2.BUSY_POLICY_REJECT,
        )
        return SetpointStream(self._services, target, self._spread)

    # Tools and parts.

    @property
    def tools(self) -> list[str]:
        """The names of the tools mounted on it."""
        return list(self._description.tools)

    def tool(self, name: str | None = None) -> Tool:
        """Return a handle for a tool of this robot, by its name or its gripper's; without a name the chosen one.

        Example:
            >>> robot.tool("hand").open()
        """
        return Tool.of(self._services, self.name, name)

    def mount(
        self,
        what: NodeNamed | Path,
        *,
        name: str | None = None,
        adapter: NodeNamed | None = None,
        pose: PoseLike | None = None,
        tcp: str | ArrayLike | None = None,
    ) -> Tool:
        """Mount a tool or gripper at the flange, work with it, and return it.

        From then on it is this robot's: its tool centre point, its states, its mass, its figures for collisions.

        Args:
            what: a model to load: `model://` with a name of `client.models()`, a file's path with a `/` in it, or a
                `Path`; otherwise a node that is there, or its name: a tool, a gripper, or an adapter with one.
            name: of what is loaded; by default its own, with a number if that is taken.
            adapter: the link or adapter of this robot that it goes to instead of the flange.
            pose: where its frame is in that of the flange or adapter, 4x4; by default they coincide.
            tcp: the name of the tool centre point to work with, by default the first; or a pose, 4x4 in the frame of
                what is mounted, of a tool centre point that it gets: so a model without a tool of its own becomes one.

        Raises:
            WrongStateError: when another tool hangs there, or it is mounted on a robot already.
            RobotBusyError: while one of both moves.
            InvalidArgumentError: when there is no tool in it.

        Example:
            >>> hand = arm.mount("model://parallel_gripper")
            >>> hand.close().wait()
            >>> arm.mount("gripper", adapter="plate", pose=virtualrobot.pose(z=0.02))
        """
        mount(self._services, self.name, what, name, None if adapter is None else name_of(adapter), pose, tcp)
        return self.tool()

    def unmount(self, tool: NodeNamed | None = None, *, to: NodeNamed = "world", pose: PoseLike | None = None) -> None:
        """Take a tool off: by default the chosen one with its gripper, or a tool, gripper or adapter by name.

        It is fixed to the node `to`, such as a rack, at `pose` (4x4 in the frame of that), by default where it is.

        Raises:
            WrongStateError: when it is not mounted on this robot.

        Example:
            >>> arm.unmount(to="rack")
        """
        name = None if tool is None else name_of(tool)
        Direct(self._services).unmount_tool(self.name, name, name_of(to), pose)

    def change_tool(
        self,
        what: NodeNamed,
        *,
        rack: NodeNamed = "world",
        rack_pose: PoseLike | None = None,
        adapter: NodeNamed | None = None,
        pose: PoseLike | None = None,
        tcp: str | None = None,
    ) -> Tool:
        """Take the chosen tool off, if there is one, and mount another one that is there, as one change; return that.

        Args:
            what: the tool or gripper to work with.
            rack: the node that the present tool is fixed to.
            rack_pose: where it goes there, 4x4; by default it stays where it is.
            adapter: as in `mount`, and so `pose` and `tcp`.
            pose: where the new one goes.
            tcp: the name of the tool centre point to work with.

        Example:
            >>> arm.change_tool("vacuum", rack="rack").set("on").wait()
        """
        batch = Batch()
        if self.state.tool:
            batch.unmount_tool(self.name, None, name_of(rack), rack_pose)
        batch.mount_tool(self.name, name_of(what), None if adapter is None else name_of(adapter), pose, tcp)
        self._services.apply(batch._commands)
        return self.tool()

    def pick(self, part: str | None = None, max_distance: float | None = None) -> str:
        """Fix a part to the chosen tool and return its name.

        Without a name it is the one nearest to the tool centre point. Its origin is at most `max_distance` (m) from
        there, by default 0.2 without a name and 1 with one.
        """
        return self._services.apply([pick_command(self.name, part, max_distance)]).picked_parts[0]

    def place(self, part: str | None = None, parent: str = "world") -> None:
        """Let a part go, or all; it stays where it is, fixed to `parent`."""
        Direct(self._services).place(self.name, part, parent)

    def __repr__(self) -> str:
        """Return a line for people."""

        def say() -> str:
            state = self.state
            x, y, z = state.world_t_tcp[:3, 3]
            count = len(self.joint_names)
            with_tool = f", tool {state.tool!r}" if state.tool else ""
            moving = f", moved by {', '.join(state.motion_ids)}" if state.motion_ids else ""
            joints = f"{count} joint{'s' * (count != 1)}"
            return f"{joints}{with_tool}, tool centre point at ({x:z.3f}, {y:z.3f}, {z:z.3f}) m{moving}"

        return told(f"Robot {self.name!r}", say)

    def _repr_html_(self) -> str:
        """Return a table of the joints for notebooks."""
        from virtualrobot.tables import joint_table_html

        return joint_table_html(self)
