"""Drivers of computed robots with two joints: right ones, and wrong ones, each by one mistake."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from virtualrobot_plugins.drivers.loopback.driver import Loopback
from virtualrobot_plugins.drivers.loopback.settings import Fault, LoopbackSettings, What
from virtualrobot_sdk.drivers import About, DriverFault, Reading
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats

api_version = "1.0"
START = (0.3, -0.7)
# Slow enough for a busy machine: setpoints are few, and the joints go smoothly from one to the next.
SETTINGS = LoopbackSettings(joints=2, start=START, rate=50.0, lag=0.04, watchdog=2.0)
LONG = 1e9


class Simulated(Loopback):
    """Keeps all that a driver must."""

    def __init__(self, settings: LoopbackSettings = SETTINGS) -> None:
        """Stand somewhere."""
        super().__init__(settings)


def cause(driver: Loopback, what: What, value: float | None = None) -> None:
    """Have a fault, now."""
    driver.controller.cause(Fault(what, 0, 1, value))


def cut(driver: Loopback) -> None:
    """Take the controller's power."""
    cause(driver, "power", LONG)


def silence(driver: Loopback) -> None:
    """Freeze the controller."""
    cause(driver, "silent")


def mend(driver: Loopback) -> None:
    """Make all well."""
    driver.controller.mend()


def meet(driver: Loopback) -> None:
    """Have the robot meet something."""
    cause(driver, "protective_stop")


def press(driver: Loopback) -> None:
    """Press the button."""
    cause(driver, "emergency_stop")


@dataclass(frozen=True)
class PlaceSettings:
    """Place at which a controller should be."""

    host: str = ""


class Remote(Simulated):
    """Answers at one host alone."""

    def __init__(self, settings: PlaceSettings) -> None:
        """Know where."""
        super().__init__()
        self.host = settings.host

    def connect(self) -> About:
        """Connect, or say where nobody answers."""
        if self.host:
            raise DriverFault(f"nobody answers at {self.host}")
        return super().connect()


class RemoteAnonymous(Remote):
    """Wrong: doesn't say where nobody answers."""

    def connect(self) -> About:
        """Connect, or not."""
        if self.host:
            raise DriverFault("timed out")
        return super().connect()


@hookimpl
def virtualrobot_register_robot_drivers(register: Register) -> None:
    """Register those with settings."""
    register("remote", Remote, PlaceSettings)
    register("anonymous", RemoteAnonymous, PlaceSettings)


class JobsSimulated(Simulated):
    """Plans by itself."""

    def __init__(self) -> None:
        """Stand somewhere."""
        super().__init__(dataclasses.replace(SETTINGS, pace="JOBS", speed=0.1))


class Watched(Simulated):
    """Counts how often any driver of this process let the robot follow."""

    count = 0

    def begin(self, held: Floats) -> None:
        """Hold, and count."""
        super().begin(held)
        Watched.count += 1

    def begun(self) -> int:
        """Return how often."""
        return Watched.count


class WrongCount(Simulated):
    """Wrong: tells more joints than its readings have."""

    def connect(self) -> About:
        """Connect."""
        return dataclasses.replace(super().connect(), joints=3)


class NoRate(Simulated):
    """Wrong: tells no rate."""

    def connect(self) -> About:
        """Connect."""
        return dataclasses.replace(super().connect(), rate=0.0)


class OtherEachTime(Simulated):
    """Wrong: tells something else when it connects again."""

    times = 0

    def connect(self) -> About:
        """Connect."""
        self.times += 1
        return dataclasses.replace(super().connect(), serial=str(self.times))


class _Rewrites(Simulated):
    def read(self) -> Reading:
        """Read, and change it."""
        return self.changed(super().read())

    def changed(self, reading: Reading) -> Reading:
        """Return it otherwise."""
        raise NotImplementedError


class Degrees(_Rewrites):
    """Wrong: reads and takes degrees, and doesn't say so."""

    def changed(self, reading: Reading) -> Reading:
        """Return degrees."""
        return dataclasses.replace(reading, positions=np.degrees(reading.positions))

    def send(self, positions: Floats, velocities: Floats, outputs: int) -> None:
        """Go."""
        super().send(np.radians(positions), np.radians(velocities), outputs)


class Milliseconds(_Rewrites):
    """Wrong: stamps are in milliseconds."""

    def changed(self, reading: Reading) -> Reading:
        """Return milliseconds."""
        return dataclasses.replace(reading, stamp=1e3 * reading.stamp)


class ClockStands(_Rewrites):
    """Wrong: stamps are always the same."""

    def changed(self, reading: Reading) -> Reading:
        """Return the same time."""
        return dataclasses.replace(reading, stamp=1.0)


class SpeaksNaN(_Rewrites):
    """Wrong: a joint that it doesn't know is NaN."""

    def changed(self, reading: Reading) -> Reading:
        """Return what is no number."""
        return dataclasses.replace(reading, positions=np.array([0.3, np.nan]))


