"""Laws of undo: taking everything back gives the start bit for bit, and an undo changes nothing but its own records."""

from __future__ import annotations

import itertools
from dataclasses import fields, replace
from typing import Any, cast

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world import commands
from virtualrobot_kernel.world.apply_records import Conflict
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.difference import alike, difference, same, value
from virtualrobot_kernel.world.history_commands import RestoreRecords
from virtualrobot_kernel.world.records import Difference
from virtualrobot_kernel.world.state import Motion, Signal
from virtualrobot_kernel.world.structure import Forest, Kind, LinkData, NodeSpec

from tests.tiers import Draws
from tests.unit.world.builders import after, arm, empty, part, shifted
from tests.unit.world.edits import cell, random_batch


def undo(of: Difference) -> RestoreRecords:
    return RestoreRecords(of.new, of.old)


def done(change: Change, *batch: Command) -> tuple[Change, Difference]:
    later = after(change, *batch)
    assert_sound(later)
    return later, difference(change, later)


def is_same(one: Change, other: Change) -> bool:
    """Return whether two worlds are the same but for values of signals and what only grows, such as uids."""
    a, b = one.structure, other.structure
    before, now = one.state, other.state
    maps = ("tool_states", "selections", "speed_factors", "speed_factor", "allowed_pairs", "collisions")
    return (
        same(tuple(a.nodes.values()), tuple(b.nodes.values()))
        and all(getattr(before, name) == getattr(now, name) for name in maps)
        and all(same(getattr(before, name), getattr(now, name)) for name in ("q", "v", "parent_t_node"))
        and before.running_sensors.keys() == now.running_sensors.keys()
        and all(getattr(a, name) == getattr(b, name) for name in ("rows", "uid_by_name", "tools"))
        and a.children == b.children
        and all(same(getattr(a.forest, one.name), getattr(b.forest, one.name)) for one in fields(Forest))
    )


def assert_sound(change: Change) -> None:
    """Nothing is set for a node that is gone."""
    nodes, state = change.structure.nodes, change.state
    maps = state.tool_states, state.selections, state.speed_factors, state.running_sensors
    settings = state.collisions.modes, state.collisions.paddings
    uids = {uid for one in (*maps, *settings) for uid in one} | {uid for pair in state.allowed_pairs for uid in pair}
    uids |= {signal.owner for signal in state.signals.values()} | {one.tool for one in state.selections.values()}
    assert uids - {0} <= nodes.keys()
    assert len(state.parent_t_node) == len(nodes)


def test_undo_of_everything_is_the_start_and_redo_the_end(rng: np.random.Generator, draws: Draws) -> None:
    for _ in range(draws(25)):
        _there_and_back(rng, 40)


@pytest.mark.long
def test_undo_of_ten_thousand_batches_is_the_start(rng: np.random.Generator) -> None:
    for _ in range(100):
        _there_and_back(rng, 100)


def _there_and_back(rng: np.random.Generator, count: int) -> None:
    start = now = cell()
    undone: list[Difference] = []
    for _ in range(count):
        now, of = done(now, *random_batch(rng, now))
        undone.append(of)
    end, redone = now, list[Difference]()
    for of in reversed(undone):
        now, back = done(now, undo(of))
        assert back.keys == of.keys
        redone.append(back)
    assert not difference(start, now)
    assert is_same(start, now)
    for of in reversed(redone):
        now = after(now, undo(of))
    assert not difference(end, now)
    assert is_same(end, now)


def test_an_undo_among_others_edits_changes_its_own_records_alone(rng: np.random.Generator, draws: Draws) -> None:
    refused = 0
    for _ in range(draws(15)):
        refused += _among_others(rng, 40)
    assert refused  # else nobody was ever in the way


