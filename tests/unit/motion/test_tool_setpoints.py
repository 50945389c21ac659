"""Motions by twists and poses of a tool: straight lines, poses, joints' limits at every tick, what holds it, brakes."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.motion.limits import CartesianLimits, JointLimits
from virtualrobot_kernel.motion.resolved_rate import SMALLEST_SINGULAR_VALUE, lever_arm
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.motion.tool_lead import BEYOND, SINGULARITY, ToolLead
from virtualrobot_kernel.motion.tool_setpoints import ToolSetpointMotion, start
from virtualrobot_sdk.poses import quaternion, rotation_matrix

from .motions import TICK, arm_limits, kinematics

TWIST, POSE = SetpointMode.TOOL_TWIST, SetpointMode.TOOL_POSE
BENT = np.array([0.3, -1.2, 1.5, -1.0, 1.2, 0.4])
"""A posture of a UR5 far from its limits and singularities."""
POSTURES = {
    "ur5": BENT,
    "iiwa": np.array([0.2, 0.5, -0.3, -1.3, 0.4, 1.2, 0.1]),
    "panda": np.array([0.0, -0.8, 0.0, -2.4, 0.0, 1.6, 0.8]),
}
OVERSHOOT = 2e-3
"""Farthest (m) that a tool goes beyond a pose where its joints allow less acceleration the farther it brakes."""
SPEED, ACCELERATION, JERK, TURNING = 0.25, 1.0, 10.0, 1.0
TIMEOUT = 0.2


def following(
    mode: SetpointMode = TWIST, name: str = "ur5", q: np.ndarray = BENT, *, in_tool: bool = False
) -> ToolSetpointMotion:
    """Return a motion at its start."""
    limits = CartesianLimits(SPEED, ACCELERATION, JERK, TURNING)
    chain = kinematics(name).chain
    lever = lever_arm(ToolLead(chain, 1.0, in_tool, limits).at(q).jacobian)
    return start(mode, ToolLead(chain, 1.0 / lever, in_tool, limits), arm_limits(name), q, TIMEOUT)


def place(motion: ToolSetpointMotion) -> np.ndarray:
    """Return where the tool is by the joints, as the arm's own component has it."""
    return motion.lead.at(np.array(motion.now.q)).pose


def led(motion: ToolSetpointMotion, values: np.ndarray | list[float], ticks: int) -> list[ToolSetpointMotion]:
    """Return the motion after each of some ticks, with the same setpoint before each."""
    found = [motion]
    for _ in range(ticks):
        found.append(found[-1].set(list(values)).advance(TICK, 1.0))
    return found


def pose(matrix: np.ndarray) -> list[float]:
    return [*matrix[:3, 3].tolist(), *quaternion(matrix[:3, :3])]


def check_limits(run: list[ToolSetpointMotion], limits: JointLimits) -> None:
    """Check that joints keep all limits at ticks, and that their derivatives are those of their positions."""
    for before, after in pairwise(run):
        (q0, v0, a0), (q, v, a) = (map(np.array, one.now) for one in (before, after))
        assert np.all((q >= limits.lower) & (q <= limits.upper))
        assert np.all(np.abs(v) <= limits.velocity * (1.0 + 1e-9))
        assert np.all(np.abs(a) <= limits.acceleration * (1.0 + 1e-9))
        assert np.all(np.abs(a - a0) <= limits.jerk * TICK * (1.0 + 1e-6))
        assert np.all(np.abs(q - q0 - 0.5 * TICK * (v + v0)) <= limits.jerk * TICK**3 + 1e-9)


