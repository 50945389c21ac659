"""The fetch in steps in a real kernel: what stands on the shelf comes to the table, where the true room judges."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.demos.carry.cell import SIZE
from virtualrobot_apps.demos.fetch import cell, run
from virtualrobot_apps.seeing.navigation.poses import compose


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_what_stands_on_the_shelf_comes_to_the_table(seed: int, capsys: pytest.CaptureFixture[str]) -> None:
    """It stands on the table, upright, as near to its place as the vehicle knows its own: 0.1 m."""
    pytest.importorskip("pyoctomap", reason="pip install pyoctomap")
    with KernelProcess("--stepped", headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        result = run.main(client, seed)
        pose = client.scene.pose(cell.THING)
        assert client.scene.node(cell.THING).parent == "world"
    assert result.touched and result.off < 0.1, capsys.readouterr().out
    assert pose[2, 3] == pytest.approx(cell.HIGH + 0.5 * SIZE[2], abs=0.01)
    assert pose[2, 2] > np.cos(0.05)


@pytest.mark.parametrize("name", list(cell.PLACES))
def test_a_place_is_ahead_of_the_arm_where_the_vehicle_stands_before_it(name: str) -> None:
    """By the arm's mount, 0.2 m ahead of the base; a vehicle that is 0.1 m too far to the left has it to the right."""
    np.testing.assert_allclose(
        cell.base_t_place(cell.before(name, cell.NEAR), name), [cell.NEAR - 0.2, 0.0], atol=1e-12
    )
    off = compose(cell.before(name, cell.NEAR), np.array([0.0, 0.1, 0.0]))
    np.testing.assert_allclose(cell.base_t_place(off, name), [cell.NEAR - 0.2, -0.1], atol=1e-12)
