"""Points of a floor that cameras see: pyramids and the shadow of a box, by formulas, and what is refused."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from virtualrobot_apps.studies.coverage import area_points, cover
from virtualrobot_apps.studies.parameters import generator
from virtualrobot_apps.studies.work import Cell
from virtualrobot_kernel.embedded import EmbeddedWorld
from virtualrobot_kernel.errors import KernelError

pytestmark = pytest.mark.long

Floats = NDArray[np.float64]

# Two cameras below a ceiling, 2.5 m high, look straight down: 200 x 100 pixels, 1 m of focal length to 1 m of width.
SCENE = """
schema_version: 1
nodes:
- name: floor
  object: {}
  parent_t_node: {position: {z: -0.05}}
  figures: [{box: {size: {x: 8, y: 8, z: 0.1}}}]
- name: post
  object: {}
  parent_t_node: {position: {x: 0.5, y: 0.2, z: 0.4}}
  figures: [{box: {size: {x: 0.2, y: 0.3, z: 0.8}}}]
- {name: area, object: {}}
- name: left
  parent_t_node: {position: {x: -0.5, z: 2.5}, orientation: {x: 1}}
  camera_sensor: {width: 200, height: 100, horizontal_field_radians: 0.9272952180016122, far_meters: 4}
- name: right
  parent_t_node: {position: {x: 0.5, z: 2.5}, orientation: {x: 1}}
  camera_sensor: {width: 200, height: 100, horizontal_field_radians: 0.9272952180016122, far_meters: 4}
- name: lidar                                    # a quarter of a turn, 1 degree apart, beside the post
  parent_t_node: {position: {y: 0.2, z: 0.4}}
  range_sensor:
    min_range_meters: 0.1
    max_range_meters: 2
    pattern: {fan: {count: 91, start_angle_radians: -0.7853981633974483, end_angle_radians: 0.7853981633974483}}
- name: fish
  camera_sensor: {projection: CAMERA_PROJECTION_FISHEYE}
"""
HEIGHT = 2.5
LOW, HIGH = np.array([0.4, 0.05, 0.0]), np.array([0.6, 0.35, 0.8])
"""Corners of the post."""


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[EmbeddedWorld]:
    """Return the scene's world."""
    file = tmp_path_factory.mktemp("scene") / "cell.yaml"
    file.write_text(SCENE)
    made = EmbeddedWorld(file)
    yield made
    made.close()


def told(world: EmbeddedWorld, **parameters: object) -> dict[str, float | str | None]:
    usual = {"sensors": "left, right", "area": "area", "length": 4.0, "width": 2.0, "spacing": 0.05}
    return dict(cover(Cell(0, usual | parameters, generator(1, 0), world, Path())))


def expected(eye: Floats, points: Floats) -> NDArray[np.bool_]:
    """Return which points of the floor are in the pyramid, and not behind the post, by its slabs.

    Kay and Kajiya, "Ray tracing complex scenes", 1986: a line is in a box between the last slab that it enters and the
    first that it leaves.
    """
    field = 2.0 * math.atan(0.5)
    assert field == pytest.approx(0.9272952180016122)
    across = np.abs(points - eye)
    # Half of 2.5 m to each side in x, and half of that in y.
    inside = (across[:, 0] <= 0.5 * HEIGHT) & (across[:, 1] <= 0.25 * HEIGHT)
    ways = points - eye
    ways[ways == 0.0] = 1e-12
    ends = np.stack([(LOW - eye) / ways, (HIGH - eye) / ways])
    enters, leaves = ends.min(axis=0).max(axis=1), ends.max(axis=0).min(axis=1)
    return inside & ~((enters < leaves) & (leaves > 0.0) & (enters < 1.0 - 1e-6))


def test_they_see_what_the_formulas_say(world: EmbeddedWorld) -> None:
    world.restore()
    points = area_points(np.eye(4), {"length": 4.0, "width": 2.0, "spacing": 0.03})
    assert len(points) == 134 * 67
    eyes = {"left": np.array([-0.5, 0.0, HEIGHT]), "right": np.array([0.5, 0.0, HEIGHT])}
    views = {name: expected(eye, points) for name, eye in eyes.items()}
    for name, view in views.items():
        assert np.array_equal(world.seen(name, points), view)
    # The post stands between the left one and the floor behind it.
    assert 0 < (~views["left"] & views["right"]).sum()
    found = told(world, spacing=0.03)
    both = sum(view.astype(int) for view in views.values())
    assert found["seen"] == np.mean(both >= 1) and found["twice"] == np.mean(both >= 2)
    assert found["worst"] == min(views, key=lambda name: views[name].mean())
    assert found["least"] == min(view.mean() for view in views.values())


