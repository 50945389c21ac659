"""Postures that keep a tool centre point where it is in a moving frame: Newton's method on the chain, compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64, int8, int32
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of
from virtualrobot_sdk.compiled.rigid import multiply, shift, turn
from virtualrobot_sdk.compiled.serial import fill_jacobian, place_frames

from virtualrobot_kernel.numeric.forest import REVOLUTE

Codes = np.ndarray[Any, np.dtype[np.int8]]
Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int32]]

MOST_STEPS = 12
"""Newton steps; two or three are usual."""


@inlined
def solve_definite(matrix: Floats, right: Floats, n: int) -> bool:
    """Solve a symmetric positive definite system in place by Cholesky's method; False when it is not definite."""
    for i in range(n):
        for j in range(i + 1):
            total = matrix[i, j]
            for m in range(j):
                total -= matrix[i, m] * matrix[j, m]
            if i == j:
                if not total > 1e-14:
                    return False
                matrix[i, i] = math.sqrt(total)
            else:
                matrix[i, j] = total / matrix[j, j]
    for i in range(n):
        total = right[i]
        for m in range(i):
            total -= matrix[i, m] * right[m]
        right[i] = total / matrix[i, i]
    for i in range(n - 1, -1, -1):
        total = right[i]
        for m in range(i + 1, n):
            total -= matrix[m, i] * right[m]
        right[i] = total / matrix[i, i]
    return True


@inlined
def _project(jacobian: Floats, gram: Floats, column: Floats, null_space: Floats) -> bool:
    """Write the projector on the Jacobian's null space, I - J^T (J J^T)^-1 J; False where J loses rank."""
    k = jacobian.shape[1]
    for j in range(k):
        for a in range(6):
            column[a] = jacobian[a, j]
            for b in range(a + 1):
                total = 0.0
                for m in range(k):
                    total += jacobian[a, m] * jacobian[b, m]
                gram[a, b] = total
        if not solve_definite(gram, column, 6):
            return False
        for i in range(k):
            total = 1.0 if i == j else 0.0
            for a in range(6):
                total -= jacobian[a, i] * column[a]
            null_space[i, j] = total
    return True


