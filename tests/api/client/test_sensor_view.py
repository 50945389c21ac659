"""What viewers show of sensors, from Python and from the command line."""

from __future__ import annotations

import pytest
import virtualrobot
from virtualrobot import Client
from virtualrobot.view.state import SensorOverlay

from tests.api.client.conftest import Run


@pytest.fixture
def sensors(client: Client) -> Client:
    """Return a client of a world with a lidar and a camera, of which nothing is shown."""
    client.scene.add_range_sensor("lidar")
    client.scene.add_camera("eye")
    client.view.hide_sensor()
    return client


def test_one_sensor_is_shown_and_hidden_beside_others(sensors: Client) -> None:
    view = sensors.view
    view.show_sensor("lidar")
    view.show_sensor("eye", image=False)
    shown = {
        "lidar": SensorOverlay(points=True, rays=False, color_by="distance", frustum=True, image=True),
        "eye": SensorOverlay(points=True, rays=False, color_by="distance", frustum=True, image=False),
    }
    assert view.sensors == shown
    view.show_sensor("lidar", points=False, rays=True, color_by="intensity", frustum=False, image=False)
    assert view.sensors["lidar"] == SensorOverlay(False, True, "intensity", False, False)
    assert view.sensors["eye"] == shown["eye"]
    view.hide_sensor("lidar", "not shown")
    assert list(view.sensors) == ["eye"]
    view.hide_sensor()
    assert not view.sensors


def test_what_cannot_be_shown_is_refused(sensors: Client) -> None:
    with pytest.raises(virtualrobot.UnknownNameError, match="no sensor named 'radar'"):
        sensors.view.show_sensor("radar")
    with pytest.raises(virtualrobot.InvalidArgumentError, match="give distance or intensity"):
        sensors.view.show_sensor("lidar", color_by="height")
    assert not sensors.view.sensors


def test_the_command_line(run: Run, sensors: Client) -> None:
    run("sensor", "show", "lidar")
    assert sensors.view.sensors["lidar"].points and not sensors.view.sensors["lidar"].rays
    run("sensor", "show", "lidar", "--rays", "--by", "intensity")
    lidar = sensors.view.sensors["lidar"]
    assert (lidar.rays, lidar.points, lidar.color_by) == (True, False, "intensity")
    run("sensor", "show", "eye", "--frustum")
    assert (sensors.view.sensors["eye"].frustum, sensors.view.sensors["eye"].image) == (True, False)
    run("sensor", "hide", "lidar")
    assert list(sensors.view.sensors) == ["eye"]
    run("sensor", "hide")
    assert not sensors.view.sensors
    assert "'radar'" in run("sensor", "show", "radar", code=1)
    assert "give --points or --rays" in run("sensor", "show", "lidar", "--image", code=2)
    sensors.scene.add_motion_sensor("imu", virtualrobot.imu(), parent="lidar")
    assert "'imu' is a motion_sensor" in run("sensor", "show", "imu", code=2)
