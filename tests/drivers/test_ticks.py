"""Ticks in the rings of robots that are played: as `put` writes them, with the way of the world, in whatever moves."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from virtualrobot_kernel.drivers.link import Link
from virtualrobot_kernel.drivers.ticks import Ticks
from virtualrobot_kernel.drivers.twin import Asked, ControllerJoint, twin_of
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.braking import braking_of
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import (
    Command,
    CreateSignal,
    PauseMotion,
    SetSpeedFactor,
    StopMotions,
)
from virtualrobot_kernel.world.state import Signal, Snapshot
from virtualrobot_kernel.world.structure import Structure
from virtualrobot_sdk.drivers import About
from virtualrobot_sdk.drivers.shared import BRAKE_ROWS, SLOTS, TickRing

from tests.unit.planning.cell import JOINTS, TICK, cell
from tests.unit.world.builders import after, ticked
from tests.unit.world.test_braking import another_setpoint, group, point_to_point, program, setpoints

CASES = 250
"""Random cases of each kind of motion."""

HEAD = 6
"""Words of a tick before its joints."""


def linked(structure: Structure, folder: Path, robot: str, joints: list[ControllerJoint]) -> Link:
    """Return the link of a robot without a process, with a ring of its own."""
    twin = twin_of(structure, robot, joints)
    count = len(twin.joints)
    ring = TickRing.create(folder / f"ring-{len(list(folder.iterdir()))}", count)
    return Link(twin, Asked("sham", {}), mock.Mock(), ring, About(count, 100.0))


def snapshot(change: Change) -> Snapshot:
    """Return the picture of a world, as far as brakes look at it."""
    return Snapshot(change.structure, change.state, np.empty(0), 0, 0.0, TICK)


def check(change: Change, ticks: Ticks, links: list[Link], oracle: dict[int, TickRing], due: int) -> int:
    """Write a tick in both ways, which must come to the same bits; return the number of rows of its brakes."""
    state = change.state
    braked = ticks.write(snapshot(change), due, links)
    way = braking_of({link.twin.uid for link in links}, change.structure, state, TICK, world_poses)
    rows = len(way.positions) if way.ends else 0
    assert braked == (0 < rows <= BRAKE_ROWS)
    for link in links:
        at_q, at_v = link.places(change.structure)
        ring = oracle[link.twin.uid]
        brake = way.positions[:, at_q] if way.ends else None
        ring.put(state.tick, due + link.lead_ns, state.q[at_q], state.v[at_v], link.outputs, brake)
        words = HEAD + (2 + (rows if braked else 0)) * ring.joints
        place = state.tick % SLOTS
        assert np.array_equal(link.ring.slots[place, :words], ring.slots[place, :words])
        record = link.ring.get(state.tick)
        assert record is not None and (record.brake is None) == (not braked)
    return rows


@pytest.mark.long
@pytest.mark.parametrize("made", [point_to_point, group, program, setpoints])
def test_they_are_those_of_the_way_of_the_world(
    made: Callable[[Change, np.random.Generator], list[Command]], rng: np.random.Generator, tmp_path: Path
) -> None:
    """For both robots and for each alone; one controller has the joints in another order, and so not the motion's."""
    begun = after(cell(), CreateSignal(Signal("lamp", False)))
    structure = begun.structure
    turned = [ControllerJoint(name) for name in reversed(JOINTS)]
    arm, other, belt = (linked(structure, tmp_path, *of) for of in (("arm", []), ("arm", turned), ("belt", [])))
    oracle = {
        link.twin.uid: TickRing.create(tmp_path / f"oracle-{link.twin.uid}", link.ring.joints) for link in (arm, belt)
    }
    cells = [[arm], [belt], [arm, belt], [other, belt]]
    kept = [Ticks(world_poses) for _ in cells]
    cases = moved = 0
    while cases < CASES:
        change = after(begun, *made(begun, rng))
        while change.state.motions and cases < CASES:
            chance, motion = rng.random(), change.state.motions[0]
            change = after(change, *another_setpoint(change, rng))
            if chance < 0.02:
                change = after(change, SetSpeedFactor("", float(rng.uniform(0.1, 1.0))))
            elif chance < 0.03:
                change = after(change, PauseMotion(motion.id))
            elif chance < 0.05:
                change = after(change, StopMotions())
            for links, ticks in zip(cells, kept, strict=True):
                for link in links:
                    link.outputs = int(rng.integers(2**64, dtype=np.uint64)) if rng.random() < 0.1 else link.outputs
                moved += check(change, ticks, links, oracle, int(rng.integers(2**62))) > 2
            change, cases = ticked(change, int(rng.integers(1, 8))), cases + 1
    assert moved > CASES


def test_a_brake_that_is_too_long_is_left_out(tmp_path: Path, rng: np.random.Generator) -> None:
    """And the next tick has one again: what is found of one tick is nothing to the next."""
    begun = cell()
    link = linked(begun.structure, tmp_path, "arm", [])
    oracle = {link.twin.uid: TickRing.create(tmp_path / "oracle", link.ring.joints)}
    ticks = Ticks(world_poses)
    change = ticked(after(begun, *point_to_point(begun, rng)), 5)
    rows = check(change, ticks, [link], oracle, 7)
    assert rows > 2
    with mock.patch("virtualrobot_kernel.drivers.ticks.LONGEST_BRAKE_TICKS", rows - 1):
        assert not ticks.write(snapshot(change), 7, [link])
    record = link.ring.get(change.state.tick)
    assert record is not None and record.brake is None
    check(ticked(change, 1), ticks, [link], oracle, 8)
