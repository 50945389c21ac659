"""First contacts on ways: against formulas, and what is asked of which way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.joint_path import JointPath, line, through, together
from virtualrobot_kernel.collision.pairs import least_distance, pair_of
from virtualrobot_kernel.collision.placed import Placed
from virtualrobot_kernel.collision.scene import CollisionScene, Detail
from virtualrobot_kernel.collision.swept import RESOLUTION, SweptContact, first_contact
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.world.commands import AttachNode, CreateNodes, SetAllowedPairs, SetCollisionSettings
from virtualrobot_kernel.world.figures import Box, Capsule, Figure, Geometry, Pose, Sphere
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Joint, JointLimits, JointType, Kind, LinkData, NodeSpec, RobotData

from tests.unit.collision.solids import GEOMETRIES, near, shapes
from tests.unit.collision.worlds import after, scene_of, world
from tests.unit.world.builders import Z, part, random_pose, shifted

FREE = JointLimits()
X = (1.0, 0.0, 0.0)


def link(name: str, parent: str, kind: JointType, axis: tuple[float, float, float], *shapes: Figure) -> NodeSpec:
    """Return a link whose joint is at its parent's origin."""
    return NodeSpec(
        name, Kind.LINK, parent, shifted(), figures=shapes, data=LinkData(Joint(f"{name} joint", kind, axis, FREE))
    )


def body(name: str, geometry: Geometry, pose: Pose) -> NodeSpec:
    """Return an object of one figure."""
    return NodeSpec(name, Kind.OBJECT, parent_t_node=pose, figures=(Figure(geometry),))


def mover(kind: JointType, axis: tuple[float, float, float], *figures: Figure, name: str = "mover") -> list[NodeSpec]:
    """Return a robot of one joint that carries figures."""
    return [NodeSpec(name, Kind.ROBOT, data=RobotData()), link(f"{name}.link", name, kind, axis, *figures)]


def contact(snapshot: Snapshot, goal: float | list[float], path: JointPath | None = None) -> SweptContact | None:
    """Return the first contact on the straight line from where all joints are, by one second."""
    q = snapshot.state.q
    return first_contact(scene_of(snapshot), snapshot, path or line(q, np.atleast_1d(goal) + 0.0 * q))


@pytest.mark.parametrize("thickness", [1.0, 1e-3, 1e-5])
@pytest.mark.parametrize("way", [0.5, 20.0])
def test_a_ball_meets_a_wall_when_it_has_gone_the_gap(thickness: float, way: float) -> None:
    """A ball of 0.1 m begins 0.3 m before a wall; however thin this is, and however long the way behind it."""
    ball = mover(JointType.PRISMATIC, X, Figure(Sphere(0.1)))
    wall = body("wall", Box((thickness, 2.0, 2.0)), shifted(x=0.4 + thickness / 2.0))
    found = contact(world(CreateNodes((*ball, wall))), way)
    assert found is not None
    assert 0.0 <= 0.3 / way - found.time <= RESOLUTION / way
    assert found.points[:, 0] == pytest.approx([found.q[0] + 0.1, 0.4], abs=1e-9)
    assert contact(world(CreateNodes((*ball, wall))), 0.3 - RESOLUTION) is None


def test_a_ball_on_a_crank_meets_another_where_their_chord_is_the_sum_of_radii(rng: np.random.Generator) -> None:
    """On a circle of radius R two balls touch where 2 R sin(angle / 2) is the sum of their radii."""
    for _ in range(20):
        reach, radii, start = rng.uniform(0.5, 2.0), rng.uniform(0.01, 0.2, 2), rng.uniform(0.5, 2.0 * np.pi - 0.9)
        ball = mover(JointType.CONTINUOUS, Z, Figure(Sphere(radii[0]), shifted(x=reach)))
        still = shifted(reach * np.cos(start), reach * np.sin(start))
        found = contact(world(CreateNodes((*ball, body("still", Sphere(radii[1]), still)))), 2.0 * np.pi)
        expected = start - 2.0 * np.arcsin(radii.sum() / (2.0 * reach))
        if expected < 0.0:
            expected = 0.0
        assert found is not None
        # The chord grows by cos(angle / 2) of the arc.
        tolerance = RESOLUTION / (reach * np.cos(0.5 * (start - expected)))
        assert 0.0 <= expected - 2.0 * np.pi * found.time <= tolerance


