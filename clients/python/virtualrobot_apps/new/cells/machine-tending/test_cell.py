"""The cell does its work: all parts are on the other side of the table and the door is open."""

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
    programs = [client.read_program(HERE / name) for name in ("program.yaml", "machine.yaml")]
    assert [program.check().first_violation for program in programs] == [None, None]
    for motion in [program.start(wait=False) for program in programs]:
        motion.wait()
    for number, x in enumerate((-0.15, 0.0, 0.15), 1):
        np.testing.assert_allclose(client.scene.pose(f"part {number}")[:3, 3], [x, 0.5, 0.7755], atol=1e-3)
    np.testing.assert_allclose(client.robot("machine").positions, [0.7], atol=1e-6)
