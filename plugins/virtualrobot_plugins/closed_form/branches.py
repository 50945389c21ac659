"""From EAIK's angles to solutions: checked forward, told apart, turned into limits and put in order; compiled."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import float64, int64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of
from virtualrobot_sdk.compiled.rigid import multiply, turn
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_plugins.closed_form.model import FIXED, NAMED, NUMBERS, Model
from virtualrobot_plugins.closed_form.singularities import LOOSE, branch_of, signed_branch_of, target_flags

SAME = 1e-6
"""Postures closer than this in every joint (rad), but for full turns, are one: EAIK tells no more of them apart."""
NEAR = 1e-6
"""Angles that miss the target by less than this (m, rad) may be polished to a solution: where an arm is stretched."""
MOST_BRANCHES = 16
MOST_TURNS = 3
"""A joint has at most this many turned values in the answer: those nearest to the seed."""
_SLACK = 1e-10
_TURN_BITS = 8
_TURN_ZERO = 1 << (_TURN_BITS - 1)

Codes = np.ndarray[Any, np.dtype[np.int64]]


Found = tuple[int, int, int, int, float, float]
"""Counts, flags and errors from sorting EAIK's angles:

- number of solutions, turned ones each for themselves;
- number of branches that reach the target, limits or not;
- SHOULDER, ELBOW, WRIST, LOOSE, added;
- number of branches that were left out because another has their name;
- the worst branch's distance from the target (m); without one the least of all angles; inf without any;
- the angle of the same (rad).
"""


Asked = tuple[Floats, Floats, Floats, bool, float, float]
"""Inverse problem of one pose: target (4, 4), limits (2, n), seed (n,), order by the seed or not, tolerances (m, rad).

