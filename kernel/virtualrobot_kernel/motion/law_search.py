"""Fast jerk-limited law along a path whose limits vary: a bang-bang law, smoothed by a moving average in time.

1. On cells of the path the limits of velocity give a ceiling of s', those of acceleration and jerk a bound of s'' that
   depends on s'; a forward and a backward pass over s'^2 (Bobrow, Dubowsky, Gibson 1985; Pham, Pham, A New Approach to
   Time-Optimal Path Parameterization Based on Reachability Analysis, 2018) give the fastest s(t) with piecewise
   constant s''.
2. The moving average of s(t) over T seconds is a piecewise cubic whose third derivative is the change of s'' within T,
   divided by T (Biagiotti, Melchiorri, FIR filters for online trajectory planning with time- and frequency-domain
   specifications, 2012). So s'' may be J T; and so that s'' doesn't change its sign within T, tops and
   valleys of s' are made to last T: tops are cut off, valleys of the ceiling widened.
3. Where the law exceeds the limits of the jerk or does not use them, it is given less or more, and searched again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial, merged
from virtualrobot_kernel.motion.rates import Rate

#: Cells of a path: at least, and on each piece at least.
_CELLS, _CELLS_PER_PIECE = 200, 6
#: Shares of acceleration and jerk that the path's own curvature may take at the ceiling.
_CURVATURE_ACCELERATION, _CURVATURE_JERK = 0.9, 0.6
_PASSES = 3
#: By how much less or more of the jerk is spent at once.
_CHANGE = (0.5, 2.0)
_TINY = 1e-200
#: A place where everything is by this slower than where it is fastest stands still.
STILL = 1e-6


@dataclass(frozen=True, eq=False)
class Cells:
    """Limits of s', s'' and s''' on N cells of a path between N + 1 `nodes`: at 3 points of each, for R quantities.

    In units of the limits, (N, 3, R): speed |f| / V; square, product, bend: |f|², f·f', |f'|² by A²; jerk: |f|, 3 |f'|
    and |f''| by J.
    """

    nodes: Array
    speed: Array
    square: Array
    product: Array
    bend: Array
    jerk: tuple[Array, Array, Array]

    @property
    def count(self) -> int:
        """Number N of cells."""
        return len(self.nodes) - 1


def nodes_of(rates: Sequence[Rate]) -> Array:
    """Return the nodes (N + 1,) of the path of the first rate: its breaks, where ranges end, and points between."""
    edges = merged([rates[0].polynomial.breaks, *([rate.begin, rate.end] for rate in rates)])
    each = max(_CELLS_PER_PIECE, -(-_CELLS // (len(edges) - 1)))
    steps = np.arange(each) / each
    return np.append((edges[:-1, None] + np.diff(edges)[:, None] * steps).ravel(), edges[-1])


def cells_of(rates: Sequence[Rate]) -> Cells:
    """Return the cells for the rates, the first of which covers the whole path."""
    nodes = nodes_of(rates)
    inside = np.nextafter(nodes[1:], nodes[:-1])
    points = np.stack([nodes[:-1], 0.5 * (nodes[:-1] + nodes[1:]), inside], axis=1)
    columns: list[list[Array]] = []
    for rate in rates:
        active = (points[:, 1] >= rate.begin) & (points[:, 1] <= rate.end)
        f, f1, f2 = rate.polynomial.states(points[active].ravel(), 2).reshape(3, int(active.sum()), 3, -1, rate.size)
        velocity, acceleration, jerk = rate.limits
        lengths = [np.linalg.norm(vector, axis=3) for vector in (f, f1, f2)]
        values = [
            lengths[0] / velocity,
            (lengths[0] / acceleration) ** 2,
            (f * f1).sum(axis=3) / acceleration**2,
            (lengths[1] / acceleration) ** 2,
            lengths[0] / jerk,
            3.0 * lengths[1] / jerk,
            lengths[2] / jerk,
        ]
        whole = np.zeros((len(values), len(nodes) - 1, 3, len(velocity)))
        whole[:, active] = values
        columns.append(list(whole))
    speed, square, product, bend, j1, j2, j3 = (np.concatenate(parts, axis=2) for parts in zip(*columns, strict=True))
    return Cells(nodes, speed, square, product, bend, (j1, j2, j3))


def search(cells: Cells, window: float, budget: Array) -> PiecewisePolynomial | None:
    """Return the law s(t) with the moving average over `window` seconds; None when it is too long for this path.

    budget (N,): by what the share of the jerk that is left for changing s'' is multiplied on each cell.
    """
    length = np.diff(cells.nodes)
    ceiling = _ceiling(cells)
    widened = _at_nodes(_spread_min(ceiling, cells.nodes, np.sqrt(ceiling) * (0.5 * window)))
    widened[[0, -1]] = 0.0
    x = widened
    for _ in range(_PASSES):
        forward, backward = _accelerations(cells, np.maximum(x[:-1], x[1:]), window, budget)
        x = _two_passes(widened, forward, backward, length)
    speeds = np.sqrt(x)
    speeds = _cut(speeds, _times(speeds, length), window)
    return moving_average(cells.nodes, speeds, window) if speeds[1:-1].min() > 0.0 else None


def longest_window(cells: Cells) -> float:
    """Return the time (s) in which most cells change s'' from 0 to its bound, at most a third of the whole motion."""
    reaching = cells.jerk[0].max(axis=(1, 2)) / np.sqrt(np.maximum(cells.square.max(axis=(1, 2)), _TINY))
    length = np.diff(cells.nodes)
    ceiling = _at_nodes(_ceiling(cells))
    ceiling[[0, -1]] = 0.0
    still = np.zeros(cells.count)
    forward, backward = _accelerations(cells, still, np.inf, np.ones(cells.count))
    seconds = _times(np.sqrt(_two_passes(ceiling, forward, backward, length)), length)[-1]
    return min(float(np.median(reaching)), float(seconds) / 3.0)


def spend(cells: Cells, budget: Array, law: PiecewisePolynomial, taus: Array, needed: Array, window: float) -> Array:
    """Return the budget (N,) changed by what the jerk needs: less where it exceeds its limit, more where it doesn't.

    taus (m,): nominal times of the law, increasing; needed (m,): the cube root of the share of the jerk's limit there.
    """
    around = 0.75 * window
    first = np.searchsorted(taus, taus - around)
    last = np.searchsorted(taus, taus + around, side="right") - 1
    greatest = -_range_min(-needed, first, last)
    at = np.searchsorted(cells.nodes, law.states(taus, 0)[0, :, 0], side="right") - 1
    share = np.zeros(cells.count)
    np.maximum.at(share, np.clip(at, 0, cells.count - 1), greatest)
    share[share == 0.0] = 1.0
    return budget / np.clip(np.where(share > 1.0, share**3.0, share**1.5), *_CHANGE)


def _ceiling(cells: Cells) -> Array:
    """Return the greatest s'^2 (N,) that velocity and curvature allow."""
    speed = cells.speed.max(axis=(1, 2))
    # Where nothing moves there is no limit but this one.
    velocity = 1.0 / np.maximum(speed, STILL * speed.max()) ** 2
    acceleration = _CURVATURE_ACCELERATION / np.sqrt(np.maximum(cells.bend.max(axis=(1, 2)), _TINY))
    jerk = (_CURVATURE_JERK / np.maximum(cells.jerk[2].max(axis=(1, 2)), _TINY)) ** (2.0 / 3.0)
    return np.minimum(np.minimum(velocity, acceleration), jerk)


