"""Missions: paths, guidance, thrusters, and a vehicle's model that is led along a path against a current."""

from __future__ import annotations

import math
from pathlib import Path as FilePath

import numpy as np
import pytest
from virtualrobot.errors import MalformedFileError, MissingFileError
from virtualrobot_apps.vehicles.autopilot import Autopilot, Gains
from virtualrobot_apps.vehicles.guidance import Follower, Path
from virtualrobot_apps.vehicles.mission import Follow, Hold, Mission, read_mission
from virtualrobot_apps.vehicles.vehicle_file import read
from virtualrobot_plugins.marine.component import FossenDynamics, FossenSettings
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.vehicles import Surroundings

SQUARE = np.array([[0, 0, -2], [6, 0, -2], [6, 4, -2.5], [0, 4, -3.0]], dtype=np.float64)
CURRENT = (0.1, -0.25, 0.0)


def test_a_path_has_its_way_and_its_nearest_point() -> None:
    path = Path.through(np.array([[0, 0, 0], [3, 0, 0], [3, 4, 0]], dtype=np.float64))
    assert path.length == 7.0
    assert path.at(5.0).tolist() == [3.0, 2.0, 0.0]
    assert path.nearest(np.array([2.5, 1.0, 0.0]), 0.0, 7.0) == pytest.approx(4.0)
    # What lies behind is not looked at again.
    assert path.nearest(np.array([1.0, 0.1, 0.0]), 2.0, 4.0) == pytest.approx(2.0)
    with pytest.raises(ValueError, match="points 0 and 1 of the path are the same"):
        Path.through(np.zeros((2, 3)))


def test_guidance_heads_for_a_point_ahead() -> None:
    follower = Follower(Path.through(np.array([[0, 0, 0], [10, 0, 0]], dtype=np.float64)), 0.5, look_ahead=2.0)
    wanted = follower.wanted(np.array([3.0, 2.0, 0.0]), 0.0)
    assert wanted is not None
    assert follower.cross_track == pytest.approx(2.0)
    assert wanted.velocity == pytest.approx(0.5 * np.array([1.0, -1.0, 0.0]) / math.sqrt(2.0))
    assert wanted.heading == pytest.approx(-math.pi / 4)
    follower.way = 9.0
    assert follower.wanted(np.array([9.95, 0.05, 0.0]), 0.0) is None


def test_thrusters_give_the_wrench_that_is_asked_for(rng: np.random.Generator) -> None:
    thrusters = read("bluerov2_heavy").thrusters
    assert thrusters.names[0] == "front_right"
    for _ in range(20):
        wrench = rng.uniform(-1.0, 1.0, 6) * [20, 20, 20, 1, 1, 3]
        speeds = thrusters.speeds(wrench)
        thrusts = [np.interp(speed, of, value) for speed, (of, value) in zip(speeds, thrusters.tables, strict=True)]
        assert thrusters.allocation @ np.array(thrusts) == pytest.approx(wrench, abs=1e-9)
    beyond = thrusters.speeds(np.array([1e4, 0.0, 0.0, 0.0, 0.0, 0.0]))
    assert np.abs(beyond).max() == pytest.approx(3450 * math.pi / 30)


def test_thrusters_are_those_of_the_component() -> None:
    """Drives and places that the client reads are those that the kernel's component has of the same file."""
    from virtualrobot_plugins.marine.parameters import parameters
    from virtualrobot_plugins.marine.vehicle import read_bundled

    own, other = read("bluerov2_heavy"), parameters(read_bundled("bluerov2_heavy"))
    assert own.thrusters.names == tuple(drive.name for drive in other.drives)
    np.testing.assert_allclose(own.thrusters.allocation[:3].T, other.drive[:, :3], atol=1e-7)
    np.testing.assert_allclose(own.thrusters.limits[1], 5.25 * 9.80665, rtol=1e-12)
    np.testing.assert_allclose(own.masses, np.diag(other.mass_matrix), rtol=1e-12)


