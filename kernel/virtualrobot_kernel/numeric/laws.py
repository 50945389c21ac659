"""Jerk-limited laws along paths whose limits vary: bang-bang laws, smoothed by a moving average in time; compiled.

1. On cells of the path the limits of velocity give a ceiling of s', those of acceleration and jerk a bound of s'' that
   depends on s'; a forward and a backward pass over s'^2 (Bobrow, Dubowsky, Gibson 1985; Pham, Pham, A New Approach to
   Time-Optimal Path Parameterization Based on Reachability Analysis, 2018) give the fastest s(t) with piecewise
   constant s''.
2. The moving average of s(t) over T seconds is a piecewise cubic whose third derivative is the change of s'' within T,
   divided by T (Biagiotti, Melchiorri, FIR filters for online trajectory planning with time- and frequency-domain
   specifications, 2012). So s'' may be J T; and so that s'' doesn't change its sign within T, tops and
   valleys of s' are made to last T: tops are cut off, valleys of the ceiling widened.
3. Where the law exceeds the limits of the jerk or does not use them, it is given less or more, and searched again.

Rates f(s) (`motion/rates.py`) are tables: shapes (r, 5), breaks and terms of r rates as `one_of` takes them, sizes (r,)
the number of components of each rate's quantities, limits (3, q) the greatest velocity, acceleration and jerk of all
quantities. A law is its breaks (p + 1,) and terms (p, t, 1). Cells are (8, n, m), in units of the limits for each of m
quantities and places: |f| / V; a = A / |f|, b = f·f' / |f|² and c = a² |f'|² / A² - b², which is 0 for one component;
|f|, 3 |f'|, |f''| by J; |f'|² / A².
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import float64, int64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of

from virtualrobot_kernel.numeric.polynomials import jerk_state, one_of, piece_near, write_derivatives

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]

STILL = 1e-6
"""A place where everything is by this slower than where it is fastest stands still."""

# Shares of acceleration and jerk that the path's own curvature may take at the ceiling.
_CURVATURE_ACCELERATION, _CURVATURE_JERK = 0.9, 0.6
_PASSES = 3
# By how much less or more of the jerk is spent at once.
_LEAST_CHANGE, _MOST_CHANGE = 0.5, 2.0
# The windows that are tried: each this much shorter than the one before, so many at most, and how often each of the
# best is tried with another budget.
_SHORTER, _WINDOWS, _BUDGETS = 0.7, 8, 3
# Moments at which laws are looked at, and by how much slower than by its fine grid a law is.
_COARSE, _FINE, _MARGIN = 500, 5000, 1.0002
# Peaks that are looked at more closely: those above this share of the greatest value, and above their neighbours by
# more than rounding; and the number of moments.
_PEAK, _SAME, _CLOSE = 0.97, 1e-7, 33
_SMALL, _TINY = 1e-100, 1e-200


class _Rates(NamedTuple):
    """Rates of quantities, see above."""

    shapes: Integers
    breaks: Floats
    terms: Floats
    sizes: Integers
    limits: Floats


_TABLE = (array_of(int64, 2), array_of(float64, 1), array_of(float64, 1), array_of(int64, 1), array_of(float64, 2))


@inlined
def _by_time(f: Floats, c: int, s1: float, s2: float, s3: float) -> tuple[float, float, float]:
    """Return velocity, acceleration and jerk of a component with the rates (3, k) f, f', f'' under a law."""
    return f[0, c] * s1, f[0, c] * s2 + f[1, c] * s1 * s1, f[0, c] * s3 + 3.0 * f[1, c] * s1 * s2 + f[2, c] * s1**3


