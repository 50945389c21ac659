"""Circle of an arc: through a point, or about a centre; or the refusal that says by how much it is none."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt, tau

import numpy as np

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.arc import Arc
from virtualrobot_kernel.motion.cartesian_path import turn_between
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.pose_check import check_pose

#: Points nearer to each other than this are the same, and three points less than this off a line are in a line (m):
#: an arc is promised to 0.01 mm, so within that it would not be told from a line.
IN_LINE = 1e-5
#: By how much start and goal may differ in their distance from a given centre, or lie off its plane (m).
CENTER_TOLERANCE = 1e-4
#: The greatest angle of an arc in rad: ten turns.
GREATEST_ANGLE = 10.0 * tau


@dataclass(frozen=True, eq=False)
class Via:
    """Arc through a via point (3,) in m to a goal."""

    point: Array

    def seen_from(self, frame_t_own: Array) -> Via:
        """Return the same in the frame in which its own has the pose `frame_t_own` (4, 4)."""
        return Via(_moved(frame_t_own, self.point))


@dataclass(frozen=True, eq=False)
class Center:
    """Arc about a point (3,) in m.

    axis (3,): the arc turns about it by the right hand; None: the shorter way. angle: by how much in rad, negative
    for the other way round; None: until the goal.
    """

    point: Array
    axis: Array | None = None
    angle: float | None = None

    def seen_from(self, frame_t_own: Array) -> Center:
        """Return the same in the frame in which its own has the pose `frame_t_own` (4, 4)."""
        axis = None if self.axis is None else frame_t_own[:3, :3] @ self.axis
        return Center(_moved(frame_t_own, self.point), axis, self.angle)


def arc(base_t_start: Array, shape: Via | Center, base_t_goal: Array | None, with_arc: bool = False) -> Arc:
    """Return the arc from a pose (4, 4) to another one, all in the base frame; with an angle the goal may be None.

    The orientation turns evenly from the start's to the goal's the shorter way, and stays when there is no goal;
    `with_arc`: it turns as the arc does, whatever the goal's is. Raises KernelError, which names the points and by how
    much they are wrong, when they don't make an arc.
    """
    start = np.array(base_t_start, dtype=np.float64)
    if base_t_goal is not None:
        check_pose(base_t_goal, "the goal of a CIRC motion")
    end = None if base_t_goal is None else base_t_goal[:3, 3]
    if isinstance(shape, Via):
        _check_finite(shape.point, "the via point of a CIRC motion")
        if end is None:
            raise KernelError("a CIRC motion through a via point needs a goal")
        circle = _through(start[:3, 3], shape.point, end)
    else:
        circle = _about(start[:3, 3], shape, end)
    center, axis, sweep, via = circle
    inward = center - start[:3, 3]
    radius = float(np.linalg.norm(inward))
    inward = inward / radius
    rotation = np.zeros(3)
    if with_arc:
        rotation = sweep * axis
    elif base_t_goal is not None:
        rotation = turn_between(start, base_t_goal)
    return Arc(start, rotation, np.cross(inward, axis), inward, radius, sweep, via)


_Circle = tuple[Array, Array, float, float | None]
"""Centre (3,) in m, unit axis (3,), angle about it in rad, above 0, and the fraction of a via point."""


def _through(start: Array, via: Array, goal: Array) -> _Circle:
    """Return the circle through three points (3,)."""
    for one, other, words in (
        (start, via, "the via point is the start"),
        (via, goal, "the via point is the goal"),
        (start, goal, "start and goal are the same point; for a whole turn give a centre, an axis and an angle"),
    ):
        if (distance := float(np.linalg.norm(one - other))) < IN_LINE:
            raise KernelError(
                f"three points make an arc, but {words}: {_words(one)} and {_words(other)} are {1e3 * distance:.3g} mm "
                f"apart; they must be at least {1e3 * IN_LINE:g} mm apart",
                distance_meters=distance,
            )
    a, b = via - start, goal - start
    normal = np.cross(a, b)
    square = float(normal @ normal)
    longest = max(float(np.linalg.norm(side)) for side in (a, b, a - b))
    if (height := sqrt(square) / longest) < IN_LINE:
        raise KernelError(
            f"start {_words(start)}, via point {_words(via)} and goal {_words(goal)} are in a line: only "
            f"{1e3 * height:.3g} mm off it; an arc needs {1e3 * IN_LINE:g} mm at least, a line is a LIN motion",
            distance_meters=height,
        )
    # The centre of the circumcircle, by the vectors to two of its points from the third.
    center = start + np.cross((a @ a) * b - (b @ b) * a, normal) / (2.0 * square)
    axis = normal / sqrt(square)
    sweep = _turn(start - center, goal - center, axis)
    return center, axis, sweep, _turn(start - center, via - center, axis) / sweep


def _about(start: Array, shape: Center, goal: Array | None) -> _Circle:
    """Return the circle about a point, through start and goal (3,) where there is one."""
    center, axis, angle = shape.point, shape.axis, shape.angle
    _check_finite(center, "the centre of a CIRC motion")
    radius = float(np.linalg.norm(start - center))
    if radius < IN_LINE:
        raise KernelError(
            f"the centre {_words(center)} of the CIRC motion is its start {_words(start)}: they are "
            f"{1e3 * radius:.3g} mm apart; they must be at least {1e3 * IN_LINE:g} mm apart",
            distance_meters=radius,
        )
    if angle is not None:
        _check_angle(angle, radius)
        if axis is None:
            raise KernelError("a CIRC motion by an angle needs the axis about which it turns")
    elif goal is None:
        raise KernelError("a CIRC motion about a centre needs a goal, or an axis and an angle")
    same = goal is not None and float(np.linalg.norm(goal - start)) < IN_LINE
    if same and angle is None:
        raise KernelError(
            f"start and goal of the CIRC motion are the same point {_words(start)}; for a whole turn give an angle "
            f"of {tau:.6f} rad"
        )
    axis = _axis_of(start, center, goal) if axis is None else _unit(axis)
    if angle is not None and angle < 0.0:
        axis, angle = -axis, -angle
    _check_plane(start, center, axis, "start")
    if goal is None or same:
        assert angle is not None
        center = center + ((start - center) @ axis) * axis
        turn = 0.0 if same else angle
    else:
        _check_plane(goal, center, axis, "goal")
        _check_distances(start, goal, center)
        # Start and goal are on the arc exactly, so axis and centre give way by what they were off.
        chord = (goal - start) / np.linalg.norm(goal - start)
        axis = _unit(axis - (axis @ chord) * chord)
        offset = center - 0.5 * (start + goal)
        center = center - (offset @ chord) * chord - (offset @ axis) * axis
        turn = _turn(start - center, goal - center, axis)
    return center, axis, turn if angle is None else _whole(angle, turn, radius), None


def _axis_of(start: Array, center: Array, goal: Array | None) -> Array:
    """Return the unit axis (3,) about which the way from start to goal is the shorter one."""
    assert goal is not None
    normal = np.cross(start - center, goal - center)
    chord = float(np.linalg.norm(goal - start))
    height = float(np.linalg.norm(normal)) / chord
    if height < IN_LINE:
        raise KernelError(
            f"start {_words(start)}, centre {_words(center)} and goal {_words(goal)} are in a line: the centre is "
            f"{1e3 * height:.3g} mm off it; such an arc needs an axis about which it turns",
            distance_meters=height,
        )
    return _unit(normal)


def _whole(angle: float, turn: float, radius: float) -> float:
    """Return the angle at which the goal, `turn` after the start, is passed; `angle` says after how many turns."""
    exact = turn + tau * round((angle - turn) / tau)
    away = radius * abs(angle - exact)
    if away > CENTER_TOLERANCE or exact <= 0.0:
        raise KernelError(
            f"an arc of {angle:.6g} rad ends {1e3 * away:.4g} mm along the circle from the goal, which is at "
            f"{turn:.6g} rad; leave one of the two out, or let them agree to {1e3 * CENTER_TOLERANCE:g} mm",
            distance_meters=away,
        )
    return exact


def _check_angle(angle: float, radius: float) -> None:
    if not abs(angle) <= GREATEST_ANGLE * (1.0 + 1e-9):
        raise KernelError(
            f"the angle of a CIRC motion must be finite and at most {GREATEST_ANGLE:.4f} rad, ten turns, "
            f"not {angle:.6g}",
            angle=angle,
        )
    if abs(angle) * radius < IN_LINE:
        raise KernelError(
            f"an arc of {angle:.6g} rad has no length: {1e3 * abs(angle) * radius:.3g} mm at a radius of "
            f"{1e3 * radius:.4g} mm; it must be at least {1e3 * IN_LINE:g} mm",
            angle=angle,
        )


def _check_plane(point: Array, center: Array, axis: Array, what: str) -> None:
    off = float((point - center) @ axis)
    if abs(off) > CENTER_TOLERANCE:
        raise KernelError(
            f"the {what} {_words(point)} is {1e3 * abs(off):.4g} mm off the plane through the centre {_words(center)} "
            f"across the axis {_words(axis)}; it may be {1e3 * CENTER_TOLERANCE:g} mm",
            distance_meters=off,
        )


def _check_distances(start: Array, goal: Array, center: Array) -> None:
    first, last = float(np.linalg.norm(start - center)), float(np.linalg.norm(goal - center))
    if abs(first - last) > CENTER_TOLERANCE:
        raise KernelError(
            f"the centre {_words(center)} is {1e3 * first:.4f} mm from the start {_words(start)}, but "
            f"{1e3 * last:.4f} mm from the goal {_words(goal)}; they may differ by {1e3 * CENTER_TOLERANCE:g} mm",
            start_distance_meters=first,
            goal_distance_meters=last,
        )


def _check_finite(values: Array, what: str) -> None:
    if values.shape != (3,) or not np.all(np.isfinite(values)):
        raise KernelError(f"{what} must be three finite numbers, not {values.tolist()}")


def _moved(frame_t_own: Array, point: Array) -> Array:
    return frame_t_own[:3, :3] @ point + frame_t_own[:3, 3]


def _unit(axis: Array) -> Array:
    _check_finite(axis, "the axis of a CIRC motion")
    length = float(np.linalg.norm(axis))
    if length < 1e-9:
        raise KernelError(f"the axis of a CIRC motion must have a length above 0, not {axis.tolist()}")
    return axis / length


def _turn(first: Array, second: Array, axis: Array) -> float:
    """Return the angle in (0, 2 pi] that turns `first` to `second` (3,) about `axis` by the right hand."""
    angle = float(np.arctan2(np.cross(first, second) @ axis, first @ second))
    return angle if angle > 0.0 else angle + tau


def _words(point: Array) -> str:
    return "({:.6g}, {:.6g}, {:.6g})".format(*point.tolist())
