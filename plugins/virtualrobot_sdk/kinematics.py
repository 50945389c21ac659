"""What every kinematics component is: names, limits, forward, inverse and Jacobian, on arrays and plain settings."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class InverseStatus(Enum):
    """How solving ended."""

    SOLVED = "SOLVED"
    """There is at least one solution."""
    UNREACHABLE = "UNREACHABLE"
    """No posture that the component could find reaches the pose, with or without limits."""
    OUTSIDE_LIMITS = "OUTSIDE_LIMITS"
    """Postures reach the pose, but all that the component could find break a joint's limits."""


@dataclass(frozen=True, slots=True, eq=False)
class InverseOptions:
    """How to solve."""

    seed: Floats | None = None
    """(k,) posture to start from and to stay near, in radians and metres; None: the middle of each joint's range."""
    respect_limits: bool = True
    """Whether solutions must lie within joint limits (a prismatic joint's stroke always counts)."""
    max_restarts: int = 2000
    """Most random starts after the seed, for components that search."""
    position_tolerance: float = 1e-9
    """Largest distance of a solution's tip from the target (m)."""
    rotation_tolerance: float = 1e-9
    """Largest angle between a solution's tip and the target (rad)."""
    random_seed: int = 0
    """What random starts are drawn by: equal calls give equal answers to the last bit."""


@dataclass(frozen=True, slots=True, eq=False)
class InverseResult:
    """What solving came to."""

    status: InverseStatus
    solutions: Floats
    """(m, k) all solutions that the component knows, in its fixed order (rad, m); m is 0 if not SOLVED."""
    configurations: tuple[str, ...] = ()
    """The name of each solution's configuration; empty strings where the component has no names."""
    position_error: float = 0.0
    """Distance from the target (m): the worst solution's, or the best attempt's where there is none; inf: none made."""
    rotation_error: float = 0.0
    """Angle from the target (rad) of the same posture."""
    starts: int = 0
    """Starts made, the seed's included, for components that search."""
    iterations: int = 0
    """Steps made in all starts."""
    reason: str = ""
    """Why there is no solution, in words and numbers."""


class Kinematics(Protocol):
    """A robot's kinematics, from its base to its tip; poses are 4x4 in the base frame, SI units and radians."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Return the names of the k independent joints, in the order of every q."""
        ...

    @property
    def lower(self) -> Floats:
        """Return the lower joint limits (k,); -inf without."""
        ...

    @property
    def upper(self) -> Floats:
        """Return the upper joint limits (k,); inf without."""
        ...

    def forward(self, q: Floats, /) -> Floats:
        """Return the poses (m, 4, 4) of the component's frames at q (k,), the last one the tip's: `base_t_frame`.

        Raises KernelError when q has the wrong shape or is not finite.
        """
        ...

    def jacobian(self, q: Floats, /) -> Floats:
        """Return the geometric Jacobian (6, k) at the tip, linear rows first, in the base frame.

        Raises KernelError when q has the wrong shape or is not finite.
        """
        ...

    def inverse(self, base_t_tip: Floats, options: InverseOptions = ..., /) -> InverseResult:
        """Return the postures that put the tip at `base_t_tip` (4, 4), or the reason why there is none.

        Raises KernelError when the target is no finite rigid transform, or when an option makes no sense.
        """
        ...
