"""Search of postures along a path, rung by rung; compiled.

A rung is a place of the path, a node one posture there: a combination of the free values, a branch of the inverse
kinematics, and the turns that its joints have gone. The cheapest way to each node leads over one on the rung before,
from which the free values go one step at the most and the branch stays (R. Bellman, Dynamic Programming, 1957;
the ladder is that of Descartes, S. Edwards, C. Lewis, ROS-Industrial applications, 2013). Edges are looked at as they
come and never kept.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64, int8, int32, int64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]
Flags = np.ndarray[Any, np.dtype[np.int8]]

MOST_TURNS = 6.0
"""A joint whose range is more full turns than this counts as one without limits."""
_TURN = 2.0 * math.pi
_ROUNDING = 1e-9
_STRAIGHT, _NEAR_LIMIT = 0.02, 0.2
"""Cost of a straight wrist, as the square of the sine at which it has halved, and of a joint at its limit."""


@inlined
def _turns_in(lower: float, upper: float) -> int:
    """Return at how many turns a joint between limits may be; 1 for one without."""
    if upper - lower > MOST_TURNS * _TURN:
        return 1
    return math.floor((upper - lower) / _TURN + _ROUNDING) + 1


@compiled(
    *(array_of(float64, 4), array_of(float64, 3), array_of(int8, 3), array_of(float64, 2), array_of(float64, 2)),
    *(array_of(int64, 2), array_of(float64, 1), array_of(float64, 1)),
    *(output_of(int32, 2), output_of(int64, 2), output_of(float64, 2)),
)
def cheapest_way(
    q: Floats,
    wrist: Floats,
    blocked: Flags,
    limits: Floats,
    most: Floats,
    neighbours: Integers,
    changes: Floats,
    wish: Floats,
    back: Integers,
    way: Integers,
    joints: Floats,
) -> int:
    """Write the cheapest way over n rungs, and return n; or the first rung that none leads to.

    A step costs the squares of the shares of the greatest differences that its joints need, and what its change of free
    values does; a posture what its free values do, and more the nearer its wrist is to straight and joints to limits.

    Args:
        q: (n, g, b, k) postures for g combinations of free values in b branches, each joint at any of its turns; NaN
            where there is none.
        wrist: (n, g, b), 0 where the wrist is straight.
        blocked: (n, g, b), not 0 where the way must not pass.
        limits: (2, k) of the joints.
        most: (n - 1, k) the greatest difference of each joint from a rung to the next, less than half a turn.
        neighbours: (g, w) the combinations from which one is reached; -1 where there are fewer.
        changes: (w,) what that costs.
        wish: (g,) what a combination costs.
        back: (n, g * b * t) room, t being the product of `turns_of`.
        way: (n, 2) combination and branch on each rung.
        joints: (n, k) the postures of the way, continuous.
    """
    n, combinations, branches, k = q.shape
    nodes, turns = combinations * branches, back.shape[1] // (combinations * branches)
    cost, before = np.full(nodes * turns, np.inf), np.full(nodes * turns, np.inf)
    low, low_before = np.zeros((nodes, k)), np.zeros((nodes, k))
    count, count_before = np.zeros((nodes, k), np.int64), np.zeros((nodes, k), np.int64)
    radix, shift = np.ones(k, np.int64), np.zeros(k, np.int64)
    for j in range(k):
        radix[j] = _turns_in(limits[0, j], limits[1, j])
    for i in range(n):
        alive = False
        for g in range(combinations):
            for b in range(branches):
                node = g * branches + b
                for t in range(turns):
                    cost[node * turns + t] = np.inf
                    back[i, node * turns + t] = -1
                is_there = blocked[i, g, b] == 0 and not np.isnan(q[i, g, b, 0])
                for j in range(k):
                    low[node, j], count[node, j] = q[i, g, b, j], 1 if is_there else 0
                    if is_there and limits[1, j] - limits[0, j] <= MOST_TURNS * _TURN:
                        up = math.ceil((limits[0, j] - q[i, g, b, j]) / _TURN - _ROUNDING)
                        low[node, j] += _TURN * up
                        room = math.floor((limits[1, j] - low[node, j]) / _TURN + _ROUNDING) + 1
                        count[node, j] = max(0, min(room, radix[j]))
                    is_there = is_there and count[node, j] > 0
                if not is_there:
                    count[node, 0] = 0
                    continue
                if i == 0:
                    for t in range(turns):
                        cost[node * turns + t] = 0.0
                for w in range(neighbours.shape[1] if i > 0 else 0):
                    other = neighbours[g, w]
                    old = other * branches + b
                    if other < 0 or count_before[old, 0] == 0:
                        continue
                    step = changes[w]
                    for j in range(k):
                        apart = q[i, g, b, j] - q[i - 1, other, b, j]
                        apart -= _TURN * np.round(apart / _TURN)
                        if abs(apart) > most[i - 1, j]:
                            step = np.inf
                            break
                        step += (apart / most[i - 1, j]) ** 2
                        shift[j] = 0
                        if limits[1, j] - limits[0, j] <= MOST_TURNS * _TURN:
                            shift[j] = round((low[node, j] - low_before[old, j] - apart) / _TURN)
                    if step == np.inf:
                        continue
                    for t in range(turns):
                        rest, from_turn, scale = t, 0, 1
                        for j in range(k):
                            turn = rest % radix[j]
                            rest //= radix[j]
                            turn_before = turn + shift[j]
                            if turn >= count[node, j] or not 0 <= turn_before < count_before[old, j]:
                                from_turn = -1
                                break
                            from_turn += scale * turn_before
                            scale *= radix[j]
                        if from_turn < 0:
                            continue
                        whole = before[old * turns + from_turn] + step
                        if whole < cost[node * turns + t]:
                            cost[node * turns + t] = whole
                            back[i, node * turns + t] = old * turns + from_turn
                own = wish[g] + _STRAIGHT / (_STRAIGHT + wrist[i, g, b] ** 2)
                for t in range(turns):
                    rest, near = t, 0.0
                    for j in range(k):
                        turn = rest % radix[j]
                        rest //= radix[j]
                        if turn >= count[node, j]:
                            near = np.inf
                            break
                        span = limits[1, j] - limits[0, j]
                        if 0.0 < span < np.inf:
                            value = low[node, j] + _TURN * turn
                            near += _NEAR_LIMIT * ((2.0 * value - limits[0, j] - limits[1, j]) / span) ** 6
                    cost[node * turns + t] += own + near
                    alive = alive or cost[node * turns + t] < np.inf
        if not alive:
            return i
        cost, before = before, cost
        low, low_before = low_before, low
        count, count_before = count_before, count
    at = int(np.argmin(before))
    last = at
    for i in range(n - 1, -1, -1):
        way[i, 0], way[i, 1] = at // (branches * turns), at // turns % branches
        at = back[i, at]
    rest = last % turns
    for j in range(k):
        joints[n - 1, j] = low_before[last // turns, j] + _TURN * (rest % radix[j])
        rest //= radix[j]
    for i in range(n - 2, -1, -1):
        for j in range(k):
            value = q[i, way[i, 0], way[i, 1], j]
            joints[i, j] = value + _TURN * np.round((joints[i + 1, j] - value) / _TURN)
    return n


def turns_of(limits: Floats) -> list[int]:
    """Return at how many turns each joint may be, of limits (2, k)."""
    return [_turns_in(*ends) for ends in limits.T.tolist()]
