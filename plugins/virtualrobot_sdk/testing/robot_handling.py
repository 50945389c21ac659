"""Handling of a robot in the suite for drivers: what an author states of it, and the ways that it is sent on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from virtualrobot_sdk.drivers import About, Pace, Reading
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.testing.driver_stage import Complaint, Script, Session
from virtualrobot_sdk.testing.laws import LawBroken
from virtualrobot_sdk.testing.trial import NotTried, Trial, numbers

WAY_SECONDS = 0.3
"""Duration of the way that a robot is sent (s)."""
PROMPT_SECONDS = 0.1
"""Time (s) within which a controller that plans by itself must have been stopped where the suite wants it to be."""
_SLOW_CALLS = 30.0
"""Longest time (s) to connect, begin and end, each of which may take ten."""
ATTEMPTS = 5
"""Number of times that a robot is sent on a way while the machine is too busy to send setpoints in time."""


@dataclass(frozen=True, slots=True)
class DriverFacts:
    """Properties of a driver and the robot on it that their author states.

    A `module:function` is called with the driver, in the driver's process: it does something to the controller's
    counterpart.

    Attributes:
        joints: number of the robot's joints.
        moves: whether the robot may be moved by `way`; without it nothing lets it follow.
        way: distance (rad, m) that each joint is moved from where it is; both ways must be free.
        tolerance: largest error (rad, m) of the robot from where it was told to be.
        settle_seconds: longest time to begin, to get there after the last setpoint, and to come to rest after a stop;
            of JOBS, for the whole way.
        stands_at: position of the robot when the suite begins (rad, m), as its panel says it; None: nobody knows, and
            a driver that has its units wrong both ways is not found.
        breaks: `module:function` that breaks the connection as a pulled cable does.
        silences: one after which the controller says nothing more, its connection open.
        mends: one that makes either good.
        complains: one after which the controller has a fault of its own.
        words: part of what it says then.
        heals: one that does what a person has to do where `reset` may not clear the fault.
        nobody: settings with which nobody answers.
    """

    joints: int
    moves: bool = False
    way: float = 0.05
    tolerance: float = 1e-3
    settle_seconds: float = 1.0
    stands_at: tuple[float, ...] | None = None
    breaks: str = ""
    silences: str = ""
    mends: str = ""
    complains: str = ""
    words: str = ""
    heals: str = ""
    nobody: Mapping[str, Any] | None = None


DriverTrial = Trial[DriverFacts]


def must_be_free_to_move(trial: DriverTrial) -> None:
    """Raise NotTried where the robot may not be moved."""
    if not trial.facts.moves:
        raise NotTried("the robot may not be moved (`moves` of DriverFacts)")


def must_be_stated(trial: DriverTrial, *names: str) -> None:
    """Raise NotTried where the facts do not say how something is done."""
    missing = [name for name in names if not getattr(trial.facts, name)]
    if missing:
        raise NotTried(f"DriverFacts does not say {', '.join(f'`{name}`' for name in missing)}")


def anew(trial: DriverTrial) -> None:
    """Let the robot go and make the driver anew."""
    trial.renew()
    trial.call("let_go")
    trial.make_anew()


def connected(trial: DriverTrial) -> About:
    """Return what the driver says of its controller as it connects."""
    found = trial.call("connected")
    if isinstance(found, Complaint):
        raise LawBroken(f"connect complains: {found}")
    return found


def fresh(trial: DriverTrial) -> About:
    """Make the driver anew and connect it."""
    anew(trial)
    return connected(trial)


def read(trial: DriverTrial, count: int = 1) -> list[Reading]:
    """Return readings, which must come."""
    found = trial.call("readings", count)
    if isinstance(found[-1], Complaint):
        raise LawBroken(f"read complains: {found[-1]}")
    return found


def held(trial: DriverTrial, count: int, *calls: str) -> list[Reading]:
    """Begin where the robot is, keep it there for some readings, then make calls; return readings, the robot's place.

    Raises LawBroken where it complains, and where it moves.
    """
    place = read(trial)[0].positions
    found = trial.call("hold", count, *calls)
    said = ", ".join(("begin", *calls))
    if found and isinstance(found[-1], Complaint):
        raise LawBroken(f"{said} of a robot at rest complains: {found[-1]}")
    must_stay(found, place, said, trial.facts.tolerance)
    return found


def performed(trial: DriverTrial, *ways: Floats, cut: float = 1.0, ending: str = "end") -> Session:
    """Send the robot of a driver made anew on ways; raise LawBroken for what is wrong with any of them.

    A machine that is too busy to send as often as the controller's watchdog wants proves nothing: it is tried again.
    """
    facts = trial.facts
    script = Script(ways, WAY_SECONDS, facts.settle_seconds, facts.tolerance, cut, ending)
    for _ in range(ATTEMPTS):
        anew(trial)
        session: Session = trial.call_within(_SLOW_CALLS + (2 + len(ways)) * facts.settle_seconds, "perform", script)
        jobs = session.about.pace is Pace.JOBS
        limit = (PROMPT_SECONDS if cut < 1.0 else 0.0) if jobs else session.about.watchdog / 2
        if not 0.0 < limit < session.late:
            break
    else:
        raise NotTried(f"this machine is too busy: it is {session.late:.3g} s late")
    if session.complaint is not None:
        raise LawBroken(f"it complains: {session.complaint}")
    if not session.running:
        raise LawBroken(
            f"after begin no reading has Mode.RUNNING for {facts.settle_seconds:g} s; they have "
            f"{session.holding[-1].mode.name}, {session.holding[-1].safety.name} {session.holding[-1].text}"
        )
    must_stay(session.holding, session.held, "begin, and setpoints where it is,", facts.tolerance)
    return session


def must_be_at(reading: Reading, place: Floats, facts: DriverFacts, told: str) -> float:
    """Return how far the robot is from where it was told to be."""
    off = np.abs(reading.positions - place)
    if off.max() > facts.tolerance:
        raise LawBroken(
            f"{told} {numbers(place)}, it is at {numbers(reading.positions)} {facts.settle_seconds:g} s later: joint "
            f"{int(off.argmax())} is {off.max():.3g} off; it may be {facts.tolerance:g} (`tolerance` of DriverFacts)"
        )
    return float(off.max())


def must_stay(readings: list[Reading], place: Floats, after: str, tolerance: float) -> float:
    """Return how far the robot goes from a place where it must stay."""
    worst = 0.0
    for reading in readings:
        worst = max(worst, float(np.abs(reading.positions - place).max()))
        if worst > tolerance:
            raise LawBroken(
                f"after {after} it moves from {numbers(place)} to {numbers(reading.positions)}; it must stay"
            )
    return worst