def _accelerations(cells: Cells, level: Array, window: float, budget: Array) -> tuple[Array, Array]:
    """Return the greatest s'' and -s'' (N,) at s'^2 = `level` (N,), for |f s'' + f' s'^2| <= A and for the jerk.

    Where s'' changes within the window the jerk is at most |f| s'' / T + 3 |f'| s' s'' + |f''| s'^3.
    """
    x = level[:, None, None]
    lean = cells.product * x
    square = np.maximum(cells.square, _TINY)
    root = np.sqrt(np.maximum(lean**2 + square * (1.0 - cells.bend * x**2), 0.0))
    v = np.sqrt(x)
    j1, j2, j3 = cells.jerk
    smooth = ((1.0 - j3 * (v * x)) / np.maximum(j1 / window + j2 * v, _TINY)).min(axis=(1, 2))
    smooth = np.maximum(smooth, 0.0) * budget
    forward, backward = ((root - sign * lean) / square for sign in (1.0, -1.0))
    return np.minimum(forward.min(axis=(1, 2)), smooth), np.minimum(backward.min(axis=(1, 2)), smooth)


def _two_passes(ceiling: Array, forward: Array, backward: Array, length: Array) -> Array:
    """Return the greatest s'^2 at the nodes (N + 1,) below `ceiling` with s'' in [-backward, forward] on each cell."""
    x = ceiling.tolist()
    for i, rise in enumerate((2.0 * forward * length).tolist()):
        reached = x[i] + rise
        if reached < x[i + 1]:
            x[i + 1] = reached
    falls = (2.0 * backward * length).tolist()
    for i in range(len(falls) - 1, -1, -1):
        reached = x[i + 1] + falls[i]
        if reached < x[i]:
            x[i] = reached
    return np.array(x)


def _times(speeds: Array, length: Array) -> Array:
    """Return when each node is passed (N + 1,), with a speed that is linear in time on each cell."""
    return np.concatenate([[0.0], np.cumsum(2.0 * length / np.maximum(speeds[:-1] + speeds[1:], _TINY))])


