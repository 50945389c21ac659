"""Laws of targets: what they name is there, follows other names, and is forgotten with its robot."""

from __future__ import annotations

import pytest
from virtualrobot_kernel.drawing.inventory import look_of
from virtualrobot_kernel.errors import KernelError, UnknownNameError
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import CreateNodes, RemoveNode, SetPostures, UpdateNode
from virtualrobot_kernel.world.figures import Label
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, LinkData, NodeSpec, RobotData, TargetData

from tests.unit.world.builders import after, arm, empty


def target(**data: object) -> CreateNodes:
    return CreateNodes((NodeSpec("pick", Kind.TARGET, data=TargetData(**data)),))  # pyright: ignore[reportArgumentType]


@pytest.fixture
def taught() -> Change:
    return after(empty(), arm(), target(robot="arm", tool="arm_gripper", joint_positions={"a": 0.5, "b": 0.1}))


def data(change: Change) -> TargetData:
    found = change.structure.node("pick").data
    assert isinstance(found, TargetData)
    return found


def test_joints_and_nodes_of_other_names_are_followed(taught: Change) -> None:
    link = next(node for node in taught.structure.nodes.values() if _joint(node.data) == "a")
    assert isinstance(link.data, LinkData)
    joint = link.data.joint
    renamed = LinkData(Joint("shoulder", joint.type, joint.axis, joint.limits))
    changed = after(taught, UpdateNode(link.name, data=renamed), UpdateNode("arm_gripper", new_name="claw"))
    assert data(changed).joint_positions == {"shoulder": 0.5, "b": 0.1}
    assert data(changed).tool == "claw"


def test_what_is_gone_is_forgotten(taught: Change) -> None:
    without_tool = after(taught, RemoveNode("arm_gripper"))
    assert data(without_tool) == TargetData("arm", joint_positions={"a": 0.5, "b": 0.1})
    assert data(after(taught, RemoveNode("arm"))) == TargetData()


def test_a_joint_that_a_target_names_is_kept(taught: Change) -> None:
    link = next(node.name for node in taught.structure.nodes.values() if _joint(node.data) == "b")
    without = after(taught, UpdateNode("arm", data=RobotData()), RemoveNode("arm_gripper"))
    with pytest.raises(KernelError, match="the target 'pick': there is no joint of 'arm'"):
        after(without, UpdateNode(link, data=LinkData(Joint("b"))))


@pytest.mark.parametrize(
    "wrong",
    [
        {"robot": "nobody"},
        {"robot": "arm", "joint_positions": {"z": 0.0}},
        {"tool": "arm"},
        {"joint_positions": {"a": 0.0}},
    ],
)
def test_a_target_names_what_there_is(wrong: dict[str, object]) -> None:
    with pytest.raises(KernelError, match="the target 'pick'"):
        after(empty(), arm(), target(**wrong))


def test_postures_are_taken_away_before_others_come(taught: Change) -> None:
    two = after(taught, SetPostures("arm", {"up": {"a": 0.1}, "down": {"a": -0.1}}))
    one = after(two, SetPostures("arm", {"up": {"b": 0.2}}, ("up", "down", "bent")))
    robot = one.structure.node("arm").data
    assert isinstance(robot, RobotData)
    assert robot.postures == {"up": {"b": 0.2}}
    with pytest.raises(UnknownNameError, match="no posture of 'arm' named 'dwon'; did you mean 'down'"):
        after(two, SetPostures("arm", removed=("dwon",)))
    with pytest.raises(KernelError, match="posture 'far'"):
        after(two, SetPostures("arm", {"far": {"a": 99.0}}))


def test_people_see_a_frame_with_its_name(taught: Change) -> None:
    look = look_of(taught.structure.node("pick"))
    assert [one.geometry for one in look.annotations] == [Label("pick")]
    assert len(look.pieces) == 1
    shown = look_of(after(taught, UpdateNode("pick", new_name="place")).structure.node("place"))
    assert [one.geometry for one in shown.annotations] == [Label("place")]


def _joint(found: object) -> str:
    return found.joint.name if isinstance(found, LinkData) and found.joint.type is not JointType.FIXED else ""
