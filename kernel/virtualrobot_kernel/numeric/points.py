"""Postures that bring a tool centre point to points, however it is turned there: damped least squares, compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64, int8, int32
from virtualrobot_sdk.compiled.cache import array_of, compiled, output_of
from virtualrobot_sdk.compiled.serial import fill_jacobian, place_frames

from virtualrobot_kernel.numeric.tracking import solve_definite

Codes = np.ndarray[Any, np.dtype[np.int8]]
Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int32]]

REACHED = 1e-9
"""Greatest distance (m) from a point that counts as reached."""

_POLISHED = 1e-13
_STEPS = 80
_PATIENCE = 6
_DAMPING = 0.05
_DAMPING_FLOOR = 1e-12
_LONGEST_STEP = 0.5


@compiled(
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(int8, 1),
    array_of(int32, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 3),
    float64,
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 2),
    array_of(float64, 2),
    output_of(float64, 2),
    output_of(float64, 1),
)
def follow_points(
    pre: Floats,
    axis: Floats,
    joint_type: Codes,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    post: Floats,
    weight: float,
    lower: Floats,
    upper: Floats,
    points: Floats,
    starts: Floats,
    q: Floats,
    error: Floats,
) -> None:
    """Write the postures within limits whose tip is at each of `points`, each solved from the one before.

    Where that leads nowhere, a point is tried from each of `starts`; the first of these is where the first point is
    solved from. The steps are J^T (J J^T + d I)^-1 e with a damping that falls with the square of the error (Yamashita
    and Fukushima 2001), and joints at their limits are left out where the step would push them through.

    Args:
        pre: (n, 4, 4), of n joints with k coordinates, as all up to `offset` in `SerialChain`.
        axis: (n, 3).
        joint_type: (n,).
        q_index: (n,).
        multiplier: (n,).
        offset: (n,).
        post: (1, 4, 4) pose of the tip in the frame of the last joint.
        weight: 1/m, one by the reach of the chain.
        lower: (k,) limits; -inf without.
        upper: (k,) limits; inf without.
        points: (m, 3) in m, base frame.
        starts: (s, k) postures, one at least.
        q: (m, k) the postures, up to the first point that is not reached.
        error: (m,) how far the tip is from its point (m), the best attempt's where it is not reached; inf after that.
    """
    k = q.shape[1]
    n = pre.shape[0]
    frames = np.empty((n + 1, 4, 4))
    jacobian = np.empty((6, k))
    matrix = np.empty((3, 3))
    right = np.empty(3)
    step = np.empty(k)
    now = np.empty(k)
    error[:] = math.inf
    for place in range(points.shape[0]):
        reached = False
        for attempt in range(-1, starts.shape[0]):
            if attempt < 0 and place == 0:
                continue
            for i in range(k):
                begin = q[place - 1, i] if attempt < 0 else starts[attempt, i]
                now[i] = min(max(begin, lower[i]), upper[i])
            best = math.inf
            patience = _PATIENCE
            for _ in range(_STEPS):
                place_frames(pre, axis, joint_type, q_index, multiplier, offset, post, now, frames)
                distance = 0.0
                for a in range(3):
                    right[a] = points[place, a] - frames[n, a, 3]
                    distance += right[a] * right[a]
                distance = math.sqrt(distance)
                if distance < error[place]:
                    error[place] = distance
                # A descent that only creeps has nothing to find.
                patience = _PATIENCE if distance < 0.9 * best else patience - 1
                if distance < best:
                    best = distance
                    for i in range(k):
                        q[place, i] = now[i]
                if best < _POLISHED or patience < 0:
                    break
                size = distance * distance * weight * weight
                fill_jacobian(axis, joint_type, q_index, multiplier, frames, weight, jacobian)
                damping = _DAMPING * min(size, 1.0) + _DAMPING_FLOOR
                off0 = right[0] * weight
                off1 = right[1] * weight
                off2 = right[2] * weight
                for _again in range(k + 1):
                    right[0] = off0
                    right[1] = off1
                    right[2] = off2
                    for a in range(3):
                        for b in range(a + 1):
                            total = damping if a == b else 0.0
                            for i in range(k):
                                total += jacobian[a, i] * jacobian[b, i]
                            matrix[a, b] = total
                    if not solve_definite(matrix, right, 3):
                        right[:] = 0.0
                    held = False
                    for i in range(k):
                        step[i] = 0.0
                        for a in range(3):
                            step[i] += jacobian[a, i] * right[a]
                        if (now[i] >= upper[i] and step[i] > 0.0) or (now[i] <= lower[i] and step[i] < 0.0):
                            for a in range(3):
                                jacobian[a, i] = 0.0
                            held = True
                    if not held:
                        break
                longest = _LONGEST_STEP
                for i in range(k):
                    longest = max(longest, abs(step[i]))
                for i in range(k):
                    now[i] = min(max(now[i] + step[i] * (_LONGEST_STEP / longest), lower[i]), upper[i])
            if best < REACHED:
                error[place] = best
                reached = True
                break
        if not reached:
            return
