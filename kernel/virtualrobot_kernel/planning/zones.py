"""Size of a zone about a corner: the room that the moves leave for it, by the ways of the tool centre points."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.superposed import LEAST_RAMP, Fade, Led, fade_within
from virtualrobot_kernel.planning.program import Zone

MOST = 0.5
"""Share of a move that one of its two zones may take, as on robot controllers."""

_SAMPLES = 32
"""Number of places in which a half move is checked."""

_STILL = 1e-6
"""Distance (m) below which a tool centre point does not count as moving."""

_WIDE = 1.1
"""Factor by which a zone in percent may lead a tool centre point farther from its corner than the programmed way."""

Floats = NDArray[np.float64]
Position = Callable[[Floats], Floats]
"""Position (3,) of a robot's tool centre point, in m in its base's frame, at joints (n,) of a path."""


@dataclass(frozen=True, slots=True, eq=False)
class Room:
    """Room of two moves for a zone about the corner between them.

    kept: the zone's size in the unit that was asked for, 0 where there is none; `why` it is smaller than wanted.
    shares: how much of the first path before the corner and of the second one behind it the zone takes. corners, radii:
    where each tool centre point is at the corner, and how far from there it may be. fades: of a parabola, for positions
    and for all else, in m; leds: the tool centre points that make it; made: its way, once it is looked for, or None.
    """

    kept: float
    why: str
    shares: tuple[float, float]
    positions: tuple[Position, ...]
    corners: tuple[Floats, ...]
    radii: tuple[float, ...]
    fades: tuple[Fade, Fade] | None = None
    leds: tuple[Led, ...] = ()
    made: list[PiecewisePolynomial | None] = field(default_factory=list)

    def holds(self, joints: Floats) -> bool:
        """Return True if every tool centre point is in its part of the zone, with joints (m, n)."""
        return all(
            max(_length(position(q) - corner) for q in joints) <= radius * (1.0 + 1e-9)
            for position, corner, radius in zip(self.positions, self.corners, self.radii, strict=True)
        )


def room_for(
    zone: Zone, before: PiecewisePolynomial, after: PiecewisePolynomial, positions: Sequence[Position]
) -> Room:
    """Return the room of two paths that meet at a corner.

    A distance is the radius of a sphere about the corner: the zone begins where the first tool centre point comes into
    its own sphere for good, and ends where the first one leaves its own. A percentage is of each path's parameter; in
    it no tool centre point may be farther from the corner than on the programmed way, by a tenth. No zone takes more
    than half of a path. A parabola begins a little sooner than its radius says, where there is room.
    """
    halves = (_Half(before, True, positions), _Half(after, False, positions))
    corners = tuple(halves[1].corner)
    if zone.percent > 0.0:
        share = min(zone.percent / 100.0, MOST)
        radii = tuple(_WIDE * max(half.farthest(place, share) for half in halves) for place in range(len(positions)))
        return Room(100.0 * share, "", (share, share), tuple(positions), corners, radii)
    moving = [half for half in halves if half.room >= _STILL]
    if not moving:
        why = "no tool centre point moves there, so a distance has no meaning; give percent"
        return Room(0.0, why, (0.0, 0.0), (), (), ())
    room = min(half.room for half in moving)
    kept, fades = min(zone.meters, room), None
    if zone.parabola:
        place = fade_within(zone.meters, room)
        fades = (place, fade_within(max(zone.extended, zone.meters), room))
        told = min(zone.meters, room / (1.0 + 0.5 * LEAST_RAMP))
        kept = max(fade.reach for fade in fades)
    shares = [half.share_of(kept) if half in moving else 0.0 for half in halves]
    # Where no tool centre point moves a distance says nothing: then as large a share as of the other path.
    first, second = (share or max(shares) for share in shares)
    far = _WIDE * kept if fades else kept
    kept = told if fades else kept
    why = "" if kept == zone.meters else "a zone takes at most half of a move"
    return Room(kept, why, (first, second), tuple(positions), corners, (far,) * len(positions), fades)


def _length(way: Floats) -> float:
    """Return the length of a vector (3,), in a tenth of the time that NumPy's norm takes."""
    return math.sqrt(way.dot(way))


class _Half:
    """Half of a path next to the corner: distances of the tool centre points from the corner, by share."""

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
        """Return the distance of a tool centre point from the corner, in m, at a share of the path from the corner."""
        there = self.positions[place](self.path.evaluate(self._at(share)))
        return _length(there - self.corner[place])

    def farthest(self, place: int, share: float) -> float:
        """Return the greatest distance of a tool centre point from the corner, in m, up to a share of the path."""
        return max(self.distance(place, share), float(self.distances[place][self.shares <= share].max()))

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
        start, end = self.path.start, self.path.end
        return end - share * (end - start) if self.is_before else start + share * (end - start)
