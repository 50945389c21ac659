"""Trajectories of segments over TCP: where ros2_control has each tick; starts on the way, tolerances, refusals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Motion, Phase, Robot
from virtualrobot.errors import (
    InvalidArgumentError,
    LimitError,
    PlanOutdatedError,
    RobotBusyError,
    WrongStateError,
)

from tests import ros2_control
from tests.api.client.conftest import IIWA

TICK = 0.004
TIMES = np.array([0.4, 0.9, 1.1, 1.8])


@pytest.fixture
def arm(steps: Client) -> Robot:
    return steps.load_robot(IIWA, name="arm")


def drawn(rng: np.random.Generator, degree: int) -> list[np.ndarray]:
    """Return positions (4, 7) and, for the degrees 3 and 5, velocities and accelerations; at rest in the end."""
    rows = [rng.uniform(-most, most, (4, 7)) for most in (0.3, 0.2, 0.5)]
    rows[1][-1] = rows[2][-1] = 0.0
    return rows[: (degree + 1) // 2]


def points_of(times: np.ndarray, rows: list[np.ndarray]) -> list[ros2_control.Point]:
    each = [values.tolist() for values in rows] + [[[]] * len(times)] * (3 - len(rows))
    return list(zip(times.tolist(), *each, strict=True))


def begun(robot: Robot, rows: list[np.ndarray], **options: object) -> Motion:
    accelerations = rows[2] if len(rows) > 2 else None
    return robot.move_trajectory(  # pyright: ignore[reportCallIssue]
        TIMES,
        rows[0],
        rows[1] if len(rows) > 1 else None,
        accelerations=accelerations,
        interpolation="segments",
        wait=False,
        **options,  # pyright: ignore[reportArgumentType]
    )


def ticks(client: Client, robot: Robot, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and velocities (n, 7) after each of some ticks."""
    found = []
    for _ in range(count):
        state = client.clock.step(1).robots[robot.name]
        found.append((state.positions, state.velocities))
    q, v = zip(*found, strict=True)
    return np.array(q), np.array(v)


@pytest.mark.parametrize("degree", [1, 3, 5])
def test_each_tick_is_where_ros2_control_has_it(
    steps: Client, arm: Robot, degree: int, rng: np.random.Generator
) -> None:
    rows = drawn(rng, degree)
    motion = begun(arm, rows)
    assert motion.planned_duration == pytest.approx(1.8)
    count = round(TIMES[-1] / TICK) + 5
    q, _ = ticks(steps, arm, count)
    rest = [0.0] * 7
    for tick in range(count):
        wanted, _ = ros2_control.sample(points_of(TIMES, rows), (0.0, rest, rest, rest), 0.0, (tick + 1) * TICK)
        np.testing.assert_allclose(q[tick], wanted, atol=1e-6)
    assert motion.phase is Phase.SUCCEEDED
    np.testing.assert_array_equal(arm.positions, rows[0][-1])


def test_it_takes_over_from_what_moves_at_its_speed(steps: Client, arm: Robot, rng: np.random.Generator) -> None:
    first = arm.move_joints([1.0, 0.5, -0.6, -1.0, 0.2, 0.3, 0.4], wait=False)
    steps.clock.step(40)
    here = arm.state
    rows = drawn(rng, 3)
    motion = begun(arm, rows, replace=True)
    assert (first.phase, first.state.end_cause) == (Phase.CANCELLED, "preempted")
    assert motion.id in first.state.end_reason
    assert np.abs(here.velocities).max() > 0.3
    q, v = ticks(steps, arm, 451)
    before = (0.0, here.positions.tolist(), here.velocities.tolist(), [0.0] * 7)
    for tick in range(450):
        wanted = ros2_control.sample(points_of(TIMES, rows), before, 0.0, (tick + 1) * TICK)
        np.testing.assert_allclose(q[tick], wanted[0], atol=1e-6)
    assert motion.phase is Phase.SUCCEEDED and not v[-1].any()
    # One after the other, each before the last has come to its end, as a jog by MoveIt Servo does.
    for step in range(5):
        arm.move_trajectory(
            [0.1], [arm.positions + 0.01], [[0.05] * 7], interpolation="segments", replace=True, wait=False
        )
        assert len(steps.clock.step(15 + step).motions) >= 1
    steps.clock.step(200)
    assert not arm.state.velocities.any()