def _cut(speeds: Array, times: Array, window: float) -> Array:
    """Return the speeds at the nodes with tops that last `window`: a morphological opening in time."""
    half = 0.5 * window
    # Exact at the nodes and half a window beside them; between nodes the speed is linear in time.
    sides = [_least(speeds, times, times + shift, half) for shift in (-half, 0.0, half)]
    first, last = np.searchsorted(times, times - half), np.searchsorted(times, times + half, side="right") - 1
    return np.maximum(np.maximum(sides[0], sides[2]), -_range_min(-sides[1], first, last))


def _least(speeds: Array, times: Array, centers: Array, half: float) -> Array:
    """Return the least speed within `half` seconds of each moment of `centers`."""
    first = np.searchsorted(times, centers - half)
    last = np.searchsorted(times, centers + half, side="right") - 1
    ends = np.minimum(np.interp(centers - half, times, speeds), np.interp(centers + half, times, speeds))
    some = last >= first
    ends[some] = np.minimum(ends[some], _range_min(speeds, first[some], last[some]))
    return ends


def _at_nodes(values: Array) -> Array:
    """Return the lesser of the values of the two cells beside each node."""
    return np.minimum(np.append(values, np.inf), np.append(np.inf, values))


def _spread_min(values: Array, nodes: Array, reach: Array) -> Array:
    """Return the least value of the cells within `reach` (N,) of each."""
    first = np.clip(np.searchsorted(nodes, nodes[:-1] - reach, side="right") - 1, 0, len(values) - 1)
    last = np.clip(np.searchsorted(nodes, nodes[1:] + reach, side="left") - 1, 0, len(values) - 1)
    return _range_min(values, first, last)


def _range_min(values: Array, first: NDArray[np.intp], last: NDArray[np.intp]) -> Array:
    """Return the least of values[first[i] : last[i] + 1] for each i, by a table of powers of two."""
    tables = [values]
    while 2 ** len(tables) <= len(values):
        half = 2 ** (len(tables) - 1)
        tables.append(np.minimum(tables[-1][:-half], tables[-1][half:]))
    widths = last - first + 1
    level = np.frexp(widths)[1] - 1
    found = np.empty(len(widths))
    for k, table in enumerate(tables):
        at = level == k
        found[at] = np.minimum(table[first[at]], table[last[at] + 1 - 2**k])
    return found


def moving_average(nodes: Array, speeds: Array, window: float) -> PiecewisePolynomial:
    """Return the moving average over `window` seconds of the law that passes `nodes` with `speeds`, (N + 1,) each.

    It begins and ends at rest half a window before and after that law. Its derivatives are differences of the law's
    own: S' = (s(t + T/2) - s(t - T/2)) / T, and so on.
    """
    length = np.diff(nodes)
    times = _times(speeds, length)
    slopes = np.diff(speeds) / np.diff(times)
    keep = np.concatenate([[True], np.abs(np.diff(slopes)) > 1e-9 * np.abs(slopes).max(), [True]])
    begin = np.flatnonzero(keep)[:-1]
    pieces = np.stack([nodes[begin], speeds[begin], 0.5 * slopes[begin]], axis=1)
    law = PiecewisePolynomial(times[keep], pieces[:, :, None])
    breaks = np.unique(np.concatenate([times[keep], times[keep] + window]))
    breaks = breaks[np.append(True, np.diff(breaks) > 1e-9 * breaks[-1])]
    breaks[-1] = times[-1] + window
    moments = 0.5 * (breaks[:-1] + breaks[1:])
    jerks = (law.states(moments, 2)[2] - law.states(moments - window, 2)[2])[:, 0] / window
    return integrated(nodes[0], np.diff(breaks), jerks, nodes[-1])


def integrated(start: float, seconds: Array, jerks: Array, goal: float) -> PiecewisePolynomial:
    """Return the cubic pieces from rest at `start` with jerks (K,) for `seconds` (K,) to rest, scaled to end at `goal`.

    What the jerks lack of that, by the rounding of their seconds, is made up by the least change of them.
    """
    breaks = np.concatenate([[0.0], np.cumsum(seconds)])
    left = breaks[-1] - breaks[1:]
    to_rest = np.stack([seconds, seconds * (left + 0.5 * seconds)])  # times jerks: s'' and s' at the end
    jerks = jerks - np.linalg.lstsq(to_rest, to_rest @ jerks)[0]
    slope = np.concatenate([[0.0], np.cumsum(jerks * seconds)])[:-1]
    speed = np.concatenate([[0.0], np.cumsum(seconds * (slope + 0.5 * seconds * jerks))])[:-1]
    steps = seconds * (speed + seconds * (0.5 * slope + seconds * jerks / 6.0))
    way = np.concatenate([[0.0], np.cumsum(steps)])
    scale = (goal - start) / way[-1]
    pieces = np.stack([start + scale * way[:-1], scale * speed, scale * slope / 2.0, scale * jerks / 6.0], axis=1)
    return PiecewisePolynomial(breaks, pieces[:, :, None])
