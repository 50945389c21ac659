"""A vehicle under water that a person pilots: it goes as it is told, and keeps upright, its heading and its place."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Mapping
from pathlib import Path

import click
import numpy as np
import virtualrobot
from virtualrobot import Client
from virtualrobot.cli.gamepad import Pad
from virtualrobot.cli.gamepad_mapping import TOOL, GamepadMapping
from virtualrobot.cli.held_pad import HeldPad
from virtualrobot.cli.key_screen import KeyScreen
from virtualrobot.cli.teleop import PAD_SECONDS
from virtualrobot.cli.teleoperation import KEYS, DriveKeys, Teleoperation, Values
from virtualrobot.errors import WrongStateError

from virtualrobot_apps.vehicles import sail
from virtualrobot_apps.vehicles.autopilot import Autopilot, Gains
from virtualrobot_apps.vehicles.guidance import Floats, Wanted
from virtualrobot_apps.vehicles.vehicle_file import VehicleFile, read

SPEED, TURN = 0.5, 0.6
"""Greatest speed (m/s) along each axis and turning rate (rad/s)."""
PILOT_KEYS: Mapping[str, Values] = {
    **{key: (ahead, left, 0.0, turn) for key, (ahead, left, turn) in KEYS.items()},
    "t": (0.0, 0.0, 1.0, 0.0),
    "b": (0.0, 0.0, -1.0, 0.0),
}
"""Parts of the limits that keys mean: ahead, left, up and turn; t and b as in teleop_twist_keyboard of ROS."""
HELP = (
    "w s, up down: ahead, back   a d, left right: turn   J L: sideways   t b: up, down   u o, m .: in a bow\n"
    "hold a key to go on: without one it keeps its place   [ ] slower, faster   q ends"
)
NAMES = "m/s ahead, left, up, rad/s"
MAPPING = Path(__file__).with_name("pilot_gamepad.yaml")
"""Mapping of gamepads that is taken where none is named."""


class Pilot:
    """Leads a vehicle by what a person wants: a velocity (4,) ahead, left, up (m/s) and a turning rate (rad/s).

    A context manager. From the first wish on the autopilot holds the vehicle upright, and in its place while nothing is
    wanted. What the kernel refuses is in `error`; its thrusters stand then until something is wanted anew.
    """

    def __init__(
        self, client: Client, name: str, vehicle: VehicleFile, told: Callable[[], Values], preempt: bool = False
    ) -> None:
        """Take a robot that is a craft by `fossen`, of this vehicle's file; `preempt`: cancel motions in the way.

        Raises WrongStateError for a vehicle whose thrusters cannot move it in all these directions, and a robot whose
        base does not float.
        """
        self._robot, self._told = client.robot(name), told
        thrusters, types = vehicle.thrusters, self._robot.joint_types
        reached = thrusters.allocation @ np.linalg.pinv(thrusters.allocation)
        for axis, said in {0: "ahead", 1: "sideways", 2: "up", 5: "about the vertical"}.items():
            if abs(reached[axis, axis] - 1.0) > 1e-6:
                raise WrongStateError(f"the thrusters of {name!r} cannot move it {said} alone; nobody can pilot it so")
        base = next(iter(types))
        if types[base] != "floating":
            raise WrongStateError(f"{name!r} does not float: its first joint is {types[base]}; load a floating base")
        self._mounting = client.scene.pose(name)[:3, :3]
        self._gains = Gains()
        self._autopilot = Autopilot(vehicle, self._gains)
        self._resting: Values = (0.0,) * len(thrusters.names)
        self._holds, self._turning = False, False
        self._heading, self._at = 0.0, math.nan
        self.told: Values = (0.0,) * 4
        self.place = self._pose()[0]
        self._driving: Teleoperation | None = None
        self._driving = Teleoperation(self._robot, self._speeds, preempt, thrusters.names)

    @property
    def error(self) -> str:
        """Refusal of the kernel in its words; empty without one."""
        return self._driving.error if self._driving is not None else ""

    @property
    def heading(self) -> float:
        """Heading that is kept (rad)."""
        return self._heading

    def _pose(self) -> tuple[Floats, Floats, Floats, float]:
        """Return place (3,), rotation (3, 3) in the world, twist (6,) along its own axes, and the time of these (s)."""
        state = self._robot.state
        turned = virtualrobot.pose_from_quaternion((0.0, 0.0, 0.0), state.positions[3:7].tolist())[:3, :3]
        twist = np.concatenate([turned.T @ state.velocities[:3], state.velocities[3:6]])
        return state.world_t_tcp[:3, 3].copy(), self._mounting @ turned, twist, state.stamp.simulation_time

    def _speeds(self) -> Values:
        """Return the speeds of the thrusters (m,) (rad/s)."""
        self.told = self._told()
        *along, turn = self.told
        if any(self.told):
            self._holds = True
        elif self.error:
            self._holds = False
        if not self._holds:
            self._at = math.nan
            return self._resting
        self.place, rotation, twist, now = self._pose()
        heading = math.atan2(rotation[1, 0], rotation[0, 0])
        if turn:
            # As far ahead as the autopilot's second order lets it turn by that rate.
            self._heading = heading + 2.0 * turn / self._gains.heading
        elif self._turning or math.isnan(self._at):
            # Where it comes to rest without turning back.
            self._heading = heading + twist[5] / self._gains.heading
        elapsed = 0.0 if math.isnan(self._at) else now - self._at
        self._turning, self._at = bool(turn), now
        c, s = math.cos(heading), math.sin(heading)
        velocity = np.array([c * along[0] - s * along[1], s * along[0] + c * along[1], along[2]])
        return tuple(self._autopilot.speeds(Wanted(velocity, self._heading), rotation, twist, elapsed).tolist())

    def __enter__(self) -> Pilot:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Let the thrusters come to rest; the vehicle drifts on."""
        if self._driving is not None:
            self._driving.close()


