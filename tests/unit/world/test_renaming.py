"""A joint of another name is the same joint: it stays where it is, and whatever named it names it by its new name."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import (
    Command,
    CreateNodes,
    SetJointPositions,
    SetToolState,
    StartMotion,
    UpdateNode,
)
from virtualrobot_kernel.world.state import State
from virtualrobot_kernel.world.structure import (
    Joint,
    JointGroup,
    JointLimits,
    JointType,
    Kind,
    LinkData,
    Mimic,
    NodeSpec,
    RobotData,
    Structure,
    ToolData,
)

from tests.unit.world.builders import LIMITS, Z, after, arm, empty, link, shifted, ticked
from tests.unit.world.test_consistency import plan

FINGER = JointLimits(0.0, 0.04, 0.2, 1.0, 10.0)


@pytest.fixture
def cell() -> Change:
    """Return a world in which another arm stands before and behind the one that is changed."""
    there = SetJointPositions("arm", {"a": 0.3, "b": -0.7, "f": 0.02})
    return after(empty(), arm("before"), arm(), arm("behind"), there, SetJointPositions("behind", {"b": 1.0}))


def positions(structure: Structure, state: State, robot: str = "arm") -> dict[str, float]:
    index = structure.robot(robot)[1]
    return dict(zip(index.joint_names, state.q[index.q_slice].tolist(), strict=True))


def turn(name: str, limits: JointLimits = LIMITS) -> LinkData:
    return LinkData(Joint(name, JointType.REVOLUTE, Z, limits))


def slide(name: str) -> LinkData:
    return LinkData(Joint(name, JointType.PRISMATIC, Z, FINGER))


def test_a_renamed_joint_stays_where_it_is(cell: Change) -> None:
    named = after(cell, UpdateNode("arm.one", data=turn("shoulder")))
    assert positions(named.structure, named.state) == {"shoulder": 0.3, "b": -0.7, "f": 0.02}
    for other in ("before", "behind"):
        here, there = (positions(world.structure, world.state, other) for world in (named, cell))
        assert here == there


def test_a_renamed_joint_keeps_its_velocity(cell: Change) -> None:
    state = cell.state
    v = np.arange(1.0, 1.0 + len(state.v))
    moving = State(state.tick, state.q, v, state.parent_t_node, tool_states=state.tool_states)
    named = after(Change(cell.structure, moving), UpdateNode("arm.two", data=turn("elbow")))
    np.testing.assert_array_equal(named.state.v, v)


def test_joints_can_swap_their_names_and_not_their_places(cell: Change) -> None:
    swapped = after(
        cell,
        UpdateNode("arm.one", data=turn("x")),
        UpdateNode("arm.two", data=turn("a")),
        UpdateNode("arm.one", data=turn("b")),
    )
    assert positions(swapped.structure, swapped.state) == {"b": 0.3, "a": -0.7, "f": 0.02}
    data = swapped.structure.node("arm").data
    assert isinstance(data, RobotData)
    assert data.postures == {"bent": {"b": 0.5, "a": -0.5}}, "the posture is where it was"


def test_what_names_a_joint_follows_it(cell: Change) -> None:
    grouped = RobotData("hand", postures={"bent": {"a": 0.5, "f": 0.01}}, groups=(JointGroup("hand", ("b", "f")),))
    named = after(cell, UpdateNode("arm", data=grouped), UpdateNode("arm.left", data=slide("thumb")))
    data, tool = named.structure.node("arm").data, named.structure.node("arm_gripper").data
    assert isinstance(data, RobotData)
    assert isinstance(tool, ToolData)
    assert data.postures == {"bent": {"a": 0.5, "thumb": 0.01}}
    assert data.groups[0].joint_names == ("b", "thumb")
    assert tool.states == {"open": {"thumb": 0.04}, "closed": {"thumb": 0.0}}
    finger = named.structure.node("arm.right").data
    assert isinstance(finger, LinkData)
    assert finger.joint.mimic == Mimic("thumb", -1.0, 0.01)
    other = named.structure.node("behind_gripper").data
    assert isinstance(other, ToolData)
    assert other.states["open"] == {"f": 0.04}, "another robot's joint of the old name"


def test_postures_of_a_renamed_base_name_its_coordinates() -> None:
    def base(name: str) -> LinkData:
        return LinkData(Joint(name, JointType.PLANAR, Z, LIMITS))

    made = CreateNodes(
        (
            NodeSpec("agv", Kind.ROBOT, data=RobotData(postures={"dock": {"base/x": 1.0, "base/theta": 0.5}})),
            NodeSpec("agv.body", Kind.LINK, "agv", data=base("base")),
        )
    )
    data = after(empty(), made, UpdateNode("agv.body", data=base("floor"))).structure.node("agv").data
    assert isinstance(data, RobotData)
    assert data.postures == {"dock": {"floor/x": 1.0, "floor/theta": 0.5}}


def test_a_joint_and_its_tool_change_in_one_batch(cell: Change) -> None:
    wide = ToolData({"tip": shifted(x=0.1)}, {"open": {"thumb": 0.03}, "half": {"thumb": 0.02}})
    named = after(
        cell,
        UpdateNode("arm.left", data=slide("thumb")),
        UpdateNode("arm_gripper", data=wide),
        SetToolState("arm_gripper", "half"),
    )
    assert positions(named.structure, named.state)["thumb"] == 0.02
    tool = named.structure.node("arm_gripper")
    assert named.state.tool_states[tool.uid] == "half"


def test_a_joint_with_an_adopted_name_and_narrower_limits_is_refused_by_what_named_it(cell: Change) -> None:
    with pytest.raises(KernelError, match=r"the posture 'bent' of 'arm': the joint 'shoulder'") as refused:
        after(cell, UpdateNode("arm.one", data=turn("shoulder", JointLimits(0.0, 0.4))))
    assert refused.value.reason is Reason.LIMIT_EXCEEDED


def test_the_name_of_a_fixed_joint_is_nobody_s(cell: Change) -> None:
    """A fixed joint may have the name of one that moves; that one alone is meant by what names it."""
    twice = after(cell, CreateNodes((link("arm.plate", "arm.hand", Joint("a")),)))
    named = after(twice, UpdateNode("arm.plate", data=LinkData(Joint("bolt"))))
    data = named.structure.node("arm").data
    assert isinstance(data, RobotData)
    assert data.postures == {"bent": {"a": 0.5, "b": -0.5}}


def test_another_robot_s_motion_goes_on(cell: Change) -> None:
    """The joints behind the renamed one are where they were, and so is their motion."""
    moving = after(cell, StartMotion((("behind", "a"),), plan(a=(0.0, 1.0))))
    command: Command = UpdateNode("arm.one", data=turn("shoulder"))
    renamed_first, moved_first = ticked(after(moving, command), 100).state, ticked(moving, 100).state
    np.testing.assert_array_equal(renamed_first.q, moved_first.q)
    assert 0.0 < positions(moving.structure, moved_first, "behind")["a"] < 1.0


def test_a_joint_that_moves_keeps_its_name(cell: Change) -> None:
    moving = after(cell, StartMotion((("arm", "a"),), plan(a=(0.3, 1.0))))
    with pytest.raises(KernelError) as refused:
        after(moving, UpdateNode("arm.two", data=turn("elbow")))
    assert refused.value.reason is Reason.ROBOT_BUSY


def test_a_new_joint_of_an_old_name_is_another_joint() -> None:
    made = after(empty(), CreateNodes((NodeSpec("r", Kind.ROBOT, data=RobotData()), link("r.x", "r", turn("j").joint))))
    both = after(
        made,
        SetJointPositions("r", {"j": 0.5}),
        UpdateNode("r.x", data=turn("k")),
        CreateNodes((link("r.y", "r.x", turn("j").joint),)),
    )
    assert positions(both.structure, both.state, "r") == {"k": 0.5, "j": 0.0}
