"""The cell does its work: the block stands where it was put."""

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
    np.testing.assert_allclose(client.scene.pose("block")[:3, 3], [0.2, -0.35, 0.7755], atol=1e-3)
    assert client.scene.node("block").parent == "table"
