"""Motions that follow setpoints: limits at ticks and at ten points between, tracking, watchdog, refusals, steering."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, LimitError, Reason
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.online import Bounds, Coupling, JointState, follow_positions, follow_velocities
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.motion.setpoint_motion import (
    AHEAD_SECONDS,
    MOST_DRIFT,
    SetpointMode,
    SetpointMotion,
    start,
)

from .motions import TICK, random_limits

POSITION, VELOCITY = SetpointMode.POSITION, SetpointMode.VELOCITY
SAMPLES = [TICK * place / 11 for place in range(1, 12)]
"""Ten points between two ticks, and the tick."""


def one(velocity: float = 2.0, acceleration: float = 10.0, jerk: float = 100.0, reach: float = 3.0) -> JointLimits:
    """Return the limits of one joint."""
    return JointLimits(("j",), *(np.array([value]) for value in (-reach, reach, velocity, acceleration, jerk)))


def samples(before: SetpointMotion, override: float = 1.0) -> Iterator[JointState]:
    """Yield where the joints are between two ticks, and at the second one."""
    heard = before.heard()
    way, _ = heard.way(TICK, override)
    yield from (way.at(time) for time in SAMPLES)


def check_limits(before: SetpointMotion, limits: JointLimits, override: float = 1.0) -> None:
    """Check that the tick after `before` keeps all limits, also between: of positions exactly."""
    q, v, a = map(np.array, before.now)
    for state in samples(before, override):
        q1, v1, a1 = map(np.array, state)
        assert np.all((q1 >= limits.lower) & (q1 <= limits.upper))
        assert np.all(np.abs(v1) <= limits.velocity * (1.0 + 1e-9))
        assert np.all(np.abs(a1) <= limits.acceleration * (1.0 + 1e-9))
        dt = TICK / 11
        assert np.all(np.abs(a1 - a) <= limits.jerk * dt * (1.0 + 1e-6) + 1e-9)
        # What changes is what the derivatives say: no jump of position or velocity.
        assert np.all(np.abs(v1 - v - (a + a1) / 2 * dt) <= limits.jerk * dt**2 / 4 + 1e-9)
        assert np.all(np.abs(q1 - q - (v + v1) / 2 * dt) <= limits.acceleration * dt**2 / 4 + 1e-9)
        q, v, a = q1, v1, a1


def near(following: SetpointMotion, rng: np.random.Generator) -> np.ndarray:
    """Return a setpoint that is not refused: any velocity, or a position as far as it may be."""
    limits = following.limits
    if following.mode is VELOCITY:
        return rng.uniform(-1.0, 1.0, len(limits.names)) * limits.velocity * rng.choice([0.0, 0.01, 1.0])
    reach = (following.age + np.array(following.ahead)) * limits.velocity
    wanted = following.counted + rng.uniform(-1.0, 1.0, len(reach)) * reach * rng.choice([0.0, 0.1, 1.0])
    return np.clip(wanted, limits.lower, limits.upper)


@pytest.mark.long
@pytest.mark.parametrize("mode", SetpointMode)
def test_random_setpoints_keep_every_limit_also_between_ticks(mode: SetpointMode, rng: np.random.Generator) -> None:
    for _ in range(4):
        limits = random_limits(rng, 3)
        following = start(mode, limits, rng.uniform(limits.lower, limits.upper), timeout=10.0)
        override, pace = 1.0, rng.choice([0.05, 0.3, 1.0])
        for _ in range(500):
            if rng.random() < pace:
                following = following.set(near(following, rng).tolist())
            if rng.random() < 0.01:
                override = float(rng.choice([1.0, 0.3, 1e-2, 1e-9]))
            if rng.random() < 0.01:
                following = following.resume() if following.phase is not Phase.RUNNING else following.pause()
            check_limits(following, limits, override)
            following = following.advance(TICK, override)
            assert not following.ended


@pytest.mark.long
def test_a_joint_stops_at_its_limit_by_itself_and_leaves_it_again(rng: np.random.Generator) -> None:
    limits = random_limits(rng, 4)
    wanted = limits.velocity * rng.choice([-1.0, 1.0], 4) * rng.uniform(0.2, 1.0, 4)
    following = start(VELOCITY, limits, rng.uniform(-1.0, 1.0, 4), timeout=1e9).set(wanted.tolist())
    for _ in range(int(30.0 / TICK)):
        check_limits(following, limits)
        following = following.advance(TICK, 1.0)
        if not any(following.now.v) and not any(following.now.a):
            break
    assert np.array_equal(following.now.q, np.where(wanted > 0.0, limits.upper, limits.lower))
    following = following.set((-wanted).tolist())
    for _ in range(100):
        check_limits(following, limits)
        following = following.advance(TICK, 1.0)
    assert np.all(np.sign(following.now.v) == -np.sign(wanted))


@pytest.mark.parametrize("mode", SetpointMode)
def test_joints_of_one_actuator_keep_its_limits_together(mode: SetpointMode, rng: np.random.Generator) -> None:
    """As the rods of a palletizer do: the sum of two joints has limits of its own."""
    limits = random_limits(rng, 3)
    ratio = rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 2.0)
    rods = Coupling("rods", ((0, 1.0), (2, ratio)), -0.5, 0.6)
    bound = np.array([1.0, 0.0, ratio])
    following = start(mode, limits, np.zeros(3), 1e9, [rods])
    for _ in range(500):
        wanted = near(following, rng)
        if rng.random() < 0.05 or mode is POSITION:
            with contextlib.suppress(LimitError):
                following = following.set(wanted.tolist())
        check_limits(following, limits)
        for state in samples(following):
            assert -0.5 <= bound @ state.q <= 0.6
        following = following.advance(TICK, 1.0)
    if mode is VELOCITY:  # they get to both limits, and away from the first one
        for direction in (1.0, -1.0):
            following = following.set((direction * limits.velocity * np.sign(bound)).tolist())
            for _ in range(600):
                following = following.advance(TICK, 1.0)
            assert bound @ following.now.q == pytest.approx(0.6 if direction > 0.0 else -0.5, abs=2e-3)
    else:
        with pytest.raises(LimitError, match="the actuator 'rods' would be at"):
            following.set([1.0, 0.0, float(np.sign(ratio))])


def test_joints_go_along_the_limit_of_their_actuator() -> None:
    """One leads it back while the other waits for room; what is reached in the end is the setpoint."""
    limits = JointLimits(("a", "b"), *(np.full(2, value) for value in (-3.0, 3.0, 2.0, 10.0, 100.0)))
    sum_of_both = Coupling("rods", ((0, 1.0), (1, 1.0)), -1.0, 1.0)
    following = start(POSITION, limits, [0.7, 0.3], 1.0, [sum_of_both])
    following = following.set([0.65, 0.35]).close()
    for _ in range(200):
        check_limits(following, limits)
        assert all(sum(state.q) <= 1.0 for state in samples(following))
        following = following.advance(TICK, 1.0)
    assert following.phase is Phase.SUCCEEDED
    assert following.now.q == (0.65, 0.35)


def test_a_closed_stream_whose_setpoint_an_actuator_keeps_out_of_reach_ends() -> None:
    """Actuators that cross: each joint's way leads one of them beyond its limits, though start and goal are within."""
    limits = JointLimits(("a", "b"), *(np.full(2, value) for value in (-3.0, 3.0, 2.0, 10.0, 100.0)))
    difference = Coupling("slit", ((0, 1.0), (1, -1.0)), 0.0, 0.0)
    following = start(POSITION, limits, [0.0, 0.0], 1.0, [difference]).set([0.05, 0.05]).close()
    for _ in range(10):
        following = following.advance(TICK, 1.0)
    assert following.phase is Phase.CANCELLED
    said = "the joint 'b' comes no nearer than 0.05 to its last setpoint: the limits of 'slit' keep it from there"
    assert following.fault == ("SETPOINT_REFUSED", said)


