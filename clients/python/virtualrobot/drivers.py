"""Drivers of real robots: connected, watched, set to a mode."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.messages import settings_message, value_or_default, words_of
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.showing import listed, shown
from virtualrobot.errors import InvalidArgumentError, UnknownNameError
from virtualrobot.v1 import driver_pb2

_MODES = words_of(driver_pb2.DriverMode, "DRIVER_MODE_")
_STATES = words_of(driver_pb2.DriverState, "DRIVER_STATE_")
_PACES = words_of(driver_pb2.ControllerPace, "CONTROLLER_PACE_")
_CONTROLLER_MODES = words_of(driver_pb2.ControllerMode, "CONTROLLER_MODE_")
_SAFETIES = words_of(driver_pb2.ControllerSafety, "CONTROLLER_SAFETY_")

MODES = tuple(_MODES.values())
"""The modes: `simulated`, `monitor`, `execute`."""


@shown
@dataclass(frozen=True, slots=True)
class Controller:
    """Controller of a real robot, as it says itself.

    Attributes:
        joint_count: number of its joints.
        rate: readings and setpoints a second (Hz).
        pace: `host`, `controller` or `jobs`: who says when the next setpoint is due.
        watchdog: time (s) without a setpoint after which it stops the robot by itself; 0: it doesn't.
        model: its model; empty where it doesn't tell.
        version: version of its software, likewise.
        serial: serial number, likewise.
        inputs: number of its digital inputs, the signals "ROBOT.di0" and on.
        outputs: number of its digital outputs, the signals "ROBOT.do0" and on.
    """

    joint_count: int
    rate: float
    pace: str
    watchdog: float
    model: str
    version: str
    serial: str
    inputs: int
    outputs: int


@shown
@dataclass(frozen=True, slots=True, eq=False)
class DriverStatus:
    """Driver of a robot as it is; arrays (k,) have the order of `joint_names`, rad or m, per s, and may be empty.

    Attributes:
        robot: the robot.
        component: the driver's component.
        mode: `simulated`, `monitor` or `execute`.
        state: `disconnected`, `connecting`, `inactive`, `beginning`, `active`, `stopping` or `error`.
        controller_mode: `off`, `starting`, `ready`, `running`, `hand_guided` or `local`; empty before a reading.
        safety: `normal`, `reduced`, `protective_stop`, `safeguard_stop`, `emergency_stop` or `fault`; likewise.
        text: the newest words of the controller, or of what went wrong; empty while there are none.
        code: its number of the error.
        clears: whether `reset` may help.
        controller: what it says of itself.
        joint_names: the robot's joints, in the controller's order.
        positions: where they were measured.
        velocities: how fast they were measured to be.
        outside_limits: joints that were measured outside of their limits.
        following_error: measured minus played; while the robot is played.
        follows_badly: whether it is beyond the warning.
        speed_scaling: share of the speed that it was told at which the controller goes.
        lead: how much later (s) than its twin the robot does things.
        play_rate: rate of the clock by which it is played.
        played_tick: the tick that is played.
        cycles: cycles since it connected.
        skipped_cycles: those that it came too late for.
        process_id: number of the driver's process on the kernel's machine.
        halted: whether motions of the robot are refused until `set_mode`: it follows no more though nobody chose so.
    """

    robot: str
    component: str
    mode: str
    state: str
    controller_mode: str
    safety: str
    text: str
    code: str
    clears: bool
    controller: Controller
    joint_names: tuple[str, ...]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]
    outside_limits: tuple[str, ...]
    following_error: NDArray[np.float64]
    follows_badly: bool
    speed_scaling: float
    lead: float
    play_rate: float
    played_tick: int
    cycles: int
    skipped_cycles: int
    process_id: int
    halted: bool

    @staticmethod
    def of(message: driver_pb2.DriverStatus) -> DriverStatus:
        """Return what a message tells."""
        said = message.controller
        controller = Controller(
            *(said.joint_count, said.rate_hertz, _PACES.get(said.pace, ""), said.watchdog_seconds),
            *(said.model, said.version, said.serial, said.input_count, said.output_count),
        )
        return DriverStatus(
            *(message.robot, message.component, _MODES.get(message.mode, "")),
            _STATES.get(message.state, ""),
            _CONTROLLER_MODES.get(message.controller_mode, ""),
            _SAFETIES.get(message.controller_safety, ""),
            *(message.text, message.code, message.clears, controller, tuple(message.joint_names)),
            *(np.array(message.positions, dtype=float), np.array(message.velocities, dtype=float)),
            tuple(message.outside_limits),
            np.array(message.following_error, dtype=float),
            *(message.follows_badly, message.speed_scaling, message.lead_seconds, message.play_rate),
            *(message.played_tick, message.cycles, message.skipped_cycles, message.process_id, message.halted),
        )


@checked
@dataclass(frozen=True, slots=True)
class DriverJoint:
    """Joint of a controller: which joint of the robot it is, and how it counts.

    Attributes:
        joint: the robot's joint, by name.
        reversed: whether the controller counts in the other direction.
        offset: where the robot's joint is when the controller says 0, rad or m.
    """

    joint: str
    reversed: bool = False
    offset: float = 0.0


@checked
class Drivers:
    """The drivers of one kernel: connections to the real robots whose twins are in its world.

    Example:
        >>> client.drivers.connect("arm", "ur_rtde", {"host": "192.168.0.2"})
        >>> with arm.lease():
        ...     client.drivers.set_mode("arm", "execute")
        ...     arm.move_joints(goal)          # first the twin, then the robot, a tenth of a second later
        ...     client.drivers.set_mode("arm", "simulated")
    """

    def __init__(self, services: Services) -> None:
        """Handle the drivers of one kernel."""
        self._services = services

    def connect(
        self,
        robot: str,
        component: str,
        settings: Mapping[str, object] | None = None,
        *,
        joints: Sequence[DriverJoint] = (),
        lead: float | None = None,
        following_warning: float | None = None,
        following_limit: float | None = None,
        without_watchdog: bool = False,
    ) -> DriverStatus:
        """Connect a robot's driver to its controller; nothing moves. Return how it is.

        Args:
            robot: the robot in the world.
            component: the driver's component, as `client.plugins.components("robot_driver")` lists them.
            settings: its settings, as its page and its schema say.
            joints: the controller's joints in its order; without them the robot's, as they are.
            lead: how much later (s) than its twin the robot does things, 0.02 to 0.4; without it 0.1.
            following_warning: the following error (rad or m) from which on it is warned of; without it 0.02.
            following_limit: the one beyond which the robot is stopped; without it 0.1.
            without_watchdog: consents to a controller that doesn't stop by itself when it hears nothing more.

        Raises:
            DriverFaultError: when the controller doesn't answer or refuses, in its own words.
            WrongStateError: when the robot is connected already.
            UnknownNameError: when there is no such robot, component or joint.
            InvalidArgumentError: when a setting is wrong; the message says what is right.
        """
        request = driver_pb2.ConnectDriverRequest(
            robot=robot,
            component=component,
            settings=settings_message(settings or {}),
            joints=[
                driver_pb2.DriverJoint(joint=one.joint, reversed=one.reversed, offset=one.offset) for one in joints
            ],
            lead_seconds=lead,
            following_warning=following_warning,
            following_limit=following_limit,
            without_watchdog=without_watchdog,
        )
        return DriverStatus.of(self._services.driver.ConnectDriver(request, timeout=LONG_TIMEOUT_SECONDS).driver)

    def disconnect(self, robot: str) -> None:
        """End a robot's driver; a robot that moves is stopped first, and the twin stays where it is."""
        request = driver_pb2.DisconnectDriverRequest(robot=robot)
        self._services.driver.DisconnectDriver(request, timeout=LONG_TIMEOUT_SECONDS)

    def set_mode(self, robot: str, mode: str) -> DriverStatus:
        """Choose how a robot and its twin go together; return how the driver is.

        `simulated`: the twin moves alone. `monitor`: the twin is where the robot is measured. `execute`: the robot does
        what its twin does, a lead later; it needs a lease of the robot (`robot.lease()`), the collision guard, and time
        that follows the wall clock.

        After a fault, or a stop that nobody chose for this robot, its motions are refused until a mode is chosen: so no
        twin moves alone unnoticed. `simulated` can be chosen in ERROR, too.

        Raises:
            WrongStateError: when something of that isn't so; `aspect` in its metadata names it.
            LeasedError: when somebody else has the robot.
            DriverFaultError: when the controller does not let the robot follow, in its own words.
        """
        if mode not in MODES:
            raise InvalidArgumentError(f"a mode is one of {', '.join(MODES)}, not {mode!r}")
        request = driver_pb2.SetDriverModeRequest(robot=robot, mode=f"DRIVER_MODE_{mode.upper()}")
        return DriverStatus.of(self._services.driver.SetDriverMode(request, timeout=LONG_TIMEOUT_SECONDS).driver)

    def reset(self, robot: str) -> DriverStatus:
        """Clear a fault at the controller, where that helps, and connect again; nothing moves before `set_mode`.

        Raises:
            DriverFaultError: when it doesn't help, in the controller's own words.
        """
        request = driver_pb2.ResetDriverRequest(robot=robot)
        return DriverStatus.of(self._services.driver.ResetDriver(request, timeout=LONG_TIMEOUT_SECONDS).driver)

    def list(self) -> list[DriverStatus]:
        """Return all drivers as they are, by the names of their robots."""
        return list(map(DriverStatus.of, self._services.driver.GetDrivers(driver_pb2.GetDriversRequest()).drivers))

    def __getitem__(self, robot: str) -> DriverStatus:
        """Return the driver of a robot as it is; raise UnknownNameError where it has none."""
        found = {status.robot: status for status in self.list()}
        if robot not in found:
            raise UnknownNameError(f"{robot!r} has no driver; these robots have one: {listed(found)}")
        return found[robot]

    def watch(self, max_rate: float | None = None) -> Iterator[list[DriverStatus]]:
        """Yield all drivers again and again, at most `max_rate` (30 by default) times a second."""
        request = driver_pb2.WatchDriversRequest(max_rate_hertz=value_or_default(max_rate, "max_rate"))
        with self._services.driver.WatchDrivers(request) as stream:
            for response in stream:
                yield list(map(DriverStatus.of, response.drivers))

    def __repr__(self) -> str:
        """Return a line for people."""
        robots = [f"{status.robot} ({status.mode}, {status.state})" for status in self.list()]
        return f"<Drivers: {listed(robots)}>"
