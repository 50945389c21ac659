"""Inverse kinematics of a serial chain: damped least squares within limits, started again at random until it holds.

Each start is a Levenberg-Marquardt descent whose damping falls with the square of the error (N. Yamashita and
M. Fukushima, On the rate of convergence of the Levenberg-Marquardt method, Computing Suppl. 15, 2001), so that its
last steps are Newton steps and converge quadratically. Errors in metres are divided by the chain's reach, so that
arms of any size converge alike.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import float64, int8, int64, uint64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of
from virtualrobot_sdk.compiled.pose_error import pose_error
from virtualrobot_sdk.compiled.serial import fill_jacobian, place_frames
from virtualrobot_sdk.kinematics import REVOLUTE, Codes, Floats, Integers

from virtualrobot_plugins.chain.damped import step_within_limits
from virtualrobot_plugins.chain.serial import JOINT_TYPES, SerialChain, reach_bound

# Measured on four arms of 6 and 7 axes, 1,000 poses each: these gave the fewest steps in the mean and at p99.
_DAMPING = 0.05
_DAMPING_FLOOR = 1e-12
_LONGEST_STEP = 1.0
_STEPS_PER_START = 60
_PROGRESS = 0.8
_PATIENCE = 3
_POLISHED = 1e-10

ENDLESS = 100.0
"""Range (rad, m) from which on a coordinate counts as endless, as of a base: nobody draws from all of it."""

Words = np.ndarray[Any, np.dtype[np.uint64]]


class SearchSpace(NamedTuple):
    """Ranges of a chain's k joints for solutions and for random starts; arrays (k,) in metres and radians."""

    lower: Floats
    upper: Floats
    draw_lower: Floats
    """Start of the range that starts are drawn from: the limit; of what is endless about -pi (revolute) or -1 m."""
    draw_upper: Floats
    """End of that range."""
    endless: Codes
    """1 (revolute) or 2 (prismatic) where the limits are so far apart that starts are drawn around the seed: within pi,
    or as far as the target is from where the seed leads to and at least 1 m. Else 0."""
    turns: Codes
    """1 where adding a full turn changes no pose: all joints of the coordinate are revolute, multipliers are whole."""
    scale: float
    """1 / reach (1/m), what makes errors in metres and in radians comparable."""


class SearchOutcome(NamedTuple):
    """Outcome of a search for joint positions: success, effort and remaining error."""

    solved: bool
    starts: int
    """Starts made, the seed's included."""
    steps: int
    """Steps of all starts."""
    position_error: float
    """Position error of the solution, or of the best posture met (m)."""
    rotation_error: float
    """Rotation error of the same posture (rad)."""


def search_space(chain: SerialChain, respect_limits: bool = True) -> SearchSpace:
    """Return the search space of a chain; without `respect_limits`, revolute joints turn freely."""
    k = len(chain.lower)
    turns = np.ones(k, np.int8)
    revolute = np.zeros(k, np.bool_)
    for kind, index, multiplier in zip(chain.joint_type, chain.q_index, chain.multiplier, strict=True):
        revolute[index] |= kind == REVOLUTE
        turns[index] &= kind == REVOLUTE and multiplier == round(multiplier)
    opened = revolute & (not respect_limits)
    lower = np.where(opened, -np.inf, chain.lower)
    upper = np.where(opened, np.inf, chain.upper)
    endless = upper / 2.0 - lower / 2.0 > ENDLESS / 2.0  # limits may be the largest numbers
    half = np.where(revolute, np.pi, 1.0)
    draw_lower = np.where(endless, np.clip(-half, lower, np.maximum(lower, upper - 2.0 * half)), lower)
    draw_upper = np.where(endless, draw_lower + 2.0 * half, upper)
    # How far a base may drive says nothing of the arm's size.
    first, last = (np.where(endless, 0.0, limit) for limit in (chain.lower, chain.upper))
    reach = reach_bound(chain._replace(lower=first, upper=last))[1]
    scale = 1.0 / reach if 0.0 < reach < np.inf else 1.0
    codes = np.where(endless, np.where(revolute, 1, 2), 0).astype(np.int8)
    return SearchSpace(lower, upper, draw_lower, draw_upper, codes, turns, scale)


