"""Matching of scans: the pose at which the points of one lie on the walls of the other.

Each point is drawn to the line of the patch of wall that is nearest, along its normal alone: where rays happen to meet
a wall doesn't count. A. Censi, An ICP Variant Using a Point-to-Line Metric, IEEE ICRA 2008. What odometry says is one
more measurement, by its deviations: along a corridor without features nothing else tells.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from virtualrobot_apps.seeing.navigation.poses import Floats, between, moved, wrapped

FITS = 0.1
"""Distance (m) from the nearest point at which a point fits."""
FEWEST = 20
"""Fewest points of a scan that can be matched."""
PATCH, PATCH_RADIUS = 0.1, 0.18
"""Distance (m) between patches of walls, and the radius about its middle of what counts to one."""
STRAIGHT = 0.35
"""Variance across a patch, as part of that along it, up to which it is one."""
ALIKE = 0.5
"""Cosine of the angle between normals up to which points are on the same side of a wall: walls are thin."""
LEAST_DEVIATION = 0.01
"""Least deviation (m) of points from patches: below it their unevenness isn't noise."""
WEAK = 0.02
"""Information about a direction, as part of that about the other, below which a match is free along it."""
CONTRADICTED = 3.0
"""Deviations of odometry from which on it counts as wrong."""
_STEPS, _STILL = 30, 1e-8
_NEIGHBOURS = 16


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """Match of two clouds.

    pose: (3,) of the second in the frame of the first. share: of its points that fit, 0 to 1. weak: whether the clouds
    leave it free along one direction, as in a corridor without features.
    """

    pose: Floats
    share: float
    weak: bool


class Cloud:
    """Points (n, 2) and normals (n, 2) towards where they were seen from, that others are matched with, prepared once.

    Of many scans each has its noise: patches average it away, so that no point finds one that happens to be near.
    """

    def __init__(self, points: Floats, normals: Floats) -> None:
        """Prepare points in their frame; raise ValueError for fewer than FEWEST."""
        if len(points) < FEWEST:
            raise ValueError(f"{len(points)} points are too few to be matched: {FEWEST} at least")
        self._tree = KDTree(points)
        self._middles, self._normals = _patches(np.asarray(points, np.float64), normals, self._tree)
        self._patches = KDTree(self._middles) if len(self._middles) else None

    def match(
        self,
        points: Floats,
        normals: Floats,
        guess: Floats,
        deviations: tuple[float, float] | None = None,
        reach: float = 0.5,
    ) -> Match:
        """Return the pose of points (n, 2) with normals (n, 2) in the frame of this cloud, from a guess (3,) on.

        `deviations` are those of the guess (m, rad) where it is a measurement, and not only where to begin. Points
        further than `reach` (m) from any of this cloud don't draw; it shrinks to three times FITS as the pose settles.
        """
        pose = np.array(guess, np.float64)
        prior = np.zeros(3) if deviations is None else np.array([deviations[0], deviations[0], deviations[1]]) ** -2.0
        information = np.zeros((3, 3))
        patches = self._patches
        for _ in range(_STEPS):
            if patches is None:
                break
            turn = np.array([0.0, 0.0, pose[2]])
            turned, facing = moved(turn, points), moved(turn, normals)
            apart, nearest = patches.query(turned + pose[:2], k=3, distance_upper_bound=reach)
            known = np.isfinite(apart)
            nearest = np.where(known, nearest, 0)
            known &= (self._normals[nearest] * facing[:, None]).sum(axis=2) > ALIKE
            first = np.argmax(known, axis=1)
            near = np.flatnonzero(known[np.arange(len(points)), first])
            if len(near) < FEWEST // 2:
                break
            at = nearest[near, first[near]]
            lines, drawn = self._normals[at], turned[near]
            off = ((drawn + pose[:2] - self._middles[at]) * lines).sum(axis=1)
            deviation = max(LEAST_DEVIATION, 1.4826 * float(np.median(np.abs(off))))
            # P. J. Huber's loss: what is far draws no harder.
            weights = np.minimum(1.0, 1.345 * deviation / np.maximum(np.abs(off), 1e-12)) / deviation**2
            by_pose = np.column_stack([lines, lines[:, 1] * drawn[:, 0] - lines[:, 0] * drawn[:, 1]])
            information = (by_pose * weights[:, None]).T @ by_pose
            from_guess = pose - guess
            from_guess[2] = wrapped(from_guess[2])
            slope = (by_pose * weights[:, None]).T @ off + prior * from_guess
            step = -np.linalg.lstsq(information + np.diag(prior), slope, rcond=1e-9)[0]
            pose += step
            settled = reach <= 3.0 * FITS
            reach = max(3.0 * FITS, 0.7 * reach)
            if settled and np.abs(step).max() < _STILL:
                break
        pose[2] = wrapped(pose[2])
        values = np.linalg.eigvalsh(_about_places(information))
        return Match(pose, self.share(points, pose), bool(values[0] <= WEAK * values[1]))

    def match_after(self, points: Floats, normals: Floats, guess: Floats, step: Floats) -> Match:
        """Return the pose of points (n, 2) with normals (n, 2) from a guess (3,) that odometry has after a step (3,).

        Odometry is one more measurement, unless the walls contradict it: wheels slip, and encoders fail.
        """
        meters, radians = odometry_deviations(step)
        found = self.match(points, normals, guess, (meters, radians))
        off = between(guess, found.pose)
        if np.hypot(off[0], off[1]) > CONTRADICTED * meters or abs(off[2]) > CONTRADICTED * radians:
            free = self.match(points, normals, found.pose)
            if free.share >= found.share and not free.weak:
                return free
        return found

    def share(self, points: Floats, pose: Floats) -> float:
        """Return which part of points (n, 2) fits when their frame has this pose."""
        apart, _ = self._tree.query(moved(pose, points), distance_upper_bound=FITS)
        return float(np.isfinite(apart).mean())


