"""The swept check of a way that is told tick by tick, such as a brake, and which pairs it leaves out."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.joint_path import JointPath, Lengths, of_path
from virtualrobot_kernel.collision.scene import CollisionScene, Nearest
from virtualrobot_kernel.collision.swept import RESOLUTION, SweptContact, first_contact
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.planning.robots import with_state
from virtualrobot_kernel.world.braking import BrakePath
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import JointType, Structure

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]

APART = 5.0 * RESOLUTION
"""Two nodes that touched are looked at again when they are this far apart (m)."""

LEVER = 4.0
"""Largest distance (m) of a joint's axis from what it moves, where the resolution follows from joints."""


def contact_on(
    scene: CollisionScene,
    snapshot: Snapshot,
    way: BrakePath,
    robots: Collection[int],
    tolerated: Collection[Pair],
    asked: Callable[[Integers], Booleans] | None = None,
) -> SweptContact | None:
    """Return the first contact on a way; None: there is none. It goes in stretches on which tools look the same.

    What touches because a tool looks otherwise is asked where that begins: nothing need move then.

    Args:
        scene: is used for it.
        snapshot: a world of the same structure, and of the same ticks.
        way: where all joints go.
        robots: pairs with one of these (uids) are asked.
        tolerated: pairs of nodes (uids) that are not asked.
        asked: tells which pairs of nodes (k, 2), given by their rows, are asked on the way; None means all.
    """
    dt = snapshot.tick_seconds
    ends = [*(row for row, _ in way.tools[1:]), len(way.positions) - 1]
    for (begin, tools), end in zip(way.tools, ends, strict=True):
        base = snapshot if tools is snapshot.state.tool_states else pictured(snapshot, way, begin)
        if begin and (near := _touching(scene, base, robots, tolerated)) is not None:
            time = (way.tick + begin) * dt
            return SweptContact(time, near.first, near.second, 0.0, near.points, way.positions[begin])
        if end <= begin:
            continue
        positions = way.positions[begin : end + 1]
        path = _curve(positions, (way.tick + begin) * dt, dt, jerk_limits(snapshot.structure))
        assert path.wobble is not None
        resolution = RESOLUTION + LEVER * float(path.wobble.sum())
        contact = first_contact(
            scene, base, path, robots=robots, tolerated=tolerated, resolution=resolution, asked=asked
        )
        if contact is not None:
            return contact
    return None


def _touching(
    scene: CollisionScene, snapshot: Snapshot, robots: Collection[int], tolerated: Collection[Pair]
) -> Nearest | None:
    """Return two nodes that touch, of the pairs that `contact_on` asks; None: there are none."""
    scene.place(snapshot)
    pair = min(scene.touching(robots).difference(tolerated), default=None)
    return scene.distances([pair[0]], [pair[1]], 0.0)[0] if pair else None


def pictured(snapshot: Snapshot, way: BrakePath, row: int) -> Snapshot:
    """Return the snapshot of a place of a way (a row, or -1 for the last one)."""
    row %= len(way.positions)
    tools = next(held for begin, held in reversed(way.tools) if begin <= row)
    state = replace(snapshot.state, q=way.positions[row], tool_states=tools)
    return with_state(snapshot, state)


def distance(scene: CollisionScene, snapshot: Snapshot, pair: Pair, reach: float = 2.0 * APART) -> float:
    """Return how far two nodes (uids) are apart (m); inf beyond `reach`, and where they may touch."""
    scene.place(snapshot)
    found = scene.distances([pair[0]], [pair[1]], reach)
    return found[0].distance if found else np.inf


@lru_cache(maxsize=4)
def jerk_limits(structure: Structure) -> Floats:
    """Return the jerk limit of each coordinate (nq,), rad/s³ or m/s³; 0 for those without.

    The third derivative of a quaternion q that turns with the angular velocity w follows from q' = q w / 2: it is at
    most j / 2 + 3/4 w a + w³ / 8, of which each axis keeps its limit.
    """
    jerks = np.zeros(structure.q_count)
    for index in structure.robots.values():
        for joint, start in zip(index.joints, index.q_start, strict=True):
            limits, most = joint.limits, np.sqrt(3.0)
            if np.isfinite(limits.jerk):
                jerks[start : start + joint.type.coordinate_count] = limits.jerk
            if joint.type is JointType.FLOATING:
                speed, bend = most * limits.velocity, most * limits.acceleration
                jerks[start + 3 : start + 7] = most * limits.jerk / 2.0 + 0.75 * speed * bend + speed**3 / 8.0
    return jerks


def _jump(steps: Floats, bends: Floats, dt: float) -> Floats:
    """Return by how much accelerations (nq,) jump at the most, by steps (m, nq) and second differences (m + 1, nq).

    One step alone is taken to end at rest: with an acceleration of 2 steps / dt².
    """
    if len(steps) == 1:
        return 2.0 * np.abs(steps[0]) / dt**2
    jumps = np.pad(np.abs(np.diff(bends, axis=0)), ((1, 1), (0, 0)))
    return (jumps[:-2] + jumps[1:-1] + jumps[2:]).max(axis=0)


def _curve(positions: Floats, begin: float, dt: float, jerks: Floats) -> JointPath:
    """Return the way through positions (m, nq), a tick apart, as it is when no jerk is above its limit (nq,).

    Between two ticks it goes with an acceleration that changes evenly, from the second difference at the one to that at
    the other. A second difference is a mean of the acceleration around its tick; by the limit j of the jerk this is
    within 2 j dt of the true one, so the place is within 2 j dt · dt²/8 of the true one, and the speed is at most its
    mean between the ticks and half a tick of the greatest acceleration there more. Where laws without a limit of the
    jerk let the acceleration jump, a jump is in the second differences of three ticks, and stands for 2 j dt.
    """
    steps = np.diff(positions, axis=0)
    bends = np.empty_like(positions)
    bends[1:-1] = np.diff(steps, axis=0) / dt**2
    bends[0] = bends[min(1, len(steps) - 1)] if len(steps) > 1 else 0.0
    bends[-1] = bends[-2] if len(steps) > 1 else 0.0
    moved = (steps != 0.0).any(axis=0)
    slack = np.maximum(np.where(moved, 2.0 * jerks * dt, 0.0), _jump(steps, bends, dt))
    speeds = np.abs(steps) / dt + (np.maximum(np.abs(bends[1:]), np.abs(bends[:-1])) + slack) * (0.5 * dt)
    columns = np.flatnonzero(speeds.any(axis=0))
    before, after = bends[:-1], bends[1:]
    linear = steps / dt - (2.0 * before + after) * (dt / 6.0)
    terms = positions[:-1], linear, 0.5 * before, (after - before) / (6.0 * dt)
    path = PiecewisePolynomial(
        begin + dt * np.arange(len(positions), dtype=np.float64), np.stack(terms, axis=1)[:, :, columns]
    )
    gone = np.concatenate([np.zeros((1, len(columns))), np.cumsum(speeds[:, columns] * dt, axis=0)])
    lengths = Lengths(path.breaks.tolist(), gone, speeds[:, columns])
    return of_path(positions[0], columns, path, lengths, slack * (dt**2 / 8.0))
