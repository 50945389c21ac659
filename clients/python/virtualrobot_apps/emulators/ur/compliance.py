"""Force mode: along chosen axes the tool moves until it pushes as it shall; along others it goes as its move does.

How it gives way is the law of `virtualrobot_apps.admittance`.
"""

from __future__ import annotations

import numpy as np
from virtualrobot.geometry import rotation_from_vector, rotation_vector_of

from virtualrobot_apps.admittance import DAMPING, Admittance
from virtualrobot_apps.emulators.ur import kinematics
from virtualrobot_apps.emulators.ur.kinematics import Floats, Model
from virtualrobot_apps.emulators.ur.moves import Move

USUAL_DAMPING = 0.025
"""Damping of force mode, by which `DAMPING` is meant with a gain of 1."""


class Compliance:
    """Force mode of a controller, from its begin to its end.

    Attributes:
        move: what moves the arm in it.
        planned: joints (6,) where that would have them if nothing gave way, and their `planned_velocity` (6,).
    """

    def __init__(self, move: Move | None, here: Floats, velocity: Floats, rate: float) -> None:
        """Begin where the setpoint is, (6,), at its velocity (6,); cycles are 1/rate seconds."""
        self.follow(move, here, velocity)
        self._dt = 1.0 / rate
        self._admittance = Admittance(rate)
        self._before: Floats | None = None
        self._frame, self._kind, self._damping = np.eye(4), 2, DAMPING
        self._chosen, self._wanted, self._limits = np.zeros(6, bool), np.zeros(6), np.zeros(6)

    def set(self, frame: Floats, chosen: Floats, wanted: Floats, kind: int, limits: Floats, damping: float) -> None:
        """Push by `wanted` (6,) N and Nm along the axes of a frame (4, 4) of the base that are `chosen` (6,).

        Args:
            frame: see `kind`.
            chosen: truth values.
            wanted: what the tool puts on what it touches.
            kind: 1: y points from the tool to the frame's origin; 2: the axes are the frame's; 3: x is along the tool's
                velocity in the frame's plane of x and y.
            limits: the highest speeds (6,) along chosen axes, m/s and rad/s.
            damping: a multiple of the usual one.
        """
        self._frame, self._chosen, self._wanted, self._kind = frame, chosen.astype(bool), wanted, kind
        self._limits, self._damping = limits, DAMPING * damping

    @property
    def resting(self) -> bool:
        """True where it gives way along no axis."""
        return not self._chosen.any()

    def rest(self) -> None:
        """Give way no more; the move that runs goes on beside where it would be."""
        self._chosen = np.zeros(6, bool)
        self._admittance.rest()

    def follow(self, move: Move | None, here: Floats, velocity: Floats) -> None:
        """Have another move, which begins where the setpoint is, (6,), at its velocity (6,)."""
        self.move, self.planned, self.planned_velocity = move, here, velocity

    def advance(
        self, model: Model, tcp: Floats, target: Floats, goal: Floats, felt: Floats, actual: Floats, pace: float
    ) -> Floats:
        """Return the next setpoint (6,).

        Args:
            model: the arm.
            tcp: the tool (4, 4).
            target: the setpoint until now, (6,).
            goal: where the move would have the joints next, (6,).
            felt: force and torque (6,) on the tool about the TCP, along the base's axes.
            actual: where the joints are, (6,), as long ago as `felt` was measured.
            pace: share of its speed at which it gives way, 0 where the program is paused.

        Raises NoPosture where the tool can't go.
        """
        before, after, here = (kinematics.forward(model, q, tcp) for q in (self.planned, goal, target))
        step = _step(before, after)
        axes = self._axes(here, step)
        along = _turned(axes.T, step)
        given = self._given(axes, kinematics.forward(model, actual, tcp), _turned(axes.T, felt), pace)
        along[self._chosen] = given[self._chosen] * self._dt
        step = _turned(axes, along)
        pose = np.eye(4)
        pose[:3, 3] = here[:3, 3] + step[:3]
        pose[:3, :3] = rotation_from_vector(step[3:]) @ here[:3, :3]
        self.planned, self.planned_velocity = goal, (goal - self.planned) / self._dt
        return kinematics.inverse(model, pose, target, tcp)

    def _axes(self, here: Floats, step: Floats) -> Floats:
        """Return the axes (3, 3) along which it gives way."""
        if self._kind == 2:
            return self._frame[:3, :3]
        z = self._frame[:3, 2]
        if self._kind == 1:
            y = self._frame[:3, 3] - here[:3, 3]
            length = float(np.linalg.norm(y))
            if length < 1e-6:
                return self._frame[:3, :3]
            y = y / length
            x = np.cross(y, z)
            if np.linalg.norm(x) < 1e-6:
                x = np.cross(y, self._frame[:3, 1])
            x = x / np.linalg.norm(x)
            return np.column_stack([x, y, np.cross(x, y)])
        x = step[:3] - z * float(z @ step[:3])
        length = float(np.linalg.norm(x))
        if length < 1e-9:
            return self._frame[:3, :3]
        x = x / length
        return np.column_stack([x, np.cross(z, x), z])

    def _given(self, axes: Floats, actual: Floats, force: Floats, pace: float) -> Floats:
        """Return the velocity (6,) along and about the axes by which the tool gives way to what is felt along them."""
        moved = np.zeros(6) if self._before is None else _turned(axes.T, _step(self._before, actual))
        self._before = actual
        return self._admittance.velocity(moved, force, self._wanted, self._limits, self._damping, pace)


def _step(first: Floats, second: Floats) -> Floats:
    """Return the way and the turn (6,) from one pose (4, 4) to another one, along the axes of their frame."""
    return np.concatenate([second[:3, 3] - first[:3, 3], rotation_vector_of(second[:3, :3] @ first[:3, :3].T)])


def _turned(turn: Floats, both: Floats) -> Floats:
    """Return a pair of vectors (6,), each turned by (3, 3)."""
    return np.concatenate([turn @ both[:3], turn @ both[3:]])
