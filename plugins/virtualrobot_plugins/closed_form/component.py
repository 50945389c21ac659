"""The kinematics component `closed_form`: every branch of an arm of up to six turning joints, named."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot_sdk.arguments import check_options, joint_vector, rigid_target
from virtualrobot_sdk.compiled.rigid import orthonormalise
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult, InverseStatus, SerialChain

from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_plugins.chain.serial import reach_bound
from virtualrobot_plugins.closed_form.branches import (
    ELBOW,
    LOOSE,
    MOST_BRANCHES,
    SHOULDER,
    WRIST,
    Asked,
    Codes,
    Found,
    decoded,
    find,
    most_turns,
)
from virtualrobot_plugins.closed_form.geometry import MOST_JOINTS, axes_of, check_joints, idealised, upright_frames
from virtualrobot_plugins.closed_form.library import solver_of
from virtualrobot_plugins.closed_form.model import model_of
from virtualrobot_plugins.closed_form.names import NAMELESS, branch_names, check_configuration, scheme_of, turn_words
from virtualrobot_plugins.closed_form.polish import polished

POLISHED = 1e-10
"""How far a solution's tip may be from its target (m, rad), unless tighter tolerances are asked for."""
_DEFAULTS = InverseOptions()
_TOLERANCES = POLISHED, POLISHED
_TRIALS = 24
_FEW = 1024
"""Room for solutions that a call makes at first."""
_SINGULAR = {
    SHOULDER: "the shoulder (the wrist's centre is above or below joint 1)",
    ELBOW: "the elbow (the arm is stretched or folded)",
    WRIST: "the wrist (joints 4 and 6 turn about parallel axes)",
}