def odometry_deviations(way: Floats) -> tuple[float, float]:
    """Return the deviations (m, rad) that odometry is taken to have after a way (3,): about a tenth of it."""
    meters, radians = float(np.hypot(way[0], way[1])), abs(float(way[2]))
    return 0.002 + 0.1 * meters, 0.002 + 0.1 * radians + 0.05 * meters


def normals_of(points: Floats, origin: Floats) -> Floats:
    """Return normals (n, 2) of what points (n, 2) of one scan lie on, towards where they were seen from (2,)."""
    if not len(points):
        return np.zeros((0, 2))
    sight = origin - points
    # What is far is sparse, and noise grows with distance.
    radius = 0.08 + 0.05 * np.hypot(*sight.T)
    apart, nearest = KDTree(points).query(points, k=min(_NEIGHBOURS, len(points)))
    near = (apart.reshape(len(points), -1) <= radius[:, None])[..., None]
    neighbours = points[nearest.reshape(len(points), -1)]
    off = np.where(
        near, neighbours - (neighbours * near).sum(axis=1, keepdims=True) / near.sum(axis=1, keepdims=True), 0.0
    )
    normals, _ = _across((off[..., 0] ** 2).sum(axis=1), (off[..., 1] ** 2).sum(axis=1), off.prod(axis=2).sum(axis=1))
    sides = np.where((normals * sight).sum(axis=1) < 0.0, -1.0, 1.0)
    return np.column_stack([normals[:, 0] * sides, normals[:, 1] * sides])


def _patches(points: Floats, normals: Floats, tree: KDTree) -> tuple[Floats, Floats]:
    """Return middles and normals (m, 2) of patches of walls, each of points that look to the same side."""
    sides = np.round(np.arctan2(normals[:, 1], normals[:, 0]) / (0.5 * np.pi)) % 4.0
    _, seeds = np.unique(np.column_stack([np.floor(points / PATCH), sides]), axis=0, return_index=True)
    members = tree.query_ball_point(points[seeds], PATCH_RADIUS)
    counts = np.array([len(one) for one in members])
    of, at = np.repeat(np.arange(len(seeds)), counts), np.concatenate(members).astype(np.int64)
    alike = (normals[seeds][of] * normals[at]).sum(axis=1) > ALIKE
    of, at = of[alike], at[alike]

    def sums(values: Floats) -> Floats:
        return np.bincount(of, values, len(seeds)).astype(float)

    number = sums(np.ones(len(of)))
    middles = np.column_stack([sums(points[at, 0]), sums(points[at, 1])]) / number[:, None]
    off = points[at] - middles[of]
    found, part = _across(sums(off[:, 0] ** 2), sums(off[:, 1] ** 2), sums(off.prod(axis=1)))
    found *= np.where((found * normals[seeds]).sum(axis=1) < 0.0, -1.0, 1.0)[:, None]
    straight = (number >= 3) & (part <= STRAIGHT)
    return middles[straight], found[straight]


def _across(xx: Floats, yy: Floats, xy: Floats) -> tuple[Floats, Floats]:
    """Return of moments (n,) the directions (n, 2) of least variance, and it as part (n,) of the greatest."""
    along = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    mean, half = 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy)
    return np.column_stack([-np.sin(along), np.cos(along)]), (mean - half) / np.maximum(mean + half, 1e-12)


def _about_places(information: Floats) -> Floats:
    """Return what (2, 2) an information (3, 3) tells of the place while the heading is unknown."""
    if information[2, 2] < 1e-12:
        return information[:2, :2]
    return information[:2, :2] - np.outer(information[:2, 2], information[2, :2]) / information[2, 2]
