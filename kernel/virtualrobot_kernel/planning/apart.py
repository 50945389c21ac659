"""Moves along a tool that stands apart from its robot, which carries what is worked on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.apart_path import ApartPath, ApartTcp
from virtualrobot_kernel.motion.bounds import TcpBound, TimeLaw
from virtualrobot_kernel.motion.cartesian_path import CartesianPath
from virtualrobot_kernel.motion.cartesian_plan import checked_joint_path, checked_start, plan_seen
from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.motion.path import joint_line
from virtualrobot_kernel.motion.planned import planned
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.profile import jerk_limited_profile
from virtualrobot_kernel.motion.resolved_rate import TcpKinematics
from virtualrobot_kernel.planning.free_joints import objective_of
from virtualrobot_kernel.planning.planned_move import PlannedMove, joint_limits
from virtualrobot_kernel.planning.redundancy import NearOf, Redundancy
from virtualrobot_kernel.planning.relative_frame import rows_above
from virtualrobot_kernel.planning.robots import Arm, SolverOf, tip_t_tcp
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.state import Snapshot


def tip_t_object(snapshot: Snapshot, arm: Arm, tool: str, carried: str) -> Pose:
    """Return where the object is at the arm's tip (4, 4); raise KernelError where the arm carries not it alone."""
    structure = snapshot.structure
    robot, tip = arm.robot.name, structure.rows[arm.tip]
    rows = rows_above(structure, structure.node(carried).uid)
    if tip not in rows or any(structure.coordinates_at(row) for row in rows[rows.index(tip) + 1 :]):
        raise KernelError(
            f"{robot!r} moves {carried or 'world'!r} along the tool {tool!r}, and must carry it: give the goal in the "
            f"frame of a node that is fixed below {structure.nodes[arm.tip].name!r}",
            robot=robot,
        )
    return inverse(snapshot.world_t(arm.tip)) @ snapshot.world_t(structure.node(carried).uid)


def apart_tcp(snapshot: Snapshot, arm: Arm, tool: str, carried: str, solver_of: SolverOf) -> ApartTcp:
    """Return a tool as the object sees it that an arm carries; raise KernelError as `tip_t_object` does."""
    held = TcpKinematics(solver_of(snapshot, arm), tip_t_object(snapshot, arm, tool, carried))
    base_t_tool = inverse(snapshot.world_t(arm.base)) @ snapshot.world_t(snapshot.structure.node(tool).uid)
    return ApartTcp(held, base_t_tool, (tool, carried))


def goal_of_tcp(snapshot: Snapshot, arm: Arm, tool: str, carried: str, object_t_tool: Pose) -> Pose:
    """Return world_t_tcp (4, 4) of the chosen tool centre point where the tool is at a pose in the object."""
    world_t_object = snapshot.world_t(snapshot.structure.node(tool).uid) @ inverse(object_t_tool)
    return world_t_object @ inverse(tip_t_object(snapshot, arm, tool, carried)) @ tip_t_tcp(snapshot, arm)


def plan_apart(
    snapshot: Snapshot,
    arm: Arm,
    tool: str,
    carried: str,
    path_from: Callable[[Array], CartesianPath],
    cartesian: CartesianLimits,
    velocity_scale: float,
    redundancy: Redundancy,
    time_law: TimeLaw,
    gentle: tuple[float, float],
    solver_of: SolverOf,
    near_of: NearOf | None,
) -> PlannedMove:
    """Return the move of an arm that leads what it carries along a tool.

    path_from: from object_t_tool (4, 4) at the start to the tool's path in the object. The tool keeps the limits in the
    frame of the object.
    """
    apart = apart_tcp(snapshot, arm, tool, carried, solver_of)
    limits, start = joint_limits(snapshot, arm.robot, arm.joint_names)
    objective = objective_of(snapshot, arm, redundancy, apart.held.jacobian, start, near_of)
    start, tcp = checked_start("Cartesian", apart.held.kinematics, start, limits, apart.held.tip_t_tcp, objective)
    base_t_object, slow = tcp.pose(start), cartesian.scaled(velocity_scale)
    way = ApartPath(base_t_object, path_from(inverse(base_t_object) @ apart.base_t_tool), apart.base_t_tool)
    if way.length or way.angle:
        path = checked_joint_path("Cartesian", tcp, way, start, limits)
        plan = plan_seen(way.kind, path, limits, apart, slow, velocity_scale, time_law, gentle)
    else:
        plan = planned(way.kind, joint_line(start, start), jerk_limited_profile(0.0, 1.0, 1.0, 1.0), limits)
    path = plan.tracks[0].path
    bound = TcpBound(path.start, path.end, slice(0, path.dimension), apart, slow)
    return PlannedMove(arm.robot, arm.joint_names, plan, speed_factor=velocity_scale, gentle=gentle, tcp=bound)


def moves_along(robot: str, tool: str) -> KernelError:
    """Return the error that a robot carries its tool."""
    return KernelError(
        f"the tool {tool!r} moves with {robot!r}; one that stands apart is carried by something else, or leave out "
        "fixed_tool",
        robot=robot,
    )


def stands_still(robot: str, tool: str) -> KernelError:
    """Return the error that other moves of the step move a tool, or the robot that works with it."""
    return KernelError(
        f"{robot!r} works with the tool {tool!r}, and other moves of the step move one of them; a tool that stands "
        "apart stands still",
        robot=robot,
    )


def share_apart(apart: ApartTcp, start: Array, goal: Array, velocity: Array, most: tuple[float, float]) -> float:
    """Return the share, up to 1, of the joints' speeds with which a tool keeps its own in the object on a joint move.

    velocity (k,): the joints' limits. most: m/s and rad/s; 0: any.
    """
    way = goal - start
    seconds = float(np.max(np.abs(way) / velocity, initial=0.0))
    if seconds == 0.0:
        return 1.0
    looks = start + np.linspace(0.0, 1.0, 257)[:, None] * way
    twists = np.array([apart.jacobian(q) @ way for q in looks]) / seconds
    fastest = [float(np.linalg.norm(part, axis=1).max()) for part in (twists[:, :3], twists[:, 3:])]
    return min([1.0, *(limit / speed for limit, speed in zip(most, fastest, strict=True) if limit and speed > 1e-12)])