@inlined
def _write_needed(rates: _Rates, law_breaks: Floats, law: Floats, taus: Floats, needed: Floats) -> float:
    """Write what `stretch_needed` does; return the greatest of it."""
    needed[:] = 0.0
    first = 0
    for rate in range(rates.sizes.shape[0]):
        breaks, terms = one_of(rates.breaks, rates.terms, rates.shapes[rate])
        size = rates.sizes[rate]
        begin, end = breaks[0], breaks[breaks.shape[0] - 1]
        f, shares = np.empty((3, terms.shape[2])), np.empty((3, terms.shape[2] // size))
        for quantity in range(shares.shape[1]):
            for row in range(3):
                shares[row, quantity] = 1.0 / rates.limits[row, first + quantity]
        first += shares.shape[1]
        at, piece = 0, 0
        for i in range(taus.shape[0]):
            at = piece_near(law_breaks, taus[i], at)
            s, s1, s2, s3 = jerk_state(law_breaks, law, taus[i], at)
            if s < begin or s > end:
                continue
            piece = piece_near(breaks, s, piece)
            write_derivatives(terms, piece, s - breaks[piece], f)
            for quantity in range(shares.shape[1]):
                if size == 1:
                    velocity, acceleration, jerk = _by_time(f, quantity, s1, s2, s3)
                else:
                    velocity, acceleration, jerk = 0.0, 0.0, 0.0
                    for c in range(quantity * size, (quantity + 1) * size):
                        x1, x2, x3 = _by_time(f, c, s1, s2, s3)
                        velocity, acceleration, jerk = velocity + x1 * x1, acceleration + x2 * x2, jerk + x3 * x3
                    velocity, acceleration, jerk = math.sqrt(velocity), math.sqrt(acceleration), math.sqrt(jerk)
                needed[0, i] = max(needed[0, i], abs(velocity) * shares[0, quantity])
                needed[1, i] = max(needed[1, i], abs(acceleration) * shares[1, quantity])
                needed[2, i] = max(needed[2, i], abs(jerk) * shares[2, quantity])
    greatest = 0.0
    for i in range(taus.shape[0]):
        needed[1, i] = math.sqrt(needed[1, i])
        needed[2, i] = needed[2, i] ** (1.0 / 3.0)
        greatest = max(greatest, needed[0, i], needed[1, i], needed[2, i])
    return greatest


@inlined
def _greatest_needed(rates: _Rates, law_breaks: Floats, law: Floats, taus: Floats, rows: int) -> float:
    """Return the greatest of `stretch_needed` in its first rows; peaks are looked at closely."""
    needed = np.empty((3, taus.shape[0]))
    _write_needed(rates, law_breaks, law, taus, needed)
    greatest = 0.0
    for row in range(rows):
        for i in range(taus.shape[0]):
            greatest = max(greatest, needed[row, i])
    high = _PEAK * greatest
    close, there = np.empty(_CLOSE), np.empty((3, _CLOSE))
    for i in range(1, taus.shape[0] - 1):
        peak = False
        for row in range(rows):
            around = max(needed[row, i - 1], needed[row, i + 1]) + _SAME
            peak = peak or (needed[row, i] > high and needed[row, i] > around)
        if peak:
            for place in range(_CLOSE):
                close[place] = taus[i - 1] + (taus[i + 1] - taus[i - 1]) * (place / (_CLOSE - 1))
            _write_needed(rates, law_breaks, law, close, there)
            for row in range(rows):
                for place in range(_CLOSE):
                    greatest = max(greatest, there[row, place])
    return greatest


@inlined
def _cells(rates: _Rates, nodes: Floats) -> Floats:
    """Return the cells between nodes (n + 1,), at three places of each."""
    cells = np.zeros((8, nodes.shape[0] - 1, 3 * rates.limits.shape[1]))
    cells[1] = 1.0 / _SMALL
    first = 0
    for rate in range(rates.sizes.shape[0]):
        breaks, terms = one_of(rates.breaks, rates.terms, rates.shapes[rate])
        size = rates.sizes[rate]
        begin, end = breaks[0], breaks[breaks.shape[0] - 1]
        f = np.empty((3, terms.shape[2]))
        piece = 0
        for cell in range(cells.shape[1]):
            middle = 0.5 * (nodes[cell] + nodes[cell + 1])
            if middle < begin or middle > end:
                continue
            for place in range(3):
                s = (nodes[cell], middle, np.nextafter(nodes[cell + 1], nodes[cell]))[place]
                inside = min(max(s, begin), end)
                piece = piece_near(breaks, inside, piece)
                write_derivatives(terms, piece, inside - breaks[piece], f)
                bends = 1.0 if s == inside else 0.0
                for quantity in range(terms.shape[2] // size):
                    square, product, bend, twist = 0.0, 0.0, 0.0, 0.0
                    for c in range(quantity * size, (quantity + 1) * size):
                        x0, x1, x2 = f[0, c], bends * f[1, c], bends * f[2, c]
                        square, product = square + x0 * x0, product + x0 * x1
                        bend, twist = bend + x1 * x1, twist + x2 * x2
                    m = 3 * (first + quantity) + place
                    acceleration, jerk = rates.limits[1, first + quantity], rates.limits[2, first + quantity]
                    cells[0, cell, m] = math.sqrt(square) / rates.limits[0, first + quantity]
                    greatest = 1.0 / max(math.sqrt(square) / acceleration, _SMALL)
                    lean = product / max(square, (_SMALL * acceleration) ** 2)
                    cells[7, cell, m] = bend / (acceleration * acceleration)
                    cells[1, cell, m], cells[2, cell, m] = greatest, lean
                    if size > 1:
                        cells[3, cell, m] = greatest * greatest * cells[7, cell, m] - lean * lean
                    cells[4, cell, m] = math.sqrt(square) / jerk
                    cells[5, cell, m] = 3.0 * math.sqrt(bend) / jerk
                    cells[6, cell, m] = math.sqrt(twist) / jerk
        first += terms.shape[2] // size
    return cells


@inlined
def _ceiling(cells: Floats) -> Floats:
    """Return the greatest s'^2 (n,) that velocity and curvature allow."""
    speed, ceiling = np.zeros(cells.shape[1]), np.empty(cells.shape[1])
    fastest = 0.0
    for cell in range(cells.shape[1]):
        bend, twist = _TINY, _TINY
        for m in range(cells.shape[2]):
            speed[cell] = max(speed[cell], cells[0, cell, m])
            bend, twist = max(bend, cells[7, cell, m]), max(twist, cells[6, cell, m])
        fastest = max(fastest, speed[cell])
        ceiling[cell] = min(_CURVATURE_ACCELERATION / math.sqrt(bend), (_CURVATURE_JERK / twist) ** (2.0 / 3.0))
    for cell in range(cells.shape[1]):
        # Where nothing moves there is no limit but this one.
        ceiling[cell] = min(ceiling[cell], 1.0 / max(speed[cell], STILL * fastest) ** 2)
    return ceiling


@inlined
def _accelerations(
    cells: Floats, level: Floats, window: float, budget: Floats, forward: Floats, backward: Floats
) -> None:
    """Write the greatest s'' and -s'' (n,) at s'^2 = `level` (n,), for |f s'' + f' s'^2| <= A and for the jerk.

    By the acceleration s'' is at most root(a^2 - c s'^4) - b s'^2, with the cells' a, b and c. Where it changes within
    the window the jerk is at most |f| s'' / T + 3 |f'| s' s'' + |f''| s'^3.
    """
    for cell in range(cells.shape[1]):
        x = level[cell]
        v = math.sqrt(x)
        rise, fall, smooth = math.inf, math.inf, math.inf
        for m in range(cells.shape[2]):
            root, lean = cells[1, cell, m], cells[2, cell, m] * x
            if cells[3, cell, m] != 0.0:
                root = math.sqrt(max(root * root - cells[3, cell, m] * x * x, 0.0))
            rise, fall = min(rise, root - lean), min(fall, root + lean)
            change = max(cells[4, cell, m] / window + cells[5, cell, m] * v, _TINY)
            smooth = min(smooth, (1.0 - cells[6, cell, m] * (v * x)) / change)
        smooth = max(smooth, 0.0) * budget[cell]
        forward[cell], backward[cell] = min(rise, smooth), min(fall, smooth)


@inlined
def _two_passes(ceiling: Floats, forward: Floats, backward: Floats, nodes: Floats) -> Floats:
    """Return the greatest s'^2 at the nodes (n + 1,) below `ceiling` with s'' in [-backward, forward] on each cell."""
    x = ceiling.copy()
    for cell in range(forward.shape[0]):
        x[cell + 1] = min(x[cell + 1], x[cell] + 2.0 * forward[cell] * (nodes[cell + 1] - nodes[cell]))
    for cell in range(forward.shape[0] - 1, -1, -1):
        x[cell] = min(x[cell], x[cell + 1] + 2.0 * backward[cell] * (nodes[cell + 1] - nodes[cell]))
    return x


@inlined
def _speeds(squares: Floats) -> Floats:
    speeds = np.empty(squares.shape[0])
    for i in range(squares.shape[0]):
        speeds[i] = math.sqrt(squares[i])
    return speeds


@inlined
def _times(speeds: Floats, nodes: Floats) -> Floats:
    """Return when each node is passed (n + 1,), with a speed that is linear in time on each cell."""
    times = np.zeros(speeds.shape[0])
    for i in range(speeds.shape[0] - 1):
        times[i + 1] = times[i] + 2.0 * (nodes[i + 1] - nodes[i]) / max(speeds[i] + speeds[i + 1], _TINY)
    return times


@inlined
def _at_nodes(values: Floats) -> Floats:
    """Return the lesser of the values of the two cells beside each node, and 0 at both ends."""
    found = np.zeros(values.shape[0] + 1)
    for i in range(1, values.shape[0]):
        found[i] = min(values[i - 1], values[i])
    return found


@inlined
def _linear(places: Floats, values: Floats, x: float, piece: int) -> float:
    """Return the value at x in a piece between places, linear; beyond the ends that of the ends."""
    width = places[piece + 1] - places[piece]
    share = min(max((x - places[piece]) / width, 0.0), 1.0) if width > 0.0 else 0.0
    return values[piece] + share * (values[piece + 1] - values[piece])


@inlined
def _cut(speeds: Floats, times: Floats, window: float) -> Floats:
    """Return the speeds at the nodes with tops that last `window`: a morphological opening in time.

    Exact at the nodes and half a window beside them; between nodes the speed is linear in time.
    """
    count, half = speeds.shape[0], 0.5 * window
    least, cut = np.empty(count), np.zeros(count)
    for side in (-1.0, 1.0, 0.0):
        first, last = 0, 0
        for i in range(count):
            begin, end = times[i] + side * half - half, times[i] + side * half + half
            first, last = piece_near(times, begin, first), piece_near(times, end, last)
            least[i] = min(_linear(times, speeds, begin, first), _linear(times, speeds, end, last))
            for k in range(first, last + 2):
                if k < count and begin <= times[k] <= end:
                    least[i] = min(least[i], speeds[k])
            cut[i] = max(cut[i], least[i])
    first = 0
    for i in range(count):
        while times[first] < times[i] - half:
            first += 1
        k = first
        while k < count and times[k] <= times[i] + half:
            cut[i] = max(cut[i], least[k])
            k += 1
    return cut


@inlined
def _merged(one: Floats, other: Floats) -> Floats:
    """Return the values of two increasing arrays in increasing order."""
    both = np.empty(one.shape[0] + other.shape[0])
    i, j = 0, 0
    for place in range(both.shape[0]):
        if j == other.shape[0] or (i < one.shape[0] and one[i] <= other[j]):
            both[place] = one[i]
            i += 1
        else:
            both[place] = other[j]
            j += 1
    return both


@inlined
def _slope_at(times: Floats, slopes: Floats, t: float, piece: int) -> float:
    return slopes[piece] if times[0] <= t <= times[slopes.shape[0]] else 0.0


@inlined
def _moving_average(nodes: Floats, speeds: Floats, window: float) -> tuple[Floats, Floats]:
    """Return the moving average over `window` seconds of the law that passes `nodes` with `speeds`, (n + 1,) each.

    It begins and ends at rest half a window before and after that law. Its derivatives are differences of the law's
    own: S' = (s(t + T/2) - s(t - T/2)) / T, and so on.
    """
    count = nodes.shape[0] - 1
    times, slopes = _times(speeds, nodes), np.empty(count)
    steepest = 0.0
    for i in range(count):
        slopes[i] = (speeds[i + 1] - speeds[i]) / (times[i + 1] - times[i])
        steepest = max(steepest, abs(slopes[i]))
    kept = 1
    before = slopes[0]
    for i in range(1, count):
        changes = abs(slopes[i] - before) > 1e-9 * steepest
        before = slopes[i]
        if changes:
            times[kept], slopes[kept] = times[i], slopes[i]
            kept += 1
    times[kept] = times[count]
    times, slopes = times[: kept + 1], slopes[:kept]
    later = np.empty(kept + 1)
    for i in range(kept + 1):
        later[i] = times[i] + window
    every = _merged(times, later)
    breaks = np.empty(every.shape[0])
    pieces = 0
    for i in range(1, every.shape[0]):
        if every[i] - every[i - 1] > 1e-9 * later[kept]:
            pieces += 1
            breaks[pieces] = every[i]
    breaks[0], breaks[pieces] = every[0], later[kept]
    seconds, jerks = np.empty(pieces), np.empty(pieces)
    here, there = 0, 0
    for i in range(pieces):
        middle = 0.5 * (breaks[i] + breaks[i + 1])
        here, there = piece_near(times, middle, here), piece_near(times, middle - window, there)
        seconds[i] = breaks[i + 1] - breaks[i]
        change = _slope_at(times, slopes, middle, here) - _slope_at(times, slopes, middle - window, there)
        jerks[i] = change / window
    return _integrated(float(nodes[0]), seconds, jerks, float(nodes[count]))


@inlined
def _integrated(start: float, seconds: Floats, jerks: Floats, goal: float) -> tuple[Floats, Floats]:
    """Return the cubic pieces from rest at `start` with jerks (p,) for `seconds` (p,) to rest, scaled to end at `goal`.

    What the jerks lack of that, by the rounding of their seconds, is made up by the least change of them: they lose
    what they have along the two rows which, times them, are s'' and s' at the end.
    """
    pieces = seconds.shape[0]
    breaks, lever = np.zeros(pieces + 1), np.empty(pieces)
    for i in range(pieces):
        breaks[i + 1] = breaks[i] + seconds[i]
    square, mixed, slope = 0.0, 0.0, 0.0
    for i in range(pieces):
        lever[i] = seconds[i] * (breaks[pieces] - breaks[i + 1] + 0.5 * seconds[i])
        square, mixed = square + seconds[i] * seconds[i], mixed + seconds[i] * lever[i]
        slope += seconds[i] * jerks[i]
    across, speed = 0.0, 0.0
    for i in range(pieces):
        lever[i] -= mixed / square * seconds[i]
        jerks[i] -= slope / square * seconds[i]
        across, speed = across + lever[i] * lever[i], speed + lever[i] * jerks[i]
    terms = np.empty((pieces, 4, 1))
    s, s1, s2 = 0.0, 0.0, 0.0
    for i in range(pieces):
        h, j = seconds[i], jerks[i] - speed / across * lever[i]
        terms[i, 0, 0], terms[i, 1, 0], terms[i, 2, 0], terms[i, 3, 0] = s, s1, s2 / 2.0, j / 6.0
        s, s1, s2 = s + h * (s1 + h * (0.5 * s2 + h * j / 6.0)), s1 + h * (s2 + 0.5 * h * j), s2 + h * j
    for i in range(pieces):
        for power in range(4):
            terms[i, power, 0] *= (goal - start) / s
        terms[i, 0, 0] += start
    return breaks, terms


@inlined
def _searched(nodes: Floats, cells: Floats, ceiling: Floats, window: float, budget: Floats) -> tuple[Floats, Floats]:
    """Return the law s(t) with the moving average over `window` seconds; without terms when it is too long.

    budget (n,): by what the share of the jerk that is left for changing s'' is multiplied on each cell.
    """
    count = ceiling.shape[0]
    wide = np.empty(count)
    for cell in range(count):
        reach = math.sqrt(ceiling[cell]) * 0.5 * window
        wide[cell] = ceiling[cell]
        k = cell - 1
        while k >= 0 and nodes[k + 1] > nodes[cell] - reach:
            wide[cell] = min(wide[cell], ceiling[k])
            k -= 1
        k = cell + 1
        while k < count and nodes[k] < nodes[cell + 1] + reach:
            wide[cell] = min(wide[cell], ceiling[k])
            k += 1
    widened = _at_nodes(wide)
    x = widened
    level, forward, backward = np.empty(count), np.empty(count), np.empty(count)
    for _ in range(_PASSES):
        for cell in range(count):
            level[cell] = max(x[cell], x[cell + 1])
        _accelerations(cells, level, window, budget, forward, backward)
        x = _two_passes(widened, forward, backward, nodes)
    speeds = _speeds(x)
    speeds = _cut(speeds, _times(speeds, nodes), window)
    for i in range(1, count):
        if not speeds[i] > 0.0:
            return np.empty(0), np.empty((0, 4, 1))
    return _moving_average(nodes, speeds, window)


@inlined
def _longest_window(nodes: Floats, cells: Floats, ceiling: Floats) -> float:
    """Return the time (s) in which most cells change s'' from 0 to its bound, at most a third of the whole motion."""
    count = ceiling.shape[0]
    reaching, forward, backward = np.empty(count), np.empty(count), np.empty(count)
    for cell in range(count):
        jerk, least = 0.0, math.inf
        for m in range(cells.shape[2]):
            jerk, least = max(jerk, cells[4, cell, m]), min(least, cells[1, cell, m])
        reaching[cell] = jerk * least
    _accelerations(cells, np.zeros(count), math.inf, np.ones(count), forward, backward)
    times = _times(_speeds(_two_passes(_at_nodes(ceiling), forward, backward, nodes)), nodes)
    return min(float(np.median(reaching)), float(times[count]) / 3.0)


@inlined
def _grid(breaks: Floats, law: Floats, edges: Floats, points: int) -> Floats:
    """Return increasing nominal times: both sides of each break of the law, and places all along the path."""
    each, last = max(4, points // edges.shape[0]), breaks.shape[0] - 1
    reached, sides = np.empty(last + 1), np.empty(2 * last + 2)
    for i in range(last + 1):
        reached[i] = jerk_state(breaks, law, breaks[i], min(i, last - 1))[0]
        sides[2 * i], sides[2 * i + 1] = np.nextafter(breaks[i], -math.inf), breaks[i]
    taus = np.empty((edges.shape[0] - 1) * each)
    piece = 0
    for i in range(taus.shape[0]):
        begin, end = edges[i // each], edges[i // each + 1]
        place = begin + (end - begin) * (i % each / each)
        piece = piece_near(reached, place, piece)
        taus[i] = _linear(reached, breaks, place, piece)
    return _merged(taus, sides)


@inlined
def _spent(
    nodes: Floats, budget: Floats, breaks: Floats, law: Floats, taus: Floats, needed: Floats, window: float
) -> Floats:
    """Return the budget (n,) changed by what the jerk needs: less where it exceeds its limit, more where it doesn't.

    needed (m,): the cube root of the share of the jerk's limit at nominal times (m,). What counts is the greatest of it
    within 0.75 windows: candidates for that stand in a queue, each less than the one before.
    """
    count, around = taus.shape[0], 0.75 * window
    share, queue = np.zeros(budget.shape[0]), np.empty(count, np.int64)
    head, tail, seen, at, cell = 0, 0, 0, 0, 0
    for i in range(count):
        while seen < count and taus[seen] <= taus[i] + around:
            while tail > head and needed[queue[tail - 1]] <= needed[seen]:
                tail -= 1
            queue[tail] = seen
            tail += 1
            seen += 1
        while taus[queue[head]] < taus[i] - around:
            head += 1
        at = piece_near(breaks, taus[i], at)
        cell = piece_near(nodes, jerk_state(breaks, law, taus[i], at)[0], cell)
        share[cell] = max(share[cell], needed[queue[head]])
    spent = np.empty(budget.shape[0])
    for cell in range(budget.shape[0]):
        wanted = share[cell] if share[cell] > 0.0 else 1.0
        change = wanted**3.0 if wanted > 1.0 else wanted**1.5
        spent[cell] = budget[cell] / min(max(change, _LEAST_CHANGE), _MOST_CHANGE)
    return spent


@inlined
def _stretch(breaks: Floats, law: Floats, factor: float) -> None:
    """Make a law that begins at time 0 slower by a factor, in place."""
    for i in range(breaks.shape[0]):
        breaks[i] *= factor
    for i in range(law.shape[0]):
        for power in range(4):
            law[i, power, 0] /= factor**power


@compiled(*_TABLE, array_of(float64, 1))
def fastest_law(
    shapes: Integers, breaks: Floats, terms: Floats, sizes: Integers, limits: Floats, nodes: Floats
) -> tuple[Floats, Floats]:
    """Return the fastest law found over the nodes (n + 1,), at rest at both ends, that keeps the limits of all rates.

    Rates are told above; the first of them covers the whole path. Without terms where none is found.
    """
    rates = _Rates(shapes, breaks, terms, sizes, limits)
    edges = one_of(breaks, terms, shapes[0])[0]
    cells = _cells(rates, nodes)
    ceiling = _ceiling(cells)
    usual = np.ones(ceiling.shape[0])
    best, best_window = math.inf, 0.0
    chosen, chosen_law = np.empty(0), np.empty((0, 4, 1))
    before, last = math.inf, math.inf
    window = _longest_window(nodes, cells, ceiling) / _SHORTER
    for _ in range(_WINDOWS):
        found, law = _searched(nodes, cells, ceiling, window, usual)
        if law.shape[0] > 0:
            taus = _grid(found, law, edges, _COARSE)
            need = _write_needed(rates, found, law, taus, np.empty((3, taus.shape[0])))
            end = found[law.shape[0]] * need
            if end < best:
                best, best_window = end, window
                _stretch(found, law, need)
                chosen, chosen_law = found, law
            if end > last and last > before:
                break
            before, last = last, end
        window *= _SHORTER
    if chosen_law.shape[0] == 0:
        return chosen, chosen_law
    for attempt in range(2):
        window = best_window * _SHORTER if attempt else best_window
        budget = usual
        for _ in range(_BUDGETS):
            found, law = _searched(nodes, cells, ceiling, window, budget)
            if law.shape[0] == 0:
                break
            taus = _grid(found, law, edges, _COARSE)
            needed = np.empty((3, taus.shape[0]))
            need = _write_needed(rates, found, law, taus, needed)
            budget = _spent(nodes, budget, found, law, taus, needed[2], window)
            if found[law.shape[0]] * need < best:
                best = found[law.shape[0]] * need
                _stretch(found, law, need)
                chosen, chosen_law = found, law
    even = np.empty(_FINE)
    for i in range(_FINE):
        even[i] = chosen[chosen_law.shape[0]] * (i / (_FINE - 1))
    taus = _merged(even, _grid(chosen, chosen_law, edges, _FINE))
    _stretch(chosen, chosen_law, _greatest_needed(rates, chosen, chosen_law, taus, 3) * _MARGIN)
    return chosen, chosen_law


# Laws and times are copied so that they have the types of those that are found: nothing is compiled twice.


@compiled(*_TABLE, array_of(float64, 1), output_of(float64, 2))
def stretch_needed(
    shapes: Integers, breaks: Floats, terms: Floats, sizes: Integers, limits: Floats, taus: Floats, needed: Floats
) -> None:
    """Write by how much a law has to be slower at nominal times (m,), for each limit to be kept there: (3, m).

    Rows: velocity, acceleration, jerk. The law comes after the rates in shapes (r + 1, 5), breaks and terms.
    """
    law_breaks, law = one_of(breaks, terms, shapes[sizes.shape[0]])
    rates = _Rates(shapes, breaks, terms, sizes, limits)
    _write_needed(rates, law_breaks.copy(), law.copy(), taus.copy(), needed)


@compiled(*_TABLE, array_of(float64, 1), int64)
def greatest_stretch(
    shapes: Integers, breaks: Floats, terms: Floats, sizes: Integers, limits: Floats, taus: Floats, rows: int
) -> float:
    """Return the greatest of `stretch_needed`, of its first rows, at increasing times; peaks are looked at closely."""
    law_breaks, law = one_of(breaks, terms, shapes[sizes.shape[0]])
    rates = _Rates(shapes, breaks, terms, sizes, limits)
    return _greatest_needed(rates, law_breaks.copy(), law.copy(), taus.copy(), rows)


@compiled(array_of(int64, 2), array_of(float64, 1), array_of(float64, 1), array_of(float64, 1), output_of(float64, 2))
def greatest_rates(shapes: Integers, breaks: Floats, terms: Floats, taus: Floats, greatest: Floats) -> None:
    """Write the greatest |velocity|, |acceleration| and |jerk| (3, k) at nominal times (m,).

    shapes (2, 5): of a path's derivative by s, with k components, and of the law, as `one_of` takes them.
    """
    path_breaks, path = one_of(breaks, terms, shapes[0])
    law_breaks, law = one_of(breaks, terms, shapes[1])
    greatest[:] = 0.0
    f = np.empty((3, path.shape[2]))
    at, piece = 0, 0
    for i in range(taus.shape[0]):
        at = piece_near(law_breaks, taus[i], at)
        s, s1, s2, s3 = jerk_state(law_breaks, law, taus[i], at)
        if s < path_breaks[0] or s > path_breaks[path.shape[0]]:
            continue
        piece = piece_near(path_breaks, s, piece)
        write_derivatives(path, piece, s - path_breaks[piece], f)
        for c in range(path.shape[2]):
            velocity, acceleration, jerk = _by_time(f, c, s1, s2, s3)
            greatest[0, c] = max(greatest[0, c], abs(velocity))
            greatest[1, c] = max(greatest[1, c], abs(acceleration))
            greatest[2, c] = max(greatest[2, c], abs(jerk))
