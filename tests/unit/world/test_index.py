"""Laws of the index: what is added, attached and renamed step by step is what would be built of all nodes at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.change import Change, rebuilt, shortened
from virtualrobot_kernel.world.commands import (
    AttachNode,
    Command,
    CreateNodes,
    CreateSignal,
    SetJointPositions,
    UpdateNode,
)
from virtualrobot_kernel.world.state import Signal
from virtualrobot_kernel.world.structure import (
    WORLD_NAME,
    Forest,
    Joint,
    JointType,
    Kind,
    LinkData,
    Mimic,
    Node,
    NodeSpec,
    Structure,
    ToolData,
)

from tests.unit.world.builders import LIMITS, Z, after, arm, empty, link, part, random_pose, shifted


@pytest.fixture
def hall(rng: np.random.Generator) -> Change:
    """Return a world in which a robot's nodes are few."""
    parts = CreateNodes(tuple(part(f"p{place}", random_pose(rng)) for place in range(200)))
    return after(empty(), arm(), parts, SetJointPositions("arm", {"a": 0.3, "b": -0.7, "f": 0.02}))


def assert_equal_to_one_built_at_once(structure: Structure) -> None:
    """Compare with what is built of the same nodes in another order."""
    shuffled = dict(sorted(structure.nodes.items(), key=lambda item: -item[0] % 7))
    built = index.build(shuffled, structure.next_uid, structure.revision)
    for name in ("nodes", "next_uid", "revision", "uid_by_name", "rows", "children", "tools", "q_count", "v_count"):
        assert getattr(structure, name) == getattr(built, name), name
    assert list(structure.nodes) == list(structure.rows) == list(built.rows) == sorted(structure.nodes)
    assert structure.robots.keys() == built.robots.keys()
    for uid, robot in structure.robots.items():
        for field in fields(robot):
            assert getattr(robot, field.name) == getattr(built.robots[uid], field.name), field.name
    for field in fields(Forest):
        ours, theirs = getattr(structure.forest, field.name), getattr(built.forest, field.name)
        assert ours.dtype == theirs.dtype
        np.testing.assert_array_equal(ours, theirs, field.name)
    nodes = list(structure.nodes.values())
    walked = [nodes[row].uid for row in structure.forest.order.tolist()]
    assert walked == [node.uid for node in structure.below(structure.node(WORLD_NAME).uid)], "depth first"


def random_command(world: Change, place: int, rng: np.random.Generator) -> Command:
    """Return a command that adds, attaches or renames something; its names hold `place`."""
    nodes = world.structure.nodes.values()
    anywhere = str(rng.choice([node.name for node in nodes]))
    some_part = str(rng.choice([node.name for node in nodes if node.kind is Kind.PART]))
    some_robot = str(rng.choice([node.name for node in nodes if node.kind is Kind.ROBOT]))
    match rng.integers(5):
        case 0:
            return CreateNodes((part(f"q{place}", random_pose(rng), anywhere),))
        case 1:
            return arm(f"arm{place}")
        case 2:
            return CreateNodes(
                (
                    NodeSpec(f"plate{place}", Kind.ADAPTER, f"{some_robot}.hand", shifted(x=0.1)),
                    NodeSpec(f"tool{place}", Kind.TOOL, f"plate{place}", data=ToolData()),
                    part(f"held{place}", random_pose(rng), f"tool{place}"),
                )
            )
        case 3:
            return AttachNode(some_part, anywhere)
        case _:
            return UpdateNode(some_part, new_name=f"n{place}")


def test_step_by_step_is_as_at_once(hall: Change, rng: np.random.Generator) -> None:
    world = hall
    for place in range(60):
        try:
            world = after(world, random_command(world, place, rng))
        except KernelError as error:
            assert "hangs below it" in str(error)
        assert_equal_to_one_built_at_once(world.structure)
    at_once = rebuilt(world, world.structure.nodes, world.structure.next_uid, {})
    for name in ("q", "v", "parent_t_node"):
        np.testing.assert_array_equal(getattr(world.state, name), getattr(at_once.state, name), name)


