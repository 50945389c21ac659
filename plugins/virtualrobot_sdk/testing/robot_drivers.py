"""The contract suite for robot drivers: their life cycle, and what a robot does that hangs on one.

Laws that move a robot are not tried where a real one hangs on the driver.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from virtualrobot_sdk.drivers import TRANSITIONS, DriverState, Measured
from virtualrobot_sdk.errors import ArgumentError, ComponentFault
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing import laws
from virtualrobot_sdk.testing.component_contract import ComponentContract
from virtualrobot_sdk.testing.laws import LawBroken
from virtualrobot_sdk.testing.trial import Law, NotTried, Trial, checked, must_refuse, numbers

CALLS = ("configure", "activate", "read", "write", "stop", "deactivate", "cleanup")
"""Every call of a driver."""
READINGS = 10
"""How many readings are taken where a robot is watched."""
_WAY_SECONDS = 0.3
"""How long the way takes that a robot is sent."""


@dataclass(frozen=True, slots=True)
class DriverFacts:
    """What the author says of a driver and the robot on it.

    Attributes:
        joint_names: of the robot, in any order.
        is_real: whether a real robot hangs on it: nothing is activated or moved then.
        period_seconds: how often it is read and written to.
        way: how far (rad, m) each joint is moved from where it is; both ways must be free.
        tolerance: how far (rad, m) the robot may be from where it was told to be.
        settle_seconds: how long it may take to get there after the last write, and to come to rest after a stop.
        breaks: a method of the driver's, without arguments, that breaks the connection as a pulled cable does, for this
            suite only; empty when there is none.
    """

    joint_names: tuple[str, ...]
    is_real: bool = False
    period_seconds: float = 0.01
    way: float = 0.05
    tolerance: float = 1e-3
    settle_seconds: float = 1.0
    breaks: str = ""


DriverTrial = Trial[DriverFacts]


def life_cycle(trial: DriverTrial, rng: np.random.Generator) -> laws.Measured:
    """Each call is taken or refused in each state as TRANSITIONS has it, and leads to the state that it says."""
    tried = 0
    for state in _states(trial):
        for call in CALLS:
            if trial.facts.is_real and TRANSITIONS[state].get(call) is DriverState.ACTIVE:
                continue
            held = _brought(trial, state)
            arguments = {"configure": (trial.facts.joint_names,), "write": (held, np.zeros_like(held))}.get(call, ())
            expected = TRANSITIONS[state].get(call)
            tried += 1
            try:
                trial.call(call, *arguments)
            except ArgumentError as error:
                if expected is not None:
                    raise LawBroken(f"{call} is refused in {state.value}: {error}") from error
                _stands(trial, state, f"{call} was refused")
                continue
            if expected is None:
                raise LawBroken(f"{call} is taken in {state.value}; it must be refused by an ArgumentError there")
            _stands(trial, expected, f"{call} in {state.value}")
    return laws.Measured(tried)


def refusals(trial: DriverTrial, rng: np.random.Generator) -> laws.Measured:
    """Wrong joints and wrong targets are refused, and leave the driver in its state."""
    _brought(trial, DriverState.UNCONFIGURED)
    tried = must_refuse(trial, _wrong_joints(trial.facts.joint_names))
    _stands(trial, DriverState.UNCONFIGURED, "configure was refused")
    if not trial.facts.is_real:
        held = _brought(trial, DriverState.ACTIVE)
        tried += must_refuse(trial, _wrong_targets(held))
        _stands(trial, DriverState.ACTIVE, "write was refused")
        _stays(trial, held, "wrong targets were refused")
    return laws.Measured(tried)


def reading(trial: DriverTrial, rng: np.random.Generator) -> laws.Measured:
    """Readings are finite, have a value for each joint, and their time never falls and grows."""
    _brought(trial, DriverState.INACTIVE)
    first = _read(trial)
    last = first
    for _ in range(READINGS):
        time.sleep(trial.facts.period_seconds)
        now = _read(trial)
        if now.seconds < last.seconds:
            raise LawBroken(f"the time of a reading is {now.seconds:.6f} s after {last.seconds:.6f} s")
        last = now
    if not last.seconds > first.seconds:
        waited = READINGS * trial.facts.period_seconds
        raise LawBroken(f"the time of {READINGS} readings within {waited:.3g} s is always {first.seconds:.6f} s")
    return laws.Measured(READINGS)


def order(trial: DriverTrial, rng: np.random.Generator) -> laws.Measured:
    """Arrays are in the order of the names that `configure` was given."""
    names = trial.facts.joint_names
    if len(names) < 2:
        raise NotTried("it has one joint")
    if not trial.facts.is_real:
        # Each joint at a place of its own, so that an order is seen.
        held = _brought(trial, DriverState.ACTIVE)
        _sent(trial, held, held + trial.facts.way * np.linspace(-1.0, 1.0, len(names)))
        trial.call("deactivate")
        before = _read(trial).positions
        trial.call("cleanup")
    else:
        before = _brought(trial, DriverState.INACTIVE)
        trial.call("cleanup")
    turned = rng.permutation(len(names))
    while (turned == np.arange(len(names))).all():
        turned = rng.permutation(len(names))
    trial.call("configure", tuple(names[i] for i in turned))
    found = _read(trial).positions
    off = np.abs(found - before[turned])
    if off.max() > trial.facts.tolerance:
        raise LawBroken(
            f"configured for {', '.join(names)} it reads {numbers(before)}, and for "
            f"{', '.join(names[i] for i in turned)} {numbers(found)}; values must have the order of the names"
        )
    return laws.Measured(1, {"rad, m": float(off.max())})


def holding(trial: DriverTrial, rng: np.random.Generator) -> laws.Measured:
    """A robot that is activated stays where it is until something is written, and where nothing may be written too."""
    _may_move(trial)
    held = _brought(trial, DriverState.ACTIVE)
    worst = _stays(trial, held, "it was activated and nothing was written")
    trial.call("deactivate")
    held = _read(trial).positions
    must_refuse(trial, [("write", (held + trial.facts.way, np.zeros_like(held)), "a target in INACTIVE")])
    worst = max(worst, _stays(trial, held, "a target was refused in INACTIVE"))
    return laws.Measured(2 * READINGS, {"rad, m": worst})


def following(trial: DriverTrial, rng: np.random.Generator) -> laws.Measured:
    """An active robot goes where it is told, joint by joint, and back."""
    _may_move(trial)
    held = _brought(trial, DriverState.ACTIVE)
    target = held + trial.facts.way * rng.choice([-1.0, 1.0], len(held)) * rng.uniform(0.3, 1.0, len(held))
    worst = max(_sent(trial, held, target), _sent(trial, target, held))
    return laws.Measured(2, {"rad, m": worst})


def stopping(trial: DriverTrial, rng: np.random.Generator) -> laws.Measured:
    """A stop in the middle of a way brings the robot to rest, and it does not go on when it is active again."""
    _may_move(trial)
    held = _brought(trial, DriverState.ACTIVE)
    _sent(trial, held, held + trial.facts.way, part=0.5)
    trial.call("stop")
    _stands(trial, DriverState.INACTIVE, "stop")
    rest = _at_rest(trial)
    if (rest - held > trial.facts.way + trial.facts.tolerance).any():
        raise LawBroken(
            f"stopped on half of the way from {numbers(held)} to {numbers(held + trial.facts.way)}, it rests past its "
            f"end at {numbers(rest)}"
        )
    worst = _stays(trial, rest, "it came to rest after a stop")
    trial.call("activate")
    worst = max(worst, _stays(trial, rest, "it was stopped on its way and activated again"))
    return laws.Measured(2 * READINGS, {"rad, m": worst})


def recovery(trial: DriverTrial, rng: np.random.Generator) -> laws.Measured:
    """A broken connection is an error, ERROR is the state, and the driver starts again from where the robot is."""
    _may_move(trial)
    if not trial.facts.breaks:
        raise NotTried("`breaks` of DriverFacts names no method that breaks the connection")
    held = _brought(trial, DriverState.ACTIVE)
    _sent(trial, held, held + trial.facts.way, part=0.5)
    _broken(trial)
    trial.call("configure", trial.facts.joint_names)
    _stands(trial, DriverState.INACTIVE, "configure in ERROR")
    rest = _at_rest(trial)
    trial.call("activate")
    worst = _stays(trial, rest, "its connection broke on its way and it was activated again")
    worst = max(worst, _sent(trial, rest, held))
    return laws.Measured(READINGS, {"rad, m": worst})


LAWS: Mapping[str, Law] = MappingProxyType(
    {law.__name__: law for law in (life_cycle, refusals, reading, order, holding, following, stopping, recovery)}
)
"""What every robot driver must keep, in the order in which it is tried."""


class RobotDriverContract(ComponentContract):
    """What every robot driver must keep; subclass it in a test file.

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
        cls.trial.renew()
        _let_go(cls.trial)
        super().teardown_class()