def test_setpoints_outside_the_limits_by_rounding_are_reached_at_the_limits() -> None:
    following = start(POSITION, one(), [2.99], 1.0).set([3.0 + 5e-7]).close()
    for _ in range(200):
        following = following.advance(TICK, 1.0)
    assert following.phase is Phase.SUCCEEDED
    assert following.now.q == (3.0,)


@pytest.mark.parametrize("mode", SetpointMode)
def test_limits_with_which_a_joint_takes_forever_are_refused(mode: SetpointMode, rng: np.random.Generator) -> None:
    """The library ruckig plans for two hours at most and fails on longer ways, which nobody could stop in the tick."""
    with pytest.raises(KernelError, match="joint 'j' with limits of velocity 2, acceleration 1e-09"):
        start(mode, one(acceleration=1e-9), [0.0], 1.0)


@pytest.mark.parametrize("mode", SetpointMode)
def test_joints_of_any_speed_follow_and_stop(mode: SetpointMode, rng: np.random.Generator) -> None:
    """An exception in the tick would end the kernel; ruckig's own checks fail on one way of a thousand here."""
    for _ in range(600):
        velocity, *seconds = (10.0 ** rng.uniform([0.0, -4.0, -4.0], [4.0, 2.0, 2.0])).tolist()
        acceleration = velocity / seconds[0]
        following = start(mode, one(velocity, acceleration, acceleration / seconds[1], reach=1e9), [0.0], 1e9)
        for _ in range(5):
            following = following.set(near(following, rng).tolist()).advance(TICK, float(rng.choice([1.0, 1e-9])))
        for _ in range(3):
            following = following.cancel().advance(TICK, 1.0)