def _among_others(rng: np.random.Generator, count: int) -> int:
    """Let two people edit, and one of them take steps back at random; return how often that was refused."""
    now, refused = cell(), 0
    steps: list[tuple[int, Difference]] = []
    for person in itertools.islice(itertools.cycle((0, 1)), count):
        now, of = done(now, *random_batch(rng, now))
        steps.append((person, of))
        mine = [one for who, one in steps if who == 0]
        of = mine[rng.integers(len(mine))]
        try:
            later, back = done(now, undo(of))
        except Conflict as error:
            refused += 1
            at = next(place for place, (_, one) in enumerate(steps) if one is of)
            since = frozenset[object]().union(*(one.keys for _, one in steps[at + 1 :]))
            # What stands in the way was changed since: so whoever did can be named.
            assert not error.table or since & {(error.table, error.key), ("nodes", error.key)}, error
            continue
        assert back.keys <= of.keys
        for table, key, old in of.old.items():
            assert alike(table, value(later, table, key), old)
        steps.append((0, back))
        now = later
    return refused


@pytest.fixture
def world() -> Change:
    return cell()


def test_nothing_that_it_does_not_cover_is_changed(world: Change) -> None:
    """Joints stay, signals keep their values, and sensors go on."""
    now, moved = done(world, commands.UpdateNode("table", parent_t_node=shifted(x=1.0)))
    now = after(
        now,
        commands.SetJointPositions("left", {"a": 1.0}),
        commands.SetSignal("ready", True),
        commands.RunSensors(("lidar",), False),
    )
    now = after(now, undo(moved))
    assert now.state.q[0] == 1.0
    assert now.state.signals["ready"].value is True
    assert not now.state.running_sensors


def test_a_removed_robot_comes_back_where_it_stood(world: Change) -> None:
    now, removed = done(world, commands.RemoveNode("left"))
    now = after(now, undo(removed))
    assert is_same(world, now)
    uid = now.structure.uid_by_name["left"]
    assert now.state.q[now.structure.robots[uid].q_slice].tolist() == [0.3, -0.4, 0.02]
    assert now.state.signals["ready"].owner == uid


def test_a_world_that_was_cleared_comes_back(world: Change) -> None:
    now, cleared = done(world, commands.ClearWorld(), commands.CreateNodes((part("new", shifted()),)))
    now = after(now, undo(cleared))
    assert is_same(world, now)
    assert now.structure.next_uid > world.structure.next_uid


def refused(change: Change, of: Difference, match: str, reason: Reason = Reason.CONFLICT) -> KernelError:
    with pytest.raises(KernelError, match=match) as error:
        after(change, undo(of))
    assert error.value.reason is reason
    return error.value


def test_what_was_changed_since_is_named(world: Change) -> None:
    now, moved = done(world, commands.UpdateNode("table", parent_t_node=shifted(x=1.0)))
    now = after(now, commands.UpdateNode("table", parent_t_node=shifted(x=2.0)))
    refused(now, moved, "the pose of 'table' has been changed since")


def test_across_a_cleared_world(world: Change) -> None:
    now, moved = done(world, commands.UpdateNode("table", parent_t_node=shifted(x=1.0)))
    refused(after(now, commands.ClearWorld()), moved, "a node that it changed is gone")


def test_of_a_node_that_was_created_again_under_the_same_name(world: Change) -> None:
    now, created = done(world, commands.CreateNodes((part("box", shifted()),)))
    now = after(now, commands.RemoveNode("box"), commands.CreateNodes((part("box", shifted()),)))
    refused(now, created, "the node 'box' is gone")


def test_of_a_removal_whose_name_is_taken(world: Change) -> None:
    now, removed = done(world, commands.RemoveNode("part_0"))
    now = after(now, commands.CreateNodes((part("part_0", shifted()),)))
    refused(now, removed, "another node has the name 'part_0'")


def test_of_a_removal_whose_parent_is_gone(world: Change) -> None:
    now, removed = done(world, commands.RemoveNode("part_0"))
    refused(after(now, commands.RemoveNode("table")), removed, "what 'part_0' hung on is gone")


