"""RobotService: states of joints and tools, and kinematics."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import AsyncIterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from virtualrobot.v1 import robot_pb2, robot_pb2_grpc
from virtualrobot_sdk.selfcheck import SelfCheck

from virtualrobot_kernel.api.convert.commands import kinematics_command
from virtualrobot_kernel.api.convert.redundancy import requested_redundancy
from virtualrobot_kernel.api.convert.states import robot_states, robots_named
from virtualrobot_kernel.api.driving import reckoned_drives, solved_drives
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.message_parts import TOGETHER_BYTES, parts
from virtualrobot_kernel.collision.clearance import near_by
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.messages.nodes import JOINT_TYPES, LIMITS
from virtualrobot_kernel.messages.robots import ROBOT, group_selection
from virtualrobot_kernel.messages.structs import settings_message
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.messages.values import (
    array,
    array_message,
    mask_fields,
    masked,
    pose,
    pose_message,
    poses_array,
    stamp,
    vector,
)
from virtualrobot_kernel.physics.exerted import Exerted
from virtualrobot_kernel.planning.dynamics import EffortViolation, solve_inverse_dynamics
from virtualrobot_kernel.planning.free_joints import solve_inverse
from virtualrobot_kernel.planning.jacobian import Point, solve_jacobian
from virtualrobot_kernel.planning.points import solve_points
from virtualrobot_kernel.planning.robots import arm_if_chain, arm_of, forward_links, joint_vector
from virtualrobot_kernel.planning.solvers import chosen
from virtualrobot_kernel.world.groups import Group, joints_of
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import Applied
from virtualrobot_kernel.world.structure import Kind, Node, RobotData

MOST_POINTS = 10_000
"""Greatest number of points in one call of SolveJacobian."""

MOST_PAGES = 16
"""So many of the latest snapshots are kept as messages: who is told each tick gets several at once."""

MOST_PLACES = 100_000
"""Greatest number of points in one call of SolvePoints."""

EFFORT_VIOLATION = Table(EffortViolation, robot_pb2.EffortViolation)
SELF_CHECK = Table(
    SelfCheck,
    robot_pb2.KinematicsCheck,
    names={
        "forward_position": "forward_position_error_meters",
        "forward_rotation": "forward_rotation_error_radians",
        "inverse_position": "inverse_position_error_meters",
        "inverse_rotation": "inverse_rotation_error_radians",
        "jacobian": "jacobian_error",
    },
    without=("solved",),
)


class RobotServicer(robot_pb2_grpc.RobotServiceServicer):
    """Servicer of RobotService."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel
        self._book = _Book(kernel.forces.exerted)

    async def GetRobot(self, request: robot_pb2.GetRobotRequest, context: object) -> robot_pb2.GetRobotResponse:
        """Tell joints, links and tools; and the chain of a group."""
        snapshot = self._kernel.world.snapshot
        structure = snapshot.structure
        node, index = structure.robot(request.name)
        data = node.data if isinstance(node.data, RobotData) else RobotData()
        group = group_selection(request.group, "group")
        arm, kinematics = arm_if_chain(snapshot, node, group), ""
        if arm is not None:
            kinematics = chosen(node, group)[0] or self._kernel.solvers.name_found(node, group)
        if arm is not None and not kinematics:
            # The robot has to be tried to tell; that is not for the thread that all calls share.
            find = partial(self._kernel.solvers.name_of, snapshot, arm)
            kinematics = await self._kernel.limiter.run([node.uid], find)
        settings = chosen(node, group)[1]
        described = ROBOT.write(data, joint_names=index.joint_names)
        for message in described.groups:
            message.joint_names[:] = joints_of(structure, node, Group(message.name))
        return robot_pb2.GetRobotResponse(
            stamp=stamp(snapshot),
            uid=node.uid,
            robot=described,
            joints=[
                robot_pb2.JointDescription(
                    name=joint.name,
                    type=JOINT_TYPES.write(joint.type),
                    limits=LIMITS.write(joint.limits),
                    coordinate_count=joint.type.coordinate_count,
                    velocity_count=joint.type.velocity_count,
                    coordinate_names=joint.coordinate_names,
                )
                for joint in index.joints
            ],
            links=[structure.nodes[uid].name for uid in index.links],
            tools=[tool.name for tool in structure.tools_of(node.uid)],
            flange=structure.nodes[arm.tip].name if arm is not None else "",
            kinematics=kinematics,
            chain_joints=arm.joint_names if arm else index.coordinates_of(joints_of(structure, node, group)),
            kinematics_settings=settings_message(settings) if settings else None,
            kinematics_fault=self._kernel.solvers.fault_of(node, group),
        )

    async def GetRobotStates(
        self, request: robot_pb2.GetRobotStatesRequest, context: object
    ) -> robot_pb2.GetRobotStatesResponse:
        """Tell where robots are."""
        snapshot = self._kernel.world.snapshot
        fields = mask_fields(request.read_mask, robot_pb2.RobotState)
        robots = self._book.states(snapshot, robots_named(snapshot, request.names))
        return robot_pb2.GetRobotStatesResponse(
            stamp=stamp(snapshot), robots=[_copy(robot, fields) for robot in robots]
        )

    async def WatchRobotStates(
        self, request: robot_pb2.WatchRobotStatesRequest, context: object
    ) -> AsyncIterator[robot_pb2.WatchRobotStatesResponse]:
        """Tell where robots are, then those that change."""
        fields = mask_fields(request.read_mask, robot_pb2.RobotState)
        watched = frozenset(node.uid for node in robots_named(self._kernel.world.snapshot, request.names))
        told: _Told | None = None
        if request.every_tick:
            async for ticks in self._kernel.publications.every_tick(request.max_rate_hertz):
                messages = []
                for lost, snapshot in ticks:
                    message = robot_pb2.WatchRobotStatesResponse(stamp=stamp(snapshot), lost_ticks=lost)
                    if told is not None and _quiet(told.snapshot, snapshot):
                        told = replace(told, snapshot=snapshot)
                    else:
                        told = self._book.news(told, snapshot, watched if request.names else None, fields)
                        if told.message is not None:
                            message.MergeFrom(told.message)
                    messages.append(message)
                for part in parts(messages, TOGETHER_BYTES):
                    yield robot_pb2.WatchRobotStatesResponse(stamp=part[-1].stamp, ticks=part)
            return
        async for snapshot in self._kernel.publications.snapshots(request.max_rate_hertz):
            if told is not None and _quiet(told.snapshot, snapshot):
                continue
            told = self._book.news(told, snapshot, watched if request.names else None, fields)
            if told.message is not None:
                yield told.message

    async def SolveForward(
        self, request: robot_pb2.SolveForwardRequest, context: object
    ) -> robot_pb2.SolveForwardResponse:
        """Tell where links would be."""
        snapshot = self._kernel.world.snapshot
        node = snapshot.structure.node(request.robot, Kind.ROBOT)
        group, positions = group_selection(request.group, "group"), dict(request.joint_positions)
        world_t_link, world_t_tcp = forward_links(snapshot, node, positions, group)

        def configuration() -> str:
            arm = arm_of(snapshot, node, group)
            return self._kernel.solvers.of(snapshot, arm).configuration(joint_vector(snapshot, arm, positions))

        named = await self._kernel.limiter.run([node.uid], configuration) if request.with_configuration else ""
        links = snapshot.structure.robots[node.uid].links
        return robot_pb2.SolveForwardResponse(
            stamp=stamp(snapshot),
            world_t_tcp=pose_message(world_t_tcp),
            links=[snapshot.structure.nodes[uid].name for uid in links],
            world_t_link=poses_array(world_t_link),
            configuration=named,
        )

    async def SolveJacobian(
        self, request: robot_pb2.SolveJacobianRequest, context: object
    ) -> robot_pb2.SolveJacobianResponse:
        """Tell how points move with joints, in a worker thread."""
        snapshot = self._kernel.world.snapshot
        structure = snapshot.structure
        node = structure.node(request.robot, Kind.ROBOT)
        if len(request.points) > MOST_POINTS:
            raise KernelError(
                f"{len(request.points)} points are too many; give at most {MOST_POINTS} at a time",
                reason=Reason.TOO_LARGE,
                field="points",
            )
        points = [
            Point(
                structure.node(point.node).uid,
                structure.node(point.reference).uid,
                np.array(vector(point.point, f"points[{row}].point")),
            )
            for row, point in enumerate(request.points)
        ]
        group = group_selection(request.group, "group")
        solve = partial(solve_jacobian, snapshot, node, dict(request.joint_positions), points, group)
        found = await self._kernel.in_worker(solve)
        return robot_pb2.SolveJacobianResponse(
            stamp=stamp(snapshot),
            joint_names=found.joint_names,
            world_t_tcp=pose_message(found.world_t_tcp),
            tcp_jacobian=array_message(found.tcp),
            point_jacobians=array_message(found.points),
        )

    async def SolveInverse(
        self, request: robot_pb2.SolveInverseRequest, context: object
    ) -> robot_pb2.SolveInverseResponse:
        """Tell which joints reach a pose."""
        snapshot = self._kernel.world.snapshot
        node = snapshot.structure.node(request.robot, Kind.ROBOT)
        reference = snapshot.structure.node(request.reference)
        world_t_tcp = snapshot.world_t(reference.uid) @ pose(request.reference_t_tcp, "reference_t_tcp")
        seed, solver_of = dict(request.seed), self._kernel.solvers.of
        redundancy = requested_redundancy(request.redundancy, "redundancy")
        group, near_of = group_selection(request.group, "group"), near_by(self._kernel.collisions)
        options = seed, solver_of, request.configuration, redundancy, group, near_of
        solve = partial(solve_inverse, snapshot, node, world_t_tcp, *options)
        arm, result = await self._kernel.limiter.run([node.uid], solve)
        return robot_pb2.SolveInverseResponse(
            stamp=stamp(snapshot),
            status=getattr(robot_pb2, f"INVERSE_STATUS_{result.status.name}"),
            joint_names=arm.joint_names,
            solutions=array_message(np.asarray(result.solutions).reshape(-1, len(arm.joint_names))),
            configurations=result.configurations,
            position_error_meters=result.position_error,
            rotation_error_radians=result.rotation_error,
            explanation=result.reason,
            arm_angles_radians=result.arm_angles,
        )

    async def SolvePoints(
        self, request: robot_pb2.SolvePointsRequest, context: object
    ) -> robot_pb2.SolvePointsResponse:
        """Tell which joints reach points, in a worker thread."""
        snapshot = self._kernel.world.snapshot
        node = snapshot.structure.node(request.robot, Kind.ROBOT)
        reference = snapshot.structure.node(request.reference)
        points = array(request.points, (None, 3), "points")
        if len(points) > MOST_PLACES:
            raise KernelError(
                f"{len(points)} points are too many; give at most {MOST_PLACES} at a time",
                reason=Reason.TOO_LARGE,
                field="points",
            )
        options = reference.uid, dict(request.seed), group_selection(request.group, "group")
        found = await self._kernel.in_worker(partial(solve_points, snapshot, node, points, *options))
        return robot_pb2.SolvePointsResponse(
            stamp=stamp(snapshot),
            status=getattr(robot_pb2, f"INVERSE_STATUS_{found.status.name}"),
            joint_names=found.joint_names,
            positions=array_message(found.positions),
            position_error_meters=found.position_error,
            explanation=found.reason,
        )

    async def SolveDrives(
        self, request: robot_pb2.SolveDrivesRequest, context: object
    ) -> robot_pb2.SolveDrivesResponse:
        """Tell where drives of a craft have to be for a way."""
        return await solved_drives(self._kernel, request)

    async def ReckonDrives(
        self, request: robot_pb2.ReckonDrivesRequest, context: object
    ) -> robot_pb2.ReckonDrivesResponse:
        """Tell where drives have taken a craft."""
        return await reckoned_drives(self._kernel, request)

    async def SetKinematics(
        self, request: robot_pb2.SetKinematicsRequest, context: object
    ) -> robot_pb2.SetKinematicsResponse:
        """Try a component on the robot in a worker thread, then choose it."""
        kernel = self._kernel
        snapshot = kernel.world.snapshot
        command = kinematics_command(request.choice)
        node = snapshot.structure.node(command.robot, Kind.ROBOT)
        submit = kernel.submitting(context)

        def swap() -> tuple[Applied, SelfCheck]:
            # All in one thread: a client that goes away cancels what is awaited, and a component must not be lost.
            arm = arm_of(snapshot, node, Group(command.group))
            choice = command.kinematics, command.settings
            return kernel.solvers.swap(snapshot, arm, *choice, lambda: submit([command]).result())

        applied, check = await kernel.limiter.run([node.uid], swap)
        return robot_pb2.SetKinematicsResponse(stamp=stamp(applied.snapshot), check=SELF_CHECK.write(check))

    async def SolveInverseDynamics(
        self, request: robot_pb2.SolveInverseDynamicsRequest, context: object
    ) -> robot_pb2.SolveInverseDynamicsResponse:
        """Tell which efforts a movement takes, in a worker thread."""
        snapshot = self._kernel.world.snapshot
        node = snapshot.structure.node(request.robot, Kind.ROBOT)
        given = {
            name: getattr(request, name)
            for name in ("positions", "velocities", "accelerations")
            if request.HasField(name)
        }
        # Of any shape here: which one is right is the robot's matter.
        movement = {name: array(values, [None] * len(values.shape), name) for name, values in given.items()}
        solve = partial(solve_inverse_dynamics, snapshot, node, tuple(request.joint_names), **movement)
        found = await self._kernel.in_worker(solve)
        return robot_pb2.SolveInverseDynamicsResponse(
            stamp=stamp(snapshot),
            joint_names=found.joint_names,
            efforts=array_message(found.efforts),
            gravity_efforts=array_message(found.gravity_efforts),
            base_wrenches=array_message(found.base_wrenches),
            first_violation=found.first_violation and EFFORT_VIOLATION.write(found.first_violation),
            payload_kilograms=found.payload,
            warnings=found.warnings,
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Told:
    """State of a watch up to a snapshot: the states told by uid, and its last message (None: there was no news)."""

    snapshot: Snapshot
    states: Mapping[int, robot_pb2.RobotState]
    message: robot_pb2.WatchRobotStatesResponse | None


@dataclass(frozen=True, slots=True, eq=False)
class _Page:
    """Messages of one snapshot: states of robots by uid, and news by what was told before and is wanted."""

    snapshot: Snapshot
    messages: dict[int, robot_pb2.RobotState] = field(default_factory=dict)
    news: dict[tuple, _Told] = field(default_factory=dict)


class _Book:
    """States of robots in the latest snapshots as messages, made once for all who watch."""

    def __init__(self, exerted: Exerted) -> None:
        self._pages: OrderedDict[int, _Page] = OrderedDict()
        self._exerted = exerted

    def _page(self, snapshot: Snapshot) -> _Page:
        page = self._pages.get(snapshot.revision)
        if page is None or page.snapshot is not snapshot:
            page = self._pages[snapshot.revision] = _Page(snapshot)
            if len(self._pages) > MOST_PAGES:
                self._pages.popitem(last=False)
        return page

    def states(self, snapshot: Snapshot, robots: Sequence[Node]) -> list[robot_pb2.RobotState]:
        """Return the states of some robots; not to be changed."""
        messages = self._page(snapshot).messages
        missing = [node for node in robots if node.uid not in messages]
        for node, message in zip(missing, robot_states(snapshot, missing, self._exerted), strict=True):
            messages[node.uid] = message
        return [messages[node.uid] for node in robots]

    def news(
        self, before: _Told | None, snapshot: Snapshot, watched: frozenset[int] | None, fields: frozenset[str] | None
    ) -> _Told:
        """Return the news since `before` of the watched robots (None: of all); the same for equal watches."""
        key = (before and before.snapshot.revision, watched, fields)
        page = self._page(snapshot)
        if key in page.news:
            return page.news[key]
        nodes = [
            snapshot.structure.nodes[uid] for uid in snapshot.structure.robots if watched is None or uid in watched
        ]
        states = [_copy(state, fields) for state in self.states(snapshot, nodes)]
        now = {node.uid: state for node, state in zip(nodes, states, strict=True)}
        old = before.states if before else {}
        changed = [state for uid, state in now.items() if old.get(uid) != state]
        names = {state.name for state in states}
        removed = [state.name for state in old.values() if state.name not in names]
        message = None
        if changed or removed or before is None:
            message = robot_pb2.WatchRobotStatesResponse(stamp=stamp(snapshot), robots=changed, removed_names=removed)
        page.news[key] = told = _Told(snapshot, now, message)
        return told


def _copy(message: robot_pb2.RobotState, fields: frozenset[str] | None) -> robot_pb2.RobotState:
    if fields is None:
        return message
    copy = robot_pb2.RobotState()
    copy.CopyFrom(message)
    return masked(copy, fields | {"name"})


def _quiet(before: Snapshot, after: Snapshot) -> bool:
    """Return whether nothing but time has gone on between two snapshots."""
    a, b = before.state, after.state
    return before.structure is after.structure and all(getattr(a, field) is getattr(b, field) for field in TOLD)


TOLD = (
    *("q", "v", "commanded", "motored", "parent_t_node", "motions", "tool_states", "selections"),
    *("speed_factors", "tcp_speed_limits"),
)
"""Fields of State that RobotState tells of."""