def test_a_start_time_lies_in_the_future_or_the_past(steps: Client, arm: Robot, rng: np.random.Generator) -> None:
    rows = drawn(rng, 5)
    now = steps.clock.read().stamp.simulation_time
    begun(arm, rows, start_time=now + 0.5)
    q, _ = ticks(steps, arm, round(2.3 / TICK))
    rest, points = [0.0] * 7, points_of(TIMES, rows)
    for tick in range(len(q) - 1):
        wanted, _ = ros2_control.sample(points, (0.0, rest, rest, rest), 0.5, (tick + 1) * TICK)
        np.testing.assert_allclose(q[tick], wanted, atol=1e-6)
    now = steps.clock.read().stamp.simulation_time
    late = begun(arm, rows, start_time=now - 0.95)  # between its second and third point
    assert late.planned_duration == pytest.approx(TIMES[-1] - 0.95)
    q, _ = ticks(steps, arm, round(0.8 / TICK))
    for tick in range(40, 200):
        wanted, _ = ros2_control.sample(points, (0.0, rest, rest, rest), 0.0, 0.95 + (tick + 1) * TICK)
        np.testing.assert_allclose(q[tick], wanted, atol=1e-6)
    steps.clock.step(50)
    with pytest.raises(InvalidArgumentError, match=r"last point was due 8\.2 s ago"):
        begun(arm, rows, start_time=steps.clock.read().stamp.simulation_time - 10.0)


def test_a_speed_factor_slows_it_and_a_cancel_brakes(steps: Client, arm: Robot, rng: np.random.Generator) -> None:
    rows = drawn(rng, 5)
    arm.speed_factor = 0.5
    motion = begun(arm, rows)
    steps.clock.step(round(0.9 * 2 / TICK))
    np.testing.assert_allclose(arm.positions, rows[0][1], atol=1e-6)
    np.testing.assert_allclose(arm.state.velocities, rows[1][1] / 2, atol=1e-6)
    motion.cancel("no more")
    steps.clock.step(500)
    assert (motion.phase, motion.state.end_cause) == (Phase.CANCELLED, "call")
    assert not arm.state.velocities.any()


def test_it_is_planned_and_checked_as_others_are(arm: Robot, rng: np.random.Generator) -> None:
    rows = drawn(rng, 3)
    move = arm.trajectory(TIMES, *rows, interpolation="segments")
    plan = arm.plan(move)
    assert plan.duration == pytest.approx(1.8)
    np.testing.assert_allclose(plan.robots["arm"].positions[round(0.9 / TICK)], rows[0][1], atol=1e-9)
    # Of the third degree accelerations have steps, which are the caller's business, and told.
    assert arm.check(move).first_violation.kind.name == "JOINT_ACCELERATION"  # pyright: ignore[reportOptionalMemberAccess]
    still, goal = np.zeros((2, 7)), np.stack([np.zeros(7), np.full(7, 0.5)])
    assert arm.check(arm.trajectory([0.0, 3.0], goal, still, accelerations=still, interpolation="segments")).ok
    fast = arm.trajectory([0.1], [[2.0, *[0.0] * 6]], interpolation="segments")
    assert arm.check(fast).first_violation is not None


def test_what_cannot_be_is_refused_and_nothing_moves(steps: Client, arm: Robot, rng: np.random.Generator) -> None:
    rows = drawn(rng, 5)
    far = [[4.0, *[0.0] * 6]]
    with pytest.raises(LimitError, match="lbr_iiwa_joint_1"):
        arm.move_trajectory([9.0], far, interpolation="segments", wait=False)
    with pytest.raises(LimitError, match="too fast"):
        arm.move_trajectory([0.01], [[0.5] * 7], interpolation="segments", wait=False)
    with pytest.raises(InvalidArgumentError, match="'smooth', 'segments', not 'cubic'"):
        arm.trajectory(TIMES, rows[0], interpolation="cubic")
    with pytest.raises(InvalidArgumentError, match="SEGMENTS alone"):
        arm.move_trajectory([0.0, 1.0], np.zeros((2, 7)), accelerations=np.zeros((2, 7)), wait=False)
    with pytest.raises(InvalidArgumentError, match="single joint trajectory of SEGMENTS"):
        arm.move_joints([0.1] * 7, replace=True, wait=False)
    with pytest.raises(InvalidArgumentError, match=r"path_tolerances\[0\].joint must be one of"):
        begun(arm, rows, path_tolerances={"elbow": 0.1})
    with pytest.raises(InvalidArgumentError, match="path_tolerances are 0"):
        begun(arm, rows, path_tolerances=-0.1)
    with pytest.raises(InvalidArgumentError, match="only move of its motion"):
        step = steps.program().move(arm.trajectory(TIMES, rows[0], interpolation="segments", start_time=1.0))
        step.start(wait=False)
    other = steps.load_robot(IIWA, name="other", pose=virtualrobot.pose(y=2.0))
    with pytest.raises(InvalidArgumentError, match="keeps its times"):
        both = [one.trajectory(TIMES, rows[0], interpolation="segments") for one in (arm, other)]
        steps.move_together(both, wait=False)
    steps.clock.step(10)
    assert not arm.positions.any()
    moving = arm.move_joints([1.5] * 7, wait=False)
    with pytest.raises(RobotBusyError):
        begun(arm, rows)
    with pytest.raises(RobotBusyError, match="moves 'lbr_iiwa_joint_2'"):
        arm.move_trajectory(
            [1.0], [[0.1]], joints=["lbr_iiwa_joint_1"], interpolation="segments", replace=True, wait=False
        )
    steps.clock.step(30)
    with pytest.raises((InvalidArgumentError, PlanOutdatedError), match="the joint is at"):
        arm.move_trajectory([0.0, 1.0], np.zeros((2, 7)), interpolation="segments", replace=True, wait=False)
    arm.stop()
    with pytest.raises(WrongStateError, match="is being stopped"):
        begun(arm, rows, replace=True)
    steps.clock.step(200)
    assert moving.phase is Phase.CANCELLED