def test_very_fast_joints_change_their_speed_where_rounding_exceeds_what_ruckig_checks() -> None:
    """Its check of the end, to fixed amounts, failed on both of these states, also with lower limits."""
    for v, a, wanted, acceleration, jerk in (
        (1754.7030618850015, 877351.5309425007, 33.4907569895765, 3041013.98073439, 219337882.73562518),
        (-1968.194052937362, -423316.2443106997, 0.0, 1803601.9998175611, 314882422.9557921),
    ):
        before = JointState((0.0,), (v,), (a,))
        bounds = Bounds([-1e9], [1e9], [acceleration], [jerk], ())
        way, _ = follow_velocities(before, [wanted], bounds, [1e5], TICK)
        step = way.duration / 1000
        for place in range(1, 1001):
            after = way.at(step * place)
            mean_v, mean_a = (before.v[0] + after.v[0]) / 2, (before.a[0] + after.a[0]) / 2
            assert abs(after.a[0]) <= acceleration * (1.0 + 1e-9)
            assert abs(after.a[0] - before.a[0]) <= jerk * step * (1.0 + 1e-6)
            assert abs(after.v[0] - before.v[0] - mean_a * step) <= jerk * step**2 / 4
            assert abs(after.q[0] - before.q[0] - mean_v * step) <= acceleration * step**2 / 4
            before = after
        assert way.at(way.duration)[1:] == ((wanted,), (0.0,))


def test_a_speed_factor_slows_within_the_limits() -> None:
    following = start(POSITION, one(), [-2.5], timeout=1e9)
    places = [following.counted[0]]
    for tick in range(500):
        following = following.set([min(2.5, -2.5 + tick * TICK)]).advance(TICK, 0.1)
        places.append(following.now.q[0])
    assert max(np.abs(np.diff(places))) <= 0.1 * 2.0 * TICK * (1.0 + 1e-9)
    for _ in range(1000):
        following = following.set([-0.5]).advance(TICK, 1.0)
    assert following.now.q == (pytest.approx(-0.5, abs=1e-9),), "it has caught up"


def test_setpoints_of_constant_speed_are_met_without_lag(rng: np.random.Generator) -> None:
    speed = rng.uniform(0.1, 1.8)
    every = int(rng.integers(1, 10))
    following = start(POSITION, one(reach=30.0), [0.0], timeout=1.0)
    for tick in range(1000):
        if tick % every == 0:
            following = following.set([speed * tick * TICK])
        following = following.advance(TICK, 1.0)
    assert following.now.q[0] == pytest.approx(speed * 1000 * TICK, abs=1e-6)
    assert following.now.v[0] == pytest.approx(speed, abs=1e-6)


def test_of_several_setpoints_between_two_ticks_the_newest_counts(rng: np.random.Generator) -> None:
    for mode in SetpointMode:
        following = start(mode, one(), [0.0], timeout=1.0)
        for _ in range(50):
            many, few = following, following
            for _ in range(int(rng.integers(0, 4))):
                many = many.set(near(following, rng).tolist())
            last = near(following, rng).tolist()
            following = many.set(last).advance(TICK, 1.0)
            assert following == few.set(last).advance(TICK, 1.0) or following.now == few.set(last).advance(TICK, 1).now


