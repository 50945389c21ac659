"""Crafts whose twist is linear in the speeds of their wheels: equal commands move them on exact arcs."""

from __future__ import annotations

import numpy as np
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_plugins.mobile.planar import arc, check_pose, check_seconds, check_twist, check_values

SIDEWAYS = 1e-12
"""Least speed of a wheel by a motion to the side (1/m) of a craft that can move so."""


class Rolling:
    """Craft with m driven wheels and nothing to steer.

    `rates` (m, 3): the speeds of the wheels for a twist of 1 each; wheels that contradict each other slip, and the
    craft moves by the least squares of their speeds.
    """

    passive_names: tuple[str, ...] = ()

    def __init__(self, names: tuple[str, ...], rates: Floats) -> None:
        """Take names and speeds of the wheels."""
        self.drive_names = names
        self._rates = rates
        self._twists = np.linalg.pinv(rates)
        self._sideways = bool(np.abs(rates[:, 1]).max() > SIDEWAYS)

    def step(
        self, world_t_base: Floats, drive_states: Floats, commands: Floats, seconds: float, /
    ) -> tuple[Floats, Floats]:
        """Return where base and wheels are after an exact arc."""
        pose = check_pose(world_t_base)
        check_seconds(seconds)
        states = check_values("states of drives", drive_states, self.drive_names)
        x, y, turn = (self.base_twist(states, commands) * seconds).tolist()
        return arc(pose, x, y, turn), states + commands * seconds

    def passive_states(
        self, passive_states: Floats, drive_states: Floats, commands: Floats, seconds: float, /
    ) -> Floats:
        """Return nothing: all wheels are driven."""
        return check_values("states of passive wheels", passive_states, ()).copy()

    def base_twist(self, drive_states: Floats, commands: Floats, /) -> Floats:
        """Return the twist (3,) of wheels told `commands`."""
        check_values("states of drives", drive_states, self.drive_names)
        return self._twists @ check_values("commands", commands, self.drive_names)

    def drive_commands(self, twist: Floats, drive_states: Floats, seconds: float, /) -> Floats:
        """Return the speeds of the wheels (m,) for a twist."""
        check_twist(twist, self._sideways)
        check_values("states of drives", drive_states, self.drive_names)
        check_seconds(seconds)
        return self._rates @ twist
