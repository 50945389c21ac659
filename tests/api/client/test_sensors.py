"""Sensors from Python and from the command line, on a real kernel."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client

from tests.api.client.conftest import Run

FAN = virtualrobot.fan(3, -0.1, 0.1)
PATTERNS = {
    "beam": (None, (1, 1)),
    "fan": (FAN, (1, 3)),
    "spinning": (virtualrobot.spinning(12, [-0.1, 0.0]), (2, 12)),
    "raster": (virtualrobot.raster(4, 3, 0.2, 0.1), (3, 4)),
    "ring": (virtualrobot.ring(5, 0.1, -1.0, 1.0), (1, 5)),
    "free": (virtualrobot.beams([[2, 0, 0], [1, 0, 0.1]], [[0, 0, 0], [0, 0, 0.1]]), (1, 2)),
}


@pytest.fixture
def lidar(client: Client) -> virtualrobot.Sensor:
    """Return a scanner in front of a sphere of 0.5 m, 2 m away, in a world whose time goes on by steps."""
    client.clock.set_stepped()
    client.scene.add_object("ball", virtualrobot.sphere(0.5), pose=virtualrobot.pose(2.0))
    client.scene.add_range_sensor("lidar", virtualrobot.range_sensor(pattern=FAN))
    return client.sensors["lidar"]


def test_a_reading_has_arrays(lidar: virtualrobot.Sensor) -> None:
    reading = lidar.read(points=True, frame="world", intensities=True, elements=True)
    scan = reading.range
    assert scan.distances[0, 1] == pytest.approx(1.5)
    assert scan.valid.all() and scan.valid.dtype == np.bool_
    assert scan.mask("ball").all()
    np.testing.assert_allclose(np.linalg.norm(scan.points[0] - [2, 0, 0], axis=1), 0.5, atol=1e-6)  # pyright: ignore
    assert (scan.frame, reading.number, reading.state) == ("world", 1, "stopped")
    assert lidar.read().range.points is None
    with pytest.raises(virtualrobot.InvalidArgumentError, match="no frame"):
        lidar.read(frame="wrold")


def test_a_sensor_that_is_not_there_is_told_with_those_that_are(client: Client) -> None:
    with pytest.raises(virtualrobot.UnknownNameError, match="no sensor named 'lidar'; there is none yet"):
        client.sensors["lidar"]
    with client.scene.batch() as batch:
        for number in range(10):
            batch.add_range_sensor(f"lidar{number}", virtualrobot.range_sensor())
    with pytest.raises(virtualrobot.UnknownNameError, match=r"'lidar0', .* and 2 more$"):
        client.sensors["camera"]
    with pytest.raises(virtualrobot.UnknownNameError, match="did you mean 'lidar7'"):
        client.sensors["lidar-7"]


@pytest.mark.parametrize("name", PATTERNS)
def test_every_pattern_has_its_shape(client: Client, lidar: virtualrobot.Sensor, name: str) -> None:
    pattern, shape = PATTERNS[name]
    client.scene.add_range_sensor("other", virtualrobot.range_sensor(pattern=pattern))
    scan = client.sensors["other"].read(points=True).range
    assert scan.distances.shape == shape
    assert scan.points is not None and scan.points.shape == (*shape, 3)
    if name != "ring":
        assert scan.distances[np.isfinite(scan.distances)].min() == pytest.approx(1.5, abs=0.01)


def test_every_preset_reads(client: Client, lidar: virtualrobot.Sensor) -> None:
    presets = client.sensors.presets()
    assert "LDS-01" in presets
    for name in presets:
        client.scene.add_range_sensor(name, virtualrobot.range_sensor(name, seed=1))
        scan = client.sensors[name].read().range
        assert scan.distances.size > 0
    assert client.sensors["VLP-16"].read().range.distances.shape == (16, 1800)


def test_sensors_are_watched_started_and_stopped(client: Client, lidar: virtualrobot.Sensor) -> None:
    assert list(client.sensors) == ["lidar"]
    lidar.start()
    client.clock.step(25)
    with_points = lidar.watch(points=True)
    first = next(with_points)
    assert (first.state, first.number, first.stamp.simulation_time > 0) == ("running", 1, True)
    client.clock.step(50)
    assert next(one.number for one in with_points if one.number > 2) == 3
    assert (lidar.status.state, lidar.status.readings, lidar.status.rate) == ("running", 3, 10.0)
    lidar.stop()
    last = next(one for one in with_points if one.state != "running")
    assert (last.state, last.value) == ("stopped", None)
    with pytest.raises(TypeError, match="no distances"):
        _ = last.range
    with_points.close()  # pyright: ignore[reportAttributeAccessIssue] a generator
    with pytest.raises(virtualrobot.UnknownNameError, match="'lidar'"):
        client.sensors["lidra"]


def test_components_are_swapped_while_the_sensor_runs(client: Client, lidar: virtualrobot.Sensor) -> None:
    lidar.start()
    client.clock.step(25)
    trial = lidar.set_model("laser", {"divergence_radians": [0.01, 0.01], "rays": 7})
    assert trial.rays == 21
    assert lidar.set_ray_caster("reference").rays == 21
    client.clock.step(50)
    assert lidar.status.readings == 3  # it goes on to count
    assert lidar.read().range.distances[0, 1] == pytest.approx(1.5, abs=0.1)
    uses = {component.name: component.uses for component in client.plugins.components("ray_caster")}
    (use,) = (use for use in uses["reference"] if use.sensor)  # calls that cast rays may have one of their own
    assert (use.sensor, use.process_id > 0) == ("lidar", True)
    assert lidar.set_model("laser").rays == 3  # without settings it has its own
    for name, settings in (("lsaer", {}), ("laser", {"rays": 0})):
        with pytest.raises(virtualrobot.VirtualRobotError):
            lidar.set_model(name, settings)
    assert lidar.status.state == "running"


def test_the_command_line(run: Run, client: Client, lidar: virtualrobot.Sensor, tmp_path: Path) -> None:
    assert re.match(r"lidar  range_sensor  stopped  10 Hz\n", run("sensor"))
    run("sensor", "start", "lidar")
    client.clock.step(25)
    assert "running  10 Hz  1 reading of" in run("sensor")
    shown = run("sensor", "read", "lidar")
    assert re.search(r"lidar  1  1 x 3 beams, 3 echoes from 1\.500 m to 1\.5\d\d m\n +3 beams on ball", shown)
    for ending in (".npz", ".csv", ".ply"):
        run("sensor", "read", "lidar", "--frame", "world", "--out", str(tmp_path / f"scan{ending}"))
    with np.load(tmp_path / "scan.npz") as saved:
        points = saved["points"][saved["valid"]]
    table = np.loadtxt(tmp_path / "scan.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(table[:, :3], points, rtol=1e-5, atol=1e-6)
    ply = (tmp_path / "scan.ply").read_text().splitlines()
    np.testing.assert_allclose(np.loadtxt(ply[ply.index("end_header") + 1 :]), table)
    assert "lidar  1  1 x 3 beams" in run("sensor", "watch", "lidar", "--count", "1")
    assert "21 rays" in run(
        "sensor", "set", "lidar", "--model", "laser", "--set", "divergence_radians=[0.01, 0.01]", "--set", "rays=7"
    )
    run("sensor", "stop")
    assert "stopped" in run("sensor")
    assert "LDS-01" in run("sensor", "presets")
    assert "no sensor named 'radar'" in run("sensor", "read", "radar", code=1)
    assert "--out ends with .npz or .ply or .csv" in run("sensor", "read", "lidar", "--out", "scan.xyz", code=2)
    assert "--kind is for cameras" in run("sensor", "read", "lidar", "--kind", "depth", code=2)


def test_one_echo_is_told_in_the_singular(run: Run, client: Client) -> None:
    client.scene.add_object("ball", virtualrobot.sphere(0.5), pose=virtualrobot.pose(2.0))
    client.scene.add_range_sensor("ahead")
    assert re.search(r"ahead  1  1 beam, 1 echo from 1\.500 m\n +1 beam on ball", run("sensor", "read", "ahead"))


def test_a_scanner_from_a_urdf_file_looks_out_of_its_housing(client: Client) -> None:
    """The racecar of pybullet_data has a Hokuyo inside the mesh of its link; a wall stands 2 m ahead of the car."""
    client.clock.set_stepped()
    client.load_robot("package://pybullet_data/racecar/racecar.urdf", name="car")
    client.scene.add_object("wall", virtualrobot.box(0.1, 4.0, 2.0), pose=virtualrobot.pose(2.05))
    reading = client.sensors["car.hokuyo_sensor"].read(elements=True)
    ahead = reading.range.distances[0, 540]
    assert reading.range.element_names[int(reading.range.elements[0, 540])] == "wall"  # pyright: ignore
    # Its noise is 1 cm, its steps too.
    assert ahead == pytest.approx(2.0 - reading.world_t_sensor[0, 3], abs=0.07)
    client.sensors.start()
    client.clock.step(25)
    assert {one.state for one in client.sensors.statuses()} == {"running"}
