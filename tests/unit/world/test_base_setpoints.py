"""Setpoints of planar and floating bases: where they lead, against pinocchio, and how they brake."""

from __future__ import annotations

import numpy as np
import pinocchio  # pyright: ignore[reportMissingImports]  a path file makes it importable
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.braking import braking
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import CancelMotion, EndSetpoints, SetSetpoint, StartSetpointMotion
from virtualrobot_kernel.world.state import Cancellation, EndCause
from virtualrobot_kernel.world.structure import JointType

from tests.tiers import Draws
from tests.unit.planning.crafts import (
    ACCELERATION,
    AXES,
    FLOATING,
    JERK,
    PLANAR,
    SPEED,
    anywhere,
    craft,
    model_of,
    pinocchio_q,
    pinocchio_v,
    run,
    standing,
)
from tests.unit.world.builders import TICK, after, empty, ticked

KINDS = [PLANAR, FLOATING]
POSITION, VELOCITY = SetpointMode.POSITION, SetpointMode.VELOCITY


def streaming(world: Change, kind: JointType, mode: SetpointMode) -> Change:
    names = tuple(f"base/{axis}" for axis in AXES[kind])
    return after(world, StartSetpointMotion("craft", names, mode, 0.2))


def sent(world: Change, values: np.ndarray) -> Change:
    return ticked(after(world, SetSetpoint(world.state.motions[0].id, tuple(values.tolist()))))


def way(kind: JointType, start: np.ndarray, goal: np.ndarray, share: float) -> np.ndarray:
    """Return the place on the straight way, turned as slerp does."""
    if kind is PLANAR:
        return start + share * (goal - start)
    turn = pinocchio.Quaternion(start[3:]).slerp(share, pinocchio.Quaternion(goal[3:])).coeffs()
    return np.concatenate([start[:3] + share * (goal[:3] - start[:3]), turn])


def apart(kind: JointType, one: np.ndarray, other: np.ndarray) -> float:
    """Return the greatest of the distances of places and the angle between orientations."""
    model = model_of(kind)
    return float(np.abs(pinocchio.difference(model, pinocchio_q(kind, one), pinocchio_q(kind, other))).max())


@pytest.mark.parametrize("kind", KINDS)
def test_a_base_follows_setpoints_and_ends_on_the_last_one(
    kind: JointType, rng: np.random.Generator, draws: Draws
) -> None:
    for _ in range(draws(5)):
        world, goal = standing(kind, rng), anywhere(kind, rng)
        count = len(goal)
        start, before = world.state.q[:count], world.state.v
        seconds = 2.5 * max(apart(kind, start, goal), 1.0) / SPEED
        world, lag, place = streaming(world, kind, POSITION), 0.0, start
        for tick in range(int(seconds / TICK) + 1):
            place = way(kind, start, goal, 10 * (u := tick * TICK / seconds) ** 3 - 15 * u**4 + 6 * u**5)
            world = sent(world, place)
            lag = max(lag, apart(kind, world.state.q[:count], place))
            assert np.abs(world.state.v).max() <= SPEED * (1.0 + 1e-9)
            assert np.abs(world.state.v - before).max() / TICK <= ACCELERATION * (1.0 + 1e-2)
            before = world.state.v
        assert lag < 0.02
        world, q, _ = run(after(world, EndSetpoints(world.state.motions[0].id)))
        assert world.state.ended[-1].phase is Phase.SUCCEEDED
        assert apart(kind, q[-1, :count], place) < 1e-8


def test_a_last_setpoint_far_away_is_reached_though_its_axes_come_at_times_of_their_own(
    rng: np.random.Generator, draws: Draws
) -> None:
    for _ in range(draws(10)):
        world = standing(FLOATING, rng)
        start = world.state.q[:7]
        turn = rng.uniform(-0.028, 0.028, 3)  # what the limit of speed allows within 0.05 s
        goal = pinocchio.integrate(model_of(FLOATING), start, np.concatenate([np.zeros(3), turn]))
        world = sent(streaming(world, FLOATING, POSITION), goal)
        world, q, v = run(after(world, EndSetpoints(world.state.motions[0].id)))
        assert world.state.ended[-1].phase is Phase.SUCCEEDED and not v[-1].any()
        assert apart(FLOATING, q[-1, :7], goal) < 1e-8