def test_of_a_creation_on_which_something_hangs(world: Change) -> None:
    now, created = done(world, commands.CreateNodes((NodeSpec("tray", Kind.OBJECT),)))
    now = after(now, commands.AttachNode("part_0", "tray"))
    refused(now, created, "'part_0' hangs on 'tray', which would go")


def test_of_a_new_parent_that_hangs_below_by_now(world: Change) -> None:
    now, hung = done(world, commands.AttachNode("part_0", "world"))
    now = after(now, commands.AttachNode("table", "part_0"))
    refused(now, hung, "'table' hangs below 'part_0'")


def test_what_others_have_set_for_it_is_not_lost(world: Change) -> None:
    now, created = done(world, commands.CreateNodes((part("box", shifted()),)))
    now = after(now, commands.SetAllowedPairs(allow=(("box", "table", "mine"),)))
    refused(now, created, "whether 'table' and 'box' may touch was set since and would be lost")


def test_what_was_set_for_a_node_that_is_gone_is_not_set_again(world: Change) -> None:
    now, forbidden = done(world, commands.SetAllowedPairs(forbid=(("part_1", "table"),)))
    now = after(now, commands.RemoveNode("part_1"))
    refused(now, forbidden, "whether 'table' and a node that is gone may touch was set for a node that is gone")


def test_what_a_running_program_names_stays(world: Change) -> None:
    now, created = done(
        world, commands.CreateNodes((part("box", shifted()),)), commands.CreateSignal(Signal("go", True))
    )
    now, renamed = done(now, commands.UpdateNode("table", new_name="desk"))
    none = np.zeros(0, np.int32)
    uids = now.structure.uid_by_name
    for nodes, signals, of in (
        ({uids["box"]}, set[str](), created),
        (set[int](), {"go"}, created),
        ({uids["desk"]}, set[str](), renamed),
    ):
        motion = Motion(
            *("motion-1", (), (), none, none, cast(Any, None), 0),
            nodes=frozenset(nodes),
            signals=frozenset(signals),
        )
        running = replace(now, state=replace(now.state, motions=(motion,)))
        refused(running, of, "the program 'motion-1' names the", Reason.WRONG_STATE)


def test_two_that_change_places_hang_as_before(world: Change) -> None:
    now = after(world, commands.AttachNode("part_0", "part_1"))
    now, turned = done(now, commands.AttachNode("part_0", "table"), commands.AttachNode("part_1", "part_0"))
    back = after(now, undo(turned))
    assert not difference(after(world, commands.AttachNode("part_0", "part_1")), back)


def test_a_created_signal_goes_whatever_its_value(world: Change) -> None:
    now, created = done(world, commands.CreateSignal(Signal("lamp", False)))
    now = after(now, commands.SetSignal("lamp", True))
    now, gone = done(now, undo(created))
    assert "lamp" not in now.state.signals
    assert after(now, undo(gone)).state.signals["lamp"].value is True


def test_limits_where_a_joint_is_not_any_more(world: Change) -> None:
    link = world.structure.node("left.one").data
    assert isinstance(link, LinkData)
    wider = replace(link, joint=replace(link.joint, limits=replace(link.joint.limits, upper=3.0)))
    now, widened = done(world, commands.UpdateNode("left.one", data=wider))
    now = after(now, commands.SetJointPositions("left", {"a": 2.5}))
    refused(now, widened, "the joint 'a' of 'left' cannot be at 2.5 rad")


def test_values_are_compared_bit_for_bit() -> None:
    assert not same(0.0, -0.0)
    assert same(float("nan"), float("nan"))
    assert not same((1, 2.0), (1, 2))
    assert same({"a": np.zeros(2)}, {"a": np.zeros(2)})
    assert not same({"a": 1, "b": 2}, {"b": 2, "a": 1})


def test_equal_worlds_do_not_differ() -> None:
    assert not difference(after(empty(), arm()), after(empty(), arm()))
