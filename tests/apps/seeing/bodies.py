"""Bodies of boxes that a scanner looks at from around, and a judge of what its views cover, by rays of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from virtualrobot_apps.seeing.views.planning import ViewPlanner, views_around
from virtualrobot_apps.seeing.views.voxels import Floats, Voxels

from tests.apps.seeing.box_scanner import Box, met, rays

LOW, HIGH, EDGE = (-0.3, -0.3, 0.0), (0.3, 0.3, 0.6), 0.02
MIDDLE = np.array([0.0, 0.0, 0.2])
REACH, HALF = 1.6, np.radians(25.0)
GROUND: Box = ((-2.0, -2.0, -0.1), (2.0, 2.0, -1e-9))
VIEWS = 8
BODIES: dict[str, list[Box]] = {
    "table": [
        ((-0.25, -0.2, 0.3), (0.25, 0.2, 0.34)),
        *(((x - 0.02, y - 0.02, 0.0), (x + 0.02, y + 0.02, 0.3)) for x in (-0.22, 0.22) for y in (-0.17, 0.17)),
    ],
    "shelf": [
        ((-0.2, -0.12, 0.0), (-0.18, 0.12, 0.45)),
        ((0.18, -0.12, 0.0), (0.2, 0.12, 0.45)),
        ((-0.2, 0.1, 0.0), (0.2, 0.12, 0.45)),
        *(((-0.2, -0.12, z), (0.2, 0.12, z + 0.02)) for z in (0.0, 0.2, 0.43)),
    ],
    "crate": [
        ((-0.2, -0.15, 0.0), (0.2, 0.15, 0.02)),
        *(((x - 0.01, -0.15, 0.0), (x + 0.01, 0.15, 0.3)) for x in (-0.19, 0.19)),
        *(((-0.2, y - 0.01, 0.0), (0.2, y + 0.01, 0.3)) for y in (-0.14, 0.14)),
    ],
    "tunnel": [
        *(((x - 0.02, -0.25, 0.0), (x + 0.02, 0.25, 0.2)) for x in (-0.15, 0.15)),
        ((-0.17, -0.25, 0.2), (0.17, 0.25, 0.24)),
        ((-0.05, -0.05, 0.24), (0.05, 0.05, 0.45)),
    ],
    "chair": [
        ((-0.2, -0.2, 0.25), (0.2, 0.2, 0.29)),
        ((-0.2, 0.16, 0.29), (0.2, 0.2, 0.55)),
        *(((x - 0.02, y - 0.02, 0.0), (x + 0.02, y + 0.02, 0.25)) for x in (-0.18, 0.18) for y in (-0.18, 0.18)),
    ],
    "comb": [
        ((-0.25, -0.2, 0.0), (0.25, 0.2, 0.03)),
        *(((x - 0.01, -0.2, 0.03), (x + 0.01, 0.2, 0.35)) for x in (-0.2, -0.07, 0.07, 0.2)),
    ],
}


def looking(along_x: Floats) -> Floats:
    """Return rays about z of rays about x."""
    return along_x[:, [1, 2, 0]]


FAN = looking(rays(2.0 * HALF, np.radians(0.1), np.radians(0.25)))
"""Rays of a range finder of two dimensions."""
RAYS = looking(rays(2.0 * HALF, 2.0 * HALF, np.radians(1.25)))


def look(planner: ViewPlanner, view: Floats, boxes: list[Box], of_view: Floats = RAYS) -> int:
    """Take a scan from a view, by rays (n, 3) about its z."""
    along = of_view @ view[:3, :3].T
    lengths = met([*boxes, GROUND], view[:3, 3], along)
    seen = lengths <= REACH
    return planner.take(view[:3, 3], view[:3, 3] + along * np.where(seen, lengths, REACH)[:, None], seen)


def skin(boxes: list[Box], rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Return points (n, 3) of the outer faces of boxes, and their normals."""
    points, normals = [], []
    for low, high in np.array(boxes):
        for axis in range(3):
            for end, sign in ((low, -1.0), (high, 1.0)):
                others = [one for one in range(3) if one != axis]
                count = int(np.ceil(8000.0 * np.prod((high - low)[others])))
                face = rng.uniform(low, high, (count, 3))
                face[:, axis] = end[axis]
                points.append(face)
                normals.append(np.tile(sign * np.eye(3)[axis], (count, 1)))
    places, out = np.vstack(points), np.vstack(normals)
    before = places + 1e-4 * out
    hidden = np.any([((before >= low) & (before <= high)).all(axis=1) for low, high in np.array(boxes)], axis=0)
    return places[~hidden & (before[:, 2] > 0.0)], out[~hidden & (before[:, 2] > 0.0)]


def visible(view: Floats, places: Floats, out: Floats, boxes: list[Box]) -> np.ndarray:
    """Return which places are met by a ray from a view, in its field, by less than 80 degrees off their normals."""
    off = places - view[:3, 3]
    lengths = np.linalg.norm(off, axis=1)
    along = off / lengths[:, None]
    x, y, z = (along @ view[:3, :3]).T
    inside = (np.abs(np.arctan2(x, z)) < HALF) & (np.abs(np.arctan2(y, np.hypot(x, z))) < HALF)
    inside &= (lengths < REACH) & ((along * out).sum(axis=1) < -np.cos(np.radians(80.0)))
    found = np.zeros(len(places), bool)
    found[inside] = met([*boxes, GROUND], view[:3, 3], along[inside]) > lengths[inside] - 1e-3
    return found


@dataclass(frozen=True)
class Covered:
    """Part of what all views see together that chosen ones see, and drawn ones in the mean; and the planner's views."""

    chosen: float
    drawn: float
    views: list[Floats]


def covered(boxes: list[Box], rng: np.random.Generator) -> Covered:
    """Return what VIEWS views of 60 cover of a body, chosen one after the other, and drawn 20 times."""
    views = views_around(MIDDLE, np.array([0.7, 0.9]), 30)
    planner = ViewPlanner(Voxels(LOW, HIGH, EDGE), views, RAYS, REACH)
    chosen = list[Floats]()
    while len(chosen) < VIEWS and (view := planner.next()) is not None:
        look(planner, view, boxes)
        chosen.append(view)
    places, out = skin(boxes, rng)
    seen = np.array([visible(view, places, out, boxes) for view in views])
    coverable = seen.any(axis=0).sum()
    by_chosen = np.any([visible(view, places, out, boxes) for view in chosen], axis=0).sum() / coverable
    drawn = [seen[rng.choice(len(views), VIEWS, replace=False)].any(axis=0).sum() / coverable for _ in range(20)]
    return Covered(float(by_chosen), float(np.mean(drawn)), chosen)
