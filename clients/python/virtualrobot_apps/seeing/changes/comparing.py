"""Comparison of two scans of a place: what one has seen where the other has looked past it, joined to things."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.seeing.changes.registering import LEAST_DEVIATION, Registration, moved, off_planes, registered
from virtualrobot_apps.seeing.changes.scan import Floats, Scan

BEFORE = 0.02
"""Distance (m), besides five deviations of the noise, by which a point lies before what the other scan has seen."""
LOOKS = 9
"""Number of the other scan's rays about a point, all of which must have looked past it."""
AMONG = 0.1
"""Distance of these rays to each side of the point's direction, in the angle between rays, where it is among them."""
SIDES = 8
"""Number of sides of a direction that are looked at for that."""
AROUND = 48
"""Number of neighbours that the surface goes through on which a point may lie: rays that graze it come in rows."""
JOINED = 0.05
"""Distance (m) up to which points belong to one thing."""
LEAST_POINTS = 5
"""Fewest points of a thing."""
SAME_PLACE = 0.8
"""Part of a scan that must fit the other one, for both to be of one place."""


class OtherPlaceError(InvalidArgumentError):
    """Raised where two scans are of different places."""


@dataclass(frozen=True, slots=True, eq=False)
class Change:
    """Thing that stands there now (`appeared`), or is gone.

    place: (3,) middle of the box about what was seen of it, and size: (3,) of that box, along the world's axes (m),
    down to the surface below that the other scan has seen, where its points come near that. What is hidden, such as its
    far side, is not in it, and between rays it may go on. points: number of its points.
    """

    appeared: bool
    place: Floats
    size: Floats
    points: int

    @property
    def volume(self) -> float:
        """Return the volume of the box about what was seen of it (m³)."""
        return float(self.size.prod())

    def __str__(self) -> str:
        """Return it in words."""
        x, y, z = self.place
        wide, deep, high = self.size
        where = "stands now" if self.appeared else "stood"
        return f"something, seen of it {wide:.2f} x {deep:.2f} x {high:.2f} m, {where} at ({x:.2f}, {y:.2f}, {z:.2f})"


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """Comparison of two scans: what changed, the biggest first, and how the second was registered with the first.

    identical: both are the same to the bit: the sensor has not measured again, or it has no noise.
    """

    changes: tuple[Change, ...]
    registration: Registration
    identical: bool = False


def compare(before: Scan, after: Scan) -> Comparison:
    """Return what changed from one scan of a place to another from nearly the same pose of the sensor.

    Poses of both are as the robot has them; the second is registered with the first. The frame of changes is the world
    of the first scan.

    Raises:
        OtherPlaceError: where the scans are of different places.
        InvalidArgumentError: where echoes of one lie too close together to be registered.
    """
    if before.points.shape == after.points.shape and np.array_equal(before.points, after.points):
        return Comparison((), Registration(np.eye(4), 1.0, LEAST_DEVIATION), identical=True)
    guess = np.linalg.inv(before.world_t_sensor) @ after.world_t_sensor
    found = registered(before.points, after.points, guess)
    if found.share < SAME_PLACE:
        raise OtherPlaceError(
            f"the second scan fits the first one to {100.0 * found.share:.0f}%, and {100.0 * SAME_PLACE:.0f}% at least "
            "are needed: is it of the same place?"
        )
    back = np.asarray(np.linalg.inv(found.pose), np.float64)
    new = after.points[_unseen(before.points, moved(found.pose, after.points), found.deviation)]
    gone = before.points[_unseen(after.points, moved(back, before.points), found.deviation)]
    clear, world_t_after = BEFORE + 5.0 * found.deviation, before.world_t_sensor @ found.pose
    was, now = moved(before.world_t_sensor, before.points), moved(world_t_after, after.points)
    changes = [
        *_things(moved(world_t_after, new), np.linalg.norm(new, axis=1), _step(after.points), was, clear, True),
        *_things(
            moved(before.world_t_sensor, gone), np.linalg.norm(gone, axis=1), _step(before.points), now, clear, False
        ),
    ]
    return Comparison(tuple(sorted(changes, key=lambda one: -one.volume)), found)


def _step(points: Floats) -> float:
    """Return the angle (rad) between rays beside each other that have met points (n, 3)."""
    along = points / np.linalg.norm(points, axis=1, keepdims=True)
    away, _ = KDTree(along).query(along[:: max(1, len(along) // 500)], k=2)
    return float(np.median(away[:, 1]))


def _unseen(seen: Floats, points: Floats, deviation: float) -> np.ndarray:
    """Return which of points (n, 3), in the frame of another scan, lie clearly before all that it has seen (m, 3)."""
    ranges, lengths = np.linalg.norm(seen, axis=1), np.linalg.norm(points, axis=1)
    along, to = seen / ranges[:, None], points / lengths[:, None]
    rays = np.asarray(KDTree(along).query(to, k=min(LOOKS, len(seen)))[1])
    clear = BEFORE + 5.0 * deviation
    found = lengths < ranges[rays].min(axis=1) - clear
    # Beside the other scan's field of view all of its rays are to one side, and nobody knows.
    found[found] = _among(along[rays[found]], to[found], AMONG * _step(seen))
    if found.any():
        # Along a surface that rays graze, ranges differ much from one to the next: what lies on it is no change.
        off, _ = off_planes(KDTree(seen), seen, points[found], np.inf, AROUND)
        found[found] = ~(np.abs(off) < clear)
    return found


def _among(around: Floats, to: Floats, least: float) -> np.ndarray:
    """Return which directions (n, 3) have some of those around (n, m, 3) on each side, at least so far off (rad)."""
    across = np.cross(to, np.where(np.abs(to[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]]))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    off = around - to[:, None]
    plane = np.stack([(off * across[:, None]).sum(axis=2), (off * np.cross(to, across)[:, None]).sum(axis=2)], axis=2)
    turns = np.arange(SIDES) * 2.0 * np.pi / SIDES
    sides = plane @ np.array([np.cos(turns), np.sin(turns)])
    return np.asarray((sides.max(axis=1) > least).all(axis=1), bool)


def _things(points: Floats, ranges: Floats, step: float, others: Floats, clear: float, appeared: bool) -> list[Change]:
    """Return the things that points (n, 3) of the world at distances (n,) from the sensor belong to.

    They stand on what the other scan has seen there (m, 3), of which echoes up to `clear` (m) don't tell a thing.
    """
    if not len(points):
        return []
    joined = max(JOINED, 2.5 * step * float(np.median(ranges)))
    pairs = KDTree(points).query_pairs(joined, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    count, labels = connected_components(graph, directed=False)
    found = []
    for number in range(count):
        mine = points[labels == number]
        if len(mine) >= LEAST_POINTS:
            low, high = mine.min(axis=0), mine.max(axis=0)
            beside = step * float(np.median(ranges))
            under = others[((others > low - beside) & (others < high + beside))[:, :2].all(axis=1), 2]
            if (below := under[(under < low[2]) & (under > low[2] - clear - beside)]).size:
                low[2] = np.median(below)
            found.append(Change(appeared, 0.5 * (low + high), high - low, len(mine)))
    return found
