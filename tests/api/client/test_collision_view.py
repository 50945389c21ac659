"""Pictures and films show what collides: red nodes before a rose background, and both back when it is over."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from virtualrobot import Client, box, camera, looking_at, pose

from tests.api.client.conftest import IIWA

CAMERA = ([0.5, -1.6, 0.9], [0.2, 0.0, 0.75])
BACKGROUND = np.array([0.2, 0.4, 0.6])


@pytest.fixture
def cell(client: Client) -> Iterator[Client]:
    """Give a watched arm and a green box that is free of it, before a background of its own colour."""
    client.clock.set_stepped()
    client.load_robot(IIWA, name="arm")
    client.scene.add_part("box", box(0.2, 0.2, 0.2, color=(0.1, 0.7, 0.1)), pose=pose(0.6, 0.0, 0.9))
    before = client.view.background
    client.view.background, client.view.grid = BACKGROUND, False
    client.collisions.set("monitor")
    yield client
    client.view.background, client.view.grid, client.view.collisions = before, True, True


def seen(client: Client, **options: object) -> np.ndarray:
    """Return a picture (h, w, 3) as signed numbers."""
    picture = client.view.capture(CAMERA, size=(320, 240), format="raw", **options)  # pyright: ignore[reportArgumentType]
    return picture.pixels.astype(int)


def red(pixels: np.ndarray) -> np.ndarray:
    """Return where a picture is red, and not orange as this arm is."""
    red, green, blue = np.moveaxis(pixels, -1, 0)
    return (red > 90) & (red > 2.5 * np.maximum(green, blue)) & (np.abs(green - blue) < 30)


def at(client: Client, node: str, z: float = 0.0) -> tuple[int, int]:
    """Return row and column of a node's origin in the picture, by the projection of a pinhole."""
    eye, target = (np.array(point) for point in CAMERA)
    ahead = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    way = (client.scene.pose(node) @ (0.0, 0.0, z, 1.0))[:3] - eye
    scale = 120.0 / np.tan(0.45) / (way @ ahead)
    return round(119.5 - scale * (way @ np.cross(right, ahead))), round(159.5 + scale * (way @ right))


def move_box(client: Client, x: float) -> None:
    client.scene.node("box").parent_t_node = pose(x, 0.0, 0.9)
    client.clock.step(1)


def test_what_collides_is_red_until_it_is_free(cell: Client) -> None:
    free = seen(cell)
    assert not red(free).any() and np.abs(free[2, 2] - 255 * BACKGROUND).max() <= 1
    move_box(cell, 0.1)
    touching = {name for pair in cell.collisions.check().pairs for name in (pair.first, pair.second)}
    assert "box" in touching and any(name.startswith("arm.") for name in touching)
    hit = seen(cell)
    row, column = at(cell, "box")
    assert red(hit)[row - 2 : row + 3, column - 2 : column + 3].all()
    rose = 255 * (0.7 * BACKGROUND + 0.3 * np.array([1.0, 0.50, 0.48]))
    assert np.abs(hit[2, 2] - rose).max() <= 1
    base = at(cell, "arm.lbr_iiwa_link_0", 0.1)
    assert not red(hit)[base], "what touches nothing keeps its colours"
    move_box(cell, 0.6)
    np.testing.assert_array_equal(seen(cell), free)


def test_links_of_meshes_are_red(cell: Client) -> None:
    """The box is hidden, and collides all the same."""
    cell.scene.node("box").hide()
    move_box(cell, 0.1)
    assert red(seen(cell)).sum() > 500
    cell.view.collisions = False
    assert (cell.view.collisions, red(seen(cell)).sum()) == (False, 0)


def test_plain_pictures_and_cameras_of_the_scene_show_the_world_as_it_is(cell: Client) -> None:
    cell.scene.add_camera("eye", camera(160, 120), pose=looking_at(*CAMERA))
    before = seen(cell, plain=True)
    move_box(cell, 0.1)
    plain = seen(cell, plain=True)
    through = cell.view.capture("eye", format="raw").pixels.astype(int)
    assert not red(plain).any() and np.array_equal(plain[2, 2], before[2, 2])
    assert not red(through).any()


def test_a_film_shows_it_in_the_tick_in_which_it_begins(cell: Client) -> None:
    arm = cell.robot("arm")
    arm.move_joints({"lbr_iiwa_joint_2": 1.6}, wait=False)
    watch = cell.collisions.watch()
    next(watch)
    rate = 1.0 / cell.clock.read().tick_length
    with cell.view.record(CAMERA, size=(160, 120), format="raw", rate=rate) as recording:
        frames = iter(recording)
        next(frames)
        cell.clock.step(500)
        began = next(watch).events[0]
        for frame in frames:
            collides = bool(red(frame.pixels.astype(int)).any())
            assert collides == (frame.simulation_time > began.simulation_time - 1e-6), frame.simulation_time
            if collides:
                break
