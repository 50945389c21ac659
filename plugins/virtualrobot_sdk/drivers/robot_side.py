"""Joints of a robot as the kernel has them, and how they are those of its controller."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Integral, Real

import numpy as np
from numpy.typing import NDArray

from virtualrobot_sdk.drivers.driver import About, Pace, Reading, wrong_fields
from virtualrobot_sdk.drivers.shared import Floats
from virtualrobot_sdk.errors import ArgumentError

MOST_OUTPUTS = 64
"""Greatest number of digital inputs or outputs of a controller."""


@dataclass(frozen=True, slots=True)
class JointSide:
    """Joint of the robot: its name, which of the controller's joints it is (from 0), and how it counts.

    Where the controller says x, in units of `About.units`, the joint is at `sign · units · x + offset`, in rad or m.
    lower, upper: its limits; velocity: its greatest speed.
    """

    name: str
    index: int
    lower: float
    upper: float
    velocity: float
    sign: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class RobotSide:
    """Joints of a robot that has a driver, in the order of its ring, and what its host keeps to.

    Attributes:
        joints: them.
        tick_ns: length of a tick.
        begin_tolerance: how far the twin may be from the robot when it begins to follow (rad or m).
        without_watchdog: whether the user consents to a controller that doesn't stop by itself.
        lead_ns: how much later than its twin the robot does things (ns); a host that is late by half of it, in motion,
            stops the robot.
    """

    joints: tuple[JointSide, ...]
    tick_ns: int = 4_000_000
    begin_tolerance: float = 1e-3
    without_watchdog: bool = False
    lead_ns: int = 100_000_000

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the joints."""
        return tuple(joint.name for joint in self.joints)


_KINDS = {
    **{"joints": Integral, "inputs": Integral, "outputs": Integral, "rate": Real, "watchdog": Real, "silence": Real},
    **{"pace": Pace, "model": str, "version": str, "serial": str},
}
"""Types of what a driver says of its controller beside its units; numbers of NumPy are numbers."""


def wrong_about(about: object) -> str:
    """Return what is wrong with what `connect` has returned, with its values; empty when nothing is."""
    if not isinstance(about, About):
        return f"`connect` returned {about!r}; it must return an About"
    if wrong := wrong_fields(about, _KINDS):
        return wrong
    for name, least, most in (
        *(("rate", 0.1, 10_000.0), ("inputs", 0, MOST_OUTPUTS), ("outputs", 0, MOST_OUTPUTS)),
        *(("watchdog", 0.0, np.inf), ("silence", 0.0, np.inf)),
    ):
        if not least <= (given := getattr(about, name)) <= most:
            return f"{name} of its About is {given:g}; it must be {least:g} to {most:g}"
    try:
        units = np.asarray(about.units, dtype=np.float64)
    except (TypeError, ValueError):
        return f"units of its About are {about.units!r}; they must be numbers"
    if units.shape not in ((), (about.joints,)):
        return f"units of its About have shape {units.shape}; they must be one number, or one for each of its joints"
    return ""


def check_fits(side: RobotSide, about: About) -> None:
    """Raise ArgumentError for a controller that is not the one of a robot's side, or that nobody may rely on."""
    if about.joints != len(side.joints):
        raise ArgumentError(
            f"the controller has {about.joints} joints, and its twin {len(side.joints)}: {', '.join(side.names)}; "
            "say in `joints` which joint of the twin each of the controller's is, in the controller's order",
            field="joints",
            controller=about.joints,
        )
    if about.watchdog <= 0.0 and about.pace is not Pace.JOBS and not side.without_watchdog:
        raise ArgumentError(
            "this controller does not stop its robot by itself when nothing comes any more, as when this computer "
            "hangs; consent to that (`without_watchdog`), or use one that does",
            field="without_watchdog",
        )


class Mapping:
    """Mapping between a robot's joints and its controller's: order, signs, units, offsets."""

    def __init__(self, side: RobotSide, about: About) -> None:
        """Map the joints of `side` to those of a controller.

        Raises ArgumentError where the numbers of joints differ, where two are the same joint of the controller, and
        where it has a joint that nobody says anything of.
        """
        count, given = about.joints, [joint.index for joint in side.joints]
        if sorted(given) != list(range(count)):
            raise ArgumentError(
                f"the controller has {count} joints, and the mapping names {given} of them for "
                f"{', '.join(side.names)}; name each of 0 to {count - 1} once",
                joints=count,
            )
        units = np.broadcast_to(np.asarray(about.units, dtype=np.float64), (count,))
        if not (np.isfinite(units).all() and (units > 0.0).all()):
            raise ArgumentError(f"the driver's units are {units.tolist()}; they must be above 0")
        self._index: NDArray[np.intp] = np.array(given, np.intp)
        self._scale: Floats = units[self._index] * [joint.sign for joint in side.joints]
        self._offset: Floats = np.array([joint.offset for joint in side.joints])
        self._count = count

    def joints(self, reading: Reading) -> tuple[Floats, Floats | None]:
        """Return the robot's joints q, and v where they are told (k,), of a reading."""
        q = np.asarray(reading.positions, dtype=np.float64)[self._index] * self._scale + self._offset
        if reading.velocities is None:
            return q, None
        return q, np.asarray(reading.velocities, dtype=np.float64)[self._index] * self._scale

    def raw(self, q: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Return the controller's positions and velocities (k,) for the robot's."""
        positions, velocities = np.empty(self._count), np.empty(self._count)
        positions[self._index] = (q - self._offset) / self._scale
        velocities[self._index] = v / self._scale
        return positions, velocities


class Gate:
    """Gate before a controller: what isn't finite, outside of limits or too far from the setpoint before stays here."""

    def __init__(self, side: RobotSide) -> None:
        """Keep to the limits of these joints."""
        self._names = side.names
        self._lower = np.array([joint.lower for joint in side.joints]) - 1e-9
        self._upper = np.array([joint.upper for joint in side.joints]) + 1e-9
        self._velocity = np.array([joint.velocity for joint in side.joints])

    def fault(self, q: Floats, before: Floats, seconds: float) -> str:
        """Return why a setpoint may not go out, so long after the one before; empty when it may."""
        if not np.isfinite(q).all():
            return f"a setpoint is {q.tolist()}"
        step = 1.1 * self._velocity * max(seconds, 1e-4) + 1e-5
        out = (q < self._lower) | (q > self._upper)
        if out.any():
            joint = int(out.argmax())
            return (
                f"a setpoint of {self._names[joint]!r} is {q[joint]:.6g}, outside of its limits "
                f"{self._lower[joint]:.6g} to {self._upper[joint]:.6g}"
            )
        far = np.abs(q - before) > step
        if far.any():
            joint = int(far.argmax())
            return (
                f"a setpoint of {self._names[joint]!r} is {abs(q[joint] - before[joint]):.3g} from the one "
                f"{1e3 * seconds:.1f} ms before, and {step[joint]:.3g} is as far as its speed allows"
            )
        return ""
