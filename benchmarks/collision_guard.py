"""Cost of a guard per tick: of an arm alone, of an arm among meshes, of twenty arms that move at once."""

from __future__ import annotations

import numpy as np
from virtualrobot_kernel.collision import readiness
from virtualrobot_kernel.collision.guard import CollisionGuard, GuardCost
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.plan import plan_ptp
from virtualrobot_kernel.motion.program import of_plan
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import SetCollisionSettings, StartMotion
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.store import World
from virtualrobot_sdk.compiled.cache import make_ready

from benchmarks.collision_cell import collision_cell
from benchmarks.rows import Row, row
from tests.unit.journals import entries_of

TICK_MILLISECONDS, WORST_MILLISECONDS = 4.0, 12.0
WAIT = 600.0
FARTHEST = 0.8
"""Distance (rad) that each joint goes in a motion, at the most."""


def guarded(arms: int, meshes: int, ticks: int) -> tuple[GuardCost, int]:
    """Return what guarding costs while all arms move to and fro, and how often it stopped them."""
    rng = np.random.default_rng(1)
    cell = collision_cell(arms, meshes, 1)
    (snapshot,) = cell.snapshots
    clock = Clock(Mode.STEPPED, 1.0, round(TICK_MILLISECONDS * 1e6))
    world = World(world_poses, MemoryJournal(), clock, snapshot.structure, snapshot.state)
    guard = CollisionGuard(cell.shapes, world)
    world.start()
    try:
        settings = [SetCollisionSettings(CollisionMode.GUARD)]
        readiness.make_ready(cell.shapes, snapshot, settings)  # as a kernel does before
        make_ready()
        world.submit(settings).result(WAIT)
        warm = GuardCost()
        for tick in range(ticks):
            busy = {uid for motion in world.snapshot.state.motions for uid in motion.robots}
            starts = [_start(world, uid, rng) for uid in snapshot.structure.robots if uid not in busy]
            if starts:
                world.submit(starts).result(WAIT)
            world.step(1).result(WAIT)
            if tick == 20:
                warm, guard.cost = guard.cost, GuardCost()
        assert warm.ticks
        stops = sum(entry.author == guard.author for entry in entries_of(world))
        return guard.cost, stops
    finally:
        world.close()


def _start(world: World, uid: int, rng: np.random.Generator) -> StartMotion:
    """Return the start of a motion of an arm from where it stands."""
    structure, state = world.snapshot.structure, world.snapshot.state
    index, name = structure.robots[uid], structure.nodes[uid].name
    names = index.joint_names
    columns = (
        np.array([getattr(joint.limits, field) for joint in index.joints])
        for field in ("lower", "upper", "velocity", "acceleration", "jerk")
    )
    limits = JointLimits(names, *columns)
    at = state.q[index.q_slice]
    goal = np.clip(at + rng.uniform(-FARTHEST, FARTHEST, len(names)), limits.lower, limits.upper)
    return StartMotion(tuple((name, joint) for joint in names), of_plan(plan_ptp(at, goal, limits)))


def run() -> list[Row]:
    """Measure."""
    rows = []
    for arms, meshes, ticks in ((1, 0, 800), (1, 200, 800), (20, 500, 400)):
        cost, stops = guarded(arms, meshes, ticks)
        milliseconds = 1e3 * cost.seconds / cost.ticks
        note = f"worst {1e3 * cost.worst_seconds:.1f} ms of {cost.ticks} ticks, {stops} stops"
        what = f"guard, {arms} arm{'s' if arms > 1 else ''} and {meshes} meshes"
        rows.append(row(what, milliseconds, TICK_MILLISECONDS, "a tick", "ms", 1.0 if arms == 1 else None, note))
        if meshes:
            note = "the worst tick"
            rows.append(row(what, 1e3 * cost.worst_seconds, WORST_MILLISECONDS, "the budget", "ms", 1.0, note))
    return rows