def test_a_turning_capsule_meets_a_ball_where_their_axes_are_near_enough() -> None:
    """A capsule from the axis outwards, 1 m long, meets a ball at 0.6 m where 0.6 sin(angle) is the sum of radii."""
    along_x = shifted(x=0.5)
    along_x[:3, :3] = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
    bar = mover(JointType.REVOLUTE, Z, Figure(Capsule(0.05, 1.0), along_x))
    found = contact(world(CreateNodes((*bar, body("ball", Sphere(0.1), shifted(y=0.6))))), np.pi / 2.0)
    expected = np.pi / 2.0 - np.arcsin(0.15 / 0.6)
    assert found is not None
    assert 0.0 <= expected - found.time * np.pi / 2.0 <= 2.0 * RESOLUTION / 0.6


def test_two_robots_meet_in_the_middle_and_passing_each_other_is_free() -> None:
    """Two balls of 0.1 m that come towards each other from 2 m apart meet when each has gone 0.9 m."""
    pair = (
        *mover(JointType.PRISMATIC, X, Figure(Sphere(0.1)), name="one"),
        *mover(JointType.PRISMATIC, X, Figure(Sphere(0.1), shifted(x=2.0)), name="two"),
    )
    snapshot = world(CreateNodes(pair))
    q = snapshot.state.q
    both = together([line(q, np.array([2.0, 0.0]), 0.0, 2.0), line(q, np.array([0.0, -2.0]), 0.0, 2.0)])
    found = contact(snapshot, 0.0, both)
    assert found is not None
    assert found.time == pytest.approx(0.9, abs=RESOLUTION)
    assert found.time <= 0.9
    # The second one goes away before the first comes.
    away = [line(q, np.array([2.0, 0.0]), 1.0, 2.0), line(q, np.array([0.0, 9.0]), 0.0, 1.0)]
    assert contact(snapshot, 0.0, together(away)) is None


def test_joints_above_both_carry_both(rng: np.random.Generator) -> None:
    """Two links 2 mm apart on a carriage that goes and turns far; only what moves them against each other counts."""
    pose = random_pose(rng)
    specs = [
        NodeSpec("robot", Kind.ROBOT, parent_t_node=pose, data=RobotData()),
        link("rail", "robot", JointType.PRISMATIC, X),
        link("table", "rail", JointType.CONTINUOUS, Z),
        link("left", "table", JointType.PRISMATIC, X, Figure(Sphere(0.1))),
        link("right", "table", JointType.PRISMATIC, X, Figure(Sphere(0.1), shifted(x=0.202))),
    ]
    snapshot = world(CreateNodes(tuple(specs)))
    q = snapshot.state.q
    assert contact(snapshot, 0.0, line(q, np.array([30.0, 20.0, 0.0, 0.0]))) is None
    assert contact(snapshot, 0.0, line(q, np.array([30.0, 20.0, 1.0, 1.0001]))) is None
    found = contact(snapshot, 0.0, line(q, np.array([30.0, 20.0, 0.004, 0.0])))
    assert found is not None
    assert found.time == pytest.approx(0.5, abs=RESOLUTION / 0.004)


def test_floating_and_planar_joints_are_bounded_too() -> None:
    """A bar that turns about itself by a quaternion, and one that drives and turns, meet a wall where they must."""
    bar = Figure(Box((1.0, 0.1, 0.1)))
    wall = body("wall", Box((4.0, 0.1, 4.0)), shifted(y=0.35))
    snapshot = world(CreateNodes((*mover(JointType.FLOATING, X, bar), wall)))
    start, goal = np.array([0.0, 0, 0, 0, 0, 0, 1]), np.array([0.0, 0, 0, 0, 0, 1, 1])
    found = contact(snapshot, 0.0, line(start, goal))
    # The bar's corner is 0.5 sin + 0.05 cos of the angle away; z, w = s, 1 is an angle of 2 atan s.
    angles = np.linspace(0.0, np.pi / 2.0, 1_000_001)
    meets = angles[np.argmax(0.5 * np.sin(angles) + 0.05 * np.cos(angles) >= 0.3)]
    assert found is not None
    assert found.time == pytest.approx(np.tan(meets / 2.0), abs=2.0 * RESOLUTION)
    planar = world(CreateNodes((*mover(JointType.PLANAR, Z, bar), wall)))
    found = contact(planar, 0.0, line(np.zeros(3), np.array([1.0, 0.0, np.pi / 2.0])))
    assert found is not None
    assert found.time == pytest.approx(meets / (np.pi / 2.0), abs=2.0 * RESOLUTION)


