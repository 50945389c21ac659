r"""Externally Guided Motion of a program in RAPID: what it has agreed with a computer, and the motion that follows.

Sources: ABB, *Application manual Externally Guided Motion* (3HAC073318), and *Technical reference manual, RAPID
Instructions, Functions and Data types* (3HAC050917), from memory: what arguments mean, and what they are when left out.
The filter is of first order here, the ramp of the start a share that grows evenly, and the axes of a pose are apart in
the correction frame.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from virtualrobot.geometry import quaternion_of

from virtualrobot_apps.emulators.body import Body, Floats
from virtualrobot_apps.emulators.egm.controller import EgmController

SAMPLE = 0.004
"""Time (s) between two packets of a controller, of which each other one is a multiple."""
BACK = math.radians(0.01)
"""Difference (rad) below which the arm is back where it began."""
JOINT_RANGE = (-0.5, 0.5)
"""Difference (degrees) from where a joint was asked to be, within which it is there, where a program has none."""
POSE_RANGES = ((-1.0, 1.0),) * 3 + ((-0.5, 0.5),) * 3
"""The same of x, y, z (mm) and of turns about them (degrees)."""


@dataclass(frozen=True, slots=True, eq=False)
class Terms:
    """Terms that EGMActJoint or EGMActPose has set.

    Attributes:
        ranges: differences (least, greatest) of each axis within which it is where it was asked to be, six: degrees of
            joints, or mm and degrees of a pose.
        base_t_frame: the frame of poses, 4x4, in the base's.
        correction: axes of a pose are apart along those of this frame, 4x4, in the base's.
        period: time (s) between two packets.
        filter: bandwidth (Hz) of the low-pass filter of what is asked for; 0: none.
        farthest: greatest way (rad) of a joint from where it began.
        fastest: greatest speed (rad/s) of a joint.
    """

    ranges: Sequence[tuple[float, float]] = (JOINT_RANGE,) * 6
    base_t_frame: Floats = field(default_factory=lambda: np.eye(4))
    correction: Floats = field(default_factory=lambda: np.eye(4))
    period: float = SAMPLE
    filter: float = 0.0
    farthest: float = math.radians(1000.0)
    fastest: float = math.radians(1.0)


@dataclass(slots=True, eq=False)
class EgmProcess:
    """Value of an egmident.

    Attributes:
        to: where the computer listens; None: it is not connected.
        poses: whether it is guided by poses, and not by joints.
        silence: time (s) without an answer that is ERR_UDPUC_COMM.
        terms: what was said by EGMActJoint or EGMActPose; None: nothing yet.
        runs: whether a motion goes on.
        ends: how it is to end, where somebody has asked for it: back where it began in so many seconds, or at once (0).
    """

    to: tuple[str, int] | None = None
    poses: bool = False
    silence: float = 1.0
    terms: Terms | None = None
    runs: bool = False
    ends: float | None = None


class GuidedMotion(EgmController):
    """Motion of EGMRunJoint or EGMRunPose.

    Attributes:
        met: time (s) for which the arm has been where it was asked to be.
    """

    def __init__(
        self,
        body: Body,
        to: tuple[str, int],
        terms: Terms,
        axes: Sequence[bool],
        *,
        poses: bool,
        ramp: float,
        speeds: Floats,
    ) -> None:
        """Speak to the computer at `to`; `body` has six joints.

        Args:
            body: the arm.
            to: where the computer listens.
            terms: what was agreed.
            axes: mask of the axes that go where they are asked to, six; the others stay as they are.
            poses: whether they are those of a pose, and not joints.
            ramp: time (s) in which what is asked for comes to count whole.
            speeds: greatest speed of each joint, (k,), rad/s.

        Raises OSError where the computer can't be spoken to.
        """
        super().__init__(body, to, 1.0 / terms.period, math.inf)
        self.met = 0.0
        self.poses, self.base_t_frame = poses, terms.base_t_frame
        self._terms, self._axes, self._ramp = terms, np.array(axes, dtype=bool), ramp
        self._speeds, self._fastest = speeds, np.minimum(speeds, terms.fastest)
        self._gain = 1.0 if terms.filter <= 0.0 else 1.0 - math.exp(-2.0 * math.pi * terms.filter * terms.period)
        self._origin = self._planned.copy()
        self._origin_tcp = self._goal_tcp = body.tcp()
        self._back: Floats | None = None
        self._back_seconds = self._back_passed = 0.0
        self.begin_here()

    def begin_here(self) -> None:
        """Go on from where the arm is, at rest, with a ramp."""
        self._from = self._filtered = self._sent = self._body.read()[0]
        self._share = 0.0

    def cycle(self) -> None:
        """Do a cycle, as ever, and count how long the arm has been where it was asked to be."""
        super().cycle()
        self.met = self.met + self.period if self.convergence_met else 0.0

    def go_back(self, seconds: float) -> None:
        """Go back from now on to where the arm began, in so many seconds or as fast as it can."""
        self._back, self._back_seconds, self._back_passed = self._sent, max(seconds, self.period), 0.0

    @property
    def back(self) -> bool:
        """True where the arm is back; it follows nothing else after `go_back`."""
        return bool(np.abs(self._body.read()[0] - self._origin).max() < BACK)

    def setpoint(self, planned: Floats) -> Floats:
        """Return where the arm is sent: by ramp, range, filter and greatest speed towards `planned` (k,), or back."""
        if self._back is not None:
            self._back_passed += self.period
            share = min(1.0, self._back_passed / self._back_seconds)
            wanted = self._back + share**2 * (3.0 - 2.0 * share) * (self._origin - self._back)
            return self._towards(wanted, self._speeds)
        self._share = 1.0 if self._ramp <= 0.0 else min(1.0, self._share + self.period / self._ramp)
        asked = planned if self.poses else np.where(self._axes, planned, self._origin)
        wanted = self._from + self._share * (asked - self._from)
        wanted = np.clip(wanted, self._origin - self._terms.farthest, self._origin + self._terms.farthest)
        self._filtered = self._filtered + self._gain * (wanted - self._filtered)
        return self._towards(self._filtered, self._fastest)

    def _towards(self, wanted: Floats, fastest: Floats) -> Floats:
        step = fastest * self.period
        self._sent = self._sent + np.clip(wanted - self._sent, -step, step)
        return self._sent

    def goal(self, base_t_tcp: Floats) -> Floats:
        """Return where the tool centre point goes: with the axes of a pose, 4x4, that are asked for, from the start."""
        if self._origin_tcp is not None and not self._axes.all():
            rotation = self._terms.correction[:3, :3]
            way = rotation.T @ (base_t_tcp[:3, 3] - self._origin_tcp[:3, 3])
            goal = self._origin_tcp.copy()
            goal[:3, 3] += rotation @ np.where(self._axes[:3], way, 0.0)
            if self._axes[3:].all():
                goal[:3, :3] = base_t_tcp[:3, :3]
            base_t_tcp = goal
        self._goal_tcp = base_t_tcp
        return base_t_tcp

    def converged(self, positions: Floats) -> bool:
        """Return whether something was asked for, and each axis that goes is within its range of it."""
        if not self.answered:
            return False
        off = self._off_pose() if self.poses else np.degrees(self._planned - positions)
        return all(
            low <= one <= high
            for one, (low, high), goes in zip(off, self._terms.ranges, self._axes, strict=True)
            if goes
        )

    def _off_pose(self) -> Floats:
        """Return how far the tool centre point is from its goal: along the frame's axes (mm), about them (degrees)."""
        tcp, goal, rotation = self._body.tcp(), self._goal_tcp, self._terms.base_t_frame[:3, :3]
        if tcp is None or goal is None:
            return np.full(6, np.inf)
        *axis, cosine = quaternion_of(rotation.T @ goal[:3, :3] @ tcp[:3, :3].T @ rotation)
        sine = float(np.linalg.norm(axis))
        turn = np.array(axis) * (2.0 * math.atan2(sine, cosine) / sine if sine > 0.0 else 0.0)
        return np.concatenate((1e3 * (rotation.T @ (goal[:3, 3] - tcp[:3, 3])), np.degrees(turn)))
