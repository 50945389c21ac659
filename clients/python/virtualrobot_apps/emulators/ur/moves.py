"""Moves of an emulated controller: where the joints shall be in the next cycle, by its own limits of a move.

Each is asked once a cycle, by `advance`, for the setpoint (6,) after so many seconds, and says when it is over.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from virtualrobot.geometry import pose_between, rotation_from_vector, rotation_vector_of

from virtualrobot_apps.emulators.ur import kinematics
from virtualrobot_apps.emulators.ur.kinematics import Floats, Model

_DAMPING = 1e-6
"""Square of the smallest singular value at which velocities of the TCP are half of what is wanted."""
_SHORTEST = 1e-6
"""Way (m, rad) of the shortest move that another one may join."""
_BEHIND = np.radians(170.0)
"""Angle (rad) between the way of the TCP and that to a pose above which the pose is behind it."""
_FASTEST = np.pi
"""Speed (rad/s) of the fastest joint at which velocities of the TCP are kept: near a singularity they are less."""


class Move(Protocol):
    """Something that moves the setpoint."""

    over: bool
    """It moves nothing more."""

    def advance(self, here: Floats, velocity: Floats, seconds: float) -> Floats:
        """Return the setpoint (6,) after `seconds`; `here` and `velocity` (6,) are the setpoint's own until now."""
        ...


class Ramp:
    """Way along a path of a length, by constant acceleration, speed and braking."""

    def __init__(self, length: float, speed: float, acceleration: float, begin: float = 0.0) -> None:
        """Begin at a speed; speed and acceleration are above 0."""
        self._length, self._speed, self._acceleration = length, speed, acceleration
        self.way, self.now = 0.0, begin

    def advance(self, seconds: float) -> bool:
        """Go on for `seconds`; return whether the end is reached."""
        left = self._length - self.way
        change = self._acceleration * seconds
        most = min(max(self._speed, self.now - change), np.sqrt(2.0 * self._acceleration * max(left, 0.0)))
        self.now = min(self.now + change, most)
        if left <= max(self.now * seconds, 1e-9):
            self.way = self._length
            return True
        self.way += self.now * seconds
        return False


class Bend:
    """Parabola that leaves one line before its end and joins the next one: the Bezier curve of second degree.

    Attributes:
        length: its length, as `measure` has it of a step.
    """

    def __init__(self, first: Floats, corner: Floats, last: Floats, measure: Callable[[Floats], float]) -> None:
        """Go from `first` (k,), on the way to `corner` (k,), to `last` (k,), on the way from it."""
        u = np.linspace(0.0, 1.0, 129)[:, None]
        self._points = (1.0 - u) ** 2 * first + 2.0 * u * (1.0 - u) * corner + u**2 * last
        steps = [measure(step) for step in np.diff(self._points, axis=0)]
        self._ways = np.concatenate([[0.0], np.cumsum(steps)])
        self.length = float(self._ways[-1])

    def at(self, way: float) -> Floats:
        """Return the point (k,) after so long a way."""
        return np.array([np.interp(way, self._ways, column) for column in self._points.T])


def _leading(step: Floats) -> float:
    """Return the way of the joint that has the longest."""
    return float(np.abs(step).max())


class JointMove:
    """movej: all joints arrive together, the one with the longest way at its speed and acceleration.

    Attributes:
        goal: where it ends, (6,).
        blends: the next one may join it before its end.
    """

    def __init__(self, start: Floats, goal: Floats, speed: float, acceleration: float) -> None:
        """Go from `start` to `goal` (6,), rad/s and rad/s^2 of the leading joint."""
        self.goal = goal
        self._start, self._way = start, goal - start
        self._bend: Bend | None = None
        self._length = _leading(self._way)
        self._ramp = Ramp(self._length, speed, acceleration)
        self.blends = self._length > _SHORTEST
        self.over = False

    @classmethod
    def after(
        cls, before: JointMove, here: Floats, goal: Floats, share: float, speed: float, acceleration: float
    ) -> JointMove:
        """Go on from `here` (6,), where another move is, past its end to `goal` (6,).

        The bend joins the way from there to the goal at a share of it.
        """
        last = before.goal + (goal - before.goal) * share
        move = cls(last, goal, speed, acceleration)
        move._bend = Bend(here, before.goal, last, _leading)
        move._ramp = Ramp(move._length + move._bend.length, speed, acceleration, before._ramp.now)
        move.blends = True
        return move

    def advance(self, here: Floats, velocity: Floats, seconds: float) -> Floats:
        """Return the next setpoint."""
        self.over = self._ramp.advance(seconds)
        way = self._ramp.way
        if self._bend is not None:
            if way < self._bend.length:
                return self._bend.at(way)
            way -= self._bend.length
        return self._start + self._way * (way / self._length if self._length else 1.0)