@pytest.mark.parametrize("in_tool", [False, True])
def test_a_tool_goes_along_a_straight_line_and_keeps_its_orientation(in_tool: bool) -> None:
    motion = following(in_tool=in_tool)
    start_pose = place(motion)
    axes = start_pose[:3, :3] if in_tool else np.eye(3)
    direction = np.array([2.0, -1.0, 2.0]) / 3.0
    run = led(motion, [*(0.2 * direction), 0.0, 0.0, 0.0], 250)
    ways = np.array([place(one)[:3, 3] - start_pose[:3, 3] for one in run]) @ axes
    assert np.abs(ways - np.outer(ways @ direction, direction)).max() < 1e-9
    assert max(np.abs(place(one)[:3, :3] - start_pose[:3, :3]).max() for one in run) < 1e-9
    # A jerk-limited ramp to v lasts T = v/a + a/j where it reaches the greatest acceleration, and takes v T / 2.
    time = 0.2 / ACCELERATION + ACCELERATION / JERK
    assert ways[-1] @ direction == pytest.approx(0.2 * (250 * TICK - time / 2.0), abs=1e-9)
    assert np.allclose(run[-1].base_twist[:3], 0.2 * axes @ direction, atol=1e-9)
    check_limits(run, motion.limits)


def test_a_tool_turns_about_its_centre_point_and_moves_meanwhile() -> None:
    motion = following()
    start_pose = place(motion)
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    run = led(motion, [0.1, 0.0, 0.0, *(0.5 * axis)], 200)
    end = place(run[-1])
    way = end[:3, 3] - start_pose[:3, 3]
    assert np.abs(way[1:]).max() < 1e-9
    # Both change together, since their ratio is that of the twist: 5 rad each metre.
    assert np.abs(end[:3, :3] - rotation_matrix(5.0 * way[0] * axis) @ start_pose[:3, :3]).max() < 1e-9
    check_limits(run, motion.limits)


@pytest.mark.parametrize("name", POSTURES)
@pytest.mark.parametrize("turning", [0.0, 0.5])
def test_poses_of_constant_speed_are_followed_without_lag(name: str, turning: float) -> None:
    """As a hand moves it: 72 poses a second, at ticks between which they come unevenly."""
    motion = following(POSE, name, POSTURES[name])
    begin, direction, axis = place(motion), np.array([-0.48, 0.6, 0.64]), np.array([1.0, 2.0, -2.0]) / 3.0

    def there(seconds: float) -> np.ndarray:
        goal = begin.copy()
        goal[:3, 3] += 0.1 * seconds * direction
        goal[:3, :3] = rotation_matrix(turning * seconds * axis) @ begin[:3, :3]
        return goal

    run, told = [motion], 0
    for tick in range(300):
        if 72 * tick * TICK >= told:
            motion, told = motion.set(pose(there(tick * TICK))), told + 1
        motion = motion.advance(TICK, 1.0)
        run.append(motion)
    assert np.abs(place(motion) - there(300 * TICK)).max() < 1e-6
    # It has caught up with what it was behind at first, within its greatest speed.
    assert max(float(np.linalg.norm(one.base_twist[:3])) for one in run) <= SPEED * (1.0 + BEYOND)
    # The last one stands: the tool goes beyond it by the way of its brake at most, v sqrt(v / j), and comes back.
    last = there(299 * TICK)
    run += led(motion, pose(last), 300)[1:]
    beyond = max(float(direction @ (place(one) - last)[:3, 3]) for one in run)
    assert beyond < 0.1 * np.sqrt(0.1 / JERK) + 0.1 * 3 * 2 * TICK + OVERSHOOT
    assert np.abs(place(run[-1]) - last).max() < 1e-9
    check_limits(run, motion.limits)


@pytest.mark.parametrize("name", ["ur5", "iiwa", "panda"])
def test_a_pose_is_reached_on_a_straight_line_and_kept(name: str) -> None:
    motion = following(POSE, name, POSTURES[name])
    begin = place(motion)
    goal = begin.copy()
    goal[:3, :3] = rotation_matrix(np.array([0.3, -0.2, 0.1])) @ begin[:3, :3]
    goal[:3, 3] += [0.1, -0.05, 0.08]
    run = led(motion, pose(goal), 400)
    assert np.abs(place(run[-1]) - goal).max() < 1e-9
    assert not any(run[-1].now.v) and run[-1].phase is Phase.RUNNING
    ways = np.array([place(one)[:3, 3] for one in run]) - begin[:3, 3]
    direction = (goal - begin)[:3, 3] / np.linalg.norm((goal - begin)[:3, 3])
    assert np.abs(ways - np.outer(ways @ direction, direction)).max() < 1e-6
    assert (ways @ direction).max() < (goal - begin)[:3, 3] @ direction + OVERSHOOT
    check_limits(run, motion.limits)
    done = run[-1].close().advance(TICK, 1.0)
    assert done.phase is Phase.SUCCEEDED


