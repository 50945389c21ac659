"""Viewpoints: views that are saved in the scene, looked from again, and go along with what they hang on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, errors, pose

from tests.api.client.conftest import Run

EYE, AT = np.array([0.0, -2.0, 0.5]), np.array([0.0, 0.0, 0.5])
X = np.array([1.0, 0.0, 0.0])


def looks(client: Client, eye: np.ndarray, at: np.ndarray) -> bool:
    """Return whether the view looks from a point at another one."""
    found = client.view.eye_and_target()
    return found is not None and np.allclose(found, [eye, at], atol=1e-9)


def test_a_view_is_saved_and_looked_from_again(client: Client, tmp_path: Path) -> None:
    with pytest.raises(errors.WrongStateError, match="frames the world"):
        client.view.save("front")
    client.view.set_camera(EYE, AT, 0.6)
    saved = client.view.save("front")
    assert (saved.kind, saved.parent, saved.field_of_view) == ("viewpoint", "world", pytest.approx(0.6))
    assert saved.distance == pytest.approx(2.0)
    np.testing.assert_allclose(saved.pose, virtualrobot.looking_at(EYE, AT), atol=1e-12)

    client.view.set_camera([3, 0, 0])
    client.view.look_from("front")
    assert looks(client, EYE, AT)
    assert client.view.read().field_of_view == pytest.approx(0.6)
    # It looks from there wherever the viewpoint goes, under whatever name.
    saved.rename("gate")
    saved.parent_t_node = pose(y=-1.0) @ saved.parent_t_node
    assert looks(client, EYE - [0, 1, 0], AT - [0, 1, 0])
    assert client.view.read().camera_node == "gate"

    # Saved again under its name, while it is looked from, it stays; undo and scene files have it.
    client.view.save("gate")
    assert looks(client, EYE - [0, 1, 0], AT - [0, 1, 0])
    client.view.set_camera([3, 0, 0])
    client.view.save("gate")
    client.history.undo()
    np.testing.assert_allclose(client.scene.viewpoint("gate").pose[:3, 3], EYE - [0, 1, 0], atol=1e-9)
    client.scene.save(tmp_path / "cell.yaml")
    client.scene.remove("gate")
    assert client.view.eye_and_target() is not None and not client.scene.viewpoints()
    client.scene.load_scene(tmp_path / "cell.yaml")
    assert client.scene.viewpoint("gate").distance == pytest.approx(2.0)


def test_a_view_goes_along_with_a_node(client: Client) -> None:
    cart = client.scene.add_object("cart", virtualrobot.box(0.2, 0.2, 0.2, color="red"), pose=pose(1.0))
    client.view.set_camera(EYE, AT)
    client.view.follow("cart")
    cart.parent_t_node = pose(2.0, yaw=np.pi / 2)
    assert looks(client, EYE + X, AT + X)

    # One that turns with it, by a quarter about the cart: (x, y) from it becomes (-y, x).
    cart.parent_t_node = pose(1.0)
    client.view.set_camera(EYE, AT)
    client.view.follow("cart", turns=True)
    client.view.save("mounted")
    assert client.scene.viewpoint("mounted").parent == "cart"
    cart.parent_t_node = pose(1.0, yaw=np.pi / 2)
    assert looks(client, np.array([3.0, -1.0, 0.5]), np.array([1.0, -1.0, 0.5]))
    client.view.follow("world")
    cart.parent_t_node = pose(5.0)
    assert looks(client, np.array([3.0, -1.0, 0.5]), np.array([1.0, -1.0, 0.5]))
    client.view.look_from("mounted")
    assert looks(client, np.array([4.0, -2.0, 0.5]), np.array([4.0, 0.0, 0.5]))

    # Without what it goes along with, the view frames the world.
    client.scene.remove("cart")
    assert client.view.eye_and_target() is None


def test_pictures_are_taken_from_viewpoints(client: Client) -> None:
    client.scene.add_object("ball", virtualrobot.sphere(0.2, color="red"), pose=pose(z=0.5))
    there = virtualrobot.looking_at(EYE, AT)
    client.scene.add_viewpoint("front", pose=there, distance=2.0, field_of_view=0.5)
    size = (64, 48)
    by_name = client.view.capture("front", size=size, format="raw").pixels
    by_hand = client.view.capture((EYE, AT, 0.5), size=size, format="raw").pixels
    # The eye's pose came as a quaternion: edges may be off by the last bit of a number.
    assert (np.abs(by_name.astype(int) - by_hand).max(axis=2) > 2).mean() < 0.01
    assert client.view.pick(31.5, 23.5, "front", size=size).node == "ball"


@pytest.mark.parametrize(
    ("distance", "field_of_view", "named"),
    [(1.0, 3.5, "field_of_view_radians is 3.5"), (-1.0, 0.9, "distance_meters")],
)
def test_what_is_no_view_is_refused(client: Client, distance: float, field_of_view: float, named: str) -> None:
    with pytest.raises(errors.InvalidArgumentError, match=named):
        client.scene.add_viewpoint("odd", distance=distance, field_of_view=field_of_view)
    assert not client.scene.viewpoints()


def test_the_command_line_saves_and_follows(run: Run, client: Client) -> None:
    client.scene.add_object("cart", pose=pose(1.0))
    there = "from 0.0000 -2.0000 0.5000 at 0.0000 0.0000 0.5000"
    assert run("view", "--from", "0,-2,0.5", "--at", "world:0,0,0.5", "--save", "front") == f"saved front\n{there}\n"
    run("view", "top")
    assert run("view", "--saved", "front") == f"{there}, along with front\n"
    assert (
        run("view", "--follow", "cart", "--turn", "--save", "mounted") == f"saved mounted\n{there}, along with cart\n"
    )
    assert run("view", "--list") == "mounted in cart\nfront in world\n"
    assert "--saved says all" in run("view", "top", "--saved", "front", code=2)
    assert "--turn needs --follow" in run("view", "--turn", code=2)
    assert "there is no viewpoint named 'nobody'" in run("view", "--saved", "nobody", code=1)
