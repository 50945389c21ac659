"""Least distances that the view shows: lines between the nearest points of surfaces, with their values."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, pose, sphere

from tests.api.client.conftest import IIWA

Run = Callable[..., str]
CAMERA = ([0.5, -3.0, 1.0], [0.5, 0.0, 1.0])
SIZE = (320, 240)
FOCAL = 120.0 / np.tan(0.45) / 3.0
"""Pixels a meter in the plane y = 0, by the projection of a pinhole."""


@pytest.fixture
def cell(client: Client) -> Iterator[Client]:
    """Give two balls of 0.2 m radius with 0.6 m between them, before a white background."""
    client.clock.set_stepped()
    before = client.view.background
    client.scene.add_part("left", sphere(0.2), pose=pose(0.0, 0.0, 1.0))
    client.scene.add_part("right", sphere(0.2), pose=pose(1.0, 0.0, 1.0))
    client.view.background, client.view.grid = "white", False
    yield client
    client.view.background, client.view.grid, client.view.clearances = before, True, {}


def teal(client: Client, x: float, z: float) -> bool:
    """Return whether a line is seen at x, z in the plane y = 0."""
    pixels = client.view.capture(CAMERA, size=SIZE, format="raw").pixels.astype(int)
    row, column = round(119.5 - FOCAL * (z - 1.0)), round(159.5 + FOCAL * (x - 0.5))
    near = pixels[row - 1 : row + 2, column - 1 : column + 2].reshape(-1, 3)
    return bool(((near[:, 0] < 110) & (near[:, 2] > near[:, 0] + 30)).any())


def test_a_line_goes_from_surface_to_surface_and_follows(cell: Client) -> None:
    assert not teal(cell, 0.25, 1.0)
    cell.view.clearances = {"gap": ("left", "right")}
    assert teal(cell, 0.25, 1.0) and teal(cell, 0.75, 1.0)
    cell.scene.node("right").parent_t_node = pose(0.0, 0.0, 1.8)
    assert not teal(cell, 0.75, 1.0) and teal(cell, 0.0, 1.25)
    plain = cell.view.capture(CAMERA, size=SIZE, format="raw", plain=True).pixels
    cell.view.clearances = {}
    np.testing.assert_array_equal(cell.view.capture(CAMERA, size=SIZE, format="raw").pixels, plain)


def test_the_view_tells_them_by_name_and_leaves_out_what_is_gone(cell: Client) -> None:
    cell.load_robot(IIWA, name="arm", pose=pose(0.0, 2.0))
    wanted = {"all": (["arm"], []), "two": (["arm"], ["left", "right"]), "gap": (["left"], ["right"])}
    cell.view.clearances = {"all": ("arm", ()), "two": (["arm"], ["left", "right"]), "gap": ("left", "right")}
    assert cell.view.clearances == wanted
    cell.scene.node("right").rename("other")
    assert cell.view.clearances["two"] == (["arm"], ["left", "other"])
    cell.scene.node("other").remove()
    assert cell.view.clearances == {"all": (["arm"], []), "two": (["arm"], ["left"])}
    assert cell.view.capture(CAMERA, size=SIZE).width == SIZE[0], "what is gone is passed over"
    cell.scene.clear()
    assert cell.view.clearances == {}
    assert cell.view.capture(CAMERA, size=SIZE).width == SIZE[0]


def test_what_cannot_be_shown_is_refused(cell: Client) -> None:
    with pytest.raises(virtualrobot.UnknownNameError):
        cell.view.clearances = {"gap": ("left", "nobody")}
    with pytest.raises(virtualrobot.InvalidArgumentError, match="names no node"):
        cell.view.clearances = {"gap": ((), "left")}
    with pytest.raises(virtualrobot.InvalidArgumentError, match="has no name"):
        cell.view.clearances = {" ": ("left", "right")}
    assert cell.view.clearances == {}


def test_the_command_line_shows_and_hides_them(cell: Client, run: Run) -> None:
    cell.view.clearances = {"gap": ("left", "right")}
    assert "0.600" in run("collision", "distance", "left", "right", "--show")
    assert cell.view.clearances == {"gap": (["left"], ["right"]), "left - right": (["left"], ["right"])}
    run("collision", "distance", "left", "--show")
    run("collision", "distance", "left", "right", "--hide")
    assert list(cell.view.clearances) == ["gap", "left"]
