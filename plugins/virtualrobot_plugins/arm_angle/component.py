"""The kinematics component `arm_angle`: every branch of a seven-axis arm for each place of its elbow, named."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot_sdk.arguments import joint_vector, rigid_target
from virtualrobot_sdk.compiled.rigid import orthonormalise
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult, InverseStatus, SerialChain

from virtualrobot_plugins.arm_angle.angles import all_branches, arm_angle_of
from virtualrobot_plugins.arm_angle.geometry import arm_of, model_of
from virtualrobot_plugins.arm_angle.intervals import meetings_of, ranges_between_limits
from virtualrobot_plugins.chain.serial import reach_bound
from virtualrobot_plugins.closed_form.branch_kinematics import DEFAULTS, POLISHED, BranchKinematics
from virtualrobot_plugins.closed_form.branches import Asked, Found
from virtualrobot_plugins.closed_form.names import NAMELESS
from virtualrobot_plugins.closed_form.singularities import ELBOW, LOOSE, SHOULDER, WRIST

MARGIN = math.radians(0.5)
"""Least distance of an arm angle from the ends of its range (rad); a quarter of the range where that is less."""
SCHEME = NAMELESS._replace(words=(("shoulder+", "shoulder-"), ("elbow+", "elbow-"), ("wrist+", "wrist-")))
_TRIALS = 8
_NEXT = 1e-3
_SINGULAR = {
    SHOULDER: "the shoulder (joints 1 and 3 turn about one line)",
    ELBOW: "the elbow (the arm is stretched or folded)",
    WRIST: "the wrist (joints 5 and 7 turn about one line)",
}


class ArmAngleKinematics(BranchKinematics):
    """All postures at once, exact and named, of arms of seven turning joints by the angle of their elbow.

    Needs a spherical shoulder and a spherical wrist, as the KUKA LBR iiwa has. The arm angle is where the elbow is
    about the line from shoulder to wrist; for each there are up to eight branches.
    """

    def __init__(self, chain: SerialChain) -> None:
        """Take the arm's geometry, and try it.

        Raises ArgumentError when the arm has not seven turning joints, or shoulder or wrist are not spherical.
        """
        self._arm, axes = arm_of(chain)
        super().__init__(chain)
        self._meetings = meetings_of(self._arm, *self._limits)
        self._use(SCHEME, model_of(chain, axes, self._arm, reach_bound(chain)[1]))
        if not self._finds_again():
            raise ArgumentError("the arm has an arm angle, but postures of it are missed")
        self._make_room()

    def arm_angle(self, q: ArrayLike, /) -> float:
        """Return the arm angle of a posture (7,) in rad, -pi to pi."""
        return arm_angle_of(self._arm, joint_vector(q, self._names_of_joints))

    def inverse(self, base_t_tip: ArrayLike, options: InverseOptions = DEFAULTS, /) -> InverseResult:
        """Return all postures that put the tip at `base_t_tip` (4, 4) at one arm angle, to 1e-10 (m, rad).

        The arm angle is the one that is asked for, else that of the seed (of the middle of all ranges without one),
        else the one nearest to it where a posture is within limits; with a seed, and no arm angle asked for, branches
        that are within limits at others only come at the nearest of these. Each branch comes with all its turned
        variants; nearest to the seed first, or without a seed by branch and turns. Where two joints turn about one line
        the former stands as in the seed, and `reason` names the singularity.

        Raises ArgumentError when the target is no finite rigid transform, an option makes no sense, or there is no such
        configuration.
        """
        target = rigid_target(base_t_tip, orthonormalise)
        asked = self._asked(target, options, has_arm_angle=True)
        wanted = options.arm_angle
        arm_angle = arm_angle_of(self._arm, asked[2]) if wanted is None else math.remainder(wanted, 2.0 * math.pi)
        result, found = self._at(arm_angle, asked, options)
        swings = wanted is None and options.seed is not None and options.respect_limits and not options.configuration
        if len(result.solutions):
            return self._with_other_branches(result, arm_angle, asked, options) if swings else result
        reasons = [result.reason]
        if found[1] and options.respect_limits:
            ranges = self._ranges(asked, options)
            if wanted is None:
                for other in _nearest(ranges, arm_angle):
                    nearest, _ = self._at(other, asked, options)
                    if len(nearest.solutions):
                        return self._with_other_branches(nearest, arm_angle, asked, options) if swings else nearest
            reasons = [_said_of_angles(arm_angle, ranges), *reasons]
            options = replace(options, arm_angle=arm_angle)
        return self._none(target, options, found[1], found[4:], reasons)

    def _at(self, arm_angle: float, asked: Asked, options: InverseOptions) -> tuple[InverseResult, Found]:
        """Return the postures at one arm angle, and what became of its angles; without any the singularity's words."""
        target, _, seed = asked[:3]
        angles, _, miss = all_branches(self._arm, target, arm_angle, seed)
        if miss:
            empty = np.empty((0, len(seed)))
            return InverseResult(InverseStatus.UNREACHABLE, empty), (0, 0, 0, 0, miss, 0.0)
        found, solutions, codes = self._found(angles, asked)
        polish = found[2] != 0
        if polish:
            starts = [*np.ascontiguousarray(angles.T)] if found[2] & LOOSE else []
            # Near a singularity the pose hardly tells some joints: where the arm stands is a solution all the same.
            starts += [seed] if options.arm_angle is None else []
            found, solutions, codes = self._found(np.hstack([angles, *self._polished(target, starts)]), asked)
        solutions, names = self._named(solutions, codes, options.configuration)
        reason = _said_of(found[2]) if found[2] else ""
        status = InverseStatus.SOLVED if names else InverseStatus.OUTSIDE_LIMITS
        told = tuple(arm_angle_of(self._arm, q) for q in solutions) if polish else (arm_angle,) * len(names)
        return InverseResult(status, solutions, names, *found[4:], reason=reason, arm_angles=told), found

    def _with_other_branches(
        self, result: InverseResult, arm_angle: float, asked: Asked, options: InverseOptions
    ) -> InverseResult:
        """Return a result with the branches that are within limits at other arm angles only, each at the nearest.

        Else an arm would go to a branch far away where a small swing of the elbow lets it have one close by.
        """
        missing = [
            branch for branch in self._branch_names if not any(self._is(name, branch) for name in result.configurations)
        ]
        ranges: dict[str, list[tuple[float, float]]] = {branch: [] for branch in missing}
        for begin, end in ranges_between_limits(self._arm, self._meetings, asked[0]) if missing else ():
            middle = math.remainder((begin + end) / 2.0, 2.0 * math.pi)
            # A branch's name is three words; those of turns follow.
            names = self._at(middle, asked, options)[0].configurations
            for branch in {" ".join(name.split(" ", 3)[:3]) for name in names}:
                if branch in ranges:
                    ranges[branch].append((begin, end))
        found = [result]
        for branch in missing:
            only = replace(options, configuration=branch)
            own = (self._at(other, asked, only)[0] for other in _nearest(_joined(ranges[branch]), arm_angle))
            found += [one for one in [next((one for one in own if len(one.solutions)), None)] if one is not None]
        solutions = np.vstack([one.solutions for one in found])
        names = [name for one in found for name in one.configurations]
        angles = [angle for one in found for angle in one.arm_angles]
        order = np.argsort(((solutions - asked[2]) ** 2).sum(axis=1), kind="stable")
        return result._replace(
            solutions=solutions[order],
            configurations=tuple(names[i] for i in order),
            arm_angles=tuple(angles[i] for i in order),
            position_error=max(one.position_error for one in found),
            rotation_error=max(one.rotation_error for one in found),
        )

    def _polished(self, target: Floats, starts: Sequence[Floats]) -> Iterator[Floats]:
        """Yield the postures (7, 1) at the target that are next to those given (7,): models round their numbers."""
        for start in starts:
            end = self._chain.refined(target, start)
            if end is not None and np.abs(end - start).max() < _NEXT:
                yield end[:, None]

    def _ranges(self, asked: Asked, options: InverseOptions) -> list[tuple[float, float]]:
        """Return the ranges of arm angles (rad) with a posture within limits and of the configuration asked for."""
        ranges: list[tuple[float, float]] = []
        for begin, end in ranges_between_limits(self._arm, self._meetings, asked[0]):
            middle = math.remainder((begin + end) / 2.0, 2.0 * math.pi)
            if len(self._at(middle, asked, options)[0].solutions):
                ranges.append((begin, end))
        return _joined(ranges)

    def _finds_again(self) -> bool:
        """Return whether random postures are found again from their poses, each under a name of its own."""
        rng = np.random.default_rng(_TRIALS)
        for _ in range(_TRIALS):
            q = rng.uniform(-np.pi, np.pi, len(self._names_of_joints))
            asked = self._chain.forward(q)[-1], self._free, q, True, POLISHED, POLISHED
            result, found = self._at(arm_angle_of(self._arm, q), asked, DEFAULTS)
            if found[3] or not len(result.solutions) or np.abs(result.solutions[0] - q).max() > 1e-5:
                return False
        return True


