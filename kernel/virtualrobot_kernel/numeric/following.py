"""Steps along a Cartesian path by resolved rates, for serial chains whose free joints serve nothing else; compiled.

The joints' rate is q'(u) = J^+ twist(u), the least one (D. E. Whitney, Resolved motion rate control of manipulators and
human prostheses, IEEE Trans. Man-Machine Systems 10(2), 1969). J^+ comes from the singular value decomposition of J by
one-sided Jacobi rotations, which is as exact as LAPACK's for matrices this small (M. R. Hestenes, Inversion of matrices
by biorthogonalization and related results, J. SIAM 6(1), 1958; G. Golub, C. Van Loan, Matrix Computations, 4th ed.,
section 8.6.3).

The chain's arrays are those of `SerialChain`, `post` (1, 4, 4) with the tool centre point. Twists (6,) are in m and rad
per u, base frame; `weight` (1/m) multiplies linear rows, so that they compare with the angular ones.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import float64, int8, int32
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of
from virtualrobot_sdk.compiled.pose_error import pose_error
from virtualrobot_sdk.compiled.serial import fill_jacobian, place_frames

Codes = np.ndarray[Any, np.dtype[np.int8]]
Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int32]]

_SWEEPS, _ORTHOGONAL = 30, 1e-15
# Singular values below this share of the greatest one count as 0.
_RANK = 1e-12
# Newton steps onto the path: so many at most, where they end, and how near the path the last one has to be (m, rad).
_STEPS, _CLOSED, _ON_PATH = 6, 1e-12, 1e-10


class _Chain(NamedTuple):
    pre: Floats
    axis: Floats
    joint_type: Codes
    q_index: Integers
    multiplier: Floats
    offset: Floats
    post: Floats
    weight: float


class _Work(NamedTuple):
    """Work space for k joints: frames (n + 1, 4, 4), the weighted Jacobian (6, k), and its decomposition.

    The Jacobian's c = min(6, k) rows or columns (c, max(6, k)) made orthogonal, the rotation (c, c) that does so, and
    the squares of its singular values (c,).
    """

    frames: Floats
    jacobian: Floats
    vectors: Floats
    rotation: Floats
    squares: Floats


_CHAIN = (
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(int8, 1),
    array_of(int32, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 3),
    float64,
)
_IN, _OUT = array_of(float64, 1), output_of(float64, 1)


@inlined
def _work(chain: _Chain, k: int) -> _Work:
    c = min(6, k)
    return _Work(
        np.empty((chain.pre.shape[0] + 1, 4, 4)),
        np.empty((6, k)),
        np.empty((c, max(6, k))),
        np.empty((c, c)),
        np.empty(c),
    )


@inlined
def _place(chain: _Chain, q: Floats, work: _Work) -> None:
    """Write the frames at q (k,)."""
    place_frames(
        chain.pre,
        chain.axis,
        chain.joint_type,
        chain.q_index,
        chain.multiplier,
        chain.offset,
        chain.post,
        q,
        work.frames,
    )


@inlined
def _differentiate(chain: _Chain, work: _Work) -> None:
    """Write the weighted Jacobian of the frames."""
    fill_jacobian(
        chain.axis, chain.joint_type, chain.q_index, chain.multiplier, work.frames, chain.weight, work.jacobian
    )


@inlined
def _decompose(work: _Work) -> None:
    """Write the decomposition of the Jacobian: of its rows, or of its columns where there are fewer."""
    vectors, rotation, wide = work.vectors, work.rotation, work.jacobian.shape[1] >= 6
    count, length = vectors.shape
    for i in range(count):
        for j in range(length):
            vectors[i, j] = work.jacobian[i, j] if wide else work.jacobian[j, i]
        for j in range(count):
            rotation[i, j] = 1.0 if i == j else 0.0
    for _ in range(_SWEEPS):
        turned = False
        for i in range(count - 1):
            for j in range(i + 1, count):
                first, second, both = 0.0, 0.0, 0.0
                for m in range(length):
                    first += vectors[i, m] * vectors[i, m]
                    second += vectors[j, m] * vectors[j, m]
                    both += vectors[i, m] * vectors[j, m]
                if abs(both) <= _ORTHOGONAL * math.sqrt(first * second):
                    continue
                turned = True
                ratio = (second - first) / (2.0 * both)
                tangent = math.copysign(1.0 / (abs(ratio) + math.sqrt(1.0 + ratio * ratio)), ratio)
                cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
                sine = tangent * cosine
                for m in range(length):
                    x, y = vectors[i, m], vectors[j, m]
                    vectors[i, m], vectors[j, m] = cosine * x - sine * y, sine * x + cosine * y
                for m in range(count):
                    x, y = rotation[i, m], rotation[j, m]
                    rotation[i, m], rotation[j, m] = cosine * x - sine * y, sine * x + cosine * y
        if not turned:
            break
    for i in range(count):
        total = 0.0
        for m in range(length):
            total += vectors[i, m] * vectors[i, m]
        work.squares[i] = total


@inlined
def _solve(work: _Work, weighted: Floats, solution: Floats) -> None:
    """Write the least joints (k,) that give a weighted twist (6,), or what is nearest to it, by the decomposition."""
    wide = work.jacobian.shape[1] >= 6
    left, right = (work.rotation, work.vectors) if wide else (work.vectors, work.rotation)
    greatest = 0.0
    for i in range(work.squares.shape[0]):
        greatest = max(greatest, work.squares[i])
    solution[:] = 0.0
    for i in range(work.squares.shape[0]):
        if work.squares[i] <= _RANK * _RANK * greatest:
            continue
        share = 0.0
        for m in range(6):
            share += left[i, m] * weighted[m]
        share /= work.squares[i]
        for j in range(solution.shape[0]):
            solution[j] += share * right[i, j]


@inlined
def _weigh(chain: _Chain, twist: Floats, weighted: Floats) -> None:
    for i in range(3):
        weighted[i], weighted[3 + i] = chain.weight * twist[i], twist[3 + i]


@inlined
def _write_rate(chain: _Chain, q: Floats, twist: Floats, work: _Work, weighted: Floats, rate: Floats) -> None:
    """Write the least rate (k,) of the joints that moves the tool centre point by a twist, and all that leads to it."""
    _place(chain, q, work)
    _differentiate(chain, work)
    _decompose(work)
    _weigh(chain, twist, weighted)
    _solve(work, weighted, rate)


@inlined
def _write_ahead(start: Floats, width: float, rate: Floats, q: Floats) -> None:
    for i in range(start.shape[0]):
        q[i] = start[i] + width * rate[i]


@inlined
def _greatest(values: Floats) -> float:
    greatest = 0.0
    for i in range(values.shape[0]):
        greatest = max(greatest, abs(values[i]))
    return greatest


@compiled(*_CHAIN, _IN, _IN, float64, _IN, _IN, array_of(float64, 2), _OUT)
def step_along(
    pre: Floats,
    axis: Floats,
    joint_type: Codes,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    post: Floats,
    weight: float,
    start: Floats,
    rate: Floats,
    width: float,
    middle_twist: Floats,
    end_twist: Floats,
    end: Floats,
    q: Floats,
) -> bool:
    """Write the joints q (k,) at the end of a step from `start` (k,), on its branch; False where it is too long.

    A Runge-Kutta step predicts them, Newton steps put them on the path: to `end` (4, 4), the pose of the tool centre
    point. A correction as long as the step itself would be another branch.

    Args:
        pre: as all up to `weight` told above.
        axis: (n, 3).
        joint_type: (n,).
        q_index: (n,).
        multiplier: (n,).
        offset: (n,).
        post: (1, 4, 4).
        weight: 1/m.
        start: (k,) rad or m.
        rate: (k,) of the joints by u there.
        width: of the step, in u.
        middle_twist: (6,) of the path in its middle.
        end_twist: (6,) of the path at its end.
        end: (4, 4) the path's pose there.
        q: (k,) what is written.
    """
    chain = _Chain(pre, axis, joint_type, q_index, multiplier, offset, post, weight)
    k = start.shape[0]
    work, weighted = _work(chain, k), np.empty(6)
    slope, mean, predicted, error, change = rate.copy(), rate.copy(), np.empty(k), np.empty(6), np.empty(k)
    for stage in range(3):
        _write_ahead(start, width if stage == 2 else 0.5 * width, slope, q)
        _write_rate(chain, q, end_twist if stage == 2 else middle_twist, work, weighted, slope)
        _write_ahead(mean, 1.0 if stage == 2 else 2.0, slope, mean)
    _write_ahead(start, width / 6.0, mean, predicted)
    farthest = 1e-9
    for i in range(k):
        farthest = max(farthest, 0.1 * abs(predicted[i] - start[i]) + 1e-9)
        q[i] = predicted[i]
    for _ in range(_STEPS):
        _place(chain, q, work)
        pose_error(end, work.frames, pre.shape[0], error)
        if _greatest(error) < _CLOSED:
            break
        _differentiate(chain, work)
        _decompose(work)
        _weigh(chain, error, weighted)
        _solve(work, weighted, change)
        for i in range(k):
            q[i] += change[i]
            if not abs(q[i] - predicted[i]) <= farthest:
                return False
    _place(chain, q, work)
    pose_error(end, work.frames, pre.shape[0], error)
    return _greatest(error) < _ON_PATH


@compiled(*_CHAIN, _IN, _IN, _OUT, output_of(float64, 1), output_of(float64, 1))
def rate_along(
    pre: Floats,
    axis: Floats,
    joint_type: Codes,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    post: Floats,
    weight: float,
    q: Floats,
    twist: Floats,
    rate: Floats,
    left: Floats,
    right: Floats,
) -> tuple[float, float]:
    """Write the joints' rate (k,) that gives a twist at q (k,); return the smallest singular value and what is missing.

    What is missing is the share of the weighted twist that the joints cannot make. left (6,), right (k,): the unit
    vectors that belong to the singular value, written.
    """
    chain = _Chain(pre, axis, joint_type, q_index, multiplier, offset, post, weight)
    work, weighted = _work(chain, q.shape[0]), np.empty(6)
    # A copy has the type that steps have: nothing is compiled twice.
    _write_rate(chain, q.copy(), twist, work, weighted, rate)
    least = 0
    for i in range(work.squares.shape[0]):
        if work.squares[i] < work.squares[least]:
            least = i
    smallest = math.sqrt(work.squares[least])
    wide = q.shape[0] >= 6
    for m in range(6):
        left[m] = work.rotation[least, m] if wide else work.vectors[least, m] / smallest
    for m in range(q.shape[0]):
        right[m] = work.vectors[least, m] / smallest if wide else work.rotation[least, m]
    missing, whole = 0.0, 0.0
    for m in range(6):
        made = 0.0
        for i in range(q.shape[0]):
            made += work.jacobian[m, i] * rate[i]
        missing += (made - weighted[m]) ** 2
        whole += weighted[m] ** 2
    return smallest, math.sqrt(missing / whole)


@compiled(*_CHAIN, _IN, _IN, float64, _IN, _IN, _IN, _IN, _OUT)
def bend_along(
    pre: Floats,
    axis: Floats,
    joint_type: Codes,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    post: Floats,
    weight: float,
    q: Floats,
    rate: Floats,
    step: float,
    before: Floats,
    after: Floats,
    left: Floats,
    right: Floats,
    curvature: Floats,
) -> float:
    """Write the derivative (k,) of the joints' rate by u, and return that of the smallest singular value.

    By central differences over `step` in u along `rate` (k,) from q (k,); before, after (6,): the path's twists there.
    The value's is left^T dJ/du right (J. R. Magnus, On differentiating eigenvalues and eigenvectors, Econometric Theory
    1(2), 1985), with the unit vectors of `rate_along`.
    """
    chain = _Chain(pre, axis, joint_type, q_index, multiplier, offset, post, weight)
    work, weighted, other, place = _work(chain, q.shape[0]), np.empty(6), np.empty(q.shape[0]), np.empty(q.shape[0])
    _write_ahead(q, -step, rate, place)
    _write_rate(chain, place, before, work, weighted, other)
    jacobian = work.jacobian.copy()
    _write_ahead(q, step, rate, place)
    _write_rate(chain, place, after, work, weighted, curvature)
    slope = 0.0
    for i in range(q.shape[0]):
        curvature[i] = (curvature[i] - other[i]) / (2.0 * step)
        for m in range(6):
            slope += left[m] * (work.jacobian[m, i] - jacobian[m, i]) * right[i]
    return slope / (2.0 * step)


@compiled(*_CHAIN, _IN, array_of(float64, 2))
def distance_from(
    pre: Floats,
    axis: Floats,
    joint_type: Codes,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    post: Floats,
    weight: float,
    q: Floats,
    pose: Floats,
) -> float:
    """Return how far the tool centre point is at q (k,) from a pose (4, 4): the greatest entry in m or rad."""
    chain = _Chain(pre, axis, joint_type, q_index, multiplier, offset, post, weight)
    work, error = _work(chain, q.shape[0]), np.empty(6)
    _place(chain, q.copy(), work)
    pose_error(pose, work.frames, pre.shape[0], error)
    return _greatest(error)


@compiled(*_CHAIN, _IN, output_of(float64, 2), output_of(float64, 2))
def place_at(
    pre: Floats,
    axis: Floats,
    joint_type: Codes,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    post: Floats,
    weight: float,
    q: Floats,
    pose: Floats,
    jacobian: Floats,
) -> None:
    """Write the pose (4, 4) of the tool centre point at q (k,), and its Jacobian (6, k), linear rows times `weight`."""
    chain = _Chain(pre, axis, joint_type, q_index, multiplier, offset, post, weight)
    work = _work(chain, q.shape[0])
    _place(chain, q.copy(), work)
    _differentiate(chain, work)
    pose[:] = work.frames[pre.shape[0]]
    jacobian[:] = work.jacobian


@compiled(*_CHAIN, _IN, _IN, float64, float64, output_of(float64, 2), _OUT, _OUT)
def look_along(
    pre: Floats,
    axis: Floats,
    joint_type: Codes,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    post: Floats,
    weight: float,
    q: Floats,
    direction: Floats,
    step: float,
    floor: float,
    rates: Floats,
    smallest: Floats,
    slopes: Floats,
) -> None:
    """Write the joints' rates (n, k) at n places on their way from q (k,), each `step` after the one before.

    They are those that move the tool centre point along `direction` (6,), whose linear part has the weight already;
    singular values below `floor` count less and less. smallest (n,): the smallest one at each place; slopes (n,): its
    derivative along the way, with the vectors that belong to it there.
    """
    chain = _Chain(pre, axis, joint_type, q_index, multiplier, offset, post, weight)
    count, k = rates.shape
    work, place = _work(chain, k), q.copy()
    wide, c = k >= 6, min(6, k)
    before, left, right = np.zeros((6, k)), np.zeros(6), np.zeros(k)
    for number in range(count):
        _place(chain, place, work)
        _differentiate(chain, work)
        for last in range(2):
            # The vectors of the place before; at the last place its own, since nothing comes after it.
            if number > 0 and (last == 0 or number == count - 1):
                slope = 0.0
                for m in range(6):
                    for j in range(k):
                        slope += left[m] * (work.jacobian[m, j] - before[m, j]) * right[j]
                slopes[number - 1 + last] = slope / step
            if last == 0:
                _decompose(work)
                least = 0
                for i in range(c):
                    if work.squares[i] < work.squares[least]:
                        least = i
                size = math.sqrt(work.squares[least])
                smallest[number] = size
                for m in range(6):
                    left[m] = work.rotation[least, m] if wide else work.vectors[least, m] / max(size, 1e-300)
                for j in range(k):
                    right[j] = work.vectors[least, j] / max(size, 1e-300) if wide else work.rotation[least, j]
        before[:] = work.jacobian
        rates[number] = 0.0
        for i in range(c):
            share = 0.0
            for m in range(6):
                share += (work.rotation[i, m] if wide else work.vectors[i, m]) * direction[m]
            share /= max(work.squares[i], floor * floor)
            for j in range(k):
                rates[number, j] += share * (work.vectors[i, j] if wide else work.rotation[i, j])
        for j in range(k):
            place[j] += step * rates[number, j]


@compiled(float64, *[_IN] * 6, _IN, _IN, _OUT)
def write_middle(
    width: float,
    q0: Floats,
    rate0: Floats,
    curvature0: Floats,
    q1: Floats,
    rate1: Floats,
    curvature1: Floats,
    lower: Floats,
    upper: Floats,
    middle: Floats,
) -> bool:
    """Write the middle (k,) of a quintic Hermite piece; return whether the piece certainly keeps `lower` and `upper`.

    The piece, `width` long, has values, first and second derivatives (k,) at both ends. It lies in the hull of its
    Bernstein coefficients (G. Farin, Curves and Surfaces for CAGD, 5th ed., chapters 5 and 7.5).
    """
    inside = True
    for i in range(q0.shape[0]):
        first = q0[i] + width * rate0[i] / 5.0
        second = 2.0 * first - q0[i] + width * width * curvature0[i] / 20.0
        fourth = q1[i] - width * rate1[i] / 5.0
        third = 2.0 * fourth - q1[i] + width * width * curvature1[i] / 20.0
        middle[i] = (q0[i] + q1[i] + 5.0 * (first + fourth) + 10.0 * (second + third)) / 32.0
        least = min(q0[i], first, second, third, fourth, q1[i])
        greatest = max(q0[i], first, second, third, fourth, q1[i])
        inside = inside and lower[i] <= least and greatest <= upper[i]
    return inside
