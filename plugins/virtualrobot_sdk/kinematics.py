"""Interface of a kinematics component: forward, inverse and Jacobian of one serial chain, on plain arrays."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, NamedTuple, Protocol

import numpy as np

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int32]]
Numbers = np.ndarray[Any, np.dtype[np.int64]]
Codes = np.ndarray[Any, np.dtype[np.int8]]

REVOLUTE = 1
"""A joint that turns about its axis (rad)."""
PRISMATIC = 2
"""A joint that slides along its axis (m)."""


class SerialChain(NamedTuple):
    """A robot from base to tip: n scalar joints in a row with k independent coordinates, in meters and radians.

    Joint i has the value `multiplier[i] * q[q_index[i]] + offset[i]`. Fixed joints are folded into their neighbours.
    """

    pre: Floats
    """(n, 4, 4) pose of each joint's frame at zero, in the frame before it; the first is in the base."""
    axis: Floats
    """(n, 3) unit axis in the joint's own frame."""
    joint_type: Codes
    """(n,) REVOLUTE or PRISMATIC."""
    q_index: Integers
    """(n,) coordinate that moves the joint."""
    multiplier: Floats
    """(n,) 1 except for a mimic joint."""
    offset: Floats
    """(n,) 0 except for a mimic joint."""
    post: Floats
    """(4, 4) pose of the tip in the frame of the last joint."""
    lower: Floats
    """(k,) lower limits; -inf without."""
    upper: Floats
    """(k,) upper limits; inf without."""
    joint_names: tuple[str, ...]
    """(k,) names of the independent joints, in the order of every q."""


class InverseStatus(Enum):
    """Outcome of an inverse problem."""

    SOLVED = "SOLVED"
    """There is at least one solution."""
    UNREACHABLE = "UNREACHABLE"
    """No posture that the component could find reaches the pose, with or without limits."""
    OUTSIDE_LIMITS = "OUTSIDE_LIMITS"
    """Postures reach the pose, but all that the component could find break a joint's limits."""


@dataclass(frozen=True, slots=True, eq=False)
class InverseOptions:
    """Options of an inverse problem: seed, limits, tolerances, and the branch that is wanted."""

    seed: Floats | None = None
    """(k,) posture to start from and to stay near, in radians and metres; None: the middle of each joint's range."""
    respect_limits: bool = True
    """True: solutions must lie within joint limits (a prismatic joint's stroke always counts)."""
    max_restarts: int = 2000
    """Most random starts after the seed, for components that search."""
    position_tolerance: float = 1e-9
    """Largest distance of a solution's tip from the target (m)."""
    rotation_tolerance: float = 1e-9
    """Largest angle between a solution's tip and the target (rad)."""
    random_seed: int = 0
    """Seed of the random starts: equal calls give equal answers to the last bit."""
    configuration: str = ""
    """The name of the only configuration that is wanted; empty: any. A component refuses names that it doesn't know."""
    arm_angle: float | None = None
    """The angle of the elbow about the line from shoulder to wrist in rad; None: any. Not all components have one."""


class InverseResult(NamedTuple):
    """Solutions of an inverse problem, if any: a tuple, since making one may cost as much as a solution."""

    status: InverseStatus
    solutions: Floats
    """(m, k) all solutions that the component knows (rad, m), nearest to the seed first; m is 0 if not SOLVED.

    Without a seed a component that knows several may have them in an order of its own, always the same.
    """
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
    """Reason for no solution, in words and numbers; of a solved pose, the singularity that it is at, if any."""
    arm_angles: tuple[float, ...] = ()
    """The arm angle of each solution (rad); empty where the component knows none."""


class InverseMany(NamedTuple):
    """Solutions of n inverse problems, m together."""

    target: Numbers
    """(m,) which pose each is for, ascending."""
    solutions: Floats
    """(m, k) those of a pose in the order of `inverse` (rad, m)."""


class Kinematics(Protocol):
    """The kinematics of one `SerialChain`; poses are 4x4 in its base frame, SI units and radians; q is (k,)."""

    def forward(self, q: Floats, /) -> Floats:
        """Return the poses (m, 4, 4) of the component's frames at q (k,), the last one the tip's: `base_t_frame`.

        Raises ArgumentError when q has the wrong shape or is not finite.
        """
        ...

    def jacobian(self, q: Floats, /) -> Floats:
        """Return the geometric Jacobian (6, k) at the tip, linear rows first, in the base frame.

        Raises ArgumentError when q has the wrong shape or is not finite.
        """
        ...

    def inverse(self, base_t_tip: Floats, options: InverseOptions = ..., /) -> InverseResult:
        """Return the postures that put the tip at `base_t_tip` (4, 4), or the reason why there is none.

        Raises ArgumentError when the target is no finite rigid transform, or when an option makes no sense.
        """
        ...


class KinematicsWithNames(Kinematics, Protocol):
    """The kinematics of a chain whose component tells the configuration of a posture without solving for its pose."""

    def configuration(self, q: Floats, /) -> str:
        """Return the name that `inverse` gives to the posture q (k,) among the solutions of its pose.

        Raises ArgumentError when q has the wrong shape or is not finite.
        """
        ...


class KinematicsOfMany(Kinematics, Protocol):
    """The kinematics of a chain whose component knows the postures of many poses at once, sooner than one by one."""

    def inverse_many(self, base_t_tip: Floats, /) -> InverseMany:
        """Return the postures that put the tip at poses (n, 4, 4): those of `inverse` within limits without a seed.

        Raises ArgumentError when a target is no finite rigid transform.
        """
        ...
