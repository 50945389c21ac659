"""The contract suite for vehicle dynamics: drives that follow, steps that add up, vehicles that move alike anywhere."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from virtualrobot_sdk.answers import pose_distance
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.poses import rotation_matrix
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.component_contract import ComponentContract
from virtualrobot_sdk.testing.laws import LawBroken, Measured
from virtualrobot_sdk.testing.trial import Law, Trial, checked, must_refuse, numbers
from virtualrobot_sdk.vehicles import DriveQuantity, Surroundings, VehicleDrive

STEPS = 30
"""Number of random steps that most laws try."""
LONG_WAY = 1000
"""Number of steps made one after the other to see whether the pose stays rigid and the speed finite."""
RIGID = 1e-9
"""Largest error of the rotation of a pose from orthonormal, at any time (largest entry of R^T R - I)."""
SAME = 1e-9
"""Largest difference of poses, twists and states of drives that should be the same."""
LIGHT = 3e8
"""Speed (m/s) beyond which nothing moves; a velocity above it has run away."""


@dataclass(frozen=True, slots=True)
class VehicleFacts:
    """Properties of a vehicle that its author states.

    Attributes:
        seconds: the longest step that it is made for.
        greatest_speed: the largest component of a velocity against the water at which it is tried (m/s).
        greatest_turn: the largest component of an angular velocity at which it is tried (rad/s).
        density: the density of the water that it is made for (kg/m^3).
        half_steps: largest distance (m, rad, m/s, rad/s) between the ends of two half steps and of one: its error of
            integration.
        settling: time after which a vehicle that is told nothing has come to rest, or drifts up or down (s).
        settled: the largest component of its twist then (m/s, rad/s).
    """

    seconds: float = 0.02
    greatest_speed: float = 1.0
    greatest_turn: float = 0.5
    density: float = 1000.0
    half_steps: float = 1e-6
    settling: float = 60.0
    settled: float = 0.2


VehicleTrial = Trial[VehicleFacts]


@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    """Arguments of a step."""

    pose: Floats
    twist: Floats
    states: Floats
    commands: Floats
    seconds: float
    surroundings: Surroundings

    def arguments(self) -> tuple[object, ...]:
        return self.pose, self.twist, self.states, self.commands, self.seconds, self.surroundings

    def __str__(self) -> str:
        return (
            f"a step of {self.seconds:.4g} s from {numbers(self.pose[:3, 3])} at {numbers(self.twist)}, drives at "
            f"{numbers(self.states)} told {numbers(self.commands)}"
        )


Answer = tuple[Floats, Floats, Floats]
"""Pose, twist, states of drives."""


def drives(trial: VehicleTrial, rng: np.random.Generator) -> Measured:
    """Each drive has a name of its own and a range; it goes towards its command, and never past it."""
    told = trial.call("drives")
    if not isinstance(told, tuple) or not told or not all(isinstance(one, VehicleDrive) for one in told):
        raise LawBroken(f"drives is {told!r}; it must be a tuple of VehicleDrive, one at least")
    names = [drive.name for drive in told]
    if len(set(names)) < len(names) or not all(isinstance(name, str) and name for name in names):
        raise LawBroken(f"drives are called {', '.join(map(str, names))}; each needs a name of its own")
    for drive in told:
        if not isinstance(drive.quantity, DriveQuantity) or not -np.inf < drive.lowest < drive.highest < np.inf:
            raise LawBroken(f"{drive} needs a quantity, and a finite range whose end is above its beginning")
    for _ in range(STEPS):
        step = _random_step(trial, rng)
        after = _made(trial, step)[2]
        low, high = np.minimum(step.states, step.commands), np.maximum(step.states, step.commands)
        slack = SAME * np.maximum(1.0, np.abs(high - low))
        if (after < low - slack).any() or (after > high + slack).any():
            raise LawBroken(f"{step}: they are then at {numbers(after)}; each must be between state and command")
        if not (np.abs(after - step.states) > 0.0).any():
            raise LawBroken(f"{step}: no drive moved towards its command")
    return Measured(STEPS)


def half_steps(trial: VehicleTrial, rng: np.random.Generator) -> Measured:
    """Two steps of half the time come to the same as one, but for the error that the author names."""
    worst = np.zeros(4)
    for _ in range(STEPS):
        step = _random_step(trial, rng)
        once = _made(trial, step)
        half = replace(step, seconds=step.seconds / 2)
        twice = _made(trial, _then(half, _made(trial, half)))
        off = _apart(once, twice)
        if max(off) > trial.facts.half_steps:
            raise LawBroken(
                f"{step}: two of half the time end {off[0]:.3g} m and {off[1]:.3g} rad from where it does, its twist "
                f"{off[2]:.3g} and its drives {off[3]:.3g} apart; it may be {trial.facts.half_steps:.3g} (`half_steps` "
                "of VehicleFacts)"
            )
        worst = np.maximum(worst, off)
    return Measured(STEPS, {"m": worst[0], "rad": worst[1], "of twist": worst[2], "of drives": worst[3]})


def motion(trial: VehicleTrial, rng: np.random.Generator) -> Measured:
    """Some of what the drives can be told changes the twist."""
    most = 0.0
    for _ in range(STEPS):
        step = _random_step(trial, rng)
        rest = np.clip(np.zeros_like(step.commands), *_ranges(trial))
        told = _made(trial, step)[1]
        most = max(most, float(np.abs(told - _made(trial, replace(step, commands=rest, states=rest))[1]).max()))
    if most < 1e-6:
        raise LawBroken(f"none of {STEPS} random commands changed the twist by more than {most:.3g} m/s or rad/s")
    return Measured(STEPS, {"m/s or rad/s a step": most})


def anywhere(trial: VehicleTrial, rng: np.random.Generator) -> Measured:
    """A vehicle that is shifted, or turned about the vertical, moves alike when current and surface are too."""
    worst = np.zeros(4)
    for _ in range(STEPS):
        step = _random_step(trial, rng)
        shift = np.eye(4)
        shift[:3, :3] = rotation_matrix(np.array([0.0, 0.0, rng.uniform(-np.pi, np.pi)]))
        shift[:3, 3] = rng.uniform(-10.0, 10.0, 3)
        water = step.surroundings
        turned = tuple((shift[:3, :3] @ np.array(water.current)).tolist())
        there = replace(
            step,
            pose=shift @ step.pose,
            surroundings=replace(water, current=turned, surface=water.surface + shift[2, 3]),
        )
        pose, twist, states = _made(trial, step)
        found = _made(trial, there)
        off = _apart((shift @ pose, twist, states), found)
        if max(off) > SAME * 10.0:
            raise LawBroken(
                f"{step} ends at {numbers((shift @ pose)[:3, 3])} if it is shifted and turned afterwards, but at "
                f"{numbers(found[0][:3, 3])} if before: {off[0]:.3g} m, {off[1]:.3g} rad, {off[2]:.3g} of twist apart"
            )
        worst = np.maximum(worst, off)
    return Measured(STEPS, {"m": worst[0], "rad": worst[1], "of twist": worst[2]})


def current(trial: VehicleTrial, rng: np.random.Generator) -> Measured:
    """In water that flows evenly, a vehicle that moves with it moves as in still water."""
    worst = np.zeros(4)
    for _ in range(STEPS):
        flowing = _random_step(trial, rng)
        flow = np.array(flowing.surroundings.current)
        # The surface moves too: the same depth is what counts.
        flow[2] = 0.0
        water = replace(flowing.surroundings, current=tuple(flow.tolist()))
        flowing = replace(flowing, surroundings=water)
        along = np.append(flowing.pose[:3, :3].T @ flow, np.zeros(3))
        still = replace(flowing, twist=flowing.twist - along, surroundings=replace(water, current=(0.0, 0.0, 0.0)))
        carried = _made(trial, still)
        pose = carried[0].copy()
        pose[:3, 3] += flow * flowing.seconds
        twist = carried[1] + np.append(pose[:3, :3].T @ flow, np.zeros(3))
        found = _made(trial, flowing)
        off = _apart((pose, twist, carried[2]), found)
        if max(off) > SAME * 10.0:
            raise LawBroken(
                f"{flowing} in a current of {numbers(flow)} m/s ends at {numbers(found[0][:3, 3])} with "
                f"{numbers(found[1])}; carried along it would be at {numbers(pose[:3, 3])} with {numbers(twist)}"
            )
        worst = np.maximum(worst, off)
    return Measured(STEPS, {"m": worst[0], "rad": worst[1], "of twist": worst[2]})


def settling(trial: VehicleTrial, rng: np.random.Generator) -> Measured:
    """Told nothing in still water, it comes to rest, or drifts up or down."""
    facts = trial.facts
    step = _random_step(trial, rng)
    rest = np.clip(np.zeros_like(step.commands), *_ranges(trial))
    water = replace(step.surroundings, current=(0.0, 0.0, 0.0), surface=1e4)
    step = replace(step, pose=_upright(step.pose), commands=rest, seconds=facts.seconds, surroundings=water)
    for _ in range(int(np.ceil(facts.settling / facts.seconds))):
        step = _then(step, _made(trial, step))
    if np.abs(step.twist).max() > facts.settled:
        raise LawBroken(
            f"told nothing for {facts.settling:g} s, it moves by {numbers(step.twist)}; it may be {facts.settled:g} "
            "(`settling`, `settled` of VehicleFacts)"
        )
    return Measured(1, {"m/s or rad/s": float(np.abs(step.twist).max())})


def long_way(trial: VehicleTrial, rng: np.random.Generator) -> Measured:
    """Poses stay rigid and numbers finite over many steps, one after the other."""
    step = _random_step(trial, rng)
    worst = 0.0
    for i in range(LONG_WAY):
        if i % 100 == 0:
            fresh = _random_step(trial, rng)
            step = replace(step, commands=fresh.commands, seconds=fresh.seconds, surroundings=fresh.surroundings)
        step = _then(step, _made(trial, step))
        worst = max(worst, float(np.abs(step.pose[:3, :3].T @ step.pose[:3, :3] - np.eye(3)).max()))
    return Measured(LONG_WAY, {"of R^T R": worst})


def refusals(trial: VehicleTrial, rng: np.random.Generator) -> Measured:
    """Arguments that make no sense are refused by an ArgumentError, and the next step is answered rightly."""
    step = _random_step(trial, rng)
    before = _made(trial, step)
    tried = must_refuse(trial, _nonsense(step, trial.call("drives")))
    if _bits(_made(trial, step)) != _bits(before):
        raise LawBroken("after refusals the same step ends elsewhere")
    return Measured(tried)


def determinism(trial: VehicleTrial, rng: np.random.Generator) -> Measured:
    """The same step gives the same bits: twice in a row, after another one, and in another process."""
    with trial.twin() as twin:
        for _ in range(5):
            step, other = _random_step(trial, rng), _random_step(trial, rng)
            first = _bits(_made(trial, step))
            _made(trial, other)
            for where, one in (("", trial), (" in another process", twin)):
                if _bits(_made(one, step)) != first:
                    raise LawBroken(f"the same step ends elsewhere{where}; it may depend on its arguments alone")
    return Measured(5)


def cost(trial: VehicleTrial, rng: np.random.Generator) -> Measured:
    """Tell nothing but microseconds a step."""
    step = replace(_random_step(trial, rng), seconds=trial.facts.seconds)
    seconds = trial.seconds(200, "step", *step.arguments())
    return Measured(len(seconds), {"microseconds": 1e6 * float(np.median(seconds))})


LAWS: Mapping[str, Law] = MappingProxyType(
    {
        law.__name__: law
        for law in (
            drives,
            half_steps,
            motion,
            anywhere,
            current,
            settling,
            long_way,
            refusals,
            determinism,
            cost,
        )
    }
)
"""Laws of all vehicle dynamics, by name, in the order in which they are tried."""


class VehicleDynamicsContract(ComponentContract):
    """Contract of all vehicle dynamics; subclass it in a test file.

    class TestMyVehicle(VehicleDynamicsContract):
        component = "my_package/my_vehicle"
        facts = VehicleFacts(greatest_speed=2.0)
    """

    kind = ComponentKind.VEHICLE_DYNAMICS
    laws = LAWS
    facts: ClassVar[VehicleFacts] = VehicleFacts()


def _made(trial: VehicleTrial, step: _Step) -> Answer:
    """Return pose, twist and drives after a step, of the right shapes, finite and rigid."""
    answer = trial.call("step", *step.arguments())
    if not isinstance(answer, tuple) or len(answer) != 3:
        raise LawBroken(f"step returned {type(answer).__name__}; it must be a tuple of pose, twist and drives")
    pose = checked(answer[0], "the pose", np.float64, (4, 4))
    twist = checked(answer[1], "the twist", np.float64, (6,))
    states = checked(answer[2], "the drives", np.float64, step.states.shape)
    if not all(np.isfinite(one).all() for one in (pose, twist, states)) or np.abs(twist).max() > LIGHT:
        raise LawBroken(f"{step} ends at {numbers(pose[:3, 3])} with {numbers(twist)} and {numbers(states)}")
    off = float(np.abs(pose[:3, :3].T @ pose[:3, :3] - np.eye(3)).max())
    if off > RIGID or np.linalg.det(pose[:3, :3]) < 0.0 or pose[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        raise LawBroken(f"{step} ends at a pose that is not rigid: R^T R is off by {off:.3g}, row 4 {numbers(pose[3])}")
    return pose, twist, states


def _then(step: _Step, after: Answer) -> _Step:
    """Return the same step from where another has led."""
    return replace(step, pose=after[0], twist=after[1], states=after[2])


def _ranges(trial: VehicleTrial) -> tuple[Floats, Floats]:
    told = trial.call("drives")
    return np.array([drive.lowest for drive in told]), np.array([drive.highest for drive in told])


def _random_step(trial: VehicleTrial, rng: np.random.Generator) -> _Step:
    """Return a step somewhere in deep water, the vehicle tilted by up to half a radian."""
    facts = trial.facts
    lowest, highest = _ranges(trial)
    pose = _upright(np.eye(4), rng.uniform(-np.pi, np.pi))
    pose[:3, :3] = rotation_matrix(rng.uniform(-0.3, 0.3, 3)) @ pose[:3, :3]
    pose[:3, 3] = rng.uniform(-10.0, 10.0, 3)
    flow = rng.uniform(-0.5, 0.5, 3) * facts.greatest_speed
    through = np.append(
        rng.uniform(-1.0, 1.0, 3) * facts.greatest_speed, rng.uniform(-1.0, 1.0, 3) * facts.greatest_turn
    )
    return _Step(
        pose,
        through + np.append(pose[:3, :3].T @ flow, np.zeros(3)),
        rng.uniform(lowest, highest),
        rng.uniform(lowest, highest),
        float(facts.seconds * rng.uniform(0.1, 1.0)),
        Surroundings(tuple(flow.tolist()), facts.density, 100.0),
    )


def _upright(pose: Floats, heading: float | None = None) -> Floats:
    """Return a pose at the same place whose z is up."""
    angle = float(np.arctan2(pose[1, 0], pose[0, 0])) if heading is None else heading
    result = np.eye(4)
    result[:3, :3] = rotation_matrix(np.array([0.0, 0.0, angle]))
    result[:3, 3] = pose[:3, 3]
    return result


def _apart(a: Answer, b: Answer) -> tuple[float, float, float, float]:
    """Return how far two answers are apart: m, rad, of twists, of drives as parts of their speed."""
    far, turned = pose_distance(a[0], b[0])
    drives_apart = np.abs(a[2] - b[2]) / np.maximum(1.0, np.abs(a[2]))
    return far, turned, float(np.abs(a[1] - b[1]).max()), float(drives_apart.max())


def _nonsense(step: _Step, told: tuple[VehicleDrive, ...]) -> Iterator[tuple[str, tuple[object, ...], str]]:
    """Yield calls that must be refused."""

    def wrong(what: str, **changed: object) -> tuple[str, tuple[object, ...], str]:
        return "step", replace(step, **changed).arguments(), what  # pyright: ignore[reportArgumentType]

    water = step.surroundings
    for what, value in (("NaN", np.nan), ("infinity", np.inf)):
        for name in ("pose", "twist", "states", "commands"):
            array = getattr(step, name).copy()
            array[(0, 3) if name == "pose" else -1] = value
            yield wrong(f"{name} with {what}", **{name: array})
        yield wrong(f"a time of {what}", seconds=value)
        yield wrong(f"a current with {what}", surroundings=replace(water, current=(0.0, value, 0.0)))
        yield wrong(f"a density of {what}", surroundings=replace(water, density=value))
    for name in ("twist", "states", "commands"):
        yield wrong(f"too many {name}", **{name: np.append(getattr(step, name), 0.0)})
        yield wrong(f"too few {name}", **{name: getattr(step, name)[:-1]})
    beyond = step.commands.copy()
    beyond[0] = told[0].highest + 0.01 * (told[0].highest - told[0].lowest)
    yield wrong("a command beyond its range", commands=beyond)
    yield wrong("a pose of shape (3, 4)", pose=step.pose[:3])
    yield wrong("a pose twice as large", pose=step.pose @ np.diag([2.0, 2.0, 2.0, 1.0]))
    yield wrong("a reflected pose", pose=step.pose @ np.diag([1.0, 1.0, -1.0, 1.0]))
    for seconds in (0.0, -step.seconds):
        yield wrong(f"a time of {seconds:g} s", seconds=seconds)
    yield wrong("a density of 0", surroundings=replace(water, density=0.0))
    yield wrong("a gravity below 0", surroundings=replace(water, gravity=-1.0))


def _bits(answer: Answer) -> bytes:
    return b"".join(array.tobytes() for array in answer)
