"""Interface of a robot driver: the words of one controller, and nothing else.

An author says how to connect, read, send and stop. The host (`virtualrobot_sdk.drivers.host`), in whose process the
driver runs, owns all the rest: states, clock, interpolation, units, signs, offsets, limits, reconnecting, watchdogs.
So what a driver is given has been checked, and what it raises stops the robot.

    class Mine(Driver):
        def connect(self) -> About: ...
        def read(self) -> Reading: ...
        def send(self, positions, velocities, outputs) -> None: ...
        def stop(self) -> None: ...

Joints are in the controller's order. Values are in the controller's units (`About.units`), with its signs and zeros:
the host turns them into the kernel's. One thread makes all calls; each must return within the deadline that its
docstring says, and a driver that doesn't is killed with its process, after which the controller's own watchdog acts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from numbers import Integral, Real

import numpy as np

from virtualrobot_sdk.kinematics import Floats


class Pace(Enum):
    """Clock by which setpoints are due."""

    HOST = "HOST"
    """The host's clock: `read` returns at once, `send` comes `About.rate` times a second."""
    CONTROLLER = "CONTROLLER"
    """The controller's: `read` waits for its next packet, and `send` answers it."""
    JOBS = "JOBS"
    """Nobody: the controller plans by itself. `run` gives it points to go to, and readings tell how many are done."""


class Mode(Enum):
    """State in which the controller has the robot."""

    OFF = "OFF"
    """Motors have no power."""
    STARTING = "STARTING"
    """Power comes on, brakes open, a program is loaded; it takes a while."""
    READY = "READY"
    """The robot is held and would follow; nothing has been begun."""
    RUNNING = "RUNNING"
    """The robot follows what is sent."""
    HAND_GUIDED = "HAND_GUIDED"
    """A person moves the robot by hand."""
    LOCAL = "LOCAL"
    """The controller listens to its own pendant only."""


class Safety(Enum):
    """Verdict of the controller's safety system; all but the first two mean that it has stopped the robot."""

    NORMAL = "NORMAL"
    REDUCED = "REDUCED"
    """Slower, or weaker, by its own limits."""
    PROTECTIVE_STOP = "PROTECTIVE_STOP"
    """It met something, or couldn't follow; a person looks and releases it."""
    SAFEGUARD_STOP = "SAFEGUARD_STOP"
    """A door or a light curtain; it goes on once that is closed."""
    EMERGENCY_STOP = "EMERGENCY_STOP"
    FAULT = "FAULT"
    """The controller has an error of its own; `Reading.text` says which."""


@dataclass(frozen=True, slots=True)
class Words:
    """Words of a controller, or about it; without text there are none.

    Attributes:
        text, code, clears: see `DriverFault`.
    """

    text: str = ""
    code: str = ""
    clears: bool = False


class DriverFault(Exception):
    """Fault that the controller complains of, or its silence, in words that a person at the robot understands.

    Attributes:
        text: the controller's own words, whole.
        code: its number of the error, as it prints it; empty where there is none.
        clears: whether `reset` may help; else a person has to do something at the controller first.
    """

    def __init__(self, text: str, code: str = "", clears: bool = False) -> None:
        """Keep what the controller said."""
        super().__init__(f"{code}: {text}" if code else text)
        self.text, self.code, self.clears = text, code, clears

    @property
    def words(self) -> Words:
        """Text, code, and whether a reset may help, to be kept and sent."""
        return Words(self.text, self.code, self.clears)


@dataclass(frozen=True, slots=True)
class About:
    """Description of a controller, found out as a driver connects.

    Attributes:
        joints: number k of the robot's joints.
        rate: cycles a second (Hz) of readings and setpoints; of JOBS, readings alone.
        pace: who says when the next setpoint is due.
        units: rad or m per unit of the controller, one for all joints or one each: `math.radians(1.0)` for degrees.
        watchdog: time (s) after which the controller stops the robot by itself when nothing is sent; 0: it doesn't, and
            a user must consent to that.
        silence: time (s) for which the controller's own clock may stand still before it is given up; never less than
            0.1 s or three cycles.
        model, version, serial: what the controller says it is; empty where it doesn't.
        speed_scaling: whether readings tell how much slower than it was told the controller goes.
        inputs, outputs: number of the controller's digital inputs and outputs that come with each cycle, at most 64.
    """

    joints: int
    rate: float
    pace: Pace = Pace.HOST
    units: float | tuple[float, ...] = 1.0
    watchdog: float = 0.0
    silence: float = 0.0
    model: str = ""
    version: str = ""
    serial: str = ""
    speed_scaling: bool = False
    inputs: int = 0
    outputs: int = 0

    def __post_init__(self) -> None:
        """Have units that come as an array as a tuple, which is compared as a whole."""
        if isinstance(self.units, np.ndarray | list):
            units = np.asarray(self.units).tolist()
            object.__setattr__(self, "units", tuple(units) if isinstance(units, list) else units)