def sail(
    mission: Mission, gains: Gains, seconds: float, upright: list[float] | None = None
) -> tuple[list[tuple[float, Floats, float]], bool]:
    """Return times, positions and cross-track errors of a mission at 20 Hz, and whether it came to its end.

    Cosines of the angle between the vehicle's upward axis and the vertical are put into `upright`.
    """
    dynamics = FossenDynamics(FossenSettings())
    autopilot = Autopilot(read("bluerov2_heavy"), gains)
    water = Surroundings(CURRENT, surface=0.0)
    pose, twist, states = np.eye(4), np.zeros(6), np.zeros(8)
    pose[2, 3] = -2.0
    log: list[tuple[float, Floats, float]] = []
    for i in range(round(seconds / 0.05)):
        wanted = mission.wanted(0.05 * i, pose[:3, 3].copy(), math.atan2(pose[1, 0], pose[0, 0]))
        if wanted is None:
            return log, True
        log.append((0.05 * i, pose[:3, 3].copy(), mission.cross_track))
        if upright is not None:
            upright.append(float(pose[2, 2]))
        commands = autopilot.speeds(wanted, pose[:3, :3], twist, 0.05)
        pose, twist, states = dynamics.step(pose, twist, states, commands, 0.05, water)
    return log, False


def test_a_vehicle_follows_a_path_against_a_current() -> None:
    mission = Mission([Follow(Path.through(SQUARE), 0.4), Hold(5.0)])
    log, done = sail(mission, Gains(), 120.0)
    assert done
    off = np.array([error for _, _, error in log if not math.isnan(error)])
    assert np.sqrt(np.mean(off**2)) < 0.06
    assert off.max() < 0.2
    assert np.linalg.norm(log[-1][1] - SQUARE[-1]) < 0.15


def test_it_stays_upright_though_munks_moment_would_turn_it_over() -> None:
    """M. M. Munk: (heave's added mass - surge's) u w, at 0.6 m/s of water 4.4 N m a rad against 1.3 of its weight."""
    leaned: dict[float, list[float]] = {0.0: [], Gains().tilt: []}
    for tilt, upright in leaned.items():
        sail(Mission([Follow(Path.through(SQUARE), 0.4), Hold(5.0)]), Gains(tilt=tilt), 120.0, upright)
    assert min(leaned[0.0]) < math.cos(math.radians(30.0))
    assert min(leaned[Gains().tilt]) > math.cos(math.radians(20.0))


def test_without_the_integral_the_current_pushes_it_off() -> None:
    """It doesn't even come to the end: there the current pushes as much as the error asks for."""
    log, done = sail(Mission([Follow(Path.through(SQUARE), 0.4)]), Gains(velocity=2.0, integral=0.0), 90.0)
    assert not done
    assert np.sqrt(np.mean([error**2 for _, _, error in log])) > 0.1


def test_a_mission_is_read_from_its_file(tmp_path: FilePath) -> None:
    file = tmp_path / "mission.yaml"
    file.write_text(
        "schema_version: 1\nsteps:\n- follow: {points: [[0, 0, -2], [4, 0, -2]], speed: 0.4}\n- hold: {seconds: 10}\n"
    )
    follow, hold = read_mission(file)
    assert isinstance(follow, Follow)
    assert (follow.path.length, follow.speed, follow.look_ahead) == (4.0, 0.4, 0.5)
    assert hold == Hold(10.0)


@pytest.mark.parametrize(
    ("steps", "said"),
    [
        ("[]", r"mission.yaml:2: steps: a mission has a step at least"),
        ("[{hold: {seconds: -1}}]", r"steps\[0\].hold.seconds: a number of at least 0 belongs here"),
        ("[{swim: {}}]", r"there is no field 'swim'"),
        ("[{follow: {points: [[0, 0, 0]], speed: 1}}]", r"a path needs two points"),
        ("[{follow: {points: [[0, 0, 0], [1, 0, 0]], speed: 9}}]", r"a number from 0.01 to 5 belongs here, not 9"),
    ],
)
def test_a_wrong_mission_is_refused_with_its_line(steps: str, said: str, tmp_path: FilePath) -> None:
    file = tmp_path / "mission.yaml"
    file.write_text(f"schema_version: 1\nsteps: {steps}\n")
    with pytest.raises(MalformedFileError, match=said):
        read_mission(file)


def test_vehicles_that_are_not_there_are_named(tmp_path: FilePath) -> None:
    with pytest.raises(MissingFileError, match="'nautilus'"):
        read("nautilus")
    file = tmp_path / "boat.yaml"
    file.write_text("name: boat\n")
    with pytest.raises(MalformedFileError, match=r"boat.yaml is no vehicle: KeyError\('axes'\)"):
        read(file)
