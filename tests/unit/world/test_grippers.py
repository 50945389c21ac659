"""Grippers that are robots of their own: whose tools they bring, who must be free for them, what they follow."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.affected_robots import affected_robots
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.collisions import CollisionMode, CollisionSettings
from virtualrobot_kernel.world.commands import (
    AttachNode,
    Command,
    CreateNodes,
    MountTool,
    RemoveNode,
    SelectTool,
    SetJointPositions,
    SetToolState,
    UnmountTool,
    UpdateNode,
)
from virtualrobot_kernel.world.state import Selection, Snapshot
from virtualrobot_kernel.world.structure import (
    Joint,
    JointLimits,
    JointType,
    Kind,
    LinkData,
    NodeSpec,
    RobotData,
    ToolData,
)

from tests.unit.world.builders import LIMITS, Z, after, arm, empty, link, random_pose, shifted, world_t

FINGER = Joint("f", JointType.PRISMATIC, Z, JointLimits(0.0, 0.04, 0.2, 1.0, 10.0))


def gripper(name: str, parent: str = "world") -> CreateNodes:
    """Return a gripper whose palm is fixed and whose one finger slides by a joint called as one of the arm's."""
    states = {"open": {"f": 0.04}, "closed": {"f": 0.0}}
    return CreateNodes(
        (
            NodeSpec(name, Kind.ROBOT, parent, data=RobotData()),
            link(f"{name}.palm", name, Joint("fixed")),
            link(f"{name}.finger", f"{name}.palm", FINGER),
            NodeSpec(f"{name}.tool", Kind.TOOL, f"{name}.palm", data=ToolData({"tip": shifted(z=0.1)}, states)),
        )
    )


def bare(name: str = "arm", parent: str = "world") -> CreateNodes:
    """Return an arm without a tool, with the joints a and b."""
    specs = [spec for spec in arm(name).specs if spec.kind is not Kind.TOOL and spec.name[-4:] not in ("left", "ight")]
    return CreateNodes((NodeSpec(name, Kind.ROBOT, parent, data=RobotData(flange="hand")), *specs[1:]))


def rail() -> CreateNodes:
    carriage = link("rail.carriage", "rail", Joint("x", JointType.PRISMATIC, Z, LIMITS))
    return CreateNodes((NodeSpec("rail", Kind.ROBOT, data=RobotData()), carriage))


def tools(world: Change, robot: str) -> list[str]:
    return [tool.name for tool in world.structure.tools_of(world.structure.node(robot).uid)]


def chosen(world: Change, robot: str) -> tuple[str, str]:
    selection = world.state.selections.get(world.structure.node(robot).uid, Selection())
    return (world.structure.nodes[selection.tool].name if selection.tool else "", selection.tool_center_point)


def affected(world: Change, *commands: Command) -> set[str]:
    snapshot = Snapshot(world.structure, world.state, np.zeros((0, 4, 4)), 0, 0.0, 0.004)
    return {world.structure.nodes[uid].name for uid in affected_robots(snapshot, commands)}


@pytest.fixture
def mounted() -> Change:
    return after(empty(), rail(), bare(parent="rail.carriage"), gripper("hand"), MountTool("arm", "hand"))


def test_a_tool_is_of_all_robots_that_it_is_fixed_to(mounted: Change) -> None:
    assert tools(mounted, "hand") == tools(mounted, "arm") == ["hand.tool"]
    assert tools(mounted, "rail") == [], "the arm's joints move it against the rail"
    assert chosen(mounted, "arm") == chosen(mounted, "hand") == ("hand.tool", "tip")
    structure = mounted.structure
    uid = {name: structure.node(name).uid for name in ("rail", "arm", "hand")}
    assert structure.grippers_of(uid["arm"]) == {uid["hand"]}
    assert structure.grippers_of(uid["rail"]) == structure.grippers_of(uid["hand"]) == set()
    assert structure.with_holders([uid["hand"]]) == (uid["hand"], uid["arm"])
    assert structure.with_holders([uid["arm"]]) == (uid["arm"],)
    assert [tool.name for tool in structure.own_tools_of(uid["hand"])] == ["hand.tool"]
    assert structure.own_tools_of(uid["arm"]) == ()


