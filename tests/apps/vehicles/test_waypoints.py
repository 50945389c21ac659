"""Waypoints: what the controllers say, and that a UGV gets to each of them within the limits of the document."""

from __future__ import annotations

import math
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot.cli import cli
from virtualrobot_apps.vehicles import room, ugv
from virtualrobot_apps.vehicles.waypoints import CONTROLLERS, FASTEST, PERIOD, QUICKEST, Gains, Waypoints, square

from tests.kernels import KernelProcess


def rolled(waypoints: Waypoints, seconds: float = 60.0) -> np.ndarray:
    """Return the places (n, 2) of a vehicle that does at once what it is told, on exact arcs."""
    x = y = heading = 0.0
    places = []
    for number in range(round(seconds / PERIOD)):
        twist = waypoints.twist((x, y), heading, PERIOD * number)
        places.append((x, y))
        if twist is None:
            break
        speed, turning = twist
        assert abs(speed) <= FASTEST
        assert abs(turning) <= QUICKEST
        half = 0.5 * PERIOD * turning
        chord = PERIOD * speed * np.sinc(half / np.pi)
        x, y, heading = x + chord * math.cos(heading + half), y + chord * math.sin(heading + half), heading + 2.0 * half
    return np.array(places)


@pytest.mark.parametrize("name", CONTROLLERS)
def test_each_waypoint_is_reached_within_the_limits(name: str, rng: np.random.Generator) -> None:
    points = [*square(2.0), *rng.uniform(-3.0, 3.0, (3, 2))]
    waypoints = Waypoints(points, CONTROLLERS[name])
    places = rolled(waypoints)
    assert waypoints.done
    assert waypoints.reached == sorted(waypoints.reached)
    for point in points:
        assert np.linalg.norm(places - np.array(point), axis=1).min() < 0.1
    # It would take 16 s at least for the square's lines at the greatest speed, and 4.7 s for three right angles.
    assert 18.0 < waypoints.reached[3] < 24.0


def test_what_the_gains_do() -> None:
    ahead = Waypoints([(2.0, 0.0)], Gains(2.0, 0.0))
    assert ahead.twist((0.0, 0.0), -0.2, 0.0) == pytest.approx((0.5 * math.cos(0.2), 0.4))
    assert ahead.twist((0.0, 0.5), 0.0, 0.05) == pytest.approx(
        (0.5 * math.cos(math.atan2(0.5, 2.0)), -0.48996), abs=1e-4
    )
    assert ahead.cross_track == pytest.approx(0.5)
    assert ahead.twist((0.0, 0.0), math.pi / 2, 0.1) == (0.0, -QUICKEST)  # on the spot, as fast as it may
    summed = Waypoints([(2.0, 0.0)], Gains(0.0, 1.0))
    summed.twist((0.0, 0.0), -0.2, 0.0)
    assert summed.twist((0.0, 0.0), -0.2, 0.5) == pytest.approx((0.5 * math.cos(0.2), 0.2 * 0.5))
    changing = Waypoints([(2.0, 0.0)], Gains(0.0, 0.0, 0.5))
    changing.twist((0.0, 0.0), -0.2, 0.0)
    assert changing.twist((0.0, 0.0), -0.1, 0.5) == pytest.approx((0.5 * math.cos(0.1), 0.5 * -0.1 / 0.5))
    assert Waypoints([(0.05, 0.0)], Gains(1.0, 0.0)).twist((0.0, 0.0), 0.0, 0.0) is None
    with pytest.raises(ValueError, match="waypoints are pairs of finite numbers, one at least, not"):
        Waypoints([], Gains(1.0, 0.0))


def test_a_ugv_reaches_its_waypoint_in_a_kernel(steps: virtualrobot.Client) -> None:
    ugv.build(steps, [(0.6, 0.0)])
    record = ugv.drive(steps, Waypoints([(0.6, 0.0)], CONTROLLERS["PI"]))
    assert len(record.reached) == 1
    # It rests, gathers speed by 2 m/s^2 at the most of its wheels, and goes on at 0.5 m/s.
    assert 1.0 <= record.times[-1] <= 1.4
    assert record.poses[-1][:2] == pytest.approx([0.51, 0.0], abs=0.015)
    assert np.diff(record.times) == pytest.approx(PERIOD, abs=0.0041)
    assert record.times[20] == pytest.approx(20 * PERIOD, abs=0.0041)


