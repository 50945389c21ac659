"""Under a guard nothing that is published touches, by coal, at ten points between ticks too; and it stops no sooner.

Each test draws arms, thin walls and motions anew. Coal looks at all that happens around the stops, and at every
twentieth tick elsewhere.
"""

from __future__ import annotations

import re

import numpy as np
import pytest
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.commands import StopRobots
from virtualrobot_kernel.world.journal import replay
from virtualrobot_kernel.world.state import EndCause

from tests.unit.collision.guarded import Cell, belt_cell, cell_of, nearest_later, run, started, stream, touching
from tests.unit.collision.worlds import ROBOTS, robot_nodes
from tests.unit.journals import entries_of
from tests.unit.planning import tracking_cell

CAUTION = 0.0005
"""How near (m) at the most a stopped motion would have come, had it begun to brake one tick later."""
AROUND = 8
"""How many ticks around a stop, and before the end, are looked at closely."""


@pytest.fixture(params=["iiwa", "panda"])
def kind(request: pytest.FixtureRequest) -> str:
    return request.param


def look(cell: Cell) -> int:
    """Fail where anything touches, or where a stop came too soon; return how many stops there were."""
    pictures = cell.pictures
    stops = [entry for entry in entries_of(cell.world) if entry.author == "collision guard"]
    near = {tick + row for tick in (*(entry.tick for entry in stops), max(pictures) - AROUND) for row in range(AROUND)}
    ends = {motion.end_tick - row for motion in cell.world.snapshot.state.ended for row in range(AROUND)}
    chosen = [pictures[tick] for tick in sorted(pictures) if tick % 20 == 0 or tick in near | ends]
    assert touching(chosen) == set()
    for entry in stops:
        if (before := cell.befores.get(entry.tick)) is None:
            continue  # something else braked already: this picture does not tell where it would have gone
        (stop,) = entry.commands
        assert isinstance(stop, StopRobots)
        why = stop.cancellation.reason
        said = re.match(r"'(.*)' would touch '(.*)' in (.*) s if", why)
        assert said, why
        pair = sorted(before.structure.node(name).uid for name in said.groups()[:2])
        assert nearest_later(before, pair, float(said[3])) < CAUTION
    return len(stops)


def replayed_alike(cell: Cell) -> None:
    """Fail unless a replay of the journal, without a guard, gives the same bits."""
    now, entries = cell.world.snapshot, entries_of(cell.world)
    again = replay(*cell.begin, entries, now.state.tick, now.tick_seconds, world_poses)
    assert again.state.q.tobytes() == now.state.q.tobytes()
    assert [motion.end_tick for motion in again.state.ended] == [motion.end_tick for motion in now.state.ended]


@pytest.mark.long
def test_random_motions_of_an_arm_among_thin_walls(kind: str, rng: np.random.Generator) -> None:
    cell = cell_of(kind, rng, arms=1, walls=8)
    try:
        for _ in range(2):
            cell.do(started(cell, "arm0", rng))
            run(cell)
        look(cell)
        replayed_alike(cell)
    finally:
        cell.world.close()


def test_setpoints_of_an_arm_among_thin_walls(kind: str, rng: np.random.Generator) -> None:
    cell = cell_of(kind, rng, arms=1, walls=8)
    try:
        stream(cell, "arm0", rng, 250)
        run(cell)
        look(cell)
        replayed_alike(cell)
    finally:
        cell.world.close()


@pytest.mark.long
def test_two_arms_that_reach_into_each_other(rng: np.random.Generator) -> None:
    cell = cell_of("iiwa", rng, arms=2, walls=4)
    try:
        for _ in range(2):
            cell.do(started(cell, "arm0", rng), started(cell, "arm1", rng))
            run(cell)
        look(cell)
        replayed_alike(cell)
    finally:
        cell.world.close()


@pytest.mark.long
def test_an_arm_that_goes_along_with_a_belt_leaves_it_before_a_wall(
    rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tracking_cell, "_model", lambda name: robot_nodes(ROBOTS[name], "arm"))
    cell, command, run_belt = belt_cell(rng)
    try:
        cell.do(command)
        cell.do(run_belt)
        run(cell)
        assert cell.world.snapshot.state.ended[0].tracked_joint
        look(cell)
        replayed_alike(cell)
    finally:
        cell.world.close()


def test_free_motions_go_on_as_without_a_guard(kind: str, rng: np.random.Generator) -> None:
    """Those that end by themselves have kept away from all, and are the motions that they are without a guard."""
    cell = cell_of(kind, rng, arms=1, walls=0)
    try:
        for _ in range(2):
            cell.do(started(cell, "arm0", rng))
            run(cell)
        for motion in cell.world.snapshot.state.ended:
            if motion.cancellation is not None:  # the arm's own links, as coal says too
                assert motion.cancellation.cause is EndCause.COLLISION
        look(cell)
        replayed_alike(cell)
    finally:
        cell.world.close()