def test_a_tool_that_is_let_go_rests_on_its_line() -> None:
    motion = following()
    begin = place(motion)
    run = led(motion, [0.0, 0.2, 0.0, 0.0, 0.0, 0.0], 150)
    rest = [run[-1].close()]
    while not rest[-1].ended:
        rest.append(rest[-1].advance(TICK, 1.0))
    assert rest[-1].phase is Phase.SUCCEEDED and rest[-1].fault is None
    # As long as it took to gain its speed, and three ticks until nothing changes any more.
    assert len(rest) - 1 == pytest.approx((0.2 / ACCELERATION + ACCELERATION / JERK) / TICK, abs=3)
    assert np.abs((place(rest[-1]) - begin)[[0, 2], 3]).max() < 1e-9
    check_limits([*run, *rest[1:]], motion.limits)


def test_a_singularity_slows_the_tool_on_its_line_and_lets_it_go_back() -> None:
    motion = following()
    begin = place(motion)
    run = led(motion, [0.0, SPEED, 0.0, 0.0, 0.0, 0.0], 2000)  # until the arm is nearly stretched
    check_limits(run, motion.limits)
    end = run[-1]
    assert end.held_by == SINGULARITY and not any(end.now.v) and end.phase is Phase.RUNNING
    assert SMALLEST_SINGULAR_VALUE <= end.lead.at(np.array(end.now.q)).smallest < 1.2 * SMALLEST_SINGULAR_VALUE
    assert np.abs((place(end) - begin)[[0, 2], 3]).max() < 1e-6
    back = led(end, [0.0, -SPEED, 0.0, 0.0, 0.0, 0.0], 500)
    check_limits(back, motion.limits)
    assert place(back[-1])[1, 3] < place(end)[1, 3] - 0.2


def test_a_joint_that_comes_to_its_limit_slows_the_tool_on_its_line() -> None:
    whole = following()
    upper = whole.limits.upper.copy()
    upper[3] = BENT[3] + 0.3
    limits = JointLimits(
        whole.limits.names,
        whole.limits.lower,
        upper,
        whole.limits.velocity,
        whole.limits.acceleration,
        whole.limits.jerk,
    )
    motion = start(TWIST, whole.lead, limits, BENT, TIMEOUT)
    begin = place(motion)
    run = led(motion, [0.0, -SPEED, 0.0, 0.0, 0.0, 0.0], 1500)
    check_limits(run, limits)
    assert run[-1].held_by == limits.names[3] and not any(run[-1].now.v)
    assert run[-1].now.q[3] == pytest.approx(upper[3], abs=1e-3)
    assert np.abs((place(run[-1]) - begin)[[0, 2], 3]).max() < 1e-6


def test_a_pose_out_of_reach_ends_a_closed_stream_as_near_as_the_tool_gets() -> None:
    motion = following(POSE)
    goal = place(motion)
    goal[1, 3] += 2.0
    now = led(motion, pose(goal), 1500)[-1].close()
    for _ in range(500):
        now = now.advance(TICK, 1.0)
    assert now.phase is Phase.CANCELLED
    assert now.fault is not None and now.fault[0] == "SETPOINT_REFUSED"
    assert "comes no nearer than" in now.fault[1] and "a singularity is in the way" in now.fault[1]


def check_speeds(now: ToolSetpointMotion) -> None:
    """Check that the tool goes and turns no faster than it may."""
    assert np.linalg.norm(now.base_twist[:3]) <= SPEED * (1.0 + BEYOND)
    assert np.linalg.norm(now.base_twist[3:]) <= TURNING * (1.0 + BEYOND)


