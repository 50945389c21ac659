"""The cell of two bins, in steps in a real kernel: what falls, what fingers hold, and which grasps are free."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot.cli import cli
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.demos.bins import cell, run
from virtualrobot_apps.demos.bins.grasps import grasps

BOXES = 3


@pytest.fixture(scope="module")
def client() -> Iterator[virtualrobot.Client]:
    with KernelProcess("--stepped", headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        yield client


@pytest.mark.long
@pytest.mark.parametrize("engine", ["mujoco", "bullet"])
def test_boxes_fall_into_a_bin_and_are_brought_to_the_other(client: virtualrobot.Client, engine: str) -> None:
    result = run.main(client, BOXES, seed=1, engine=engine)
    assert (result.fallen, result.brought) == (BOXES, BOXES)
    assert len(result.seconds) == BOXES <= result.tries


@pytest.mark.long
def test_a_motor_that_is_too_weak_lifts_nothing(client: virtualrobot.Client) -> None:
    """Friction needs m g / mu = 1.6 N of the one motor of both fingers (Coulomb)."""
    result = run.main(client, BOXES, seed=1, effort=0.7 * cell.MASS * 9.81 / cell.FRICTION)
    assert (result.fallen, result.brought, result.tries) == (BOXES, 0, run.TRIES * BOXES)


def box_at(x: float, y: float, yaw: float = 0.0) -> np.ndarray:
    return virtualrobot.pose(cell.FROM[0] + x, cell.FROM[1] + y, cell.TOP + 0.03, yaw=yaw)


def test_fingers_close_along_an_edge_that_is_free() -> None:
    """Two boxes side by side along y, 5 mm apart: only along x is there room for a finger of 10 mm."""
    first, second = box_at(0.0, 0.0), box_at(0.0, cell.EDGE + 0.005)
    best, worst = grasps({"first": first}, cell.FROM), grasps({"first": first, "second": second}, cell.FROM)
    assert len(best) == 2 and len(worst) == 4 and all(one.room > 0.0 for one in best)
    assert [abs(one.world_t_tcp[0, 1]) > 0.99 for one in worst] == [True, True, False, False]
    assert worst[0].room > 0.0 > worst[-1].room
    for one in worst:
        turn = one.world_t_tcp[:3, :3]
        assert np.allclose(turn @ turn.T, np.eye(3)) and np.linalg.det(turn) > 0 and turn[2, 2] == -1.0


def test_a_box_at_a_wall_is_gripped_along_it() -> None:
    at_wall = box_at(0.5 * (cell.INSIDE - cell.EDGE), 0.0)
    found = grasps({"box": at_wall}, cell.FROM)
    assert abs(found[0].world_t_tcp[1, 1]) > 0.99 and found[0].room > 0.0 > found[1].room


def test_a_box_that_stands_on_an_edge_is_gripped_along_it() -> None:
    tilted = virtualrobot.pose(cell.FROM[0], cell.FROM[1], cell.TOP + 0.04, np.radians(40.0), 0.0, 0.0)
    (only,) = grasps({"box": tilted}, cell.FROM)
    assert abs(only.world_t_tcp[0, 1]) > 0.99


@pytest.mark.parametrize(("arguments", "said"), [(("--boxes", "16"), "1<=x<=15"), (("--effort", "0"), "0.1<=x<=120.0")])
def test_wrong_usage_is_told(arguments: tuple[str, ...], said: str) -> None:
    result = CliRunner().invoke(cli, ["demo", "bins", *arguments])
    assert result.exit_code == 2 and said in result.output