def _may_move(trial: DriverTrial) -> None:
    if trial.facts.is_real:
        raise NotTried("a real robot hangs on it (`is_real` of DriverFacts)")


def _states(trial: DriverTrial) -> list[DriverState]:
    """Return the states that the driver is tried in."""
    found = [DriverState.UNCONFIGURED, DriverState.INACTIVE]
    if not trial.facts.is_real:
        found += [DriverState.ACTIVE, *([DriverState.ERROR] if trial.facts.breaks else [])]
    return found


def _brought(trial: DriverTrial, state: DriverState) -> Floats:
    """Bring a driver made anew to a state, and return where its joints are, zeros where it does not know."""
    _let_go(trial)
    trial.make_anew()
    _stands(trial, DriverState.UNCONFIGURED, "it was made")
    positions = np.zeros(len(trial.facts.joint_names))
    if state is DriverState.UNCONFIGURED:
        return positions
    trial.call("configure", trial.facts.joint_names)
    _stands(trial, DriverState.INACTIVE, "configure")
    positions = _read(trial).positions
    if state is DriverState.INACTIVE:
        return positions
    trial.call("activate")
    _stands(trial, DriverState.ACTIVE, "activate")
    if state is DriverState.ERROR:
        _broken(trial)
    return positions


def _let_go(trial: DriverTrial) -> None:
    """Give the connection back, so that another driver may have it; the law about it is `life_cycle`."""
    for call in ("stop", "cleanup"):
        try:
            trial.call(call)
        except (ArgumentError, ComponentFault):
            trial.renew()


