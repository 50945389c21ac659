"""Ghosts: robots shown where they are not, in what the view tells and in pictures."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import virtualrobot
from google.protobuf.field_mask_pb2 import FieldMask
from virtualrobot import Client, Ghost, Robot, pose
from virtualrobot._wire.messages import array_message
from virtualrobot.v1 import collision_pb2, view_pb2

from tests.api.client.conftest import Run

CAMERA = ([0.0, -3.5, 0.6], [0.0, 0.0, 0.6])
SIZE = (320, 240)
FOCAL = 120.0 / np.tan(0.45) / 3.5
"""Pixels a meter in the plane y = 0, by the projection of a pinhole."""
RIGHT = [0.0, np.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0]
"""The arm lies along x: the axis of its second joint is 0.36 m above the floor, by the data sheet of the LBR iiwa."""


@pytest.fixture
def cell(client: Client, iiwa: Robot) -> Iterator[Client]:
    """Give an arm that stands upright before a white background."""
    client.clock.set_stepped()
    before = client.view.background
    client.view.background, client.view.grid = "white", False
    yield client
    client.view.background, client.view.grid, client.view.ghosts = before, True, {}


def pixels(client: Client, *, plain: bool = False) -> np.ndarray:
    return client.view.capture(CAMERA, size=SIZE, format="raw", plain=plain).pixels.astype(int)


def at(picture: np.ndarray, x: float, z: float) -> np.ndarray:
    """Return the colour at x, z in the plane y = 0."""
    return picture[round(119.5 - FOCAL * (z - 0.6)), round(159.5 + FOCAL * x)]


def is_white(color: np.ndarray) -> bool:
    return bool((color == 255).all())


def is_bluish(color: np.ndarray) -> bool:
    return bool(color[2] > color[0] + 30)


def test_a_ghost_is_seen_where_the_robot_would_be_and_gone_when_it_is_taken_away(cell: Client) -> None:
    before = pixels(cell)
    assert is_white(at(before, 0.6, 0.36))
    cell.view.ghosts = {"goal": ("iiwa", RIGHT)}
    shown = pixels(cell)
    assert is_bluish(at(shown, 0.6, 0.36)) and is_white(at(shown, -0.6, 0.36))
    np.testing.assert_array_equal(pixels(cell, plain=True), before)
    cell.view.ghosts = {"goal": Ghost("iiwa", {"lbr_iiwa_joint_2": -np.pi / 2}, color="red", opacity=0.9)}
    shown = pixels(cell)
    left = at(shown, -0.6, 0.36)
    assert is_white(at(shown, 0.6, 0.36)) and left[0] > left[1] + 60 and left[0] > left[2] + 60
    cell.view.ghosts = {}
    np.testing.assert_array_equal(pixels(cell), before)


def test_it_stands_on_the_base_and_goes_with_the_robot(cell: Client) -> None:
    cell.view.ghosts = {"goal": ("iiwa", RIGHT)}
    cell.scene.set_joint_positions("iiwa", RIGHT)
    cell.scene.node("iiwa").parent_t_node = pose(0.0, 0.0, 0.5)
    assert is_white(at(pixels(cell), 0.6, 0.36)), "neither the ghost nor the arm"
    cell.scene.set_joint_positions("iiwa", [0.0] * 7)
    assert is_bluish(at(pixels(cell), 0.6, 0.86))
    cell.scene.node("iiwa").remove()
    assert cell.view.ghosts == {} and is_white(at(pixels(cell), 0.6, 0.86))


def test_it_shows_what_the_robot_holds_and_touches_nothing(cell: Client) -> None:
    cell.scene.add_part("rod", virtualrobot.cylinder(0.05, 0.4), parent="iiwa.lbr_iiwa_link_7", pose=pose(z=0.25))
    cell.scene.add_object("wall", virtualrobot.box(0.02, 0.5, 0.2), pose=pose(1.1, 0.0, 0.36))
    before = cell.collisions.check()
    cell.view.ghosts = {"goal": ("iiwa", RIGHT)}
    assert is_bluish(at(pixels(cell), 1.2, 0.36)), "the rod: the arm ends at x = 0.95"
    assert cell.collisions.check().pairs == before.pairs


def test_the_view_tells_them_by_name_and_many_are_thinned(cell: Client) -> None:
    rows = np.linspace(0.0, 1.0, 101)[:, None] * RIGHT
    cell.view.ghosts = {"path": ("iiwa", rows), "one": Ghost("iiwa", RIGHT, color=[0.5, 0.25, 0.125], opacity=0.5)}
    told = cell.view.ghosts
    assert list(told) == ["path", "one"] and told["path"].opacity == 0.3
    shown = np.asarray(told["path"].positions)
    assert shown.shape == (20, 7)
    np.testing.assert_array_equal(shown[[0, -1]], rows[[0, -1]])
    one = told["one"]
    assert (one.robot, one.color, one.opacity) == ("iiwa", [0.5, 0.25, 0.125], 0.5)
    cell.scene.node("iiwa").rename("arm")
    cell.view.ghosts = cell.view.ghosts
    assert [one.robot for one in cell.view.ghosts.values()] == ["arm", "arm"]


def test_a_plan_and_a_joint_by_its_name_can_be_shown(cell: Client, iiwa: Robot) -> None:
    plan = iiwa.plan(iiwa.ptp(RIGHT))
    cell.view.ghosts = {"plan": ("iiwa", plan.robots["iiwa"])}
    shown = np.asarray(cell.view.ghosts["plan"].positions)
    assert len(shown) == 20
    np.testing.assert_allclose(shown[-1], RIGHT, atol=1e-9)
    cell.scene.set_joint_positions("iiwa", [0.1] * 7)
    cell.view.ghosts = {"one": ("iiwa", {"lbr_iiwa_joint_4": [0.5, 1.0]})}
    cell.scene.set_joint_positions("iiwa", [0.2] * 7)
    shown = np.asarray(cell.view.ghosts["one"].positions)
    np.testing.assert_allclose(shown, [[0.1, 0.1, 0.1, four, 0.1, 0.1, 0.1] for four in (0.5, 1.0)])


def test_what_cannot_be_shown_is_refused(cell: Client) -> None:
    def refused(error: type[Exception], words: str, *ghosts: view_pb2.Ghost) -> None:
        request = view_pb2.UpdateViewRequest(view=view_pb2.View(ghosts=ghosts), update_mask=FieldMask(paths=["ghosts"]))
        with pytest.raises(error, match=words):
            cell.services.view.UpdateView(request)

    def ghost(rows: object, name: str = "g", robot: str = "iiwa", opacity: float = 0.3) -> view_pb2.Ghost:
        told = collision_pb2.RobotConfigurations(robot=robot, positions=array_message(np.asarray(rows, dtype=float)))
        return view_pb2.Ghost(name=name, configurations=told, opacity=opacity)

    wrong, one = virtualrobot.InvalidArgumentError, [[0.0] * 7]
    refused(virtualrobot.UnknownNameError, "nobody", ghost(one, robot="nobody"))
    refused(wrong, r"ghosts\['g'\]\.configurations\.positions must have the shape \(n, 7\)", ghost([[0.0] * 6]))
    refused(wrong, "not finite", ghost([[np.nan] * 7]))
    refused(virtualrobot.LimitError, "in row 1", ghost([[0.0] * 7, [9.0] * 7]))
    refused(wrong, "has no configuration", ghost(np.zeros((0, 7))))
    refused(wrong, "has no name", ghost(one, name=" "))
    refused(virtualrobot.NameTakenError, "two ghosts", ghost(one), ghost(one))
    refused(wrong, "51 configurations", ghost(np.zeros((30, 7))), ghost(np.zeros((21, 7)), name="h"))
    for opacity in (0.0, -0.1, 1.1, np.nan):
        refused(wrong, "opacity", ghost(one, opacity=opacity))
    assert cell.view.ghosts == {}


def test_the_command_line_shows_and_hides_a_path(cell: Client, run: Run) -> None:
    run("path", "iiwa", "--joints", "lbr_iiwa_joint_1=0.5", "--show")
    shown = np.asarray(cell.view.ghosts["path of iiwa"].positions)
    np.testing.assert_allclose(shown[[0, -1], 0], [0.0, 0.5])
    run("path", "iiwa", "--joints", "lbr_iiwa_joint_1=0.5", "--hide")
    assert cell.view.ghosts == {}
