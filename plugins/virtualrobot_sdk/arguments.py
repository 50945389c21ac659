"""Checks of what callers give to kinematics components: each refusal names the bad value and what would be right."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.kinematics.component import Floats, InverseOptions
from virtualrobot_kernel.numeric.rigid import orthonormalise

RIGIDITY = 1e-4
"""How far a target may be from a rigid transform, as `orthonormalise` measures it: room for five written digits."""


def joint_vector(value: ArrayLike, joint_names: tuple[str, ...], what: str = "q") -> Floats:
    """Return `value` as a contiguous float64 array (k,); raise KernelError for a wrong shape or a value not finite."""
    q = np.ascontiguousarray(value, dtype=np.float64)
    k = len(joint_names)
    if q.shape != (k,):
        raise KernelError(
            f"{what} has shape {q.shape}; it needs {k} values, for {', '.join(joint_names)}", shape=q.shape, needed=k
        )
    # A sum of numbers that are not all finite is not finite either; the slow look tells an overflow.
    if not math.isfinite(q.sum()) and not np.isfinite(q).all():
        i = int(np.flatnonzero(~np.isfinite(q))[0])
        raise KernelError(
            f"{what} of joint {joint_names[i]!r} is {q[i]}; it must be a finite number",
            joint=joint_names[i],
            value=q[i],
        )
    return q


def rigid_target(value: ArrayLike) -> Floats:
    """Return `value` as a rigid transform (4, 4), its rotation made exactly orthonormal.

    Raises KernelError when an entry is not finite, the last row is not 0 0 0 1 or the rest is no rotation.
    """
    target = np.array(value, dtype=np.float64, order="C")
    if target.shape != (4, 4):
        raise KernelError(f"the target pose has shape {target.shape}; it must be (4, 4)", shape=target.shape)
    off = orthonormalise(target)
    if off <= RIGIDITY:
        return target
    if not np.isfinite(target).all():
        row, column = (int(i[0]) for i in np.nonzero(~np.isfinite(target)))
        raise KernelError(
            f"the target pose has {target[row, column]} in row {row}, column {column}; all entries must be finite",
            row=row,
            column=column,
            value=target[row, column],
        )
    said = f"is off by {off:.3g} (at most {RIGIDITY})" if np.isfinite(off) else "is a reflection"
    raise KernelError(f"the target pose is no rigid transform: it {said}; it is {target.tolist()}", off=off)


def check_options(options: InverseOptions) -> None:
    """Raise KernelError when a tolerance is not positive or a count is negative."""
    if not 0.0 < options.position_tolerance < math.inf:
        raise _refused("position_tolerance", options.position_tolerance, "a positive number")
    if not 0.0 < options.rotation_tolerance < math.inf:
        raise _refused("rotation_tolerance", options.rotation_tolerance, "a positive number")
    if options.max_restarts < 0:
        raise _refused("max_restarts", options.max_restarts, "0 or more")
    if options.random_seed < 0:
        raise _refused("random_seed", options.random_seed, "0 or more")


def _refused(option: str, value: float, right: str) -> KernelError:
    return KernelError(f"{option} is {value}; it must be {right}", option=option, value=value)
