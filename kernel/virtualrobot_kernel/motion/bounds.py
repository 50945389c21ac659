"""Bounds of a time law on parts of a path, beside the joints' own limits, and the kinds of time laws."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.motion.polynomial import Array


class TimeLaw(Enum):
    """Kind of time law along a path; the names equal those of the contract."""

    #: Keeps the limits of speed, acceleration and jerk.
    JERK_LIMITED = "JERK_LIMITED"
    #: The fastest that keeps the limits of speed and acceleration; the jerk has no limit.
    TIME_OPTIMAL = "TIME_OPTIMAL"


@dataclass(frozen=True, eq=False)
class JointBound:
    """Bound of the joints on the parameters [begin, end] of a path.

    share: (k,) in (0, 1] of their velocity limits, or (3, k) of those of velocity, acceleration and jerk.
    """

    begin: float
    end: float
    share: Array


class TcpJacobian(Protocol):
    """Geometric Jacobian of a tool centre point by k joints."""

    def jacobian(self, q: Array) -> Array:
        """Return the geometric Jacobian (6, k) of the TCP at q (k,), linear rows first."""
        ...


@dataclass(frozen=True, eq=False)
class TcpBound:
    """Cartesian bound on the parameters [begin, end] of a path, for the TCP that the joints `columns` of it move.

    The limits are those of the vectors' lengths, for position and rotation each: velocity, acceleration (centripetal
    part included) and jerk.
    """

    begin: float
    end: float
    columns: slice | NDArray[np.intp]
    tcp: TcpJacobian
    limits: CartesianLimits
