"""Reset of a controller whose fault has ended the connection: the host connects for it, since drivers need that."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_plugins.drivers.loopback.driver import Loopback
from virtualrobot_plugins.drivers.loopback.settings import Fault, LoopbackSettings
from virtualrobot_sdk.drivers import About, Mode, Words, realtime
from virtualrobot_sdk.drivers.host import Host
from virtualrobot_sdk.drivers.robot_side import JointSide, RobotSide
from virtualrobot_sdk.drivers.shared import CELL, CellBlock, State, TickRing

SIDE = RobotSide(tuple(JointSide(f"joint_{i}", i, -3.0, 3.0, 2.0) for i in range(2)))


@pytest.fixture
def driver() -> Loopback:
    return Loopback(LoopbackSettings(joints=2, rate=50.0))


@pytest.fixture
def host(driver: Loopback, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Host]:
    # It is a thread of this process here, which goes on as it was.
    monkeypatch.setattr(realtime, "calm", lambda: "ordinary")
    cell, ring = CellBlock.create(tmp_path / CELL), TickRing.create(tmp_path / "ring", 2)
    host = Host(driver, SIDE, ring, cell)
    host.start()
    yield host
    host.close()
    ring.close()
    cell.close()


def test_motors_are_switched_on_after_a_loss_of_power(host: Host, driver: Loopback) -> None:
    assert isinstance(host.connect(), About)
    driver.controller.cause(Fault("power", 0, value=1e9))
    while host.state is not State.ERROR:
        time.sleep(0.01)
    assert "connection to loopback is lost" in host.words().text
    refused = host.reset()
    assert "nobody answers at loopback" in refused.text, "its power is away still"
    driver.controller.mend()
    assert host.reset() == Words()
    assert host.state is State.ERROR
    assert isinstance(host.connect(), About)
    assert driver.read().mode is Mode.READY
    np.testing.assert_array_equal(driver.controller.q, [0.0, 0.0])
