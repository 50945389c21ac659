"""Laws of the tree: poses survive attaching, joints survive changes of other nodes, refusals change nothing."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import (
    AttachNode,
    ClearWorld,
    CreateNodes,
    RemoveNode,
    SetJointPositions,
    UpdateNode,
)
from virtualrobot_kernel.world.structure import (
    Joint,
    JointLimits,
    JointType,
    Kind,
    LinkData,
    Mimic,
    NodeSpec,
    RobotData,
)

from tests.unit.world.builders import LIMITS, Z, after, arm, empty, link, part, random_pose, shifted, world_t


@pytest.fixture
def cell(rng: np.random.Generator) -> Change:
    parts = CreateNodes(tuple(part(name, random_pose(rng)) for name in ("p", "q", "r")))
    return after(empty(), arm(), parts, SetJointPositions("arm", {"a": 0.3, "b": -0.7, "f": 0.02}))


def test_attach_and_detach_keep_the_place_in_the_world(cell: Change) -> None:
    before = world_t(cell, "p")
    held = after(cell, AttachNode("p", "arm.two"))
    np.testing.assert_allclose(world_t(held, "p"), before, atol=1e-15)
    moved = after(held, SetJointPositions("arm", {"a": -1.0}))
    assert np.abs(world_t(moved, "p") - before).max() > 0.1
    there = world_t(moved, "p")
    released = after(moved, AttachNode("p", "world"))
    np.testing.assert_allclose(world_t(released, "p"), there, atol=1e-15)


def test_attach_at_a_pose_takes_that_pose(cell: Change) -> None:
    held = after(cell, AttachNode("p", "q", shifted(x=0.25)))
    np.testing.assert_allclose(world_t(held, "p"), world_t(cell, "q") @ shifted(x=0.25), atol=1e-15)


def test_a_node_cannot_hang_below_itself(cell: Change) -> None:
    chain = after(cell, AttachNode("q", "p"), AttachNode("r", "q"))
    with pytest.raises(KernelError, match=r"'p' to 'r', which hangs below"):
        after(chain, AttachNode("p", "r"))


def test_links_stay_where_their_joints_are(cell: Change) -> None:
    with pytest.raises(KernelError, match=r"link nodes such as 'arm\.two'"):
        after(cell, AttachNode("arm.two", "world"))


def test_removing_takes_what_hangs_below_and_keeps_the_joints_of_others(cell: Change) -> None:
    two = after(cell, arm("other"), SetJointPositions("other", {"a": 1.1}), AttachNode("p", "arm.hand"))
    left = after(two, RemoveNode("arm"))
    others = {f"other.{link}" for link in ("one", "two", "hand", "left", "right")}
    names = {node.name for node in left.structure.nodes.values()}
    assert names == {"world", "q", "r", "other", "other_gripper"} | others
    np.testing.assert_array_equal(world_t(left, "other.two"), world_t(two, "other.two"))
    assert left.structure.q_count == 3


def test_renaming_a_robot_renames_its_links_and_keeps_uids(cell: Change) -> None:
    named = after(cell, UpdateNode("arm", new_name="left"))
    assert named.structure.node("left.two").uid == cell.structure.node("arm.two").uid
    np.testing.assert_array_equal(world_t(named, "left.two"), world_t(cell, "arm.two"))
    with pytest.raises(UnknownNameError, match=r"did you mean 'left"):
        named.structure.node("lefft.two")


def test_a_uid_is_never_used_again(cell: Change) -> None:
    gone = cell.structure.node("r").uid
    again = after(after(cell, RemoveNode("r")), CreateNodes((part("r", shifted()),)))
    assert again.structure.node("r").uid > gone


def test_mimic_joints_follow_and_are_no_coordinates(cell: Change) -> None:
    assert cell.structure.robot("arm")[1].joint_names == ("a", "b", "f")
    left, right = world_t(cell, "arm.left"), world_t(cell, "arm.right")
    hand = world_t(cell, "arm.hand")
    # By the definition of mimic: g = -1 * f + 0.01, with f = 0.02.
    np.testing.assert_allclose((np.linalg.inv(hand) @ left)[2, 3], 0.02, atol=1e-15)
    np.testing.assert_allclose((np.linalg.inv(hand) @ right)[2, 3], -0.01, atol=1e-15)


def test_chains_of_mimics_multiply_out() -> None:
    joints = [
        Joint("a", JointType.REVOLUTE, Z, LIMITS),
        Joint("b", JointType.REVOLUTE, Z, LIMITS, Mimic("a", 2.0, 0.1)),
        Joint("c", JointType.REVOLUTE, Z, LIMITS, Mimic("b", -3.0, 0.2)),
    ]
    specs = [NodeSpec("m", Kind.ROBOT, data=RobotData())] + [link(f"m.{j.name}", "m", j) for j in joints]
    made = after(empty(), CreateNodes(tuple(specs)), SetJointPositions("m", {"a": 0.3}))
    turn = world_t(made, "m.c")
    # c = -3 * (2 * 0.3 + 0.1) + 0.2 = -1.9
    np.testing.assert_allclose(np.arctan2(turn[1, 0], turn[0, 0]), -1.9, atol=1e-12)


def test_circular_mimics_are_refused() -> None:
    specs = (
        NodeSpec("m", Kind.ROBOT, data=RobotData()),
        link("m.a", "m", Joint("a", JointType.REVOLUTE, Z, LIMITS, Mimic("b"))),
        link("m.b", "m", Joint("b", JointType.REVOLUTE, Z, LIMITS, Mimic("a"))),
    )
    with pytest.raises(KernelError, match=r"a -> b -> a"):
        after(empty(), CreateNodes(specs))


def test_floating_joints_have_seven_coordinates_and_six_velocities(rng: np.random.Generator) -> None:
    specs = (
        NodeSpec("boat", Kind.ROBOT, data=RobotData()),
        link("boat.hull", "boat", Joint("free", JointType.FLOATING)),
        link("boat.rudder", "boat.hull", Joint("r", JointType.REVOLUTE, Z, LIMITS), shifted(x=-1.0)),
    )
    made = after(empty(), CreateNodes(specs))
    assert (made.structure.q_count, made.structure.v_count) == (8, 7)
    np.testing.assert_array_equal(world_t(made, "boat.hull"), np.eye(4))
    half = rng.uniform(0.1, 1.4)
    coordinates = np.array([1.0, 2.0, 3.0, 0.0, 0.0, np.sin(half), np.cos(half), 0.5])
    moved = after(made, SetJointPositions("boat", coordinates=coordinates))
    rudder = world_t(moved, "boat.rudder")
    # A turn about z by 2 * half, then the rudder 1 m behind turned by 0.5 more.
    np.testing.assert_allclose(rudder[:2, 3], [1 - np.cos(2 * half), 2 - np.sin(2 * half)], atol=1e-12)
    np.testing.assert_allclose(rudder[1, 0], np.sin(2 * half + 0.5), atol=1e-12)


def test_a_joint_that_cannot_be_zero_starts_at_its_nearest_limit() -> None:
    limits = JointLimits(0.5, 1.0, 1.0, 1.0, 1.0)
    specs = (NodeSpec("m", Kind.ROBOT, data=RobotData()), link("m.a", "m", Joint("a", JointType.REVOLUTE, Z, limits)))
    assert after(empty(), CreateNodes(specs)).state.q.tolist() == [0.5]


def test_changing_a_joint_keeps_the_others_where_they_are(cell: Change) -> None:
    data = LinkData(Joint("b", JointType.PRISMATIC, Z, JointLimits(-1.0, 1.0)))
    changed = after(cell, UpdateNode("arm.two", data=data))
    robot = changed.structure.robot("arm")[1]
    q = dict(zip(robot.joint_names, changed.state.q[robot.q_slice], strict=True))
    assert q == {"a": 0.3, "b": 0.0, "f": 0.02}


def test_a_batch_is_applied_whole_or_not_at_all(cell: Change) -> None:
    with pytest.raises(UnknownNameError) as refused:
        after(cell, RemoveNode("p"), AttachNode("nobody", "q"))
    assert refused.value.metadata["command_index"] == "1"
    assert cell.structure.node("p")


@pytest.mark.parametrize(
    ("spec", "reason", "match"),
    [
        (part("p", shifted()), Reason.NAME_TAKEN, "'p' is taken"),
        (part("", shifted()), Reason.INVALID_ARGUMENT, "may not be empty"),
        (part("x", shifted(), "nobody"), Reason.UNKNOWN_NAME, "no parent for 'x' named 'nobody'"),
        (link("x", "world", Joint("j")), Reason.INVALID_ARGUMENT, "'x' hangs on no robot"),
        (NodeSpec("x", Kind.LINK, "arm"), Reason.INVALID_ARGUMENT, "'x' needs the fields of a link"),
        (NodeSpec("x", Kind.WORLD), Reason.INVALID_ARGUMENT, "one world already"),
        (link("x", "arm", Joint("a", JointType.REVOLUTE, Z, LIMITS)), Reason.NAME_TAKEN, "two joints named 'a'"),
        (
            link("x", "arm", Joint("x", JointType.REVOLUTE, Z, LIMITS, Mimic("zz"))),
            Reason.UNKNOWN_NAME,
            "to mimic named 'zz'",
        ),
    ],
)
def test_impossible_nodes_are_refused(cell: Change, spec: NodeSpec, reason: Reason, match: str) -> None:
    with pytest.raises(KernelError, match=match) as refused:
        after(cell, CreateNodes((spec,)))
    assert refused.value.reason is reason


def test_clearing_leaves_only_the_world(cell: Change) -> None:
    cleared = after(cell, ClearWorld())
    assert [node.name for node in cleared.structure.nodes.values()] == ["world"]
    assert cleared.state.q.size == 0
    assert cleared.structure.next_uid == cell.structure.next_uid


def test_only_changes_of_structure_count_as_revisions(cell: Change) -> None:
    jumped = after(cell, SetJointPositions("arm", {"a": 0.1}))
    assert jumped.structure.revision == cell.structure.revision
    assert after(cell, AttachNode("p", "q")).structure.revision == cell.structure.revision + 1


def test_a_move_of_a_part_keeps_the_identity_of_all_other_nodes(cell: Change) -> None:
    held = after(cell, AttachNode("p", "arm.hand"))
    for uid, node in cell.structure.nodes.items():
        assert (held.structure.nodes[uid] is node) == (node.name != "p")
    assert held.structure.robots is cell.structure.robots
