"""The kinematics component `chain`: any serial chain of revolute and prismatic joints, solved numerically."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot_sdk.arguments import check_options, joint_vector, rigid_target
from virtualrobot_sdk.compiled.cache import make_ready
from virtualrobot_sdk.compiled.rigid import orthonormalise
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult, InverseStatus, SerialChain

from virtualrobot_plugins.chain.inverse import SearchOutcome, SearchSpace, search, search_space
from virtualrobot_plugins.chain.serial import chain_frames, chain_jacobian, reach_bound

_DEFAULTS = InverseOptions()
_REFINED = 1e-10
_FREE_STARTS = 20
"""Starts without limits that tell a pose outside limits from one out of reach."""


class ChainKinematics:
    """Any chain of revolute and prismatic joints, solved numerically: one solution, the one that the seed leads to.

    Where the seed leads to none, it is the first that a random start leads to; its configurations have no names. Its
    frames are one for each joint, after the joint's own motion, and the tip. Immutable; computes without the GIL.
    """

    def __init__(self, chain: SerialChain) -> None:
        """Keep the chain.

        Raises ArgumentError when the chain has no joint, names and limits differ in number, or limits are swapped.
        """
        joint_names = chain.joint_names
        k = len(joint_names)
        if k == 0 or len(chain.pre) == 0:
            raise ArgumentError("a kinematic chain needs at least one joint that moves")
        if chain.lower.shape != (k,) or chain.upper.shape != (k,):
            raise ArgumentError(
                f"a chain of joints {', '.join(joint_names)} needs {k} lower and upper limits, "
                f"not {chain.lower.size} and {chain.upper.size}"
            )
        if not (chain.lower <= chain.upper).all():
            i = int(np.flatnonzero(~(chain.lower <= chain.upper))[0])
            raise ArgumentError(
                f"joint {joint_names[i]!r} has lower limit {chain.lower[i]} above its upper limit {chain.upper[i]}",
                joint=joint_names[i],
                lower=chain.lower[i],
                upper=chain.upper[i],
            )
        make_ready()
        for array in chain[:9]:
            array.setflags(write=False)
        self._chain = chain
        self._joint_names = joint_names
        self._within = search_space(chain)
        self._free = search_space(chain, respect_limits=False)
        self._middle = (self._within.draw_lower + self._within.draw_upper) / 2.0
        centre, self._reach = reach_bound(chain)
        self._centre = tuple(centre.tolist())

    @property
    def chain(self) -> SerialChain:
        """Return the chain."""
        return self._chain

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Return the names of the k independent joints."""
        return self._joint_names

    @property
    def lower(self) -> Floats:
        """Return the lower limits (k,) in radians and metres; -inf without."""
        return self._chain.lower

    @property
    def upper(self) -> Floats:
        """Return the upper limits (k,) in radians and metres; inf without."""
        return self._chain.upper

    @property
    def middle(self) -> Floats:
        """Return the posture (k,) in the middle of all ranges, where solving starts without a seed."""
        return self._middle

    def forward(self, q: ArrayLike, /) -> Floats:
        """Return the poses (n + 1, 4, 4) of the joints' frames and of the tip in the base frame, at q (k,)."""
        return chain_frames(self._chain, joint_vector(q, self._joint_names))

    def jacobian(self, q: ArrayLike, /) -> Floats:
        """Return the geometric Jacobian (6, k) of the tip at q (k,): linear rows first, in the base frame."""
        return chain_jacobian(self._chain, joint_vector(q, self._joint_names))

    def inverse(self, base_t_tip: ArrayLike, options: InverseOptions = _DEFAULTS, /) -> InverseResult:
        """Return a posture that puts the tip at `base_t_tip` (4, 4), polished to 1e-10 (m, rad) where possible.

        It counts as solved when it is within the tolerances of `options`. Raises ArgumentError when the target is no
        finite rigid transform, or when an option makes no sense.
        """
        target = rigid_target(base_t_tip, orthonormalise)
        if options is _DEFAULTS:
            seed = self._middle
        else:
            check_options(options)
            if options.configuration:
                raise ArgumentError(
                    f"the configuration {options.configuration!r} cannot be told: this component names none; without "
                    "a configuration the branch nearest to the seed is taken, of a move the one nearest to its start",
                    configuration=options.configuration,
                )
            seed = self._middle if options.seed is None else joint_vector(options.seed, self._joint_names, "the seed")
        distance = math.dist(target[:3, 3], self._centre)
        if distance > self._reach + options.position_tolerance:
            return self._too_far(distance)
        space = self._within if options.respect_limits else self._free
        outcome, q = self._search(space, target, seed, options, 1 + options.max_restarts)
        if outcome.solved:
            return InverseResult(InverseStatus.SOLVED, q[None], ("",), *_numbers(outcome))
        limits = "within limits" if options.respect_limits else "without regard to limits"
        reason = (
            f"no solution {limits} after {outcome.starts} starts; the best was off by "
            f"{outcome.position_error * 1e3:.3g} mm and {np.degrees(outcome.rotation_error):.3g} degrees"
        )
        if options.respect_limits:
            free, q = self._search(self._free, target, seed, options, _FREE_STARTS)
            if free.solved:
                broken = f"{reason}; outside limits it is reached, for instance with {self._broken_limits(q)}"
                return self._failure(InverseStatus.OUTSIDE_LIMITS, outcome, broken)
        return self._failure(InverseStatus.UNREACHABLE, outcome, reason)

    def refined(self, base_t_tip: Floats, q: Floats, within: bool = False) -> Floats | None:
        """Return the posture (k,) that q (k,) leads to in one descent, its tip at `base_t_tip` (4, 4) up to 1e-10.

        None where the descent ends elsewhere. With `within` it stays within limits. Neither argument is checked.
        """
        space = self._within if within else self._free
        outcome, refined = search(self._chain, space, base_t_tip, q, 1, _REFINED, _REFINED, 0)
        return refined if outcome.solved else None

    def _search(
        self, space: SearchSpace, target: Floats, seed: Floats, options: InverseOptions, starts: int
    ) -> tuple[SearchOutcome, Floats]:
        tolerances = options.position_tolerance, options.rotation_tolerance
        return search(self._chain, space, target, seed, starts, *tolerances, options.random_seed)

    def _too_far(self, distance: float) -> InverseResult:
        x, y, z = self._centre
        reason = (
            f"the target is {distance:.4f} m from the first joint, farther than all links together reach, "
            f"{self._reach:.4f} m; the first joint is at ({x:.4f}, {y:.4f}, {z:.4f}) in the robot's base frame"
        )
        empty = np.empty((0, len(self._joint_names)))
        # How far the best attempt would be off is known only from below.
        return InverseResult(InverseStatus.UNREACHABLE, empty, (), distance - self._reach, np.inf, 0, 0, reason)

    def _failure(self, status: InverseStatus, outcome: SearchOutcome, reason: str) -> InverseResult:
        empty = np.empty((0, len(self._joint_names)))
        return InverseResult(status, empty, (), *_numbers(outcome), reason)

    def _broken_limits(self, q: Floats) -> str:
        """Name each joint of q that is outside its limits, with value and limits."""
        outside = np.flatnonzero((q < self.lower) | (q > self.upper))
        return ", ".join(
            f"{self._joint_names[i]!r} at {q[i]:.4f} ({self.lower[i]:.4f} to {self.upper[i]:.4f})" for i in outside
        )


def _numbers(outcome: SearchOutcome) -> tuple[float, float, int, int]:
    return outcome.position_error, outcome.rotation_error, outcome.starts, outcome.steps
