"""Walks: where body and feet of a machine are over time, from a course, a gait and the ground."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_apps.vehicles.walking.course import Part, course, duration
from virtualrobot_apps.vehicles.walking.feet import blend, swing
from virtualrobot_apps.vehicles.walking.footholds import Ground, Stand, Step, flat, footholds
from virtualrobot_apps.vehicles.walking.gaits import Gait

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]

KNOT = 0.008
"""Time between the instants that a walk is told at (s)."""


@dataclass(frozen=True, slots=True, eq=False)
class Walk:
    """Walk of a machine with l legs, told at n instants; it begins and ends at rest on all feet.

    times: (n,) from 0 (s). bodies: (n, 4, 4) world_t_body. feet: (n, l, 3) middles of the feet in the world (m).
    stance: (n, l) whether each foot is on the ground. steps: of each leg.
    """

    gait: Gait
    stand: Stand
    times: Floats
    bodies: Floats
    feet: Floats
    stance: Booleans
    steps: list[list[Step]]

    @property
    def body_t_feet(self) -> Floats:
        """Places (n, l, 3) of the feet in the frame of the body (m)."""
        off = self.feet - self.bodies[:, None, :3, 3]
        return np.einsum("nji,nlj->nli", self.bodies[:, :3, :3], off)

    def stance_at(self, time: float) -> Booleans:
        """Return which feet are on the ground (l,) at a time (s)."""
        return np.array([not any(step.begin < time < step.end for step in of) for of in self.steps])


def plan_walk(
    gait: Gait,
    stand: Stand,
    parts: Sequence[Part],
    ground: Ground | None = None,
    start: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Walk:
    """Return the walk of a machine from x, y (m) and heading (rad), over its parts, until it stands again.

    Raises ValueError where a number makes no walk, or where there is no ground for a foot.
    """
    if len(gait.phases) != len(stand.feet):
        raise ValueError(f"the gait {gait.name!r} is of {len(gait.phases)} legs, and the machine has {len(stand.feet)}")
    if not parts:
        raise ValueError("a course has a part at least")
    ground = ground or flat()
    # When the body stands, each foot steps once more and comes to its place below it.
    stopped = duration(parts, gait.cycle)
    until = stopped + gait.cycle * (1.0 - gait.duty_factor / 2.0)
    times = KNOT * np.arange(int(np.ceil(until / KNOT - 1e-9)) + 1, dtype=np.float64)
    poses = course(times, parts, gait.cycle, start)
    first, steps = footholds(gait, stand, times, poses, ground, float(times[-1]))
    feet = np.repeat(first[None], len(times), axis=0)
    below = feet.copy()
    stance = np.ones(feet.shape[:2], np.bool_)
    for leg, of in enumerate(steps):
        for step in of:
            part = (times - step.begin) / (step.end - step.begin)
            during, after = (times > step.begin) & (times < step.end), times >= step.end
            feet[during, leg] = swing(part[during], step.start, step.goal, step.height)
            below[during, leg] = step.start + (step.goal - step.start) * blend(part[during])[:, None]
            feet[after, leg] = below[after, leg] = step.goal
            stance[during, leg] = False
    below[:, :, 2] -= stand.foot_radius
    envelope = blend(times / gait.cycle) * blend((times[-1] - times) / gait.cycle)
    offsets = _sway(gait, stand, times) * envelope[:, None] - np.array(stand.center)
    return Walk(gait, stand, times, _bodies(poses, offsets, below, stand.height), feet, stance, steps)


def _sway(gait: Gait, stand: Stand, times: Floats) -> Floats:
    """Return how far forward and to the left (n, 2) the body leans, away from what steps: a wave a cycle."""
    middle = np.array(gait.phases) - (1.0 - gait.duty_factor) / 2.0
    wave = (-np.sign(stand.feet[:, 1]) * np.exp(2j * np.pi * middle)).sum()
    leaning = np.zeros((len(times), 2))
    if stand.sway > 0.0 and abs(wave) > 0.1:
        leaning[:, 1] = stand.sway * np.cos(2.0 * np.pi * times / gait.cycle - np.angle(wave))
    return leaning


def _bodies(poses: Floats, offsets: Floats, below: Floats, height: float) -> Floats:
    """Return poses (n, 4, 4) of the body: level with the plane through its feet, `height` above it.

    `below` (n, l, 3) are the places of the feet on the ground, those in the air on the line between their footholds.
    """
    count = below.mean(axis=1, keepdims=True)
    off = below - count
    # Least squares: z = a x + b y about the middle of the feet.
    matrix = np.einsum("nli,nlj->nij", off[:, :, :2], off[:, :, :2])
    gradient = np.linalg.solve(matrix, np.einsum("nli,nl->ni", off[:, :, :2], off[:, :, 2])[..., None])[..., 0]
    normal = np.column_stack([-gradient, np.ones(len(poses))])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    heading = np.column_stack([np.cos(poses[:, 2]), np.sin(poses[:, 2]), np.zeros(len(poses))])
    forward = heading - (heading * normal).sum(axis=1, keepdims=True) * normal
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    bodies = np.tile(np.eye(4), (len(poses), 1, 1))
    bodies[:, :3, 0], bodies[:, :3, 1], bodies[:, :3, 2] = forward, np.cross(normal, forward), normal
    left = np.column_stack([-heading[:, 1], heading[:, 0]])
    bodies[:, :2, 3] = poses[:, :2] + offsets[:, :1] * heading[:, :2] + offsets[:, 1:] * left
    middle = count[:, 0]
    ground = middle[:, 2] + (gradient * (bodies[:, :2, 3] - middle[:, :2])).sum(axis=1)
    bodies[:, 2, 3] = ground + height
    return bodies
