"""Checks of what callers give to kinematics components: each refusal names the bad value and what would be right."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats, InverseOptions

RIGIDITY = 1e-4
"""Largest error of a target from a rigid transform, as `orthonormalise` measures it: room for five written digits."""


def orthonormalise(pose: Floats) -> float:
    """Make the rotation of `pose` (4, 4) orthonormal in place, and return how far it was from a rigid transform.

    That is the largest entry of R^T R - I and of the last row less 0 0 0 1; inf when an entry is not finite or the
    rotation is a reflection. Two steps R (3 I - R^T R) / 2 (A. Bjorck and C. Bowie, An iterative algorithm for
    computing the best estimate of an orthogonal matrix, SIAM J. Numer. Anal. 8, 1971).
    """
    rotation = pose[:3, :3].copy()
    if not np.isfinite(pose).all() or np.linalg.det(rotation) <= 0.0:
        return math.inf
    off = max(np.abs(rotation.T @ rotation - np.eye(3)).max(), np.abs(pose[3] - (0.0, 0.0, 0.0, 1.0)).max())
    for _ in range(2 if off <= 1e-2 else 0):
        rotation = rotation @ (3.0 * np.eye(3) - rotation.T @ rotation) / 2.0
    pose[:3, :3] = rotation
    return float(off)


def joint_vector(value: ArrayLike, joint_names: tuple[str, ...], what: str = "q") -> Floats:
    """Return `value` as a contiguous float64 array (k,); raise ArgumentError unless it has k finite numbers."""
    q = np.ascontiguousarray(value, dtype=np.float64)
    k = len(joint_names)
    if q.shape != (k,):
        raise ArgumentError(
            f"{what} has shape {q.shape}; it needs {k} values, for {', '.join(joint_names)}", shape=q.shape, needed=k
        )
    # A sum of numbers that are not all finite is not finite either; the slow look tells an overflow.
    if not math.isfinite(q.sum()) and not np.isfinite(q).all():
        i = int(np.flatnonzero(~np.isfinite(q))[0])
        raise ArgumentError(
            f"{what} of joint {joint_names[i]!r} is {q[i]}; it must be a finite number",
            joint=joint_names[i],
            value=q[i],
        )
    return q


def rigid_target(value: ArrayLike, orthonormalise: Callable[[Floats], float] = orthonormalise) -> Floats:
    """Return `value` as a rigid transform (4, 4), its rotation made exactly orthonormal.

    `orthonormalise` may be a faster one than this module's, such as that of `virtualrobot_sdk.compiled.rigid`.

    Raises ArgumentError when an entry is not finite, the last row is not 0 0 0 1 or the rest is no rotation.
    """
    target = np.array(value, dtype=np.float64, order="C")
    if target.shape != (4, 4):
        raise ArgumentError(f"the target pose has shape {target.shape}; it must be (4, 4)", shape=target.shape)
    off = orthonormalise(target)
    if off <= RIGIDITY:
        return target
    if not np.isfinite(target).all():
        row, column = (int(i[0]) for i in np.nonzero(~np.isfinite(target)))
        raise ArgumentError(
            f"the target pose has {target[row, column]} in row {row}, column {column}; all entries must be finite",
            row=row,
            column=column,
            value=target[row, column],
        )
    said = f"is off by {off:.3g} (at most {RIGIDITY})" if np.isfinite(off) else "is a reflection"
    raise ArgumentError(f"the target pose is no rigid transform: it {said}; it is {target.tolist()}", off=off)


def check_options(options: InverseOptions, has_arm_angle: bool = False) -> None:
    """Raise ArgumentError when a tolerance is not positive, a count is negative, or an arm angle makes no sense.

    An arm angle makes sense for components that have one, which they say by `has_arm_angle`.
    """
    if not 0.0 < options.position_tolerance < math.inf:
        raise _refused("position_tolerance", options.position_tolerance, "a positive number")
    if not 0.0 < options.rotation_tolerance < math.inf:
        raise _refused("rotation_tolerance", options.rotation_tolerance, "a positive number")
    if options.max_restarts < 0:
        raise _refused("max_restarts", options.max_restarts, "0 or more")
    if options.random_seed < 0:
        raise _refused("random_seed", options.random_seed, "0 or more")
    if options.arm_angle is not None and not has_arm_angle:
        raise ArgumentError(
            f"the arm angle {options.arm_angle:g} cannot be given: this component knows none; it is for arms of seven "
            "joints with spherical shoulder and wrist, solved by `arm_angle`",
            arm_angle=options.arm_angle,
        )
    if options.arm_angle is not None and not math.isfinite(options.arm_angle):
        raise _refused("arm_angle", options.arm_angle, "a finite number of radians")


def _refused(option: str, value: float, right: str) -> ArgumentError:
    return ArgumentError(f"{option} is {value}; it must be {right}", option=option, value=value)
