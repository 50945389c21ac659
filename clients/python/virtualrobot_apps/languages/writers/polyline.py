"""Lines that tell a motion of a tool: the fewest that stay near it, for controllers that know lines alone."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from virtualrobot.geometry import Matrix, rows_from_poses

from virtualrobot_apps.languages.writers.statements import Floats, Zone

BESIDE, TURNED = 5e-5, 1e-3
"""Greatest distance (m) and turn (rad) of a tool on the lines from the motion that they tell."""
CORNER = 0.4
"""Part of the shorter one of two lines that the zone between them takes."""
STANDS = 1e-6
"""Distance (m) from place to place up to which a tool stands."""


@dataclass(frozen=True, slots=True, eq=False)
class Polyline:
    """Lines from place to place.

    Attributes:
        rows: (m + 1,) the rows of the motion where lines begin and end.
        lengths: (m,) of the lines (m).
        speeds: (m,) of the tool on them (m/s): the greatest that it has on that stretch of its motion.
    """

    rows: NDArray[np.int64]
    lengths: Floats
    speeds: Floats

    def zone(self, line: int) -> Zone | None:
        """Return the corner after a line, so that the tool doesn't stop there; None after the last one."""
        if line == len(self.lengths) - 1:
            return None
        return Zone(CORNER * float(self.lengths[line : line + 2].min()), CORNER)


def polyline(poses: Matrix, speeds: Floats) -> Polyline | None:
    """Return lines through some poses of (n, 4, 4), so that none is farther from them than `BESIDE` and `TURNED`.

    Between two poses a controller goes straight and turns evenly about one axis. `speeds` (n,) are those of the tool
    (m/s). None where the tool turns on the spot, or doesn't move: no line tells that.

    The division is that of D. Douglas, T. Peucker, Algorithms for the reduction of the number of points, 1973.
    """
    points, turns = np.split(rows_from_poses(poses), [3], axis=1)
    kept = [0, len(poses) - 1]
    divided = [(0, len(poses) - 1)]
    while divided:
        first, last = divided.pop()
        if last - first < 2:
            continue
        off = _off(points[first : last + 1], turns[first : last + 1])
        worst = int(off[1:-1].argmax()) + 1
        if off[worst] > 1.0:
            kept.append(first + worst)
            divided += [(first, first + worst), (first + worst, last)]
    rows = np.array(sorted(kept))
    lengths = np.linalg.norm(np.diff(points[rows], axis=0), axis=1)
    if lengths.min() <= STANDS:
        return None
    fastest = np.array([speeds[a : b + 1].max() for a, b in pairwise(rows.tolist())])
    return Polyline(rows, lengths, fastest)


def _off(points: Floats, turns: Floats) -> Floats:
    """Return how far poses are off the line from the first to the last, in parts of what is allowed: (n,).

    points (n, 3) in m, turns (n, 4) unit quaternions. A pose that is behind one before it, as seen along the line, is
    off by that, too: there the tool goes back.
    """
    along, chord = points - points[0], points[-1] - points[0]
    squared = float(chord @ chord)
    shares = np.clip(along @ chord / max(squared, STANDS**2), 0.0, 1.0)
    aside = np.linalg.norm(along - shares[:, None] * chord, axis=1)
    behind = np.sqrt(squared) * (np.maximum.accumulate(shares) - shares)
    cosine = float(turns[0] @ turns[-1])
    last = turns[-1] if cosine >= 0.0 else -turns[-1]
    half = np.arccos(min(abs(cosine), 1.0))
    # Slerp (K. Shoemake, Animating rotation with quaternion curves, 1985); evenly where the angle vanishes.
    parts = np.stack([1.0 - shares, shares]) if half < 1e-6 else np.sin(half * np.stack([1.0 - shares, shares]))
    evenly = parts[0][:, None] * turns[0] + parts[1][:, None] * last
    evenly /= np.linalg.norm(evenly, axis=1, keepdims=True)
    turned = 2.0 * np.arccos(np.clip(np.abs(np.einsum("ij,ij->i", evenly, turns)), 0.0, 1.0))
    return np.maximum(np.maximum(aside, behind) / BESIDE, turned / TURNED)
