"""Motions: from moves of one or several robots, and a snapshot, to one planned motion."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import KernelError, UnknownNameError
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.circle import arc
from virtualrobot_kernel.motion.course import Course
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.line import line_between
from virtualrobot_kernel.motion.plan import Plan, plan_circ, plan_lin, plan_ptp, plan_together, plan_trajectory
from virtualrobot_kernel.motion.spline import spline
from virtualrobot_kernel.planning.actuators import check_plans
from virtualrobot_kernel.planning.carried import Carriers, carried_by, carriers, in_order, plan_carried
from virtualrobot_kernel.planning.free_joints import led_tcp, reached
from virtualrobot_kernel.planning.jog import CartesianJog, JogFrame, JointJog, cartesian_jog, joint_jog
from virtualrobot_kernel.planning.planned_move import (
    PlannedMove,
    PoseGoal,
    cartesian_limits,
    joint_limits,
    led_move,
    world_t_goal,
)
from virtualrobot_kernel.planning.robots import Arm, SolverOf, arm_of, arm_on_path, arms_of
from virtualrobot_kernel.planning.spline import Spline, moving_reference, spline_move
from virtualrobot_kernel.planning.wishes import (
    LED,
    ActuatorGoal,
    Circular,
    JointTrajectory,
    Linear,
    Move,
    PointToPoint,
    ToolStateMove,
)
from virtualrobot_kernel.world.actuators import joint_positions
from virtualrobot_kernel.world.apply_robots import tool_state
from virtualrobot_kernel.world.apply_signals import check_condition
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.groups import WHOLE
from virtualrobot_kernel.world.groups import joints_of as group_joints
from virtualrobot_kernel.world.preconditions import Preconditions, TcpPath, preconditions_of
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, Node, RobotData
from virtualrobot_kernel.world.tcp import chosen_tcp


def search_of(snapshot: Snapshot, moves: Sequence[Move]) -> Linear | None:
    """Return the one of some moves that searches, or None; raise KernelError for two, or for an unknown signal."""
    searches = [move for move in moves if isinstance(move, Linear) and move.until]
    if len(searches) > 1:
        raise KernelError(
            f"{searches[0].robot!r} and {searches[1].robot!r} both search; only one of the moves that go together can",
            robot=searches[1].robot,
        )
    for search in searches:
        assert search.until
        check_condition(snapshot.state, search.until)
    return searches[0] if searches else None


def plan_moves(snapshot: Snapshot, moves: Sequence[Move], solver_of: SolverOf) -> list[PlannedMove]:
    """Return the plan of each of some moves that go together; raise KernelError with place and reason."""
    if not moves:
        raise KernelError("a motion needs at least one move, or one step of a program", field="moves")
    planned = _planned(snapshot, moves, solver_of)
    joints = [(one.robot.name, name) for one in planned for name in one.joint_names]
    if len(set(joints)) != len(joints):
        robot, joint = next(pair for pair in joints if joints.count(pair) > 1)
        raise KernelError(f"two moves of one motion move the joint {joint!r} of {robot!r}", robot=robot, joint=joint)
    check_plans(snapshot, planned)
    for move, one in zip(moves, planned, strict=True):
        _check_group(snapshot, move, one)
    return [replace(one, group=move.group) for move, one in zip(moves, planned, strict=True)]


def _check_group(snapshot: Snapshot, move: Move, planned: PlannedMove) -> None:
    """Raise UnknownNameError for a joint that a move of a group moves and the group has not."""
    if move.group == WHOLE or isinstance(move, ToolStateMove):
        return
    names = group_joints(snapshot.structure, planned.robot, move.group)
    for name in planned.joint_names:
        if name not in names:
            raise UnknownNameError(f"joint of {planned.robot.name!r}{move.group}", name, names)


def _planned(snapshot: Snapshot, moves: Sequence[Move], solver_of: SolverOf) -> list[PlannedMove]:
    """Return the plan of each move, those that others carry after these; an error says for which robot it is."""
    needed, frames = [joints_of(snapshot, [move]) for move in moves], [_frames(snapshot, move) for move in moves]
    carrying = carried_by(snapshot, needed, frames)
    planned: dict[int, PlannedMove] = {}
    for place in in_order(carrying, [move.robot for move in moves]):
        move = moves[place]
        try:
            if carrying[place]:
                along = carriers(snapshot, [planned[other] for other in sorted(carrying[place])])
                planned[place] = _carried(snapshot, move, along, solver_of)
            else:
                planned[place] = PLANNERS[type(move)](snapshot, move, solver_of)
        except KernelError as error:
            error.metadata.setdefault("robot", move.robot)
            if "position" in error.metadata and move.group != WHOLE:
                # Where that is is told in the frame of the chain's base.
                base = arm_of(snapshot, snapshot.structure.node(move.robot, Kind.ROBOT), move.group).base
                error.metadata["base"] = snapshot.structure.nodes[base].name
            raise
    timed = next((move for move in moves if isinstance(move, JointTrajectory)), None)
    if timed is not None and (one := next((one for one in planned.values() if one.seen), None)):
        raise KernelError(
            f"the joint trajectory of {timed.robot!r} has times of its own, and moves that go together with a carried "
            f"one, that of {one.robot.name!r}, have one law; give other moves, or a step for each",
            robot=timed.robot,
        )
    return [planned[place] for place in range(len(moves))]


def _frames(snapshot: Snapshot, move: Move) -> list[int]:
    """Return the nodes (uids) whose places count all along a move: the arm's base, and a reference that moves."""
    structure = snapshot.structure
    if isinstance(move, ToolStateMove | JointTrajectory) or not solved_robots(snapshot, [move]):
        return []
    frames = [arm_of(snapshot, structure.node(move.robot, Kind.ROBOT), move.group).base]
    if isinstance(move, Circular) and move.moving:
        frames.append(structure.node(move.reference).uid)
    if isinstance(move, Spline) and (reference := moving_reference(move)) is not None:
        frames.append(structure.node(reference).uid)
    if isinstance(move, Linear | PointToPoint) and isinstance(move.goal, PoseGoal) and move.goal.moving:
        frames.append(structure.node(move.goal.reference).uid)
    return frames


