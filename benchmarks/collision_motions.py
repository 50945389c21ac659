"""Checks of whole motions among meshes against bare python-fcl asked at steps as small as the resolution."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np
from virtualrobot_kernel.api.motion_plans import contact_of
from virtualrobot_kernel.collision.joint_path import of_program
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.collision.swept import RESOLUTION
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.planning.moves import Linear, Move, PointToPoint
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import MotionSpec
from virtualrobot_kernel.planning.robots import Arm, standing_at
from virtualrobot_kernel.world.commands import StartMotion
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_plugins.chain.component import ChainKinematics

from benchmarks.collision_cell import CollisionCell, collision_cell
from benchmarks.collision_peers import bare_fcl
from benchmarks.rows import Row, row

MOTIONS = 10
SECONDS = 2.0
"""About how long each motion takes."""
PLACES = 200
"""At how many places of a motion the peer is asked; all its steps are taken to cost as much as these do."""
BUDGET = 0.01
ARM = "arm0"


def solver(snapshot: Snapshot, arm: Arm) -> ChainKinematics:
    """Solve any arm by the chain's component, in this process."""
    return ChainKinematics(arm.serial())


def free_motions(cell: CollisionCell, kind: str, rng: np.random.Generator) -> Iterator[tuple[Snapshot, StartMotion]]:
    """Yield motions on which nothing touches, from the configurations of a cell: joint moves, or lines."""
    for snapshot in cell.snapshots * 10:
        try:
            command = plan_motion(snapshot, MotionSpec((_move(snapshot, kind, rng),)), solver).command
        except KernelError:
            continue
        if contact_of(cell.scene, snapshot, command, np.inf, RESOLUTION, lambda: False) is None:
            yield snapshot, command


def _move(snapshot: Snapshot, kind: str, rng: np.random.Generator) -> Move:
    structure = snapshot.structure
    index = structure.robots[structure.node(ARM).uid]
    if kind == "LIN":
        goal = snapshot.world_t(index.flange).copy()
        way = rng.normal(size=3)
        goal[:3, 3] += 0.25 * SECONDS * 0.9 * way / np.linalg.norm(way)
        return Linear(ARM, PoseGoal(goal), max_velocity=0.25)
    here = snapshot.state.q[list(index.q_start)]
    limits = [joint.limits for joint in index.joints]
    goal = np.clip(
        here + rng.uniform(-0.8, 0.8, len(here)), [one.lower for one in limits], [one.upper for one in limits]
    )
    positions = dict(zip(index.joint_names, goal.tolist(), strict=True))
    fast = plan_motion(snapshot, MotionSpec((PointToPoint(ARM, positions),)), solver).command.program.duration
    return PointToPoint(ARM, positions, speed_factor=min(1.0, fast / SECONDS))


def stepped(cell: CollisionCell, snapshot: Snapshot, command: StartMotion) -> tuple[float, int]:
    """Return the seconds that bare python-fcl takes for a motion, and in how many steps.

    In so many that the flange goes no farther than the resolution from one to the next; other points go farther. The
    poses of the links are made before.
    """
    structure = snapshot.structure
    index = structure.robots[structure.node(ARM).uid]
    program, q_index = command.program, np.array(index.q_start, np.int32)
    path = of_program(snapshot.state.q, q_index, program)

    def at(time: float) -> Snapshot:
        return standing_at(snapshot, q_index, path.at(time)[q_index])

    times = np.linspace(0.0, program.duration, PLACES).tolist()
    flange = np.array([at(time).world_t(index.flange)[:3, 3] for time in times])
    count = int(np.ceil(np.linalg.norm(np.diff(flange, axis=0), axis=1).sum() / RESOLUTION))
    poses = []
    for place in times:
        cell.scene.place(at(place))
        poses.append(cell.scene.world_t_element.copy())
    check = bare_fcl(replace(cell, poses=np.array(poses)))
    start = time.perf_counter()
    touches = [check(place) for place in range(PLACES)]
    seconds = (time.perf_counter() - start) / PLACES * count
    assert not any(touches), "the motion was proven free"
    return seconds, count


def compared(cell: CollisionCell, kind: str) -> Row:
    """Return what motions of one kind cost, with the peer's steps."""
    rng = np.random.default_rng(1)
    costs, others, counts = [], [], []
    scene = CollisionScene(cell.shapes)  # one that has been used, but knows nothing of these motions
    scene.place(cell.snapshots[0])
    for snapshot, command in islice(free_motions(cell, kind, rng), MOTIONS):
        start = time.perf_counter()
        found = contact_of(scene, snapshot, command, np.inf, RESOLUTION, lambda: False)
        costs.append((time.perf_counter() - start) * 1e3)
        assert found is None
        seconds, count = stepped(cell, snapshot, command)
        others.append(seconds * 1e3)
        counts.append(count)
    note = (
        f"mean of {len(costs)}, longest {max(costs):.0f} ms; bare python-fcl at {np.mean(counts):.0f} steps of 0.1 mm"
    )
    ours, peer = float(np.mean(costs)), float(np.mean(others))
    return row(
        f"{kind} of about {SECONDS:g} s among 200 meshes",
        ours,
        peer,
        "bare python-fcl",
        "ms",
        BUDGET if kind == "PTP" else None,
        note,
    )


def run() -> list[Row]:
    """Measure."""
    cell = collision_cell(1, 200, 100)
    return [compared(cell, kind) for kind in ("PTP", "LIN")]