@pytest.mark.parametrize("mode", [TWIST, POSE])
@pytest.mark.parametrize("name", ["ur5", "iiwa"])
def test_random_setpoints_keep_every_limit(mode: SetpointMode, name: str, rng: np.random.Generator) -> None:
    limits = arm_limits(name)
    q = rng.uniform(0.8 * np.maximum(limits.lower, -2.0), 0.8 * np.minimum(limits.upper, 2.0))
    motion = following(mode, name, q, in_tool=bool(rng.integers(2)))
    home = place(motion)
    run = [motion]
    for _ in range(8):
        if mode is TWIST:
            values = [*rng.uniform(-SPEED, SPEED, 3) / 2.0, *rng.uniform(-TURNING, TURNING, 3) / 2.0]
        else:
            goal = np.eye(4)
            goal[:3, :3] = rotation_matrix(rng.uniform(-0.5, 0.5, 3)) @ home[:3, :3]
            goal[:3, 3] = home[:3, 3] + rng.uniform(-0.4, 0.4, 3)
            values = pose(goal)
        run += led(run[-1], values, int(rng.integers(10, 120)))[1:]
    assert run[-1].phase is Phase.RUNNING
    check_limits(run, limits)


@pytest.mark.parametrize("mode", [TWIST, POSE])
@pytest.mark.parametrize("name", sorted(POSTURES))
def test_a_tool_is_nowhere_faster_than_its_greatest_speed(
    name: str, mode: SetpointMode, rng: np.random.Generator
) -> None:
    """Led at its greatest speed in directions that change, and braking from there, from postures as they come."""
    limits = arm_limits(name)
    near = POSTURES[name] + rng.uniform(-1.0, 1.0, len(POSTURES[name]))
    motion = following(mode, name, np.clip(near, limits.lower + 0.1, limits.upper - 0.1))
    home, run = place(motion), [motion]

    for _ in range(3):
        if mode is TWIST:
            way, axis = rng.normal(size=(2, 3))
            turning = TURNING * float(rng.integers(2)) / np.linalg.norm(axis)
            values = [*(SPEED * way / np.linalg.norm(way)), *(turning * axis)]
        else:
            goal = home.copy()
            goal[:3, :3] = rotation_matrix(rng.uniform(-1.0, 1.0, 3)) @ home[:3, :3]
            goal[:3, 3] += rng.uniform(-0.4, 0.4, 3)
            values = pose(goal)
        for _ in range(3):
            run += led(run[-1], values, 40)[1:]
            braked = [run[-1].cancel()]
            while not braked[-1].ended:
                braked.append(braked[-1].advance(TICK, 1.0))
                check_speeds(braked[-1])
            check_limits(braked, limits)
    for now in run:
        check_speeds(now)
    check_limits(run, limits)


@pytest.mark.parametrize(("number", "ticks"), [(9, 90), (35, 120)])
def test_joints_that_would_brake_at_different_times_make_no_tool_fast(number: int, ticks: int) -> None:
    """Two drawn cases in which it became 1.31 and 1.43 times as fast as its limit when each joint braked alone."""
    rng = np.random.default_rng(1)
    cases = [(BENT + rng.uniform(-1.0, 1.0, 6), rng.normal(size=3)) for _ in range(number + 1)]
    q, way = cases[number]
    twist = [*(SPEED * way / np.linalg.norm(way)), 0.0, 0.0, 0.0]
    now = led(following(TWIST, "ur5", q), twist, ticks)[-1].cancel()
    while not now.ended:
        now = now.advance(TICK, 1.0)
        check_speeds(now)