def test_a_camera_elsewhere_sees_other_things(world: EmbeddedWorld) -> None:
    """Off the post, a picture has 2.5 x 1.25 m of the floor; half of it is beyond the area's rim at x = -2 m."""
    away = {"sensors": "left", "moved": "left", "length": 4.0, "width": 2.0, "spacing": 0.01}
    whole = told(world, **away, x=-0.75)["seen"]
    assert whole == pytest.approx(2.5 * 1.25 / 8.0, abs=0.01)
    half = told(world, **away, x=-2.0)["seen"]
    assert half == pytest.approx(1.25 * 1.25 / 8.0, abs=0.01)
    turned = told(world, **away, x=-2.0, yaw=math.pi / 2)["seen"]
    assert turned == pytest.approx(0.625 * 2.0 / 8.0, abs=0.01)
    # From below 0.8 m the picture is a third as wide as from 2.5 m; from above 4 m the floor is too far.
    assert told(world, **away, x=-2.0, z=0.75)["seen"] == pytest.approx(0.375 * 0.375 / 8.0, abs=0.01)
    assert told(world, **away, x=-2.0, z=4.1)["seen"] == 0.0
    # As it was in the scene again.
    assert world.pose("left")[2, 3] == pytest.approx(4.1)
    world.restore()
    assert world.pose("left")[2, 3] == HEIGHT


def test_a_range_sensor_sees_what_its_beams_pass(world: EmbeddedWorld) -> None:
    """A quarter of a ring from 0.1 to 2 m, where beams 1 degree apart are within half a spacing; behind the post none.

    Of 2 cm between points beams are farther away than 1 cm from 1.146 m on, but near them.
    """
    world.restore()
    points = area_points(np.eye(4), {"length": 4.0, "width": 4.0, "spacing": 0.05})
    points[:, 2] = 0.4
    off = points - [0.0, 0.2, 0.4]
    at, angle = np.hypot(off[:, 0], off[:, 1]), np.arctan2(off[:, 1], off[:, 0])
    beside = np.abs(angle - np.round(np.degrees(angle)) * math.pi / 180.0)
    for within in (0.025, 0.01):
        passed = (at >= 0.1) & (at <= 2.0) & (np.abs(angle) <= math.pi / 4.0) & (at * np.sin(beside) <= within)
        # Just outside of the quarter its last beams pass, too.
        sides = np.abs(np.abs(angle) - math.pi / 4.0)
        passed |= (at >= 0.1) & (at <= 2.0) & (sides < 0.3) & (at * np.sin(sides) <= within)
        shadow = (off[:, 0] > 0.4) & (np.abs(off[:, 1]) < 0.15 * off[:, 0] / 0.4)
        seen = world.seen("lidar", points, within)
        rim = np.abs(np.abs(off[:, 1]) - 0.15 * off[:, 0] / 0.4) < 1e-9
        assert np.array_equal(seen[~rim], (passed & ~shadow)[~rim]) and 0 < (passed & shadow).sum()
    assert 0 < seen.sum() < world.seen("lidar", points, 0.025).sum()


def test_several_are_placed_at_once(world: EmbeddedWorld) -> None:
    both = {"length": 6.0, "width": 2.0, "spacing": 0.02, "moved": "left, right"}
    apart = told(world, **both, x=-1.5, x2=1.5)
    # Each sees 2.5 x 1.25 m, and the right one not what is behind the post.
    assert apart["twice"] == 0.0 and apart["seen"] == pytest.approx(2.0 * 2.5 * 1.25 / 12.0, abs=0.015)
    # Turned by a right angle at the same place, one has 1.25 x 2 m of the area, 1.25 x 1.25 m of which both have.
    crossed = told(world, **both, x=-1.5, x2=-1.5, yaw2=0.5 * math.pi)
    assert crossed["twice"] == pytest.approx(1.25**2 / 12.0, abs=0.01)
    assert crossed["seen"] == pytest.approx((2.5 * 1.25 + 1.25 * 2.0 - 1.25**2) / 12.0, abs=0.01)


def test_an_area_may_have_a_height_and_lie_anyhow() -> None:
    pose = np.eye(4)
    pose[:3, :3] = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
    pose[:3, 3] = 1.0, 2.0, 3.0
    points = area_points(pose, {"length": 1.0, "width": 0.5, "height": 0.3, "spacing": 0.25})
    assert len(points) == 4 * 2 * 2
    np.testing.assert_allclose(points.mean(axis=0), [1.0, 2.0, 3.0])
    # x goes down, y to the side, and z along the world's x.
    np.testing.assert_allclose(np.ptp(points, axis=0), [0.15, 0.25, 0.75])


def test_bad_input_is_told(world: EmbeddedWorld) -> None:
    with pytest.raises(ValueError, match="moved is some of left, right, each once, not post"):
        told(world, moved="post")
    with pytest.raises(ValueError, match="each once, not left, left"):
        told(world, moved="left, left")
    with pytest.raises(ValueError, match="length, width and spacing are above 0"):
        told(world, length=0.0)
    with pytest.raises(ValueError, match="spacing is too small"):
        told(world, spacing=1e-5)
    with pytest.raises(KernelError, match="did you mean 'left'"):
        told(world, sensors="lefft")
    for name in ("post", "fish"):
        with pytest.raises(KernelError, match=f"'{name}' is no camera_sensor that is a pinhole without distort"):
            told(world, sensors=name)
    with pytest.raises(KernelError, match=r"points are \(n, 3\) and finite"):
        world.seen("left", np.full((1, 3), np.nan))