def _carried(snapshot: Snapshot, move: Move, along: Carriers, solver_of: SolverOf) -> PlannedMove:
    """Return the plan of a move that others carry."""
    node = snapshot.structure.node(move.robot, Kind.ROBOT)
    if isinstance(move, PointToPoint) and isinstance(move.goal, PoseGoal):
        there = along.arrived()
        world_t_tcp = world_t_goal(there if move.goal.moving else snapshot, move.goal)
        goal = replace(move.goal, reference_t_tcp=world_t_tcp, reference="")
        return _point_to_point(there, replace(move, goal=goal), solver_of)
    if not isinstance(move, Linear | Circular | Spline):
        carrying = " and ".join(repr(one.robot.name) for one in along.moves)
        raise KernelError(
            f"{node.name!r} is carried by the move of {carrying}; only a line, an arc, a spline or a move to a pose "
            "can go along",
            robot=node.name,
        )
    if isinstance(move, Linear):
        reference, moving = move.goal.reference, move.goal.moving
    elif isinstance(move, Spline):
        reference, moving = moving_reference(move) or "", moving_reference(move) is not None
        goals = [goal.reference_t_tcp if moving else world_t_goal(snapshot, goal) for goal in move.goals]
    else:
        reference, moving = move.reference, move.moving

    def course(reference_t_start: Pose) -> Course:
        if isinstance(move, Linear):
            return line_between(reference_t_start, move.goal.reference_t_tcp)
        if isinstance(move, Spline):
            return spline(reference_t_start, goals)
        return arc(reference_t_start, move.shape, move.reference_t_goal, move.with_arc)

    return plan_carried(
        snapshot,
        arm_on_path(snapshot, node, move.redundancy, move.group),
        along,
        course,
        snapshot.structure.node(reference).uid,
        moving,
        cartesian_limits(move.max_velocity, move.max_acceleration),
        move.speed_factor or 1.0,
        solver_of,
    )


def together(planned: Sequence[PlannedMove]) -> Plan:
    """Return the one plan of moves that start and end together, their joints one after the other."""
    return planned[0].plan if len(planned) == 1 else plan_together([one.plan for one in planned])


def joints_of(snapshot: Snapshot, moves: Sequence[Move]) -> set[tuple[int, str]]:
    """Return the joints that moves need, as (robot uid, joint name)."""
    needed: set[tuple[int, str]] = set()
    for move in moves:
        node = snapshot.structure.node(move.robot, Kind.ROBOT)
        if isinstance(move, ToolStateMove):
            names: Sequence[str] = tuple(_tool_positions(snapshot, node, move)[1])
        elif isinstance(move, JointTrajectory):
            names = move.joint_names
        elif isinstance(move, JointJog):
            names = (move.joint,)
        elif isinstance(move, PointToPoint) and not isinstance(move.goal, PoseGoal):
            names = tuple(goal_positions(node, move.goal, _group_joints(snapshot, node, move)))
        elif isinstance(move, PointToPoint):
            names = arm_of(snapshot, node, move.group).joint_names
        else:
            names = arm_on_path(snapshot, node, move.redundancy, move.group).joint_names
        needed |= {(node.uid, name) for name in names}
    return needed


def moved_arms(snapshot: Snapshot, moves: Sequence[Move]) -> list[Arm]:
    """Return the arms of the robots and groups that moves are for."""
    return arms_of(snapshot, ((snapshot.structure.node(move.robot, Kind.ROBOT), move.group) for move in moves))


