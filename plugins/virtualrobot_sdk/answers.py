"""Checks of what components answer: nonsense becomes a `ComponentFault` that says what is wrong."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real

import numpy as np

from virtualrobot_sdk.errors import ComponentFault, FaultKind
from virtualrobot_sdk.kinematics import (
    Floats,
    InverseMany,
    InverseOptions,
    InverseResult,
    InverseStatus,
    SerialChain,
)
from virtualrobot_sdk.rays import Readings

RIGID = 1e-6
"""Largest error of the rotation of a returned pose from orthonormal (largest entry of R^T R - I)."""

MOST_SOLUTIONS = 10_000
"""Largest number of solutions in an answer: each is looked at."""

LONGEST_TEXT = 2_000
"""Number of characters that are kept of a text."""

MOST_BEAM_RAYS = 4096
"""Largest number of rays in a beam."""

CLOSURE = 1e-6
"""Largest error of a solution's tip from its target where tighter tolerances were asked for (m, rad)."""


def checked_frames(value: object) -> Floats:
    """Return a copy of what `forward` answered, (m, 4, 4).

    Raises ComponentFault unless all is finite and the last pose a rigid transform.
    """
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
    if np.linalg.det(rotation) < 0.0:
        raise nonsense("forward returned a last pose that is a reflection; its axes must be right-handed")
    return frames


def checked_jacobian(value: object, chain: SerialChain) -> Floats:
    """Return a copy of what `jacobian` answered, (6, k).

    Raises ComponentFault for another shape or a value that is not finite.
    """
    jacobian = _floats("jacobian", value)
    if jacobian.shape != (6, len(chain.joint_names)):
        raise nonsense(f"jacobian returned shape {jacobian.shape}; it must be {(6, len(chain.joint_names))}")
    _finite("jacobian", jacobian)
    return jacobian


def checked_result(value: object, chain: SerialChain, options: InverseOptions) -> InverseResult:
    """Return a copy of what `inverse` answered, its solutions (m, k) finite, of the limits and configuration asked for.

    Raises ComponentFault when a field has a wrong type, or status, solutions and configurations do not fit together.
    """
    result = _fitting(value, chain, options)
    _check_numbers(result.solutions, chain, options)
    return result


def checked_name(value: object) -> str:
    """Return what `configuration` answered; raise ComponentFault when it is no text."""
    return _text("the name", value, "configuration")


def checked_results(values: Sequence[object], chain: SerialChain, options: InverseOptions) -> list[InverseResult]:
    """Return what `checked_result` does for each of many answers; their numbers are looked at together."""
    results = [_fitting(value, chain, options) for value in values]
    if results:
        try:
            _check_numbers(np.concatenate([result.solutions for result in results]), chain, options)
        except ComponentFault:
            for result in results:
                _check_numbers(result.solutions, chain, options)  # whose place in its own answer is told
    return results


def checked_many(value: object, chain: SerialChain, count: int) -> InverseMany:
    """Return a copy of what `inverse_many` answered for so many poses, its solutions finite and within limits.

    Raises ComponentFault when a field has a wrong type, or they don't fit together.
    """
    if not isinstance(value, InverseMany):
        raise nonsense(f"inverse_many returned {_kind(value)}; it must be an InverseMany")
    solutions, k = _floats("inverse_many", value.solutions), len(chain.joint_names)
    if solutions.ndim != 2 or solutions.shape[1] != k:
        raise nonsense(f"inverse_many returned solutions of shape {solutions.shape}; they must be (m, {k})")
    if not isinstance(value.target, np.ndarray) or value.target.dtype != np.int64:
        raise nonsense(f"inverse_many returned {_kind(value.target)} as target; it must be an int64 array")
    target = np.array(value.target)
    if target.shape != solutions.shape[:1]:
        raise nonsense(f"inverse_many returned target of shape {target.shape} for {len(solutions)} solutions")
    if len(target) and (target[0] < 0 or target[-1] >= count or (np.diff(target) < 0).any()):
        raise nonsense(f"inverse_many returned targets that do not go up from 0 to {count - 1} at the most")
    _check_numbers(solutions, chain, InverseOptions())
    return InverseMany(target, solutions)


