"""Collision checks against bare python-fcl, coal, MuJoCo and PyBullet, and what picking a part costs a scene of 500."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from virtualrobot_kernel.collision.scene import Detail
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.commands import AttachNode
from virtualrobot_kernel.world.state import Snapshot

from benchmarks.collision_cell import CollisionCell, collision_cell
from benchmarks.collision_peers import Checks, bare_fcl, in_coal, in_mujoco, in_pybullet
from benchmarks.rows import Row, row

ROUNDS = 5
BUDGETS = {("bare python-fcl", 1): 0.4, ("MuJoCo, hulls", 20): 0.95}
"""By peer and number of arms."""
PICK_BUDGET_MILLISECONDS = 5.0
PEERS: dict[str, Callable[[CollisionCell], Checks]] = {
    "bare python-fcl": bare_fcl,
    "coal": in_coal,
    "MuJoCo, hulls": in_mujoco,
    "PyBullet, hulls": in_pybullet,
}


def ours(cell: CollisionCell) -> Checks:
    """Return our check: the scene follows the snapshot."""

    def check(place: int) -> bool:
        cell.scene.place(cell.snapshots[place])
        return bool(cell.scene.collisions(Detail.FIRST))

    return check


def measured(checks: dict[str, Checks], count: int) -> dict[str, tuple[float, np.ndarray]]:
    """Return the least milliseconds of a check among rounds, in turns, and what each answers (n,)."""
    best = dict.fromkeys(checks, np.inf)
    answers: dict[str, np.ndarray] = {}
    for _ in range(ROUNDS):
        for name, check in checks.items():
            start = time.perf_counter()
            answers[name] = np.array([check(place) for place in range(count)])
            best[name] = min(best[name], (time.perf_counter() - start) / count * 1e3)
    return {name: (best[name], answers[name]) for name in checks}


def compared(arms: int, meshes: int, configurations: int) -> list[Row]:
    """Return a row for each peer on one scene."""
    cell = collision_cell(arms, meshes, configurations)
    checks = {"ours": ours(cell), **{name: made(cell) for name, made in PEERS.items()}}
    found = measured(checks, configurations)
    milliseconds, truth = found.pop("ours")
    rows = []
    for name, (peer, answers) in found.items():
        wrong = f"{(answers & ~truth).sum()} false, {(truth & ~answers).sum()} missed of {configurations}"
        note = f"{truth.sum()} of {configurations} touch; {name}: {wrong}"
        what = f"check, {arms} arm{'s' if arms > 1 else ''} and {meshes} meshes"
        rows.append(row(what, milliseconds, peer, name, "ms", BUDGETS.get((name, arms)), note))
    return rows


def picking() -> Row:
    """Return what it costs a scene of 500 meshes to follow when a part is picked or put away."""
    cell = collision_cell(1, 500, 1)
    (snapshot,) = cell.snapshots
    cell.scene.place(snapshot)
    costs = []
    for turn in range(20):
        command = AttachNode(f"part {turn}", "arm0.lbr_iiwa_link_7")
        change = apply(snapshot.structure, snapshot.state, [command], world_poses)
        world = world_poses(change.structure, change.state)
        snapshot = Snapshot(change.structure, change.state, world, 0, 0.0, snapshot.tick_seconds)
        start = time.perf_counter()
        cell.scene.place(snapshot)
        costs.append((time.perf_counter() - start) * 1e3)
    return row(
        "picking a part in a scene of 500", float(np.median(costs)), PICK_BUDGET_MILLISECONDS, "budget", "ms", 1.0
    )


def run() -> list[Row]:
    """Measure."""
    return [*compared(1, 200, 300), *compared(20, 500, 30), picking()]
