"""Cells of real arms, and random move steps for them, for the tests of runs of moves with zones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.circle import Via
from virtualrobot_kernel.planning.blending import PlannedRun, join_steps
from virtualrobot_kernel.planning.moves import Circular, Linear, Move, PointToPoint, Spline
from virtualrobot_kernel.planning.notes import Note
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import MoveStep, Zone
from virtualrobot_kernel.planning.robots import Arm, SolverOf, arm_of, tcp_frame, world_poses
from virtualrobot_kernel.planning.steps import arrived, plan_steps
from virtualrobot_kernel.planning.together import plan_moves
from virtualrobot_kernel.world.state import Snapshot, State
from virtualrobot_kernel.world.structure import Kind
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.kinematics import Kinematics
from virtualrobot_sdk.poses import rotation_matrix

from tests.unit.formats.models import load, structure_of
from tests.unit.numeric.urdf_arrays import URDFS

KINDS = ("joints", "pose", "line", "arc", "spline")
"""The kinds of moves: PTP to joints and to a pose, LIN, CIRC, and a spline."""


@cache
def _nodes(file: Path, name: str, y: float) -> tuple:
    pose = np.eye(4)
    pose[1, 3] = y
    return load(file, name=name, parent_t_node=pose)[0].nodes


def cell_of(rng: np.random.Generator, *files: str) -> Snapshot:
    """Return a world with arms, called `arm0`, `arm1` and so on, 2 m apart, with their joints in random places."""
    nodes = [node for place, file in enumerate(files) for node in _nodes(URDFS[file], f"arm{place}", 2.0 * place)]
    structure, poses = structure_of(tuple(nodes))
    state = State(0, np.zeros(structure.q_count), np.zeros(structure.v_count), poses)
    snapshot = Snapshot(structure, state, world_poses(structure, state), 1, 0.0, 0.004)
    for place in range(len(files)):
        snapshot = with_joints(snapshot, f"arm{place}", random_joints(rng, snapshot, f"arm{place}"))
    return snapshot


_solvers: dict[Arm, ChainKinematics] = {}


def solver(snapshot: Snapshot, arm: Arm) -> Kinematics:
    """Return the numeric kinematics of an arm."""
    if arm not in _solvers:
        _solvers[arm] = ChainKinematics(arm.serial())
    return _solvers[arm]


def plan_run(
    snapshot: Snapshot, steps: Sequence[MoveStep], solver_of: SolverOf, numbers: Sequence[int] | None = None
) -> tuple[list[PlannedRun], list[Note]]:
    """Return the plans of consecutive move steps, one after the other, and what became of their zones."""
    return join_steps(plan_steps(snapshot, steps, solver_of, numbers))


def random_joints(rng: np.random.Generator, snapshot: Snapshot, robot: str) -> np.ndarray:
    """Return joints of an arm in the middle of their ranges."""
    chain = arm_of(snapshot, snapshot.structure.node(robot, Kind.ROBOT)).serial()
    lower, upper = np.maximum(chain.lower, -np.pi), np.minimum(chain.upper, np.pi)
    return rng.uniform(0.75 * lower + 0.25 * upper, 0.25 * lower + 0.75 * upper)


def with_joints(snapshot: Snapshot, robot: str, q: np.ndarray) -> Snapshot:
    """Return the world with an arm's joints elsewhere."""
    names = arm_of(snapshot, snapshot.structure.node(robot, Kind.ROBOT)).joint_names
    return arrived(snapshot, [(robot, name) for name in names], q)


def random_move(rng: np.random.Generator, snapshot: Snapshot, robot: str, kind: str) -> Move:
    """Return a move that can be planned from where the robot is: of some decimetres, or about a radian."""
    node = snapshot.structure.node(robot, Kind.ROBOT)
    arm = arm_of(snapshot, node)
    here = tcp_frame(snapshot, node)
    chain = arm.serial()
    for _ in range(60):
        speed_factor = float(rng.uniform(0.3, 1.0))
        goal = here.copy()
        goal[:3, 3] += rng.uniform(-0.2, 0.2, 3)
        goal[:3, :3] = rotation_matrix(rng.normal(size=3) * 0.3) @ goal[:3, :3]
        pose = PoseGoal(goal)
        if kind == "joints":
            q = snapshot.state.q[arm.q_index] + rng.uniform(-0.6, 0.6, len(arm.q_index))
            q = np.clip(q, np.maximum(chain.lower, -20.0), np.minimum(chain.upper, 20.0))
            move = PointToPoint(robot, dict(zip(arm.joint_names, q.tolist(), strict=True)), speed_factor)
        elif kind == "pose":
            move = PointToPoint(robot, pose, speed_factor)
        elif kind == "line":
            move = Linear(robot, pose, speed_factor, max_velocity=float(rng.uniform(0.1, 1.0)))
        elif kind == "spline":
            middle = here.copy()
            middle[:3, 3] = 0.5 * (here + goal)[:3, 3] + rng.uniform(-0.05, 0.05, 3)
            move = Spline(robot, (PoseGoal(middle), pose), speed_factor, max_velocity=float(rng.uniform(0.1, 1.0)))
        else:
            via = Via(here[:3, 3] + rng.uniform(-0.15, 0.15, 3))
            move = Circular(robot, via, goal, "", speed_factor=speed_factor, max_velocity=float(rng.uniform(0.1, 1.0)))
        try:
            (planned,) = plan_moves(snapshot, [move], solver)
        except KernelError:
            continue
        if kind != "pose" or np.abs(planned.plan.goal - planned.plan.start).max() < 1.5:
            return move
    raise AssertionError(f"no {kind} of 400 could be planned for {robot}")


def random_steps(
    rng: np.random.Generator, file: str, kinds: Sequence[str], zone: Zone, time_law: TimeLaw = TimeLaw.JERK_LIMITED
) -> tuple[Snapshot, list[MoveStep]]:
    """Return a world with one arm, and steps of one move each of these kinds, all but the last one with a zone."""
    for _ in range(100):
        snapshot = here = cell_of(rng, file)
        steps: list[MoveStep] = []
        try:
            for place, kind in enumerate(kinds):
                move = replace(random_move(rng, here, "arm0", kind), time_law=time_law)
                steps.append(MoveStep((move,), zone if place < len(kinds) - 1 else None))
                (planned,) = plan_moves(here, [move], solver)
                here = with_joints(here, "arm0", planned.plan.goal)
        except AssertionError:
            continue
        return snapshot, steps
    raise AssertionError(f"no steps of 100 could be planned for {file}")
