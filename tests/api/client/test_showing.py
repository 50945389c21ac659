"""Objects at a prompt, and what they show."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot

from tests.kernels import KernelProcess

MOST_LINES = 5
MOST_LETTERS = 600


def handles(client: Client) -> Iterator[object]:
    """Yield what a client leads to by one or two dots."""
    yield client
    yield client.services
    for name, first in vars(client).items():
        if not name.startswith("_"):
            yield first
            yield from (second for name, second in getattr(first, "__dict__", {}).items() if not name.startswith("_"))


def check(one: object) -> None:
    """Check what an object of this library shows."""
    shown = repr(one)
    assert " object at 0x" not in shown, f"{type(one)} shows {shown}"
    assert 0 < len(shown.splitlines()) <= MOST_LINES, shown
    assert len(shown) <= MOST_LETTERS, shown


def test_everything_that_a_client_leads_to_shows_itself(client: Client, iiwa: Robot) -> None:
    every = [one for one in handles(client) if type(one).__module__.startswith("virtualrobot")]
    assert len({type(one) for one in every}) >= 13
    for one in every:
        check(one)


def test_a_line_says_what_is_worth_knowing(client: Client, iiwa: Robot) -> None:
    client.scene.add_range_sensor("lidar")
    client.signals.create("part", True)
    client.collisions.set("monitor", robots={"iiwa": "guard"}, look_ahead=1.0)
    client.view.joint_axes = ["iiwa"]
    client.clock.set_stepped()
    seconds = client.clock.simulation_time
    assert repr(client.clock) == f"<Clock: stepped, {seconds:.3f} s, goes on by step(), ticks of 4 ms>"
    assert repr(client.sensors) == "<Sensors: 'lidar' (range_sensor, stopped)>"
    assert repr(client.sensors["lidar"]) == "<Sensor 'lidar': stopped>"
    assert repr(client.signals) == "<Signals: 'part' = True>"
    assert repr(client.collisions) == "<Collisions: mode monitor, 'iiwa' guard, looks 1 s ahead>"
    assert repr(client.collisions.allowed) == f"<AllowedPairs: {len(client.collisions.allowed.list())} pairs may touch>"
    assert repr(client.view) == "<View: 0 browsers; joint axes of 1>"
    assert "RRTConnect" in repr(client.paths)
    with client.scene.batch() as batch:
        batch.add_part("box", virtualrobot.box(0.1, 0.1, 0.1), pose=virtualrobot.pose(x=3.0))
        batch.hide("box")
        assert repr(batch) == "<Batch of 2 changes: create_node, update_node>"


def test_a_handle_that_cannot_ask_shows_why(kernel: KernelProcess, iiwa: Robot) -> None:
    with virtualrobot.connect(kernel.address) as other:
        arm = other.robot("iiwa")
    for one in (other, other.sensors, other.signals, other.view, other.collisions, other.scene, other.robots, arm):
        check(one)
    assert repr(other.clock) == "<Clock: this client is closed: connect again>"


def test_what_is_told_is_short_however_much_it_holds(client: Client, iiwa: Robot) -> None:
    client.scene.add_object("wall", virtualrobot.box(0.1, 4.0, 2.0), pose=virtualrobot.pose(2.0))
    settings = virtualrobot.range_sensor(pattern=virtualrobot.fan(720, -1.0, 1.0))
    client.scene.add_range_sensor("lidar", settings, pose=virtualrobot.pose(z=0.5))
    client.scene.add_camera("eye", virtualrobot.camera(64, 48), pose=virtualrobot.looking_at([2, 2, 1], [0, 0, 0.5]))
    client.signals.create("part")
    cloud = client.view.add_points(np.zeros((10_000, 3)))
    lidar, eye = client.sensors["lidar"], client.sensors["eye"]
    goal = iiwa.positions + 0.1
    for one in (
        lidar.read(points=True),
        lidar.read(elements=True).range,
        eye.read(images=["color", "depth"]),
        eye.read().camera,
        client.view.capture(),
        client.view.read(),
        client.view.pick(640, 360),
        iiwa.state,
        iiwa.solve_inverse(iiwa.tcp),
        iiwa.solve_forward(),
        iiwa.solve_jacobian(),
        iiwa.solve_inverse_dynamics(),
        iiwa.plan(iiwa.ptp(goal)),
        iiwa.plan(iiwa.ptp(goal)).robots["iiwa"],
        iiwa.check(iiwa.ptp(goal)),
        iiwa.ptp(goal),
        client.program().move(iiwa.ptp(goal)),
        client.collisions.check(),
        client.collisions.distance("iiwa"),
        client.collisions.settings,
        client.rays.cast([0, 0, 1], np.ones((1000, 3))),
        client.clock.read(),
        client.clock.read().stamp,
        next(client.scene.watch()),
        cloud.info,
        cloud.figures[0],
        settings,
        iiwa.postures,
        client.models("ur10e")[0],
        client.plugins.list()[0],
        client.signals.read()[0],
        iiwa.group(tip=iiwa.links[3]),
    ):
        check(one)


def test_pictures_and_tables_are_shown_in_notebooks(client: Client, iiwa: Robot) -> None:
    client.scene.add_camera("eye", virtualrobot.camera(8, 6), pose=virtualrobot.looking_at([2, 2, 1], [0, 0, 0.5]))
    client.signals.create("pressure", 5.5, unit="bar", description="of the line")
    picture = client.view.capture(size=(8, 6))
    assert picture._repr_png_() == picture.image and picture._repr_jpeg_() is None
    raw = client.view.capture(size=(8, 6), format="raw")
    for own, pixels in ((raw, raw.pixels), (eye := client.sensors["eye"].read(), eye.camera.color)):
        png = own._repr_png_()
        assert png is not None
        decoded = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
        assert decoded is not None and pixels is not None
        np.testing.assert_array_equal(decoded[..., ::-1], pixels)
    assert client.view.capture(size=(8, 6), format="jpeg")._repr_jpeg_() is not None
    assert "<td>lbr_iiwa_joint_1</td>" in iiwa._repr_html_() and "<td>rad, rad/s</td>" in iiwa._repr_html_()
    assert "<td>5.5</td><td>bar</td>" in client.signals._repr_html_()
    assert "no viewer: start it without" in client.view._repr_html_()
    assert "<td>eye</td><td>camera_sensor</td>" in client.sensors._repr_html_()
    assert "<td>kinematics</td>" in client.plugins._repr_html_()
    assert "<td>iiwa</td><td>7</td>" in client.robots._repr_html_()


def test_a_check_names_its_pairs(client: Client) -> None:
    client.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="arm")
    client.scene.add_object("wall", virtualrobot.box(0.3, 0.3, 0.3), pose=virtualrobot.pose(z=0.8))
    found = client.collisions.check()
    assert found.pairs and f"{found.pairs[0].first!r} touches {found.pairs[0].second!r}" in repr(found)
    check(found)


def test_names_complete(client: Client, iiwa: Robot) -> None:
    client.scene.add_range_sensor("lidar")
    client.signals.create("part")
    iiwa.postures.add("home")
    for one, name in (
        (client.robots, "iiwa"),
        (client.scene, "lidar"),
        (client.sensors, "lidar"),
        (client.signals, "part"),
        (iiwa.postures, "home"),
    ):
        completed = one._ipython_key_completions_()
        assert name in completed and name in one and "nothing" not in one
        for each in completed:
            one[each]
        with pytest.raises(virtualrobot.UnknownNameError):
            one["nothing"]
    assert [robot.name for robot in client.robots()] == list(client.robots) == ["iiwa"]
    assert repr(client.robots) == "<Robots: 'iiwa'>"
    assert repr(client.scene) == "<Scene: 1 robot, 1 range_sensor>"


def test_positions_that_are_told_are_read_only(iiwa: Robot) -> None:
    for told in (iiwa.positions, iiwa.group(tip=iiwa.links[3]).positions, iiwa.positions[:3]):
        with pytest.raises(virtualrobot.InvalidArgumentError, match="set_positions puts joints elsewhere"):
            told[0] = 1.0
        with pytest.raises(virtualrobot.InvalidArgumentError, match="an array to compute with"):
            told += 0.1
    here = iiwa.positions
    for own in (here.copy(), here + 0.0, np.array(here), np.cos(here), here.tolist()):
        assert type(own) in (np.ndarray, list)
        own[0] = 1.0
    assert repr(here) == repr(np.zeros(7)) and here[0] == 0.0
    assert not iiwa.positions.any()