A plain tuple, as `Found`: making anything better costs as much as a branch.
"""


@inlined
def _wrapped(angle: float) -> float:
    """Return the angle less the full turns that bring it to -pi .. pi."""
    return angle - 2.0 * math.pi * np.round(angle / (2.0 * math.pi))


@inlined
def _place(
    kept: Floats, numbers: Codes, count: int, q: Floats, number: int, flags: int, seed: Floats, named: bool
) -> tuple[int, int]:
    """Add q to the branches unless it is there; return the count, and 1 when another has its name."""
    n = q.shape[0]
    for i in range(count):
        # Away from singularities one posture cannot have two numbers.
        if named and flags == 0 and numbers[i] != number:
            continue
        apart = False
        for j in range(n):
            if abs(_wrapped(q[j] - kept[i, j])) >= SAME:
                apart = True
                break
        if not apart:
            return count, 0
        if named and numbers[i] == number:
            before = 0.0
            after = 0.0
            for j in range(n):
                before += _wrapped(kept[i, j] - seed[j]) ** 2
                after += _wrapped(q[j] - seed[j]) ** 2
            if after < before:
                for j in range(n):
                    kept[i, j] = q[j]
            return count, 1
    if count == kept.shape[0]:
        return count, 1
    for j in range(n):
        kept[count, j] = q[j]
    numbers[count] = number
    return count + 1, 0


@inlined
def _turns(q: float, seed: float, lower: float, upper: float) -> tuple[int, int]:
    """Return the first and the last count of full turns to add to q; the last is less where none fits the limits."""
    full = 2.0 * math.pi
    if lower <= q <= upper and q - full < lower - _SLACK and q + full > upper + _SLACK:
        return 0, 0
    wanted = np.round((seed - q) / full)
    low = math.ceil((lower - _SLACK - q) / full) if lower > -math.inf else wanted
    high = math.floor((upper + _SLACK - q) / full) if upper < math.inf else wanted
    if low > high and (lower == -math.inf or upper == math.inf):
        wanted = high if lower == -math.inf else low
        return int(wanted), int(wanted)
    if lower == -math.inf or upper == math.inf:
        wanted = min(max(wanted, low), high)
        return int(wanted), int(wanted)
    if high - low >= MOST_TURNS:
        low = min(max(wanted - 1.0, low), high - (MOST_TURNS - 1.0))
        high = low + (MOST_TURNS - 1.0)
    return int(low), int(high)


@inlined
def _sorted_out(
    angles: Floats,
    numbers: Floats,
    wrist_frame: int,
    elbow_frame: int,
    kind: int,
    target: Floats,
    limits: Floats,
    seed: Floats,
    sort_by_seed: int,
    position_tolerance: float,
    rotation_tolerance: float,
    solutions: Floats,
    codes: Codes,
) -> Found:
    """Return what angles come to, and write the solutions and their codes: see `find`."""
    n = angles.shape[0]
    most = solutions.shape[0]
    # One piece of memory for all numbers and one for all counts: each piece costs as much as a joint's frame.
    floats = np.empty(16 * (n + 1) + (1 + MOST_BRANCHES) * n + most * (n + 1))
    f = floats[: 16 * (n + 1)].reshape((n + 1, 4, 4))
    rest = floats[16 * (n + 1) :]
    q = rest[:n]
    kept = rest[n : n + MOST_BRANCHES * n].reshape((MOST_BRANCHES, n))
    rest = rest[n + MOST_BRANCHES * n :]
    rows = rest[: most * n].reshape((most, n))
    key = rest[most * n :]
    counts = np.empty(MOST_BRANCHES + 2 * most + 3 * n, np.int64)
    kept_number = counts[:MOST_BRANCHES]
    row_code = counts[MOST_BRANCHES : MOST_BRANCHES + most]
    order = counts[MOST_BRANCHES + most : MOST_BRANCHES + 2 * most]
    turns_of = counts[MOST_BRANCHES + 2 * most :]
    first, last, now = turns_of[:n], turns_of[n : 2 * n], turns_of[2 * n :]
    pre = numbers[NUMBERS:].reshape((n + 1, 4, 4))
    lower, upper = limits[0], limits[1]
    named = kind & NAMED != 0
    branches = 0
    clashes = 0
    flags = 0
    expected = 0
    if kind & FIXED != 0:
        flags, expected = target_flags(target, numbers, kind)
    worst = 0.0
    worst_turn = 0.0
    least = math.inf
    least_turn = math.inf
    for b in range(angles.shape[1]):
        same = True
        for i in range(n):
            # EAIK's branches come as a tree: as far as two have the same angles, their frames are the same.
            if same and b > 0 and angles[i, b] == angles[i, b - 1]:
                continue
            same = False
            q[i] = angles[i, b]
            if i == 0:
                for row in range(3):
                    for column in range(4):
                        f[0, row, column] = pre[0, row, column]
            else:
                multiply(f, i - 1, pre, i, f, i)
            turn(f, i, 0.0, 0.0, 1.0, q[i])
        if same and b > 0:
            continue
        multiply(f, n - 1, pre, n, f, n)
        position = 0.0
        turned = 0.0
        for row in range(3):
            position += (f[n, row, 3] - target[row, 3]) ** 2
            for column in range(3):
                turned += (f[n, row, column] - target[row, column]) ** 2
        position = math.sqrt(position)
        # The norm of the difference of two rotations is sqrt(8) times the sine of half the angle.
        turned = 2.0 * math.asin(min(1.0, math.sqrt(turned / 8.0)))
        if not (position <= position_tolerance and turned <= rotation_tolerance):
            # Angles that are not finite miss by no number and are left out too.
            if position < NEAR and turned < NEAR:
                flags |= LOOSE
            if position + turned < least + least_turn:
                least = position
                least_turn = turned
            continue
        number = 0
        more = 0
        if named:
            if n == 7:
                number, more = signed_branch_of(q, numbers)
            else:
                number, more = branch_of(f, numbers, wrist_frame, elbow_frame)
            flags |= more
        before = branches
        branches, clash = _place(kept, kept_number, branches, q, number, more, seed, named)
        clashes += clash
        if branches > before or clash == 1:
            worst = max(worst, position)
            worst_turn = max(worst_turn, turned)
    if branches < expected:
        flags |= LOOSE
    count = 0
    for b in range(branches):
        fits = True
        for i in range(n):
            kept[b, i] = _wrapped(kept[b, i])
            first[i], last[i] = _turns(kept[b, i], seed[i], lower[i], upper[i])
            now[i] = first[i]
            value = kept[b, i] + 2.0 * math.pi * first[i]
            fits = fits and first[i] <= last[i] and lower[i] - _SLACK <= value <= upper[i] + _SLACK
        while fits and count < most:
            code = kept_number[b]
            distance = 0.0
            turns = 0
            for i in range(n):
                value = min(max(kept[b, i] + 2.0 * math.pi * now[i], lower[i]), upper[i])
                rows[count, i] = value
                distance += (value - seed[i]) ** 2
                turns += abs(now[i])
                code = (code << _TURN_BITS) | (min(max(now[i], 1 - _TURN_ZERO), _TURN_ZERO - 1) + _TURN_ZERO)
            row_code[count] = code
            key[count] = distance if sort_by_seed == 1 else kept_number[b] * 1e6 + turns
            count += 1
            i = n - 1
            while i >= 0 and now[i] == last[i]:
                now[i] = first[i]
                i -= 1
            if i < 0:
                break
            now[i] += 1
    # Insertion keeps equal ones in order and is the fastest way for a few; many are merged.
    if count <= MOST_BRANCHES:
        for i in range(count):
            j = i
            while j > 0 and key[order[j - 1]] > key[i]:
                order[j] = order[j - 1]
                j -= 1
            order[j] = i
    else:
        order[:count] = np.argsort(key[:count], kind="mergesort")
    for i in range(count):
        for j in range(n):
            solutions[i, j] = rows[order[i], j]
        codes[i] = row_code[order[i]]
    if branches > 0:
        least = worst
        least_turn = worst_turn
    return count, branches, flags, clashes, least, least_turn


@compiled(
    array_of(float64, 2),
    array_of(float64, 1),
    int64,
    int64,
    int64,
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(float64, 1),
    int64,
    float64,
    float64,
    output_of(float64, 2),
    output_of(int64, 1),
)
def _find(
    angles: Floats,
    numbers: Floats,
    wrist_frame: int,
    elbow_frame: int,
    kind: int,
    target: Floats,
    limits: Floats,
    seed: Floats,
    sort_by_seed: int,
    position_tolerance: float,
    rotation_tolerance: float,
    solutions: Floats,
    codes: Codes,
) -> Found:
    model = numbers, wrist_frame, elbow_frame, kind
    asked = target, limits, seed, sort_by_seed, position_tolerance, rotation_tolerance
    return _sorted_out(angles, *model, *asked, solutions, codes)


@compiled(
    array_of(float64, 2),
    array_of(int64, 1),
    array_of(float64, 1),
    int64,
    int64,
    int64,
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(float64, 1),
    float64,
    int64,
    output_of(float64, 2),
    output_of(int64, 1),
    output_of(int64, 2),
)
def _find_each(
    angles: Floats,
    last: Codes,
    numbers: Floats,
    wrist_frame: int,
    elbow_frame: int,
    kind: int,
    targets: Floats,
    limits: Floats,
    seed: Floats,
    tolerance: float,
    room: int,
    solutions: Floats,
    codes: Codes,
    told: Codes,
) -> int:
    begin = 0
    count = 0
    model = numbers, wrist_frame, elbow_frame, kind
    for pose in range(last.shape[0]):
        its_own = angles[:, begin : last[pose]]
        begin = last[pose]
        rows = solutions[count : count + room]
        asked = targets[pose], limits, seed, 0, tolerance, tolerance
        found = _sorted_out(its_own, *model, *asked, rows, codes)
        told[pose, 0], told[pose, 1], told[pose, 2] = found[0], found[1], found[2]
        count += found[0]
    return count


def find(angles: Floats, model: Model, asked: Asked, room: int) -> tuple[Found, Floats, Codes]:
    """Return what EAIK's angles (n, branches) come to, the solutions (m, n) and their codes (m,), at most `room`.

    What misses the target by more than the tolerances is left out. Each branch is added with all full turns that the
    limits allow. They are sorted by distance from the seed, or by branch and turns; of equal ones the seed's nearest is
    kept.
    """
    solutions, codes = np.empty((room, len(angles))), np.empty(room, np.int64)
    found = _find(angles, *model, *asked, solutions, codes)
    return found, solutions[: found[0]], codes[: found[0]]


def find_each(
    angles: Sequence[Floats], model: Model, targets: Floats, limits: Floats, seed: Floats, tolerance: float, room: int
) -> tuple[Codes, Floats]:
    """Return what EAIK's angles (n, branches) of each of m targets (m, 4, 4) come to, as `find` has it without order.

    They are numbers of solutions and branches, and flags, (m, 3), and the solutions of all, (k, n), each target's by
    branch and turns; at most `room` of each.
    """
    last = np.cumsum([one.shape[1] for one in angles])
    solutions, told = np.empty((room * len(angles), len(seed))), np.empty((len(angles), 3), np.int64)
    given = np.concatenate(angles, axis=1), last, *model, targets, limits, seed, tolerance, room
    count = _find_each(*given, solutions, np.empty(room, np.int64), told)
    return told, solutions[:count]


def decoded(code: int, joints: int) -> tuple[int, tuple[int, ...]]:
    """Return the branch's number and each joint's full turns, which a code packs."""
    turns = []
    for _ in range(joints):
        turns.append((code & (2 * _TURN_ZERO - 1)) - _TURN_ZERO)
        code >>= _TURN_BITS
    return code, tuple(reversed(turns))


def most_turns(lower: Floats, upper: Floats) -> int:
    """Return how many turned variants a branch may have within limits."""
    spans = (np.minimum(upper - lower, 2.0 * math.pi * (MOST_TURNS - 1)) + 2.0 * _SLACK) / (2.0 * math.pi)
    turns = np.where(np.isfinite(lower) & np.isfinite(upper), np.floor(np.maximum(spans, 0.0)) + 1.0, 1.0)
    return int(turns.prod())
