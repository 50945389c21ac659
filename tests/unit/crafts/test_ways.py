"""Ways of crafts to goals: no narrower than their components turn, and driven by these they end at the goal."""

from __future__ import annotations

import math

import numpy as np
import pytest
from virtualrobot_kernel.crafts.craft import CraftAtWork
from virtualrobot_kernel.crafts.ways import Goal, least_radius, way_to
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world.commands import SetJointPositions
from virtualrobot_kernel.world.craft_data import Craft, CraftDrive
from virtualrobot_kernel.world.structure import JointType

from tests.unit.crafts.rover import RADIUS, TWO_WHEELS, Yard, rover, yard

BASE, LIMIT = 0.5, 0.6
STEERED = {"wheelbase_meters": BASE, "wheel_radius_meters": RADIUS, "steering_limit_radians": LIMIT}
BICYCLE = Craft("bicycle", STEERED, (CraftDrive("steering", "left"), CraftDrive("rear_wheel", "right")))
CAR = Craft(
    "ackermann",
    {**STEERED, "track_meters": 0.4},
    (CraftDrive("front_left_steering", "left"), CraftDrive("rear_left_wheel", "right")),
    center_x=-0.2,
    heading=0.5,
)
SIDEWAYS = Craft("differential", TWO_WHEELS.settings, TWO_WHEELS.drives, center_y=0.1, heading=math.pi / 2.0)


def craft_of(course: Yard) -> CraftAtWork:
    return course.crafts.driven(course.world.snapshot.structure.node("rover").uid)


def driven(course: Yard, parts: np.ndarray) -> np.ndarray:
    """Return x, y and heading of the base after the drives have gone from row to row of a way, by the component."""
    craft, q = craft_of(course), course.world.snapshot.state.q
    pose, states = craft.pose(q) @ craft.base_t_center, craft.states(q)
    for row in craft.way(q, parts) / craft.drives.ratio:
        pose, _ = craft.stepped(pose, states, row - states, 1.0)
        states = row
    base = pose @ craft.center_t_base
    return np.array([base[0, 3], base[1, 3], math.atan2(base[1, 0], base[0, 0])])


@pytest.mark.parametrize(
    ("craft", "radius"),
    [(TWO_WHEELS, 0.0), (BICYCLE, BASE / math.tan(LIMIT)), (CAR, BASE / math.tan(LIMIT) + 0.2)],
    ids=["differential", "bicycle", "ackermann"],
)
def test_the_least_radius_is_that_of_the_component(craft: Craft, radius: float) -> None:
    """R1 = b1 / tan alpha; a car's left wheel is the inner one to the left, half a track nearer."""
    with yard(rover(craft)) as course:
        found = least_radius(craft_of(course), course.world.snapshot.state.q, back=True)
        assert found == pytest.approx(radius, rel=1e-9)


@pytest.mark.parametrize("craft", [TWO_WHEELS, SIDEWAYS, BICYCLE, CAR], ids=["two", "aside", "bicycle", "car"])
@pytest.mark.parametrize("base", [JointType.PLANAR, pytest.param(JointType.FLOATING, marks=pytest.mark.long)])
def test_a_way_ends_at_its_goal(craft: Craft, base: JointType, rng: np.random.Generator) -> None:
    with yard(rover(craft, base)) as course:
        if base is JointType.PLANAR:
            course.do(SetJointPositions("rover", {"base/x": 0.3, "base/y": -0.2, "base/theta": 2.0}))
        q = course.world.snapshot.state.q
        for _ in range(8):
            x, y, heading = (rng.uniform(-1.0, 1.0, 3) * (3.0, 3.0, np.pi)).tolist()
            for back in (False, True):
                way = way_to(craft_of(course), q, Goal(x, y, heading, back))
                there = driven(course, way.parts)
                np.testing.assert_allclose(there[:2], [x, y], atol=1e-6)
                assert math.remainder(there[2] - heading, math.tau) == pytest.approx(0.0, abs=1e-6)
                assert back or (way.parts[:, 0] >= 0.0).all()
                freely = way_to(craft_of(course), q, Goal(x, y, None, back))
                np.testing.assert_allclose(driven(course, freely.parts)[:2], [x, y], atol=1e-6)
                assert freely.length <= way.length + 1e-9


def test_a_radius_of_its_own_makes_wider_arcs_also_of_what_turns_on_the_spot() -> None:
    with yard(rover()) as course:
        way = way_to(craft_of(course), course.world.snapshot.state.q, Goal(0.0, 2.0, math.pi, radius=1.0))
        assert (way.word, way.radius, way.length) == ("L", 1.0, pytest.approx(math.pi))
        np.testing.assert_allclose(way.parts, [[math.pi, 0.0, math.pi]], atol=1e-12)
        back = way_to(craft_of(course), course.world.snapshot.state.q, Goal(-1.0, 0.0, 0.0, back=True))
        np.testing.assert_allclose(back.parts, [[-1.0, 0.0, 0.0]], atol=1e-12)


def test_what_cannot_be_is_refused_in_words() -> None:
    with yard(rover(BICYCLE)) as course:
        q = course.world.snapshot.state.q
        with pytest.raises(KernelError, match=r"turns on circles of 0\.7308 m or more, not of 0\.5 m"):
            way_to(craft_of(course), q, Goal(1.0, 1.0, 0.0, radius=0.5))
    with yard(rover(BICYCLE, JointType.FLOATING)) as course:
        q = course.world.snapshot.state.q.copy()
        at = craft_of(course).base_q
        q[at + 3 : at + 7] = math.sin(0.1), 0.0, 0.0, math.cos(0.1)
        with pytest.raises(KernelError, match=r"'rover' is tilted by 0\.2 rad"):
            way_to(craft_of(course), q, Goal(1.0, 1.0, 0.0))