def solved_robots(snapshot: Snapshot, moves: Sequence[Move]) -> set[int]:
    """Return the robots (uids) whose components moves need."""
    return {
        snapshot.structure.node(move.robot, Kind.ROBOT).uid
        for move in moves
        if isinstance(move, LED) or (isinstance(move, PointToPoint) and isinstance(move.goal, PoseGoal))
    }


def preconditions_by(snapshot: Snapshot, moves: Sequence[Move], joints: Iterable[tuple[str, str]]) -> Preconditions:
    """Return what the plan of these moves, which moves these joints (robot, joint), assumes of the world."""
    structure = snapshot.structure
    ways: list[TcpPath] = []
    postures: list[tuple[int, str]] = []
    tool_states: list[tuple[int, str]] = []
    for move in moves:
        robot = structure.node(move.robot, Kind.ROBOT)
        if solved_robots(snapshot, [move]):
            ways.append(TcpPath(robot.uid, tuple(structure.node(name).uid for name in _references(move)), move.group))
        elif isinstance(move, ToolStateMove):
            tool_states.append((structure.node(_tool_positions(snapshot, robot, move)[0]).uid, move.state))
        elif isinstance(move, PointToPoint) and isinstance(move.goal, str):
            postures.append((robot.uid, move.goal))
    uids = ((structure.node(robot, Kind.ROBOT).uid, joint) for robot, joint in joints)
    return preconditions_of(structure, snapshot.state, uids, ways, postures, tool_states)


def _references(move: Move) -> tuple[str, ...]:
    """Return the nodes in whose frames the goals of a move are."""
    if isinstance(move, Circular):
        return (move.reference,)
    if isinstance(move, Spline):
        return tuple(dict.fromkeys(goal.reference for goal in move.goals))
    if isinstance(move, CartesianJog):
        return (move.node,) if move.frame is JogFrame.NODE else ()
    goal = getattr(move, "goal", None)
    return (goal.reference,) if isinstance(goal, PoseGoal) else ()


def _point_to_point(snapshot: Snapshot, move: PointToPoint, solver_of: SolverOf) -> PlannedMove:
    node = snapshot.structure.node(move.robot, Kind.ROBOT)
    if isinstance(move.goal, PoseGoal):
        arm, goal = _solved(snapshot, node, move, move.goal, solver_of)
        limits, start = joint_limits(snapshot, node, arm.joint_names)
        goal = _nearest_turn(goal, start, limits)
        speed_factor = move.speed_factor or 1.0
        plan = plan_ptp(start, goal, limits, speed_factor, move.time_law)
        return PlannedMove(node, arm.joint_names, plan, speed_factor=speed_factor)
    positions = goal_positions(node, move.goal, _group_joints(snapshot, node, move))
    return _to_joints(snapshot, node, positions, move.speed_factor, move.time_law)


def _to_joints(
    snapshot: Snapshot, node: Node, positions: Mapping[str, float], speed_factor: float, time_law: TimeLaw
) -> PlannedMove:
    names = tuple(positions)
    limits, start = joint_limits(snapshot, node, names)
    goal = np.array([positions[name] for name in names])
    speed_factor = speed_factor or 1.0
    plan = plan_ptp(start, goal, limits, speed_factor, time_law)
    return PlannedMove(node, names, plan, speed_factor=speed_factor)


def _group_joints(snapshot: Snapshot, node: Node, move: PointToPoint) -> Sequence[str] | None:
    return None if move.group == WHOLE else group_joints(snapshot.structure, node, move.group)


def goal_positions(
    node: Node, goal: Mapping[str, float] | PoseGoal | str | ActuatorGoal, joints: Sequence[str] | None = None
) -> Mapping[str, float]:
    """Return the joint values of a goal that is no pose; of a posture only those of a group's `joints`, if given.

    Raises UnknownNameError for a posture that there is not.
    """
    if isinstance(goal, ActuatorGoal):
        return joint_positions(node, goal.positions)
    if isinstance(goal, str):
        postures = node.data.postures if isinstance(node.data, RobotData) else {}
        if goal not in postures:
            raise UnknownNameError(f"posture of {node.name!r}", goal, postures)
        goal = {name: value for name, value in postures[goal].items() if joints is None or name in joints}
    assert not isinstance(goal, PoseGoal)
    if not goal:
        raise KernelError(
            f"the move of {node.name!r} names no joint{' of its group' if joints else ''}: give the positions of those "
            "that shall move",
            robot=node.name,
        )
    return goal


