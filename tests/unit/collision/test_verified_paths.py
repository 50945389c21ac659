"""What the guard knows of paths is true: what is not in doubt touches nowhere, by FCL at places on ways and brakes.

The worlds are not guarded here, so that the arms go through walls and each other, and there is much to unverified.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.collision.brake_check import pictured
from virtualrobot_kernel.collision.group_boxes import swept_boxes
from virtualrobot_kernel.collision.joint_path import line
from virtualrobot_kernel.collision.kinematic_groups import kinematic_groups_of
from virtualrobot_kernel.collision.scene import CollisionScene, Detail
from virtualrobot_kernel.collision.verified_paths import VerifiedPaths
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.braking import braking
from virtualrobot_kernel.world.commands import UpdateNode
from virtualrobot_kernel.world.figures import Mesh
from virtualrobot_kernel.world.state import Snapshot, State
from virtualrobot_kernel.world.tick import advance

from tests.unit.collision.carts import block, cart, drive, mode
from tests.unit.collision.guarded import TICK, Cell, cell_of, started
from tests.unit.collision.worlds import LIBRARY, SHAPES, after, somewhere, with_robots, world

EVERY = 6
"""How many ticks are gone on before it is looked at again where things touch."""
PLACES = 3
"""At how many places of a brake that is looked at."""


def later_than(now: Snapshot) -> State:
    return advance(now.structure, now.state, TICK, world_poses)


def run_through(cell: Cell, rng: np.random.Generator, ticks: int = 700) -> None:
    """Fail where something touches that was not in unverified."""
    now, scene, paths = cell.world.snapshot, CollisionScene(SHAPES), VerifiedPaths(CollisionScene(SHAPES))
    robots = frozenset(now.structure.robots)
    for tick in range(ticks):
        later = later_than(now)
        if not now.state.motions:
            break
        unverified = paths.unverified(now, later, robots, frozenset())
        if tick % EVERY == 0:
            way = braking(now.structure, later, TICK, world_poses)
            way = way.after(now.structure, now.state, later.motions)
            unverified.add_reached(way.reached)
            for row in {0, 1, *rng.integers(len(way.positions), size=PLACES).tolist()}:
                scene.place(pictured(now, way, row))
                found = scene.collisions(Detail.PAIRS)
                rows = [[now.structure.rows[one.first], now.structure.rows[one.second]] for one in found]
                pairs = np.array(rows, np.int64).reshape(-1, 2)
                pairs = pairs[unverified.moving[unverified.of.rows[pairs]].any(axis=1)]  # what stands may touch
                assert unverified.asked(pairs).all(), (tick, row, found)
        now = replace(now, state=later, world_t_node=world_poses(now.structure, later))


@pytest.mark.parametrize("kind", ["iiwa", "panda"])
def test_what_an_arm_touches_was_in_doubt(kind: str, rng: np.random.Generator) -> None:
    cell = cell_of(kind, rng, arms=1, walls=8)
    try:
        cell.do(mode("off"))
        cell.do(started(cell, "arm0", rng))
        run_through(cell, rng)
    finally:
        cell.world.close()


def test_what_two_arms_touch_was_in_doubt(rng: np.random.Generator) -> None:
    cell = cell_of("iiwa", rng, arms=2, walls=4)
    try:
        cell.do(mode("off"))
        cell.do(started(cell, "arm0", rng))
        for _ in range(int(rng.integers(40))):
            cell.step()
        cell.do(started(cell, "arm1", rng))
        run_through(cell, rng)
    finally:
        cell.world.close()


def doubts(now: Snapshot, ticks: int) -> list[bool]:
    """Return for each of some ticks whether anything was in unverified."""
    paths, found = VerifiedPaths(CollisionScene(SHAPES)), []
    for _ in range(ticks):
        later = later_than(now)
        unverified = paths.unverified(now, later, frozenset(now.structure.robots), frozenset())
        unverified.add_reached(braking(now.structure, later, TICK, world_poses).reached)
        found.append(bool(unverified.groups.any()))
        now = replace(now, state=later, world_t_node=world_poses(now.structure, later))
    return found


def test_where_nothing_is_near_nothing_is_in_doubt() -> None:
    now = world(cart("cart"), cart("other", y=1.0), block("block", 1.0, y=0.5))
    assert not any(doubts(after(now, drive(0.0, 1.5), drive(0.0, 1.5, "other")), 200))


def test_in_doubt_is_what_a_brake_reaches() -> None:
    """The ball touches the block from 0.7 on; a brake from 1 m/s with 4 m/s² and 40 m/s³ takes less than 0.3 m."""
    found = doubts(after(world(cart("cart"), block("block", 0.9)), drive(0.0, 1.5)), 200)
    first = found.index(True)
    assert 60 < first
    assert all(found[first : first + 20])


def test_two_that_may_meet_are_in_doubt_until_one_is_past() -> None:
    """Their paths cross at 0.5, and both sweep boxes of that; the second cart stands there while the first goes by."""
    across = np.array([[0.0, -1.0, 0.0, 0.5], [1.0, 0.0, 0.0, -1.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    now = world(cart("cart"), cart("other"), UpdateNode("other", None, across))
    found = doubts(after(now, drive(0.0, 1.5), drive(0.0, 0.3, "other")), 440)
    assert not any(found), "it ends at 0.7 of the first one's way"
    found = doubts(after(now, drive(0.0, 1.5), drive(0.0, 1.5, "other")), 440)
    assert all(found[:50])
    assert not any(found[-50:])


def test_what_hangs_on_one_joint_is_of_one_unit() -> None:
    hung = cart("upper", parent="lower.ball")
    structure = world(cart("lower"), hung, cart("other"), block("block", 3.0)).structure
    units = kinematic_groups_of(structure)
    unit = {node.name: int(units.rows[structure.rows[node.uid]]) for node in structure.nodes.values()}
    assert unit["lower.ball"] == unit["upper.ball"] == unit["upper"] != unit["other.ball"]
    assert unit["block"] == unit["lower"] == unit["other"] == 0
    assert 0 not in {unit["lower.ball"], unit["other.ball"]}
    assert units.coordinates.tolist() == [unit["lower.ball"]] * 2 + [unit["other.ball"]]


@pytest.mark.parametrize("kind", ["iiwa", "panda", "xarm"])
def test_boxes_of_a_path_are_around_all_of_it(kind: str, rng: np.random.Generator) -> None:
    """By all vertices of all figures at places on the line between two configurations."""
    now = somewhere(with_robots(kind), rng)
    goal = somewhere(now, rng).state.q
    path, scene = line(now.state.q, goal), CollisionScene(SHAPES)
    scene.place(now)
    boxes = swept_boxes(scene, now, path, np.arange(len(scene.bodies.rows)))
    for u in rng.uniform(size=12).tolist():
        state = replace(now.state, q=path.at(u))
        scene.place(replace(now, state=state, world_t_node=world_poses(now.structure, state)))
        row = int(np.searchsorted(boxes.ends, u))
        for element, figure in enumerate(scene.bodies.figures):
            if not isinstance(figure.geometry, Mesh):
                continue
            pose = scene.world_t_element[element]
            for part in LIBRARY.load(figure.geometry):
                points = part.vertices @ pose[:3, :3].T + pose[:3, 3]
                assert (points >= boxes.low[row, element] - 1e-9).all()
                assert (points <= boxes.high[row, element] + 1e-9).all()
