"""Surfaces under physics: restitution, friction and what they must not be; the numbers are those of formulas."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError

from tests.api.client.physics_world import floor, place

GRAVITY = 9.81
TICK = 0.004
ENGINES = ["mujoco", pytest.param("bullet", marks=pytest.mark.long)]


@pytest.mark.parametrize("engine", ENGINES)
def test_a_ball_comes_back_as_high_as_its_restitution_says(steps: Client, engine: str) -> None:
    floor(steps, restitution=0.6)
    ball = virtualrobot.sphere(0.05).with_surface(restitution=0.6)
    steps.scene.add_part("ball", ball, pose=virtualrobot.pose(z=0.55), mass=1.0, dynamic=True)
    steps.physics.set(engine)
    heights = []
    for _ in range(160):
        steps.clock.step(1)
        heights.append(place(steps, "ball")[2])
    touched = int(np.argmin(heights))
    # It falls 0.5 m, and comes back with e of its speed, so as high as e squared of that.
    assert max(heights[touched:]) - 0.05 == pytest.approx(0.5 * 0.6**2, rel=0.08)


@pytest.mark.parametrize("engine", ENGINES)
def test_what_slides_is_braked_by_its_friction(steps: Client, engine: str) -> None:
    friction, angle = 0.2, 0.4
    tilted = virtualrobot.pose(0.0, 0.0, 2.0, 0.0, angle, 0.0)
    slope = virtualrobot.box(6.0, 2.0, 0.2, pose=virtualrobot.pose(0.0, 0.0, -0.1)).with_surface(friction=friction)
    steps.scene.add_object("slope", slope, pose=tilted)
    box = virtualrobot.box(0.2, 0.2, 0.1, pose=virtualrobot.pose(0.0, 0.0, 0.05)).with_surface(friction=friction)
    steps.scene.add_part("box", box, pose=tilted, mass=1.0, dynamic=True)
    steps.physics.set(engine)
    steps.clock.step(25)
    at = [place(steps, "box")]
    for _ in range(2):
        steps.clock.step(50)
        at.append(place(steps, "box"))
    first, second = np.linalg.norm(np.diff(at, axis=0), axis=1)
    expected = GRAVITY * (np.sin(angle) - friction * np.cos(angle))
    assert (second - first) / 0.2**2 == pytest.approx(expected, rel=0.1)


def groove(client: Client, angle: float, half: float = 0.5) -> virtualrobot.Figure:
    """Return ground along y that falls from both sides to x = 0, a mesh of triangles without thickness."""
    x, y = np.linspace(-half, half, 21), np.array([-0.3, 0.0, 0.3])
    corners = np.array([(across, along, abs(across) * np.tan(angle)) for along in y for across in x])
    first = [21 * row + column for row in range(2) for column in range(20)]
    triangles = [(at, at + 1, at + 22) for at in first] + [(at, at + 22, at + 21) for at in first]
    return client.assets.triangles(corners, triangles)


@pytest.mark.parametrize("engine", ENGINES)
def test_ground_is_touched_where_it_is_and_not_where_its_hull_is(steps: Client, engine: str) -> None:
    """A ball in a groove whose sides rise by a rests with its middle r / cos a above the bottom; the hull is level."""
    angle, radius = 0.5, 0.06
    steps.scene.add_object("ground", groove(steps, angle), pose=virtualrobot.pose(1.0, 2.0, 0.5))
    ball = virtualrobot.sphere(radius).with_surface(rolling_friction=0.002)
    steps.scene.add_part("ball", ball, pose=virtualrobot.pose(1.02, 2.0, 0.6), mass=1.0, dynamic=True)
    steps.physics.set(engine)
    steps.clock.step(500)
    assert place(steps, "ball") == pytest.approx([1.0, 2.0, 0.5 + radius / np.cos(angle)], abs=2e-3)
    assert steps.physics.status.fault == ""


def test_a_mesh_without_volume_is_named_where_it_is_no_ground(steps: Client) -> None:
    """Two triangles that are a cell of level ground carry a ball; one alone is none, and what moves needs a volume."""
    corners = [(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)]
    level = steps.assets.triangles(corners, [(0, 1, 2), (0, 2, 3)])
    steps.physics.set("mujoco")
    steps.scene.add_object("ground", level)
    pose = virtualrobot.pose(0.3, 0.2, 0.1)
    steps.scene.add_part("ball", virtualrobot.sphere(0.05), pose=pose, mass=1.0, dynamic=True)
    steps.clock.step(250)
    assert place(steps, "ball")[2] == pytest.approx(0.05, abs=1e-3)
    with pytest.raises(VirtualRobotError, match=r"the mesh '.*' of 'sheet' has no volume"):
        steps.scene.add_object("sheet", steps.assets.triangles(corners, [(0, 1, 2)]))
    with pytest.raises(VirtualRobotError, match=r"the mesh '.*' of 'plate' has no volume"):
        steps.scene.add_part("plate", level, mass=1.0, dynamic=True)
    tiny = steps.assets.triangles(np.eye(4, 3) * 1e-5, [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)])
    with pytest.raises(VirtualRobotError, match=r"the mesh '.*' of 'tiny' has no volume"):
        steps.scene.add_part("tiny", tiny, mass=1.0, dynamic=True)
    assert {node.name for node in steps.scene.nodes()} == {"world", "ground", "ball"}


def test_settings_that_an_engine_lacks_are_refused_at_once(steps: Client) -> None:
    """And what has moved by forces goes on."""
    steps.physics.set("mujoco")
    steps.scene.add_part("ball", virtualrobot.sphere(0.05), mass=1.0, dynamic=True)
    with pytest.raises(VirtualRobotError, match="'foo'"):
        steps.physics.set(engine_settings={"foo": 1})
    with pytest.raises(VirtualRobotError, match="'foo'"):
        steps.physics.set("bullet", engine_settings={"foo": 1})
    steps.clock.step(10)
    assert place(steps, "ball")[2] < 0.0
    assert (steps.physics.status.engine, steps.physics.status.fault) == ("mujoco", "")


def test_surfaces_that_there_are_not_are_refused(steps: Client) -> None:
    for surface, said in (
        ({"restitution": 1.5}, "restitution must be 0 to 1, not 1.5"),
        ({"friction": -0.1}, "friction must be 0 or more, not -0.1"),
        ({"rolling_friction": -1.0}, "rolling_friction"),
        ({"stiffness": float("nan")}, "stiffness"),
        ({"damping": 10.0}, r"a damping of 10 N s/m and no stiffness, beside which it counts; give both"),
    ):
        with pytest.raises((VirtualRobotError, ValueError), match=said):
            floor(steps, **surface)
    with pytest.raises(VirtualRobotError, match="the mass of 'ball' is 0"):
        steps.scene.add_part("ball", virtualrobot.sphere(0.05), mass=0.0, dynamic=True)
    assert [node.name for node in steps.scene.nodes()] == ["world"]