def test_what_stands_still_against_each_other_is_not_asked() -> None:
    """A base in the floor is no contact of a motion; a link that begins in it is one from the first moment on."""
    specs = [
        NodeSpec("robot", Kind.ROBOT, figures=(Figure(Sphere(0.1)),), data=RobotData()),
        link("robot.link", "robot", JointType.PRISMATIC, Z, Figure(Sphere(0.1), shifted(z=0.5))),
        body("floor", Box((1.0, 1.0, 0.2)), shifted()),
    ]
    snapshot = world(CreateNodes(tuple(specs)))
    assert contact(snapshot, 1.0) is None
    low = standing_at(snapshot, np.array([0], np.int32), np.array([-0.45]))
    found = contact(low, 1.0)
    assert found is not None
    assert (found.time, found.distance) == (0.0, 0.0)
    nodes = snapshot.structure.nodes
    assert {nodes[found.first].name, nodes[found.second].name} == {"robot.link", "floor"}
    scene, path = scene_of(low), line(low.state.q, low.state.q + 1.0)
    pair: Pair = (found.first, found.second)
    assert first_contact(scene, low, path, tolerated=[pair]) is None
    assert first_contact(scene, after(low, SetAllowedPairs((("robot.link", "floor", ""),))), path) is None


def test_robots_choose_the_pairs_and_callers_may_give_up() -> None:
    """Two robots run into a wall each; asked for one, the other's contact is not told."""
    robots = [
        *mover(JointType.PRISMATIC, X, Figure(Sphere(0.1)), name="one"),
        *mover(JointType.PRISMATIC, X, Figure(Sphere(0.1), shifted(y=5.0)), name="two"),
    ]
    wall = body("wall", Box((0.1, 20.0, 1.0)), shifted(x=1.0))
    snapshot = world(CreateNodes((*robots, wall)))
    scene, q, uids = scene_of(snapshot), snapshot.state.q, snapshot.structure.uid_by_name
    path = line(q, np.array([1.0, 2.0]))
    for name, speed in (("one", 1.0), ("two", 2.0)):
        found = first_contact(scene, snapshot, path, robots=[uids[name]])
        assert found is not None
        assert found.first == uids[f"{name}.link"]
        assert found.time == pytest.approx(0.85 / speed, abs=RESOLUTION)
    every = first_contact(scene, snapshot, path)
    assert every is not None
    assert every.first == uids["two.link"]
    with pytest.raises(KernelError, match="nobody waits"):
        first_contact(scene, snapshot, path, given_up=lambda: True)


def test_what_hangs_on_a_link_moves_along() -> None:
    """A part that hangs on the link reaches the wall before it."""
    wall = body("wall", Box((0.1, 2.0, 2.0)), shifted(x=1.05))
    ball = mover(JointType.PRISMATIC, X, Figure(Sphere(0.1)))
    snapshot = world(CreateNodes((*ball, wall, part("part", shifted(x=0.2)))))
    assert contact(snapshot, 0.049) is None
    held = after(snapshot, AttachNode("part", "mover.link"))
    found = contact(held, 1.0)
    assert found is not None
    assert found.time == pytest.approx(0.75, abs=RESOLUTION)
    assert {held.structure.nodes[uid].name for uid in (found.first, found.second)} == {"wall", "part"}


