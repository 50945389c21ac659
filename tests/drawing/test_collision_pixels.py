"""What people see of collisions: pixels of the viewer's page in a real browser."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.collision.clearances import Clearance
from virtualrobot_kernel.collision.report import Touch
from virtualrobot_kernel.collision.scene import Collision
from virtualrobot_kernel.collision.touching import Contacts
from virtualrobot_kernel.drawing.alarm import alarmed
from virtualrobot_kernel.drawing.view import Camera
from virtualrobot_kernel.world.commands import RemoveNode, UpdateNode
from virtualrobot_kernel.world.figures import Box, Sphere

from tests.drawing.cell import at
from tests.drawing.conftest import FRONT, WIDTH, Stage
from tests.drawing.test_viewer_pixels import is_background, is_green, is_red, painted

ROSE = 255 * np.array(alarmed((0.2, 0.4, 0.6)))


def is_rose(color: np.ndarray) -> bool:
    return bool(np.abs(color - ROSE).max() <= 2)


def touch(stage: Stage, first: str, second: str, *points: tuple[float, float, float]) -> Touch:
    contacts = (Contacts(np.array(points), np.array([1.0, 0.0, 0.0])),) if points else ()
    pair = Collision(stage.cell.uid(first), stage.cell.uid(second), contacts)
    return Touch(pair, (first, second), 0, 0.0, tolerated=False)


@pytest.fixture
def boxes(stage: Stage) -> Stage:
    """Show three equal green boxes beside each other."""
    for name, x in (("left", -1.0), ("middle", 0.0), ("right", 1.0)):
        stage.cell.add(name, painted(Box((0.5, 0.5, 0.5)), 0.0, 1.0, 0.0), pose=at(x, 0.0, 0.0))
    stage.wait(lambda: all(is_green(stage.pixel(x, 0.0)) for x in (-1.0, 0.0, 1.0)))
    return stage


@pytest.mark.long
def test_what_collides_is_red_before_a_rose_background_and_gets_its_colours_back(boxes: Stage) -> None:
    boxes.touching = (touch(boxes, "left", "middle"),)
    boxes.wait(lambda: is_red(boxes.pixel(-1.0, 0.0)) and is_red(boxes.pixel(0.0, 0.0)))
    assert is_green(boxes.pixel(1.0, 0.0)) and is_rose(boxes.pixel(0.5, 0.8))
    boxes.touching = (touch(boxes, "middle", "right"),)
    boxes.wait(lambda: is_green(boxes.pixel(-1.0, 0.0)) and is_red(boxes.pixel(1.0, 0.0)))
    boxes.cell.do(UpdateNode("right", parent_t_node=at(1.0, 0.0, 0.8)))  # red things move, too
    boxes.wait(lambda: is_red(boxes.pixel(1.0, 0.8)) and is_rose(boxes.pixel(1.0, 0.0)))
    boxes.touching = ()
    boxes.wait(lambda: is_green(boxes.pixel(0.0, 0.0)) and is_green(boxes.pixel(1.0, 0.8)))
    assert is_background(boxes.pixel(0.5, -0.8))


def test_it_can_be_switched_off(boxes: Stage) -> None:
    boxes.touching = (touch(boxes, "left", "middle"),)
    boxes.wait(lambda: is_red(boxes.pixel(0.0, 0.0)))
    boxes.view.update(collisions_hidden=True)
    boxes.wait(lambda: is_green(boxes.pixel(0.0, 0.0)) and is_background(boxes.pixel(0.5, 0.8)))
    boxes.view.update(collisions_hidden=False)
    boxes.wait(lambda: is_red(boxes.pixel(0.0, 0.0)) and is_rose(boxes.pixel(0.5, 0.8)))


def test_dots_tell_where_it_touches(boxes: Stage) -> None:
    """From 1.2 m away a dot of 2 cm is 6 pixels wide."""
    boxes.view.update(camera=Camera((0.0, -1.2, 0.0), (0.0, 0.0, 0.0), FRONT.field_of_view))
    boxes.touching = (touch(boxes, "left", "middle", (0.0, -0.27, 0.0)),)

    def yellow() -> int:
        pixels = boxes.pixels().astype(int)
        return int(((pixels[..., 0] > 200) & (pixels[..., 1] > 160) & (pixels[..., 2] < 90)).sum())

    boxes.wait(lambda: 20 < yellow() < 150)
    boxes.touching = ()
    boxes.wait(lambda: yellow() == 0)


def test_a_node_that_collides_may_be_removed(boxes: Stage) -> None:
    boxes.touching = (touch(boxes, "left", "middle"),)
    boxes.wait(lambda: is_red(boxes.pixel(-1.0, 0.0)))
    boxes.cell.do(RemoveNode("left"))
    boxes.wait(lambda: is_rose(boxes.pixel(-1.0, 0.0)))
    assert is_red(boxes.pixel(0.0, 0.0))


def test_glass_stays_glass(stage: Stage) -> None:
    stage.cell.add("inside", painted(Box((0.3, 0.3, 0.3)), 0.0, 0.0, 1.0))
    stage.cell.add("glass", painted(Sphere(0.6), 0.0, 1.0, 0.0, 0.3), pose=at(0.0, -0.7, 0.0))

    def blue(x: float) -> float:
        color = stage.pixel(x, 0.0)
        return float(color[2] - color[0])

    stage.wait(lambda: blue(0.0) > 60)
    stage.touching = (touch(stage, "glass", "inside"),)
    stage.wait(lambda: is_red(stage.pixel(0.0, 0.0)))
    rim = stage.pixels()[:, WIDTH // 2 + 40].astype(int)
    assert (rim[:, 1] > 40).any(), "the background is seen through it"


@pytest.mark.long
def test_a_least_distance_is_a_line_that_follows(stage: Stage) -> None:
    """From the surface of one ball to that of another: between x = -0.75 and where the other begins."""
    stage.view.update(background=(1.0, 1.0, 1.0))
    for name, x in (("left", -1.0), ("right", 1.0)):
        stage.cell.add(name, painted(Sphere(0.25), 0.0, 1.0, 0.0), pose=at(x, 0.0, 0.0))
    stage.wait(lambda: is_green(stage.pixel(1.0, 0.0)))

    def teal(x: float, z: float) -> bool:
        rows = [stage.pixel(x, z + dz) for dz in (-0.01, 0.0, 0.01)]
        return any(color[0] < 110 and color[2] > color[0] + 30 for color in rows)

    stage.view.update(clearances=(Clearance("gap", (stage.cell.uid("left"),)),))
    stage.wait(lambda: teal(-0.5, 0.0) and teal(0.5, 0.0))
    assert not teal(0.5, 0.5)
    stage.cell.do(UpdateNode("right", parent_t_node=at(0.5, 0.0, 0.0)))
    stage.wait(lambda: teal(-0.6, 0.0) and not teal(0.6, 0.0))
    stage.view.update(clearances=())
    stage.wait(lambda: not teal(-0.6, 0.0))
