"""Path query: joints, their start, and all configurations that would do as its end."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import UnknownNameError
from virtualrobot_kernel.planning.actuators import actuator_limits
from virtualrobot_kernel.planning.free_joints import reached, solve_inverse
from virtualrobot_kernel.planning.moves import ActuatorGoal, goal_positions
from virtualrobot_kernel.planning.planned_move import PoseGoal, world_t_goal
from virtualrobot_kernel.planning.robots import Arm, SolverOf, arm_of, kind_of_joint, standing_at
from virtualrobot_kernel.world.change import check_joint_value, single_joint
from virtualrobot_kernel.world.groups import WHOLE, Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import JointType, Kind, Node

Floats = NDArray[np.float64]
Goal = Mapping[str, float] | PoseGoal | str | ActuatorGoal
"""Goal of a point-to-point move: joint values, a pose, the name of a posture, or actuator positions."""

MOST_GOALS = 24
"""Greatest number of configurations that a path may end in; those nearest to its start are taken."""

TRIED_SEEDS = 8
"""Number of random seeds of a pose's solutions, besides the start: each may lead to another branch."""

SAME = 1e-3
"""Greatest difference of solutions that count as one, in rad or m."""

ROUND = 2.0 * np.pi
"""Range of a turning joint without limits beyond start and goals, in rad."""

BESIDE = 1.0
"""Range of a sliding joint without limits beyond start and goals, in m."""


@dataclass(frozen=True, slots=True, eq=False)
class PathQuery:
    """Query for a free path; the world in which it is asked has the robot at the start.

    Attributes:
        robot: its name, and `group`, whose joints move.
        joint_names: the arm's joints (k,).
        q_index: (k,) where they are among all coordinates.
        lower: (k,) from where to where they may go, finite, and `upper`.
        goals: (m, k) where the path may end; the first is what a point-to-point move would go to, but for whole turns.
        ratios: (a, k) of actuators that have limits of their own, `least` and `most` (a,): ratios @ q is between them.
        planner: the name of an algorithm.
        seed: what it draws its samples from.
        time_limit: in s.
        speed_factor: of the moves, and `blend_percent` of their zones at the most.
        clearance: from what is not the robot's, in m; the world in which it is asked has it, see `cleared`.
    """

    robot: str
    group: Group
    joint_names: tuple[str, ...]
    q_index: NDArray[np.int32]
    lower: Floats
    upper: Floats
    goals: Floats
    ratios: Floats
    least: Floats
    most: Floats
    planner: str
    seed: int
    time_limit: float
    speed_factor: float
    blend_percent: float
    clearance: float


@dataclass(frozen=True, slots=True)
class PathOptions:
    """Options of a path search: see `PathQuery`."""

    planner: str
    seed: int
    time_limit: float
    speed_factor: float
    blend_percent: float
    clearance: float = 0.0


def cleared(snapshot: Snapshot, robot: Node, clearance: float) -> Snapshot:
    """Return the world in which all that is not the robot's, nor below it, counts as thicker by a clearance (m)."""
    if not clearance:
        return snapshot
    structure, collisions = snapshot.structure, snapshot.state.collisions
    own = {node.uid for node in structure.below(robot.uid)}
    thicker = {uid: (collisions.paddings.get(uid) or 0.0) + clearance for uid in structure.nodes if uid not in own}
    collisions = replace(collisions, paddings={**collisions.paddings, **thicker})
    return replace(snapshot, state=replace(snapshot.state, collisions=collisions))


def started_at(snapshot: Snapshot, robot: Node, start: Mapping[str, float], group: Group = WHOLE) -> Snapshot:
    """Return the world with joints of a group elsewhere; raise KernelError for others or beyond limits."""
    if not start:
        return snapshot
    return standing_at(snapshot, *_placed(snapshot, arm_of(snapshot, robot, group), start))