def _stands(trial: DriverTrial, state: DriverState, after: str) -> None:
    found = trial.call("state")
    if found is not state:
        said = found.value if isinstance(found, DriverState) else repr(found)
        raise LawBroken(f"after {after} the state is {said}; it must be {state.value}")


def _read(trial: DriverTrial) -> Measured:
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


def _sent(trial: DriverTrial, start: Floats, target: Floats, part: float = 1.0) -> float:
    """Send the robot on a way, or only on a part of it; return how far it stays from a target that it goes to.

    The way is 3 s^2 - 2 s^3 of the time, so that it begins and ends at rest.
    """
    steps = max(2, round(_WAY_SECONDS / trial.facts.period_seconds))
    for i in range(1, round(part * steps) + 1):
        s = i / steps
        rate = 6.0 * s * (1.0 - s) / _WAY_SECONDS
        trial.call("write", start + (target - start) * s * s * (3.0 - 2.0 * s), (target - start) * rate)
        time.sleep(trial.facts.period_seconds)
    if part < 1.0:
        return 0.0

    def arrived() -> bool:
        trial.call("write", target, np.zeros_like(target))
        return bool((np.abs(_read(trial).positions - target) <= trial.facts.tolerance).all())

    _until(trial, arrived)
    found = _read(trial).positions
    off = np.abs(found - target)
    if off.max() > trial.facts.tolerance:
        joint = trial.facts.joint_names[int(off.argmax())]
        raise LawBroken(
            f"written {numbers(target)}, it is at {numbers(found)} {trial.facts.settle_seconds:g} s later: {joint!r} "
            f"is {off.max():.3g} off; it may be {trial.facts.tolerance:g} (`tolerance` of DriverFacts)"
        )
    return float(off.max())


def _at_rest(trial: DriverTrial) -> Floats:
    """Return where the robot comes to rest."""
    limit = trial.facts.tolerance / trial.facts.period_seconds
    _until(trial, lambda: bool((np.abs(_read(trial).velocities) <= limit).all()))
    found = _read(trial)
    if (np.abs(found.velocities) > limit).any():
        raise LawBroken(
            f"{trial.facts.settle_seconds:g} s after it was stopped it has the velocities {numbers(found.velocities)}"
        )
    return found.positions


def _stays(trial: DriverTrial, place: Floats, after: str) -> float:
    """Return how far the robot goes from a place where it must stay."""
    worst = 0.0
    for _ in range(READINGS):
        time.sleep(trial.facts.period_seconds)
        found = _read(trial).positions
        worst = max(worst, float(np.abs(found - place).max()))
        if worst > trial.facts.tolerance:
            raise LawBroken(f"after {after} it moves from {numbers(place)} to {numbers(found)}; it must stay")
    return worst


def _broken(trial: DriverTrial) -> None:
    """Break the connection and see that the driver notices by the next reading."""
    try:
        trial.call(trial.facts.breaks)
        trial.call("read")
    except (ArgumentError, ComponentFault) as error:
        if trial.has_ended:
            raise LawBroken(f"a broken connection ends its process: {error}") from error
    _stands(trial, DriverState.ERROR, f"{trial.facts.breaks} and read")


def _until(trial: DriverTrial, done: Callable[[], bool]) -> None:
    """Wait until something is so, at most as long as the robot may take to settle."""
    ends = time.monotonic() + trial.facts.settle_seconds
    while not done() and time.monotonic() < ends:
        time.sleep(trial.facts.period_seconds)


def _wrong_joints(names: tuple[str, ...]) -> Iterator[tuple[str, tuple[object, ...], str]]:
    """Yield calls that must be refused."""
    yield "configure", (("no_such_joint", *names[1:]),), "a joint that the robot has not"
    yield "configure", ((*names, "no_such_joint"),), "a joint too many"
    yield "configure", (names[:-1],), "a joint too few"
    yield "configure", ((),), "no joint"
    yield "configure", ((*names[:-1], names[0]) if len(names) > 1 else (*names, *names),), "a joint twice"


def _wrong_targets(held: Floats) -> Iterator[tuple[str, tuple[object, ...], str]]:
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
