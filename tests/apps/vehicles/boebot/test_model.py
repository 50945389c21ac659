"""The Boe-Bot's model: it drives, its devices measure what stands around it, and its wheels are counted."""

from __future__ import annotations

import math

import numpy as np
import pytest
import virtualrobot

RADIUS, TRACK = 0.0325, 0.116


@pytest.fixture
def client(steps: virtualrobot.Client) -> virtualrobot.Client:
    """Return a client of a kernel with a Boe-Bot at the origin, and walls around it."""
    steps.load_robot("model://boebot", base="planar")
    for name, x, y in (("ahead", 0.74, 0.0), ("left", 0.0, 0.44), ("right", 0.0, -0.54)):
        size = (0.1, 1.0, 0.5) if name == "ahead" else (1.0, 0.1, 0.5)
        place = virtualrobot.pose(x + 0.05 * (name == "ahead"), y + 0.05 * np.sign(y), 0.25)
        steps.scene.add_object(name, virtualrobot.box(*size), pose=place)
    return steps


def test_sonars_and_laser_measure_the_walls(client: virtualrobot.Client) -> None:
    """Walls are 0.7, 0.4 and 0.5 m before the sonars. HC-SR04: 3 mm steps; sound is 1% faster than it takes it for."""
    for side, distance in (("front", 0.70), ("left", 0.40), ("right", 0.50)):
        reading = client.sensors[f"boebot.sonar_{side}"].read().range
        assert reading.valid.all()
        assert float(reading.distances[0, 0]) == pytest.approx(distance, abs=0.015)
    scan = client.sensors["boebot.laser"].read().range
    assert scan.distances.shape == (1, 10)
    # The beams are 36 degrees wide in all; steps of 1 cm, deviation 1 cm.
    expected = (0.74 - 0.0114) / np.cos(np.linspace(-0.314159, 0.314159, 10))
    np.testing.assert_allclose(scan.distances[0], expected, atol=0.05)


def test_its_camera_looks_at_the_floor_ahead(client: virtualrobot.Client) -> None:
    """It is 54.8 mm high and looks 60 degrees down, so that the middle of the picture is 63 mm away."""
    client.scene.add_object("floor", virtualrobot.box(4.0, 4.0, 0.1), pose=virtualrobot.pose(z=-0.05))
    seen = client.sensors["boebot.camera"].read(images=["color", "depth", "segmentation"]).camera
    assert seen.color is not None and seen.depth is not None and seen.segmentation is not None
    assert seen.color.shape == (480, 640, 3)
    assert float(seen.depth[240, 320]) == pytest.approx(0.0548 / math.sin(math.pi / 3), abs=1e-3)
    assert seen.camera_matrix[0, 0] == pytest.approx(320.0 / math.tan(0.5 * 1.3962634))
    assert seen.mask("floor")[: 3 * 480 // 4].all()


def test_it_drives_straight_and_its_wheels_are_counted(client: virtualrobot.Client) -> None:
    with client.robot("boebot").stream_twist(timeout=5.0) as stream:
        stream.send((0.1, 0.0, 0.0), wait=True)
        client.clock.step(250)
        stream.send((0.0, 0.0, 0.0), wait=True)
        state = client.clock.step(75).robots["boebot"]
        stream.cancel()
    # What it lacks as it gathers speed it goes on as it brakes: 1 s of 0.1 m/s.
    assert state.positions[0] == pytest.approx(0.1, abs=1e-6)
    assert state.positions[-2:] == pytest.approx(0.1 / RADIUS, abs=1e-5)
    counts = client.sensors["boebot.encoders"].read().value.positions
    assert counts == pytest.approx(np.round(0.1 / RADIUS * 64 / math.tau) * math.tau / 64, abs=1e-9)


def test_it_is_as_heavy_as_the_model_of_the_document(client: virtualrobot.Client) -> None:
    """The links of boebot.xacro are 0.984 kg in all; the servos of Parallax' data sheet turn 50 rpm at most."""
    links = [client.scene.node(name)._message.link for name in client.robot("boebot").links]
    assert sum(link.inertial.mass_kilograms for link in links) == pytest.approx(0.984, abs=1e-3)
    assert client.robot("boebot").limits["left_wheel"].velocity == pytest.approx(50.0 * math.tau / 60.0, abs=1e-3)


def test_a_speed_beyond_its_servos_is_refused(client: virtualrobot.Client) -> None:
    """50 rpm on wheels of 65 mm are 0.170 m/s."""
    with (
        pytest.raises(virtualrobot.LimitError, match="wheel"),
        client.robot("boebot").stream_twist() as stream,
    ):
        stream.send((0.18, 0.0, 0.0), wait=True)
        client.clock.step(1)
        stream.send((0.18, 0.0, 0.0), wait=True)
