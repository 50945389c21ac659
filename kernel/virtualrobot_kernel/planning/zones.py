"""How large a zone about a corner can be: what the moves have room for, by the ways of the tool centre points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.blend import Corner, round_corner
from virtualrobot_kernel.motion.limits import TOLERANCE, JointLimits
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.planning.program import Zone

MOST = 0.5
"""The share of a move that one of its two zones may take, as on robot controllers."""

_SAMPLES = 32
"""In how many places a half move and a rounded corner are looked at."""

_STILL = 1e-6
"""A tool centre point that moves by less, in meters, does not move."""

_SMALLER, _TRIES = 0.8, 24
"""A corner that does not fit is tried this much smaller, and how often: down to half a percent of it."""

_WIDE = 1.1
"""How much farther from its corner than on the programmed way a zone in percent may lead a tool centre point."""

Floats = NDArray[np.float64]
Position = Callable[[Floats], Floats]
"""Gives where a robot's tool centre point is, (3,) in m in its base's frame, with the joints (n,) of the run."""


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A zone that fits: its corner, the size that it was given in the unit that was asked for, and why it is smaller.

    Without a corner there is none that fits, for the reason `why`.
    """

    corner: Corner | None
    kept: float
    why: str


def fitted(
    before: PiecewisePolynomial,
    after: PiecewisePolynomial,
    zone: Zone,
    positions: Sequence[Position],
    limits: JointLimits,
) -> Fitted:
    """Return the corner between two paths that goes over a zone, at most as large as was asked for.

    A distance is the radius of a sphere about the corner: the piece begins where the first tool centre point comes into
    its own sphere for good and ends where the first one leaves its own. A percentage is of each path's parameter. No
    zone takes more than half of a path. The piece keeps the joints within their limits and the tool centre points
    within the spheres (of a percentage: not farther from the corner than on the programmed way, by a tenth); one that
    does not is made smaller.
    """
    halves = [_Half(before, True, positions), _Half(after, False, positions)]
    if zone.percent > 0.0:
        wanted = kept = zone.percent
    else:
        wanted = kept = zone.meters
        moving = [half for half in halves if half.room >= _STILL]
        if not moving:
            return Fitted(None, 0.0, "no tool centre point moves there, so a distance has no meaning; give percent")
        kept = min([wanted, *(half.room for half in moving)])
    why = "" if kept == wanted else "a zone takes at most half of a move"
    for _ in range(_TRIES):
        shares = _shares(halves, zone, kept)
        left, right = (share * (half.path.end - half.path.start) for share, half in zip(shares, halves, strict=True))
        corner = round_corner(before, after, left, right)
        problem = _problem(corner.piece, halves, shares, zone, kept, limits)
        if not problem:
            return Fitted(corner, kept, why)
        kept, why = kept * _SMALLER, problem
    return Fitted(None, 0.0, why)


class _Half:
    """The half of a path that is next to the corner: how far from the corner each tool centre point is, by share."""

    def __init__(self, path: PiecewisePolynomial, is_before: bool, positions: Sequence[Position]) -> None:
        self.path, self.is_before, self.positions = path, is_before, positions
        self.corner = [position(path.evaluate(self._at(0.0))) for position in positions]
        self.shares = np.linspace(0.0, MOST, _SAMPLES + 1)
        self.distances = np.array(
            [[self.distance(place, float(share)) for share in self.shares] for place in range(len(positions))]
        ).reshape(len(positions), len(self.shares))
        #: The largest radius that a tool centre point gets to; the largest of all counts, since the smallest zone does.
        self.room = float(self.distances.max(initial=0.0))

    def distance(self, place: int, share: float) -> float:
        """Return how far from the corner a tool centre point is, in m, at a share of the path from the corner."""
        there = self.positions[place](self.path.evaluate(self._at(share)))
        return float(np.linalg.norm(there - self.corner[place]))

    def share_of(self, radius: float) -> float:
        """Return at which share of the path, from the corner, the first tool centre point is `radius` away from it."""
        found = MOST
        for place, distances in enumerate(self.distances):
            far = np.flatnonzero(distances >= radius)
            if not len(far) or self.shares[far[0] - 1] >= found:
                continue
            near, beyond = float(self.shares[far[0] - 1]), float(self.shares[far[0]])
            for _ in range(40):
                middle = 0.5 * (near + beyond)
                near, beyond = (middle, beyond) if self.distance(place, middle) < radius else (near, middle)
            found = min(found, near)
        return found

    def _at(self, share: float) -> float:
        length = self.path.end - self.path.start
        return self.path.end - share * length if self.is_before else self.path.start + share * length


def _shares(halves: Sequence[_Half], zone: Zone, size: float) -> list[float]:
    """Return which share of each of the two paths a zone of this size takes."""
    if zone.percent > 0.0:
        return [size / 100.0] * 2
    shares = [half.share_of(size) if half.room >= _STILL else 0.0 for half in halves]
    # Where no tool centre point moves a distance says nothing: then as large a share as of the other path.
    return [share or max(shares) for share in shares]


def _problem(
    piece: PiecewisePolynomial,
    halves: Sequence[_Half],
    shares: Sequence[float],
    zone: Zone,
    size: float,
    limits: JointLimits,
) -> str:
    """Return why a corner does not do; nothing where it does."""
    excursion = piece.first_excursion(limits.lower, limits.upper, TOLERANCE)
    if excursion is not None:
        return f"a larger one would lead the joint {limits.names[excursion.component]!r} beyond its limits"
    way = piece.evaluate(np.linspace(piece.start, piece.end, _SAMPLES + 1))
    for place, position in enumerate(halves[0].positions):
        radius = size
        if zone.percent > 0.0:
            radius = _WIDE * max(
                float(half.distances[place][half.shares <= share + MOST / _SAMPLES].max())
                for half, share in zip(halves, shares, strict=True)
            )
        corner = halves[1].corner[place]
        farthest = max(float(np.linalg.norm(position(q) - corner)) for q in way)
        if farthest > radius * (1.0 + 1e-6) + _STILL:
            return "the tool centre point would leave a larger one on its way"
    return ""
