"""A board on a cable plays what its twin in a kernel does."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import virtualrobot

from tests.api.asking import IIWA
from tests.drivers.boards import Board
from tests.drivers.cables import Cable
from tests.kernels import KernelProcess, Stubs

PATIENCE_SECONDS = 60.0


@pytest.fixture
def cable(tmp_path: Path) -> Iterator[Cable]:
    """Yield a cable with a board of seven joints."""
    cable = Cable(tmp_path)
    board = Board(cable, tmp_path, PINS=tuple(range(7)), WATCHDOG_MS=5000)
    yield cable
    board.close()
    cable.unplug()


@pytest.mark.long
def test_a_board_does_what_its_twin_does(kernel: KernelProcess, stubs: Stubs, cable: Cable) -> None:
    goal = np.array([0.2, -0.3, 0.1, -0.4, 0.0, 0.5, -0.1])
    with virtualrobot.connect(kernel.address) as client:
        arm = client.load_robot(IIWA, name="arm")
        client.collisions.set("guard")
        settings = {"port": str(cable.path), "silence_seconds": 2.0}
        status = client.drivers.connect("arm", "serial_line", settings, lead=0.4, following_limit=2.0)
        assert (status.controller.model, status.controller.joint_count) == ("six-servos", 7)
        with arm.lease():
            client.drivers.set_mode("arm", "execute")
            end = time.monotonic() + PATIENCE_SECONDS
            while client.drivers["arm"].state != "active":
                assert time.monotonic() < end, client.drivers["arm"]
            arm.move_joints(goal)
            while np.abs(np.array(client.drivers["arm"].positions) - goal).max() > 1e-3:
                assert time.monotonic() < end, client.drivers["arm"]
        client.drivers.disconnect("arm")
