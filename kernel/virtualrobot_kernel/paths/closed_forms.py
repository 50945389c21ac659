"""Closed forms by which a ladder's postures are found, of six turning joints; a joint beside them is held.

Of six joints they are those with a spherical wrist, with three parallel axes, and with axes that meet at both ends. Of
seven, one has a value of its own in each combination of free values: the third of an arm with shoulder and wrist, which
is its arm angle by another number; a joint that slides, such as a rail's; or whichever leaves a closed form.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from virtualrobot_sdk.compiled.closed import BRANCHES, inverse_many, spherical_wrist
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import REVOLUTE, Floats, SerialChain
from virtualrobot_sdk.meeting_axes import MeetingAxes
from virtualrobot_sdk.parallel_axes import ParallelAxes, has_parallel_axes

from virtualrobot_kernel.planning.extract import lock_coordinates

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
class LedArm:
    """Arm whose postures a ladder knows: of k joints, six by a closed form, and `held`, None for an arm of six.

    One closed form tells them at all values of the joint held, so that a branch is the same one at each.
    """

    chain: SerialChain
    held: int | None = None

    def at(self, value: float) -> Postures:
        """Return the closed form of the other joints with one held at a value; raises ArgumentError with its lack."""
        assert self.held is not None
        others = lock_coordinates(self.chain, {self.held: value})[0]
        return MeetingAxes(others).postures if self.turns[self.held] else closed_form(others)

    @property
    def turns(self) -> np.ndarray:
        """Whether each joint turns: (k,); others slide."""
        return self.chain.joint_type == REVOLUTE

    def postures(self, tips: Floats, held: Floats) -> tuple[Floats, Floats]:
        """Return postures (m, 8, k) as of `Postures` of poses (m, 4, 4), each with its value (m,) of the joint held."""
        if self.held is None:
            return closed_form(self.chain)(tips)
        count = len(self.chain.joint_names)
        q, clear = np.full((len(tips), BRANCHES, count), np.nan), np.zeros((len(tips), BRANCHES))
        others = [joint for joint in range(count) if joint != self.held]
        for value in np.unique(held).tolist():
            rows = np.flatnonzero(held == value)
            found, clear[rows] = self.at(value)(tips[rows])
            q[rows[:, None, None], np.arange(BRANCHES)[:, None], others] = found
            q[rows, :, self.held] = np.where(np.isfinite(found[:, :, 0]), value, np.nan)
        return q, clear


def led_arm(chain: SerialChain) -> LedArm:
    """Return an arm with the joint that is held, if it has seven; raises ArgumentError with what it lacks."""
    if len(chain.joint_names) != 7:
        closed_form(chain)
        return LedArm(chain)
    own = np.array_equal(chain.q_index, np.arange(7))
    slides = np.flatnonzero(chain.joint_type != REVOLUTE).tolist()
    for held in (slides or ORDER) if own else ():
        arm = LedArm(chain, held)
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
