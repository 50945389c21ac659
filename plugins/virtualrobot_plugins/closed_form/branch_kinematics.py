"""Base of the components that know all branches of an arm: names, limits, turns, reasons for no solution."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot_sdk.arguments import check_options, joint_vector
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult, InverseStatus, SerialChain

from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_plugins.closed_form.branches import MOST_BRANCHES, Asked, Codes, Found, decoded, find, most_turns
from virtualrobot_plugins.closed_form.model import Model
from virtualrobot_plugins.closed_form.names import Scheme, branch_names, check_configuration, turn_words

POLISHED = 1e-10
"""Largest error of a solution's tip from its target (m, rad), unless tighter tolerances are asked for."""
DEFAULTS = InverseOptions()
_TOLERANCES = POLISHED, POLISHED
_FEW = 1024
"""Room for solutions that a call makes at first."""


class BranchKinematics(ABC):
    """An arm whose branches are known all at once; how, its components say."""

    def __init__(self, chain: SerialChain) -> None:
        """Keep the chain; `_use` is to follow."""
        self._chain = ChainKinematics(chain)
        self._names_of_joints = chain.joint_names
        n = len(chain.joint_names)
        self._limits = np.stack([chain.lower, chain.upper])
        self._free = np.stack([np.full(n, -np.inf), np.full(n, np.inf)])
        self._middle = self._chain.middle
        self._room = self._most = MOST_BRANCHES

    def _use(self, scheme: Scheme, model: Model) -> None:
        """Tell branches apart by this scheme."""
        self._scheme, self._model = scheme, model
        self._branch_names = branch_names(scheme)
        # Poses mostly have the branches that others had before.
        self._name_of = lru_cache(_FEW)(self._make_name)
        self._names_of = lru_cache(_FEW)(self._make_names)

    def _make_room(self) -> None:
        """Make room for all turned variants that limits allow."""
        branches = len(self._branch_names) if self._scheme.words else MOST_BRANCHES
        self._most = branches * most_turns(*self._limits)
        self._room = min(self._most, _FEW)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Return the names of the k joints."""
        return self._names_of_joints

    @property
    def configurations(self) -> tuple[str, ...]:
        """Return the names of the branches, in the order in which they come without a seed; empty without names."""
        return self._branch_names if self._scheme.words else ()

    def forward(self, q: ArrayLike, /) -> Floats:
        """Return the poses (k + 1, 4, 4) of the joints' frames and of the tip in the base frame, at q (k,)."""
        return self._chain.forward(q)

    def jacobian(self, q: ArrayLike, /) -> Floats:
        """Return the geometric Jacobian (6, k) of the tip at q (k,): linear rows first, in the base frame."""
        return self._chain.jacobian(q)

    def configuration(self, q: ArrayLike, /) -> str:
        """Return the name of the branch that q (k,) is in, with its full turns."""
        posture = joint_vector(q, self._names_of_joints)
        asked = self._chain.forward(posture)[-1], self._free, posture, True, POLISHED, POLISHED
        return self._name_of(int(find(posture[:, None], self._model, asked, 1)[2][0]))

    @abstractmethod
    def inverse(self, base_t_tip: ArrayLike, options: InverseOptions = DEFAULTS, /) -> InverseResult:
        """Return all postures that put the tip at `base_t_tip` (4, 4), or the reason why there is none."""

    def _asked(self, target: Floats, options: InverseOptions, has_arm_angle: bool = False) -> Asked:
        """Return what is asked of a target; raise ArgumentError when an option makes no sense."""
        if options is DEFAULTS:
            return target, self._limits, self._middle, False, *_TOLERANCES
        check_options(options, has_arm_angle)
        if options.configuration:
            check_configuration(options.configuration, self._scheme, self._names_of_joints)
        tolerances = _TOLERANCES
        if min(options.position_tolerance, options.rotation_tolerance) < POLISHED:
            tolerances = min(options.position_tolerance, POLISHED), min(options.rotation_tolerance, POLISHED)
        limits = self._limits if options.respect_limits else self._free
        if options.seed is None:
            return target, limits, self._middle, False, *tolerances
        return target, limits, joint_vector(options.seed, self._names_of_joints, "the seed"), True, *tolerances

    def _found(self, angles: Floats, asked: Asked) -> tuple[Found, Floats, Codes]:
        """Return what angles (k, branches) come to."""
        answer = find(angles, self._model, asked, self._room)
        if answer[0][0] == self._room < self._most:
            return find(angles, self._model, asked, self._most)
        return answer

    def _named(self, solutions: Floats, codes: Codes, configuration: str) -> tuple[Floats, tuple[str, ...]]:
        """Return solutions with their names; only those of one configuration where it is asked for."""
        names = self._names_of(codes.tobytes())
        if not configuration:
            return solutions, names
        wanted = [i for i, name in enumerate(names) if self._is(name, configuration)]
        return solutions[wanted], tuple(names[i] for i in wanted)

    def _make_names(self, codes: bytes) -> tuple[str, ...]:
        return tuple([self._name_of(code) for code in np.frombuffer(codes, np.int64).tolist()])

    def _make_name(self, code: int) -> str:
        if not self._scheme.words:
            return ""
        number, turns = decoded(code, len(self._names_of_joints))
        return self._branch_names[number] + turn_words(self._names_of_joints, turns)

    def _is(self, name: str, configuration: str) -> bool:
        """Return whether a solution's name is the configuration; one that names no turns is that of a whole branch."""
        return name == configuration or (configuration in self._branch_names and name.startswith(f"{configuration} "))

    def _none(
        self,
        target: Floats,
        options: InverseOptions,
        branches: int,
        errors: tuple[float, float],
        reasons: Sequence[str],
    ) -> InverseResult:
        """Return the answer where no posture is exact, within limits and of the configuration that is asked for.

        `errors` are those of the nearest attempt (m, rad); `reasons` follow the reason that is found here.
        """
        loose = max(options.position_tolerance, options.rotation_tolerance) > DEFAULTS.position_tolerance
        if not branches and loose and not options.configuration and options.arm_angle is None:
            return self._chain.inverse(target, options)
        empty = np.empty((0, len(self._names_of_joints)))
        status = InverseStatus.OUTSIDE_LIMITS
        if not branches:
            status = InverseStatus.UNREACHABLE
            reason = "no posture reaches the pose, with or without limits"
            if math.isfinite(sum(errors)):
                apart, turned = (_plain(round(one, 6)) for one in (errors[0] * 1e3, math.degrees(errors[1])))
                reason += f"; the nearest is off by {apart} mm and {turned} degrees"
            return InverseResult(status, empty, (), *errors, reason=joined(reason, *reasons))
        free = self.inverse(target, replace(options, respect_limits=False, configuration=""))
        broken = [self._broken(q) for q in free.solutions]
        if not options.configuration:
            reason = f"{len(free.solutions)} postures reach the pose, all outside limits, for instance with {broken[0]}"
            return InverseResult(status, empty, (), *errors, reason=joined(reason, *reasons))
        reached = dict(zip(free.configurations, broken, strict=True))
        listed = ", ".join(f"{name!r}" + (f" ({why})" if why else "") for name, why in reached.items())
        reason = f"no posture within limits reaches the pose in the configuration {options.configuration!r}; others: "
        if not any(self._is(name, options.configuration) for name in reached):
            status = InverseStatus.UNREACHABLE
        return InverseResult(status, empty, (), *errors, reason=joined(reason + listed, *reasons))

    def _broken(self, q: Floats) -> str:
        """Return the first joint of q that is outside its limits, in words; empty when all are within."""
        for name, value, lower, upper in zip(self._names_of_joints, q, *self._limits, strict=True):
            if not lower - 1e-9 <= value <= upper + 1e-9:
                return f"{name} at {value:.4f} rad, outside {lower:.4f} to {upper:.4f}"
        return ""


def joined(*reasons: str) -> str:
    """Return reasons one after the other, without empty ones."""
    return "; ".join(reason for reason in reasons if reason)


def _plain(number: float) -> str:
    """Return a number to three digits, without an exponent."""
    return np.format_float_positional(number, precision=3, unique=False, fractional=False, trim="-")
