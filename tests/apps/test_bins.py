"""The cell of two bins, in steps in a real kernel: what falls, and what fingers hold of what a scanner sees."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot.cli import cli
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.demos.bins import cell, run
from virtualrobot_apps.seeing.grasping.heights import CELL, Heights

BOXES = 2


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
    result = run.main(client, 1, seed=1, effort=0.7 * cell.MASS * 9.81 / cell.FRICTION)
    assert (result.fallen, result.brought, result.tries) == (1, 0, run.TRIES)


def test_what_leaves_fingers_no_room_is_pushed_through_its_middle_from_beside_it() -> None:
    """From the free place nearest to it; a bin that is empty, or has no free place, is left alone."""
    rows, columns = np.indices(Heights.of(np.array([[*cell.FROM, 0.0]]), *run.OUTSIDE).heights.shape)
    places = run.OUTSIDE[0] + (np.stack([columns, rows], axis=-1) + 0.5) * CELL
    middle = np.array([cell.FROM[0] + 0.03, cell.FROM[1] - 0.02])
    away = np.abs(places - middle).max(axis=-1)
    lies = Heights(run.OUTSIDE[0], np.where(away < 0.05, run.BOTTOM + cell.EDGE, run.BOTTOM))
    way = run.push(lies)
    assert way is not None
    first, last = (pose[:2, 3] - middle for pose in way)
    assert 0.05 < np.abs(first).max() < 0.05 + 2.0 * run.SPREAD
    assert np.linalg.norm(last - first) == pytest.approx(run.STIRRED, abs=1e-6)
    assert np.abs(last).max() < 0.03 and way[0][2, 3] > run.BOTTOM
    assert run.push(Heights(run.OUTSIDE[0], np.full(away.shape, run.BOTTOM))) is None
    assert run.push(Heights(run.OUTSIDE[0], np.full(away.shape, run.BOTTOM + cell.EDGE))) is None


def test_a_box_on_a_heap_above_the_walls_is_in_the_bin_and_one_beside_it_is_not() -> None:
    x, y = cell.TO
    assert cell.holds(cell.TO, np.array([x, y, cell.TOP + 1.2 * cell.DEEP]))
    assert not cell.holds(cell.TO, np.array([x, y + 0.5 * cell.INSIDE + cell.WALL, cell.TOP + cell.DEEP]))
    assert not cell.holds(cell.TO, np.array([x, y, 0.02]))


@pytest.mark.parametrize(("arguments", "said"), [(("--boxes", "21"), "1<=x<=20"), (("--effort", "0"), "0.1<=x<=120.0")])
def test_wrong_usage_is_told(arguments: tuple[str, ...], said: str) -> None:
    result = CliRunner().invoke(cli, ["demo", "bins", *arguments])
    assert result.exit_code == 2 and said in result.output
