"""Kinematics of the kit's SCARA, right and wrong in small ways, for the tests of the test kit."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
from virtualrobot_sdk.arguments import check_options, joint_vector, rigid_target
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult, InverseStatus, SerialChain
from virtualrobot_sdk.reference import chain_frames, tip_pose
from virtualrobot_sdk.selfcheck import finite_differences
from virtualrobot_sdk.testing.chains import scara

UPPER, FORE, HEIGHT = 0.425, 0.375, 0.4
"""The lengths of `virtualrobot_sdk.testing.chains.scara` (m)."""
NAMES = "left", "right"
"""The configurations: where the elbow is."""


class Right:
    """All solutions in closed form."""

    def __init__(self, chain: SerialChain) -> None:
        """Keep the chain."""
        self.chain = chain

    def forward(self, q: Floats, /) -> Floats:
        return chain_frames(self.chain, joint_vector(q, self.chain.joint_names))

    def jacobian(self, q: Floats, /) -> Floats:
        q = joint_vector(q, self.chain.joint_names)
        return finite_differences(lambda values: tip_pose(self.chain, values), q)

    def inverse(self, base_t_tip: Floats, options: InverseOptions, /) -> InverseResult:
        check_options(options)
        target = rigid_target(base_t_tip)
        seed = np.zeros(4) if options.seed is None else joint_vector(options.seed, self.chain.joint_names)
        distance = np.hypot(*target[:2, 3])
        cosine = (distance**2 - UPPER**2 - FORE**2) / (2 * UPPER * FORE)
        if options.configuration not in ("", *NAMES):
            raise ArgumentError(f"there is no {options.configuration!r}; there are left and right")
        if abs(cosine) > 1 + 1e-12 or self.tilt(target) > options.rotation_tolerance:
            return InverseResult(InverseStatus.UNREACHABLE, np.empty((0, 4)), reason="it is too far or tilted")
        found = self.solutions(target, np.arccos(np.clip(cosine, -1.0, 1.0)), seed)
        if not np.ptp(found, axis=0).any():
            found = found[:1]
        inside = (self.chain.lower - 1e-9 <= found) & (found <= self.chain.upper + 1e-9)
        taken = inside.all(axis=1) if options.respect_limits else inside[:, 2]
        taken = taken & np.array([options.configuration in ("", name) for name in NAMES[: len(found)]])
        names = np.array(NAMES[: len(found)])[taken]
        found = np.clip(found, self.chain.lower, self.chain.upper)[taken] if options.respect_limits else found[taken]
        order = np.argsort(np.linalg.norm(found - seed, axis=1))
        return self.result(found[order], tuple(names[order].tolist()))

    def tilt(self, target: Floats) -> float:
        """Return the sine of the angle between the tool and the vertical."""
        return float(np.hypot(target[0, 2], target[1, 2]))

    def solutions(self, target: Floats, bend: float, seed: Floats) -> Floats:
        x, y = target[:2, 3]
        found = []
        for elbow in (bend, -bend):
            shoulder = np.arctan2(y, x) - np.arctan2(FORE * np.sin(elbow), UPPER + FORE * np.cos(elbow))
            hand = np.arctan2(target[1, 0], target[0, 0]) - shoulder - elbow
            found.append(self.near(np.array([shoulder, elbow, target[2, 3] - HEIGHT, hand]), seed))
        return np.array(found)

    def near(self, q: Floats, seed: Floats) -> Floats:
        """Return q turned by full turns, near the seed and, where that is possible, within limits."""
        turn = 2.0 * np.pi
        for i in (0, 1, 3):
            q[i] += turn * np.round((seed[i] - q[i]) / turn)
            q[i] -= turn * (q[i] > self.chain.upper[i] + 1e-9)
            q[i] += turn * (q[i] < self.chain.lower[i] - 1e-9)
        return q

    def result(self, solutions: Floats, names: tuple[str, ...]) -> InverseResult:
        if not len(solutions):
            return InverseResult(InverseStatus.OUTSIDE_LIMITS, solutions, reason="limits")
        return InverseResult(InverseStatus.SOLVED, solutions, names)


class OtherTip(Right):
    def forward(self, q: Floats, /) -> Floats:
        frames = super().forward(q)
        frames[-1] = frames[-1] @ np.diag([-1.0, -1.0, 1.0, 1.0])
        return frames


class FramesComeAndGo(Right):
    def forward(self, q: Floats, /) -> Floats:
        frames = super().forward(q)
        return frames if q[0] > 0.0 else frames[-1:]


class JacobianOfTheTip(Right):
    def jacobian(self, q: Floats, /) -> Floats:
        turned = super().forward(q)[-1, :3, :3].T
        return np.vstack([turned @ rows for rows in np.split(super().jacobian(q), 2)])


class OneElbow(Right):
    def result(self, solutions: Floats, names: tuple[str, ...]) -> InverseResult:
        return super().result(solutions[:1], names[:1])


class Twice(Right):
    def result(self, solutions: Floats, names: tuple[str, ...]) -> InverseResult:
        return super().result(np.repeat(solutions, 2, axis=0), tuple(np.repeat(names, 2).tolist()))


class FarthestFirst(Right):
    def result(self, solutions: Floats, names: tuple[str, ...]) -> InverseResult:
        return super().result(solutions[::-1].copy(), names[::-1])


class NamesByOrder(Right):
    def result(self, solutions: Floats, names: tuple[str, ...]) -> InverseResult:
        return super().result(solutions, NAMES[: len(solutions)])


class IgnoresConfiguration(Right):
    def inverse(self, base_t_tip: Floats, options: InverseOptions, /) -> InverseResult:
        return super().inverse(base_t_tip, replace(options, configuration=""))


class NamelessWhenAsked(Right):
    def inverse(self, base_t_tip: Floats, options: InverseOptions, /) -> InverseResult:
        known = options.configuration if options.configuration in NAMES else ""
        return super().inverse(base_t_tip, replace(options, configuration=known))


class TiltedAsUpright(Right):
    def tilt(self, target: Floats) -> float:
        return abs(target[2, 2] - 1.0)


class RoundsTheTarget(Right):
    """As one that looks answers up by rounded poses."""

    def inverse(self, base_t_tip: Floats, options: InverseOptions, /) -> InverseResult:
        target = np.array(base_t_tip)
        target[:3, 3] = target[:3, 3].round(3)
        return super().inverse(target, options)


class LeavesOutTurns(Right):
    def near(self, q: Floats, seed: Floats) -> Floats:
        return super().near(q, np.zeros(4))


class NaNWhereStretched(Right):
    def solutions(self, target: Floats, bend: float, seed: Floats) -> Floats:
        return super().solutions(target, bend if bend > 1e-6 else np.nan, seed)


class OutsideLimitsAlways(Right):
    def inverse(self, base_t_tip: Floats, options: InverseOptions, /) -> InverseResult:
        return InverseResult(InverseStatus.OUTSIDE_LIMITS, np.empty((0, len(self.chain.joint_names))), reason="limits")


class FarFromExact(Right):
    def result(self, solutions: Floats, names: tuple[str, ...]) -> InverseResult:
        return super().result(solutions, names)._replace(position_error=1e6)


class IgnoresTheBase(Right):
    def __init__(self, chain: SerialChain) -> None:
        """Take a robot that stands at the origin."""
        super().__init__(chain._replace(pre=np.concatenate([scara().pre[:1], chain.pre[1:]])))


class IgnoresTheTool(Right):
    def __init__(self, chain: SerialChain) -> None:
        """Take a robot without a tool."""
        super().__init__(chain._replace(post=np.eye(4)))


class StartsWhereItEnded(Right):
    """As a search that begins where the last one ended, and so ends beside where it ended before."""

    last = np.zeros(4)

    def inverse(self, base_t_tip: Floats, options: InverseOptions, /) -> InverseResult:
        result = super().inverse(base_t_tip, options)
        found = result._replace(solutions=result.solutions + 1e-10 * self.last)
        self.last = np.copy(base_t_tip[:, 3])
        return found


class BeyondLimits(Right):
    def __init__(self, chain: SerialChain) -> None:
        """Take wider limits than the robot's."""
        super().__init__(chain._replace(upper=chain.upper + 10.0, lower=chain.lower - 10.0))


