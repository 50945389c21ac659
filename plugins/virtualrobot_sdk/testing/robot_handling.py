"""Handling of a robot in the suite for drivers: brings its driver to a state, sends it on a way, watches it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from virtualrobot_sdk.drivers import DriverState, Measured
from virtualrobot_sdk.errors import ArgumentError, ComponentFault
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.testing.laws import LawBroken
from virtualrobot_sdk.testing.trial import NotTried, Trial, checked, numbers

READINGS = 10
"""Number of readings that are taken where a robot is watched."""
_WAY_SECONDS = 0.3
"""Duration of the way that a robot is sent (s)."""


@dataclass(frozen=True, slots=True)
class DriverFacts:
    """Properties of a driver and the robot on it that their author states.

    Attributes:
        joint_names: of the robot, in any order.
        is_real: true where a real robot hangs on it: nothing is activated or moved then.
        period_seconds: period of reading and writing (s).
        way: distance (rad, m) that each joint is moved from where it is; both ways must be free.
        tolerance: largest error (rad, m) of the robot from where it was told to be.
        settle_seconds: longest time (s) to get there after the last write, and to come to rest after a stop.
        breaks: a method of the driver's, without arguments, that breaks the connection as a pulled cable does, for this
            suite only; empty when there is none.
        stands_at: position of the robot when the suite begins (rad, m), as its panel says it, in the order of
            `joint_names`; None: nobody knows, and a driver that has its units wrong both ways is not found.
    """

    joint_names: tuple[str, ...]
    is_real: bool = False
    period_seconds: float = 0.01
    way: float = 0.05
    tolerance: float = 1e-3
    settle_seconds: float = 1.0
    breaks: str = ""
    stands_at: tuple[float, ...] | None = None


DriverTrial = Trial[DriverFacts]


def must_be_free_to_move(trial: DriverTrial) -> None:
    """Raise NotTried where a real robot hangs on the driver."""
    if trial.facts.is_real:
        raise NotTried("a real robot hangs on it (`is_real` of DriverFacts)")


def states_to_try(trial: DriverTrial) -> list[DriverState]:
    """Return the states that the driver is tried in."""
    found = [DriverState.UNCONFIGURED, DriverState.INACTIVE]
    if not trial.facts.is_real:
        found += [DriverState.ACTIVE, *([DriverState.ERROR] if trial.facts.breaks else [])]
    return found


def bring_to(trial: DriverTrial, state: DriverState) -> Floats:
    """Bring a driver made anew to a state, and return where its joints are, zeros where it does not know."""
    let_go(trial)
    trial.make_anew()
    must_be_in(trial, DriverState.UNCONFIGURED, "it was made")
    positions = np.zeros(len(trial.facts.joint_names))
    if state is DriverState.UNCONFIGURED:
        return positions
    trial.call("configure", trial.facts.joint_names)
    must_be_in(trial, DriverState.INACTIVE, "configure")
    positions = read(trial).positions
    if state is DriverState.INACTIVE:
        return positions
    trial.call("activate")
    must_be_in(trial, DriverState.ACTIVE, "activate")
    if state is DriverState.ERROR:
        break_connection(trial)
    return positions


def let_go(trial: DriverTrial) -> None:
    """Give the connection back, so that another driver may have it; the law about it is `life_cycle`."""
    for call in ("stop", "cleanup"):
        try:
            trial.call(call)
        except (ArgumentError, ComponentFault):
            trial.renew()


def must_be_in(trial: DriverTrial, state: DriverState, after: str) -> None:
    """Raise LawBroken when the driver is in another state."""
    found = trial.call("state")
    if found is not state:
        said = found.value if isinstance(found, DriverState) else repr(found)
        raise LawBroken(f"after {after} the state is {said}; it must be {state.value}")


def read(trial: DriverTrial) -> Measured:
    """Return a reading, of the right types and shapes and finite."""
    found = trial.call("read")
    if not isinstance(found, Measured):
        raise LawBroken(f"read returned {type(found).__name__}; it must be Measured")
    k = len(trial.facts.joint_names)
    for what, values in (("positions", found.positions), ("velocities", found.velocities)):
        if not np.isfinite(checked(values, what, np.float64, (k,))).all():
            raise LawBroken(f"read returned {what} {numbers(values)}; all must be finite")
    if not isinstance(found.seconds, float) or not np.isfinite(found.seconds):
        raise LawBroken(f"read returned the time {found.seconds!r}; it must be a finite float")
    return found


def send(
    trial: DriverTrial, start: Floats, target: Floats, part: float = 1.0, told: list[Measured] | None = None
) -> float:
    """Send the robot on a way, or only on a part of it; return how far it stays from a target that it goes to.

    The way is 3 s^2 - 2 s^3 of the time, so that it begins and ends at rest. Readings on it are added to `told`.
    """
    steps = max(2, round(_WAY_SECONDS / trial.facts.period_seconds))
    for i in range(1, round(part * steps) + 1):
        s = i / steps
        rate = 6.0 * s * (1.0 - s) / _WAY_SECONDS
        trial.call("write", start + (target - start) * s * s * (3.0 - 2.0 * s), (target - start) * rate)
        time.sleep(trial.facts.period_seconds)
        if told is not None:
            told.append(read(trial))
    if part < 1.0:
        return 0.0

    def arrived() -> bool:
        trial.call("write", target, np.zeros_like(target))
        now = read(trial)
        if told is not None:
            told.append(now)
        return bool((np.abs(now.positions - target) <= trial.facts.tolerance).all())

    until(trial, arrived)
    found = read(trial).positions
    off = np.abs(found - target)
    if off.max() > trial.facts.tolerance:
        joint = trial.facts.joint_names[int(off.argmax())]
        raise LawBroken(
            f"written {numbers(target)}, it is at {numbers(found)} {trial.facts.settle_seconds:g} s later: {joint!r} "
            f"is {off.max():.3g} off; it may be {trial.facts.tolerance:g} (`tolerance` of DriverFacts)"
        )
    return float(off.max())


def come_to_rest(trial: DriverTrial) -> Floats:
    """Return where the robot comes to rest."""
    limit = trial.facts.tolerance / trial.facts.period_seconds
    until(trial, lambda: bool((np.abs(read(trial).velocities) <= limit).all()))
    found = read(trial)
    if (np.abs(found.velocities) > limit).any():
        raise LawBroken(
            f"{trial.facts.settle_seconds:g} s after it was stopped it has the velocities {numbers(found.velocities)}"
        )
    return found.positions


def must_stay(trial: DriverTrial, place: Floats, after: str) -> float:
    """Return how far the robot goes from a place where it must stay."""
    worst = 0.0
    for _ in range(READINGS):
        time.sleep(trial.facts.period_seconds)
        found = read(trial).positions
        worst = max(worst, float(np.abs(found - place).max()))
        if worst > trial.facts.tolerance:
            raise LawBroken(f"after {after} it moves from {numbers(place)} to {numbers(found)}; it must stay")
    return worst


def break_connection(trial: DriverTrial) -> None:
    """Break the connection and see that the driver notices by the next reading."""
    try:
        trial.call(trial.facts.breaks)
        trial.call("read")
    except (ArgumentError, ComponentFault) as error:
        if trial.has_ended:
            raise LawBroken(f"a broken connection ends its process: {error}") from error
    must_be_in(trial, DriverState.ERROR, f"{trial.facts.breaks} and read")


def until(trial: DriverTrial, done: Callable[[], bool]) -> None:
    """Wait until something is so, at most as long as the robot may take to settle."""
    ends = time.monotonic() + trial.facts.settle_seconds
    while not done() and time.monotonic() < ends:
        time.sleep(trial.facts.period_seconds)


def wrong_joints(names: tuple[str, ...]) -> Iterator[tuple[str, tuple[object, ...], str]]:
    """Yield calls that must be refused."""
    yield "configure", (("no_such_joint", *names[1:]),), "a joint that the robot has not"
    yield "configure", ((*names, "no_such_joint"),), "a joint too many"
    yield "configure", (names[:-1],), "a joint too few"
    yield "configure", ((),), "no joint"
    yield "configure", ((*names[:-1], names[0]) if len(names) > 1 else (*names, *names),), "a joint twice"


def wrong_targets(held: Floats) -> Iterator[tuple[str, tuple[object, ...], str]]:
    """Yield calls that must be refused."""
    still = np.zeros_like(held)
    for what, value in (("NaN", np.nan), ("infinity", np.inf)):
        wrong = still.copy()
        wrong[-1] = value
        yield "write", (held + wrong, still), f"positions with {what}"
        yield "write", (held, wrong), f"velocities with {what}"
    yield "write", (np.append(held, 0.0), np.append(still, 0.0)), "a value too many"
    yield "write", (held[:-1], still[:-1]), "a value too few"
    yield "write", (held[None], still[None]), "a matrix"