def path_query(
    snapshot: Snapshot,
    robot_name: str,
    goal: Goal,
    solver_of: SolverOf,
    options: PathOptions,
    group: Group = WHOLE,
) -> PathQuery:
    """Return the question for a path of a robot, or a group of it, from where it is in this world.

    Raises UnknownNameError for a robot, joint or posture that there is not, LimitError for a joint beyond its limits,
    and KernelError (UNREACHABLE) for a pose.
    """
    robot = snapshot.structure.node(robot_name, Kind.ROBOT)
    arm = arm_of(snapshot, robot, group)
    chain = arm.serial()
    start = snapshot.state.q[arm.q_index]
    if isinstance(goal, PoseGoal):
        goals = _reaching(snapshot, robot, goal, solver_of, options.seed, group)
    else:
        q_index, q = _placed(snapshot, arm, goal_positions(robot, goal, None if group == WHOLE else chain.joint_names))
        goals = standing_at(snapshot, q_index, q).state.q[arm.q_index][None]
    endless = np.isinf(chain.lower) & np.isinf(chain.upper)
    turning = endless & np.array([_turns(snapshot, robot, name) for name in chain.joint_names])
    goals = _every_turn(goals, start, turning)
    first, others = goals[:1], goals[1:]
    nearest = np.argsort(np.linalg.norm(others - start, axis=1), kind="stable")[: MOST_GOALS - 1]
    goals = np.concatenate([first, others[nearest]])
    reached = np.concatenate([goals, start[None]])
    beyond = np.where(turning, ROUND, BESIDE)
    limits = actuator_limits(snapshot, robot, chain.joint_names)
    rest = np.array([one.rest for one in limits])
    return PathQuery(
        robot.name,
        group,
        chain.joint_names,
        arm.q_index,
        np.where(np.isinf(chain.lower), reached.min(axis=0) - beyond, np.minimum(chain.lower, reached.min(axis=0))),
        np.where(np.isinf(chain.upper), reached.max(axis=0) + beyond, np.maximum(chain.upper, reached.max(axis=0))),
        goals,
        np.array([one.ratios for one in limits]).reshape(-1, len(start)),
        np.array([one.actuator.lower for one in limits]) - rest,
        np.array([one.actuator.upper for one in limits]) - rest,
        options.planner,
        options.seed,
        options.time_limit,
        options.speed_factor,
        options.blend_percent,
        options.clearance,
    )


def _placed(snapshot: Snapshot, arm: Arm, positions: Mapping[str, float]) -> tuple[NDArray[np.int32], Floats]:
    """Return the coordinates of joints, (n,), and where they shall be."""
    robot = arm.robot
    names = arm.serial().joint_names
    places: dict[int, float] = {}
    for name, value in positions.items():
        if name not in names:
            single_joint(snapshot.structure, robot, name)  # what is no joint at all is told by its own words
            raise UnknownNameError(f"{kind_of_joint(arm)}, as a path does,", name, names)
        joint, place, _ = single_joint(snapshot.structure, robot, name)
        check_joint_value(robot.name, joint, value)
        places[place] = value
    return np.array(list(places), np.int32), np.array(list(places.values()))


def _reaching(snapshot: Snapshot, robot: Node, goal: PoseGoal, solver_of: SolverOf, seed: int, group: Group) -> Floats:
    """Return configurations (m, k) that reach a pose, those first that a move from here would take."""
    world_t_tcp = world_t_goal(snapshot, goal)
    choice = goal.configuration
    arm, found = reached(snapshot, robot, world_t_tcp, solver_of, choice, group=group, reference=goal.reference)
    chain, rng = arm.serial(), np.random.default_rng(seed)
    lower = np.maximum(chain.lower, -np.pi)
    upper = np.maximum(np.minimum(chain.upper, np.pi), lower)
    for _ in range(TRIED_SEEDS):
        guess = dict(zip(chain.joint_names, rng.uniform(lower, upper).tolist(), strict=True))
        again = solve_inverse(snapshot, robot, world_t_tcp, guess, solver_of, goal.configuration, group=group)[1]
        for solution in again.solutions:
            if all(np.abs(solution - other).max() > SAME for other in found):
                found.append(solution)
    return np.array(found)


def _turns(snapshot: Snapshot, robot: Node, name: str) -> bool:
    return single_joint(snapshot.structure, robot, name)[0].type is not JointType.PRISMATIC


def _every_turn(goals: Floats, start: Floats, turning: NDArray[np.bool_]) -> Floats:
    """Return goals with joints that turn without limits within half a turn of the start, or one the other way round."""
    turns = np.round((goals - start) / (2 * np.pi))
    goals = np.where(turning, goals - 2 * np.pi * turns, goals)
    found = [goals]
    for joint in np.flatnonzero(turning).tolist():
        other = goals.copy()
        other[:, joint] -= np.where(goals[:, joint] > start[joint], 2 * np.pi, -2 * np.pi)
        found.append(other)
    return np.concatenate(found)
