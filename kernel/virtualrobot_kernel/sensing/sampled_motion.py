"""Motion of nodes from their places at three ticks: differences that are exact for constant acceleration.

Central differences tell of the middle one of three ticks; so what they tell is one tick old, and its error is of second
order in the tick (R. Hamming, Numerical methods for scientists and engineers, 2nd edition 1973, chapter 35).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.planning.robots import with_state
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.world.state import Snapshot

Floats = NDArray[np.float64]
Ticks = tuple[Snapshot, Snapshot, Snapshot]
"""The world at three ticks, the oldest first."""


@dataclass(frozen=True, slots=True, eq=False)
class SampledMotion:
    """Motion of n frames at the middle one of three ticks.

    Attributes:
        pose: (n, 4, 4) in the world.
        angular_velocity: (n, 3) rad/s, and `angular_acceleration` (n, 3) rad/s^2, each in the frame itself.
        acceleration: (n, 3) of the origins in the world, m/s^2.
        velocity: (n, 3) of the origins in the world at the last one of the ticks, m/s.
    """

    pose: Floats
    angular_velocity: Floats
    angular_acceleration: Floats
    acceleration: Floats
    velocity: Floats


def three_ticks(moment: Moment) -> Ticks:
    """Return the world of a reading and of the two ticks before it that the history has.

    Where it has none, the world goes back at the speeds of its joints.
    """
    found = [moment.snapshot]
    for earlier in reversed(moment.history):
        if len(found) < 3 and earlier.state.tick < found[-1].state.tick:
            found.append(earlier)
    while len(found) < 3:
        found.append(_a_tick_before(found[-1]))
    return found[2], found[1], found[0]


def poses_of(ticks: Ticks, uids: Sequence[int]) -> Floats:
    """Return where nodes were at three ticks, (3, n, 4, 4); one that was not there yet was where it is first."""
    result = np.empty((3, len(uids), 4, 4))
    for at in (2, 1, 0):
        snapshot = ticks[at]
        if snapshot.structure is ticks[2].structure:
            result[at] = snapshot.world_t_node[[snapshot.structure.rows[uid] for uid in uids]]
            continue
        for place, uid in enumerate(uids):
            there = uid in snapshot.structure.rows
            result[at, place] = snapshot.world_t(uid) if there else result[at + 1, place]
    return result


def sampled_motion(ticks: Ticks, poses: Floats) -> SampledMotion:
    """Return how frames move that were at `poses` (3, n, 4, 4); they turn by less than half a turn in a tick."""
    first, second = ((ticks[i + 1].state.tick - ticks[i].state.tick) * ticks[2].tick_seconds for i in range(2))
    span = first + second
    speeds = [(poses[i + 1, :, :3, 3] - poses[i, :, :3, 3]) / length for i, length in ((0, first), (1, second))]
    turns = [
        rotation_vectors(np.swapaxes(poses[i, :, :3, :3], 1, 2) @ poses[i + 1, :, :3, :3]) / length
        for i, length in ((0, first), (1, second))
    ]
    acceleration = 2.0 * (speeds[1] - speeds[0]) / span
    return SampledMotion(
        pose=poses[1],
        angular_velocity=(second * turns[0] + first * turns[1]) / span,
        angular_acceleration=2.0 * (turns[1] - turns[0]) / span,
        acceleration=acceleration,
        velocity=speeds[1] + 0.5 * second * acceleration,
    )


def rotation_vectors(rotations: Floats) -> Floats:
    """Return axis times angle (n, 3) of rotations (n, 3, 3) by less than half a turn, exact to rounding when small."""
    skew = 0.5 * (rotations - np.swapaxes(rotations, 1, 2))
    axes = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)
    sine = np.linalg.norm(axes, axis=1)
    cosine = 0.5 * (np.trace(rotations, axis1=1, axis2=2) - 1.0)
    factor = np.where(sine > 0.0, np.arctan2(sine, cosine) / np.where(sine > 0.0, sine, 1.0), 1.0)
    return axes * factor[:, None]


def _a_tick_before(snapshot: Snapshot) -> Snapshot:
    """Return the world a tick earlier if joints of one coordinate had gone at their speeds, and nothing else."""
    structure, state = snapshot.structure, snapshot.state
    q = state.q.copy()
    for robot in structure.robots.values():
        for joint, at_q, at_v in zip(robot.joints, robot.q_start, robot.v_start, strict=True):
            if joint.type.coordinate_count == 1:
                q[at_q] -= state.v[at_v] * snapshot.tick_seconds
    return with_state(snapshot, replace(state, q=q, tick=state.tick - 1))