def test_the_scene_stands_at_the_snapshot_afterwards() -> None:
    """A scene that was used for a way tells of the snapshot what a new one does."""
    ball = mover(JointType.PRISMATIC, X, Figure(Sphere(0.1)))
    snapshot = world(CreateNodes((*ball, body("wall", Box((0.1, 2.0, 2.0)), shifted(x=1.05)))))
    scene = CollisionScene(scene_of(snapshot)._shapes)
    path = line(snapshot.state.q, np.ones(1))
    for _ in range(2):
        assert first_contact(scene, snapshot, path) is not None
        np.testing.assert_array_equal(scene.world_t_element, scene_of(snapshot).world_t_element)
        assert scene.collisions(Detail.PAIRS) == []
    moved = standing_at(snapshot, np.array([0], np.int32), np.array([0.95]))
    scene.place(moved)
    assert len(scene.collisions(Detail.PAIRS)) == 1


def test_ways_between_ticks_may_bend() -> None:
    """A ball that brakes 2 mm before a wall is free on straight lines, not if it may bend by A h^2 / 8 = 2.5 mm."""
    ball = mover(JointType.PRISMATIC, X, Figure(Sphere(0.1)))
    snapshot = world(CreateNodes((*ball, body("wall", Box((0.1, 2.0, 2.0)), shifted(x=1.05)))))
    times, places = np.array([0.0, 0.1]), np.array([[0.0], [0.898]])
    assert contact(snapshot, 0.0, through(times, places)) is None
    assert contact(snapshot, 0.0, through(times, places, 1.0)) is None
    asked: list[float] = []
    bent = through(times, places, 2.0)
    counted = replace(bent, at=lambda time: asked.append(time) or bent.at(time))
    assert contact(snapshot, 0.0, counted) is not None
    assert len(asked) < 30  # it isn't looked at more finely than the way is known


def test_a_joint_of_which_the_way_says_otherwise_than_the_snapshot_is_where_the_way_has_it() -> None:
    """The way begins elsewhere, also with joints that stand still on it."""
    specs = [
        *mover(JointType.PRISMATIC, X, Figure(Sphere(0.1)), name="one"),
        *mover(JointType.PRISMATIC, X, Figure(Sphere(0.1), shifted(x=1.0, y=1.0)), name="two"),
    ]
    specs[3] = replace(specs[3], data=LinkData(Joint("two joint", JointType.PRISMATIC, (0.0, 1.0, 0.0), FREE)))
    snapshot = world(CreateNodes(tuple(specs)))
    assert contact(snapshot, 0.0, line(np.zeros(2), np.array([2.0, 0.0]))) is None
    found = contact(snapshot, 0.0, line(np.array([0.0, -1.0]), np.array([2.0, -1.0])))
    assert found is not None
    assert found.time == pytest.approx(0.4, abs=RESOLUTION)


def test_measured_distances_are_never_too_great(rng: np.random.Generator) -> None:
    """Against what `pair_of` tells, for all kinds of figures, with paddings; exact up to what was asked for."""
    kinds = list(GEOMETRIES.values())
    for _ in range(150):
        solids = [shapes().get(kinds[place]) for place in rng.integers(0, len(kinds), 2)]
        poses = np.array([near(rng, 0.5), near(rng, 0.5)])
        padding = rng.uniform(0.0, 0.05, 2) * rng.integers(0, 2)
        here = Placed([one for one in solids if one], poses, padding=padding)
        exact = pair_of(here, here, 0, 1)
        assert exact is not None
        for most in (0.01, 0.2, 3.0):
            told = least_distance(here, 0, 1, most)
            assert 0.0 <= told <= exact.distance + 1e-9
            assert told >= min(most, exact.distance) - 1e-4


def test_paddings_count() -> None:
    """With 1 cm of padding on both, a ball meets the wall 2 cm earlier."""
    ball = mover(JointType.PRISMATIC, X, Figure(Sphere(0.1)))
    snapshot = world(CreateNodes((*ball, body("wall", Box((0.1, 2.0, 2.0)), shifted(x=0.45)))))
    thick = after(snapshot, SetCollisionSettings(paddings=(("wall", 0.01), ("mover.link", 0.01))))
    for now, expected in ((snapshot, 0.3), (thick, 0.28)):
        found = contact(now, 1.0)
        assert found is not None
        assert found.time == pytest.approx(expected, abs=RESOLUTION)
