"""Ghosts of robots: pixels of the viewer's page in a real browser."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.drawing.view import Ghost
from virtualrobot_kernel.world.commands import RemoveNode, SetJointPositions, UpdateNode
from virtualrobot_kernel.world.figures import Box
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, LinkData

from tests.drawing.cell import at
from tests.drawing.conftest import Stage
from tests.drawing.test_viewer_pixels import is_background, is_green, painted

pytestmark = pytest.mark.long


def is_ghost(color: np.ndarray) -> bool:
    """Return whether red is mixed with the background (51, 102, 153), which is seen through it."""
    return bool(color[0] > 90 and color[2] > 40)


def is_translucent(color: np.ndarray) -> bool:
    """Return whether something is seen with the background behind it."""
    return not is_background(color) and not is_green(color) and bool(color[2] > 40)


def add_slide(stage: Stage) -> None:
    """Add a slide whose green cube of 0.4 m goes along x."""
    stage.cell.add("slide", kind=Kind.ROBOT)
    data = LinkData(Joint("j", JointType.PRISMATIC, axis=(1.0, 0.0, 0.0)))
    stage.cell.add("cube", painted(Box((0.4, 0.4, 0.4)), 0.0, 1.0, 0.0), parent="slide", kind=Kind.LINK, data=data)
    stage.wait(lambda: is_green(stage.pixel(0.0, 0.0)))


def test_a_ghost_is_translucent_where_the_robot_would_be_and_follows_its_base(stage: Stage) -> None:
    add_slide(stage)
    ghost = Ghost("goals", stage.cell.uid("slide"), ((-1.0,), (1.0,)), (1.0, 0.0, 0.0), 0.5)
    stage.view.update(ghosts=(ghost,))
    stage.wait(lambda: is_ghost(stage.pixel(-1.0, 0.0)) and is_ghost(stage.pixel(1.0, 0.0)))
    assert is_green(stage.pixel(0.0, 0.0)) and is_background(stage.pixel(0.5, 0.0))
    stage.cell.do(SetJointPositions("slide", {"j": 0.5}))
    stage.wait(lambda: is_green(stage.pixel(0.5, 0.0)))
    assert is_ghost(stage.pixel(1.0, 0.0)), "it stays while the robot moves"
    stage.cell.do(UpdateNode("slide", parent_t_node=at(0.0, 0.0, 0.6)))
    stage.wait(lambda: is_ghost(stage.pixel(1.0, 0.6)) and is_background(stage.pixel(1.0, 0.0)))
    stage.view.update(ghosts=())
    stage.wait(lambda: is_background(stage.pixel(1.0, 0.6)) and is_background(stage.pixel(-1.0, 0.6)))
    stage.view.update(ghosts=(ghost,))
    stage.wait(lambda: is_ghost(stage.pixel(-1.0, 0.6)))
    stage.cell.do(RemoveNode("slide"))
    stage.wait(lambda: is_background(stage.pixel(-1.0, 0.6)) and is_background(stage.pixel(0.5, 0.6)))


def test_a_real_robot_that_is_elsewhere_is_a_ghost_that_moves_with_it(stage: Stage) -> None:
    """It is gone where robot and twin are together, and comes again."""
    add_slide(stage)
    uid = stage.cell.uid("slide")
    stage.measured[uid] = np.array([1.0])
    stage.wait(lambda: is_translucent(stage.pixel(1.0, 0.0)))
    assert is_green(stage.pixel(0.0, 0.0))
    stage.measured[uid] = np.array([-1.0])
    stage.wait(lambda: is_translucent(stage.pixel(-1.0, 0.0)) and is_background(stage.pixel(1.0, 0.0)))
    stage.measured[uid] = np.array([0.001])
    stage.wait(lambda: is_background(stage.pixel(-1.0, 0.0)))
    stage.cell.do(SetJointPositions("slide", {"j": 1.0}))
    stage.wait(lambda: is_green(stage.pixel(1.0, 0.0)) and is_translucent(stage.pixel(0.0, 0.0)))
    stage.measured.clear()
    stage.wait(lambda: is_background(stage.pixel(0.0, 0.0)))
