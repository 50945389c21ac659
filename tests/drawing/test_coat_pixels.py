"""Coats in the viewer: pixels of its page in a real browser."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.sensing.coats import Coat, Legend, Skin
from virtualrobot_kernel.sensing.color_maps import ColorMap
from virtualrobot_kernel.world.commands import RemoveNode, UpdateNode
from virtualrobot_kernel.world.figures import Box

from tests.drawing.cell import at
from tests.drawing.conftest import Stage
from tests.drawing.test_viewer_pixels import is_background, is_green, painted

pytestmark = pytest.mark.long

COUNT = 80


def is_white(color: np.ndarray) -> bool:
    return bool(color.min() > 170)


def test_a_coat_is_seen_where_it_has_values_and_follows_its_node(stage: Stage) -> None:
    """A square of 80 x 80 corners before a green cube; heat is white at the highest value and red between."""
    stage.cell.add("cube", painted(Box((1.0, 1.0, 1.0)), 0.0, 1.0, 0.0))
    x, z = (grid.ravel() for grid in np.meshgrid(np.linspace(-0.5, 0.5, COUNT), np.linspace(-0.5, 0.5, COUNT)))
    corner = (np.arange(COUNT - 1)[:, None] * COUNT + np.arange(COUNT - 1)).ravel()
    halves = [corner, corner + 1, corner + COUNT], [corner + 1, corner + COUNT + 1, corner + COUNT]
    faces = np.concatenate([np.stack(half, axis=1) for half in halves])
    skin = Skin(np.stack([x, np.full_like(x, -0.501), z], 1).astype(np.float32), faces.astype(np.int32))
    right = np.where(x > 0.0, 255, 0).astype(np.uint8)
    stage.wait(lambda: is_green(stage.pixel(0.25, 0.0)))
    legend = Legend(ColorMap.HEAT, 0.0, 50.0, "µm", "Film <b>")
    stage.coats.set(Coat("film", stage.cell.uid("cube"), skin, right, legend), {stage.cell.uid("cube")})
    stage.wait(lambda: is_white(stage.pixel(0.25, 0.0)))
    assert is_green(stage.pixel(-0.25, 0.0))
    assert "Film <b>" in stage.page.content() or "Film &lt;b&gt;" in stage.page.content()
    stage.coats.paint("film", 0, (255 - right).astype(np.uint8))
    stage.wait(lambda: is_white(stage.pixel(-0.25, 0.0)) and is_green(stage.pixel(0.25, 0.0)))
    stage.cell.do(UpdateNode("cube", parent_t_node=at(0.6, 0.0, 0.0)))
    stage.wait(lambda: is_white(stage.pixel(0.35, 0.0)) and is_background(stage.pixel(-0.25, 0.0)))
    stage.cell.do(UpdateNode("cube", hidden=True))
    stage.wait(lambda: is_background(stage.pixel(0.35, 0.0)))
    stage.cell.do(UpdateNode("cube", hidden=False))
    stage.wait(lambda: is_white(stage.pixel(0.35, 0.0)))
    stage.coats.remove(())
    stage.wait(lambda: is_green(stage.pixel(0.35, 0.0)))
    stage.coats.set(Coat("film", stage.cell.uid("cube"), skin, 255 - right, legend), {stage.cell.uid("cube")})
    stage.wait(lambda: is_white(stage.pixel(0.35, 0.0)))
    stage.cell.do(RemoveNode("cube"))
    stage.wait(lambda: is_background(stage.pixel(0.35, 0.0)))