@inlined
def next_random(state: Words) -> float:
    """Advance xorshift64* (S. Vigna, An experimental exploration of Marsaglia's xorshift generators, ACM TOMS, 2016).

    `state` (1,) is uint64 and never 0; returns a number in [0, 1).
    """
    x = state[0]
    x ^= x >> np.uint64(12)
    x ^= x << np.uint64(25)
    x ^= x >> np.uint64(27)
    state[0] = x
    return float((x * np.uint64(2685821657736338717)) >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@inlined
def unwind(q: Floats, seed: Floats, lower: Floats, upper: Floats, turns: Codes) -> None:
    """Add to each coordinate the full turns that bring it nearest to the seed within limits."""
    full = 2.0 * math.pi
    for i in range(q.shape[0]):
        if turns[i] == 0:
            continue
        value = q[i] + full * np.round((seed[i] - q[i]) / full)
        if value > upper[i]:
            value -= full * math.ceil((value - upper[i]) / full)
        elif value < lower[i]:
            value += full * math.ceil((lower[i] - value) / full)
        if lower[i] <= value <= upper[i]:
            q[i] = value


@compiled(
    *JOINT_TYPES,
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(int8, 1),
    array_of(int8, 1),
    float64,
    array_of(float64, 2),
    array_of(float64, 1),
    int64,
    float64,
    float64,
    uint64,
    output_of(float64, 1),
)
def _search(
    pre: Floats,
    axis: Floats,
    joint_type: Codes,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    post: Floats,
    lower: Floats,
    upper: Floats,
    draw_lower: Floats,
    draw_upper: Floats,
    endless: Codes,
    turns: Codes,
    scale: float,
    target: Floats,
    seed: Floats,
    starts: int,
    position_tolerance: float,
    rotation_tolerance: float,
    random_state: int,
    q: Floats,
) -> tuple[bool, int, int, float, float]:
    """Do what `search` does; a solution is written to q (k,)."""
    n = pre.shape[0]
    k = seed.shape[0]
    state = np.empty(1, np.uint64)
    state[0] = random_state
    frames = np.empty((n + 1, 4, 4))
    tip = post.reshape((1, 4, 4))
    jacobian = np.empty((6, k))
    error = np.empty(6)
    triangle = np.empty((6, 6))
    y = np.empty(6)
    step = np.empty(k)
    steps = 0
    least = np.inf
    least_position = np.inf
    least_rotation = np.inf
    away = 1.0
    for start in range(starts):
        for i in range(k):
            value = seed[i]
            if start > 0:
                share = next_random(state)
                if endless[i] == 0:
                    value = draw_lower[i] + (draw_upper[i] - draw_lower[i]) * share
                else:
                    value += (2.0 * share - 1.0) * (math.pi if endless[i] == 1 else away)
            q[i] = min(max(value, lower[i]), upper[i])
        best = np.inf
        patience = _PATIENCE
        for iteration in range(_STEPS_PER_START + 1):
            place_frames(pre, axis, joint_type, q_index, multiplier, offset, tip, q, frames)
            pose_error(target, frames, n, error)
            position = math.sqrt(error[0] * error[0] + error[1] * error[1] + error[2] * error[2])
            rotation = math.sqrt(error[3] * error[3] + error[4] * error[4] + error[5] * error[5])
            size = position * position * scale * scale + rotation * rotation
            if start == 0 and iteration == 0:
                away = max(away, position)
            if size < least:
                least = size
                least_position = position
                least_rotation = rotation
            if size < best * _PROGRESS:
                best = size
                patience = _PATIENCE
            else:
                patience -= 1
            # Within tolerance it goes on polishing for as long as that helps.
            polished = position <= _POLISHED and rotation <= _POLISHED
            over = patience < _PATIENCE or iteration == _STEPS_PER_START
            if position <= position_tolerance and rotation <= rotation_tolerance and (polished or over):
                unwind(q, seed, lower, upper, turns)
                return True, start + 1, steps, position, rotation
            if patience < 0:
                break
            fill_jacobian(axis, joint_type, q_index, multiplier, frames, scale, jacobian)
            for row in range(3):
                error[row] *= scale
            damping = _DAMPING * min(size, 1.0) + _DAMPING_FLOOR
            step_within_limits(jacobian, error, damping, q, lower, upper, triangle, y, step)
            longest = _LONGEST_STEP
            for i in range(k):
                longest = max(longest, abs(step[i]))
            for i in range(k):
                q[i] = min(max(q[i] + step[i] * (_LONGEST_STEP / longest), lower[i]), upper[i])
            steps += 1
    return False, starts, steps, least_position, least_rotation


def search(
    chain: SerialChain,
    space: SearchSpace,
    base_t_tip: Floats,
    seed: Floats,
    starts: int,
    position_tolerance: float,
    rotation_tolerance: float,
    random_seed: int,
) -> tuple[SearchOutcome, Floats]:
    """Return the outcome and the first posture (k,) found that puts the tip at `base_t_tip` (4, 4), a rigid transform.

    The first start is `seed` (k,), moved into limits; the others are drawn by `random_seed`, around the seed where a
    coordinate is endless, so that equal calls give equal answers to the last bit. A start that is within tolerance
    (m, rad) is polished to 1e-10 where possible. The posture is inside limits and, by full turns, as near to the seed
    as it can be; where the outcome is not `solved`, it is the last one tried and of no use.
    """
    q = np.empty(len(seed))
    # The odd constant spreads neighbouring seeds over the 64 bits (the golden ratio, as in splitmix64).
    state = ((random_seed + 1) * 0x9E3779B97F4A7C15) % 2**64 or 1
    outcome = _search(*chain[:7], *space, base_t_tip, seed, starts, position_tolerance, rotation_tolerance, state, q)
    return SearchOutcome(*outcome), q
