"""Outgoing setpoints: each passes the gate before it goes to the controller, or the robot brakes before it."""

from __future__ import annotations

import numpy as np

from virtualrobot_sdk.drivers.driver import Driver, DriverFault
from virtualrobot_sdk.drivers.player import SLACK_SECONDS, Player, Setpoint
from virtualrobot_sdk.drivers.robot_side import Gate, Mapping, RobotSide
from virtualrobot_sdk.drivers.shared import CellBlock, Floats

LATEST_NS = 20_000_000
"""Time (ns) since the setpoint before, or three longer cycles, up to which the next may go on from it."""


class Outgoing:
    """Setpoints of one host.

    Attributes:
        sent: when the newest one was due (ns, CLOCK_MONOTONIC), and where it is (k,); None while nothing is played.
        refused: why a setpoint was not sent, before which the robot has braked or brakes; empty where all were.
    """

    def __init__(self, driver: Driver, side: RobotSide, cell: CellBlock) -> None:
        """Send nothing yet."""
        self._driver, self._cell = driver, cell
        self._gate = Gate(side)
        self.sent: tuple[int, Floats] | None = None
        self.refused = ""

    @property
    def held(self) -> Setpoint:
        """Setpoint that holds the robot where the newest one is."""
        assert self.sent is not None
        return Setpoint(self.sent[1], np.zeros_like(self.sent[1]), 0)

    def send(self, setpoint: Setpoint, ns: int, mapping: Mapping) -> None:
        """Send a setpoint that may go out, which was due at a time (ns)."""
        self.sent = (ns, setpoint.q)
        self._driver.send(*mapping.raw(setpoint.q, setpoint.v), setpoint.outputs)

    def passed(self, setpoint: Setpoint, player: Player, ns: int, rate: float) -> Setpoint:
        """Return a setpoint that may go out, or the brake's from the one before; raise DriverFault for neither."""
        assert self.sent is not None
        before_ns, before = self.sent
        # However late this is: who was silent for longer must not go on as if nothing had been.
        longest = max(LATEST_NS, round(3e9 / rate))
        seconds = min(ns - before_ns, longest) * 1e-9
        fault = self._gate.fault(setpoint.q, before, seconds)
        if not fault and player.late:
            fault = f"the controller goes slower than it was told, and is over {SLACK_SECONDS:g} s late"
        if fault and not self.refused:
            self.refused = f"{fault}; it was not sent, and the robot braked before it"
            braked = player.halt()
            self._cell.stop()
            braking = player.step(ns) if braked else None
            if braking is None or (fault := self._gate.fault(braking.q, before, seconds)):
                raise DriverFault(f"{fault}; nothing was sent")
            return braking
        if fault and not player.late:
            raise DriverFault(f"{fault}; nothing was sent")
        return setpoint