@pytest.mark.parametrize("kind", KINDS)
def test_velocities_lead_where_pinocchio_integrates_them_to(kind: JointType, rng: np.random.Generator) -> None:
    world = streaming(standing(kind, rng), kind, VELOCITY)
    model, count = model_of(kind), len(AXES[kind])
    rates = rng.uniform(-0.5, 0.5, count)
    rates[6:] = 0.0
    for _ in range(200):
        world = sent(world, rates)
    assert np.allclose(world.state.v[:-1], rates[: len(world.state.v) - 1], atol=1e-12)
    start = world.state.q[:count]
    for _ in range(100):
        world = sent(world, rates)
    fine = 1000
    here = pinocchio_q(kind, start)
    for _ in range(fine):  # the linear velocity keeps its direction in the joint's frame, whatever the body does
        body = here if kind is FLOATING else np.array([*here[:2], np.arctan2(here[3], here[2])])
        here = pinocchio.integrate(model, here, pinocchio_v(kind, body, world.state.v[:-1]) * (100 * TICK / fine))
    there = pinocchio_q(kind, world.state.q[:count])
    assert np.abs(pinocchio.difference(model, here, there)).max() < 1e-3
    if kind is FLOATING:
        turn = pinocchio.exp3(rates[3:6] * 100 * TICK)
        expected = pinocchio.Quaternion(start[3:]).matrix() @ turn
        assert np.allclose(pinocchio.Quaternion(world.state.q[3:7]).matrix(), expected, atol=1e-12)
    assert np.allclose(world.state.q[: 2 if kind is PLANAR else 3] - start[: 2 if kind is PLANAR else 3],
                       rates[: 2 if kind is PLANAR else 3] * 100 * TICK, atol=1e-12)  # fmt: skip


@pytest.mark.parametrize("mode", [POSITION, VELOCITY])
def test_a_brake_is_foreseen_as_it_happens(mode: SetpointMode, rng: np.random.Generator) -> None:
    world = streaming(standing(FLOATING, rng), FLOATING, mode)
    start, rates = world.state.q[:7], np.array([0.3, -0.5, 0.2, 0.6, -0.4, 0.5, 0.0])
    for tick in range(150):
        turn = pinocchio.integrate(model_of(FLOATING), start, np.concatenate([np.zeros(3), rates[3:6] * tick * TICK]))
        place = np.concatenate([start[:3] + rates[:3] * tick * TICK, turn[3:]])
        world = sent(world, rates if mode is VELOCITY else place)
    foreseen = braking(world.structure, world.state, TICK, world_poses)
    world = after(world, CancelMotion(world.state.motions[0].id, Cancellation(EndCause.CALL, "")))
    _, q, v = run(world)
    count = min(len(q), len(foreseen.positions))
    assert abs(len(q) - len(foreseen.positions)) <= 1
    assert np.allclose(q[:count], foreseen.positions[:count], atol=1e-12)
    assert np.abs(np.diff(v, axis=0)).max() / TICK <= ACCELERATION * (1.0 + 1e-2)
    jumps = np.abs(np.diff(v, n=2, axis=0)).max() / TICK**2
    assert jumps <= JERK * (1.0 + 1e-2)


def test_without_setpoints_a_base_stops(rng: np.random.Generator) -> None:
    world = streaming(standing(PLANAR, rng), PLANAR, VELOCITY)
    for _ in range(100):
        world = sent(world, np.array([0.5, 0.0, 0.2]))
    world, _, v = run(world)
    end = world.state.ended[-1]
    assert end.phase is Phase.ABORTED and end.cancellation and end.cancellation.cause is EndCause.SETPOINT_TIMEOUT
    assert not v[-1].any()


@pytest.mark.parametrize(
    ("mode", "values", "words"),
    [
        (POSITION, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.01], "joint 'base' has the quaternion .* of length 1.01"),
        (POSITION, [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0], "joint 'base/qz' would go from 0 to 3.14159"),
        (VELOCITY, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1], "the velocity of 'base/qw' is 0, not 0.1"),
        (VELOCITY, [0.0, 0.0, 0.0, 0.0, 1.1, 0.0, 0.0], "joint 'base/qy' would move at 1.1, its limit is 1"),
    ],
)
def test_setpoints_that_cannot_be_are_refused(mode: SetpointMode, values: list[float], words: str) -> None:
    world = streaming(after(empty(), craft(FLOATING)), FLOATING, mode)
    with pytest.raises(KernelError, match=words):
        sent(world, np.array(values))


def test_a_part_of_a_quaternion_follows_nothing() -> None:
    with pytest.raises(KernelError, match="turns by a quaternion; name all of"):
        after(after(empty(), craft(FLOATING)), StartSetpointMotion("craft", ("base/qx", "base/x"), POSITION, 0.2))