@pytest.mark.long
def test_the_demo_drives_the_square_and_tells_its_numbers(stepped_kernel: KernelProcess, tmp_path: Path) -> None:
    plot = tmp_path / "ugv.svg"
    result = CliRunner().invoke(
        cli, ["demo", "ugv", "--address", stepped_kernel.address, "--plot", str(plot), "--headless"]
    )
    assert result.exit_code == 0, result.output
    assert "PI   4 of 4 waypoints in 2" in result.output
    assert "PID  4 of 4 waypoints in 2" in result.output
    assert ElementTree.parse(plot).getroot().tag.endswith("svg")


@pytest.mark.long
@pytest.mark.parametrize("engine", ["mujoco", "bullet"])
def test_a_ugv_on_wheels_and_caster_reaches_its_waypoints_by_forces(steps: virtualrobot.Client, engine: str) -> None:
    points = [(0.6, 0.0), (0.6, 0.6)]
    for name, gains in CONTROLLERS.items():
        ugv.build(steps, points, engine)
        record = ugv.drive(steps, Waypoints(points, gains))
        assert len(record.reached) == 2, name
        for point in points:
            assert np.linalg.norm(record.poses[:, :2] - np.array(point), axis=1).min() < 0.1
        # Within the limits of the document: what is told, and what it truly does but for a wheel's overshoot.
        assert np.abs(record.twists).max(axis=0) == pytest.approx([FASTEST, QUICKEST], rel=0.02)
        speeds = np.linalg.norm(np.diff(record.poses[:, :2], axis=0), axis=1) / np.diff(record.times)
        assert speeds.max() < 1.1 * FASTEST
        assert np.diff(record.times) == pytest.approx(PERIOD, abs=0.0041)
        assert steps.physics.status.fault == ""


@pytest.mark.long
def test_the_demo_drives_the_square_by_forces(stepped_kernel: KernelProcess) -> None:
    engine = "bullet"
    arguments = ["demo", "ugv", "--physics", engine, "--address", stepped_kernel.address, "--headless"]
    result = CliRunner().invoke(cli, arguments)
    assert result.exit_code == 0, result.output
    assert f"UGV by {engine}, square of 2 m" in result.output
    # Tried before with both engines: 21.4 s by PI, 21.6 s by PID.
    assert "PI   4 of 4 waypoints in 2" in result.output
    assert "PID  4 of 4 waypoints in 2" in result.output


@pytest.mark.long
def test_the_demo_drives_through_a_furnished_room(stepped_kernel: KernelProcess) -> None:
    arguments = ["demo", "ugv", "--room", "--address", stepped_kernel.address, "--headless"]
    result = CliRunner().invoke(cli, arguments)
    assert result.exit_code == 0, result.output
    found = re.findall(r"4 of 4 waypoints in .* (\d+) mm from furniture at least", result.output)
    assert len(found) == 2 and all(int(one) > 200 for one in found), result.output


def test_a_lidar_sees_the_walls_of_the_room(steps: virtualrobot.Client) -> None:
    """From the origin the walls behind and to the right are as far as the room says, the cupboard farther ahead."""
    ugv.build(steps, list(room.ROUTE))
    room.furnish(steps)
    lidar = steps.scene.pose("ugv.lidar")[:3, 3]
    points = steps.sensors["ugv.lidar"].read(points=True, frame="world").range.points
    assert points is not None
    flat = points.reshape(-1, 3)
    flat = flat[np.isfinite(flat).all(axis=1)]
    bearing = np.arctan2(flat[:, 1] - lidar[1], flat[:, 0] - lidar[0])
    behind, right = (flat[np.abs(np.abs(bearing) - np.pi) < 0.05], flat[np.abs(bearing + 0.5 * np.pi) < 0.05])
    # The LDS-01's noise is 10 mm and more up to 3.5 m.
    assert behind[:, 0] == pytest.approx(room.LOW[0], abs=0.08) and len(behind)
    assert right[:, 1] == pytest.approx(room.LOW[1], abs=0.08) and len(right)


def test_a_room_has_no_side(stepped_kernel: KernelProcess) -> None:
    result = CliRunner().invoke(cli, ["demo", "ugv", "--room", "--side", "3", "--address", stepped_kernel.address])
    assert result.exit_code == 2 and "--side is of the square" in result.output
