"""Cost of a replay: a moment among 100,000 ticks of 20 arms that move, and a verification of them."""

from __future__ import annotations

import time

import numpy as np
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.history.replay import Replay
from virtualrobot_kernel.history.rows import Row as Entry
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.history.tick_hash import tick_hash
from virtualrobot_kernel.history.verify import verify
from virtualrobot_kernel.planning.moves import PointToPoint
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.program import MotionSpec
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.apply_checkpoint import checkpoint_of
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.state import Snapshot, empty_state
from virtualrobot_kernel.world.tick import advance
from virtualrobot_sdk.compiled.cache import compile_all

from benchmarks.rows import Row, row
from benchmarks.tick import nobody, world_of

ARMS, TICKS, MOMENTS = 20, 100_000, 200
TICK_SECONDS = 0.004
LONGEST_SECONDS = 0.5
FASTEST = 0.8
"""Least speed of a verification, of that of the replay alone."""


def recorded(ticks: int) -> tuple[Store, bytes]:
    """Return a store with the past of arms that always move, and the hashes of its ticks."""
    world = world_of(ARMS)
    begin = world.snapshot
    world.close()
    store, encode, hashes = Store(), world_codec().encode, bytearray()
    rng = np.random.default_rng(14)
    change, number = Change(index.empty(), empty_state()), 0

    def do(command: Command) -> None:
        nonlocal change, number
        number += 1
        store.write([Entry(number, change.state.tick, 0.0, "", encode((command,)))])
        change = apply(change.structure, change.state, [command], world_poses)

    do(checkpoint_of(Change(begin.structure, begin.state), "begin"))
    while change.state.tick < ticks:
        moving = {uid for motion in change.state.motions for uid in motion.robots}
        for uid, robot in change.structure.robots.items():
            if uid not in moving:
                goal = rng.uniform(-1.5, 1.5, len(robot.joint_names)).tolist()
                move = PointToPoint(
                    change.structure.nodes[uid].name, dict(zip(robot.joint_names, goal, strict=True)), 0.1
                )
                poses = world_poses(change.structure, change.state)
                now = Snapshot(change.structure, change.state, poses, 0, 0.0, TICK_SECONDS)
                do(plan_motion(now, MotionSpec((move,)), nobody).command)
        change = Change(change.structure, advance(change.structure, change.state, TICK_SECONDS, world_poses))
        hashes += tick_hash(change.structure, change.state)
    return store, bytes(hashes)


def run(ticks: int = TICKS) -> list[Row]:
    """Measure; return the rows."""
    compile_all(lambda name, number, count: None)
    store, hashes = recorded(ticks)
    replay = Replay(store, world_codec(), TICK_SECONDS, world_poses, ticks)
    began = time.thread_time()
    replay.keep_moments()
    alone = time.thread_time() - began
    began = time.thread_time()
    verdict = verify(replay, [(1, hashes)])
    verified = time.thread_time() - began
    assert (verdict.ticks, verdict.tick) == (ticks, None)
    rng = np.random.default_rng(15)
    times = []
    for tick in rng.integers(0, ticks, MOMENTS).tolist():
        began = time.thread_time()
        assert replay.at(tick).state.tick == tick
        times.append(time.thread_time() - began)
    note = f"{ticks:,} ticks of {ARMS} arms; median {np.median(times):.2f} s"
    worst = row(f"a moment, worst of {MOMENTS}", max(times), LONGEST_SECONDS, "half a second", "s", 1.0, note)
    each = 1e6 / ticks
    pace = row("a tick verified", verified * each, alone * each, "the replay alone", "µs", 1.0 / FASTEST)
    return [worst, pace]
