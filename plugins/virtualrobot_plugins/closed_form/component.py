"""The kinematics component `closed_form`: every branch of an arm of up to six turning joints, named."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot_sdk.arguments import rigid_target
from virtualrobot_sdk.compiled.rigid import orthonormalise
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import (
    Floats,
    InverseMany,
    InverseOptions,
    InverseResult,
    InverseStatus,
    SerialChain,
)

from virtualrobot_plugins.chain.serial import reach_bound
from virtualrobot_plugins.closed_form.branch_kinematics import DEFAULTS, POLISHED, BranchKinematics
from virtualrobot_plugins.closed_form.branches import Asked, Codes, Found, find_each
from virtualrobot_plugins.closed_form.geometry import MOST_JOINTS, axes_of, check_joints, idealised, upright_frames
from virtualrobot_plugins.closed_form.library import solver_of
from virtualrobot_plugins.closed_form.model import model_of
from virtualrobot_plugins.closed_form.names import NAMELESS, scheme_of
from virtualrobot_plugins.closed_form.polish import polished
from virtualrobot_plugins.closed_form.singularities import ELBOW, LOOSE, SHOULDER, WRIST

_TRIALS = 24
_AT_ONCE = 256
"""Number of poses whose angles are sorted out together."""
_SINGULAR = {
    SHOULDER: "the shoulder (the wrist's centre is above or below joint 1)",
    ELBOW: "the elbow (the arm is stretched or folded)",
    WRIST: "the wrist (joints 4 and 6 turn about parallel axes)",
}


class ClosedFormKinematics(BranchKinematics):
    """All postures at once, exact and named by shoulder, elbow and wrist: arms of up to six turning joints (EAIK).

    Needs a geometry that has a closed form, as most industrial arms have: three axes that meet or are parallel.
    """

    def __init__(self, chain: SerialChain) -> None:
        """Find the arm's closed form and try it.

        Raises ArgumentError when a joint slides or is coupled, the arm has more than six, the library EAIK is not
        installed, knows no closed form for this geometry, or misses solutions of it.
        """
        check_joints(chain)
        super().__init__(chain)
        axes, is_rounded = idealised(axes_of(chain))
        self._angles = solver_of(axes)
        # EAIK's angles are those of the arm that was meant; each is polished to the arm that there is.
        self._always_polish = is_rounded
        frames, reach = upright_frames(chain), reach_bound(chain)[1]
        for scheme in (scheme_of(axes), NAMELESS):
            self._use(scheme, model_of(frames, axes, scheme, reach))
            if self._finds_again():
                break
        else:
            raise ArgumentError("the library EAIK has a closed form for this arm, but it misses postures of it")
        # Where the target tells whether it is singular, no angles mean that it is out of reach.
        self._flags_tell = len(chain.joint_names) == MOST_JOINTS and bool(self._scheme.words)
        self._make_room()

    def inverse(self, base_t_tip: ArrayLike, options: InverseOptions = DEFAULTS, /) -> InverseResult:
        """Return all postures that put the tip at `base_t_tip` (4, 4), to 1e-10 (m, rad).

        Each branch within limits comes with all its turned variants; nearest to the seed first, or without a seed by
        branch and turns. At a singular pose, which endlessly many postures reach, each branch comes once, near the
        seed, and `reason` names the singularity. Where no posture is exact and `options` has tolerances above 1e-9,
        the numeric search answers. Raises ArgumentError when the target is no finite rigid transform, an option makes
        no sense, or there is no such configuration.
        """
        target = rigid_target(base_t_tip, orthonormalise)
        asked = self._asked(target, options)
        found, solutions, codes = self._found(self._angles(target), asked)
        branches, flags, errors = found[1], found[2], found[4:]
        if self._always_polish or flags or not (branches or self._flags_tell):
            found, solutions, codes = self._looked_again(asked, 0 if self._always_polish else flags)
            branches, flags, after = found[1], found[2], found[4:]
            # Where nothing reaches the pose, the angles that come nearest are still the library's own.
            errors = after if branches else errors
        solutions, names = self._named(solutions, codes, options.configuration)
        reason = _said_of(flags) if flags else ""
        if names:
            return InverseResult(InverseStatus.SOLVED, solutions, names, *errors, 0, 0, reason)
        return self._none(target, options, branches, errors, (reason,))

    def inverse_many(self, base_t_tip: ArrayLike, /) -> InverseMany:
        """Return all postures within limits of poses (n, 4, 4): what `inverse` does without a seed, for each of them.

        Raises ArgumentError when a target is no finite rigid transform.
        """
        poses = np.asarray(base_t_tip)
        found = [self._many(poses[begin : begin + _AT_ONCE]) for begin in range(0, len(poses), _AT_ONCE)]
        counts = np.concatenate([np.zeros(0, np.int64), *(counts for counts, _ in found)])
        solutions = [np.empty((0, len(self._names_of_joints))), *(solutions for _, solutions in found)]
        return InverseMany(np.repeat(np.arange(len(poses)), counts), np.concatenate(solutions))

    def _many(self, poses: Floats) -> tuple[Codes, Floats]:
        """Return how many solutions each of some poses (m, 4, 4) has, (m,), and these one after the other, (k, n)."""
        if self._always_polish:
            alone = np.ones(len(poses), np.bool_)
            counts, solutions = np.zeros(len(poses), np.int64), np.empty((0, len(self._names_of_joints)))
        else:
            targets = np.array([rigid_target(pose, orthonormalise) for pose in poses])
            angles = [self._angles(target) for target in targets]
            arm = self._model, targets, self._limits, self._middle
            told, solutions = find_each(angles, *arm, POLISHED, self._room)
            counts, branches, flags = told.T
            alone = (flags != 0) | ((branches == 0) & (not self._flags_tell))
            alone |= (counts == self._room) & (self._room < self._most)
        if not alone.any():
            return counts, solutions
        each = np.split(solutions, np.cumsum(counts)[:-1])
        for number in np.flatnonzero(alone).tolist():
            each[number] = self.inverse(poses[number]).solutions
        return np.array([len(one) for one in each], np.int64), np.concatenate(each)

    def _looked_again(self, asked: Asked, flags: int) -> tuple[Found, Floats, Codes]:
        """Polish EAIK's angles; where the pose is singular or has none, those of poses close by too, and the seed."""
        near = self._always_polish and not flags
        target, limits, seed = asked[:3]
        candidates = polished(self._chain, self._angles, target, seed, limits, None if near else self._model)
        found, solutions, codes = self._found(candidates, asked)
        count, branches, more, clashes, position_error, rotation_error = found
        # Close to where two branches meet, the arm that was meant may have none, or one for both.
        if near and (more & ~LOOSE or branches < max(1, len(self.configurations))):
            return self._looked_again(asked, more | LOOSE)
        return (count, branches, more | flags & ~LOOSE, clashes, position_error, rotation_error), solutions, codes

    def _finds_again(self) -> bool:
        """Return whether random postures are found again from their poses, each under a name of its own."""
        rng = np.random.default_rng(_TRIALS)
        for _ in range(_TRIALS):
            q = rng.uniform(-np.pi, np.pi, len(self._names_of_joints))
            target = self._chain.forward(q)[-1]
            angles = self._angles(target)
            if self._always_polish:
                angles = polished(self._chain, self._angles, target, q, self._free)
            asked = target, self._free, q, True, POLISHED, POLISHED
            (count, _, _, clashes, *_), solutions, _ = self._found(angles, asked)
            if clashes or not count or np.abs(solutions[0] - q).max() > 1e-5:
                return False
        return True


def _said_of(flags: int) -> str:
    singular = [words for flag, words in _SINGULAR.items() if flags & flag]
    if singular:
        return f"the pose is singular at {' and '.join(singular)}"
    return "the pose is so close to a singular one that a branch is missing" if flags & LOOSE else ""