def _fitting(value: object, chain: SerialChain, options: InverseOptions) -> InverseResult:
    """Return a copy of an answer whose fields fit together; its solutions' numbers are still to be looked at."""
    if not isinstance(value, InverseResult):
        raise nonsense(f"inverse returned {_kind(value)}; it must be an InverseResult")
    if not isinstance(value.status, InverseStatus):
        raise nonsense(f"inverse returned {_kind(value.status)} as status; it must be an InverseStatus")
    solutions = _floats("inverse", value.solutions)
    k = len(chain.joint_names)
    if solutions.ndim != 2 or solutions.shape[1] != k:
        raise nonsense(f"inverse returned solutions of shape {solutions.shape}; they must be (m, {k})")
    if len(solutions) > MOST_SOLUTIONS:
        raise nonsense(f"inverse returned {len(solutions)} solutions; it may return {MOST_SOLUTIONS}")
    if (value.status is InverseStatus.SOLVED) != (len(solutions) > 0):
        raise nonsense(f"inverse returned {value.status.value} with {len(solutions)} solutions")
    names = value.configurations
    if not isinstance(names, tuple | list):
        raise nonsense(f"inverse returned {_kind(names)} as configurations; they must be a tuple of texts")
    if len(names) != len(solutions):
        raise nonsense(f"inverse named {len(names)} configurations for {len(solutions)} solutions")
    angles = value.arm_angles
    if not isinstance(angles, tuple | list) or len(angles) not in (0, len(solutions)):
        said = f"{len(angles)} arm angles" if isinstance(angles, tuple | list) else f"{_kind(angles)} as arm angles"
        raise nonsense(f"inverse returned {said} for {len(solutions)} solutions; it must be a tuple of as many numbers")
    result = value._replace(
        solutions=solutions,
        configurations=tuple(_text("a configuration", name) for name in names),
        position_error=_number("position_error", value.position_error),
        rotation_error=_number("rotation_error", value.rotation_error),
        reason=_text("the reason", value.reason),
        arm_angles=tuple(_number("an arm angle", angle) for angle in angles),
    )
    if not math.isfinite(sum(result.arm_angles)):
        raise nonsense(f"inverse returned the arm angles {list(result.arm_angles)}; they must be finite")
    wanted = options.configuration
    if wanted and (others := [name for name in result.configurations if not is_configuration(name, wanted)]):
        raise nonsense(f"inverse returned the configuration {others[0]!r} where {wanted!r} was asked for")
    return result


def _check_numbers(solutions: Floats, chain: SerialChain, options: InverseOptions) -> None:
    """Raise ComponentFault unless solutions (m, k) are finite and, where that is asked for, within limits."""
    _finite("inverse", solutions)
    if options.respect_limits:
        outside = (solutions < chain.lower - _SLACK) | (solutions > chain.upper + _SLACK)
        if outside.any():
            row, column = (int(place[0]) for place in np.nonzero(outside))
            raise nonsense(
                f"inverse returned {chain.joint_names[column]!r} at {solutions[row, column]:.6g}, outside its limits "
                f"{chain.lower[column]:.6g} to {chain.upper[column]:.6g}"
            )


def is_configuration(name: str, wanted: str) -> bool:
    """Return whether a solution's configuration is the one that is wanted; more words may follow, as of full turns."""
    return name == wanted or name.startswith(f"{wanted} ")


def check_solution(reached: Floats, target: Floats, options: InverseOptions) -> None:
    """Raise ComponentFault when a solution's tip, at `reached` (4, 4), is not at the `target` (4, 4) asked for."""
    distance, angle = pose_distance(reached, target)
    if distance > max(options.position_tolerance, CLOSURE) or angle > max(options.rotation_tolerance, CLOSURE):
        raise nonsense(f"inverse returned a solution that misses its target by {distance:.3g} m and {angle:.3g} rad")


def check_solutions(reached: Floats, targets: Floats, options: InverseOptions) -> None:
    """Raise ComponentFault as `check_solution` for tips `reached` (m, 4, 4), each with a target of its own, (m, 4, 4).

    All are looked at together, by the norm of the rotations' difference: it is sqrt(8) times the sine of half the angle
    between them, and loses no digit where that is small. `check_solution` has the last word on what seems wrong.
    """
    apart = np.linalg.norm(reached[:, :3, 3] - targets[:, :3, 3], axis=1)
    turned = np.linalg.norm(reached[:, :3, :3] - targets[:, :3, :3], axis=(1, 2)) / _CHORD
    # Written so that NaN counts as wrong.
    is_right = (apart <= max(options.position_tolerance, CLOSURE)) & (
        turned <= math.sin(min(max(options.rotation_tolerance, CLOSURE), math.pi) / 2.0)
    )
    for row in np.flatnonzero(~is_right).tolist():
        check_solution(reached[row], targets[row], options)


def pose_distance(a: Floats, b: Floats) -> tuple[float, float]:
    """Return the distance (m) and the angle (rad) between two poses (4, 4)."""
    turn = a[:3, :3].T @ b[:3, :3]
    # From the skew part as well as the trace: the arc cosine of almost 1 loses half of the digits.
    skew = math.hypot(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1])
    return math.dist(a[:3, 3], b[:3, 3]), math.atan2(skew, turn[0, 0] + turn[1, 1] + turn[2, 2] - 1.0)