class LineMove:
    """movel: the TCP goes along a line and turns about one axis meanwhile.

    Attributes:
        goal: the TCP's pose where it ends, (4, 4).
        blends: the next one may join it before its end.
    """

    def __init__(
        self,
        model: Model,
        start: Floats,
        pose: Floats,
        tcp: Floats,
        speed: float,
        acceleration: float,
        begin: float = 0.0,
    ) -> None:
        """Go from the joints `start` (6,) to the TCP's `pose` (4, 4), m/s and m/s^2; rad/s where it turns alone.

        It is at the speed `begin` already.

        Raises NoPosture where the end can't be reached along the line.
        """
        self._model, self._tcp, self._from = model, tcp, kinematics.forward(model, start, tcp)
        self._shift = pose[:3, 3] - self._from[:3, 3]
        self._turn = rotation_vector_of(pose[:3, :3] @ self._from[:3, :3].T)
        self._length = self._measure()
        self._ramp = Ramp(self._length, speed, acceleration, begin)
        self.goal, self.over = pose, False
        self.blends = float(np.linalg.norm(self._shift)) > _SHORTEST
        positions = start
        for share in np.linspace(0.0, 1.0, 21)[1:]:
            positions = kinematics.inverse(model, self._at(share), positions, tcp)

    def _measure(self) -> float:
        """Return the length of the way."""
        return float(np.linalg.norm(self._shift)) or float(np.linalg.norm(self._turn))

    def _place(self, share: float) -> Floats:
        """Return the TCP's position (3,) at a share of the way."""
        return self._from[:3, 3] + self._shift * share

    def _at(self, share: float) -> Floats:
        pose = np.eye(4)
        pose[:3, :3] = rotation_from_vector(self._turn * share) @ self._from[:3, :3]
        pose[:3, 3] = self._place(share)
        return pose

    def advance(self, here: Floats, velocity: Floats, seconds: float) -> Floats:
        """Return the next setpoint."""
        self.over = self._ramp.advance(seconds)
        pose = self._at(self._ramp.way / self._length if self._length else 1.0)
        return kinematics.inverse(self._model, pose, here, self._tcp)


class BlendedLine(LineMove):
    """movel after another one, whose end it cuts: along a parabola from the first line to the second one."""

    def __init__(self, before: LineMove, start: Floats, pose: Floats, speed: float, acceleration: float) -> None:
        """Go on from the joints `start` (6,), where another line is, past its end to the TCP's `pose` (4, 4).

        The parabola is as long on both lines, but at most half of the second one. Raises NoPosture as a line does.
        """
        model, tcp, corner = before._model, before._tcp, before.goal
        now = kinematics.forward(model, start, tcp)
        shift, turn = pose[:3, 3] - corner[:3, 3], rotation_vector_of(pose[:3, :3] @ corner[:3, :3].T)
        length = float(np.linalg.norm(shift))
        share = min(0.5, float(np.linalg.norm(corner[:3, 3] - now[:3, 3])) / length)
        self._last = np.eye(4)
        self._last[:3, :3] = rotation_from_vector(turn * share) @ corner[:3, :3]
        self._last[:3, 3] = corner[:3, 3] + shift * share
        self._bend = Bend(now[:3, 3], corner[:3, 3], self._last[:3, 3], lambda step: float(np.linalg.norm(step)))
        self._first, self._rest = now, pose
        self._rest_length = length * (1.0 - share)
        super().__init__(model, start, pose, tcp, speed, acceleration, before._ramp.now)

    def _measure(self) -> float:
        return self._bend.length + self._rest_length

    def _at(self, share: float) -> Floats:
        way = share * self._length
        on_bend = way < self._bend.length
        if on_bend:
            begin, end, part = self._first, self._last, way / self._bend.length
        else:
            begin, end, part = self._last, self._rest, (way - self._bend.length) / self._rest_length
        pose = pose_between(begin, end, part)
        if on_bend:
            pose[:3, 3] = self._bend.at(way)
        return pose


class ArcMove(LineMove):
    """movec: the TCP goes along the arc of a circle through three places, and turns about one axis meanwhile."""

    def __init__(
        self,
        model: Model,
        start: Floats,
        via: Floats,
        pose: Floats,
        tcp: Floats,
        speed: float,
        acceleration: float,
        begin: float = 0.0,
    ) -> None:
        """Go from the joints `start` (6,) past the place `via` (3,) to the TCP's `pose` (4, 4), as a line does.

        Raises NoPosture where the three places are on a line, or the arc can't be gone along.
        """
        first = kinematics.forward(model, start, tcp)[:3, 3]
        chord, other = pose[:3, 3] - first, via - first
        normal = np.cross(other, chord)
        if np.linalg.norm(normal) < 1e-9:
            raise kinematics.NoPosture("the three places of an arc are on a line, or two of them are one")
        # The centre is as far from all three: solved in the plane of the circle (Cramer's rule for its two bisectors).
        square = float(normal @ normal)
        centre = (float(other @ other) * np.cross(chord, normal) + float(chord @ chord) * np.cross(normal, other)) / (
            2.0 * square
        )
        self._centre, self._arm = first + centre, -centre
        self._axis = normal / np.sqrt(square)
        side = np.cross(self._axis, self._arm)
        end = chord - centre
        self._angle = float(np.arctan2(end @ side, end @ self._arm)) % (2.0 * np.pi)
        super().__init__(model, start, pose, tcp, speed, acceleration, begin)
        self.blends = False

    def _measure(self) -> float:
        return float(np.linalg.norm(self._arm)) * self._angle

    def _place(self, share: float) -> Floats:
        return self._centre + rotation_from_vector(self._axis * self._angle * share) @ self._arm


