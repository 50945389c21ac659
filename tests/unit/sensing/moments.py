"""Moments of worlds that move as a formula says, for tests of readers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.state import Snapshot

from tests.unit.world.builders import TICK, Change

Way = Callable[[float], Pose]
"""Where a node is in its parent's frame at a time in seconds."""


def snapshot_at(
    change: Change,
    tick: int,
    ways: Mapping[str, Way] | None = None,
    q: Callable[[float], np.ndarray] | None = None,
    tick_seconds: float = TICK,
) -> Snapshot:
    """Return the world at a tick, some nodes and all joints where `ways` and `q` say."""
    structure, state = change.structure, replace(change.state, tick=tick)
    time = tick * tick_seconds
    if ways:
        poses = state.parent_t_node.copy()
        for name, way in ways.items():
            poses[structure.rows[structure.node(name).uid]] = way(time)
        state = replace(state, parent_t_node=poses)
    if q is not None:
        state = replace(state, q=q(time))
    return Snapshot(structure, state, world_poses(structure, state), tick, 0.0, tick_seconds)


def moment_at(
    change: Change,
    tick: int,
    ways: Mapping[str, Way] | None = None,
    q: Callable[[float], np.ndarray] | None = None,
    tick_seconds: float = TICK,
    number: int = 1,
    seed: int = 0,
    past: int = 2,
) -> Moment:
    """Return what a reader is given at a tick: the world there and at the ticks before; it was started at 0."""
    ticks = [snapshot_at(change, at, ways, q, tick_seconds) for at in range(tick - past, tick + 1)]
    return Moment(ticks[-1], tuple(ticks[:-1]), number, np.random.default_rng((seed, number)), tick)
