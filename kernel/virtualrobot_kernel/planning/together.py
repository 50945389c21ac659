"""Moves that go together: their joints, their assumptions about the world, and the plan of each."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from virtualrobot_kernel.errors import KernelError, UnknownNameError
from virtualrobot_kernel.planning.actuators import check_plans
from virtualrobot_kernel.planning.apart import moves_along
from virtualrobot_kernel.planning.moves import Move
from virtualrobot_kernel.planning.moving_base import carried_by, check_turns, in_order, moving_base, no_common_law
from virtualrobot_kernel.planning.planned_move import PlannedMove
from virtualrobot_kernel.planning.redundancy import NearOf
from virtualrobot_kernel.planning.robots import Arm, SolverOf, arm_of, arms_of
from virtualrobot_kernel.world import groups
from virtualrobot_kernel.world.apply_signals import check_condition
from virtualrobot_kernel.world.groups import WHOLE
from virtualrobot_kernel.world.preconditions import Preconditions, TcpPath, preconditions_of
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind


def search_of(snapshot: Snapshot, moves: Sequence[Move]) -> Move | None:
    """Return the one of some moves that searches, or None; raise KernelError for two, or for an unknown signal."""
    searches = [move for move in moves if move.search]
    if len(searches) > 1:
        raise KernelError(
            f"{searches[0].robot!r} and {searches[1].robot!r} both search; only one of the moves that go together can",
            robot=searches[1].robot,
        )
    for move in searches:
        assert move.search
        check_condition(snapshot.state, move.search)
    return searches[0] if searches else None


def joints_of(snapshot: Snapshot, moves: Iterable[Move]) -> set[tuple[int, str]]:
    """Return the joints that moves need, as (robot uid, joint name)."""
    return {(move.owner(snapshot).uid, name) for move in moves for name in move.joint_names(snapshot)}


def moved_arms(snapshot: Snapshot, moves: Iterable[Move]) -> list[Arm]:
    """Return the arms of the robots and groups that moves are for."""
    return arms_of(snapshot, ((move.node(snapshot), move.group) for move in moves))


def solved_robots(snapshot: Snapshot, moves: Iterable[Move]) -> set[int]:
    """Return the robots (uids) whose components moves need."""
    return {move.node(snapshot).uid for move in moves if move.solved}


def preconditions_by(snapshot: Snapshot, moves: Iterable[Move], joints: Iterable[tuple[str, str]]) -> Preconditions:
    """Return the assumptions about the world of the plan of these moves, which moves these joints (robot, joint)."""
    structure = snapshot.structure
    ways: list[TcpPath] = []
    postures: list[tuple[int, str]] = []
    tool_states: list[tuple[int, str]] = []
    for move in moves:
        robot = move.node(snapshot).uid
        if move.solved:
            ways.append(TcpPath(robot, tuple(structure.node(name).uid for name in move.frames), move.group))
        tool_states += [(structure.node(tool).uid, state) for tool, state in move.tool_states(snapshot)]
        postures += [(robot, move.posture)] if move.posture else []
    uids = ((structure.node(robot, Kind.ROBOT).uid, joint) for robot, joint in joints)
    return preconditions_of(structure, snapshot.state, uids, ways, postures, tool_states)


def plan_moves(
    snapshot: Snapshot, moves: Sequence[Move], solver_of: SolverOf, near_of: NearOf | None = None
) -> list[PlannedMove]:
    """Return the plan of each of some moves that go together; raise KernelError with place and reason."""
    if not moves:
        raise KernelError("a motion needs at least one move, or one step of a program", field="moves")
    planned = _each(snapshot, moves, solver_of, near_of)
    joints = [(one.robot.name, name) for one in planned for name in one.joint_names]
    if len(set(joints)) != len(joints):
        robot, joint = next(pair for pair in joints if joints.count(pair) > 1)
        raise KernelError(f"two moves of one motion move the joint {joint!r} of {robot!r}", robot=robot, joint=joint)
    check_plans(snapshot, planned)
    for move, one in zip(moves, planned, strict=True):
        _check_group(snapshot, move, one)
    # The joints of a gripper are of no group of its arm.
    return [
        replace(one, group=move.group) if one.robot.name == move.robot else one
        for move, one in zip(moves, planned, strict=True)
    ]


def _check_group(snapshot: Snapshot, move: Move, planned: PlannedMove) -> None:
    """Raise UnknownNameError for a joint that a move of a group moves and the group has not."""
    if move.group == WHOLE or move.other_joints:
        return
    names = groups.joints_of(snapshot.structure, planned.robot, move.group)
    for name in planned.joint_names:
        if snapshot.structure.robots[planned.robot.uid].joint_of(name) not in names:
            raise UnknownNameError(f"joint of {planned.robot.name!r}{move.group}", name, names)


def _each(snapshot: Snapshot, moves: Sequence[Move], solver_of: SolverOf, near_of: NearOf | None) -> list[PlannedMove]:
    """Return the plan of each move, those that others carry after these; an error says for which robot it is."""
    carrying = carried_by(
        snapshot, [joints_of(snapshot, [move]) for move in moves], [_frames(snapshot, move) for move in moves]
    )
    for place, move in enumerate(moves):
        if move.fixed_tool and place in carrying[place]:
            raise moves_along(move.robot, move.fixed_tool)
    planned: dict[int, PlannedMove] = {}
    for place in in_order(carrying, [move.robot for move in moves]):
        move = moves[place]
        try:
            if carrying[place]:
                base = moving_base(snapshot, [planned[other] for other in sorted(carrying[place])])
                planned[place] = move.plan_on(base, solver_of, near_of)
            else:
                planned[place] = move.plan(snapshot, solver_of, near_of)
        except KernelError as error:
            error.metadata.setdefault("robot", move.robot)
            if "position" in error.metadata and move.group != WHOLE:
                # Where that is is told in the frame of the chain's base.
                base = arm_of(snapshot, move.node(snapshot), move.group).base
                error.metadata["base"] = snapshot.structure.nodes[base].name
            raise
    carried = next((one for one in planned.values() if one.relative_tcp), None)
    if carried is not None:
        check_turns(planned.values(), carried.robot)
        if timed := next((move for move in moves if move.timed), None):
            raise no_common_law(f"joint trajectory of {timed.robot!r} has times of its own", carried.robot)
    return [planned[place] for place in range(len(moves))]


def _frames(snapshot: Snapshot, move: Move) -> list[int]:
    """Return the nodes (uids) whose places count all along a move: the arm's base, and a reference that moves."""
    if not move.solved:
        return []
    base, reference = arm_of(snapshot, move.node(snapshot), move.group).base, move.moving_reference
    names = [name for name in (reference, move.fixed_tool) if name]
    return [base, *(snapshot.structure.node(name).uid for name in names)]