class TangentArc:
    """servoc: the TCP goes on as it moves, along the arc of a circle that leads to a pose; from rest along a line.

    Attributes:
        goal: the TCP's pose where it ends, (4, 4).
        blends: the next one may join it before its end.
    """

    def __init__(
        self,
        model: Model,
        start: Floats,
        velocity: Floats,
        pose: Floats,
        tcp: Floats,
        speed: float,
        acceleration: float,
    ) -> None:
        """Go from the joints `start` (6,), at their `velocity` (6,), to the TCP's `pose` (4, 4), as a line does.

        Raises NoPosture where the pose is behind the TCP, or the way can't be gone along.
        """
        first = kinematics.forward(model, start, tcp)[:3, 3]
        chord = pose[:3, 3] - first
        along = (kinematics.jacobian(model, start, tcp) @ velocity)[:3]
        begin, length = float(np.linalg.norm(along)), float(np.linalg.norm(chord))
        self.goal, self.blends, self.over = pose, True, False
        self._way: LineMove
        aside = np.cross(along, chord)
        # Angle of the way to the chord: the arc turns by twice as much, and its middle is half its tangent aside.
        angle = float(np.arctan2(np.linalg.norm(aside), along @ chord))
        if begin < _SHORTEST or length < _SHORTEST or angle < _SHORTEST:
            self._way = LineMove(model, start, pose, tcp, speed, acceleration, begin if length >= _SHORTEST else 0.0)
            return
        if angle > _BEHIND:
            raise kinematics.NoPosture("servoc can't turn back at once: its pose is behind the tool")
        out = np.cross(chord, aside)
        via = first + chord / 2.0 + out / np.linalg.norm(out) * (length / 2.0 * np.tan(angle / 2.0))
        self._way = ArcMove(model, start, via, pose, tcp, speed, acceleration, begin)

    def advance(self, here: Floats, velocity: Floats, seconds: float) -> Floats:
        """Return the next setpoint."""
        goal = self._way.advance(here, velocity, seconds)
        self.over = self._way.over
        return goal


class Servo:
    """servoj: the setpoint is what came last."""

    over = False

    def __init__(self, goal: Floats) -> None:
        """Follow `goal` (6,), which may be set anew at any time."""
        self.goal = goal

    def advance(self, here: Floats, velocity: Floats, seconds: float) -> Floats:
        """Return the goal."""
        return self.goal


class Speed:
    """speedj and speedl: velocities that are reached by an acceleration, and held for a time."""

    over = False

    def __init__(self, model: Model, tcp: Floats) -> None:
        """Stand."""
        self._model, self._tcp = model, tcp
        self.wanted, self.linear, self.acceleration, self.seconds = np.zeros(6), False, 1.0, 0.0

    def set(self, wanted: Floats, linear: bool, acceleration: float, seconds: float) -> None:
        """Go at `wanted` (6,): rad/s of the joints, or of the TCP m/s and rad/s; for `seconds`, 0: until told."""
        self.wanted, self.linear, self.acceleration = wanted, linear, acceleration
        self.seconds = seconds if seconds > 0.0 else np.inf

    def advance(self, here: Floats, velocity: Floats, seconds: float) -> Floats:
        """Return the next setpoint."""
        wanted = self.wanted if self.seconds > 0.5 * seconds else np.zeros(6)
        self.seconds -= seconds
        if self.linear:
            slope = kinematics.jacobian(self._model, here, self._tcp)
            wanted = slope.T @ np.linalg.solve(slope @ slope.T + _DAMPING * np.eye(6), wanted)
            wanted = wanted * min(1.0, _FASTEST / max(float(np.abs(wanted).max()), 1e-12))
        change = self.acceleration * seconds
        return here + (velocity + np.clip(wanted - velocity, -change, change)) * seconds


class Stop:
    """stopj: all joints slow down together, the fastest one at the deceleration (rad/s^2)."""

    def __init__(self, deceleration: float) -> None:
        """Slow down."""
        self._deceleration = max(deceleration, 0.1)
        self.over = False

    def advance(self, here: Floats, velocity: Floats, seconds: float) -> Floats:
        """Return the next setpoint."""
        fastest = float(np.abs(velocity).max())
        left = max(0.0, fastest - self._deceleration * seconds)
        self.over = left == 0.0
        return here if self.over else here + velocity * (left / fastest) * seconds


PLANNED = (JointMove, LineMove, TangentArc)
"""Moves that the controller plans itself, and its speed slider slows."""
