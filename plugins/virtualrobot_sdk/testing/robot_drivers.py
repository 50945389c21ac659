"""The contract suite for robot drivers: their life cycle, and what a robot does that hangs on one.

Laws that move a robot are not tried where a real one hangs on the driver.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from virtualrobot_sdk.drivers import TRANSITIONS, DriverState
from virtualrobot_sdk.drivers import Measured as Reading
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.component_contract import ComponentContract
from virtualrobot_sdk.testing.laws import LawBroken, Measured
from virtualrobot_sdk.testing.robot_handling import (
    READINGS,
    DriverFacts,
    DriverTrial,
    break_connection,
    bring_to,
    come_to_rest,
    let_go,
    must_be_free_to_move,
    must_be_in,
    must_stay,
    read,
    send,
    states_to_try,
    wrong_joints,
    wrong_targets,
)
from virtualrobot_sdk.testing.trial import Law, NotTried, must_refuse, numbers

CLOCKS = 5.0
"""Factor by which the readings' time may run faster or slower than the wall clock."""
CALLS = ("configure", "activate", "read", "write", "stop", "deactivate", "cleanup")
"""Every call of a driver."""


def life_cycle(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """Each call is taken or refused in each state as TRANSITIONS has it, and leads to the state that it says."""
    tried = 0
    for state in states_to_try(trial):
        for call in CALLS:
            if trial.facts.is_real and TRANSITIONS[state].get(call) is DriverState.ACTIVE:
                continue
            held = bring_to(trial, state)
            arguments = {"configure": (trial.facts.joint_names,), "write": (held, np.zeros_like(held))}.get(call, ())
            expected = TRANSITIONS[state].get(call)
            tried += 1
            try:
                trial.call(call, *arguments)
            except ArgumentError as error:
                if expected is not None:
                    raise LawBroken(f"{call} is refused in {state.value}: {error}") from error
                must_be_in(trial, state, f"{call} was refused")
                continue
            if expected is None:
                raise LawBroken(f"{call} is taken in {state.value}; it must be refused by an ArgumentError there")
            must_be_in(trial, expected, f"{call} in {state.value}")
    return Measured(tried)


def refusals(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """Wrong joints and wrong targets are refused, and leave the driver in its state."""
    bring_to(trial, DriverState.UNCONFIGURED)
    tried = must_refuse(trial, wrong_joints(trial.facts.joint_names))
    must_be_in(trial, DriverState.UNCONFIGURED, "configure was refused")
    if not trial.facts.is_real:
        held = bring_to(trial, DriverState.ACTIVE)
        tried += must_refuse(trial, wrong_targets(held))
        must_be_in(trial, DriverState.ACTIVE, "write was refused")
        must_stay(trial, held, "wrong targets were refused")
    return Measured(tried)


def reading(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """Readings are finite, are where the robot stands, and their time grows by seconds."""
    bring_to(trial, DriverState.INACTIVE)
    began = time.monotonic()
    first = last = read(trial)
    if trial.facts.stands_at is not None:
        off = np.abs(first.positions - trial.facts.stands_at)
        if off.max() > trial.facts.tolerance:
            stands = numbers(np.array(trial.facts.stands_at))
            raise LawBroken(
                f"it reads {numbers(first.positions)}, and the robot stands at {stands} rad or m (`stands_at` of "
                "DriverFacts)"
            )
    for _ in range(READINGS):
        time.sleep(trial.facts.period_seconds)
        now = read(trial)
        if now.seconds < last.seconds:
            raise LawBroken(f"the time of a reading is {now.seconds:.6f} s after {last.seconds:.6f} s")
        last = now
    if not last.seconds > first.seconds:
        waited = READINGS * trial.facts.period_seconds
        raise LawBroken(f"the time of {READINGS} readings within {waited:.3g} s is always {first.seconds:.6f} s")
    took, told = time.monotonic() - began, last.seconds - first.seconds
    if not took / CLOCKS <= told <= CLOCKS * took:
        raise LawBroken(f"the time of readings grew by {told:.3g} within {took:.3g} s; it must be in seconds")
    return Measured(READINGS)


def order(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """Arrays that are read and written are in the order of the names that `configure` was given."""
    names = trial.facts.joint_names
    if len(names) < 2:
        raise NotTried("it has one joint")
    if not trial.facts.is_real:
        # Each joint at a place of its own, so that an order is seen.
        held = bring_to(trial, DriverState.ACTIVE)
        send(trial, held, held + trial.facts.way * np.linspace(-1.0, 1.0, len(names)))
        trial.call("deactivate")
        before = read(trial).positions
        trial.call("cleanup")
    else:
        before = bring_to(trial, DriverState.INACTIVE)
        trial.call("cleanup")
    turned = rng.permutation(len(names))
    while (turned == np.arange(len(names))).all():
        turned = rng.permutation(len(names))
    trial.call("configure", tuple(names[i] for i in turned))
    found = read(trial).positions
    off = np.abs(found - before[turned])
    if off.max() > trial.facts.tolerance:
        raise LawBroken(
            f"configured for {', '.join(names)} it reads {numbers(before)}, and for "
            f"{', '.join(names[i] for i in turned)} {numbers(found)}; values must have the order of the names"
        )
    if not trial.facts.is_real:
        # What is written in that order goes where it is read in it.
        trial.call("activate")
        send(trial, found, found + trial.facts.way * np.linspace(-1.0, 1.0, len(names)))
    return Measured(1, {"rad, m": float(off.max())})


def holding(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """A robot that is activated stays where it is until something is written, and where nothing may be written too."""
    must_be_free_to_move(trial)
    held = bring_to(trial, DriverState.ACTIVE)
    worst = must_stay(trial, held, "it was activated and nothing was written")
    trial.call("deactivate")
    held = read(trial).positions
    must_refuse(trial, [("write", (held + trial.facts.way, np.zeros_like(held)), "a target in INACTIVE")])
    worst = max(worst, must_stay(trial, held, "a target was refused in INACTIVE"))
    return Measured(2 * READINGS, {"rad, m": worst})


def following(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """An active robot goes where it is told, joint by joint, and back, at the velocities that it tells."""
    must_be_free_to_move(trial)
    held = bring_to(trial, DriverState.ACTIVE)
    target = held + trial.facts.way * rng.choice([-1.0, 1.0], len(held)) * rng.uniform(0.3, 1.0, len(held))
    told: list[Reading] = []
    worst = max(send(trial, held, target, told=told), send(trial, target, held))
    # The sum of velocities over the readings' own times is the way, whatever the law of motion.
    places, rates, times = (np.array([getattr(one, n) for one in told]) for n in ("positions", "velocities", "seconds"))
    way = places[-1] - places[0]
    summed = (rates[1:] * np.diff(times)[:, None]).sum(axis=0)
    far = np.abs(way) > 4.0 * trial.facts.tolerance
    if (far & ~((summed / np.where(far, way, 1.0) > 0.3) & (summed / np.where(far, way, 1.0) < 3.0))).any():
        raise LawBroken(
            f"it goes by {numbers(way)}, and the velocities that it tells make {numbers(summed)} in the readings' own "
            "times; they must be in rad/s and m/s, of the way's sign"
        )
    return Measured(2, {"rad, m": worst})


def stopping(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """A stop in the middle of a way brings the robot to rest, and it does not go on when it is active again."""
    must_be_free_to_move(trial)
    held = bring_to(trial, DriverState.ACTIVE)
    send(trial, held, held + trial.facts.way, part=0.5)
    trial.call("stop")
    must_be_in(trial, DriverState.INACTIVE, "stop")
    rest = come_to_rest(trial)
    if (rest - held > trial.facts.way + trial.facts.tolerance).any():
        raise LawBroken(
            f"stopped on half of the way from {numbers(held)} to {numbers(held + trial.facts.way)}, it rests past its "
            f"end at {numbers(rest)}"
        )
    worst = must_stay(trial, rest, "it came to rest after a stop")
    trial.call("activate")
    worst = max(worst, must_stay(trial, rest, "it was stopped on its way and activated again"))
    return Measured(2 * READINGS, {"rad, m": worst})


def recovery(trial: DriverTrial, rng: np.random.Generator) -> Measured:
    """A broken connection is an error, ERROR is the state, and the driver starts again from where the robot is."""
    must_be_free_to_move(trial)
    if not trial.facts.breaks:
        raise NotTried("`breaks` of DriverFacts names no method that breaks the connection")
    held = bring_to(trial, DriverState.ACTIVE)
    send(trial, held, held + trial.facts.way, part=0.5)
    break_connection(trial)
    trial.call("configure", trial.facts.joint_names)
    must_be_in(trial, DriverState.INACTIVE, "configure in ERROR")
    rest = come_to_rest(trial)
    trial.call("activate")
    worst = must_stay(trial, rest, "its connection broke on its way and it was activated again")
    worst = max(worst, send(trial, rest, held))
    return Measured(READINGS, {"rad, m": worst})


LAWS: Mapping[str, Law] = MappingProxyType(
    {law.__name__: law for law in (life_cycle, refusals, reading, order, holding, following, stopping, recovery)}
)
"""Laws of all robot drivers, by name, in the order in which they are tried."""


class RobotDriverContract(ComponentContract):
    """Contract of all robot drivers; subclass it in a test file.

    class TestMyDriver(RobotDriverContract):
        component = "my_package/my_driver"
        facts = DriverFacts(("shoulder", "elbow", "wrist"), is_real=True)
    """

    kind = ComponentKind.ROBOT_DRIVER
    laws = LAWS
    facts: ClassVar[DriverFacts]

    @classmethod
    def teardown_class(cls) -> None:
        """Let the robot go, then end the process."""
        try:
            cls.trial.renew()
            let_go(cls.trial)
        finally:
            super().teardown_class()
