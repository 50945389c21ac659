"""Programs that lead a tool along the ways of curves: there, along lines and arcs, and away from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot import Client, Program, Robot, pose
from virtualrobot.errors import InvalidArgumentError, LimitError, UnknownNameError, VirtualRobotError

from virtualrobot_apps.curves.curve import Floats
from virtualrobot_apps.curves.frames import frames
from virtualrobot_apps.curves.way import Way

LEAST_ZONE = 1e-4
"""Radius (m) of a corner below which the tool stops there."""


@dataclass(frozen=True, slots=True, eq=False)
class Following:
    """Steps that lead a tool along ways.

    Attributes:
        program: the steps.
        places: of each step where it ends, such as `C1, point 3`.
        turns: whether the tool turns with the curve.
    """

    program: Program
    places: tuple[str, ...]
    turns: bool = False

    def error(self, error: VirtualRobotError) -> VirtualRobotError:
        """Return an error of planning with the point of the curve that its step leads to, and a way out of it."""
        step = error.metadata.get("step", "")
        if not step.isdigit() or int(step) >= len(self.places) or isinstance(error, UnknownNameError):
            return error
        words = f"{self.places[int(step)]}: {error.message}"
        if self.turns and isinstance(error, LimitError):
            words += "; the tool turns along the curve, and --no-turn keeps it from that"
        return type(error)(words, error.reason, error.metadata, error.code)


def following(
    client: Client,
    robot: Robot,
    ways: list[Way],
    axis: ArrayLike,
    *,
    speed: float,
    approach: float,
    tolerance: float,
    reference: str = "world",
    turn: bool = True,
) -> Following:
    """Return a program along each way: to `approach` (m) before its first point, along it at `speed` (m/s), back.

    The tool centre point's z goes along `axis` (3,), in the frame of `reference` as the ways are. Corners are rounded
    off as far as the tool stays within `tolerance` (m) of them; at others it stops.

    Raises InvalidArgumentError where nothing is given, and for numbers that are not above 0.
    """
    for what, value in (("speed", speed), ("approach", approach), ("tolerance", tolerance)):
        if not (np.isfinite(value) and value > 0.0):
            raise InvalidArgumentError(f"the {what} is {value:g}; it must be above 0")
    program, places = client.program(), list[str]()
    for way in ways:
        poses, zones = frames(way, axis, turn=turn), _zones(way, tolerance)
        vias = np.full((len(poses) - 1, 3), np.nan) if way.vias is None else way.vias
        before = [one @ pose(z=-approach) for one in (poses[0], poses[-1])]
        program.move(robot.ptp(before[0], reference=reference))
        program.move(robot.linear(poses[0], reference=reference, velocity=speed))
        places += [f"before {way.names[0]}", way.names[0]]
        for place, (goal, via, zone) in enumerate(zip(poses[1:], vias, zones[1:], strict=True), 1):
            if np.isnan(via[0]):
                move = robot.linear(goal, reference=reference, velocity=speed)
            else:
                move = robot.circular(via, goal, reference=reference, velocity=speed)
            program.move(move, zone=float(zone) if zone > 0.0 else None)
            places.append(way.names[place])
        program.move(robot.linear(before[1], reference=reference, velocity=speed))
        places.append(f"after {way.names[-1]}")
    if not places:
        raise InvalidArgumentError("there are no curves to follow")
    return Following(program, tuple(places), turn)


def _zones(way: Way, tolerance: float) -> Floats:
    """Return the radii (n,) in m of the corners at the points; 0 where the tool stops.

    Half of the tolerance is for the corner: a parabola that leaves one of angle a at the radius r passes it at
    r sin(a / 2) / 2. The other half is for arcs, which are off their tangent by r^2 / 2 R at the radius r.
    """
    lengths, bends, radii = way.lengths(), np.sin(0.5 * way.corners()), way.radii()
    most = np.minimum(0.5 * lengths, np.sqrt(radii * tolerance))
    most = np.concatenate([[0.0], np.minimum(most[:-1], most[1:]), [0.0]])
    with np.errstate(divide="ignore"):
        zones = np.minimum(most, tolerance / bends)
    return np.where(zones >= LEAST_ZONE, zones, 0.0)