ROD = """<robot name="rod">
  <link name="post"/>
  <link name="rod">
    <inertial><origin xyz="0 0 -0.2"/><mass value="1.5"/>
      <inertia ixx="0.02" iyy="0.02" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="hinge" type="revolute">
    <origin xyz="0 0 2"/><parent link="post"/><child link="rod"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" velocity="20" effort="1.0"/>
  </joint>
</robot>"""
HELD = np.arcsin(1.0 / (1.5 * 9.81 * 0.2))
"""Angle (rad) at which a motor of 1 N m holds the rod: m g l sin(q) = 1 N m."""


@pytest.fixture
def rod(steps: Client, tmp_path: Path) -> Robot:
    """Return a rod that hangs at a hinge, whose motor is too weak to lift it to the side."""
    (tmp_path / "rod.urdf").write_text(ROD)
    robot = steps.load_robot(tmp_path / "rod.urdf", name="rod")
    steps.physics.set("mujoco")
    steps.physics.enable("rod")
    steps.clock.step(5)
    return robot


def test_a_joint_beyond_its_tolerance_on_the_way_aborts_it(steps: Client, rod: Robot) -> None:
    motion = rod.move_trajectory([3.0], [[1.4]], interpolation="segments", path_tolerances={"hinge": 0.1}, wait=False)
    steps.clock.step(1500)
    state = motion.state
    assert (state.phase, state.end_cause) == (Phase.ABORTED, "path_tolerance")
    (off,) = state.deviations
    assert (off.robot, off.joint, off.kind, off.tolerance) == ("rod", "hinge", "position", 0.1)
    assert -0.12 < off.value < -0.1  # it hangs back, and was told in the first tick beyond
    assert "'hinge' of 'rod' is off by -0.1" in state.end_reason
    # It went along up to where its motor can hold it, and a little farther as it swung.
    assert 0.3 < state.progress * 1.4 - 0.1 < HELD + 0.1


def test_a_joint_that_does_not_come_to_its_goal_aborts_it(steps: Client, rod: Robot) -> None:
    motion = rod.move_trajectory(
        [1.0], [[1.4]], interpolation="segments", goal_tolerances=0.05, goal_time_tolerance=0.5, wait=False
    )
    steps.clock.step(260)
    assert motion.phase is Phase.WAITING
    steps.clock.step(150)
    state = motion.state
    assert (state.phase, state.end_cause) == (Phase.ABORTED, "goal_tolerance")
    assert [(one.joint, one.kind, one.tolerance) for one in state.deviations] == [("hinge", "position", 0.05)]
    assert "0.5 s after its end" in state.end_reason


def test_within_its_tolerances_it_succeeds(steps: Client, rod: Robot) -> None:
    motion = rod.move_trajectory(
        [1.0],
        [[0.2]],
        [[0.0]],
        interpolation="segments",
        path_tolerances=(0.1, 5.0),
        goal_tolerances=(0.05, 0.1),
        goal_time_tolerance=3.0,
        wait=False,
    )
    steps.clock.step(1100)
    assert (motion.phase, motion.state.deviations) == (Phase.SUCCEEDED, ())


def test_a_guarded_arm_that_takes_over_stops_before_a_wall(steps: Client, arm: Robot) -> None:
    arm.set_positions([0.3, 0.6, -0.2, -1.4, 0.1, 0.9, 0.2])
    here = arm.tcp
    x = here[0, 3] + 0.12
    steps.scene.add_object("wall", virtualrobot.box(0.001, 2.0, 2.0), pose=virtualrobot.pose(x, 0.0, 0.5))
    steps.collisions.set("guard")
    beyond = arm.solve_inverse(virtualrobot.pose(x=0.2) @ here).solutions[0]
    line = arm.move_linear(virtualrobot.pose(x=0.08) @ here, wait=False)
    steps.clock.step(60)
    assert np.abs(arm.state.velocities).max() > 0.01
    motion = arm.move_trajectory([1.0], [beyond], interpolation="segments", replace=True, wait=False)
    steps.clock.step(400)
    assert (line.phase, motion.phase) == (Phase.CANCELLED, Phase.ABORTED)
    assert motion.state.end_cause == "collision"
    assert 0.0 < steps.collisions.distance("arm", to=["wall"]).distance < 0.01
