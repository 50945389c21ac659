"""The cell does its work: each box stands in its place of the pallet."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot.kernel_process import KernelProcess

HERE = Path(__file__).parent


@pytest.fixture
def client() -> Iterator[virtualrobot.Client]:
    """Return a client of a kernel with this cell, whose time goes by twenty times as fast."""
    with KernelProcess(headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        client.clock.set_realtime(20.0)
        client.scene.load_scene(HERE / "cell.yaml")
        yield client


def test_the_cell_does_its_work(client: virtualrobot.Client) -> None:
    """Its program keeps all limits and touches nothing; after it everything is where it belongs."""
    program = client.read_program(HERE / "program.yaml")
    assert program.check().first_violation is None
    program.start()
    turned = virtualrobot.pose(2.4, 0.95, 0.4, yaw=np.pi)
    for number in range(8):
        layer, place = divmod(number, 4)
        column, row = (divmod(place, 2)[0] - 0.5) * 0.17, (divmod(place, 2)[1] - 0.5) * 0.13
        x, y = (-row, column) if layer else (column, row)
        found = client.scene.pose(f"box {number + 1}")
        expected = turned @ virtualrobot.pose(x, y, 0.0615 + 0.1205 * layer)
        np.testing.assert_allclose(found[:3, 3], expected[:3, 3], atol=2e-3)