def _linear(snapshot: Snapshot, move: Linear, solver_of: SolverOf) -> PlannedMove:
    node = snapshot.structure.node(move.robot, Kind.ROBOT)
    arm = arm_on_path(snapshot, node, move.redundancy, move.group)
    limits, start = joint_limits(snapshot, node, arm.joint_names)
    base_t_goal = inverse(snapshot.world_t(arm.base)) @ world_t_goal(snapshot, move.goal)
    tcp = led_tcp(snapshot, arm, solver_of, move.redundancy)
    cartesian, speed_factor = cartesian_limits(move.max_velocity, move.max_acceleration), move.speed_factor or 1.0
    plan = plan_lin(
        tcp.kinematics, start, base_t_goal, limits, cartesian, speed_factor, tcp.tip_t_tcp, move.time_law, tcp.wish
    )
    return led_move(node, arm, plan, tcp, cartesian, speed_factor)


def _circular(snapshot: Snapshot, move: Circular, solver_of: SolverOf) -> PlannedMove:
    node = snapshot.structure.node(move.robot, Kind.ROBOT)
    arm = arm_on_path(snapshot, node, move.redundancy, move.group)
    limits, start = joint_limits(snapshot, node, arm.joint_names)
    world_t_reference = snapshot.world_t(snapshot.structure.node(move.reference).uid)
    base_t_reference = inverse(snapshot.world_t(arm.base)) @ world_t_reference
    tcp = led_tcp(snapshot, arm, solver_of, move.redundancy)
    cartesian, speed_factor = cartesian_limits(move.max_velocity, move.max_acceleration), move.speed_factor or 1.0
    plan = plan_circ(
        tcp.kinematics,
        start,
        move.shape.seen_from(base_t_reference),
        None if move.reference_t_goal is None else base_t_reference @ move.reference_t_goal,
        limits,
        cartesian,
        speed_factor,
        tcp.tip_t_tcp,
        move.with_arc,
        move.time_law,
        tcp.wish,
    )
    return led_move(node, arm, plan, tcp, cartesian, speed_factor)


def _joint_trajectory(snapshot: Snapshot, move: JointTrajectory, solver_of: SolverOf) -> PlannedMove:
    node = snapshot.structure.node(move.robot, Kind.ROBOT)
    if not move.joint_names or len(set(move.joint_names)) != len(move.joint_names):
        raise KernelError(
            f"a trajectory must name its joints, each once, not {list(move.joint_names)}", robot=node.name
        )
    limits, start = joint_limits(snapshot, node, move.joint_names)
    return PlannedMove(
        node, move.joint_names, plan_trajectory(start, move.times, move.positions, move.velocities, limits)
    )


def _tool_state(snapshot: Snapshot, move: ToolStateMove, solver_of: SolverOf) -> PlannedMove:
    node = snapshot.structure.node(move.robot, Kind.ROBOT)
    tool, positions = _tool_positions(snapshot, node, move)
    # A state without joints, such as a vacuum, is there with the next tick.
    planned = _to_joints(snapshot, node, positions, move.speed_factor, move.time_law)
    return replace(planned, tool_states=((tool, move.state),))


def _tool_positions(snapshot: Snapshot, node: Node, move: ToolStateMove) -> tuple[str, dict[str, float]]:
    structure = snapshot.structure
    tip = 0 if move.group == WHOLE else arm_of(snapshot, node, move.group).tip
    chosen, _ = chosen_tcp(structure, snapshot.state, node, tip)
    name = move.tool or (chosen.name if chosen else "")
    tools = [tool.name for tool in structure.tools_of(node.uid)]
    if name not in tools:
        raise UnknownNameError(f"tool of {node.name!r}", name, tools)
    return name, tool_state(structure, name, move.state)[1]


PLANNERS: dict[type, Callable[[Snapshot, Any, SolverOf], PlannedMove]] = {
    PointToPoint: _point_to_point,
    Linear: _linear,
    Circular: _circular,
    JointTrajectory: _joint_trajectory,
    ToolStateMove: _tool_state,
    Spline: spline_move,
    JointJog: joint_jog,
    CartesianJog: cartesian_jog,
}


def _solved(
    snapshot: Snapshot, node: Node, move: PointToPoint, goal: PoseGoal, solver_of: SolverOf
) -> tuple[Arm, NDArray[np.float64]]:
    world_t_tcp = world_t_goal(snapshot, goal)
    arm, solutions = reached(snapshot, node, world_t_tcp, solver_of, goal.configuration, move.redundancy, move.group)
    return arm, solutions[0]


def _nearest_turn(goal: NDArray[np.float64], start: NDArray[np.float64], limits: JointLimits) -> NDArray[np.float64]:
    """Return the goal with joints that turn without limits brought within half a turn of where they are."""
    free = np.isinf(limits.lower) & np.isinf(limits.upper)
    turns = np.round((goal - start) / (2 * np.pi))
    return np.where(free, goal - 2 * np.pi * turns, goal)
