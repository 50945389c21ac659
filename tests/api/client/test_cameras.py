"""Cameras of a real kernel: what is set, asked for and read; that it is true is shown in tests/unit/sensing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot.sensors.cameras import CameraSettings

from tests.api.client.conftest import IIWA, Run


@pytest.fixture
def scene(client: virtualrobot.Client) -> virtualrobot.Client:
    """Return a client that sees a red ball 2 m ahead of a camera `eye` at the origin, over a floor, in stepped time."""
    client.clock.set_stepped()
    client.scene.add_object("floor", virtualrobot.box(20, 20, 0.1), pose=virtualrobot.pose(z=-0.55))
    client.scene.add_part("ball", virtualrobot.sphere(0.3, color="#ff0000"), pose=virtualrobot.pose(2.0))
    client.scene.add_camera("eye", virtualrobot.camera(80, 60), pose=virtualrobot.looking_at([0, 0, 0], [1, 0, 0]))
    return client


def read(client: virtualrobot.Client, *images: str, name: str = "eye") -> virtualrobot.CameraReading:
    return client.sensors[name].read(images=images).camera


def test_a_camera_takes_what_is_asked_for(scene: virtualrobot.Client) -> None:
    seen = read(scene)
    assert seen.color is not None and seen.depth is None and seen.segmentation is None and seen.normals is None
    assert (seen.color.shape, seen.color.dtype) == ((60, 80, 3), np.uint8)
    assert not seen.color.flags.writeable
    assert seen.color[30, 40].tolist() == [255, 0, 0]  # its own light, straight on
    seen = read(scene, "color", "depth", "segmentation", "normals")
    assert seen.depth is not None and seen.normals is not None and seen.segmentation is not None
    assert seen.depth[30, 40] == pytest.approx(1.7, abs=1e-3)
    assert seen.element_names[seen.segmentation[30, 40]] == "ball"
    np.testing.assert_allclose(seen.normals[30, 40], [0, 0, -1], atol=0.05)
    assert np.isinf(seen.depth[0, 0])
    assert (seen.width, seen.height, seen.projection, seen.stereo_baseline) == (80, 60, "pinhole", 0.0)
    np.testing.assert_allclose(
        seen.camera_matrix, [[40 / np.tan(0.5), 0, 39.5], [0, 40 / np.tan(0.5), 29.5], [0, 0, 1]]
    )
    reading = scene.sensors["eye"].read(images=["depth", "segmentation"])
    points = reading.camera.points(reading.world_t_sensor)[reading.camera.mask("ball")]
    np.testing.assert_allclose(np.linalg.norm(points - [2, 0, 0], axis=1), 0.3, atol=1e-3)


def test_a_running_camera_reads_at_its_rate_with_noise_that_repeats(scene: virtualrobot.Client) -> None:
    settings = virtualrobot.camera(
        32, 24, rate=25.0, images=["depth", "color"], color_noise=0.05, depth_noise=0.01, seed=5, running=True
    )
    runs = []
    for name in ("first", "second"):
        scene.scene.add_camera(name, settings, pose=virtualrobot.looking_at([0, 0, 0], [1, 0, 0]))
        scene.clock.step(50)  # 0.2 s
        status = scene.sensors.status(name)
        assert (status.state, status.readings, status.missed, status.kind) == ("running", 5, 0, "camera_sensor")
        reading = next(scene.sensors[name].watch())
        assert reading.number == 5
        assert reading.camera.depth is not None and reading.camera.color is not None
        runs.append(reading.camera)
        scene.scene.remove(name)
    np.testing.assert_array_equal(runs[0].depth, runs[1].depth)
    np.testing.assert_array_equal(runs[0].color, runs[1].color)


def test_two_eyes(scene: virtualrobot.Client) -> None:
    pose = virtualrobot.looking_at([0, 0, 0], [1, 0, 0])
    scene.scene.add_camera("pair", virtualrobot.camera(81, 61, stereo_baseline=0.2), pose=pose)
    left = read(scene, "segmentation", name="pair")
    assert left.right is not None and left.stereo_baseline == 0.2
    shift = np.argwhere(left.mask("ball")).mean(axis=0)[1] - np.argwhere(left.right.mask("ball")).mean(axis=0)[1]
    assert shift == pytest.approx(left.camera_matrix[0, 0] * 0.2 / 2.0, abs=0.5)  # focal length, baseline, depth


def test_a_camera_on_a_link_sees_what_its_robot_turns_it_to(scene: virtualrobot.Client) -> None:
    arm = scene.load_robot(IIWA, name="arm", pose=virtualrobot.pose(z=-1.0))
    hand = virtualrobot.camera(64, 48, horizontal_field=1.0)
    # z of the last link is its axis, which the camera looks along.
    scene.scene.add_camera("hand", hand, parent="arm.lbr_iiwa_link_7", pose=virtualrobot.pose(z=0.1))
    up = read(scene, "depth", name="hand").depth
    assert up is not None and np.isinf(up).all()
    scene.scene.set_joint_positions("arm", [0, 0, 0, -np.pi / 2, 0, 0, 0])
    seen = read(scene, "segmentation", name="hand")
    assert "ball" in seen.element_names
    assert seen.mask("ball").any()
    assert arm.name == "arm"


def test_cameras_and_lights_are_saved_and_loaded(scene: virtualrobot.Client, tmp_path: Path) -> None:
    settings = virtualrobot.camera(
        64,
        projection="fisheye",
        horizontal_field=2.5,
        distortion=[0.01, 0.002, 0.0, 0.0],
        near=0.1,
        far=20.0,
        images=["normals", "depth"],
        depth_noise=0.003,
        stereo_baseline=0.1,
        seed=9,
    )
    scene.scene.add_camera("wide", settings)
    light = virtualrobot.light("spot", color=[1, 0.5, 0.25], intensity=2.0, cone_angle=0.7, shadows=False)
    scene.scene.add_light("lamp", light)
    before = read(scene, "depth", name="wide")
    scene.scene.save(tmp_path / "scene.yaml")
    scene.scene.load_scene(tmp_path / "scene.yaml")
    nodes = {node.name: node for node in scene.scene._read()[0]}
    assert nodes["wide"].camera_sensor == settings._message
    assert nodes["lamp"].light == light._message
    np.testing.assert_array_equal(before.depth, read(scene, "depth", name="wide").depth)


@pytest.mark.long
def test_large_pictures_travel_and_too_large_ones_are_refused(scene: virtualrobot.Client) -> None:
    scene.scene.add_camera("large", virtualrobot.camera(2400, 1600), pose=virtualrobot.looking_at([0, 0, 0], [1, 0, 0]))
    seen = read(scene, "depth", "color", name="large")  # 27 MB
    assert seen.depth is not None
    assert seen.depth[800, 1200] == pytest.approx(1.7, abs=1e-3)
    scene.scene.add_camera("huge", virtualrobot.camera(4000, 4000), pose=virtualrobot.looking_at([0, 0, 0], [1, 0, 0]))
    with pytest.raises(virtualrobot.LimitError, match="at most 240,000,000 go into one reading"):
        read(scene, "normals", "depth", name="huge")


def test_the_command_line_writes_pictures_as_arrays(run: Run, scene: virtualrobot.Client, tmp_path: Path) -> None:
    file = tmp_path / "seen.npz"
    assert "eye  1  80 x 60 pixels: color\n" in run("sensor", "read", "eye")
    shown = run("sensor", "read", "eye", "--kind", "depth", "--kind", "segmentation", "--out", str(file))
    assert "80 x 60 pixels: depth, segmentation" in shown
    with np.load(file) as saved:
        assert saved["depth"][30, 40] == pytest.approx(1.7, abs=1e-3)
        assert saved["element_names"][saved["segmentation"][30, 40]] == "ball"
        assert saved["camera_matrix"][0, 2] == 39.5
        assert "color" not in saved
    refusal = run("sensor", "read", "eye", "--out", str(tmp_path / "seen.ply"), code=2)
    assert "`virtualrobot capture --camera eye` writes .png" in refusal
    assert "--frame is for range sensors" in run("sensor", "read", "eye", "--frame", "world", code=2)


def test_lights_that_cannot_be_are_refused(scene: virtualrobot.Client) -> None:
    for light, message in (
        (virtualrobot.light(intensity=1e12), r"intensity must be at most 1e\+09, not 1e\+12"),
        (virtualrobot.light("spot", cone_angle=2.0), "cone_angle_radians must be at most pi/2, not 2"),
        (virtualrobot.light(intensity=-1.0), "intensity"),
    ):
        with pytest.raises(virtualrobot.InvalidArgumentError, match=message):
            scene.scene.add_light("bad", light)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (virtualrobot.camera(5000, 5000), "5000 x 5000 pixels; at most 16,000,000"),
        (virtualrobot.camera(distortion=[0.1, 0.2]), "has 2 coefficients; 0 or 4 or 5 or 8 are known"),
        (virtualrobot.camera(near=2.0, far=1.0), r"far_meters must be above near_meters \(2\), not 1"),
        (virtualrobot.camera(horizontal_field=3.2), "horizontal_field_radians must be below 3.14159, not 3.2"),
        (
            virtualrobot.camera(horizontal_field=1.0, camera_matrix=np.eye(3)),
            "says its intrinsics and its field of view",
        ),
        (virtualrobot.camera(camera_matrix=np.diag([0, 5, 1])), "needs focal lengths above 0, not 0, 5"),
        (virtualrobot.camera(color_noise=float("nan")), "color_noise"),
        (virtualrobot.camera(rate=-1.0), "rate_hertz"),
        (virtualrobot.camera(images=["color", "color"]), "names a kind twice"),
        (virtualrobot.camera(stereo_baseline=float("inf")), "stereo_baseline_meters"),
        (virtualrobot.camera(water_attenuation=(0.1, -0.1, 0)), r"water_attenuation_per_meter must be 0 to 1000.*-0.1"),
        (virtualrobot.camera(water_color="blue"), "water_color is of no water; give water_attenuation_per_meter"),
    ],
    ids=lambda value: value[:20] if isinstance(value, str) else "",
)
def test_settings_that_cannot_be_are_refused_by_name(
    scene: virtualrobot.Client, settings: CameraSettings, message: str
) -> None:
    with pytest.raises((virtualrobot.InvalidArgumentError, virtualrobot.LimitError), match=message):
        scene.scene.add_camera("bad", settings)
    assert "bad" not in scene.sensors
