"""Brakes of the robots that are played are those of the way of the world, to the last bit, in whatever moves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from virtualrobot_kernel.drivers.brakes import Brakes
from virtualrobot_kernel.drivers.twin import ControllerJoint, columns, twin_of
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
from virtualrobot_kernel.world.state import Signal

from tests.unit.planning.cell import JOINTS, TICK, cell
from tests.unit.world.builders import after, ticked
from tests.unit.world.test_braking import another_setpoint, group, point_to_point, program, setpoints

CASES = 250
"""Random cases of each kind of motion."""


@pytest.mark.long
@pytest.mark.parametrize("made", [point_to_point, group, program, setpoints])
def test_they_are_those_of_the_way_of_the_world(
    made: Callable[[Change, np.random.Generator], list[Command]], rng: np.random.Generator
) -> None:
    """For both robots and for each alone; one controller has the joints in another order, and so not the motion's."""
    begun = after(cell(), CreateSignal(Signal("lamp", False)))
    structure = begun.structure
    turned = [ControllerJoint(name) for name in reversed(JOINTS)]
    arm, other, belt = (
        (twin.uid, columns(structure, twin)[0])
        for twin in (twin_of(structure, "arm", ()), twin_of(structure, "arm", turned), twin_of(structure, "belt", ()))
    )
    cells = [dict(places) for places in ([arm], [belt], [arm, belt], [other, belt])]
    kept = [Brakes(world_poses) for _ in cells]
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
            for places, brakes in zip(cells, kept, strict=True):
                way = braking_of(places.keys(), structure, change.state, TICK, world_poses)
                found = brakes.of(places, structure, change.state, TICK)
                assert way.ends and found is not None and found.keys() == places.keys()
                for uid, place in places.items():
                    assert np.array_equal(found[uid], way.positions[:, place])
                    moved += len(found[uid]) > 2
            change, cases = ticked(change, int(rng.integers(1, 8))), cases + 1
    assert moved > CASES
