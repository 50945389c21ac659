"""The cell does its work: the parts are in the tray, though the belt has not stopped for the arm."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import program
import pytest
import virtualrobot
from virtualrobot.kernel_process import KernelProcess

HERE = Path(__file__).parent


@pytest.fixture
def client() -> Iterator[virtualrobot.Client]:
    """Return a client of a kernel with this cell; its time is that of the wall, since the belt runs while it plans."""
    with KernelProcess(headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        client.scene.load_scene(HERE / "cell.yaml")
        yield client


def test_the_cell_does_its_work(client: virtualrobot.Client) -> None:
    """Each part is picked from the belt while that runs, and stands in its place of the tray."""
    program.run(client)
    for name, y in zip(program.PARTS, (0.87, 0.63), strict=True):
        np.testing.assert_allclose(client.scene.pose(name)[:3, 3], [0.3, y, 0.526], atol=2e-3)
    assert client.robot("conveyor").positions[0] > 0.5
