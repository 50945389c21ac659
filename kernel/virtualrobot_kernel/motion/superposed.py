"""Corners in which two moves are made at once: the first one slows down evenly while the second one speeds up.

Of two straight lines the sum is a parabola, the quadratic Bézier curve whose control points are where the zone begins,
the corner, and where it ends (Farin, Curves and Surfaces for CAGD, 5th ed., ch. 4). Of arcs it is what becomes of that
when the lines bend. The share of the second move begins to grow, and ends, with a ramp, so that the curvature does not
jump and jerks stay finite.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import rotation_vector

from virtualrobot_kernel.motion.path import quintic_hermite
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.motion.resolved_rate import TcpKinematics, lever_arm, row_weights

RAMP, LEAST_RAMP = 0.4, 0.016
"""Share of a zone's radius in which its curvature begins where there is room for it, and the least one."""

_PARTS, _ROUNDS = 5, 4
"""Number of pieces that a corner has at least, and of times that those which don't fit are halved."""

_DIFFERENCE, _OFF, _SOLVED = 1e-4, 1e-7, 1e-10
"""Share of a zone for differences; deviation of a piece's middle (rad or m), and of a pose (m and rad)."""


@dataclass(frozen=True, slots=True)
class Fade:
    """Share of the move after a corner: from 0 to 1, evenly but for a ramp at each end, `2 half` wide but for these.

    Both are lengths along the moves, s, which is 0 in the middle.
    """

    half: float
    ramp: float

    @property
    def reach(self) -> float:
        """Length before and after the corner in which it is neither 0 nor 1."""
        return self.half + 0.5 * self.ramp

    @property
    def knots(self) -> tuple[float, ...]:
        """Places at which its second derivative jumps."""
        near, far = self.half - 0.5 * self.ramp, self.reach
        return (-far, -near, near, far)

    def scaled(self, factor: float) -> Fade:
        """Return the same with all lengths multiplied."""
        return Fade(self.half * factor, self.ramp * factor)

    def at(self, s: float) -> tuple[float, float, float]:
        """Return where the first move is before its end (negative), the second one behind its start, and the share."""
        after, share = self._second(-abs(s))
        if s > 0.0:
            after, share = s + after, 1.0 - share
        return s - after, after, share

    def _second(self, s: float) -> tuple[float, float]:
        slope, since = 0.5 / self.half, s + self.reach
        if since <= 0.0:
            return 0.0, 0.0
        if since < self.ramp:
            return slope * since**3 / (6.0 * self.ramp), slope * since**2 / (2.0 * self.ramp)
        return slope * (0.5 * (s + self.half) ** 2 + self.ramp**2 / 24.0), slope * (s + self.half)


def fade_within(radius: float, room: float) -> Fade:
    """Return the fade of a zone's radius, which passes the corner as its parabola does and reaches `room` at most.

    Its ramp is as long as there is room for; a radius that has none for the least one is smaller.
    """
    radius = min(radius, room / (1.0 + 0.5 * LEAST_RAMP))
    ramp = min(RAMP * radius, 2.0 * (room - radius))
    return Fade(radius - ramp**2 / (12.0 * radius), ramp)


@dataclass(frozen=True, slots=True, eq=False)
class Led:
    """Tool centre point that both moves lead along Cartesian paths, and the columns of the joints that move it."""

    tcp: TcpKinematics
    columns: NDArray[np.intp]


