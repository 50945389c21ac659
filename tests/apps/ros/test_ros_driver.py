"""The driver `ros_trajectory`: joints by a topic, points by goals, against a robot that the test plays."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import suppress

import numpy as np
import pytest
from virtualrobot_apps.bridges.ros.driver import PEAK, RosTrajectory, RosTrajectorySettings
from virtualrobot_sdk.drivers import DriverFault, Mode, Pace, Reading

from tests.apps.ros.bridges import GUARD
from tests.apps.ros.sham_rosbridge import ShamRobot, sham_robot

JOINTS = ("shoulder", "elbow")


@pytest.fixture
def robot() -> Iterator[tuple[RosTrajectory, ShamRobot]]:
    """Give a driver that is not connected yet, and the robot of its settings."""
    with sham_robot() as (url, robot):
        driver = RosTrajectory(RosTrajectorySettings(url, joints=JOINTS, speed=0.5, silence=GUARD, token="secret"))
        try:
            yield driver, robot
        finally:
            driver.close()


def read_until(driver: RosTrajectory, there: Callable[[Reading], bool]) -> Reading:
    """Return the first reading of which `there` is true."""
    end = time.monotonic() + GUARD
    while not there(reading := driver.read()):
        assert time.monotonic() < end, reading
        time.sleep(0.005)
    return reading


def fault(driver: RosTrajectory) -> DriverFault:
    """Return the fault that reading comes to."""
    with pytest.raises(DriverFault) as told:
        read_until(driver, lambda _: False)
    return told.value


def test_joints_are_those_of_the_settings_in_their_order(robot: tuple[RosTrajectory, ShamRobot]) -> None:
    driver, sham = robot
    about = driver.connect()
    assert (about.joints, about.rate, about.pace, about.watchdog) == (2, 50.0, Pace.JOBS, 0.0)
    reading = driver.read()
    assert reading.positions.tolist() == [-0.25, 0.5]
    assert reading.velocities is not None and reading.velocities.tolist() == [0.0, 0.0]
    assert reading.mode is Mode.READY
    later = read_until(driver, lambda one: one.stamp > reading.stamp)
    assert (later.stamp - reading.stamp) / 0.02 == pytest.approx(round((later.stamp - reading.stamp) / 0.02))
    assert sham.headers == ["Bearer secret"]


def test_without_names_all_joints_count_as_the_topic_has_them() -> None:
    with sham_robot() as (url, _):
        driver = RosTrajectory(RosTrajectorySettings(url))
        try:
            assert driver.connect().joints == 3
            assert driver.read().positions.tolist() == [0.04, 0.5, -0.25]
        finally:
            driver.close()


def test_it_goes_from_point_to_point_in_the_time_that_its_speed_asks_for(
    robot: tuple[RosTrajectory, ShamRobot],
) -> None:
    driver, sham = robot
    driver.connect()
    driver.begin(driver.read().positions)
    points = [np.array([0.75, 0.5]), np.array([0.75, 0.0])]
    driver.run(points, [1.0, 0.5], 0)
    there = read_until(driver, lambda one: one.done == 2)
    assert there.mode is Mode.RUNNING
    read_until(driver, lambda one: one.positions.tolist() == [0.75, 0.0])
    assert sham.positions["gripper"] == 0.04
    first, second = (one["args"]["trajectory"] for one in sham.goals)
    assert first["joint_names"] == list(JOINTS)
    seconds = [
        one["points"][0]["time_from_start"]["sec"] + 1e-9 * one["points"][0]["time_from_start"]["nanosec"]
        for one in (first, second)
    ]
    # The shoulder goes 1 rad at 0.5 rad/s, the elbow 0.5 rad at half of that.
    np.testing.assert_allclose(seconds, [PEAK * 1.0 / 0.5, PEAK * 0.5 / 0.25], atol=1e-8)
    assert first["points"][0]["velocities"] == first["points"][0]["accelerations"] == [0.0, 0.0]
    driver.end()
    assert driver.read().mode is Mode.READY


def test_a_quintic_from_rest_to_rest_is_no_faster_than_its_mean_by_15_eighths() -> None:
    """A way is 10 t^3 - 15 t^4 + 6 t^5, as ros2_control has a segment with velocities and accelerations of zero."""
    t = np.linspace(0.0, 1.0, 1001)
    assert (30 * t**2 - 60 * t**3 + 30 * t**4).max() == pytest.approx(PEAK)


def test_a_stop_cancels_the_goal_and_forgets_the_points(robot: tuple[RosTrajectory, ShamRobot]) -> None:
    driver, sham = robot
    driver.connect()
    sham.answers, sham.is_deaf = None, True
    driver.begin(driver.read().positions)
    driver.run([np.zeros(2), np.ones(2)], [1.0, 1.0], 0)
    read_until(driver, lambda _: len(sham.goals) == 1)
    driver.stop()
    reading = read_until(driver, lambda _: len(sham.canceled) == 2)
    assert (sham.canceled, reading.mode, reading.done) == ([sham.goals[0]["id"]] * 2, Mode.READY, 0)
    driver.run([np.ones(2)], [1.0], 0)  # nobody follows
    sham.answers = (4, 0, "")
    driver.begin(driver.read().positions)
    driver.run([np.ones(2)], [1.0], 0)
    read_until(driver, lambda one: one.done == 1)
    assert [one["args"]["trajectory"]["points"][0]["positions"] for one in sham.goals] == [[0.0, 0.0], [1.0, 1.0]]


@pytest.mark.parametrize(
    ("answer", "text", "code"),
    [
        ((6, -4, "elbow: 0.2 rad off its path"), "elbow: 0.2 rad off its path", "-4"),
        ((6, -2, ""), "INVALID_JOINTS", "-2"),
        ((6, 0, ""), "the goal was not reached", ""),
        ((5, 0, ""), "was canceled by somebody else", ""),
    ],
)
def test_a_goal_that_fails_is_a_fault_in_its_own_words(
    robot: tuple[RosTrajectory, ShamRobot], answer: tuple[int, int, str], text: str, code: str
) -> None:
    driver, sham = robot
    driver.connect()
    sham.answers = answer
    driver.begin(driver.read().positions)
    driver.run([np.zeros(2), np.ones(2)], [1.0, 1.0], 0)
    told = fault(driver)
    assert text in told.text and (told.code, told.clears) == (code, True)
    assert len(sham.goals) == 1  # nothing is sent after it
    assert driver.read().mode is Mode.READY


def test_what_ends_or_says_nonsense_is_told(robot: tuple[RosTrajectory, ShamRobot]) -> None:
    driver, sham = robot
    for says in ("no json", "[1, 2]", '{"op": "publish", "topic": "/joint_states", "msg": {"name": ["elbow"]}}'):
        driver.connect()
        sham.says = says
        if "elbow" in says:
            driver.read()  # a message without all joints is another robot's
        else:
            assert "sends what is no message of rosbridge" in str(fault(driver))
    sham.unplug()
    assert "has ended" in str(fault(driver)) or "is lost" in str(fault(driver))


def test_a_joint_without_a_number_is_told_as_that(robot: tuple[RosTrajectory, ShamRobot]) -> None:
    driver, sham = robot
    driver.connect()
    sham.positions["elbow"] = float("nan")  # JSON of Python writes NaN, that of rosbridge null
    assert np.isnan(read_until(driver, lambda one: not np.isfinite(one.positions).all()).positions[1])


def test_nobody_and_nothing_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(f"{RosTrajectory.__module__}._FIRST_SECONDS", 0.3)
    with sham_robot() as (url, sham):
        sham.talks = False
        sham.says = '{"op": "status", "level": "error", "msg": "no such topic"}'
        driver = RosTrajectory(RosTrajectorySettings(url, joints=JOINTS))
        with pytest.raises(DriverFault, match=r"nothing comes on /joint_states with the joints shoulder, elbow; .*no"):
            driver.connect()
        driver.close()
    with suppress(DriverFault):
        driver.stop()
    with pytest.raises(DriverFault, match="nobody speaks rosbridge at ws://127"):
        RosTrajectory(RosTrajectorySettings(url)).connect()


def test_silence_is_told() -> None:
    with sham_robot() as (url, sham):
        driver = RosTrajectory(RosTrajectorySettings(url, joints=JOINTS, silence=0.3))
        try:
            driver.connect()
            sham.talks = False
            assert "/joint_states has been silent for" in str(fault(driver))
        finally:
            driver.close()
