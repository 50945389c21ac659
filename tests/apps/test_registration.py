"""Registrations and walls in a real kernel, by the command line; what they leave is read by a second client."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from numpy.typing import NDArray
from virtualrobot.cli import cli
from virtualrobot.errors import NameTakenError, WrongStateError
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.cell_io.yaml_file import parse
from virtualrobot_apps.registration.marker_pose import EDGE, bits_of
from virtualrobot_apps.walls.cameras import add_cameras
from virtualrobot_apps.walls.display_file import display_of
from virtualrobot_apps.walls.head import Observer

from tests.apps.test_walls import CAVE

pytestmark = pytest.mark.long

Floats = NDArray[np.float64]

POINTS = np.array([[0.4, 0.3, 0.0], [0.4, -0.5, 0.0], [-0.3, 0.1, 0.25]])


@pytest.fixture(scope="module")
def kernel() -> Iterator[KernelProcess]:
    with KernelProcess("--stepped", headless=True) as process:
        yield process


@pytest.fixture
def client(kernel: KernelProcess) -> Iterator[virtualrobot.Client]:
    with virtualrobot.connect(kernel.address) as one:
        one.scene.clear()
        yield one


def run(kernel: KernelProcess, *arguments: object) -> str:
    """Return what a command says that succeeds."""
    done = CliRunner().invoke(cli, [*map(str, arguments), "--address", kernel.address], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return done.output


def touched_file(folder: Path, world_t_arm: Floats, world_t_device: Floats) -> Path:
    """Write a file of points of an arm's base that a device has touched."""
    seen = np.linalg.inv(world_t_device) @ world_t_arm
    rows = "".join(
        f"- {{model: {point.tolist()}, touched: {(seen[:3, :3] @ point + seen[:3, 3]).tolist()}}}\n" for point in POINTS
    )
    file = folder / "touched.yaml"
    file.write_text(f"schema_version: 1\nrelative_to: arm\npoints:\n{rows}")
    return file


def test_a_device_is_kept_below_the_robot_and_goes_along_with_it(
    kernel: KernelProcess, client: virtualrobot.Client, tmp_path: Path
) -> None:
    client.load_robot("model://iiwa", name="arm", pose=virtualrobot.pose(0.5, 0.2, 0.1, yaw=0.3))
    for device in (virtualrobot.pose(2.0, -1.0, 0.4, yaw=1.2), virtualrobot.pose(1.0, 1.0, 0.2, yaw=-2.0)):
        file = touched_file(tmp_path, client.scene.pose("arm"), device)
        said = run(kernel, "register", "touched", file, "--frame", "tracker", "--tool", "arm")
        assert "points off by 0.0, 0.0, 0.0 mm" in said and "kept as tracker, below arm" in said
        with virtualrobot.connect(kernel.address) as other:
            assert np.abs(other.scene.pose("tracker") - device).max() < 1e-9
            assert other.scene.node("tracker").parent == "arm"
    client.scene.set_pose("arm", virtualrobot.pose())
    expected = np.linalg.inv(virtualrobot.pose(0.5, 0.2, 0.1, yaw=0.3)) @ device
    assert np.abs(client.scene.pose("tracker") - expected).max() < 1e-9


def test_a_robot_is_put_where_it_really_stands(
    kernel: KernelProcess, client: virtualrobot.Client, tmp_path: Path
) -> None:
    client.scene.add_object("stand", virtualrobot.box(0.4, 0.4, 0.5), pose=virtualrobot.pose(1.0, 0.0, 0.25))
    client.load_robot("model://iiwa", name="arm", pose=virtualrobot.pose(z=0.25), parent="stand")
    real = virtualrobot.pose(1.02, -0.01, 0.503, yaw=0.04)
    # The tracker stands in the world's frame: it tells the real places of the points.
    file = touched_file(tmp_path, real, np.eye(4))
    run(kernel, "register", "touched", file, "--robot", "arm")
    with virtualrobot.connect(kernel.address) as other:
        assert np.abs(other.scene.pose("arm") - real).max() < 1e-9
        assert other.scene.node("arm").parent == "stand"