class _Sum:
    """Sum of two joint paths about the corner between them, by s in the parameter of both."""

    def __init__(
        self, before: PiecewisePolynomial, after: PiecewisePolynomial, place: Fade, turn: Fade, leds: Sequence[Led]
    ) -> None:
        self.before, self.after, self.place, self.turn, self.leds = before, after, place, turn, leds
        self.corner = after.state(after.start, 0)[0]
        self.turned = [led.tcp.pose(self.corner[led.columns])[:3, :3] for led in leds]
        self.points = [led.tcp.pose(self.corner[led.columns])[:3, 3] for led in leds]

    def _joints(self, fade: Fade, s: float) -> tuple[Array, Array, float]:
        """Return values and rates (2, n) of both paths where a fade has them, and its share."""
        left, right, share = fade.at(s)
        return self.before.state(self.before.end + left, 1), self.after.state(self.after.start + right, 1), share

    def state(self, s: float) -> tuple[Array, Array] | None:
        """Return joints and their derivatives by s; None where a tool centre point can't be led."""
        others = self._joints(self.turn if self.leds else self.place, s)
        joints, rates = self._added(*others)
        near = self._joints(self.place, s) if self.leds else others
        for number, led in enumerate(self.leds):
            own = self._added(*near)
            found = self._led(number, own[0][led.columns], own[1][led.columns], near, others)
            if found is None:
                return None
            joints[led.columns], rates[led.columns] = found
        return joints, rates

    def _added(self, before: Array, after: Array, share: float) -> tuple[Array, Array]:
        return before[0] + after[0] - self.corner, (1.0 - share) * before[1] + share * after[1]

    def _led(
        self,
        number: int,
        joints: Array,
        rates: Array,
        near: tuple[Array, Array, float],
        others: tuple[Array, Array, float],
    ) -> tuple[Array, Array] | None:
        """Return joints and rates with which a tool centre point is where the sum of both moves has it, near others."""
        led, tcp = self.leds[number], self.leds[number].tcp
        first, second = (self._pose(led, one) for one in near[:2])
        turned = (first, second) if others is near else tuple(self._pose(led, one) for one in others[:2])
        point = first[0] + second[0] - self.points[number]
        to_corner = turned[0][1] @ self.turned[number].T
        rotation = to_corner @ turned[1][1]
        twist = np.concatenate(
            [
                (1.0 - near[2]) * first[2][:3] + near[2] * second[2][:3],
                (1.0 - others[2]) * turned[0][2][3:] + others[2] * (to_corner @ turned[1][2][3:]),
            ]
        )
        jacobian = tcp.jacobian(joints)
        weights = row_weights(lever_arm(jacobian))
        for _ in range(12):
            pose = tcp.pose(joints)
            off = np.concatenate([point - pose[:3, 3], rotation_vector(rotation @ pose[:3, :3].T)])
            if np.abs(off).max() <= _SOLVED:
                missing = (twist - jacobian @ rates) * weights
                return joints, rates + np.linalg.lstsq(jacobian * weights[:, None], missing, rcond=1e-12)[0]
            joints = joints + np.linalg.lstsq(jacobian * weights[:, None], off * weights, rcond=1e-12)[0]
            jacobian = tcp.jacobian(joints)
        return None

    def _pose(self, led: Led, state: Array) -> tuple[Array, Array, Array]:
        """Return point (3,), rotation (3, 3) and twist (6,) of a tool centre point at joints and rates (2, n)."""
        joints, rates = state[:, led.columns]
        pose = led.tcp.pose(joints)
        return pose[:3, 3], pose[:3, :3], led.tcp.jacobian(joints) @ rates


def superposed(
    before: PiecewisePolynomial,
    after: PiecewisePolynomial,
    length: float,
    place: Fade,
    turn: Fade,
    leds: Sequence[Led],
) -> PiecewisePolynomial | None:
    """Return the way through a corner in joint space, from 0 to `2 length`; None where the joints can't make it.

    It replaces the last `length` of `before` and the first of `after`, in whose parameter the fades are, too: `place`
    is that of the tool centre points' positions, `turn` that of their orientation and of joints that lead none of them.
    Without tool centre points all joints have the first one. The way has the values and two derivatives of both at its
    ends.
    """
    both = _Sum(before, after, place, turn, leds)
    difference = _DIFFERENCE * length
    known = {-length: before.state(before.end - length, 2), length: after.state(after.start + length, 2)}

    def node(s: float) -> Array | None:
        if s not in known:
            left, here, right = (both.state(one) for one in (s - difference, s, s + difference))
            if left is None or here is None or right is None:
                return None
            known[s] = np.array([*here, (right[1] - left[1]) / (2.0 * difference)])
        return known[s]

    knots = [knot for fade in (place, turn) for knot in fade.knots if abs(knot) < length - 2.0 * difference]
    places = [-length]
    for knot in [*sorted(knots), length]:
        if knot - places[-1] > 4.0 * difference:
            count = int(np.ceil((knot - places[-1]) / (2.0 * length) * _PARTS))
            places += np.linspace(places[-1], knot, count + 1)[1:].tolist()
    places[-1] = length
    for _ in range(_ROUNDS):
        nodes = [one for s in places if (one := node(s)) is not None]
        if len(nodes) < len(places):
            return None
        piece = quintic_hermite(np.array(places) + length, *np.array(nodes).transpose(1, 0, 2))
        middles = [0.5 * sum(pair) for pair in pairwise(places)]
        wanted = [both.state(middle) for middle in middles]
        halved = [
            middle
            for middle, one in zip(middles, wanted, strict=True)
            if one is None or np.abs(piece.state(middle + length, 0)[0] - one[0]).max() > _OFF
        ]
        if not halved:
            return piece
        places = sorted([*places, *halved])
    return piece
