"""Bases on ways of their drives that are known ahead: where they will be is where they come, and they go no farther."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.api.motion_plans import contact_of
from virtualrobot_kernel.collision.joint_path import of_program
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.crafts.carrying import CarriedBases
from virtualrobot_kernel.world.commands import CreateNodes, StartMotion
from virtualrobot_kernel.world.craft_data import Craft
from virtualrobot_kernel.world.figures import Box, Figure
from virtualrobot_kernel.world.structure import JointType, Kind, NodeSpec

from tests.unit.collision.worlds import SHAPES
from tests.unit.crafts.rover import TWO_WHEELS, Yard, rover, yard
from tests.unit.crafts.test_crafts import planned
from tests.unit.crafts.test_ways import BICYCLE, CAR
from tests.unit.world.builders import TICK, shifted


def carried(course: Yard, command: StartMotion) -> CarriedBases:
    """Return the coordinates on the way of a motion of the rover's two drives."""
    snapshot = course.world.snapshot
    coordinates = snapshot.structure.robots[snapshot.structure.node("rover").uid].coordinates
    q_index = np.array([coordinates[name].q for _, name in command.joints], np.int32)
    path = of_program(snapshot.state.q, q_index, command.program)
    found = course.crafts.carried(snapshot.structure, path.at, path.travel, command.program.begins)
    assert found is not None
    return found


@pytest.mark.long
@pytest.mark.parametrize(
    ("craft", "goals"),
    [
        (TWO_WHEELS, {"left": 8.0, "right": 20.0}),
        (BICYCLE, {"left": 0.5, "right": 20.0}),
        (CAR, {"left": -0.4, "right": -15.0}),
    ],
    ids=["differential", "bicycle", "ackermann"],
)
@pytest.mark.parametrize("base", [JointType.PLANAR, pytest.param(JointType.FLOATING, marks=pytest.mark.long)])
def test_where_it_will_be_is_where_it_comes_and_no_farther(
    craft: Craft, goals: dict[str, float], base: JointType, rng: np.random.Generator
) -> None:
    """A steered one steers as it drives, so its way is cut; ticks of 4 ms are themselves off by 1e-6."""
    with yard(rover(craft, base)) as course:
        command = planned("rover", goals)
        ahead = carried(course, command)
        duration = command.program.duration
        assert ahead.wobble is None or ahead.wobble.max() < 1e-4
        course.do(command)
        places, told, gone = ahead.places, [ahead.at(0.0)], 0.0
        for _ in range(int(duration / TICK / 25)):
            now = course.step(25).state
            np.testing.assert_allclose(ahead.at(now.tick * TICK), now.q, atol=1e-5)
            told.append(now.q)
        assert np.abs(told[-1][places] - told[0][places]).max() > 0.5
        for first, last in np.sort(rng.uniform(0.0, duration, (20, 2))).tolist():
            between = np.array([ahead.at(time)[places] for time in np.linspace(first, last, 40)])
            gone = np.abs(np.diff(between, axis=0)).sum(axis=0)
            assert (gone <= ahead.travel(first, last)[places] + 1e-9).all()
        # No farther, but not as good as anywhere either: a stretch that is halved again and again ends.
        assert ahead.travel(0.5, 0.5 + 1e-6)[places].max() < 1e-4


def test_rates_of_bases_are_those_of_their_coordinates() -> None:
    with yard(rover(CAR)) as course:
        command = planned("rover", {"left": -0.4, "right": 15.0})
        ahead, h = carried(course, command), 1e-5
        time = command.program.duration / 2.0
        q, v = ahead.at(time), (ahead.at(time + h) - ahead.at(time - h)) / (2.0 * h)
        np.testing.assert_allclose(ahead.rates(q, v), v[ahead.places], atol=1e-5)


def test_a_check_sees_what_the_base_would_run_into_at_the_time_when_it_does() -> None:
    """The face of the wall is 0.9 m ahead of the middle, the hull reaches 0.3: wheels have to turn by 6 rad."""
    with yard(rover()) as course:
        wall = NodeSpec("wall", Kind.OBJECT, "world", shifted(x=1.0), figures=(Figure(Box((0.2, 4.0, 1.0))),))
        course.do(CreateNodes((wall,)))
        snapshot = course.world.snapshot
        for turned, touches in ((20.0, True), (5.99, False), (-20.0, False)):
            command = planned("rover", {"left": turned, "right": turned})
            bases = carried(course, command)
            scene, until = CollisionScene(SHAPES), command.program.duration
            found = contact_of(scene, snapshot, command, until, 1e-4, lambda: False, bases)
            assert (found is not None) == touches
            if found is not None:
                x = snapshot.structure.robots[snapshot.structure.node("rover").uid].coordinates["base/x"].q
                assert bases.at(found.time)[x] == pytest.approx(0.6, abs=2e-4)
