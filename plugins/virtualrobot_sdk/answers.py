"""Checks of what kinematics components answer: nonsense becomes a `ComponentFault` that says what is wrong."""

from __future__ import annotations

import math

import numpy as np

from virtualrobot_sdk.errors import ComponentFault, FaultKind
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult, InverseStatus, SerialChain

RIGID = 1e-6
"""How far the rotation of a returned pose may be from orthonormal (largest entry of R^T R - I)."""

CLOSURE = 1e-6
"""How far a solution's tip may be from its target where tighter tolerances were asked for (m, rad)."""


def checked_frames(value: object) -> Floats:
    """Return what `forward` answered, (m, 4, 4); raise ComponentFault unless all is finite and the last pose rigid."""
    frames = _floats("forward", value)
    if frames.ndim != 3 or frames.shape[0] == 0 or frames.shape[1:] != (4, 4):
        raise nonsense(f"forward returned shape {frames.shape}; it must be (m, 4, 4) with m at least 1")
    _finite("forward", frames)
    rotation = frames[-1, :3, :3]
    off = np.abs(rotation.T @ rotation - _EYE).max()
    if off > RIGID or frames[-1, 3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        raise nonsense(
            f"forward returned a last pose that is no rigid transform (R^T R is off by {off:.3g}, the last row is "
            f"{frames[-1, 3].tolist()})"
        )
    return frames


def checked_jacobian(value: object, chain: SerialChain) -> Floats:
    """Return what `jacobian` answered as (6, k); raise ComponentFault for another shape or a value not finite."""
    jacobian = _floats("jacobian", value)
    if jacobian.shape != (6, len(chain.joint_names)):
        raise nonsense(f"jacobian returned shape {jacobian.shape}; it must be {(6, len(chain.joint_names))}")
    _finite("jacobian", jacobian)
    return jacobian


def checked_result(value: object, chain: SerialChain, options: InverseOptions) -> InverseResult:
    """Return what `inverse` answered, its solutions (m, k) finite and within limits where asked for.

    Raises ComponentFault when status, solutions and configurations do not fit together.
    """
    if not isinstance(value, InverseResult) or not isinstance(value.status, InverseStatus):
        raise nonsense(f"inverse returned {_kind(value)}; it must be an InverseResult with an InverseStatus")
    solutions = _floats("inverse", value.solutions)
    k = len(chain.joint_names)
    if solutions.ndim != 2 or solutions.shape[1] != k:
        raise nonsense(f"inverse returned solutions of shape {solutions.shape}; they must be (m, {k})")
    if (value.status is InverseStatus.SOLVED) != (len(solutions) > 0):
        raise nonsense(f"inverse returned {value.status.value} with {len(solutions)} solutions")
    if len(value.configurations) != len(solutions):
        raise nonsense(f"inverse named {len(value.configurations)} configurations for {len(solutions)} solutions")
    _finite("inverse", solutions)
    if options.respect_limits:
        outside = (solutions < chain.lower - _SLACK) | (solutions > chain.upper + _SLACK)
        if outside.any():
            row, column = (int(place[0]) for place in np.nonzero(outside))
            raise nonsense(
                f"inverse returned {chain.joint_names[column]!r} at {solutions[row, column]:.6g}, outside its limits "
                f"{chain.lower[column]:.6g} to {chain.upper[column]:.6g}"
            )
    return value


def check_solution(reached: Floats, target: Floats, options: InverseOptions) -> None:
    """Raise ComponentFault when a solution's tip, at `reached` (4, 4), is not at the `target` (4, 4) asked for."""
    distance, angle = pose_distance(reached, target)
    if distance > max(options.position_tolerance, CLOSURE) or angle > max(options.rotation_tolerance, CLOSURE):
        raise nonsense(f"inverse returned a solution that misses its target by {distance:.3g} m and {angle:.3g} rad")


def pose_distance(a: Floats, b: Floats) -> tuple[float, float]:
    """Return the distance (m) and the angle (rad) between two poses (4, 4)."""
    turn = a[:3, :3].T @ b[:3, :3]
    # From the skew part as well as the trace: the arc cosine of almost 1 loses half of the digits.
    skew = math.hypot(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1])
    return math.dist(a[:3, 3], b[:3, 3]), math.atan2(skew, turn[0, 0] + turn[1, 1] + turn[2, 2] - 1.0)


def nonsense(reason: str) -> ComponentFault:
    """Return the fault of a component whose answer makes no sense."""
    return ComponentFault(FaultKind.NONSENSE, reason)


_EYE = np.eye(3)
_SLACK = 1e-9
"""Room for the last digits where a solution lies on a limit (rad, m)."""


def _floats(method: str, value: object) -> Floats:
    if not isinstance(value, np.ndarray) or value.dtype != np.float64:
        raise nonsense(f"{method} returned {_kind(value)}; it must be a float64 array")
    return value


def _finite(method: str, array: Floats) -> None:
    # A sum of numbers that are not all finite is not finite either; the slow look tells an overflow.
    if not math.isfinite(array.sum()) and not np.isfinite(array).all():
        place = tuple(int(i[0]) for i in np.nonzero(~np.isfinite(array)))
        raise nonsense(f"{method} returned {array[place]} at {list(place)}; all values must be finite")


def _kind(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype}"
    return "None" if value is None else f"a {type(value).__name__}"
