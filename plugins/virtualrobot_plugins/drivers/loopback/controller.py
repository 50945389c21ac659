"""A computed controller and its robot: what it does in each of its cycles. No clock and no connection: see `driver.py`.

Times are seconds since the controller was switched on; positions are in rad and m.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from virtualrobot_sdk.drivers import DriverFault, Mode, Safety
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_plugins.drivers.loopback.settings import Fault, LoopbackSettings

STOPS = {
    "protective_stop": (Safety.PROTECTIVE_STOP, "LB1", "protective stop: joint {joint} met something"),
    "safeguard_stop": (Safety.SAFEGUARD_STOP, "LB2", "safeguard stop: the door is open"),
    "emergency_stop": (Safety.EMERGENCY_STOP, "LB3", "emergency stop: the button is pressed"),
}
"""Faults by which the controller stops the robot: what its safety system says, its number and its words."""
MODES = {
    "hand_guided": (Mode.HAND_GUIDED, "LB4", "somebody guides the robot by hand"),
    "local": (Mode.LOCAL, "LB5", "the key is turned to the pendant"),
}
"""Faults that are modes in which the controller takes no setpoints, alike."""
LASTING = frozenset({"nan", "power", "silent"})
"""Faults whose value is how many cycles they last."""
_VALUES = {"displaced": 0.1, "slow": 0.5, "nan": 1.0, "silent": math.inf, "late": 0.08}
"""Value of a fault that says none; the controller takes a second to start."""
_AT_REST = 1e-12
_REACHED = 1e-9


@dataclass(slots=True)
class _Trapezoid:
    """A straight way of all joints to one point: `travelled` of its `length`, both of the joint that goes farthest."""

    start: Floats
    point: Floats
    share: float
    travelled: float = 0.0
    speed: float = 0.0
    length: float = field(init=False)

    def __post_init__(self) -> None:
        self.length = float(np.abs(self.point - self.start).max())

    def step(self, speed: float, acceleration: float, seconds: float) -> Floats:
        """Go on for a time, as fast as a stop at the end allows, and return where the joints are."""
        remaining = self.length - self.travelled
        # v^2 / 2a is the way that a stop takes; the step that is made now counts to it.
        brake = acceleration * (np.sqrt(seconds**2 / 4 + 2 * remaining / acceleration) - seconds / 2)
        self.speed = min(speed * self.share, self.speed + acceleration * seconds, brake)
        self.travelled = min(self.length, self.travelled + max(self.speed * seconds, _REACHED))
        return self.start + (self.point - self.start) * (self.travelled / self.length if self.length else 1.0)

    @property
    def is_done(self) -> bool:
        return self.travelled >= self.length - _REACHED


class Controller:
    """Owns the robot's state; `advance` makes the cycles that are due, the rest says what the driver was told."""

    def __init__(self, settings: LoopbackSettings) -> None:
        """Stand where the settings say, motors on, nothing begun."""
        self.settings = settings
        self.cycle = 0
        self.q = np.array(settings.start or [0.0] * settings.joints, dtype=np.float64)
        self.v = np.zeros(settings.joints)
        self._steps = np.zeros(settings.joints)
        self.motors = True
        self.running = False
        self.done = 0
        self.outputs = 0
        self.inputs = 0
        self.active: dict[str, Fault] = {}
        self._started: dict[str, int] = {}
        self._displaced = np.zeros(settings.joints)
        self._pending = sorted(settings.faults, key=lambda fault: fault.cycle)
        self._begun_at: int | None = None
        self._heard_at = 0.0
        self._setpoints: deque[tuple[float, Floats]] = deque()
        self._target = self.q.copy()
        self._points: deque[tuple[Floats, float]] = deque()
        self._way: _Trapezoid | None = None
        self._rng = np.random.default_rng(settings.seed)

    @property
    def seconds(self) -> float:
        """Return the controller's time (s)."""
        return self.cycle / self.settings.rate

    def advance(self, cycle: int) -> None:
        """Make all cycles up to this one."""
        expected = self._pending and self._begun_at is not None
        if not (self.running or self.active or self.v.any() or expected):
            self.cycle = max(self.cycle, cycle)
        while self.cycle < cycle:
            self.cycle += 1
            self._one_cycle()

    def begin(self, now: float) -> None:
        """Follow from now on; raise DriverFault where the controller does not let the robot move."""
        for what in (*STOPS, *MODES):
            if what in self.active:
                raise self._complaint(what)
        if not self.motors:
            raise DriverFault("the motors are off", code="LB6", clears=True)
        self.running, self.done, self._heard_at = True, 0, now
        self._target = self.q.copy()
        self._forget()
        if self._begun_at is None:
            self._begun_at = self.cycle

    def heard(self, now: float) -> None:
        """Hear from the driver, which keeps the watchdog quiet; who is silent hears nothing either."""
        if "silent" not in self.active:
            self._heard_at = now

    def setpoint(self, positions: Floats, outputs: int, now: float) -> None:
        """Take a setpoint, which counts after the delay."""
        self.heard(now)
        self.outputs = outputs
        if self._rng.random() < self.settings.loss or "silent" in self.active:
            return
        due = now + self.settings.delay + self.settings.jitter * self._rng.random()
        # One that overtakes another comes right after it: order is kept.
        due = max(due, self._setpoints[-1][0]) if self._setpoints else due
        self._setpoints.append((due, np.array(positions, dtype=np.float64)))

    def run(self, points: Sequence[Floats], speeds: Sequence[float], outputs: int) -> None:
        """Go to these points after those that are not reached yet."""
        self.outputs = outputs
        if self.running and "silent" not in self.active:
            self._points.extend((np.array(p, dtype=np.float64), s) for p, s in zip(points, speeds, strict=True))

    def stop(self) -> None:
        """Come to rest where that is possible soonest, and take nothing of what was told before."""
        self.running = False
        self._forget()

    def cause(self, fault: Fault) -> None:
        """Have a fault from now on."""
        self.active[fault.what] = fault
        self._started[fault.what] = self.cycle
        if fault.what == "displaced":
            self._displaced[fault.joint] += self._value(fault)
        if fault.what in STOPS or fault.what in MODES:
            self.stop()
        if fault.what == "power":
            self.stop()
            self.v[:] = 0.0
            self.motors = False

    def mend(self) -> None:
        """Be well again; after a loss of power the motors stay off until `reset`."""
        self.active.clear()
        self._displaced[:] = 0.0

    def reset(self) -> None:
        """Clear what may be cleared without a person: a protective stop, and motors that are off."""
        self.active.pop("protective_stop", None)
        self.motors = True

    def value(self, what: str) -> float:
        """Return the value of a fault that is there."""
        return self._value(self.active[what])

    def mode(self) -> Mode:
        """Return what the robot is let do."""
        if not self.motors:
            return Mode.OFF
        found = next((MODES[what][0] for what in MODES if what in self.active), None)
        return found or (Mode.RUNNING if self.running else Mode.READY)

    def safety(self) -> Safety:
        """Return what the safety system says."""
        return next((STOPS[what][0] for what in STOPS if what in self.active), Safety.NORMAL)

    def words(self) -> str:
        """Return what the controller says to people."""
        return next((str(self._complaint(what)) for what in (*STOPS, *MODES) if what in self.active), "")

    def measured(self) -> Floats:
        """Return the positions as the encoders have them."""
        found = self.q + self._displaced
        if self.settings.noise:
            found = found + self._rng.normal(0.0, self.settings.noise, len(found))
        if "nan" in self.active:
            found[self.active["nan"].joint] = np.nan
        return found

    def _complaint(self, what: str) -> DriverFault:
        _, code, words = (STOPS | MODES)[what]
        text = words.format(joint=self.active[what].joint)
        return DriverFault(text, code=code, clears=what == "protective_stop")

    def _value(self, fault: Fault) -> float:
        usual = self.settings.rate if fault.what == "power" else _VALUES.get(fault.what, 0.0)
        return usual if fault.value is None else fault.value

    def _forget(self) -> None:
        self._setpoints.clear()
        self._points.clear()
        self._way = None

    def _one_cycle(self) -> None:
        while self._pending and self._begun_at is not None and self.cycle - self._begun_at >= self._pending[0].cycle:
            self.cause(self._pending.pop(0))
        for what in self.active.keys() & LASTING:
            if self.cycle - self._started[what] >= self._value(self.active[what]):
                del self.active[what]
        before = self.q
        self.q = self._next()
        if "stuck" in self.active:
            self.q[self.active["stuck"].joint] = before[self.active["stuck"].joint]
        steps = (self.q - before) * self.settings.rate
        # Setpoints and cycles beat: where none came in a cycle, two come in the next.
        self.v = (steps + self._steps) / 2 if self.running else steps
        self._steps = steps

    def _next(self) -> Floats:
        """Return where the joints are a cycle later."""
        settings, seconds = self.settings, 1.0 / self.settings.rate
        speed = settings.speed * (self.value("slow") if "slow" in self.active else 1.0)
        jobs = settings.pace == "JOBS"
        if self.running and 0.0 < settings.watchdog < self.seconds - self._heard_at:
            self.stop()
        if not self.running:
            greatest = float(np.abs(self.v).max())
            left = max(0.0, greatest - settings.acceleration * seconds)
            return self.q + self.v * (left / greatest * seconds if greatest > _AT_REST else 0.0)
        if jobs:
            return self._along(speed, seconds)
        while self._setpoints and self._setpoints[0][0] <= self.seconds:
            self._target = self._setpoints.popleft()[1]
        way = self._target - self.q
        if settings.lag:
            way = way * (1.0 - np.exp(-seconds / settings.lag))
        return self.q + np.clip(way, -speed * seconds, speed * seconds)

    def _along(self, speed: float, seconds: float) -> Floats:
        if self._way is None and self._points:
            self._way = _Trapezoid(self.q.copy(), *self._points.popleft())
        if self._way is None:
            return self.q.copy()
        found = self._way.step(speed, self.settings.acceleration, seconds)
        if self._way.is_done:
            found, self._way, self.done = self._way.point.copy(), None, self.done + 1
        return found
