"""From wishes to planned motions: which joints they need, and what is refused before anything is planned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, LimitError, UnknownNameError
from virtualrobot_kernel.planning.moves import JointTrajectory, PointToPoint, ToolStateMove
from virtualrobot_kernel.planning.robots import Arm, world_poses
from virtualrobot_kernel.planning.together import joints_of
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import CreateNodes, UpdateNode
from virtualrobot_kernel.world.groups import Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, NodeSpec, ToolData, ToolWidth
from virtualrobot_sdk.kinematics import Kinematics

from tests.unit.planning.starts import start_of
from tests.unit.world.builders import TICK, after, arm, empty, ticked
from tests.unit.world.test_grippers import gripper


def pictured(change: Change) -> Snapshot:
    return Snapshot(change.structure, change.state, world_poses(change.structure, change.state), 1, 0.0, TICK)


def nobody(snapshot: Snapshot, arm: Arm) -> Kinematics:
    """Solve no arm: these moves need none."""
    raise AssertionError(f"nobody solves {arm.robot.name}")


@pytest.fixture
def cell() -> Change:
    vacuum = NodeSpec("cup", Kind.TOOL, "arm.hand", data=ToolData(states={"off": {}, "on": {}}))
    return after(empty(), arm(), CreateNodes((vacuum,)))


def test_a_tool_state_without_joints_is_there_with_the_next_tick(cell: Change) -> None:
    started = after(cell, start_of(pictured(cell), [ToolStateMove("arm", "cup", "on")], nobody))
    cup = started.structure.node("cup").uid
    assert started.state.tool_states[cup] == "off"
    assert started.state.motions[0].robots == (started.structure.node("arm").uid,)
    later = ticked(started).state
    assert later.tool_states[cup] == "on"
    assert not later.motions


def test_moves_of_different_joints_go_together_and_those_of_the_same_do_not(cell: Change) -> None:
    snapshot = pictured(cell)
    moves = [PointToPoint("arm", {"a": 1.0}), ToolStateMove("arm", "arm_gripper", "closed")]
    together = start_of(snapshot, moves, nobody)
    assert together.joints == (("arm", "a"), ("arm", "f"))
    with pytest.raises(KernelError, match="two moves of one motion move the joint 'a' of 'arm'"):
        start_of(snapshot, [PointToPoint("arm", {"a": 1.0}), PointToPoint("arm", "bent")], nobody)


def test_joints_that_are_needed_are_known_before_planning(cell: Change) -> None:
    snapshot = pictured(cell)
    uid = cell.structure.node("arm").uid
    wishes = [
        (PointToPoint("arm", {"b": 1.0}), {"b"}),
        (PointToPoint("arm", "bent"), {"a", "b"}),
        (ToolStateMove("arm", "", "closed"), {"f"}),
        (JointTrajectory("arm", ("a",), np.zeros(2), np.zeros((2, 1))), {"a"}),
    ]
    for wish, names in wishes:
        assert joints_of(snapshot, [wish]) == {(uid, name) for name in names}


@pytest.mark.parametrize(
    ("move", "error", "match"),
    [
        (PointToPoint("arm", {}), KernelError, "names no joint"),
        (PointToPoint("arm", "bend"), UnknownNameError, "did you mean 'bent'"),
        (PointToPoint("arm", {"g": 0.0}), UnknownNameError, "that can be moved named 'g'"),
        (ToolStateMove("arm", "cop", "on"), UnknownNameError, "did you mean 'cup'"),
        (ToolStateMove("arm", "cup", "an"), UnknownNameError, "no state of the tool 'cup' named 'an'"),
        (JointTrajectory("arm", (), np.zeros(2), np.zeros((2, 0))), KernelError, "must name its joints"),
    ],
)
def test_impossible_wishes_are_refused(cell: Change, move: object, error: type, match: str) -> None:
    with pytest.raises(error, match=match):
        start_of(pictured(cell), [move], nobody)  # pyright: ignore[reportArgumentType] each is a Move


def test_nothing_to_move_is_refused(cell: Change) -> None:
    with pytest.raises(KernelError, match="at least one move"):
        start_of(pictured(cell), [], nobody)


def test_the_fingers_of_a_gripper_are_moved_by_the_name_of_its_arm() -> None:
    """By whatever group of the arm, whose joints are others; a width is a state where it is that of one."""
    world = after(empty(), arm(), gripper("hand", "arm.hand"))
    tool = world.structure.node("hand.tool")
    assert isinstance(tool.data, ToolData)
    widths = tuple(ToolWidth(2.0 * at, {"f": at}) for at in (0.0, 0.04))
    world = after(world, UpdateNode("hand.tool", data=replace(tool.data, widths=widths)))
    uids = [world.structure.node(name).uid for name in ("arm", "hand", "hand.tool")]
    for group in (Group(), Group(base="one", tip="hand")):
        for width, state in ((0.02, ""), (0.0, "closed")):
            move = ToolStateMove("arm", "hand.tool", width=width, group=group)
            assert joints_of(pictured(world), [move]) == {(uids[1], "f")}
            started = after(world, start_of(pictured(world), [move, PointToPoint("arm", {"f": 0.01})], nobody))
            motion = started.state.motions[0]
            assert set(motion.robots) == set(uids[:2])
            assert motion.tool_states == (((0, uids[2], state),) if state else ())
            later = ticked(started, 400).state
            places = [world.structure.robots[uid].coordinates["f"].q for uid in uids[:2]]
            np.testing.assert_allclose(later.q[places], [0.01, width / 2.0], atol=1e-12)
            assert later.tool_states[uids[2]] == (state or "open")
    other = start_of(pictured(world), [ToolStateMove("arm", "hand.tool", width=0.02)], nobody)
    with pytest.raises(KernelError, match="table of widths has changed"):
        after(world, UpdateNode("hand.tool", data=replace(tool.data, widths=widths[::-1])), other)
    with pytest.raises(LimitError, match=r"its widths are 0 to 0\.08 m"):
        joints_of(pictured(world), [ToolStateMove("hand", width=0.081, tool="")])
    with pytest.raises(KernelError, match="has no widths"):
        joints_of(pictured(world), [ToolStateMove("arm", "arm_gripper", width=0.01)])