class TooManyInputs(_Rewrites):
    """Wrong: reads inputs that connect doesn't tell."""

    def connect(self) -> About:
        """Connect."""
        return dataclasses.replace(super().connect(), inputs=2)

    def changed(self, reading: Reading) -> Reading:
        """Return the third."""
        return dataclasses.replace(reading, inputs=4)


class NoVelocities(_Rewrites):
    """Wrong: it knows no velocities and says 0."""

    def changed(self, reading: Reading) -> Reading:
        """Return 0."""
        return dataclasses.replace(reading, velocities=np.zeros(2))


class VelocitiesBackwards(_Rewrites):
    """Wrong: its velocities have the other sign."""

    def changed(self, reading: Reading) -> Reading:
        """Return the other sign."""
        assert reading.velocities is not None
        return dataclasses.replace(reading, velocities=-reading.velocities)


class WritesInOwnOrder(Simulated):
    """Wrong: reads in the controller's order, and sends in another."""

    def begin(self, held: Floats) -> None:
        """Begin."""
        super().begin(held[::-1])

    def send(self, positions: Floats, velocities: Floats, outputs: int) -> None:
        """Go."""
        super().send(positions[::-1], velocities, outputs)


class Deaf(Simulated):
    """Wrong: nothing that is sent reaches the robot."""

    def send(self, positions: Floats, velocities: Floats, outputs: int) -> None:
        """Go nowhere."""


class NeverRuns(Simulated):
    """Wrong: begin begins nothing."""

    def begin(self, held: Floats) -> None:
        """Do nothing."""


class KeepsRunning(Simulated):
    """Wrong: doesn't tell the robot that it is to follow no more."""

    def end(self) -> None:
        """Tell nothing."""


class GoesOn(Simulated):
    """Wrong: goes on to the old target when it is begun again."""

    wanted: Floats | None = None

    def send(self, positions: Floats, velocities: Floats, outputs: int) -> None:
        """Go."""
        super().send(positions, velocities, outputs)
        self.wanted = positions + 0.01

    def begin(self, held: Floats) -> None:
        """Go on."""
        super().begin(held)
        if self.wanted is not None:
            self.controller.q = self.wanted.copy()


class NoStop(Simulated):
    """Wrong: a stop is said to have been made, and the robot goes on."""

    def stop(self) -> None:
        """Go on."""
        if self.controller.running:
            self.controller.setpoint(self.controller.q + 0.05, 0, self.controller.seconds)

    def end(self) -> None:
        """Go on."""

    def close(self) -> None:
        """Go on."""


class StopComplains(Simulated):
    """Wrong: there must be something to stop."""

    def stop(self) -> None:
        """Complain."""
        if not self.controller.running:
            raise DriverFault("there is nothing to stop")
        super().stop()


class KeepsSilent(_Rewrites):
    """Wrong: a silent controller's last words are told for ever."""

    last: Reading | None = None

    def read(self) -> Reading:
        """Read, or repeat."""
        try:
            self.last = super().read()
        except DriverFault:
            assert self.last is not None
        return self.last

    def changed(self, reading: Reading) -> Reading:
        """Return it as it is."""
        return reading


class NeverAgain(Simulated):
    """Wrong: what was broken once stays broken."""

    broken = False

    def connect(self) -> About:
        """Connect, once."""
        if self.broken:
            raise DriverFault("socket is closed")
        return super().connect()

    def read(self) -> Reading:
        """Read."""
        try:
            return super().read()
        except DriverFault:
            self.broken = True
            raise


class OwnWords(_Rewrites):
    """Wrong: keeps the controller's words to itself."""

    def changed(self, reading: Reading) -> Reading:
        """Return words of its own."""
        return dataclasses.replace(reading, text="error 17" if reading.text else "")


class BeginsAnyway(Simulated):
    """Wrong: begins though the controller has a fault."""

    def begin(self, held: Floats) -> None:
        """Begin."""
        self.controller.active.clear()
        super().begin(held)


class ResetsNothing(Simulated):
    """Wrong: says that reset may help, and it doesn't."""

    def reset(self) -> None:
        """Do nothing."""


class CountsTwice(JobsSimulated):
    """Wrong: counts each point twice."""

    def read(self) -> Reading:
        """Read."""
        found = super().read()
        return dataclasses.replace(found, done=2 * found.done)


class JobsNoStop(JobsSimulated):
    """Wrong: a point is gone to, whatever is said."""

    def stop(self) -> None:
        """Go on."""

    def end(self) -> None:
        """Go on."""

    def close(self) -> None:
        """Go on."""


class JobsElsewhere(JobsSimulated):
    """Wrong: takes points for shares of a turn."""

    def run(self, points: Sequence[Floats], speeds: Sequence[float], outputs: int) -> None:
        """Go elsewhere."""
        super().run([point * 1.1 for point in points], speeds, outputs)