class ClosedFormKinematics:
    """All postures at once, exact and named by shoulder, elbow and wrist: arms of up to six turning joints (EAIK).

    Needs a geometry that has a closed form, as most industrial arms have: three axes that meet or are parallel.
    """

    def __init__(self, chain: SerialChain) -> None:
        """Find the arm's closed form and try it.

        Raises ArgumentError when a joint slides or is coupled, the arm has more than six, the library EAIK is not
        installed, knows no closed form for this geometry, or misses solutions of it.
        """
        check_joints(chain)
        self._chain = ChainKinematics(chain)
        self._names_of_joints = chain.joint_names
        n = len(chain.joint_names)
        axes, is_rounded = idealised(axes_of(chain))
        self._angles = solver_of(axes)
        # EAIK's angles are those of the arm that was meant; each is polished to the arm that there is.
        self._always_polish = is_rounded
        self._limits = np.stack([chain.lower, chain.upper])
        self._free = np.stack([np.full(n, -np.inf), np.full(n, np.inf)])
        self._room = self._most = MOST_BRANCHES
        self._middle = self._chain.middle
        frames, reach = upright_frames(chain), reach_bound(chain)[1]
        self._scheme = scheme_of(axes)
        self._model = model_of(frames, axes, self._scheme, reach)
        if self._scheme.words and not self._finds_again():
            self._scheme = NAMELESS
            self._model = model_of(frames, axes, NAMELESS, reach)
        if not self._scheme.words and not self._finds_again():
            raise ArgumentError("the library EAIK has a closed form for this arm, but it misses postures of it")
        # Where the target tells whether it is singular, no angles mean that it is out of reach.
        self._flags_tell = n == MOST_JOINTS and bool(self._scheme.words)
        self._branch_names = branch_names(self._scheme)
        branches = len(self._branch_names) if self._scheme.words else MOST_BRANCHES
        self._most = branches * most_turns(chain.lower, chain.upper)
        self._room = min(self._most, _FEW)
        self._configurations: dict[int, str] = {}

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

    def inverse(self, base_t_tip: ArrayLike, options: InverseOptions = _DEFAULTS, /) -> InverseResult:
        """Return all postures that put the tip at `base_t_tip` (4, 4), to 1e-10 (m, rad).

        Each branch within limits comes with all its turned variants; nearest to the seed first, or without a seed by
        branch and turns. At a singular pose, which endlessly many postures reach, each branch comes once, near the
        seed, and `reason` names the singularity. Where no posture is exact and `options` has tolerances above 1e-9,
        the numeric search answers. Raises ArgumentError when the target is no finite rigid transform, an option makes
        no sense, or there is no such configuration.
        """
        target = rigid_target(base_t_tip, orthonormalise)
        seed, limits, sort, tolerances = self._middle, self._limits, False, _TOLERANCES
        if options is not _DEFAULTS:
            check_options(options)
            if options.configuration:
                check_configuration(options.configuration, self._scheme, self._names_of_joints)
            if options.seed is not None:
                seed, sort = joint_vector(options.seed, self._names_of_joints, "the seed"), True
            if not options.respect_limits:
                limits = self._free
            if min(options.position_tolerance, options.rotation_tolerance) < POLISHED:
                tolerances = min(options.position_tolerance, POLISHED), min(options.rotation_tolerance, POLISHED)
        asked = target, limits, seed, sort, *tolerances
        found, solutions, codes = self._found(self._angles(target), asked)
        branches, flags, errors = found[1], found[2], found[4:]
        if self._always_polish or flags or not (branches or self._flags_tell):
            found, solutions, codes = self._looked_again(asked, 0 if self._always_polish else flags)
            branches, flags, after = found[1], found[2], found[4:]
            # Where nothing reaches the pose, the angles that come nearest are still the library's own.
            errors = after if branches else errors
        try:
            names = tuple([self._configurations[code] for code in codes.tolist()])
        except KeyError:
            names = self._names_of(codes)
        reason = _said_of(flags) if flags else ""
        if options.configuration and names:
            wanted = [i for i, name in enumerate(names) if self._is(name, options.configuration)]
            solutions, names = solutions[wanted], tuple(names[i] for i in wanted)
        if names:
            return InverseResult(InverseStatus.SOLVED, solutions, names, *errors, 0, 0, reason)
        return self._none(target, options, branches, errors, reason)

    def _found(self, angles: Floats, asked: Asked) -> tuple[Found, Floats, Codes]:
        """Return what angles (k, branches) come to."""
        answer = find(angles, self._model, asked, self._room)
        if answer[0][0] == self._room < self._most:
            return find(angles, self._model, asked, self._most)
        return answer

    def _looked_again(self, asked: Asked, flags: int) -> tuple[Found, Floats, Codes]:
        """Polish EAIK's angles; where the pose is singular or has none, those of poses close by too, and the seed."""
        near = self._always_polish and not flags
        target, limits, seed = asked[:3]
        candidates = polished(self._chain, self._angles, target, seed, limits, close_by=not near)
        found, solutions, codes = self._found(candidates, asked)
        count, branches, more, clashes, position_error, rotation_error = found
        if near and (more & ~LOOSE or not branches):
            return self._looked_again(asked, more | LOOSE)
        return (count, branches, more | flags & ~LOOSE, clashes, position_error, rotation_error), solutions, codes

    def _names_of(self, codes: Codes) -> tuple[str, ...]:
        """Return the names of solutions by their codes, and keep them."""
        for code in codes.tolist():
            self._configurations.setdefault(code, self._name_of(code))
        return tuple(self._configurations[code] for code in codes.tolist())

    def _name_of(self, code: int) -> str:
        if not self._scheme.words:
            return ""
        number, turns = decoded(code, len(self._names_of_joints))
        return self._branch_names[number] + turn_words(self._names_of_joints, turns)

    def _none(
        self, target: Floats, options: InverseOptions, branches: int, errors: tuple[float, float], singular: str
    ) -> InverseResult:
        """Return the answer where no posture is exact, within limits and of the configuration that is asked for."""
        loose = max(options.position_tolerance, options.rotation_tolerance) > _DEFAULTS.position_tolerance
        if not branches and loose and not options.configuration:
            return self._chain.inverse(target, options)
        empty = np.empty((0, len(self._names_of_joints)))
        if not branches:
            reason = "no posture reaches the pose, with or without limits"
            if math.isfinite(errors[0]):
                reason += f"; the nearest is off by {errors[0] * 1e3:.3g} mm and {np.degrees(errors[1]):.3g} degrees"
            return InverseResult(InverseStatus.UNREACHABLE, empty, (), *errors, reason=_joined(reason, singular))
        free = self.inverse(target, replace(options, respect_limits=False, configuration=""))
        broken = [self._broken(q) for q in free.solutions]
        if not options.configuration:
            reason = f"{len(free.solutions)} postures reach the pose, all outside limits, for instance with {broken[0]}"
            return InverseResult(InverseStatus.OUTSIDE_LIMITS, empty, (), *errors, reason=_joined(reason, singular))
        reached = dict(zip(free.configurations, broken, strict=True))
        listed = ", ".join(f"{name!r}" + (f" ({why})" if why else "") for name, why in reached.items())
        reason = f"no posture within limits reaches the pose in the configuration {options.configuration!r}; others: "
        return InverseResult(
            InverseStatus.OUTSIDE_LIMITS
            if any(self._is(name, options.configuration) for name in reached)
            else InverseStatus.UNREACHABLE,
            empty,
            (),
            *errors,
            reason=_joined(reason + listed, singular),
        )

    def _broken(self, q: Floats) -> str:
        """Return the first joint of q that is outside its limits, in words; empty when all are within."""
        for name, value, lower, upper in zip(self._names_of_joints, q, *self._limits, strict=True):
            if not lower - 1e-9 <= value <= upper + 1e-9:
                return f"{name} at {value:.4f} rad, outside {lower:.4f} to {upper:.4f}"
        return ""

    def _is(self, name: str, configuration: str) -> bool:
        """Return whether a solution's name is the configuration; one that names no turns is that of a whole branch."""
        return name == configuration or (configuration in self._branch_names and name.startswith(f"{configuration} "))

    def _finds_again(self) -> bool:
        """Return whether random postures are found again from their poses, each under a name of its own."""
        rng = np.random.default_rng(_TRIALS)
        for _ in range(_TRIALS):
            q = rng.uniform(-np.pi, np.pi, len(self._names_of_joints))
            target = self._chain.forward(q)[-1]
            angles = self._angles(target)
            if self._always_polish:
                angles = polished(self._chain, self._angles, target, q, self._free, close_by=False)
            (count, _, _, clashes, *_), solutions, _ = self._found(angles, (target, self._free, q, True, *_TOLERANCES))
            if clashes or not count or np.abs(solutions[0] - q).max() > 1e-5:
                return False
        return True


def _said_of(flags: int) -> str:
    singular = [words for flag, words in _SINGULAR.items() if flags & flag]
    if singular:
        return f"the pose is singular at {' and '.join(singular)}"
    return "the pose is so close to a singular one that a branch is missing" if flags & LOOSE else ""


def _joined(*reasons: str) -> str:
    return "; ".join(reason for reason in reasons if reason)