def _joined(ranges: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return ranges, those that touch as one."""
    joined: list[tuple[float, float]] = []
    for begin, end in ranges:
        first = joined.pop()[0] if joined and begin - joined[-1][1] < 1e-9 else begin
        joined.append((first, end))
    return joined


def _nearest(ranges: Sequence[tuple[float, float]], arm_angle: float) -> Iterator[float]:
    """Yield an arm angle inside each range, the nearest to a given one first."""
    inside: list[float] = []
    for begin, end in ranges:
        margin = min(MARGIN, (end - begin) / 4.0)
        middle = (begin + end) / 2.0
        near = arm_angle + 2.0 * math.pi * round((middle - arm_angle) / (2.0 * math.pi))
        inside.append(math.remainder(min(max(near, begin + margin), end - margin), 2.0 * math.pi))
    yield from sorted(inside, key=lambda one: abs(math.remainder(one - arm_angle, 2.0 * math.pi)))


def _said_of_angles(arm_angle: float, ranges: Sequence[tuple[float, float]]) -> str:
    said = ", ".join(f"{begin:.4f} to {end:.4f}" for begin, end in ranges) or "none"
    return f"so at the arm angle {arm_angle:.4f} rad; arm angles within limits: {said}"


def _said_of(flags: int) -> str:
    singular = [words for flag, words in _SINGULAR.items() if flags & flag]
    return f"the pose is singular at {' and '.join(singular)}" if singular else ""
