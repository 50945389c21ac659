"""Cost of a tick as robots grow from 1 to 200: motions advanced, forward pass, snapshot published; and brakes."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pybullet_data
from virtualrobot.files.resolver import Resolver
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import ImportedModel, import_model
from virtualrobot_kernel.planning.moves import PointToPoint
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.program import MotionSpec
from virtualrobot_kernel.planning.robots import Arm, world_poses
from virtualrobot_kernel.world.braking import braking
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import AttachNode, CreateNodes
from virtualrobot_kernel.world.figures import Box, Figure
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Kind, NodeSpec, PartData
from virtualrobot_kernel.world.tick import advance
from virtualrobot_sdk.compiled.cache import compile_all
from virtualrobot_sdk.kinematics import Kinematics

from benchmarks.rows import Row, row

IIWA = str(Path(pybullet_data.getDataPath()) / "kuka_iiwa/model.urdf")
COUNTS = (1, 5, 20, 50, 100, 200)
TICKS, ROUNDS = 100, 5
BUDGET_OF_20_ARMS = 0.15
"""Milliseconds."""

BRAKE_BUDGET = 50.0
"""Microseconds for the brakes of a robot that moves, in each tick: what drivers are to play if the kernel is gone."""

BRAKES_BY_NUMPY = {1: 474, 20: 510}
"""Microseconds for them before the choice was compiled."""

PARTS = 500


def nobody(snapshot: Snapshot, arm: Arm) -> Kinematics:
    """Solve no arm: moves to joints need none."""
    raise AssertionError(f"nobody solves {arm.robot.name}")


def world_of(arms: int, speed_factor: float = 0.01) -> World:
    """Return a world in which every axis of this many arms moves, slowly if not said otherwise."""
    world = world_at_rest(arms)
    go(world, arms, 1.5, speed_factor)
    return world


def world_at_rest(arms: int) -> World:
    """Return a world of this many arms, whose time goes on by steps."""
    store = AssetStore()
    library = MeshLibrary(store)
    files = Files(store, {}, Resolver())
    world = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, 4_000_000))
    world.start()
    for place in range(arms):
        model = import_model(IIWA, files, library, name=f"arm{place}")
        assert isinstance(model, ImportedModel)
        world.submit([CreateNodes(model.nodes)]).result()
    return world


def go(world: World, arms: int, position: float, speed_factor: float) -> None:
    """Let every axis of all arms begin to move to a position (rad)."""
    goal = {f"lbr_iiwa_joint_{joint}": position for joint in range(1, 8)}
    wishes = [MotionSpec((PointToPoint(f"arm{place}", goal, speed_factor),)) for place in range(arms)]
    world.submit([plan_motion(world.snapshot, wish, nobody).command for wish in wishes]).result()


def tick_milliseconds(arms: int) -> float:
    """Return what the world thread does for one tick, the median of several series: motions, poses, snapshot."""
    world = world_of(arms)
    snapshot = world.step(TICKS).result()
    world.close()
    series = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        for _ in range(TICKS):
            state = advance(snapshot.structure, snapshot.state, snapshot.tick_seconds, world_poses)
            poses = world_poses(snapshot.structure, state)
            snapshot = Snapshot(
                snapshot.structure, state, poses, snapshot.revision + 1, time.time(), snapshot.tick_seconds
            )
        series.append((time.perf_counter() - start) / TICKS * 1e3)
    return float(np.median(series))


def brake_microseconds(arms: int) -> tuple[float, float]:
    """Return what the brakes of all that moves take for an arm and a tick: the median, and what 99 of 100 stay below.

    The arms go from joint to joint; the ticks are those of the whole motion, to its end.
    """
    world = world_of(arms, 0.7)
    snapshot = world.snapshot
    world.close()
    state, costs = snapshot.state, []
    while state.motions:
        series = []
        for _ in range(ROUNDS):
            start = time.perf_counter()
            braking(snapshot.structure, state, snapshot.tick_seconds, world_poses)
            series.append((time.perf_counter() - start) / arms * 1e6)
        costs.append(min(series))
        state = advance(snapshot.structure, state, snapshot.tick_seconds, world_poses)
    return float(np.median(costs)), float(np.percentile(costs, 99))


def pick_milliseconds() -> float:
    """Return the time from submitting an attachment of one of 500 parts to its published snapshot, the median."""
    world = world_of(1)
    try:
        figures = (Figure(Box((0.1, 0.1, 0.1))),)
        parts = tuple(NodeSpec(f"part{n}", Kind.PART, figures=figures, data=PartData()) for n in range(PARTS))
        world.submit([CreateNodes(parts)]).result()
        times = []
        for n in range(100):
            start = time.perf_counter()
            world.submit([AttachNode(f"part{n}", "arm0.lbr_iiwa_link_7")]).result()
            times.append((time.perf_counter() - start) * 1e3)
        return float(np.median(times))
    finally:
        world.close()


def run() -> list[Row]:
    """Measure and return the rows."""
    compile_all(lambda done, total, name: None)
    costs = {arms: tick_milliseconds(arms) for arms in COUNTS}
    rows = []
    for arms, cost in costs.items():
        budget = 1.0 if arms == 20 else None
        peer, name = (BUDGET_OF_20_ARMS, "the budget") if arms == 20 else (arms * costs[20] / 20, "linear from 20 arms")
        rows.append(row(f"tick, {arms} arms moving", cost, peer, name, "ms", budget))
    # Linear: beyond a fixed cost, twice the arms may not cost more than twice.
    slope = (costs[200] - costs[100]) / 100
    before = (costs[100] - costs[20]) / 80
    rows.append(row("cost of one more arm, 100 to 200 against 20 to 100", slope, before, "itself", "ms", 1.3))
    for arms in (1, 20):
        median, most = brake_microseconds(arms)
        note = f"99 of 100 ticks at most {most:.0f} us; chosen by NumPy it was {BRAKES_BY_NUMPY[arms]} us"
        what = f"brakes of {arms} arm{'s' if arms > 1 else ''} that move{'s' if arms == 1 else ''}, each"
        rows.append(row(what, median, BRAKE_BUDGET, "the budget", "us", 1.0, note))
    rows.append(row(f"pick one of {PARTS} parts", pick_milliseconds(), 5.0, "the budget", "ms", 1.0))
    return rows


if __name__ == "__main__":
    for result in run():
        print(result)