def test_what_was_added_last_goes_as_if_it_had_never_been(hall: Change) -> None:
    more = after(
        hall,
        CreateNodes((NodeSpec("tray", Kind.OBJECT), NodeSpec("cup", Kind.OBJECT, "tray"))),
        arm("second"),
        CreateNodes((NodeSpec("blade", Kind.TOOL, "arm.hand"), NodeSpec("lid", Kind.OBJECT, "cup"))),
        AttachNode("blade", "tray"),
    )
    uids = [uid for uid in more.structure.nodes if uid not in hall.structure.nodes]
    for gone in (uids[-1:], uids[-2:], uids[2:], uids):
        assert index.ends_with(more.structure, gone)
        assert_equal_to_one_built_at_once(index.shortened(more.structure, gone))
        left = shortened(more, gone)
        assert len(left.state.q) == left.structure.q_count
        assert len(left.state.v) == left.structure.v_count
        assert len(left.state.parent_t_node) == len(left.structure.nodes)
    on_cup, within_arm = uids[1:-1], uids[3:]
    assert not index.ends_with(more.structure, on_cup)
    assert not index.ends_with(more.structure, within_arm)


def test_a_batch_that_alternates_creates_with_other_commands_builds_nothing_anew(
    hall: Change, monkeypatch: pytest.MonkeyPatch
) -> None:
    builds: list[int] = []
    real = index.build

    def build(nodes: Mapping[int, Node], next_uid: int, revision: int) -> Structure:
        builds.append(len(nodes))
        return real(nodes, next_uid, revision)

    monkeypatch.setattr(index, "build", build)
    batch: list[Command] = []
    for place in range(5):
        batch += [
            CreateNodes((part(f"q{place}", shifted()),)),
            CreateSignal(Signal(f"s{place}", False)),
            AttachNode(f"q{place}", "arm.hand"),
            arm(f"arm{place}"),
            SetJointPositions(f"arm{place}", {"a": 0.1 * place}),
            UpdateNode(f"q{place}", new_name=f"held{place}"),
        ]
    made = after(hall, *batch)
    assert builds == []
    places = made.structure.robot("arm4")[1].q_start
    np.testing.assert_array_equal(made.state.q[list(places)], [0.4, 0.0, 0.04])
    np.testing.assert_array_equal(made.state.q[: len(hall.state.q)], hall.state.q)


@pytest.mark.parametrize(
    "nodes",
    [
        [("", Kind.PART, "world", None)],
        [("p1", Kind.PART, "world", None)],
        [("x", Kind.OBJECT, "world", None), ("y", Kind.LINK, "x", Joint("j"))],
        [("x", Kind.ROBOT, "world", None), ("y", Kind.LINK, "x", None)],
        [
            ("x", Kind.ROBOT, "world", None),
            ("y", Kind.LINK, "x", Joint("j", JointType.REVOLUTE, Z, LIMITS)),
            ("z", Kind.LINK, "y", Joint("j", JointType.REVOLUTE, Z, LIMITS)),
        ],
        [
            ("x", Kind.ROBOT, "world", None),
            ("y", Kind.LINK, "x", Joint("j", JointType.REVOLUTE, Z, LIMITS, Mimic("k"))),
        ],
    ],
    ids=["no name", "a taken name", "a link on an object", "no joint", "a joint twice", "a mimic of nothing"],
)
def test_what_cannot_be_built_at_once_cannot_be_added(
    hall: Change, nodes: list[tuple[str, Kind, str, Joint | None]]
) -> None:
    before = hall.structure
    uids, new = dict(before.uid_by_name), {}
    for uid, (name, kind, parent, joint) in enumerate(nodes, before.next_uid):
        new[uid] = Node(uid, name, kind, uids[parent], data=LinkData(joint) if joint else None)
        uids[name] = uid
    assert index.appends(before, new)
    with pytest.raises(KernelError) as added:
        index.extended(before, new, before.next_uid + len(new))
    with pytest.raises(KernelError) as built:
        index.build({**before.nodes, **new}, before.next_uid + len(new), before.revision)
    assert (str(added.value), added.value.reason) == (str(built.value), built.value.reason)


def test_a_link_more_on_a_robot_that_is_there_moves_the_coordinates_of_those_after_it(hall: Change) -> None:
    two = after(hall, arm("other"), SetJointPositions("other", {"a": 1.1}))
    more = after(two, CreateNodes((link("arm.extra", "arm.hand", Joint("x", JointType.REVOLUTE, Z, LIMITS)),)))
    assert_equal_to_one_built_at_once(more.structure)
    first, second = more.structure.robot("arm")[1], more.structure.robot("other")[1]
    np.testing.assert_array_equal(more.state.q[first.q_slice], [0.3, -0.7, 0.02, 0.0])
    np.testing.assert_array_equal(more.state.q[second.q_slice], [1.1, 0.0, 0.04])
