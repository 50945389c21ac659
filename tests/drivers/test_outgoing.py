"""Setpoints before the gate, after each length of silence: whose fault it is that one may not go out is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from virtualrobot_sdk.drivers import About, DriverFault
from virtualrobot_sdk.drivers.outgoing import Outgoing
from virtualrobot_sdk.drivers.player import Play, Player, Setpoint
from virtualrobot_sdk.drivers.robot_side import JointSide, Mapping, RobotSide
from virtualrobot_sdk.drivers.shared import CELL, NEVER, CellBlock, TickRing

from tests.drivers.test_hosting import Controller
from tests.drivers.twin import DECELERATION, PERIOD, TICK_NS, Twin

RATE = 100.0
SPEED = 2.0
"""Greatest speed of the joint, rad/s: the gate lets through 1.1 of it, after a silence that of three cycles (30 ms)."""

SIDE = RobotSide((JointSide("hip", 0, -3.0, 3.0, SPEED),), TICK_NS)


@pytest.mark.parametrize(
    ("way", "milliseconds", "told"),
    [
        (0.9 * SPEED * 0.01, 10, ""),
        (0.9 * SPEED * 0.03, 30, ""),
        (0.9 * SPEED * 0.05, 50, "the driver had no cycle for 50 ms: the computer was too busy, or the controller's"),
        (0.9 * SPEED * 0.05, 10, "a setpoint of 'hip' is 0.09 from the one 10.0 ms before, and 0.022 is as far as"),
        (1.2 * SPEED * 0.05, 50, "a setpoint of 'hip' is 0.12 from the one 50.0 ms before, and 0.11 is as far as"),
    ],
)
def test_a_silence_is_told_apart_from_a_jump(tmp_path: Path, way: float, milliseconds: int, told: str) -> None:
    """A step that the joint's own speed explains in the time that has gone is a silence; any other is a jump."""
    cell, ring = CellBlock.create(tmp_path / CELL), TickRing.create(tmp_path / "ring", 1)
    out = Outgoing(Controller(), SIDE, lambda why: cell.stop())
    out.send(Setpoint(np.zeros(1), np.zeros(1), 0), 0, Mapping(SIDE, About(1, RATE)))
    player, there = Player(ring, cell, TICK_NS), Setpoint(np.array([way]), np.zeros(1), 0)
    if not told:
        assert out.passed(there, player, milliseconds * 1_000_000, 0, RATE) is there
        return
    with pytest.raises(DriverFault) as refused:
        out.passed(there, player, milliseconds * 1_000_000, 0, RATE)
    assert str(refused.value).startswith(told), str(refused.value)
    assert str(refused.value).endswith("nothing was sent")


@pytest.mark.parametrize(
    ("elapsed", "late", "moves", "told"),
    [
        (10, 100, True, "the driver came 100 ms late to its cycle: the computer was too busy, or the driver"),
        (100, 0, True, "the driver had no cycle for 100 ms: the computer was too busy, or the controller's"),
        (10, 49, True, ""),
        (50, 0, True, ""),
        (10, 100, False, ""),
        (100, 0, False, ""),
    ],
)
def test_a_host_that_is_late_brakes_on_the_path(
    tmp_path: Path, elapsed: int, late: int, moves: bool, told: str
) -> None:
    """By more than the half of a lead of 0.1 s, in motion: it goes on by its brake from where it is, and is told so.

    The twin swings by 0.3 rad in 1 s, so it is never faster than 0.3 π / 2 rad/s (its formula): slow enough for the
    gate to let through what it does in 100 ms.
    """
    cell, ring = CellBlock.create(tmp_path / CELL), TickRing.create(tmp_path / "ring", 1)
    side = RobotSide((JointSide("hip", 0, -3.0, 3.0, 10.0),), TICK_NS)
    controller = Controller()
    stops: list[str] = []

    def stop(why: str) -> None:
        stops.append(why)
        cell.stop()

    out, player, mapping = Outgoing(controller, side, stop), Player(ring, cell, TICK_NS), Mapping(side, About(1, RATE))
    twin = Twin({ring: np.array([0.3])}, cell, 0, side.lead_ns)
    twin.swings = moves
    period, ns = 10_000_000, 0
    out.send(Setpoint(np.zeros(1), np.zeros(1), 0), ns, mapping)

    def cycle(lateness_ns: int = 0) -> float:
        twin.write((ns + lateness_ns) // TICK_NS)
        due = player.step(ns)
        setpoint = out.held if due is None else out.passed(due, player, ns, lateness_ns, RATE)
        out.send(setpoint, ns, mapping)
        return float(setpoint.q[0])

    went = [cycle()]
    while ns < 500_000_000:
        ns += period
        went.append(cycle())
    ns += elapsed * 1_000_000
    went.append(cycle(late * 1_000_000))
    assert out.refused.startswith(told) and bool(out.refused) == bool(told)
    assert stops == ([out.refused] if told else [])
    if not told:
        return
    assert out.refused.endswith("it was not sent, and the robot braked before it")
    ns += late * 1_000_000
    while player.state is not Play.RESTS:
        ns += period
        went.append(cycle())
    steps = np.diff(went)
    assert cell.stop_ns != NEVER
    assert (steps >= 0.0).all() and steps.max() <= 0.3 * np.pi / PERIOD * period * 1e-9 + 1e-9
    # It brakes as its twin would: each step is shorter by what that is slower after a cycle.
    assert np.abs(np.diff(steps)).max() <= 1.1 * DECELERATION * (period * 1e-9) ** 2