@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """Report of a controller in one cycle; k joints in its own order and units.

    Attributes:
        stamp: the controller's own time (s): it grows with each of its cycles. One that stays means silence.
        positions: (k,).
        velocities: (k,) per second; None where it doesn't tell, and the host makes them.
        efforts: (k,) in N m and N; None where it doesn't tell.
        mode: what it lets the robot do.
        safety: what its safety system says.
        speed_scaling: share of the speed that it was told at which it goes, 0 to 1.
        inputs: its digital inputs, the first in the lowest bit.
        text: its newest words, of a fault or for people; empty where it has none.
        done: of JOBS, the number of points of `run` that have been reached since `begin`.
    """

    stamp: float
    positions: Floats
    velocities: Floats | None = None
    efforts: Floats | None = None
    mode: Mode = Mode.READY
    safety: Safety = Safety.NORMAL
    speed_scaling: float = 1.0
    inputs: int = 0
    text: str = ""
    done: int = 0


class Driver:
    """The connection to one controller. It is made with its settings, a frozen dataclass, and connects to nothing yet.

    What it raises, DriverFault or anything else, puts the connection into ERROR, in which the robot is not moved; the
    text reaches the user. After it, `connect` is called again before anything else.
    """

    def connect(self) -> About:
        """Connect, ask for everything that `About` says, and return it; nothing moves by that. Within 10 s.

        Raises DriverFault with the host and port, or the device, where nobody answers or it is refused.
        """
        raise NotImplementedError

    def read(self) -> Reading:
        """Return the newest that the controller says. Within three cycles; of `Pace.CONTROLLER` it waits for a packet.

        Raises DriverFault where the controller has been silent that long, and where the connection is lost. A reading
        that is no number is refused by the host.
        """
        raise NotImplementedError

    def begin(self, held: Floats) -> None:
        """Let the robot follow what is sent from now on; `held` (k,) is where it stands and shall stay. Within 10 s.

        Readings have `Mode.RUNNING` soon after. Raises DriverFault where the controller is not ready, saying what a
        person has to do at it.
        """

    def send(self, positions: Floats, velocities: Floats, outputs: int) -> None:
        """Tell the controller where to be at the next cycle: (k,) each, and its digital outputs. At once."""
        raise NotImplementedError

    def run(self, points: Sequence[Floats], speeds: Sequence[float], outputs: int) -> None:
        """Have the controller go to points (k,) one after the other, and return at once; of `Pace.JOBS` alone.

        `speeds` are shares (0 to 1] of the robot's own greatest speed, one for each point. Points that are given before
        others are reached come after these; `stop` forgets them all.
        """
        raise NotImplementedError

    def stop(self) -> None:
        """Bring the robot to rest as the controller does it best. At once; harmless at any time after `connect`.

        Nothing is sent after it until `begin`.
        """
        raise NotImplementedError

    def end(self) -> None:
        """Let the robot, which is at rest, no longer follow: the other end of `begin`; harmless without one.

        Unless a driver says otherwise that is what `stop` does: no robot goes on listening to what nobody sends.
        """
        self.stop()

    def reset(self) -> None:
        """Clear the fault that `DriverFault.clears` spoke of; nothing moves by that. Connected; within 10 s."""

    def close(self) -> None:
        """Give the connection back; harmless at any time, and more than once."""

    def set_tool(self, mass: float, center: Floats, flange_t_tcp: Floats) -> None:
        """Tell the controller of the tool: mass (kg), centre of mass (3,) and TCP (4, 4) in the flange's frame."""


_NAMES = {Real: "a number", Integral: "a whole number", str: "a text"}
_KINDS = {
    **{"stamp": Real, "speed_scaling": Real, "inputs": Integral, "done": Integral},
    **{"mode": Mode, "safety": Safety, "text": str},
}
"""Types of what a reading says beside its joints; numbers of NumPy are numbers."""


def wrong_fields(told: object, kinds: Mapping[str, type]) -> str:
    """Return which field of what a driver tells is of another type, with its value; empty when none is."""
    for name, kind in kinds.items():
        if not isinstance(given := getattr(told, name), kind):
            wanted = _NAMES.get(kind, f"a {kind.__name__}")
            return f"{name} of its {type(told).__name__} is {given!r}; it must be {wanted}"
    return ""


def wrong_reading(reading: object) -> str:
    """Return what is wrong with the types of what `read` has returned, with its values; empty when nothing is."""
    if not isinstance(reading, Reading):
        return f"`read` returned {reading!r}; it must return a Reading"
    return wrong_fields(reading, _KINDS)


def finite(reading: Reading, joints: int) -> str:
    """Return what is wrong with a reading's numbers, with the numbers; empty when nothing is."""
    for name in ("positions", "velocities", "efforts"):
        given = getattr(reading, name)
        if given is None and name != "positions":
            continue
        try:
            values = np.asarray(given, dtype=np.float64)
        except (TypeError, ValueError):
            return f"{name} are {given!r}; they must be numbers"
        if values.shape != (joints,):
            return f"{name} have shape {values.shape}; they must have ({joints},)"
        if not np.isfinite(values).all():
            return f"{name} are {values.tolist()}; they must be finite"
    if not (np.isfinite(reading.stamp) and 0.0 <= reading.speed_scaling <= 1.0):
        return f"stamp is {reading.stamp} and speed_scaling {reading.speed_scaling}; they must be finite, and 0 to 1"
    return ""