def test_a_device_takes_the_name_of_nothing_else(
    kernel: KernelProcess, client: virtualrobot.Client, tmp_path: Path
) -> None:
    client.load_robot("model://iiwa", name="arm")
    client.scene.add_object("table", virtualrobot.box(1.0, 1.0, 0.1))
    file = touched_file(tmp_path, client.scene.pose("arm"), virtualrobot.pose(1.0))
    for name in ("arm", "table"):
        arguments = ["register", "touched", str(file), "--frame", name, "--address", kernel.address]
        with pytest.raises(WrongStateError, match="is there already, and no frame of reference"):
            CliRunner().invoke(cli, arguments, catch_exceptions=False, standalone_mode=False)
        assert np.array_equal(client.scene.pose(name), np.eye(4))


def test_a_camera_of_the_world_is_found_by_a_marker_in_its_picture(
    kernel: KernelProcess, client: virtualrobot.Client, tmp_path: Path
) -> None:
    """The marker is made of boxes; the picture is the kernel's, and so is the camera's true place."""
    square = EDGE / 6.0
    paper = virtualrobot.box(8 * square, 8 * square, 0.001, color="white", pose=virtualrobot.pose(z=-0.0005))
    inked = [
        virtualrobot.box(
            square,
            square,
            0.0002,
            color="black",
            pose=virtualrobot.pose((column - 2.5) * square, (2.5 - row) * square, 0.0001),
        )
        for row, column in np.argwhere(~bits_of(21)).tolist()
    ]
    sheet = virtualrobot.pose(0.5, 0.3, 0.8) @ virtualrobot.pose(roll=0.5 * np.pi, yaw=0.2)
    client.scene.add_object("sheet", [paper, *inked], pose=sheet)
    eye = virtualrobot.looking_at((sheet @ [0.3, 0.25, 0.9, 1.0])[:3], sheet[:3, 3])
    client.scene.add_camera("eye", virtualrobot.camera(1280, 720, horizontal_field=1.2), pose=eye)
    color = client.sensors["eye"].read(images=["color"]).camera.color
    assert color is not None
    file = tmp_path / "seen.png"
    assert cv2.imwrite(str(file), cv2.cvtColor(color, cv2.COLOR_RGB2BGR))
    up = (eye[:3, :3].T @ [0.0, 0.0, 1.0]).tolist()
    said = run(
        *(kernel, "register", "picture", file, "--marker", "sheet", "--field", np.degrees(1.2)),
        *("--up", ",".join(map(str, up)), "--frame", "phone"),
    )
    assert "marker 21" in said and "kept as phone, below sheet" in said
    with virtualrobot.connect(kernel.address) as other:
        found = other.scene.pose("phone")
    assert np.linalg.norm((np.linalg.inv(found) @ sheet)[:3, 3] - (np.linalg.inv(eye) @ sheet)[:3, 3]) < 0.007


def test_two_walls_show_what_is_behind_their_edge_at_the_same_rows(client: virtualrobot.Client) -> None:
    """Bars that face the eye, seen by the kernel's cameras: each begins and ends at the same row on both walls."""
    observer = Observer(display_of(parse(CAVE, "cave.yaml")))
    observer.world_t_room = np.eye(4)
    for number in range(6):
        height = 0.2 + 0.8 * number
        bar = virtualrobot.pose(3.0, -3.0, height, yaw=-np.pi / 4.0)
        client.scene.add_object(f"bar {number}", virtualrobot.box(0.01, 3.0, 0.4), pose=bar)
    names = add_cameras(client, observer, "visitor")
    assert len(names) == 6
    for eye in ("left", "right"):
        front, right = (
            client.sensors[f"visitor_{wall}_{eye}"].read(images=["segmentation"]).camera for wall in ("front", "right")
        )
        assert front.segmentation is not None and right.segmentation is not None
        rows = [
            np.flatnonzero(np.diff(column >= 0)) for column in (front.segmentation[:, -1], right.segmentation[:, 0])
        ]
        assert len(rows[0]) >= 8
        assert len(rows[0]) == len(rows[1])
        assert np.abs(rows[0] - rows[1]).max() <= 1
    with pytest.raises(NameTakenError):
        add_cameras(client, observer, "visitor")
    client.scene.remove("visitor")