class LimitsAlways(Right):
    def inverse(self, base_t_tip: Floats, options: InverseOptions, /) -> InverseResult:
        return super().inverse(base_t_tip, InverseOptions(seed=options.seed))


class LimitsTooTight(Right):
    def __init__(self, chain: SerialChain) -> None:
        """Take narrower limits than the robot's."""
        super().__init__(chain._replace(upper=chain.upper - 1e-6))


class ReachesForTheMoon(Right):
    def inverse(self, base_t_tip: Floats, options: InverseOptions, /) -> InverseResult:
        target = rigid_target(base_t_tip)
        target[:3, 3] = 0.5, 0.0, 0.3
        return super().inverse(target, options)


class GivesNoReason(Right):
    def inverse(self, base_t_tip: Floats, options: InverseOptions, /) -> InverseResult:
        result = super().inverse(base_t_tip, options)
        return result._replace(reason="")


class TakesAnything(Right):
    def forward(self, q: Floats, /) -> Floats:
        return chain_frames(self.chain, np.resize(np.nan_to_num(q), 4))


class RaisesWrongly(Right):
    def forward(self, q: Floats, /) -> Floats:
        if not np.isfinite(q).all():
            raise ValueError("q must be finite")
        return super().forward(q)


class Sulks(Right):
    def forward(self, q: Floats, /) -> Floats:
        if np.shape(q) != (4,) or not np.isfinite(q).all():
            self.sulking = True
        frames = super().forward(q)
        frames[-1, 0, 3] += 0.1 * getattr(self, "sulking", False)
        return frames


class Moody(Right):
    moods = itertools.count()

    def jacobian(self, q: Floats, /) -> Floats:
        return super().jacobian(q) + 1e-12 * next(self.moods)


class WritesToTheSeed(Right):
    def inverse(self, base_t_tip: Floats, options: InverseOptions, /) -> InverseResult:
        if options.seed is not None and options.seed.flags.writeable:
            options.seed[:] = 0.0
        return super().inverse(base_t_tip, options)


class WritesToQ(Right):
    def forward(self, q: Floats, /) -> Floats:
        q[3] %= 2.0 * np.pi
        return super().forward(q)


class KeepsItsBuffer(Right):
    def __init__(self, chain: SerialChain) -> None:
        """Make one array for all answers."""
        super().__init__(chain)
        self.buffer = np.empty((5, 4, 4))

    def forward(self, q: Floats, /) -> Floats:
        self.buffer[:] = super().forward(q)
        return self.buffer


class Remembers(Right):
    def __init__(self, chain: SerialChain) -> None:
        """Start without answers."""
        super().__init__(chain)
        self.known: dict[bytes, Floats] = {}

    def jacobian(self, q: Floats, /) -> Floats:
        return self.known.setdefault(q.tobytes(), super().jacobian(q))
