"""The contract suite for mobile kinematics: steps that add up, rigid poses, crafts that move alike anywhere."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from virtualrobot_sdk.answers import pose_distance
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.component_contract import ComponentContract
from virtualrobot_sdk.testing.laws import LawBroken, Measured
from virtualrobot_sdk.testing.trial import Law, Trial, checked, must_refuse, numbers

STEPS = 40
"""Number of random steps that most laws try."""
LONG_WAY = 1500
"""Number of steps made one after the other to see whether the pose stays rigid."""
RIGID = 1e-9
"""Largest error of the rotation of a pose from orthonormal, at any time (largest entry of R^T R - I)."""
SHORT = 1e-5
"""Time (s) of a step in which twists hardly change."""
NEAR = 1e-3
"""Largest difference of twists that should be the same, of the larger of 1 and the twist (m/s, rad/s)."""
MOST_STEERING = 25
"""Number of steps in which a steering angle must have come to where a twist needs it."""
SAME = 1e-9
"""Largest difference of poses, and of states of drives, that should be the same (m, rad)."""


@dataclass(frozen=True, slots=True)
class CraftFacts:
    """Properties of a craft that its author states.

    Attributes:
        seconds: the longest step that it is made for.
        greatest_command: the largest command of a drive, to both sides (rad/s, m/s).
        greatest_state: the largest position of a drive, to both sides (rad, m), such as of a steering angle.
        half_steps: largest distance (m, rad) between the ends of two half steps and of one: its error of integration.
    """

    seconds: float = 0.1
    greatest_command: float = 5.0
    greatest_state: float = 1.0
    half_steps: float = 1e-9


CraftTrial = Trial[CraftFacts]


def drives(trial: CraftTrial, rng: np.random.Generator) -> Measured:
    """Each drive has a name of its own; it moves the way that it is told, and no farther than that."""
    names = trial.call("drive_names")
    if not isinstance(names, tuple) or not names or not all(isinstance(name, str) and name for name in names):
        raise LawBroken(f"drive_names is {names!r}; it must be a tuple of names, one at least")
    if len(set(names)) < len(names):
        raise LawBroken(f"drive_names are {', '.join(names)}; each drive needs a name of its own")
    for _ in range(STEPS):
        pose, states, commands, seconds = _random_step(trial, rng)
        moved = _step(trial, pose, states, commands, seconds)[1] - states
        told = commands * seconds
        if (moved * np.sign(told) < -SAME).any() or (np.abs(moved) > np.abs(told) + SAME).any():
            raise LawBroken(
                f"drives told {numbers(commands)} for {seconds:.4g} s moved by {numbers(moved)}; each must go the same "
                f"way, by {numbers(told)} at most"
            )
    return Measured(STEPS)


def half_steps(trial: CraftTrial, rng: np.random.Generator) -> Measured:
    """Two steps of half the time come to the same as one, but for the error that the author names."""
    worst = np.zeros(3)
    for _ in range(STEPS):
        pose, states, commands, seconds = _random_step(trial, rng)
        once = _step(trial, pose, states, commands, seconds)
        half = _step(trial, pose, states, commands, seconds / 2)
        twice = _step(trial, *half, commands, seconds / 2)
        off = *pose_distance(once[0], twice[0]), float(np.abs(once[1] - twice[1]).max())
        if max(off) > trial.facts.half_steps:
            raise LawBroken(
                f"drives at {numbers(states)} told {numbers(commands)}: two steps of {seconds / 2:.4g} s end "
                f"{off[0]:.3g} m and {off[1]:.3g} rad from where one of {seconds:.4g} s does, the drives {off[2]:.3g} "
                f"apart; it may be {trial.facts.half_steps:.3g} (`half_steps` of CraftFacts)"
            )
        worst = np.maximum(worst, off)
    return Measured(STEPS, {"m": worst[0], "rad": worst[1], "of drives": worst[2]})


def rest(trial: CraftTrial, rng: np.random.Generator) -> Measured:
    """A craft whose drives are told 0 stays where it is, and so do they."""
    for _ in range(STEPS):
        pose, states, commands, seconds = _random_step(trial, rng)
        after, drives_after = _step(trial, pose, states, np.zeros_like(commands), seconds)
        off = *pose_distance(pose, after), float(np.abs(drives_after - states).max())
        if max(off) > SAME:
            raise LawBroken(
                f"told 0 for {seconds:.4g} s with drives at {numbers(states)}, it moved by {off[0]:.3g} m and "
                f"{off[1]:.3g} rad, its drives by {off[2]:.3g}"
            )
    return Measured(STEPS)


def motion(trial: CraftTrial, rng: np.random.Generator) -> Measured:
    """Some of what the drives can be told moves the craft."""
    farthest = 0.0
    for _ in range(STEPS):
        pose, states, commands, seconds = _random_step(trial, rng)
        farthest = max(farthest, *pose_distance(pose, _step(trial, pose, states, commands, seconds)[0]))
    if farthest < 1e-6:
        raise LawBroken(f"none of {STEPS} random commands moved it by more than {farthest:.3g} m or rad")
    return Measured(STEPS, {"m or rad a step": farthest})


def twists(trial: CraftTrial, rng: np.random.Generator) -> Measured:
    """The twist of the base is what a short step makes of it."""
    worst = 0.0
    for _ in range(STEPS):
        pose, states, commands, _ = _random_step(trial, rng)
        twist = _numbers(trial, "base_twist", (3,), states, commands)
        moved = np.linalg.solve(pose, _step(trial, pose, states, commands, SHORT)[0])
        seen = np.array([moved[0, 3], moved[1, 3], np.arctan2(moved[1, 0], moved[0, 0])]) / SHORT
        off = float(np.abs(seen - twist).max())
        if off > NEAR * max(1.0, float(np.abs(twist).max())):
            raise LawBroken(
                f"drives at {numbers(states)} told {numbers(commands)}: base_twist is {numbers(twist)}, and in "
                f"{SHORT:g} s it moves at {numbers(seen)} (m/s, m/s, rad/s)"
            )
        worst = max(worst, off)
    return Measured(STEPS, {"m/s or rad/s": worst})


def commands(trial: CraftTrial, rng: np.random.Generator) -> Measured:
    """Commands for a twist lead to it, steered as often as it takes; or that twist is refused."""
    kept, seconds = 0, trial.facts.seconds
    for tried in range(STEPS):
        pose, states, told, _ = _random_step(trial, rng)
        own = _numbers(trial, "base_twist", (3,), states, told)
        twist = own if tried % 2 else rng.uniform(-1.0, 1.0, 3) * rng.integers(0, 2, 3) * max(1e-3, np.abs(own).max())
        try:
            for _ in range(MOST_STEERING):
                told = _numbers(trial, "drive_commands", states.shape, twist, states, seconds)
                states = _step(trial, pose, states, told, seconds)[1]
            told = _numbers(trial, "drive_commands", states.shape, twist, states, seconds)
        except ArgumentError:
            continue
        has = _numbers(trial, "base_twist", (3,), states, told)
        if np.abs(has - twist).max() > NEAR * max(1.0, float(np.abs(twist).max())):
            raise LawBroken(
                f"told to move at {numbers(twist)} (m/s, m/s, rad/s), it moves at {numbers(has)}; what it cannot do it "
                "must refuse by ArgumentError"
            )
        kept += 1
    if kept < STEPS // 4:
        raise LawBroken(f"of {STEPS} twists, half of which it had, it takes {kept}")
    return Measured(kept)


def passives(trial: CraftTrial, rng: np.random.Generator) -> Measured:
    """Passive wheels have names of their own, turn alike in two half steps and in one, and rest with the craft."""
    names = trial.call("passive_names")
    if not isinstance(names, tuple) or not all(isinstance(name, str) and name for name in names):
        raise LawBroken(f"passive_names is {names!r}; it must be a tuple of names, which may be empty")
    taken = (*trial.call("drive_names"), *names)
    if len(set(taken)) < len(taken):
        raise LawBroken(f"drives and passive wheels are called {', '.join(taken)}; each needs a name of its own")
    worst, shape = 0.0, (len(names),)
    for _ in range(STEPS):
        pose, states, told, seconds = _random_step(trial, rng)
        at = _numbers(trial, "passive_states", shape, rng.uniform(-3.0, 3.0, len(names)), states, told, seconds)
        once = _numbers(trial, "passive_states", shape, at, states, told, seconds)
        half = _numbers(trial, "passive_states", shape, at, states, told, seconds / 2)
        there = _step(trial, pose, states, told, seconds / 2)[1]
        twice = _numbers(trial, "passive_states", shape, half, there, told, seconds / 2)
        end = _step(trial, pose, states, told, seconds)[1]
        rests = _numbers(trial, "passive_states", shape, once, end, np.zeros_like(told), seconds)
        off = float(np.abs(np.concatenate([once - twice, rests - once])).max(initial=0.0))
        if off > max(SAME, trial.facts.half_steps):
            raise LawBroken(
                f"drives at {numbers(states)} told {numbers(told)} turn passive wheels from {numbers(at)} to "
                f"{numbers(once)} in {seconds:.4g} s, to {numbers(twice)} in two halves of that, and at rest then to "
                f"{numbers(rests)}"
            )
        worst = max(worst, off)
    return Measured(STEPS, {"rad": worst})


def anywhere(trial: CraftTrial, rng: np.random.Generator) -> Measured:
    """A craft that is shifted or turned about the vertical moves alike."""
    worst = np.zeros(2)
    for _ in range(STEPS):
        pose, states, commands, seconds = _random_step(trial, rng)
        shift = _flat_pose(rng)
        other = shift @ pose
        here, there = (_step(trial, start, states, commands, seconds) for start in (pose, other))
        off = pose_distance(shift @ here[0], there[0])
        apart = float(np.abs(here[1] - there[1]).max())
        if max(*off, apart) > SAME * max(1.0, float(np.abs(other[:3, 3]).max())):
            raise LawBroken(
                f"with drives at {numbers(states)} told {numbers(commands)} for {seconds:.4g} s, it moves from "
                f"{_place(pose)} to {_place(here[0])}, but from {_place(other)} to {_place(there[0])}; it should be "
                f"{_place(shift @ here[0])}"
            )
        worst = np.maximum(worst, off)
    return Measured(STEPS, {"m": worst[0], "rad": worst[1]})


def long_way(trial: CraftTrial, rng: np.random.Generator) -> Measured:
    """Poses stay rigid and numbers finite over many steps, one after the other."""
    pose, states, commands, seconds = _random_step(trial, rng)
    worst = 0.0
    for i in range(LONG_WAY):
        if i % 100 == 0:
            _, states, commands, seconds = _random_step(trial, rng)
        pose, after = _step(trial, pose, states, commands, seconds)
        # A steering angle would leave its range; wheels turn as far as they like.
        states = np.clip(after, -trial.facts.greatest_state, trial.facts.greatest_state)
        worst = max(worst, float(np.abs(pose[:3, :3].T @ pose[:3, :3] - np.eye(3)).max()))
    return Measured(LONG_WAY, {"of R^T R": worst})


def refusals(trial: CraftTrial, rng: np.random.Generator) -> Measured:
    """Arguments that make no sense are refused by an ArgumentError, and the next step is answered rightly."""
    step = _random_step(trial, rng)
    before = _step(trial, *step)
    tried = must_refuse(trial, _nonsense(*step))
    after = _step(trial, *step)
    if _bits(after) != _bits(before):
        raise LawBroken("after refusals the same step ends elsewhere")
    return Measured(tried)


def determinism(trial: CraftTrial, rng: np.random.Generator) -> Measured:
    """The same step gives the same bits: twice in a row, after another one, and in another process."""
    with trial.twin() as twin:
        for _ in range(5):
            step, other = _random_step(trial, rng), _random_step(trial, rng)
            first = _bits(_step(trial, *step))
            _step(trial, *other)
            for where, one in (("", trial), (" in another process", twin)):
                if _bits(_step(one, *step)) != first:
                    raise LawBroken(f"the same step ends elsewhere{where}; it may depend on its arguments alone")
    return Measured(5)


LAWS: Mapping[str, Law] = MappingProxyType(
    {
        law.__name__: law
        for law in (
            *(drives, half_steps, rest, motion, twists, commands, passives, anywhere),
            *(long_way, refusals, determinism),
        )
    }
)
"""Laws of all mobile kinematics, by name, in the order in which they are tried."""


class MobileKinematicsContract(ComponentContract):
    """Contract of all mobile kinematics; subclass it in a test file.

    class TestMyCraft(MobileKinematicsContract):
        component = "my_package/my_craft"
        facts = CraftFacts(greatest_command=10.0)
    """

    kind = ComponentKind.MOBILE_KINEMATICS
    laws = LAWS
    facts: ClassVar[CraftFacts] = CraftFacts()


def _step(trial: CraftTrial, pose: Floats, states: Floats, commands: Floats, seconds: float) -> tuple[Floats, Floats]:
    """Return where base and drives are, of the right shapes, finite and rigid."""
    answer = trial.call("step", pose, states, commands, seconds)
    if not isinstance(answer, tuple) or len(answer) != 2:
        raise LawBroken(f"step returned {type(answer).__name__}; it must be a tuple of pose and drives")
    after = checked(answer[0], "the pose", np.float64, (4, 4))
    drives_after = checked(answer[1], "the drives", np.float64, states.shape)
    said = f"a step of {seconds:.4g} s with drives at {numbers(states)} told {numbers(commands)}"
    if not np.isfinite(after).all() or not np.isfinite(drives_after).all():
        raise LawBroken(f"{said} ends at {numbers(after[:3, 3])} and {numbers(drives_after)}; all must be finite")
    off = float(np.abs(after[:3, :3].T @ after[:3, :3] - np.eye(3)).max())
    if off > RIGID or np.linalg.det(after[:3, :3]) < 0.0 or after[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        raise LawBroken(
            f"{said} ends at a pose that is not rigid: R^T R is off by {off:.3g}, row 4 {numbers(after[3])}"
        )
    return after, drives_after


def _numbers(trial: CraftTrial, method: str, shape: tuple[int, ...], *arguments: object) -> Floats:
    """Return finite numbers of a shape that a call answers."""
    found = checked(trial.call(method, *arguments), method, np.float64, shape)
    if not np.isfinite(found).all():
        raise LawBroken(f"{method} returned {numbers(found)}; all must be finite")
    return found


def _random_step(trial: CraftTrial, rng: np.random.Generator) -> tuple[Floats, Floats, Floats, float]:
    """Return a pose on the floor, drives, commands and a time."""
    facts, count = trial.facts, len(trial.call("drive_names"))
    states = rng.uniform(-facts.greatest_state, facts.greatest_state, count)
    commands = rng.uniform(-facts.greatest_command, facts.greatest_command, count)
    # Drives that are told the same are a case of their own: a craft that goes straight.
    if rng.random() < 0.25:
        commands[:] = commands[0]
    return _flat_pose(rng), states, commands, float(facts.seconds * rng.uniform(0.1, 1.0))


def _flat_pose(rng: np.random.Generator) -> Floats:
    """Return a pose within 10 m, turned about the vertical."""
    pose, angle = np.eye(4), rng.uniform(-np.pi, np.pi)
    pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    pose[:3, 3] = rng.uniform(-10.0, 10.0, 3)
    return pose


def _nonsense(
    pose: Floats, states: Floats, commands: Floats, seconds: float
) -> Iterator[tuple[str, tuple[object, ...], str]]:
    """Yield calls that must be refused."""
    for what, value in (("NaN", np.nan), ("infinity", np.inf)):
        wrong = pose.copy(), states.copy(), commands.copy()
        wrong[0][0, 3] = wrong[1][-1] = wrong[2][-1] = value
        yield "step", (wrong[0], states, commands, seconds), f"a pose with {what}"
        yield "step", (pose, wrong[1], commands, seconds), f"a drive with {what}"
        yield "step", (pose, states, wrong[2], seconds), f"a command with {what}"
        yield "step", (pose, states, commands, value), f"a time of {what}"
    yield "step", (pose, states, np.append(commands, 0.0), seconds), "too many commands"
    yield "step", (pose, states, commands[:-1], seconds), "too few commands"
    yield "step", (pose, np.append(states, 0.0), commands, seconds), "too many drives"
    yield "step", (pose[:3], states, commands, seconds), "a pose of shape (3, 4)"
    yield "step", (pose @ np.diag([2.0, 2.0, 2.0, 1.0]), states, commands, seconds), "a pose twice as large"
    yield "step", (pose @ np.diag([1.0, 1.0, -1.0, 1.0]), states, commands, seconds), "a reflected pose"
    twist = np.array([0.1, 0.0, 0.0])
    yield "base_twist", (states, commands[:-1]), "too few commands"
    yield "drive_commands", (twist[:2], states, seconds), "a twist of two numbers"
    yield "drive_commands", (np.array([np.nan, 0.0, 0.0]), states, seconds), "a twist with NaN"
    for wrong_time in (0.0, -seconds):
        yield "step", (pose, states, commands, wrong_time), f"a time of {wrong_time:g} s"


def _bits(answer: tuple[Floats, Floats]) -> bytes:
    return answer[0].tobytes() + answer[1].tobytes()


def _place(pose: Floats) -> str:
    heading = np.arctan2(pose[1, 0], pose[0, 0])
    return f"{numbers(pose[:3, 3])} heading {heading:.6g}"