@pytest.mark.parametrize("mode", SetpointMode)
def test_the_watchdog_stops_with_the_first_tick_after_the_timeout(mode: SetpointMode) -> None:
    following = start(mode, one(), [0.0], timeout=0.2)
    for tick in range(100):
        following = following.set([0.8 if mode is VELOCITY else tick * TICK * 0.8]).advance(TICK, 1.0)
    moving = following
    for _ in range(50 - 1):  # the last setpoint was 1 tick ago
        following = following.advance(TICK, 1.0)
        assert following.phase is Phase.RUNNING
        assert following.fault is None
    following = following.advance(TICK, 1.0)
    assert following.phase is Phase.STOPPING
    assert following.fault == ("SETPOINT_TIMEOUT", "no setpoint came for 0.2 s")
    assert moving.set([moving.counted[0]]).advance(TICK, 1.0).age == TICK, "any setpoint will do"
    for _ in range(100):
        check_limits(following, one())
        following = following.advance(TICK, 1.0)
    assert following.phase is Phase.CANCELLED
    assert following.now.v == (0.0,)
    assert following.progress == 0.0


def test_a_stream_that_says_nothing_times_out_also_while_it_is_paused() -> None:
    following = start(POSITION, one(), [0.0], timeout=0.1).pause()
    for _ in range(26):
        following = following.advance(TICK, 1.0)
    assert following.phase is Phase.CANCELLED
    assert following.fault is not None


@pytest.mark.parametrize("bad", [[float("nan")], [float("inf")], [], [0.0, 0.0]])
@pytest.mark.parametrize("mode", SetpointMode)
def test_setpoints_that_are_no_numbers_or_too_many_are_refused(mode: SetpointMode, bad: list[float]) -> None:
    with pytest.raises(KernelError, match="a setpoint") as refused:
        start(mode, one(), [0.0], timeout=1.0).set(bad)
    assert refused.value.reason is Reason.INVALID_ARGUMENT


def test_setpoints_beyond_limits_are_refused_with_joint_value_and_limit() -> None:
    with pytest.raises(LimitError, match=r"'j' would be at 3\.01 rad, its limits are -3 to 3 rad"):
        start(POSITION, one(), [2.99], timeout=1.0).set([3.01])
    with pytest.raises(LimitError, match=r"'j' would move at -2\.01, its limit is 2") as refused:
        start(VELOCITY, one(), [0.0], timeout=1.0).set([-2.01])
    assert refused.value.metadata == {"joint": "j", "value": "-2.01", "limit": "2.0"}
    start(VELOCITY, one(), [0.0], timeout=1.0).set([-2.0])


def test_a_jump_is_refused_and_time_that_has_gone_by_allows_it() -> None:
    following = start(POSITION, one(), [0.0], timeout=1.0)
    ahead = 2.0 * AHEAD_SECONDS
    following.set([ahead - 1e-6])
    with pytest.raises(
        LimitError, match=r"'j' would go from 0 to 0.15 within 0 s; at .* speed 2 it gets 0.1 far"
    ) as no:
        following.set([0.15])
    assert {name: float(no.value.metadata[name]) for name in ("value", "limit")} == {"value": 0.15, "limit": ahead}
    for _ in range(7):
        following = following.advance(TICK, 1.0)
    following.set([0.15])


def test_what_setpoints_are_ahead_is_used_up_and_comes_back() -> None:
    """Setpoints half as fast again as the joint: 3 rad/s against 2 rad/s use up 0.05 s within 0.1 s."""
    following = start(POSITION, one(), [0.0], timeout=1.0)
    place, ticks = 0.0, 0
    with pytest.raises(LimitError):
        while True:
            place += 3.0 * TICK
            following = following.advance(TICK, 1.0).set([place])
            ticks += 1
    assert ticks == pytest.approx(AHEAD_SECONDS * 2.0 / 1.0 / TICK, abs=1)
    for _ in range(50):
        following = following.set([following.counted[0]]).advance(TICK, 1.0)
    following.set([following.counted[0] + 2.0 * AHEAD_SECONDS])


def test_a_pause_holds_and_a_resume_goes_on_with_the_newest_setpoint() -> None:
    following = start(POSITION, one(), [0.0], timeout=1.0)
    phases = set()
    for tick in range(400):
        if tick == 100:
            following = following.pause()
            assert following.pause() is following
        following = following.set([min(1.0, tick * TICK)]).advance(TICK, 1.0)
        phases.add(following.phase)
    assert phases == {Phase.RUNNING, Phase.PAUSING, Phase.PAUSED}
    assert 0.3 < following.now.q[0] < 0.6
    following = following.resume()
    for _ in range(400):
        check_limits(following, one())
        following = following.set([1.0]).advance(TICK, 1.0)
    assert following.now.q[0] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("mode", SetpointMode)
