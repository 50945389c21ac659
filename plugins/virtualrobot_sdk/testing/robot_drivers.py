"""The contract suite for robot drivers: what they tell, and what a robot does that hangs on one.

Laws that let a robot follow are tried only where its author permits it.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from virtualrobot_sdk.drivers import About, Mode, Pace, Reading, Safety
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.component_contract import ComponentContract
from virtualrobot_sdk.testing.driver_stage import READINGS, Complaint
from virtualrobot_sdk.testing.laws import LawBroken, Measured
from virtualrobot_sdk.testing.robot_handling import (
    DriverFacts,
    DriverTrial,
    anew,
    connected,
    fresh,
    held,
    must_be_at,
    must_be_free_to_move,
    must_be_stated,
    must_stay,
    performed,
    read,
)
from virtualrobot_sdk.testing.trial import Law, NotTried, Trial, numbers

CLOCKS = 5.0
"""Factor by which the readings' time may run faster or slower than the wall clock."""
TOLD_SECONDS = 0.1
"""Time (s) within which a driver tells that its connection is broken or its controller silent."""
BUSY = 20.0
"""Factor by which a busy machine may take longer than that."""


def connecting(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """Connect tells what is consistent, and the same when it connects again; close is harmless, twice too."""
    anew(trial)
    trial.call("close")
    first = connected(trial)
    if wrong := _wrong(first, trial.facts):
        raise LawBroken(f"connect: {wrong}")
    place = read(trial)[0].positions
    for _ in range(2):
        trial.call("close")
    again = connected(trial)
    if again != first:
        raise LawBroken(f"connected again, it tells {again}; it was {first}")
    must_stay(read(trial), place, "it was closed and connected again", trial.facts.tolerance)
    return Measured(2)


def unreachable(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """Connect says where nobody answers, in words that name the place."""
    must_be_stated(trial, "nobody")
    nobody = dict(trial.facts.nobody or {})
    anew(trial)
    with Trial(trial.kind, dataclasses.replace(trial.subject, settings=nobody), trial.facts) as other:
        found = other.call("connected")
        other.call("let_go")
    if not isinstance(found, Complaint):
        raise LawBroken(f"with {nobody} nobody answers, and connect returns {found}; it must raise DriverFault")
    if not any(str(value) in found.text for value in nobody.values()):
        raise LawBroken(f"connect complains {str(found)!r}; it must say where nobody answers, of {nobody}")
    return Measured(1)


def readings(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """Readings are finite and where the robot stands; their stamps grow by seconds, at the rate that connect tells."""
    about = fresh(trial)
    stands = trial.facts.stands_at
    began = time.monotonic()
    found = read(trial, READINGS)
    took = time.monotonic() - began
    if stands is not None:
        off = np.abs(found[0].positions - stands)
        if off.max() > trial.facts.tolerance:
            raise LawBroken(
                f"it reads {numbers(found[0].positions)}, and the robot stands at {numbers(np.array(stands))} rad or m "
                "(`stands_at` of DriverFacts)"
            )
    stamps = np.array([one.stamp for one in found])
    if (np.diff(stamps) < 0.0).any():
        raise LawBroken(f"the stamps of readings are {numbers(stamps)}; they must not fall")
    grown = int((np.diff(stamps) > 0.0).sum())
    if grown < (READINGS - 1) / 2:
        raise LawBroken(
            f"of {READINGS} readings, taken {about.rate:g} times a second as connect tells, {grown} have a new stamp: "
            f"{numbers(stamps)}"
        )
    told, least = stamps[-1] - stamps[0], (READINGS - 1) / about.rate / CLOCKS
    if not least <= told <= max(took, least) * CLOCKS:
        raise LawBroken(f"the stamps of readings grew by {told:.3g} within {took:.3g} s; they must be in seconds")
    return Measured(READINGS, {"cycles": told * about.rate})


def silence(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """A controller that is silent is told as a DriverFault; afterwards connect works again."""
    must_be_stated(trial, "silences", "mends")
    return _told(trial, trial.facts.silences, "silent")


def holding(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """A robot stays where it is as it is begun, and while that is sent; readings have Mode.RUNNING until `end`."""
    must_be_free_to_move(trial)
    session = performed(trial)
    worst = must_stay(session.holding + session.after, session.held, "begin and end", trial.facts.tolerance)
    if session.after[-1].mode is Mode.RUNNING:
        raise LawBroken("after end the robot still follows: its readings have Mode.RUNNING; `end` must tell it not to")
    return Measured(len(session.holding), {"rad, m": worst})


def following(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """A robot goes where setpoints lead it, joint by joint, and back, at the velocities that it tells."""
    must_be_free_to_move(trial)
    if _pace(trial) is Pace.JOBS:
        raise NotTried("its controller plans by itself: see `jobs`")
    way = trial.facts.way * rng.choice([-1.0, 1.0], trial.facts.joints) * rng.uniform(0.3, 1.0, trial.facts.joints)
    session = performed(trial, way, np.zeros_like(way))
    there, back = session.going
    worst = must_be_at(there[-1], session.held + way, trial.facts, "sent")
    worst = max(worst, must_be_at(back[-1], session.held, trial.facts, "sent back to"))
    must_stay(session.after, session.held, "end", 2 * trial.facts.tolerance)
    _look_at_velocities(there, trial.facts)
    return Measured(2, {"rad, m": worst})


def jobs(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """A controller that plans by itself goes to each point; run returns at once, and `done` counts them."""
    must_be_free_to_move(trial)
    if _pace(trial) is not Pace.JOBS:
        raise NotTried("its controller follows setpoints: see `following`")
    way = trial.facts.way * rng.choice([-1.0, 1.0], trial.facts.joints) * rng.uniform(0.3, 1.0, trial.facts.joints)
    session = performed(trial, way, np.zeros_like(way))
    for i, (going, point) in enumerate(zip(session.going, (way, np.zeros_like(way)), strict=True)):
        if going[-1].done != i + 1:
            raise LawBroken(
                f"{trial.facts.settle_seconds:g} s after it was given, `done` of point {i + 1} is {going[-1].done}"
            )
        must_be_at(going[-1], session.held + point, trial.facts, "run to")
    if session.took > BUSY * TOLD_SECONDS:
        raise LawBroken(f"run took {session.took:.3g} s; it must return at once")
    return Measured(2, {"s": session.took})


def stopping(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """A stop in the middle of a way brings the robot to rest; begun again, it does not go on."""
    must_be_free_to_move(trial)
    way = np.full(trial.facts.joints, trial.facts.way)
    jobs = _pace(trial) is Pace.JOBS
    # By itself a controller may go as fast as its stop needs the other half of the way.
    session = performed(trial, way, cut=0.25 if jobs else 0.5, ending="stop")
    rest = session.after[-1].positions
    short = 0.05 * trial.facts.way if jobs else -trial.facts.tolerance
    if (rest > session.held + way - short).any():
        raise LawBroken(
            f"stopped on the way from {numbers(session.held)} to {numbers(session.held + way)}, it rests at "
            f"{numbers(rest)}"
        )
    worst = must_stay(session.after[-READINGS:], rest, "it came to rest after a stop", trial.facts.tolerance)
    connected(trial)
    held(trial, READINGS, "stop")
    return Measured(2 * READINGS, {"rad, m": worst})


def ending(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """Stop, end and close are harmless in any order, more than once, and readings come until close."""
    fresh(trial)
    place = read(trial)[0].positions
    for call in ("end", "stop", "stop", "end"):
        if (complaint := trial.call("attempt", call)) is not None:
            raise LawBroken(f"{call} of a robot that was not begun complains: {complaint}")
        must_stay(read(trial), place, call, trial.facts.tolerance)
    if trial.facts.moves:
        held(trial, 1, "stop", "end", "end", "stop")
    for _ in range(2):
        trial.call("close")
    return Measured(8)


def complaints(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """A fault of the controller reaches the reader in its own words; `reset` clears it where `clears` says so."""
    must_be_stated(trial, "complains", "words")
    facts = trial.facts
    fresh(trial)
    found = trial.call("told", facts.complains, BUSY * TOLD_SECONDS)
    said = found.text if isinstance(found, Reading) else str(found) if found is not None else ""
    if facts.words not in said:
        raise LawBroken(f"after {facts.complains} it says {said!r}; the controller says {facts.words!r} (`words`)")
    if isinstance(found, Reading) and found.safety in (Safety.NORMAL, Safety.REDUCED) and facts.moves:
        raise LawBroken(f"after {facts.complains} it says {said!r}, and its safety is {found.safety.name}")
    if not facts.moves:
        return Measured(1)
    refused = found if isinstance(found, Complaint) else _refusal(trial)
    if refused is None:
        raise LawBroken(f"it says {said!r}, and begin is taken; it must raise DriverFault")
    if facts.words not in str(refused):
        raise LawBroken(f"it says {said!r}, and begin complains {str(refused)!r}: the words must be the controller's")
    if isinstance(found, Complaint):
        connected(trial)
    if refused.clears:
        trial.call("reset")
    elif facts.heals:
        trial.call("act", facts.heals)
    else:
        return Measured(1, note="a person has to clear it")
    if (left := _refusal(trial)) is not None:
        raise LawBroken(f"after {'reset' if refused.clears else facts.heals} begin still complains: {left}")
    return Measured(2)


def recovery(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """A broken connection is told; connected again, it reads where the robot is, and nothing moves unasked."""
    must_be_stated(trial, "breaks", "mends")
    return _told(trial, trial.facts.breaks, "broken")


LAWS: Mapping[str, Law] = MappingProxyType(
    {
        law.__name__: law
        for law in (
            *(connecting, unreachable, readings, silence, holding, following, jobs, stopping, ending, complaints),
            recovery,
        )
    }
)
"""Laws of all robot drivers, by name, in the order in which they are tried."""


class RobotDriverContract(ComponentContract):
    """Contract of all robot drivers; subclass it in a test file.

    class TestMyDriver(RobotDriverContract):
        component = "my_package/my_driver"
        facts = DriverFacts(joints=6)
    """

    kind = ComponentKind.ROBOT_DRIVER
    laws = LAWS
    facts: ClassVar[DriverFacts]

    @classmethod
    def teardown_class(cls) -> None:
        """Let the robot go, then end the process."""
        try:
            cls.trial.renew()
            cls.trial.call("let_go")
        finally:
            super().teardown_class()


def _pace(trial: DriverTrial) -> Pace:
    return fresh(trial).pace


def _refusal(trial: DriverTrial) -> Complaint | None:
    """Return what begin complains of, if anything; the robot is stopped then."""
    found = trial.call("hold", 0, "stop")
    return next((one for one in found if isinstance(one, Complaint)), None)


def _told(trial: DriverTrial, path: str, what: str) -> Measured:
    """Break something, see that it is told in time, mend it, and see that the robot stands and may be read again."""
    about = fresh(trial)
    limit = BUSY * max(TOLD_SECONDS, 3.0 / about.rate)
    complaint = trial.call("complaint", path, limit)
    if complaint is None:
        raise LawBroken(f"after {path} the controller is {what}, and read goes on for {limit:.3g} s; it must raise")
    if complaint.seconds > limit:
        raise LawBroken(f"that its controller is {what} it tells {complaint.seconds:.3g} s later: {complaint}")
    if not complaint.text:
        raise LawBroken(f"that its controller is {what} it tells without a word")
    trial.call("act", trial.facts.mends)
    again = connected(trial)
    if again != about:
        raise LawBroken(f"connected again, it tells {again}; it was {about}")
    found = read(trial, READINGS)
    must_stay(found, found[0].positions, "it was connected again", trial.facts.tolerance)
    return Measured(1, {"s": complaint.seconds})


def _wrong(about: About, facts: DriverFacts) -> str:
    """Return what is wrong with what connect tells; empty when nothing is."""
    if about.joints != facts.joints:
        return f"joints is {about.joints}; the robot has {facts.joints} (`joints` of DriverFacts)"
    if not (isinstance(about.rate, float | int) and np.isfinite(about.rate) and about.rate > 0.0):
        return f"rate is {about.rate!r}; it must be cycles a second, above 0"
    if not isinstance(about.pace, Pace):
        return f"pace is {about.pace!r}; it must be of Pace"
    units = np.asarray(about.units, dtype=np.float64)
    if units.shape not in ((), (about.joints,)) or not (np.isfinite(units).all() and (units > 0.0).all()):
        return f"units are {about.units!r}; they must be rad or m per unit, above 0, one for all or one a joint"
    for name in ("watchdog", "silence"):
        if not (np.isfinite(getattr(about, name)) and getattr(about, name) >= 0.0):
            return f"{name} is {getattr(about, name)!r}; it must be seconds, 0 for none"
    for name in ("inputs", "outputs"):
        if not 0 <= getattr(about, name) <= 64:
            return f"{name} is {getattr(about, name)!r}; it must be 0 to 64"
    return ""


def _look_at_velocities(found: list[Reading], facts: DriverFacts) -> None:
    """Raise LawBroken unless velocities sum up to the way over the readings' own times, whatever the law of motion."""
    if any(one.velocities is None for one in found):
        return
    places, rates = (np.array([getattr(one, name) for one in found]) for name in ("positions", "velocities"))
    way = places[-1] - places[0]
    summed = (rates[1:] * np.diff([one.stamp for one in found])[:, None]).sum(axis=0)
    far = np.abs(way) > 4.0 * facts.tolerance
    share = summed / np.where(far, way, 1.0)
    if (far & ~((share > 0.2) & (share < 5.0))).any():
        raise LawBroken(
            f"it goes by {numbers(way)}, and the velocities that it tells make {numbers(summed)} in the readings' own "
            "times; they must be in the units of positions a second, of the way's sign"
        )
