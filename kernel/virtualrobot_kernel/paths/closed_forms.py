"""Closed forms by which a ladder's postures are found, of six turning joints; all others have values of their own.

Of six joints they are those with a spherical wrist, with three parallel axes, and with axes that meet at both ends. Of
seven, one has a value of its own in each combination of free values: the third of an arm with shoulder and wrist, which
is its arm angle by another number; a joint that slides, such as a rail's; or whichever leaves a closed form.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.compiled.closed import BRANCHES, inverse_many, spherical_wrist
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import REVOLUTE, Floats, SerialChain
from virtualrobot_sdk.meeting_axes import MeetingAxes
from virtualrobot_sdk.parallel_axes import ParallelAxes, has_parallel_axes

from virtualrobot_kernel.planning.extract import lock_coordinates

Flags = NDArray[np.bool_]
Postures = Callable[[Floats], tuple[Floats, Floats]]
"""Postures (m, 8, 6) of poses (m, 4, 4) of an arm's tip, NaN for none; and (m, 8), 0 where they are singular."""

ORDER = (2, 6, 0, 1, 3, 4, 5)
"""Joints of an arm of seven that turn, as they are tried to be held: what turns the elbow about, then the ends."""
TRIED = (0.0, 0.7)
"""Values at which a joint is held to see whether the others have a closed form (rad or m)."""


def closed_form(chain: SerialChain) -> Postures:
    """Return the closed form of an arm of six joints; raises ArgumentError with what it lacks."""
    if has_parallel_axes(chain):
        return ParallelAxes(chain).postures
    try:
        arm = spherical_wrist(chain)
    except ArgumentError as lacking:
        try:
            return MeetingAxes(chain).postures
        except ArgumentError:
            raise lacking from None

    def postures(tips: Floats) -> tuple[Floats, Floats]:
        q, wrist = np.empty((len(tips), BRANCHES, 6)), np.empty((len(tips), BRANCHES))
        inverse_many(arm, np.ascontiguousarray(tips), q, wrist)
        return q, wrist

    return postures


@dataclass(frozen=True, slots=True, eq=False)
class Carriers:
    """Joints of other robots, (m,), that carry the arm, such as a rail, or the frame of its path, as a positioner does.

    lower and upper (m,): their limits; turns (m,): whether each one turns, others slide. base_t_reference: where the
    path's frame is (..., 4, 4) in the frame of the arm's base when these joints are at values (..., m).
    """

    lower: Floats
    upper: Floats
    turns: Flags
    base_t_reference: Callable[[Floats], Floats]


class LedArm:
    """Arm whose postures a ladder knows: six joints by a closed form, all others with values of their own.

    Attributes:
        chain: the arm's own (k joints).
        held: which of its joints has a value of its own; None for an arm of six.
        carriers: joints (m,) of other robots, which come after the arm's own; None where all else stands.
        free: the columns (f,), of k + m, whose values are free; and `solved`, (6,), those by the closed form.
        turns: whether each joint turns: (k + m,); others slide.
        lower: limits (f,) of what is free, and `upper`.
    """

    def __init__(self, chain: SerialChain, held: int | None = None, carriers: Carriers | None = None) -> None:
        """Take an arm; see `led_arm` for one of which nothing is known."""
        self.chain, self.held, self.carriers = chain, held, carriers
        count = len(chain.joint_names)
        self.turns: Flags = chain.joint_type == REVOLUTE
        lower, upper = chain.lower, chain.upper
        self.free = [] if held is None else [held]
        if carriers is not None:
            self.free += range(count, count + len(carriers.lower))
            self.turns = np.concatenate([self.turns, carriers.turns])
            lower, upper = np.concatenate([lower, carriers.lower]), np.concatenate([upper, carriers.upper])
        self.solved = [joint for joint in range(count) if joint != held]
        self.lower, self.upper = lower[self.free], upper[self.free]
        self._own = closed_form(chain) if held is None else None

    def at(self, value: float) -> Postures:
        """Return the closed form of six joints with one held at a value; raises ArgumentError with what they lack.

        It is the same one at all values, so that a branch is the same one at each.
        """
        if self._own is not None:
            return self._own
        assert self.held is not None
        others = lock_coordinates(self.chain, {self.held: value})[0]
        return MeetingAxes(others).postures if self.turns[self.held] else closed_form(others)

    def base_t_reference(self, free: Floats) -> Floats:
        """Return where the path's frame is (..., 4, 4) in the base's, for free values (..., f); without any (4, 4)."""
        if self.carriers is None:
            return np.eye(4)
        return self.carriers.base_t_reference(free[..., self.held is not None :])

    def postures(self, tips: Floats, free: Floats) -> tuple[Floats, Floats]:
        """Return postures (n, 8, k + m) of poses (n, 4, 4) of the tip in the path's frame, as `Postures` does.

        free (n, f): what is free at each of them.
        """
        carried = self.base_t_reference(free) @ tips
        q = np.full((len(tips), BRANCHES, len(self.turns)), np.nan)
        clear = np.zeros((len(tips), BRANCHES))
        own = np.zeros(len(tips)) if self.held is None else free[:, 0]
        for value in np.unique(own).tolist():
            here = np.flatnonzero(own == value)
            found, clear[here] = self.at(value)(carried[here])
            q[here[:, None, None], np.arange(BRANCHES)[:, None], self.solved] = found
        there = np.isfinite(q[:, :, self.solved[0]])
        q[:, :, self.free] = np.where(there[:, :, None], free[:, None], np.nan)
        return q, clear


def led_arm(chain: SerialChain, carriers: Carriers | None = None) -> LedArm:
    """Return an arm with the joint that is held, if it has seven; raises ArgumentError with what it lacks."""
    if len(chain.joint_names) != 7:
        return LedArm(chain, None, carriers)
    own = np.array_equal(chain.q_index, np.arange(7))
    slides = np.flatnonzero(chain.joint_type != REVOLUTE).tolist()
    for held in (slides or ORDER) if own else ():
        arm = LedArm(chain, held, carriers)
        try:
            for value in TRIED:
                arm.at(value)
        except ArgumentError:
            continue
        return arm
    raise ArgumentError(
        f"the arm has 7 joints ({', '.join(chain.joint_names)}), and whichever of them is held, the other six have no "
        "closed form: axes of two joints must meet at one end and those of three at the other"
    )
