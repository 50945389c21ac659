"""Odometry by the client over TCP: round a square, its drift against the true pose, by counts and by wrong wheels."""

from __future__ import annotations

import math

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError, WrongStateError
from virtualrobot.robots.robot import Robot

SQUARE = [[2.0, 0.0, 0.0], [0.0, 0.0, math.pi / 2.0]] * 4
"""A square of 2 m, with turns on the spot."""

DRIFTS = {8: 0.138, 64: 0.0052, 360: 0.0003}
"""Distance (m) from the true end by counts a turn: wheels of 50 mm, 240 mm apart, reckoned each 4 ms."""


@pytest.fixture
def ugv(client: Client) -> Robot:
    """Return a craft in a world whose time goes on by steps."""
    client.clock.set_stepped()
    return client.load_robot("model://ugv", base="planar")


@pytest.mark.long
def test_a_wheel_that_is_thought_larger_leads_218_millimeters_astray(client: Client, ugv: Robot) -> None:
    """Round the square without counts: what is wrong is the radius alone, 0.5 % of the left wheel."""
    wrong = {"wheel_radius_meters": 0.05 * 1.005, "right_wheel_radius_meters": 0.05}
    exact, larger = ugv.odometry(), ugv.odometry(settings=wrong)
    ugv.drive_path(SQUARE, wait=False)
    for _ in range(2000):
        client.clock.step(10)
        exact.update()
        larger.update()
        if not client.robot("ugv").state.motion_ids:
            break
    np.testing.assert_allclose(exact.drift(), np.zeros(3), atol=1e-6)
    off = larger.drift()
    assert np.hypot(*off[:2]) == pytest.approx(0.218, abs=0.002)
    assert math.degrees(off[2]) == pytest.approx(-8.6, abs=0.1)
    assert exact.reading.pose[2] == pytest.approx(math.tau)


def test_encoders_are_counted_and_what_they_lack_is_named(client: Client, ugv: Robot) -> None:
    odometry = ugv.odometry(counts_per_turn=8, variance_per_radian=1e-3)
    ugv.drive_path([[0.4, 0.0, 0.0]], wait=False)
    client.clock.step(1500)
    reading = odometry.update()
    # 0.4 m are 8 rad of the wheels, 10.19 counts: ten are seen.
    np.testing.assert_allclose(reading.pose, [10.0 * math.tau / 8.0 * 0.05, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(odometry.drift(), [10.0 * math.tau / 8.0 * 0.05 - 0.4, 0.0, 0.0], atol=1e-6)
    assert 0.0 < reading.covariance[0, 0] < reading.covariance[2, 2]
    told = client.sensors["ugv.encoders"].read().value
    assert isinstance(told, virtualrobot.EncoderReading)
    by_sensor = ugv.odometry(encoders=told)
    ugv.drive_path([[0.4, 0.0, 0.0]], wait=False)
    client.clock.step(1500)
    now = client.sensors["ugv.encoders"].read().value
    assert by_sensor.update(now).pose[0] == pytest.approx(0.8, abs=0.05 * math.tau / 1920)
    wrong = virtualrobot.EncoderReading(("left_wheel",), now.positions[:1], now.velocities[:1])
    with pytest.raises(
        InvalidArgumentError, match=r"don't tell the drive 'right_wheel' of 'ugv'; they tell left_wheel"
    ):
        by_sensor.update(wrong)
    with pytest.raises(InvalidArgumentError, match="counts_per_turn is 1 or above, not 0"):
        ugv.odometry(counts_per_turn=0)
    with pytest.raises(InvalidArgumentError, match="right_wheel_radius_meters"):
        ugv.odometry(settings={"right_wheel_radius_meters": -1.0})
    with pytest.raises(InvalidArgumentError, match="there is no setting 'wheel_radius'; did you mean 'wheel_radius_m"):
        ugv.odometry(settings={"wheel_radius": 0.1})
    arm = client.load_robot("model://puma560", pose=virtualrobot.pose(y=3.0))
    with pytest.raises(WrongStateError, match="is no craft"):
        arm.odometry()


def test_many_readings_are_reckoned_at_once_to_the_same_bits(client: Client, ugv: Robot) -> None:
    begun = client.sensors["ugv.encoders"].read().value
    one_by_one, at_once = (ugv.odometry(encoders=begun, variance_per_radian=1e-3) for _ in range(2))
    ugv.drive_path([[0.4, 0.0, 0.3]], wait=False)
    readings, poses = [], []
    for _ in range(8):
        client.clock.step(100)
        readings.append(client.sensors["ugv.encoders"].read().value)
        poses.append(one_by_one.update(readings[-1]).pose)
    assert np.ptp(np.array(poses)[:, 0]) > 0.05
    assert at_once.reckon(readings[:3]).tolist() == np.array(poses[:3]).tolist()
    assert at_once.reckon([]).shape == (0, 3)
    assert at_once.reckon(readings[3:]).tolist() == np.array(poses[3:]).tolist()
    assert at_once.reading.covariance.tolist() == one_by_one.reading.covariance.tolist()
    with pytest.raises(InvalidArgumentError, match="positions have 1 to 10000 rows, not 10001"):
        at_once.reckon(readings[:1] * 10_000)


@pytest.mark.long
def test_whole_counts_drift_round_a_square(client: Client, ugv: Robot) -> None:
    """As the same square driven at even speeds: of the same size, since where counts fall depends on the speeds."""
    by_counts = {counts: ugv.odometry(counts_per_turn=counts) for counts in DRIFTS}
    ugv.drive_path(SQUARE, wait=False)
    while client.robot("ugv").state.motion_ids:
        client.clock.step(1)
        for odometry in by_counts.values():
            odometry.update()
    for counts, odometry in by_counts.items():
        assert float(np.hypot(*odometry.drift()[:2])) < 3.0 * DRIFTS[counts]
