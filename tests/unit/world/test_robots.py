"""Laws of tools, parts, joints, speeds and signals."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, LimitError, Reason, UnknownNameError
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import (
    AttachNode,
    CreateNodes,
    CreateSignal,
    PickPart,
    PlacePart,
    RemoveNode,
    RemoveSignal,
    SelectTool,
    SetJointPositions,
    SetSignal,
    SetSpeedFactor,
    SetToolState,
)
from virtualrobot_kernel.world.state import Selection, Signal
from virtualrobot_kernel.world.structure import Kind, NodeSpec, RobotData, ToolData

from tests.unit.world.builders import after, arm, empty, part, shifted, world_t


@pytest.fixture
def cell() -> Change:
    # With all joints at zero the gripper's tip is at (1.1, 0, 0.3).
    near, far = part("near", shifted(x=1.1, z=0.25)), part("far", shifted(x=1.1, y=0.15, z=0.3))
    return after(empty(), arm(), CreateNodes((far, near)))


def test_a_mounted_tool_is_chosen_and_in_its_first_state(cell: Change) -> None:
    robot, gripper = cell.structure.node("arm").uid, cell.structure.node("arm_gripper").uid
    assert cell.state.selections[robot] == Selection(gripper, "tip")
    assert cell.state.tool_states[gripper] == "open"
    assert cell.state.q.tolist() == [0.0, 0.0, 0.04]


def test_pick_takes_the_nearest_part_and_keeps_it_where_it_is(cell: Change) -> None:
    held = after(cell, PickPart("arm"))
    assert held.structure.nodes[held.structure.node("near").parent].name == "arm_gripper"
    np.testing.assert_allclose(world_t(held, "near"), world_t(cell, "near"), atol=1e-15)


def test_place_lets_go_where_it_is(cell: Change) -> None:
    held = after(cell, PickPart("arm", "near"), SetJointPositions("arm", {"a": 1.0}))
    placed = after(held, PlacePart("arm"))
    np.testing.assert_allclose(world_t(placed, "near"), world_t(held, "near"), atol=1e-15)
    assert placed.structure.nodes[placed.structure.node("near").parent].name == "world"


@pytest.mark.parametrize(
    ("commands", "match"),
    [
        ([PickPart("arm", "far", 0.1)], "'far' is 0.1500 m from the tool centre point of 'arm', farther than 0.1 m"),
        ([PickPart("arm", "near"), PickPart("arm", "near")], "'near' is held by the tool 'arm_gripper'"),
        ([RemoveNode("near"), RemoveNode("far"), PickPart("arm")], "no part that could be picked"),
        ([SetJointPositions("arm", {"a": 2.0}), PickPart("arm")], "farther than 0.2 m"),
        ([PlacePart("arm")], "holds no part"),
        ([SelectTool("arm"), PickPart("arm")], "'arm' works with no tool"),
    ],
)
def test_impossible_picks_are_refused(cell: Change, commands: list, match: str) -> None:
    with pytest.raises(KernelError, match=match) as refused:
        after(cell, *commands)
    assert refused.value.reason is Reason.WRONG_STATE


def test_a_tool_moves_with_its_selection(cell: Change) -> None:
    """A tool that goes to another robot leaves the first one without a tool."""
    vacuum = NodeSpec("vacuum", Kind.TOOL, "arm.hand", data=ToolData())
    other_robot = NodeSpec("other", Kind.ROBOT, data=RobotData())
    two = after(cell, RemoveNode("arm_gripper"), CreateNodes((other_robot, vacuum)))
    moved = after(two, AttachNode("vacuum", "other"))
    robot, other = (moved.structure.node(name).uid for name in ("arm", "other"))
    assert moved.state.selections[robot] == Selection()
    assert moved.state.selections[other].tool == moved.structure.node("vacuum").uid
    assert [tool.name for tool in moved.structure.tools_of(other)] == ["vacuum"]
    assert moved.structure.tools_of(robot) == ()


def test_removing_a_chosen_tool_leaves_none(cell: Change) -> None:
    gone = after(cell, RemoveNode("arm_gripper"))
    assert gone.state.selections[gone.structure.node("arm").uid] == Selection()


def test_select_tool_and_centre_point(cell: Change) -> None:
    side = after(cell, SelectTool("arm", "arm_gripper", "side"))
    assert side.state.selections[side.structure.node("arm").uid].tool_center_point == "side"
    with pytest.raises(UnknownNameError, match="'sode'; did you mean 'side'"):
        after(cell, SelectTool("arm", "arm_gripper", "sode"))
    with pytest.raises(UnknownNameError, match="no tool of 'arm' named 'near'"):
        after(cell, SelectTool("arm", "near"))


def test_tool_states_move_their_joints(cell: Change) -> None:
    closed = after(cell, SetToolState("arm_gripper", "closed"))
    assert closed.state.q.tolist() == [0.0, 0.0, 0.0]
    with pytest.raises(UnknownNameError, match="no state of the tool 'arm_gripper' named 'ajar'"):
        after(cell, SetToolState("arm_gripper", "ajar"))


def test_a_tool_state_beyond_limits_is_refused(cell: Change) -> None:
    tool = NodeSpec("wide", Kind.TOOL, "arm.hand", data=ToolData(states={"open": {"f": 0.5}}))
    with pytest.raises(LimitError, match=r"'f' of 'arm' cannot be at 0.5 m; its limits are 0 to 0.04 m"):
        after(cell, CreateNodes((tool,)))


@pytest.mark.parametrize(
    ("positions", "error", "match"),
    [
        ({"a": 2.5}, LimitError, r"'a' of 'arm' cannot be at 2.5 rad; its limits are -2 to 2 rad"),
        ({"a": float("nan")}, KernelError, "cannot be at nan"),
        ({"c": 0.0}, UnknownNameError, "no joint of 'arm' that can be moved named 'c'"),
        ({"g": 0.0}, UnknownNameError, "named 'g'"),
    ],
)
def test_impossible_joint_values_are_refused(cell: Change, positions: dict, error: type, match: str) -> None:
    with pytest.raises(error, match=match):
        after(cell, SetJointPositions("arm", positions))


def test_coordinates_must_fit_the_robot(cell: Change) -> None:
    with pytest.raises(KernelError, match="has 3 coordinates, not 2"):
        after(cell, SetJointPositions("arm", coordinates=np.zeros(2)))


@pytest.mark.parametrize("factor", [0.0, -0.1, 1.01, float("nan")])
def test_impossible_speed_factors_are_refused(cell: Change, factor: float) -> None:
    with pytest.raises(KernelError, match="above 0 and at most 1"):
        after(cell, SetSpeedFactor("arm", factor))


def test_signals_live_by_name() -> None:
    made = after(empty(), CreateSignal(Signal("ready", False, "the gate is shut")))
    on = after(made, SetSignal("ready", True))
    assert on.state.signals["ready"] == Signal("ready", True, "the gate is shut")
    assert made.state.signals["ready"].value is False
    assert not after(on, RemoveSignal("ready")).state.signals
    with pytest.raises(KernelError, match="taken by another signal"):
        after(made, CreateSignal(Signal("ready", True)))
    for command in (SetSignal("reedy", True), RemoveSignal("reedy")):
        with pytest.raises(UnknownNameError, match="did you mean 'ready'"):
            after(made, command)
