"""Setpoints before the gate, after each length of silence: whose fault it is that one may not go out is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from virtualrobot_sdk.drivers import About, DriverFault
from virtualrobot_sdk.drivers.outgoing import Outgoing
from virtualrobot_sdk.drivers.player import Player, Setpoint
from virtualrobot_sdk.drivers.robot_side import JointSide, Mapping, RobotSide
from virtualrobot_sdk.drivers.shared import CELL, CellBlock, TickRing

from tests.drivers.test_hosting import Controller
from tests.drivers.twin import TICK_NS

RATE = 100.0
SPEED = 2.0
"""Greatest speed of the joint, rad/s: the gate lets through 1.1 of it, after a silence that of three cycles (30 ms)."""

SIDE = RobotSide((JointSide("hip", 0, -3.0, 3.0, SPEED),), TICK_NS)


@pytest.mark.parametrize(
    ("way", "milliseconds", "told"),
    [
        (0.9 * SPEED * 0.01, 10, ""),
        (0.9 * SPEED * 0.03, 30, ""),
        (0.01, 500, ""),
        (0.9 * SPEED * 0.05, 50, "the driver had no cycle for 50 ms: the computer was too busy, or the controller's"),
        (0.9 * SPEED * 0.05, 10, "a setpoint of 'hip' is 0.09 from the one 10.0 ms before, and 0.022 is as far as"),
        (1.2 * SPEED * 0.05, 50, "a setpoint of 'hip' is 0.12 from the one 50.0 ms before, and 0.11 is as far as"),
    ],
)
def test_a_silence_is_told_apart_from_a_jump(tmp_path: Path, way: float, milliseconds: int, told: str) -> None:
    """A step that the joint's own speed explains in the time that has gone is a silence; any other is a jump."""
    cell, ring = CellBlock.create(tmp_path / CELL), TickRing.create(tmp_path / "ring", 1)
    out = Outgoing(Controller(), SIDE, cell)
    out.send(Setpoint(np.zeros(1), np.zeros(1), 0), 0, Mapping(SIDE, About(1, RATE)))
    player, there = Player(ring, cell, TICK_NS), Setpoint(np.array([way]), np.zeros(1), 0)
    if not told:
        assert out.passed(there, player, milliseconds * 1_000_000, RATE) is there
        return
    with pytest.raises(DriverFault) as refused:
        out.passed(there, player, milliseconds * 1_000_000, RATE)
    assert str(refused.value).startswith(told), str(refused.value)
    assert str(refused.value).endswith("nothing was sent")
