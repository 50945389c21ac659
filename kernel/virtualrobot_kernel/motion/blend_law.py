"""Jerk-limited law of a path with rounded corners: a constant rate through each corner, a double S between two.

A law for any path has to search for what is best where. Here it is known: a corner's piece is a smooth movement from
one velocity to another, so a constant rate suits it; moves between corners are straight, or nearly so.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.blend import Rounded
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.motion.rates import Rate, stretch_needed

#: Shares of the limits that a bent move itself may take: as on arcs (`arc`), and of the jerk for bending along the way.
_CURVATURE_ACCELERATION, _CURVATURE_JERK, _ACROSS_JERK, _ALONG_JERK = 0.8, 0.4, 0.6, 0.3
_LOOKS, _LOOKS_PER_PIECE = 33, 8
#: Factor of slowdown beyond the needed one, for what lies between the places that are looked at.
_MARGIN = 1.0002
#: How much finer a law is looked at whose limits don't hold by themselves between the places that are looked at.
_FINER = 5
#: Excess over a limit below which a stretch of the whole law settles it; of a law that begins at speed, none.
_NEARLY, _ROUNDS, _ROUNDING = 1.002, 20, 1e-6
_TINY = 1e-200
#: Relative difference of limits that comes from rounding.
_SAME = 1e-9
#: Share of a law's duration between its breaks and the places beside them that are looked at.
_BESIDE = 1e-9


@dataclass(slots=True)
class _Move:
    """Move between two corners: its length by s, and the limits (1/s, 1/s², 1/s³) of s' and its derivatives."""

    length: float
    velocity: float = math.inf
    acceleration: float = math.inf
    jerk: float = math.inf

    def slow_down(self, factor: float) -> None:
        """Scale the limits down to those of a law that is slower by a factor in time."""
        self.velocity /= factor
        self.acceleration /= factor**2
        self.jerk /= factor**3

    def is_like(self, other: _Move) -> bool:
        """Return whether another move has the same limits, but for rounding."""
        ours, theirs = astuple(self), astuple(other)
        return all(math.isclose(one, two, rel_tol=_SAME) for one, two in zip(ours, theirs, strict=True))


def law_through(whole: Rounded, rates: Sequence[Rate], entry: float = 0.0) -> PiecewisePolynomial:
    """Return the law s(tau) to rest with which all rates along the path keep their limits: cubic pieces.

    The rates in the corners, s' = k there, are the greatest with which the limits hold and the moves have room to get
    from one to the next; between them s' has the double S profile (Biagiotti, Melchiorri, Trajectory Planning for
    Automatic Machines and Robots (2008), section 3.4) for constant limits of s', s'' and s''' that include what the
    move's own bending takes. All is verified on a fine grid; a move or corner that exceeds a limit becomes slower.
    It begins with s' = `entry` and s'' = 0; raises KernelError where no such law from that speed is found.

    Two kinds of limits of the moves are tried, those that are kept whatever the move's rate is, and those of moves that
    don't bend, which have to become smaller where they do: the sooner law counts. Where no move bends they are equal.
    """
    passing = [_passing(whole.path, part, rates) for part in whole.corners]
    laws: list[PiecewisePolynomial] = []
    bent, straight = ([limits(whole.path, part, rates) for part in whole.moves] for limits in (_move, _straight_move))
    is_same = all(map(_Move.is_like, bent, straight))
    for moves, finer in ((bent, 1), (straight, _FINER)):
        if laws and is_same:
            continue
        try:
            laws.append(_law_with(whole, rates, moves, list(passing), entry, finer))
        except KernelError:
            if moves is straight and not laws:
                raise
    return min(laws, key=lambda law: law.end)


