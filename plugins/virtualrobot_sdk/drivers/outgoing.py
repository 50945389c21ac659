"""Outgoing setpoints: each passes the gate before it goes to the controller, or the robot brakes before it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from virtualrobot_sdk.drivers.driver import Driver, DriverFault
from virtualrobot_sdk.drivers.player import SLACK_SECONDS, Player, Setpoint
from virtualrobot_sdk.drivers.robot_side import Gate, Mapping, RobotSide
from virtualrobot_sdk.drivers.shared import Floats

LATEST_NS = 20_000_000
"""Time (ns) since the setpoint before, or three longer cycles, up to which the next may go on from it."""

NO_CYCLE = (
    "the driver had no cycle for {:.0f} ms: the computer was too busy, or the controller's packets were late; after "
    "{:.0f} ms a robot may not go on as if nothing had been"
)
"""Words for a setpoint after a time in which nothing was sent, though it is as far away as that time has it."""

CAME_LATE = (
    "the driver came {:.0f} ms late to its cycle: the computer was too busy, or the driver took so long; after "
    "{:.0f} ms what was due then is old"
)
"""Words for a setpoint of a cycle that comes so late that the robot would be elsewhere by now."""


class Outgoing:
    """Setpoints of one host.

    Attributes:
        sent: when the newest one was due (ns, CLOCK_MONOTONIC), and where it is (k,); None while nothing is played.
        refused: why a setpoint was not sent, before which the robot has braked or brakes; empty where all were.
    """

    def __init__(self, driver: Driver, side: RobotSide, stop: Callable[[str], None]) -> None:
        """Send nothing yet; `stop` tells why a setpoint was refused, and stops the cell then."""
        self._driver, self._stop = driver, stop
        self._gate = Gate(side)
        self._lead = side.lead_ns * 1e-9
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

    def passed(self, setpoint: Setpoint, player: Player, ns: int, lateness_ns: int, rate: float) -> Setpoint:
        """Return a setpoint that may go out, or the brake's from the one before; raise DriverFault for neither.

        It was due at `ns`, and comes so much later (ns).
        """
        assert self.sent is not None
        before_ns, before = self.sent
        elapsed, longest = (ns - before_ns) * 1e-9, max(LATEST_NS * 1e-9, 3.0 / rate)
        fault = self._fault(setpoint, before, elapsed, longest)
        if not fault and player.late:
            fault = f"the controller goes slower than it was told, and is over {SLACK_SECONDS:g} s late"
        if not fault and not self.refused and ((setpoint.q != before).any() or setpoint.v.any()):
            fault = _late(elapsed, lateness_ns * 1e-9, max(longest, self._lead / 2.0))
        if fault and not self.refused:
            # The brake begins where the robot is, at the cycle that is due by now: in a time in which it was told
            # nothing it has gone no way.
            period = round(1e9 / rate)
            now = ns + lateness_ns // period * period
            why = fault
            braking = player.step(now) if player.halt(now - min(now - before_ns, period)) else None
            if braking is None or (fault := self._fault(braking, before, elapsed, longest)):
                raise DriverFault(f"{fault}; nothing was sent")
            self.refused = f"{why}; it was not sent, and the robot braked before it"
            self._stop(self.refused)
            return braking
        if fault and not player.late:
            raise DriverFault(f"{fault}; nothing was sent")
        return setpoint

    def _fault(self, setpoint: Setpoint, before: Floats, elapsed: float, longest: float) -> str:
        """Return why a setpoint may not go out, so long (s) after the one before; empty when it may.

        Only `longest` (s) of that counts: who was silent for more must not go on as if nothing had been.
        """
        fault = self._gate.fault(setpoint.q, before, min(elapsed, longest))
        if not fault or elapsed <= longest:
            return fault
        return self._gate.fault(setpoint.q, before, elapsed) or NO_CYCLE.format(1e3 * elapsed, 1e3 * longest)


def _late(elapsed: float, lateness: float, most: float) -> str:
    """Return that a cycle came too late, or that too many before it have not come, in words; empty where none did."""
    if lateness > most:
        return CAME_LATE.format(1e3 * lateness, 1e3 * most)
    return NO_CYCLE.format(1e3 * elapsed, 1e3 * most) if elapsed > most else ""