def test_a_closed_stream_ends_well_at_its_last_setpoint_or_at_rest(mode: SetpointMode) -> None:
    following = start(mode, one(), [0.0], timeout=0.1)
    for tick in range(100):
        following = following.set([1.0 if mode is VELOCITY else tick * TICK]).advance(TICK, 1.0)
    following = following.set([0.5 if mode is VELOCITY else 0.45]).close()
    assert following.set([0.0]).newest == following.newest
    for _ in range(100):
        check_limits(following, one())
        following = following.advance(TICK, 1.0)
    assert following.phase is Phase.SUCCEEDED
    assert following.progress == following.steps_done == 1
    assert following.now[1:] == ((0.0,), (0.0,))
    if mode is POSITION:
        assert following.now.q == (0.45,)


def test_a_cancel_brakes_and_nothing_can_be_done_after_it() -> None:
    following = start(VELOCITY, one(), [0.0], timeout=1.0).set([1.0])
    for _ in range(100):
        following = following.advance(TICK, 1.0)
    following = following.cancel()
    assert following.phase is Phase.STOPPING
    assert following.set([1.0]) is following
    for steer in (following.pause, following.resume):
        with pytest.raises(KernelError, match="is stopping") as refused:
            steer()
        assert refused.value.reason is Reason.WRONG_STATE
    ticks = 0
    while not following.ended:
        check_limits(following, one())
        following = following.advance(TICK, 1.0)
        ticks += 1
    # The double S profile takes v/a + a/j = 1/10 + 10/100 s.
    assert 0.2 <= ticks * TICK <= 0.2 + TICK * (1.0 + 1e-9)
    assert following.phase is Phase.CANCELLED
    assert following.fault is None
    assert start(VELOCITY, one(), [0.0], timeout=1.0).pause().advance(TICK, 1.0).cancel().phase is Phase.CANCELLED


@pytest.mark.parametrize("timeout", [0.0, -1.0, float("nan"), float("inf")])
def test_impossible_timeouts_are_refused(timeout: float) -> None:
    with pytest.raises(KernelError, match="timeout"):
        start(POSITION, one(), [0.0], timeout)


def test_a_start_outside_the_limits_is_refused() -> None:
    with pytest.raises(LimitError, match="setpoints cannot be followed from here"):
        start(POSITION, one(), [3.1], 1.0)
    assert start(POSITION, one(), [3.0 + 1e-7], 1.0).advance(TICK, 1.0).now.q == (3.0 + 1e-7,)


def test_goals_beyond_limits_and_fast_ones_are_led_to_as_formulas_have_it(rng: np.random.Generator) -> None:
    limits = random_limits(rng, 7)
    begun = start(POSITION, limits, (limits.lower + limits.upper) / 2.0, 1.0)
    bounds, greatest = begun.bounds, limits.velocity.tolist()
    for reach, speed in ((0.4, 0.5), (0.7, 0.5), (0.4, 2.0), (0.7, 2.0)) * 5:
        goal = begun.now.q + rng.uniform(-reach, reach, 7) * (limits.upper - limits.lower)
        drift = rng.uniform(-speed, speed, 7) * limits.velocity
        origin = np.clip(goal, limits.lower, limits.upper)
        fastest = MOST_DRIFT * limits.velocity
        follows = np.where(origin == goal, np.clip(drift, -fastest, fastest), 0.0)
        _, there = replace(begun, goal=tuple(goal.tolist()), drift=tuple(drift.tolist())).way(TICK, 1.0)
        _, expected = follow_positions(begun.now, origin.tolist(), follows.tolist(), bounds, greatest, TICK)
        assert there == expected


@pytest.mark.parametrize(
    "values", [[0.1, 0.2], (0.1, -0.0), [1e308, 1e308], np.array([0.1, 0.2]), [0, 1], ["0.1", "0.2"], [True, 0.5]]
)
def test_a_setpoint_of_any_numbers_is_what_an_array_makes_of_them(values: list[float]) -> None:
    following = start(VELOCITY, wide(), np.zeros(2), 1.0)
    found, expected = following.set(values).newest, np.array(values, np.float64).tolist()
    assert repr(found) == repr(tuple(expected))


def wide() -> JointLimits:
    """Return the limits of two joints that may be as fast as can be."""
    return JointLimits(("a", "b"), *(np.full(2, value) for value in (-1.0, 1.0, 1.5e308, 1e308, 1e308)))
