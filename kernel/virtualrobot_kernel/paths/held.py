"""Joint path along a tool path where some joints go by functions of their own: one of seven, a rail, a positioner.

The six others are known in closed form at each place, so that they are not followed but looked up: on the branch that
the ladder has chosen, at knots that come nearer until the pieces between them are on the path.
"""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import Reason
from virtualrobot_kernel.motion.free_path import FreePath
from virtualrobot_kernel.motion.limits import TOLERANCE, JointLimits
from virtualrobot_kernel.motion.path import quintic_hermite
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.resolved_rate import DEVIATION, TcpKinematics
from virtualrobot_kernel.paths.closed_forms import LedArm
from virtualrobot_kernel.paths.tool_reasons import Places

Floats = NDArray[np.float64]

STEP = 0.01
"""Greatest length (m) of the path between two of the first knots."""
DIFFERENCE = 1e-4
"""Half the difference of two parameters by which derivatives are told; by 1e-4 of themselves at the most."""
NARROWEST = 1e-6
"""Distance of two knots below which the path is lost: postures jump there."""
CORRECTIONS = 2
"""Number of Newton steps that take a model file's rounding off, which the closed form does without."""


class HeldPath:
    """Path of the joints of an arm along a path of its tool, with a function for those that are free."""

    def __init__(
        self, arm: LedArm, tcp: TcpKinematics, path: FreePath, held: PiecewisePolynomial, branch: int, places: Places
    ) -> None:
        """Take an arm, the values `held` (f,) of what is free by the path's parameter, and a branch."""
        self._arm, self._tcp, self._path, self._held = arm, tcp, path, held
        self._branch, self._places = branch, places
        self._tcp_t_tip = inverse(tcp.tip_t_tcp)

    def joints(self, start: Floats, limits: JointLimits) -> PiecewisePolynomial:
        """Return q(u) from a posture (k,) that is near the start; raises KernelError with the place."""
        path = self._path
        count = max(4, ceil(path.length / STEP))
        marks = np.unique(np.concatenate([path.knots, np.linspace(0.0, 1.0, count + 1)]))
        # Two knots that are one but for rounding would make a sliver of a piece.
        marks = marks[np.concatenate([[True], np.diff(marks) > 1e-3 / count])]
        marks[-1] = 1.0
        near = start
        rows = []
        for mark in marks.tolist():
            near = self._posture(mark, near)
            rows.append(near)
        q = np.array(rows)
        rates, bends = self._derivatives(marks, q)
        open_ = np.ones(len(marks) - 1, np.bool_)
        while open_.any():
            piece = quintic_hermite(marks, q, rates, bends)
            starts = np.flatnonzero(open_)
            between = 0.5 * (marks[starts] + marks[starts + 1])
            guessed = piece.evaluate(between)
            found = np.array([self._posture(u, near) for u, near in zip(between.tolist(), guessed, strict=True)])
            off = np.abs(found - guessed).max(axis=1) > DEVIATION
            narrow = off & (marks[starts + 1] - marks[starts] < NARROWEST)
            if narrow.any():
                u = float(between[narrow.argmax()])
                raise self._places.error(u, "postures jump there: it is in a singularity", Reason.SINGULARITY)
            open_[starts[~off]] = False
            starts, between, found = starts[off], between[off], found[off]
            new_rates, new_bends = self._derivatives(between, found)
            marks = np.insert(marks, starts + 1, between)
            q, rates, bends = (
                np.insert(old, starts + 1, new, axis=0)
                for old, new in ((q, found), (rates, new_rates), (bends, new_bends))
            )
            open_ = np.insert(open_, starts + 1, True)
        piece = quintic_hermite(marks, q, rates, bends)
        self._check(piece, limits)
        return piece

    def _posture(self, u: float, near: Floats) -> Floats:
        """Return the joints (k,) at a parameter, at the turns that are nearest to others."""
        arm, values = self._arm, self._held.state(u, 0)[0]
        pose = self._path.pose(u)
        q = arm.postures((pose @ self._tcp_t_tip)[None], values[None])[0][0, self._branch]
        if np.isnan(q).any():
            s = min(max(u, 0.0), 1.0)
            raise self._places.error(s, "no posture reaches it with smoothed free values", Reason.UNREACHABLE)
        turns = 2.0 * np.pi * np.round((near - q) / (2.0 * np.pi))
        q = np.where(arm.turns, q + turns, q)
        q[arm.free] = values
        base_t_reference, own = arm.base_t_reference(values), len(arm.chain.joint_names)
        turn, back = base_t_reference[:3, :3], inverse(base_t_reference)
        for _ in range(CORRECTIONS):
            off = self._path.deviation(u, back @ self._tcp.pose(q[:own])).reshape(2, 3) @ turn.T
            jacobian = self._tcp.jacobian(q[:own])[:, arm.solved]
            q[arm.solved] += np.linalg.lstsq(jacobian, off.ravel(), rcond=1e-9)[0]
        return q

    def _derivatives(self, marks: Floats, q: Floats) -> tuple[Floats, Floats]:
        """Return the first and second derivatives (m, k) at parameters (m,) where the joints are q (m, k)."""
        before, after = (
            np.array([self._posture(u + aside, near) for u, near in zip(marks.tolist(), q, strict=True)]).reshape(
                q.shape
            )
            for aside in (-DIFFERENCE, DIFFERENCE)
        )
        return (after - before) / (2.0 * DIFFERENCE), (after - 2.0 * q + before) / DIFFERENCE**2

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