@compiled(
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(int8, 1),
    array_of(int32, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 3),
    float64,
    int8,
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 2),
    array_of(float64, 1),
    output_of(float64, 2),
    output_of(float64, 1),
)
def follow_frame(
    pre: Floats,
    axis: Floats,
    joint_type: Codes,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    post: Floats,
    weight: float,
    frame_type: int,
    frame_axis: Floats,
    frame_point: Floats,
    nominal: Floats,
    displacement: Floats,
    q: Floats,
    error: Floats,
) -> None:
    """Write the postures whose TCP is where `nominal` has it, seen from a frame that one joint has displaced.

    That is forward(q[i]) = S(displacement[i]) forward(nominal[i]), S the motion of the frame in the arm's base frame.
    An arm with more than six joints has many such postures; of these it is the one whose difference from the nominal
    one has no part along the null space of the nominal Jacobian, so that it depends on nothing but nominal posture and
    displacement. Newton steps from what `q` holds solve both conditions, by normal equations; the linear rows are
    multiplied by `weight` so that they compare with the angular ones.

    Args:
        pre: (n, 4, 4), of n joints with k coordinates, as all up to `offset` in `SerialChain`.
        axis: (n, 3).
        joint_type: (n,).
        q_index: (n,).
        multiplier: (n,).
        offset: (n,).
        post: (1, 4, 4) pose of the TCP in the frame of the last joint.
        weight: 1/m.
        frame_type: REVOLUTE when the frame turns by the right hand, else it shifts.
        frame_axis: (3,) unit vector about or along which it does, in the arm's base frame.
        frame_point: (3,) a point on that axis in m, base frame.
        nominal: (m, k).
        displacement: (m,) rad or m.
        q: (m, k) where to start, and the result, written in place.
        error: (m,) how far the TCP is from its place in the end: the larger of m times `weight` and rad; inf where no
            step could be made.
    """
    count = nominal.shape[0]
    k = nominal.shape[1]
    n = pre.shape[0]
    frames = np.empty((n + 1, 4, 4))
    moved = np.empty((2, 4, 4))
    jacobian = np.empty((6, k))
    null_space = np.zeros((k, k))
    gram = np.empty((6, 6))
    column = np.empty(6)
    matrix = np.empty((k, k))
    step = np.empty(k)
    off = np.empty(6)
    for place in range(count):
        place_frames(pre, axis, joint_type, q_index, multiplier, offset, post, nominal[place], frames)
        error[place] = math.inf
        if k > 6:
            fill_jacobian(axis, joint_type, q_index, multiplier, frames, weight, jacobian)
            if not _project(jacobian, gram, column, null_space):
                continue
        # The target: S(displacement) @ base_t_tcp, with S = turn about a line, or shift.
        for row in range(4):
            for col in range(4):
                moved[0, row, col] = 1.0 if row == col else 0.0
        amount = displacement[place]
        x = frame_axis[0]
        y = frame_axis[1]
        z = frame_axis[2]
        if frame_type == REVOLUTE:
            shift(moved, 0, frame_point[0], frame_point[1], frame_point[2])
            turn(moved, 0, x, y, z, amount)
            shift(moved, 0, -frame_point[0], -frame_point[1], -frame_point[2])
        else:
            shift(moved, 0, x * amount, y * amount, z * amount)
        multiply(moved, 0, frames, n, moved, 1)
        before = math.inf
        for _ in range(MOST_STEPS):
            place_frames(pre, axis, joint_type, q_index, multiplier, offset, post, q[place], frames)
            for a in range(3):
                off[a] = weight * (moved[1, a, 3] - frames[n, a, 3])
                off[3 + a] = 0.0
            # The sum of the axes' cross products is twice the turn for small angles, and 0 for none.
            for c in range(3):
                u0 = frames[n, 0, c]
                u1 = frames[n, 1, c]
                u2 = frames[n, 2, c]
                off[3] += 0.5 * (u1 * moved[1, 2, c] - u2 * moved[1, 1, c])
                off[4] += 0.5 * (u2 * moved[1, 0, c] - u0 * moved[1, 2, c])
                off[5] += 0.5 * (u0 * moved[1, 1, c] - u1 * moved[1, 0, c])
            now = 0.0
            for a in range(6):
                now = max(now, abs(off[a]))
            fill_jacobian(axis, joint_type, q_index, multiplier, frames, weight, jacobian)
            for i in range(k):
                total = 0.0
                for a in range(6):
                    total += jacobian[a, i] * off[a]
                if k > 6:
                    for j in range(k):
                        total -= null_space[i, j] * (q[place, j] - nominal[place, j])
                step[i] = total
                for j in range(i + 1):
                    total = null_space[i, j]
                    for a in range(6):
                        total += jacobian[a, i] * jacobian[a, j]
                    matrix[i, j] = total
            if not solve_definite(matrix, step, k):
                break
            largest = 0.0
            for i in range(k):
                q[place, i] += step[i]
                largest = max(largest, abs(step[i]))
            error[place] = now
            # At the level of rounding steps no longer shrink: one such step more is as good as it gets.
            if largest < 1e-13 or (largest < 1e-10 and largest >= 0.25 * before):
                break
            before = largest


@compiled(
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(int8, 1),
    array_of(int32, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 3),
    float64,
    array_of(float64, 2),
    output_of(float64, 3),
)
def weighted_jacobians(
    pre: Floats,
    axis: Floats,
    joint_type: Codes,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    post: Floats,
    weight: float,
    q: Floats,
    jacobians: Floats,
) -> None:
    """Write the geometric Jacobians (m, 6, k) at the TCP for postures q (m, k), linear rows times `weight` (1/m).

    The chain's arrays are those of `follow_frame`.
    """
    frames = np.empty((pre.shape[0] + 1, 4, 4))
    for place in range(q.shape[0]):
        place_frames(pre, axis, joint_type, q_index, multiplier, offset, post, q[place], frames)
        fill_jacobian(axis, joint_type, q_index, multiplier, frames, weight, jacobians[place])