def _law_with(
    whole: Rounded, rates: Sequence[Rate], moves: Sequence[_Move], passing: list[float], entry: float, finer: int
) -> PiecewisePolynomial:
    """Return the law of moves and corners with limits, which become smaller until all is kept.

    finer: how much finer than usual the grid is on which that is looked at in the end.
    """
    for _ in range(_ROUNDS):
        reached = _reachable(passing, moves, entry)
        law, ends = _law(whole, moves, [entry, *reached, 0.0])
        needed = _needed(law, ends, rates, len(whole.path.coefficients))
        if needed.max() <= (1.0 + _ROUNDING if entry else _NEARLY):
            break
        for place, factor in enumerate(needed.tolist()):
            if factor <= 1.0:
                continue
            if place % 2:
                passing[place // 2] = reached[place // 2] / (factor * _MARGIN)
            else:
                moves[place // 2].slow_down(factor * _MARGIN)
    if finer > 1:
        needed = _needed(law, ends, rates, len(whole.path.coefficients), finer)
    if entry:
        if needed.max() > 1.0 + _ROUNDING:
            raise KernelError("no law that begins at this speed keeps the limits along the path")
        return law
    return law.stretched(law.end * max(1.0, float(needed.max())) * _MARGIN)


def _looks(path: PiecewisePolynomial, part: tuple[float, float]) -> Array:
    """Return the places of a part of a path that are looked at: both sides of its pieces' borders included."""
    begin, end = part
    inside = path.breaks[(path.breaks > begin) & (path.breaks < end)]
    even = np.linspace(begin, end, max(_LOOKS, _LOOKS_PER_PIECE * (len(inside) + 1)))
    looks = np.concatenate([even, inside, np.nextafter(inside, -np.inf)])
    return np.clip(looks, np.nextafter(begin, np.inf), np.nextafter(end, -np.inf))


def _there(rates: Sequence[Rate], part: tuple[float, float]) -> list[Rate]:
    middle = 0.5 * (part[0] + part[1])
    return [rate for rate in rates if rate.begin <= middle <= rate.end]


def _vectors(rate: Rate, looks: Array) -> Array:
    """Return f and its first two derivatives by s, (3, m, quantities, components)."""
    return rate.polynomial.states(looks, 2).reshape(3, len(looks), -1, rate.size)


def _passing(path: PiecewisePolynomial, part: tuple[float, float], rates: Sequence[Rate]) -> float:
    """Return the greatest constant s' on a part of a path: velocity f s', acceleration f' s'^2, jerk f'' s'^3."""
    looks = _looks(path, part)
    slowest = _TINY
    for rate in _there(rates, part):
        lengths = np.linalg.norm(_vectors(rate, looks), axis=3)
        shares = (lengths / rate.limits[:, None, :]).max(axis=(1, 2))
        slowest = max(slowest, float((shares ** (1.0, 1.0 / 2.0, 1.0 / 3.0)).max()))
    return 1.0 / (slowest * _MARGIN)


@np.errstate(over="ignore")  # limits beyond all numbers count as none
def _move(path: PiecewisePolynomial, part: tuple[float, float], rates: Sequence[Rate]) -> _Move:
    """Return constant limits of s', s'' and s''' on a part of a path with which the limits of all rates hold.

    With f' = p + n along and across f the acceleration is f s'' + f' s'^2 and the jerk f s''' + 3 f' s' s'' + f'' s'^3,
    where the last term counts as if it were along f.
    """
    move = _Move(part[1] - part[0])
    if move.length <= 0.0:
        return move
    looks = _looks(path, part)
    found = []
    for rate in _there(rates, part):
        f, f1, f2 = _vectors(rate, looks)
        size, bend, twist = (np.maximum(np.linalg.norm(vector, axis=2), _TINY) for vector in (f, f1, f2))
        along = np.abs((f * f1).sum(axis=2)) / size
        across = np.sqrt(np.maximum(bend**2 - along**2, 0.0))
        found.append((size, np.maximum(along, _TINY), np.maximum(across, _TINY), bend, twist, rate.limits))
    move.velocity = min(
        float(
            np.minimum(
                np.minimum(v / size, np.sqrt(_CURVATURE_ACCELERATION * a / bend)), np.cbrt(_CURVATURE_JERK * j / twist)
            ).min()
        )
        for size, _, _, bend, twist, (v, a, j) in found
    )
    v1 = move.velocity
    for size, along, across, _, _, (_, a, j) in found:
        room = np.sqrt(np.maximum(a**2 - (across * v1**2) ** 2, 0.0)) - along * v1**2
        least = np.minimum(room / size, np.minimum(_ACROSS_JERK / across, _ALONG_JERK / along) * j / (3.0 * v1))
        move.acceleration = min(move.acceleration, float(least.min()))
    a1 = move.acceleration
    for size, along, across, _, twist, (_, _, j) in found:
        room = np.sqrt(np.maximum(j**2 - (3.0 * across * v1 * a1) ** 2, 0.0)) - 3.0 * along * v1 * a1 - twist * v1**3
        move.jerk = min(move.jerk, float((room / size).min()))
    move.slow_down(_MARGIN)
    return move


@np.errstate(over="ignore")
def _straight_move(path: PiecewisePolynomial, part: tuple[float, float], rates: Sequence[Rate]) -> _Move:
    """Return constant limits of s' and its derivatives on a part of a path with which all hold where nothing bends."""
    move = _Move(part[1] - part[0])
    if move.length <= 0.0:
        return move
    looks = _looks(path, part)
    for rate in _there(rates, part):
        size = np.maximum(np.linalg.norm(_vectors(rate, looks)[0], axis=2), _TINY)
        velocity, acceleration, jerk = (float((limit / size).min()) for limit in rate.limits)
        move.velocity = min(move.velocity, velocity)
        move.acceleration = min(move.acceleration, acceleration)
        move.jerk = min(move.jerk, jerk)
    move.slow_down(_MARGIN)
    return move


def _change(v0: float, v1: float, move: _Move) -> tuple[float, float, float]:
    """Return how long s' takes from v0 to v1, with s'' = 0 at both ends, how far s gets, and the time of each ramp."""
    change = abs(v1 - v0)
    if change * move.jerk < move.acceleration * move.acceleration:  # a power of large numbers would raise
        ramp = math.sqrt(change / move.jerk)
        seconds = 2.0 * ramp
    else:
        ramp = move.acceleration / move.jerk
        seconds = change / move.acceleration + ramp
    return seconds, 0.5 * (v0 + v1) * seconds, ramp


def _reachable(passing: Sequence[float], moves: Sequence[_Move], entry: float) -> list[float]:
    """Return the rates in the corners, none above `passing`, that can be reached from one another on the moves."""
    reached = [entry, *passing, 0.0]
    for place, move in enumerate(moves):
        reached[place + 1] = min(reached[place + 1], move.velocity)
        reached[place] = min(reached[place], move.velocity) if place else entry
    for place, move in enumerate(moves):
        reached[place + 1] = _slower(reached[place], reached[place + 1], move)
    for place, move in reversed(list(enumerate(moves))):
        reached[place] = _slower(reached[place + 1], reached[place], move)
    if reached[0] < entry:
        raise KernelError("there is no room to slow down from this speed")
    return reached[1:-1]


def _slower(low: float, high: float, move: _Move) -> float:
    """Return the greatest rate, at most `high`, that a move has room to get to from `low`."""
    if high <= low or _change(low, high, move)[1] <= move.length:
        return high
    return _greatest(low, high, lambda rate: _change(low, rate, move)[1] <= move.length) if move.length > 0.0 else low


def _greatest(low: float, high: float, fits) -> float:  # noqa: ANN001  a predicate of a rate
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low


def _law(whole: Rounded, moves: Sequence[_Move], rates: Sequence[float]) -> tuple[PiecewisePolynomial, list[float]]:
    """Return the law with these rates at the ends of the moves, and when each move and corner ends, in their order."""
    pieces: list[list[float]] = []
    breaks, ends = [0.0], []
    s = whole.path.start

    def add(seconds: float, speed: float, slope: float, jerk: float) -> None:
        nonlocal s
        if seconds > 1e-12:
            pieces.append([s, speed, slope / 2.0, jerk / 6.0])
            s += seconds * (speed + seconds * (slope / 2.0 + seconds * jerk / 6.0))
            breaks.append(breaks[-1] + seconds)

    def change(v0: float, v1: float, move: _Move) -> None:
        seconds, _, ramp = _change(v0, v1, move)
        jerk = math.copysign(move.jerk, v1 - v0)
        if ramp > 0.0:
            jerk = (v1 - v0) / (ramp * (seconds - ramp))  # to the last bit
            add(ramp, v0, 0.0, jerk)
            add(seconds - 2.0 * ramp, v0 + 0.5 * jerk * ramp**2, jerk * ramp, 0.0)
            add(ramp, v1 - 0.5 * jerk * ramp**2, jerk * ramp, -jerk)

    for place, (move, (begin, end)) in enumerate(zip(moves, whole.moves, strict=True)):
        v0, v1 = rates[place : place + 2]
        if move.length > 0.0:
            s = begin

            def fits(top: float, v0: float = v0, v1: float = v1, move: _Move = move) -> bool:
                return _change(v0, top, move)[1] + _change(top, v1, move)[1] <= move.length

            top = move.velocity if fits(move.velocity) else _greatest(max(v0, v1), move.velocity, fits)
            change(v0, top, move)
            add((move.length - _change(v0, top, move)[1] - _change(top, v1, move)[1]) / top, top, 0.0, 0.0)
            change(top, v1, move)
        ends.append(breaks[-1])
        if place < len(whole.corners):
            s, length = end, whole.corners[place][1] - whole.corners[place][0]
            add(length / v1, v1, 0.0, 0.0)
            ends.append(breaks[-1])
    return PiecewisePolynomial(np.array(breaks), np.array(pieces)[:, :, None]), ends


def _needed(
    law: PiecewisePolynomial, ends: Sequence[float], rates: Sequence[Rate], pieces: int, finer: int = 1
) -> Array:
    """Return by what factor each move and corner has to be slower in time."""
    points = finer * max(2000, 8 * len(law.coefficients), 16 * pieces) + finer - 1
    breaks = law.breaks
    # The law's breaks are the path's borders: nearer to them, rounding would put it on the other side of one.
    beside = _BESIDE * law.end
    taus = np.concatenate([np.linspace(0.0, law.end, points), breaks - beside, breaks + beside]).clip(0.0, law.end)
    taus.sort()
    needed = stretch_needed(rates, law, taus).max(axis=0)
    section = np.minimum(np.searchsorted(ends, taus, side="right"), len(ends) - 1)
    result = np.zeros(len(ends))
    np.maximum.at(result, section, needed)
    return result