def test_a_gripper_is_where_its_robot_hangs(rng: np.random.Generator) -> None:
    world = after(empty(), bare(), gripper("hand"), SetJointPositions("arm", {"a": 0.3, "b": -0.4}))
    place = random_pose(rng)
    world = after(world, MountTool("arm", "hand", parent_t_node=place))
    np.testing.assert_allclose(world_t(world, "hand.palm"), world_t(world, "arm.hand") @ place, atol=1e-12)
    away = after(world, UnmountTool("arm"))
    np.testing.assert_allclose(world_t(away, "hand.palm"), world_t(world, "hand.palm"), atol=1e-12)
    assert (tools(away, "arm"), chosen(away, "arm"), chosen(away, "hand")) == ([], ("", ""), ("hand.tool", "tip"))
    again = after(world, AttachNode("hand", "world"))
    assert (tools(again, "arm"), chosen(again, "arm")) == ([], ("", "")), "attaching says it too"


def test_a_changer_and_adapters_lie_between() -> None:
    changer = CreateNodes(
        (NodeSpec("changer", Kind.ROBOT, data=RobotData()), link("changer.plate", "changer", Joint("fixed")))
    )
    adapter = CreateNodes((NodeSpec("adapter", Kind.ADAPTER, "arm.hand", shifted(z=0.02)),))
    world = after(empty(), bare(), adapter, gripper("hand"), changer, AttachNode("hand", "changer.plate"))
    assert tools(world, "changer") == ["hand.tool"]
    world = after(world, MountTool("arm", "changer", "adapter", shifted(z=0.01)))
    assert chosen(world, "arm") == ("hand.tool", "tip")
    np.testing.assert_allclose(world_t(world, "hand.palm"), world_t(world, "arm.hand") @ shifted(z=0.03), atol=1e-12)
    assert len(world.structure.grippers_of(world.structure.node("arm").uid)) == 2
    off = after(world, UnmountTool("arm"))
    assert off.structure.nodes[off.structure.node("changer").parent].name == "world", "what hangs on the arm goes"
    part = after(world, UnmountTool("arm", "hand"))
    assert (tools(part, "arm"), tools(part, "changer")) == ([], [])


def test_tools_are_changed_in_one_batch(mounted: Change) -> None:
    rack = CreateNodes((NodeSpec("rack", Kind.OBJECT, parent_t_node=shifted(x=3.0)),))
    world = after(mounted, rack, gripper("other"))
    with pytest.raises(KernelError, match=r"'hand\.tool' hangs at 'arm\.hand' already") as refused:
        after(world, MountTool("arm", "other"))
    assert refused.value.reason is Reason.WRONG_STATE
    world = after(world, UnmountTool("arm", "", "rack", shifted(z=0.5)), MountTool("arm", "other", "", None, "tip"))
    assert (tools(world, "arm"), chosen(world, "arm")) == (["other.tool"], ("other.tool", "tip"))
    np.testing.assert_allclose(world_t(world, "hand.palm"), shifted(x=3.0, z=0.5), atol=1e-12)


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (MountTool("arm", "hand"), "mounted on 'arm' already"),
        (MountTool("arm", "arm"), "which hangs below it"),
        (MountTool("arm", "other.finger"), "is no tool and brings none"),
        (MountTool("arm", "table"), "is no tool and brings none"),
        (MountTool("arm", "nothing"), "no node"),
        (MountTool("arm", "other", "table"), "no tool of 'arm'"),
        (MountTool("arm", "other", "rail.carriage"), "no tool of 'arm'"),
        (MountTool("arm", "other", "hand.finger"), "no tool of 'arm'"),
        (MountTool("arm", "other", "other.palm"), "hangs below it"),
        (MountTool("second", "other", "", None, "tup"), "tup"),
        (UnmountTool("arm", "table"), "no tool that can be taken off"),
        (UnmountTool("arm", "other"), "no tool that can be taken off"),
        (UnmountTool("arm", "arm"), "no tool that can be taken off"),
        (UnmountTool("arm", "hand.palm"), "no tool that can be taken off"),
        (UnmountTool("second"), "works with no tool"),
        (UnmountTool("arm", "", "arm.two"), "would be still"),
    ],
)
def test_what_makes_no_sense_is_refused(mounted: Change, command: Command, words: str) -> None:
    world = after(mounted, CreateNodes((NodeSpec("table", Kind.OBJECT),)), gripper("other"), bare("second"))
    with pytest.raises(KernelError, match=words):
        after(world, command)


