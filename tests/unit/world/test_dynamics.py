"""Dynamics: what supervisors compute becomes true with the tick, beside motions, and is replayed without them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.history.codec import same
from virtualrobot_kernel.history.world_image import image_of
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import Command, CreateNodes, RemoveNode, SetMeasuredJoints
from virtualrobot_kernel.world.history_commands import RestartWorld
from virtualrobot_kernel.world.journal import MemoryJournal, replay, waited
from virtualrobot_kernel.world.physics_commands import SetDynamics
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, NodeSpec, RobotData

from tests.unit.journals import entries_of
from tests.unit.world.builders import TICK, after, arm, empty, link, ticked
from tests.unit.world.test_measured import move
from tests.unit.world.test_store import GUARD
from tests.unit.world.test_store import TICK as NANOSECONDS


def body() -> CreateNodes:
    """Return a robot that is one floating body; its coordinates are those after the arm's three."""
    hull = link("body.hull", "body", Joint("free", JointType.FLOATING))
    return CreateNodes((NodeSpec("body", Kind.ROBOT, data=RobotData()), hull))


@pytest.fixture
def cell() -> Change:
    return after(empty(), arm(), body())


def dynamics(q: dict[int, float], v: dict[int, float]) -> SetDynamics:
    index = np.array([*q], np.int32), np.array([*v], np.int32)
    return SetDynamics(index[0], np.array([*q.values()], float), index[1], np.array([*v.values()], float))


def test_it_is_true_at_the_end_of_the_tick_and_not_before(cell: Change) -> None:
    told = after(cell, dynamics({3: 0.5, 5: 0.2}, {3: 125.0}))
    assert told.state.q is cell.state.q
    now = ticked(told)
    assert now.state.q[3:].tolist() == [0.5, 0.0, 0.2, 0.0, 0.0, 0.0, 1.0]
    assert now.state.q[:3].tolist() == cell.state.q[:3].tolist()
    assert now.state.v.tolist() == [0.0, 0.0, 0.0, 125.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    assert now.state.dynamics is None
    assert ticked(now).state.q.tolist() == now.state.q.tolist()
    assert waited(told, 3, TICK, world_poses).state.q.tolist() == now.state.q.tolist()
    assert not now.state.q.flags.writeable


def test_motions_go_on_beside_it(cell: Change) -> None:
    alone, beside = (after(cell, move(0.5)) for _ in range(2))
    for tick in range(100):
        alone, beside = ticked(alone), ticked(after(beside, dynamics({3: 0.01 * tick}, {3: 2.5})))
        assert beside.state.q[:3].tolist() == alone.state.q[:3].tolist()
        assert beside.state.q[3] == 0.01 * tick


def test_the_later_of_two_counts_where_both_name_a_place(cell: Change) -> None:
    now = after(cell, dynamics({3: 1.0, 5: 2.0}, {3: 1.0}), dynamics({4: 3.0, 5: 4.0}, {4: 5.0}))
    state = ticked(now).state
    assert state.q[3:6].tolist() == [1.0, 3.0, 4.0]
    assert state.v[3:5].tolist() == [1.0, 5.0]


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (dynamics({3: np.nan}, {}), r"coordinates must be finite; the one of place 3 is nan"),
        (dynamics({}, {4: np.inf}), r"velocities must be finite; the one of place 4 is inf"),
        (dynamics({10: 0.0}, {}), r"below 10, not \[10\]"),
        (dynamics({}, {9: 0.0}), r"below 9, not \[9\]"),
        (dynamics({-1: 0.0}, {}), r"from 0 or above"),
        (dynamics({5: 0.0, 4: 0.0}, {}), r"must rise"),
        (dynamics({6: 0.5}, {}), r"the quaternion at the places 6 to 9 must have length 1, not 1\.118"),
        (SetDynamics(np.arange(2, dtype=np.int32), np.zeros(3), np.zeros(0, np.int32), np.zeros(0)), r"a place each"),
    ],
)
def test_what_is_none_is_refused(cell: Change, command: SetDynamics, said: str) -> None:
    with pytest.raises(KernelError, match=said):
        after(cell, command)


def test_where_joints_are_measured_that_counts(cell: Change) -> None:
    uid = cell.structure.node("arm").uid
    now = ticked(after(cell, SetMeasuredJoints(uid, np.full(3, 0.01)), dynamics({0: 0.3, 3: 0.4}, {})))
    assert now.state.q[:4].tolist() == [0.01, 0.01, 0.01, 0.4]


def test_what_was_computed_for_other_places_is_forgotten(cell: Change) -> None:
    told = after(cell, dynamics({3: 0.5}, {3: 1.0}))
    assert after(told, RemoveNode("arm")).state.dynamics is None
    assert after(told, RestartWorld()).state.dynamics is None


class Pushing:
    """A supervisor that moves and turns a body, as physics does, for as long as the arm moves."""

    author = "physics"

    def admit(self, before: Snapshot, after: Snapshot, batch: Sequence[Command]) -> None: ...

    def after_change(self, now: Snapshot) -> Sequence[Command]:
        return ()

    def before_tick(self, now: Snapshot, later: Snapshot) -> Sequence[Command]:
        if now.state.dynamics is not None or not now.state.motions:
            return ()
        angle = 0.1 * later.state.q[0]
        q = np.array([np.sin(angle), later.state.q[0], 0.0, 0.0, 0.0, np.sin(angle / 2), np.cos(angle / 2)])
        return [SetDynamics(np.arange(3, 10, dtype=np.int32), q, np.array([8], np.int32), later.state.v[:1])]


def test_a_replay_needs_nobody_who_computes(cell: Change) -> None:
    world = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, NANOSECONDS), cell.structure, cell.state)
    world.start()
    try:
        world.supervise(Pushing())
        world.submit([move(0.5)]).result(GUARD)
        last = world.step(300).result(GUARD)
        entries = entries_of(world)
    finally:
        world.close()
    assert not last.state.motions
    assert last.state.q[4] == pytest.approx(0.5)
    again = replay(cell.structure, cell.state, entries, last.state.tick, TICK, world_poses)
    assert same(image_of(last.structure, last.state), image_of(again.structure, again.state)) == ""
