"""Size of a zone about a corner: the room that the moves leave for it, by the ways of the tool centre points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.superposed import LEAST_RAMP, Fade, Led, fade_within
from virtualrobot_kernel.planning.program import Zone

MOST = 0.5
"""Share of a move that one of its two zones may take, as on robot controllers."""

_SAMPLES, _FINER = 32, 8
"""Number of places in which a half move is checked, and how often what lies between two of them is so again."""

_STILL = 1e-6
"""Distance (m) below which a tool centre point does not count as moving."""

_WIDE = 1.1
"""Factor by which a zone in percent may lead a tool centre point farther from its corner than the programmed way."""

Floats = NDArray[np.float64]
Position = Callable[[Floats], Floats]
"""Positions (m, 3) of a robot's tool centre point, in m in its base's frame, at joints (m, n) of a path."""


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
            _lengths(position(joints) - corner).max() <= radius * (1.0 + 1e-9)
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


def _lengths(ways: Floats) -> Floats:
    """Return the lengths of vectors (m, 3)."""
    return np.sqrt(np.einsum("ij,ij->i", ways, ways))


class _Half:
    """Half of a path next to the corner: distances of the tool centre points from the corner, by share."""

    def __init__(self, path: PiecewisePolynomial, is_before: bool, positions: Sequence[Position]) -> None:
        self.path, self.is_before, self.positions = path, is_before, positions
        self.shares = np.linspace(0.0, MOST, _SAMPLES + 1)
        joints = self._joints(self.shares)
        ways = [position(joints) for position in positions]
        self.corner = [way[0] for way in ways]
        self.distances = np.array([_lengths(way - way[0]) for way in ways]).reshape(len(ways), len(self.shares))
        #: The largest radius that a tool centre point gets to; the largest of all counts, since the smallest zone does.
        self.room = float(self.distances.max(initial=0.0))

    def _distances(self, place: int, shares: Floats) -> Floats:
        """Return the distances (m,) of a tool centre point from the corner, in m, at shares of the path from there."""
        return _lengths(self.positions[place](self._joints(shares)) - self.corner[place])

    def farthest(self, place: int, share: float) -> float:
        """Return the greatest distance of a tool centre point from the corner, in m, up to a share of the path."""
        sampled = self.distances[place][self.shares <= share]
        return float(max(self._distances(place, np.array([share]))[0], sampled.max()))

    def share_of(self, radius: float) -> float:
        """Return at which share of the path, from the corner, the first tool centre point is `radius` away from it."""
        found = MOST
        for place, distances in enumerate(self.distances):
            far = np.flatnonzero(distances >= radius)
            if not len(far) or self.shares[far[0] - 1] >= found:
                continue
            near, beyond = self.shares[far[0] - 1 : far[0] + 1].tolist()
            for _ in range(_FINER):
                finer = np.linspace(near, beyond, _SAMPLES + 1)
                first = max(1, int(np.argmax(self._distances(place, finer) >= radius)))
                near, beyond = finer[first - 1 : first + 1].tolist()
            found = min(found, near)
        return found

    def _joints(self, shares: Floats) -> Floats:
        """Return the joints (m, n) at shares (m,) of the path from the corner."""
        ways = shares * (self.path.end - self.path.start)
        return self.path.evaluate(self.path.end - ways if self.is_before else self.path.start + ways)