def test_joints_of_one_name_are_no_ones_but_their_robots() -> None:
    """A gripper's states name its own joints: the arm's joint of the same name is not meant, also when renamed."""
    world = after(empty(), arm(), gripper("hand"), AttachNode("hand", "arm.hand"))
    assert tools(world, "arm") == ["arm_gripper", "hand.tool"]
    closed = after(world, SetToolState("hand.tool", "closed"), SetJointPositions("arm", {"f": 0.02}))
    rows = closed.structure.robots
    at = {name: rows[closed.structure.node(name).uid].coordinates["f"].q for name in ("arm", "hand")}
    assert (closed.state.q[at["hand"]], closed.state.q[at["arm"]]) == (0.0, 0.02)
    left = closed.structure.node("arm.left").data
    assert isinstance(left, LinkData)
    joint = Joint("claw", JointType.PRISMATIC, left.joint.axis, left.joint.limits)
    renamed = after(closed, UpdateNode("arm.left", data=LinkData(joint)))
    own, others = (renamed.structure.node(name).data for name in ("arm_gripper", "hand.tool"))
    assert isinstance(own, ToolData) and isinstance(others, ToolData)
    assert (set(own.states["open"]), set(others.states["open"])) == ({"claw"}, {"f"})


def test_what_a_robot_works_with_ends_with_its_tool(mounted: Change) -> None:
    """A palm that begins to slide is no more fixed to the arm."""
    sliding = LinkData(Joint("s", JointType.PRISMATIC, Z, LIMITS))
    world = after(mounted, UpdateNode("hand.palm", data=sliding))
    assert (tools(world, "arm"), chosen(world, "arm")) == ([], ("", ""))
    assert chosen(world, "hand") == ("hand.tool", "tip")
    assert chosen(after(mounted, RemoveNode("hand")), "arm") == ("", "")
    assert chosen(after(mounted, SelectTool("arm")), "arm") == ("", "")


def test_an_arm_is_asked_before_its_gripper_is_touched(mounted: Change) -> None:
    world = after(mounted, gripper("other"))
    assert affected(world, SetToolState("hand.tool", "closed")) == {"hand", "arm"}
    assert affected(world, SetJointPositions("arm", {"a": 0.1})) == {"arm"}
    assert affected(world, UnmountTool("arm")) == {"hand", "arm"}
    assert affected(world, MountTool("arm", "other")) == {"other", "arm"}
    assert affected(world, AttachNode("hand", "world")) == {"hand", "arm"}


def test_a_gripper_has_the_mode_of_its_arm_unless_it_has_its_own(mounted: Change) -> None:
    structure = mounted.structure
    rail, arm, hand = (structure.node(name).uid for name in ("rail", "arm", "hand"))
    of_arm = CollisionSettings(modes={arm: CollisionMode.GUARD})
    assert of_arm.modes_of(structure) == {rail: CollisionMode.OFF, arm: CollisionMode.GUARD, hand: CollisionMode.GUARD}
    own = CollisionSettings(CollisionMode.STOP, {hand: CollisionMode.MONITOR, arm: CollisionMode.GUARD})
    assert own.modes_of(structure)[hand] is CollisionMode.MONITOR
    assert of_arm.modes_of(after(mounted, UnmountTool("arm")).structure)[hand] is CollisionMode.OFF
