"""Check of a kinematics component on a robot: its answers against the robot's own tree, at random postures.

Four laws: the tip is where the tree puts it; every solution of the inverse puts the tip at its target; asked for by its
configuration, a solution is of that configuration; the Jacobian is the derivative of the forward pass (by central
differences).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from virtualrobot_sdk.answers import checked_frames, checked_jacobian, checked_result, pose_distance
from virtualrobot_sdk.kinematics import PRISMATIC, Floats, InverseOptions, Kinematics, SerialChain

POSTURES = 8
"""Number of random postures that are tried."""
POSE_TOLERANCE = 1e-6
"""Largest error of a tip's pose (m, rad)."""
JACOBIAN_TOLERANCE = 1e-5
"""Largest error of an entry of the Jacobian (m or rad per rad or m), relative to its largest entry."""
_STEP = 1e-6
_FAR = 1e3
"""A limit farther away (rad, m) is none: the digits of such postures do not suffice for finite differences."""
_INNER = 0.9
"""The part of each joint's range, about its middle, that postures are drawn from."""


@dataclass(frozen=True, slots=True)
class SelfCheck:
    """The largest deviations found, and the cost of the calls.

    Attributes:
        postures: number of random postures that were tried.
        solved: number of their poses for which the inverse gave a solution.
        forward_position: distance of the component's tip from the tree's (m).
        forward_rotation: angle between them (rad).
        inverse_position: distance of the tip at a solution from the target (m).
        inverse_rotation: angle between them (rad).
        jacobian: largest difference of an entry from the finite difference, relative to the largest entry.
        forward_seconds: mean time of a call.
        jacobian_seconds: mean time of a call.
        inverse_seconds: mean time of a call.
    """

    postures: int
    solved: int
    forward_position: float
    forward_rotation: float
    inverse_position: float
    inverse_rotation: float
    jacobian: float
    forward_seconds: float
    jacobian_seconds: float
    inverse_seconds: float

    def failures(self) -> tuple[str, ...]:
        """Return what is beyond the tolerances, each with its number; empty when the component fits."""
        said: list[str] = []
        tolerances = f"{POSE_TOLERANCE:g} m and rad allowed"
        if max(self.forward_position, self.forward_rotation) > POSE_TOLERANCE:
            said.append(
                f"forward puts the tip {self.forward_position:.3g} m and {self.forward_rotation:.3g} rad from where "
                f"the robot's tree has it ({tolerances})"
            )
        if self.solved < self.postures:
            said.append(
                f"inverse found no solution for {self.postures - self.solved} of {self.postures} poses that the robot "
                "reaches, started at the posture that reaches them"
            )
        if max(self.inverse_position, self.inverse_rotation) > POSE_TOLERANCE:
            said.append(
                f"a solution of inverse misses its target by {self.inverse_position:.3g} m and "
                f"{self.inverse_rotation:.3g} rad ({tolerances})"
            )
        if self.jacobian > JACOBIAN_TOLERANCE:
            said.append(
                f"the Jacobian differs from finite differences by {self.jacobian:.3g} of its largest entry "
                f"({JACOBIAN_TOLERANCE:g} allowed)"
            )
        return tuple(said)


def random_posture(chain: SerialChain, rng: np.random.Generator) -> Floats:
    """Return a posture (k,) well within limits; a joint without limits lies within half a turn or 1 m of zero."""
    k = len(chain.joint_names)
    sliding = np.array([(chain.joint_type[chain.q_index == i] == PRISMATIC).any() for i in range(k)])
    reach = np.where(sliding, 1.0, np.pi)
    middle = np.clip(0.0, chain.lower, chain.upper)
    has_lower, has_upper = chain.lower >= middle - _FAR, chain.upper <= middle + _FAR
    lower = np.where(has_lower, chain.lower, np.minimum(chain.upper, reach) - 2.0 * reach)
    upper = np.where(has_upper, chain.upper, lower + 2.0 * reach)
    return (lower + upper) / 2.0 + _INNER * rng.uniform(-0.5, 0.5, k) * (upper - lower)


def self_check(
    kinematics: Kinematics,
    chain: SerialChain,
    tip_of: Callable[[Floats], Floats],
    rng: np.random.Generator,
    postures: int = POSTURES,
) -> SelfCheck:
    """Return how far a component is from the robot whose tip is at `tip_of(q)` (4, 4), in the chain's base frame.

    Raises ComponentFault for answers of a wrong type or shape, and whatever the component raises.
    """
    forward, inverse, jacobian = (np.zeros(2) for _ in range(3))
    seconds = np.zeros(3)
    solved = 0
    for _ in range(postures):
        q = random_posture(chain, rng)
        target = tip_of(q)
        started = time.perf_counter()
        frames = checked_frames(kinematics.forward(q))
        after_forward = time.perf_counter()
        rates = checked_jacobian(kinematics.jacobian(q), chain)
        after_jacobian = time.perf_counter()
        options = InverseOptions(seed=q)
        result = checked_result(kinematics.inverse(target, options), chain, options)
        seconds += np.diff([started, after_forward, after_jacobian, time.perf_counter()])
        forward = np.maximum(forward, pose_distance(frames[-1], target))
        expected = finite_differences(tip_of, q)
        jacobian[0] = max(jacobian[0], np.abs(rates - expected).max() / max(1e-3, np.abs(expected).max()))
        solved += len(result.solutions) > 0
        for solution in result.solutions:
            inverse = np.maximum(inverse, pose_distance(tip_of(solution), target))
        for name in filter(None, result.configurations[:1]):
            # Another configuration than the one asked for is nonsense; one that is not found counts as not solved.
            named = replace(options, configuration=name)
            solved -= not len(checked_result(kinematics.inverse(target, named), chain, named).solutions)
    return SelfCheck(
        postures,
        solved,
        forward_position=float(forward[0]),
        forward_rotation=float(forward[1]),
        inverse_position=float(inverse[0]),
        inverse_rotation=float(inverse[1]),
        jacobian=float(jacobian[0]),
        forward_seconds=float(seconds[0]) / postures,
        jacobian_seconds=float(seconds[1]) / postures,
        inverse_seconds=float(seconds[2]) / postures,
    )


def finite_differences(tip_of: Callable[[Floats], Floats], q: Floats) -> Floats:
    """Return the geometric Jacobian (6, k) of a tip at q by central differences, linear rows first."""
    columns = []
    rotation = tip_of(q)[:3, :3]
    for step in _STEP * np.eye(len(q)):
        ahead, behind = tip_of(q + step), tip_of(q - step)
        spin = (ahead[:3, :3] - behind[:3, :3]) @ rotation.T / (2.0 * _STEP)
        angular = [spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]]
        columns.append(np.concatenate([(ahead[:3, 3] - behind[:3, 3]) / (2.0 * _STEP), np.array(angular) / 2.0]))
    return np.array(columns).T
