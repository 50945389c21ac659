"""External axes of a program: rails and positioners of the kernel, whose joints are `eax_a` to `eax_f`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from virtualrobot import Client, Robot
from virtualrobot.errors import WrongStateError
from virtualrobot.geometry import Matrix
from virtualrobot.motions.moves import Move

from virtualrobot_apps.languages.core.diagnostics import did_you_mean
from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.predefined import NO_AXIS

MOST = 6
"""Number of external axes that a place of RAPID has."""
LETTERS = "abcdef"


@dataclass(frozen=True, slots=True)
class Axis:
    """An external axis: its robot, its joint, and how much of RAPID's unit (mm or degrees) one of the kernel's is."""

    robot: Robot
    joint: str
    scale: float
    lower: float
    upper: float
    velocity: float


class External:
    """External axes of one arm, in the order in which places name them."""

    def __init__(self, client: Client, arm: str, units: Mapping[str, str]) -> None:
        """Take robots, by the names of the mechanical units that they are.

        Raises WrongStateError where they have more than six joints, the arm is one of them or stands on two of them.
        """
        self._client, self._arm = client, arm
        self.units = {unit.lower(): client.robot(robot) for unit, robot in units.items()}
        self.axes: list[Axis] = []
        for robot in self.units.values():
            kinds = robot.joint_types
            for joint in robot.joint_names:
                limits = robot.limits[joint]
                scale = 1000.0 if kinds[joint] == "prismatic" else math.degrees(1.0)
                self.axes.append(Axis(robot, joint, scale, limits.lower, limits.upper, limits.velocity))
        names = [robot.name for robot in self.units.values()]
        if arm in names or len(set(names)) < len(names):
            raise WrongStateError(
                f"external axes are robots of their own, each once, beside {arm!r}: {', '.join(names)}"
            )
        if len(self.axes) > MOST:
            raise WrongStateError(f"{', '.join(names)} have {len(self.axes)} joints; a place has {MOST} external axes")
        carriers = [(robot, link) for robot in self.units.values() if (link := self._link_under(robot)) is not None]
        if len(carriers) > 1:
            raise WrongStateError(f"{arm!r} stands on {carriers[0][0].name!r} and {carriers[1][0].name!r}; one can be")
        self._carrier = carriers[0] if carriers else None
        self._seat = np.eye(4)
        if self._carrier is not None:
            link = client.scene.pose(self._carrier[1])
            self._seat = np.linalg.inv(link) @ client.scene.pose(arm)

    def _link_under(self, robot: Robot) -> str | None:
        """Return the link of a robot on which the arm stands; None: it stands elsewhere."""
        at = self._client.scene.node(self._arm).parent
        links = set(robot.links)
        while at and at not in links:
            at = self._client.scene.node(at).parent if at != "world" else ""
        return at or None

    @property
    def carried(self) -> bool:
        """True where the arm stands on one of them."""
        return self._carrier is not None

    def now(self) -> np.ndarray:
        """Return where they are (rad or m)."""
        return np.array([one for robot in self.units.values() for one in robot.state.positions])

    def asked(self, values: list[float]) -> np.ndarray:
        """Return the external axes of a place (mm or degrees) in rad or m.

        Raises the faults ERR_ARGVALERR for an axis of which the place says nothing, and ERR_ROBLIMIT beyond a limit.
        """
        found = []
        for letter, axis, value in zip(LETTERS, self.axes, values, strict=False):
            if value >= NO_AXIS:
                said = (
                    f"the place says nothing (9E9) of the external axis {letter}, {axis.joint!r} of {axis.robot.name!r}"
                )
                raise RapidFault("ERR_ARGVALERR", said)
            if not axis.lower - 1e-6 <= value / axis.scale <= axis.upper + 1e-6:
                least, most = axis.lower * axis.scale, axis.upper * axis.scale
                said = f"the external axis {letter} can't be at {value:g}; its limits are {least:g} to {most:g}"
                raise RapidFault("ERR_ROBLIMIT", said)
            found.append(value / axis.scale)
        return np.array(found)

    def told(self, values: np.ndarray) -> list[float]:
        """Return positions (rad or m) as the external axes of a place (mm or degrees)."""
        each = [value * axis.scale for value, axis in zip(values.tolist(), self.axes, strict=True)]
        return each + [NO_AXIS] * (MOST - len(each))

    def unit(self, name: str) -> Robot:
        """Return the robot that a mechanical unit is; raises the fault ERR_ARGVALERR where there is none."""
        if name.lower() not in self.units:
            known = f"{did_you_mean(name, self.units)}; there are: {', '.join(self.units)}"
            raise RapidFault("ERR_ARGVALERR", f"no external axis is the mechanical unit {name!r}{known}")
        return self.units[name.lower()]

    def base(self, values: np.ndarray | None = None) -> Matrix:
        """Return where the base of the arm is in the world, with the axes at positions, or at 0."""
        if self._carrier is None:
            return self._client.scene.pose(self._arm)
        robot, link = self._carrier
        return self._links(robot, np.zeros(len(self.axes)) if values is None else values)[link] @ self._seat

    def plate(self, unit: str, values: np.ndarray) -> Matrix:
        """Return where the plate of a mechanical unit, its flange, is in the world, with the axes at positions."""
        robot = self.unit(unit)
        return self._links(robot, values)[robot.flange]

    def _links(self, robot: Robot, values: np.ndarray) -> dict[str, Matrix]:
        mine = zip(self.axes, values.tolist(), strict=True)
        return robot.solve_forward({axis.joint: one for axis, one in mine if axis.robot is robot}).world_t_link

    def moves(self, goal: np.ndarray, before: np.ndarray, speed: list[float]) -> list[Move]:
        """Return the moves of the axes to positions from others, no faster than `v_leax` and `v_reax` of speed data."""
        found: list[Move] = []
        ways = list(zip(self.axes, goal.tolist(), (np.abs(goal - before) > 1e-9).tolist(), strict=True))
        for robot in self.units.values():
            mine = [(axis, one) for axis, one, moves in ways if axis.robot is robot and moves]
            if mine:
                shares = [speed[2 if axis.scale == 1000.0 else 3] / axis.scale / axis.velocity for axis, _ in mine]
                factor = min(1.0, max(1e-3, min(shares)))
                found.append(robot.ptp({axis.joint: one for axis, one in mine}, speed_factor=factor))
        return found