def checked_beam(value: object) -> Floats:
    """Return a copy of what a sensor model's `beam` answered, (k, 3).

    Raises ComponentFault unless k is from 1 to MOST_BEAM_RAYS and all are unit vectors that go forward.
    """
    beam = _floats("beam", value)
    if beam.ndim != 2 or beam.shape[1] != 3 or not 1 <= len(beam) <= MOST_BEAM_RAYS:
        raise nonsense(f"beam returned shape {beam.shape}; it must be (k, 3) with k from 1 to {MOST_BEAM_RAYS}")
    _finite("beam", beam)
    lengths = np.linalg.norm(beam, axis=1)
    wrong = (np.abs(lengths - 1.0) > RIGID) | (beam[:, 0] <= 0.0)
    if wrong.any():
        i = int(wrong.argmax())
        right = "unit length" if abs(lengths[i] - 1.0) > RIGID else "x above 0: the beam is along x"
        raise nonsense(f"beam returned ray {i} as {beam[i].tolist()}; it must have {right}")
    return beam


def checked_readings(value: object, count: int) -> Readings:
    """Return a copy of what a sensor model's `apply` answered for `count` beams.

    Raises ComponentFault for another type or shape, a distance that is NaN or below 0, a valid one that is not finite,
    or an intensity that is not from 0 to 1.
    """
    if not isinstance(value, Readings):
        raise nonsense(f"apply returned {_kind(value)}; it must be Readings")
    distance, intensity = _floats("apply", value.distance), _floats("apply", value.intensity)
    valid = value.valid
    if not isinstance(valid, np.ndarray) or valid.dtype != np.bool_:
        raise nonsense(f"apply returned {_kind(valid)} as valid; it must be an array of bool")
    for name, array in (("distance", distance), ("intensity", intensity), ("valid", valid)):
        if array.shape != (count,):
            raise nonsense(f"apply returned {name} of shape {array.shape}; it must be ({count},), one for each beam")
    valid = np.array(valid, dtype=np.bool_)
    # Written so that NaN, which compares as false, counts as wrong.
    for what, wrong in (
        ("a distance that is NaN or negative", ~(distance >= 0.0)),
        ("a valid distance that is not finite", valid & np.isinf(distance)),
        ("an intensity that is not from 0 to 1", ~((intensity >= 0.0) & (intensity <= 1.0))),
    ):
        if wrong.any():
            i = int(wrong.argmax())
            said = f"{distance[i]} m, intensity {intensity[i]}, valid {valid[i]}"
            raise nonsense(f"apply returned {what}: beam {i} reads {said}")
    return Readings(distance, intensity, valid)


def nonsense(reason: str) -> ComponentFault:
    """Return the fault of a component whose answer makes no sense."""
    return ComponentFault(FaultKind.NONSENSE, reason)


_EYE = np.eye(3)
_CHORD = math.sqrt(8.0)
_SLACK = 1e-9
"""Room for the last digits where a solution lies on a limit (rad, m)."""


def _floats(method: str, value: object) -> Floats:
    if not isinstance(value, np.ndarray) or value.dtype != np.float64:
        raise nonsense(f"{method} returned {_kind(value)}; it must be a float64 array")
    # A copy, plain and in C order: the component may use its buffer again, and subclasses count in ways of their own.
    return np.array(value, dtype=np.float64, order="C")


def _number(what: str, value: object) -> float:
    if not isinstance(value, Real):
        raise nonsense(f"inverse returned {_kind(value)} as {what}; it must be a number")
    if math.isnan(value):
        raise nonsense(f"inverse returned nan as {what}; it must be a number")
    return float(value)


def _text(what: str, value: object, method: str = "inverse") -> str:
    if not isinstance(value, str):
        raise nonsense(f"{method} returned {_kind(value)} as {what}; it must be text")
    # Half of a surrogate pair cannot be sent to anybody.
    return value[:LONGEST_TEXT].encode("utf-8", "backslashreplace").decode()


def _finite(method: str, array: Floats) -> None:
    # A sum of numbers that are not all finite is not finite either; the slow look tells an overflow.
    if not math.isfinite(array.sum()) and not np.isfinite(array).all():
        place = tuple(int(i[0]) for i in np.nonzero(~np.isfinite(array)))
        raise nonsense(f"{method} returned {array[place]} at {list(place)}; all values must be finite")


def _kind(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype}"
    return "None" if value is None else f"a {type(value).__name__}"
