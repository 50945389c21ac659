"""Joint path along a tool path: six joints by a closed form, others by functions of their own, such as a rail's.

The six are known at each place, so that they are not followed but looked up: on the branch that the ladder has chosen,
at knots that come nearer until the pieces between them are on the path.
"""

from __future__ import annotations

from collections.abc import Callable
from math import ceil

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import inverse
from virtualrobot_sdk.reference import chain_frames

from virtualrobot_kernel.errors import Reason
from virtualrobot_kernel.motion.free_path import FreePath
from virtualrobot_kernel.motion.limits import TOLERANCE, JointLimits
from virtualrobot_kernel.motion.path import quintic_hermite
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.resolved_rate import DEVIATION
from virtualrobot_kernel.paths.closed_forms import LedArm
from virtualrobot_kernel.paths.tool_reasons import Places

Floats = NDArray[np.float64]

STEP = 0.01
"""Greatest length (m) of the path between two of the first knots."""
DIFFERENCE, SHARE = 1e-4, 0.01
"""Half the difference of two parameters by which derivatives are told, at the most; and that in parts of the way to the
next knot, at which what bends the path begins to change at another rate."""
NARROWEST = 1e-6
"""Distance of two knots below which the path is lost: postures jump there."""
CORRECTIONS, CLOSED = 2, 1e-12
"""Number of Newton steps that take a model file's rounding off, which the closed form does without; and how near the
path (m, rad) none is needed."""


class LedPath:
    """Path of the joints of an arm along a path of its tool, with a function for those that are free."""

    def __init__(
        self, arm: LedArm, tip_t_tcp: Floats, path: FreePath, held: PiecewisePolynomial, branch: int, places: Places
    ) -> None:
        """Take an arm, its tool centre point, the values `held` (f,) of what is free by u, and a branch."""
        self._arm, self._path, self._held = arm, path, held
        self._branch, self._places = branch, places
        self._tip_t_tcp, self._tcp_t_tip = tip_t_tcp, inverse(tip_t_tcp)

    def joints(self, start: Floats, limits: JointLimits) -> PiecewisePolynomial:
        """Return q(u) from a posture (k,) that is near the start; raises KernelError with the place."""
        path = self._path
        count = max(4, ceil(path.length / STEP))
        marks = np.unique(np.concatenate([path.knots, np.linspace(0.0, 1.0, count + 1)]))
        # Two knots that are one but for rounding would make a sliver of a piece.
        marks = marks[np.concatenate([[True], np.diff(marks) > 1e-3 / count])]
        marks[-1] = 1.0
        # Each one is at the turns that are nearest to the one before it.
        q = self._postures(marks, lambda found: np.unwrap(np.concatenate([start[None], found]), axis=0)[1:])
        ways = np.diff(marks)
        rates, bends = self._derivatives(marks, q, np.minimum(np.append(ways, ways[-1]), np.append(ways[0], ways)))
        open_ = np.ones(len(marks) - 1, np.bool_)
        while open_.any():
            piece = quintic_hermite(marks, q, rates, bends)
            starts = np.flatnonzero(open_)
            between = 0.5 * (marks[starts] + marks[starts + 1])
            guessed = piece.evaluate(between)
            found = self._postures(between, _nearest(guessed))
            off = np.abs(found - guessed).max(axis=1) > DEVIATION
            narrow = off & (marks[starts + 1] - marks[starts] < NARROWEST)
            if narrow.any():
                u = float(between[narrow.argmax()])
                raise self._places.error(u, "postures jump there: it is in a singularity", Reason.SINGULARITY)
            open_[starts[~off]] = False
            starts, between, found = starts[off], between[off], found[off]
            new_rates, new_bends = self._derivatives(between, found, 0.5 * (marks[starts + 1] - marks[starts]))
            marks = np.insert(marks, starts + 1, between)
            q, rates, bends = (
                np.insert(old, starts + 1, new, axis=0)
                for old, new in ((q, found), (rates, new_rates), (bends, new_bends))
            )
            open_ = np.insert(open_, starts + 1, True)
        piece = quintic_hermite(marks, q, rates, bends)
        self._check(piece, limits)
        return piece

    def _postures(self, u: Floats, turned: Callable[[Floats], Floats]) -> Floats:
        """Return the joints (m, k) at parameters (m,); `turned` brings (m, k) to the turns that are wanted."""
        arm, values, wanted = self._arm, self._held.states(u, 0)[0], self._path.poses(u)
        q = arm.postures(wanted @ self._tcp_t_tip, values)[0][:, self._branch]
        missing = np.isnan(q).any(axis=1)
        if missing.any():
            s = float(np.clip(u[missing.argmax()], 0.0, 1.0))
            raise self._places.error(s, "no posture reaches it with smoothed free values", Reason.UNREACHABLE)
        q = np.where(arm.turns, turned(q), q)
        q[:, arm.free] = values
        chain, wanted = arm.chain, arm.base_t_reference(values) @ wanted
        own = len(chain.joint_names)
        for _ in range(CORRECTIONS):
            frames = chain_frames(chain, q[:, :own])
            tcp = frames[:, -1] @ self._tip_t_tcp
            off = np.concatenate([wanted[:, :3, 3] - tcp[:, :3, 3], _small_turns(wanted, tcp)], axis=1)
            if np.abs(off).max(initial=0.0) < CLOSED:
                break
            axes = np.einsum("mnij,nj->mni", frames[:, :-1, :3, :3], chain.axis)[:, arm.solved]
            levers = tcp[:, None, :3, 3] - frames[:, :, :3, 3][:, arm.solved]
            jacobian = np.concatenate([np.cross(axes, levers), axes], axis=2).transpose(0, 2, 1)
            q[:, arm.solved] += np.einsum("mij,mj->mi", np.linalg.pinv(jacobian, rcond=1e-9), off)
        return q

    def _derivatives(self, marks: Floats, q: Floats, ways: Floats) -> tuple[Floats, Floats]:
        """Return the first and second derivatives (m, k) at parameters (m,) where the joints are q (m, k).

        ways (m,): to the nearest knot.
        """
        aside = np.minimum(DIFFERENCE, SHARE * ways)
        around = np.concatenate([marks - aside, marks + aside])
        before, after = np.split(self._postures(around, _nearest(np.concatenate([q, q]))), 2)
        aside = aside[:, None]
        return (after - before) / (2.0 * aside), (after - 2.0 * q + before) / aside**2

    def _check(self, piece: PiecewisePolynomial, limits: JointLimits) -> None:
        excursion = piece.first_excursion(limits.lower, limits.upper, TOLERANCE)
        if excursion is not None:
            joint = excursion.component
            raise self._places.error(
                excursion.entered,
                f"joint {limits.names[joint]!r} would be at {excursion.value:.4g}, beyond its limits",
                Reason.LIMIT_EXCEEDED,
                joint=limits.names[joint],
                value=excursion.value,
                lower=float(limits.lower[joint]),
                upper=float(limits.upper[joint]),
            )


def _nearest(near: Floats) -> Callable[[Floats], Floats]:
    """Return what brings joints (m, k) to the turns that are nearest to others (m, k)."""
    return lambda q: q + 2.0 * np.pi * np.round((near - q) / (2.0 * np.pi))


def _small_turns(wanted: Floats, found: Floats) -> Floats:
    """Return the small rotation vectors (m, 3) that take poses (m, 4, 4) to those that are wanted."""
    turn = wanted[:, :3, :3] @ np.swapaxes(found[:, :3, :3], 1, 2)
    return 0.5 * np.stack(
        [turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]], axis=1
    )