@pytest.mark.parametrize("number", [5, 37])
def test_a_tool_that_turns_at_its_greatest_speed_turns_no_faster_where_it_changes_its_way(number: int) -> None:
    """Two drawn cases in which it turned 1.11 times as fast as its limit when only its speed along a line was held."""
    rng = np.random.default_rng(number)
    q = POSTURES["iiwa"] + rng.uniform(-0.8, 0.8, 7)
    now = following(TWIST, "iiwa", q)
    for _ in range(3):
        way, axis = rng.normal(size=(2, 3))
        twist = [*(SPEED * way / np.linalg.norm(way)), *(TURNING * axis / np.linalg.norm(axis))]
        run = led(now, twist, 60)
        for one in run:
            check_speeds(one)
        now = run[-1]


def test_the_watchdog_brakes_with_the_first_tick_after_the_timeout() -> None:
    now = led(following(), [0.0, 0.2, 0.0, 0.0, 0.0, 0.0], 200)[-1]
    ticks, run = 0, [now]
    while now.phase is Phase.RUNNING:
        now, ticks = now.advance(TICK, 1.0), ticks + 1
        run.append(now)
    assert ticks == round(TIMEOUT / TICK)
    assert (now.phase, now.fault) == (Phase.STOPPING, ("SETPOINT_TIMEOUT", "no setpoint came for 0.2 s"))
    # As the guard was told, joint by joint.
    ahead = now.stop_ahead(TICK, 1000)
    assert ahead is not None
    for row in ahead[1:]:
        now = now.advance(TICK, 1.0)
        run.append(now)
        assert np.allclose(now.now.q, row, atol=1e-9)
    assert now.phase is Phase.CANCELLED and not any(now.now.v)
    check_limits(run, now.limits)


def test_a_speed_factor_slows_the_tool_on_its_line() -> None:
    motion = following()
    begin = place(motion)
    run = [motion]
    for tick in range(300):
        run.append(run[-1].set([0.0, SPEED, 0.0, 0.0, 0.0, 0.0]).advance(TICK, 1.0 if tick < 150 else 0.2))
    assert np.linalg.norm(run[-1].base_twist[:3]) == pytest.approx(0.2 * SPEED, abs=1e-9)
    assert np.abs((place(run[-1]) - begin)[[0, 2], 3]).max() < 1e-9
    check_limits(run, motion.limits)


def test_a_pause_holds_and_a_resume_goes_on() -> None:
    now = led(following(), [0.0, 0.2, 0.0, 0.0, 0.0, 0.0], 100)[-1].pause()
    run = led(now, [0.0, 0.2, 0.0, 0.0, 0.0, 0.0], 100)
    assert run[-1].phase is Phase.PAUSED and not any(run[-1].now.v)
    again = led(run[-1].resume(), [0.0, 0.2, 0.0, 0.0, 0.0, 0.0], 100)
    assert again[-1].base_twist[1] == pytest.approx(0.2, abs=1e-9)
    check_limits([*run, *again[1:]], now.limits)


def test_setpoints_that_are_none_are_refused() -> None:
    with pytest.raises(KernelError, match="a finite number for each of vx, vy, vz, wx, wy, wz"):
        following().set([0.0, 0.1])
    with pytest.raises(KernelError, match="a finite number for each"):
        following().set([0.0, 0.1, np.nan, 0.0, 0.0, 0.0])
    with pytest.raises(
        LimitError, match=r"would move at 100 m/s, and the stream's max_velocity_meters_per_second is 0.25"
    ):
        following().set([100.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    with pytest.raises(LimitError, match="max_rotation_velocity_radians_per_second is 1"):
        following().set([0.0, 0.0, 0.0, 0.0, 1.1, 0.0])
    with pytest.raises(KernelError, match="of length 2; it must have length 1"):
        following(POSE).set([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0])


def test_it_comes_back_bit_for_bit_from_the_journal() -> None:
    now = led(following(), [0.0, 0.2, 0.0, 0.0, 0.1, 0.0], 60)[-1]
    codec = world_codec()
    again = codec.decode(codec.encode(now))
    for _ in range(20):
        now, again = (one.set([0.1, 0.0, 0.0, 0.0, 0.0, 0.0]).advance(TICK, 1.0) for one in (now, again))
    assert isinstance(again, ToolSetpointMotion) and again.now == now.now