def by_keys(client: Client, name: str, vehicle: VehicleFile, preempt: bool = False) -> None:
    """Let somebody pilot a vehicle by the keys of this terminal, until q."""
    keys = DriveKeys((SPEED, SPEED, SPEED, TURN), PILOT_KEYS)
    with Pilot(client, name, vehicle, keys.wanted, preempt) as pilot:
        KeyScreen(keys.press, lambda: f"{HELP}\n{shown(name, pilot, keys.share)}").run()


def by_pad(
    client: Client, name: str, vehicle: VehicleFile, pad: Pad, mapping: GamepadMapping, preempt: bool = False
) -> None:
    """Let somebody pilot a vehicle by a gamepad or a space mouse, by `tool` of its mapping, until q.

    Raises WrongStateError for a mapping without it, and when the device has gone; the thrusters stand then.
    """
    held = held_pad(pad, mapping)

    async def follow() -> None:
        while True:
            held.read()
            await asyncio.sleep(PAD_SECONDS)

    with Pilot(client, name, vehicle, held.wanted, preempt) as pilot:

        def text() -> str:
            held_on = "" if held.is_held else f"   hold {mapping.hold} to move"
            return f"{pad.name}{held_on}   q ends\n{shown(name, pilot, held.share)}"

        KeyScreen(lambda key: None, text, follow=follow).run()


def held_pad(pad: Pad, mapping: GamepadMapping) -> HeldPad:
    """Return the wishes of a gamepad or a space mouse; raise WrongStateError for a mapping without `tool`."""
    if not mapping.tool:
        raise WrongStateError("the mapping has no 'tool', whose vx, vy, vz and wz pilot a vehicle")
    controls = [mapping.tool.get(part) for part in TOOL if part not in ("wx", "wy")]
    return HeldPad(pad, mapping, controls, [SPEED, SPEED, SPEED, TURN])


def shown(name: str, pilot: Pilot, share: float) -> str:
    """Return lines that tell where a vehicle is and what it is told."""
    x, y, z = pilot.place
    told = ", ".join(f"{value:z.2f}" for value in pilot.told)
    place = f"{name} at {x:z.2f} {y:z.2f} {z:z.2f} m, heading {math.degrees(pilot.heading):z.0f} deg"
    return f"{place}   {told} {NAMES}   {100.0 * share:.0f}% of the limits\n{pilot.error}"


def main(client: Client, pad: Pad | None = None, mapping: GamepadMapping | None = None) -> None:
    """Replace the world by a BlueROV2 Heavy among piles, in a current, and let somebody pilot it."""
    vehicle = read(sail.VEHICLE)
    sail.build(client, vehicle, [])
    if client.clock.mode == "stepped":
        client.clock.set_realtime()
    if pad is None or mapping is None:
        by_keys(client, sail.ROBOT, vehicle)
    else:
        by_pad(client, sail.ROBOT, vehicle, pad, mapping)
    x, y, z = client.scene.pose(f"{sail.ROBOT}.hull")[:3, 3]
    click.echo(f"{sail.ROBOT} is at {x:z.2f}, {y:z.2f}, {z:z.2f} m, left to the water")
