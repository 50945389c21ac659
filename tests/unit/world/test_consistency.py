"""The world never comes to contradict itself: what is saved of it can be loaded, and time always goes on."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.limits import JointLimits as PlanLimits
from virtualrobot_kernel.motion.plan import plan_ptp
from virtualrobot_kernel.motion.program import Program, of_plan
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import (
    AttachNode,
    Command,
    CreateNodes,
    PickPart,
    RemoveNode,
    SelectTool,
    SetJointPositions,
    SetSpeedFactor,
    StartMotion,
    StopMotions,
    UpdateNode,
)
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

from tests.unit.world.builders import LIMITS, Z, after, arm, empty, link, part, shifted, ticked


@pytest.fixture
def cell() -> Change:
    return after(empty(), arm())


def plan(**joints: tuple[float, float]) -> Program:
    """Return the motion of joints from the first to the second value."""
    count = len(joints)
    limits = PlanLimits(
        tuple(joints),
        np.full(count, -2.0),
        np.full(count, 2.0),
        np.full(count, 1.0),
        np.full(count, 4.0),
        np.full(count, 40.0),
    )
    start, goal = zip(*joints.values(), strict=True)
    return of_plan(plan_ptp(np.array(start), np.array(goal), limits))


def moving(cell: Change, **joints: tuple[float, float]) -> Change:
    """Return the world with the arm's motion of these joints started."""
    return after(cell, StartMotion(tuple(("arm", name) for name in joints), plan(**joints)))


def test_the_slowest_factors_multiply_to_no_standstill(cell: Change) -> None:
    slow = after(moving(cell, a=(0.0, 1.0)), SetSpeedFactor("", 1e-200), SetSpeedFactor("arm", 1e-200))
    state = ticked(slow, 200).state
    assert state.motions[0].running.phase is Phase.RUNNING
    assert 0.0 < state.q[0] < 1.0


def test_a_stop_leaves_a_motion_without_length_its_success(cell: Change) -> None:
    gripped = StartMotion((("arm", "f"),), plan(f=(0.04, 0.04)), ((0, "arm_gripper", "closed"),))
    state = ticked(after(cell, gripped, StopMotions())).state
    (motion,) = state.ended
    assert (motion.running.phase, motion.cancellation) == (Phase.SUCCEEDED, None)
    assert list(state.tool_states.values()) == ["closed"]


def turning(lower: float, upper: float) -> LinkData:
    """Return the data of a link on the arm's joint `a` with other limits."""
    return LinkData(Joint("a", JointType.REVOLUTE, Z, JointLimits(lower, upper, 1.0, 4.0, 40.0)))


@pytest.mark.parametrize(
    ("commands", "reason", "match"),
    [
        pytest.param(
            [SetJointPositions("arm", {"a": 1.5}), UpdateNode("arm.one", data=turning(-1.0, 1.0))],
            Reason.LIMIT_EXCEEDED,
            r"'a' of 'arm' cannot be at 1\.5 rad; its limits are -1 to 1",
            id="limits that leave out where the joint is",
        ),
        pytest.param(
            [UpdateNode("arm.one", data=turning(-0.1, 0.1))],
            Reason.LIMIT_EXCEEDED,
            r"the posture 'bent' of 'arm': the joint 'a'",
            id="limits that leave out a posture",
        ),
        pytest.param(
            [RemoveNode("arm.right"), RemoveNode("arm.left")],
            Reason.UNKNOWN_NAME,
            r"the state 'open' of the tool 'arm_gripper': there is no joint",
            id="a tool without its finger",
        ),
        pytest.param(
            [AttachNode("arm_gripper", "world")],
            Reason.INVALID_ARGUMENT,
            "names joints, but the tool is on no robot",
            id="fingers without their tool",
        ),
        pytest.param(
            [SelectTool("arm", "arm_gripper", "side"), UpdateNode("arm_gripper", data=ToolData())],
            Reason.WRONG_STATE,
            "'arm' works with the tool centre point 'side'",
            id="a tool centre point in use",
        ),
        pytest.param(
            [UpdateNode("arm_gripper", data=ToolData({"tip": shifted()}, {"closed": {"f": 0.0}}))],
            Reason.WRONG_STATE,
            "'arm_gripper' is in the state 'open'",
            id="a state that a tool is in",
        ),
        pytest.param(
            [
                CreateNodes(
                    (
                        NodeSpec("plate", Kind.OBJECT, "arm.hand"),
                        link("arm.extra", "plate", Joint("x", JointType.REVOLUTE, Z, LIMITS)),
                    )
                )
            ],
            Reason.INVALID_ARGUMENT,
            "its parent must be a robot or one of its links",
            id="a link on an object",
        ),
        pytest.param(
            [CreateNodes((part("two\nlines", shifted()),))],
            Reason.INVALID_ARGUMENT,
            r"cannot be printed; this one is 'two\\nlines'",
            id="a name of two lines",
        ),
    ],
)
def test_what_would_not_load_again_is_refused(
    cell: Change, commands: list[Command], reason: Reason, match: str
) -> None:
    with pytest.raises(KernelError, match=match) as refused:
        after(cell, *commands)
    assert refused.value.reason is reason


@pytest.mark.parametrize(
    "command",
    [
        UpdateNode("arm.two", parent_t_node=shifted(x=1.0)),
        CreateNodes((NodeSpec("other", Kind.TOOL, "arm.hand", data=ToolData(states={"half": {"f": 0.02}})),)),
        RemoveNode("adapter"),
        AttachNode("adapter", "world"),
    ],
    ids=["a link elsewhere", "a tool that moves a finger at once", "the tool's adapter gone", "the adapter elsewhere"],
)
def test_a_moving_robot_keeps_what_its_motion_is_about(cell: Change, command: Command) -> None:
    mounted = after(
        cell,
        CreateNodes((NodeSpec("adapter", Kind.ADAPTER, "arm.hand"),)),
        AttachNode("arm_gripper", "adapter"),
        StartMotion((("arm", "f"),), plan(f=(0.04, 0.0)), ((0, "arm_gripper", "closed"),)),
    )
    with pytest.raises(KernelError) as refused:
        after(mounted, command)
    assert refused.value.reason is Reason.ROBOT_BUSY


@pytest.mark.parametrize("carrier", [Kind.ADAPTER, Kind.PART])
def test_a_tool_that_leaves_with_what_carries_it_is_chosen_no_more(cell: Change, carrier: Kind) -> None:
    vacuum = NodeSpec("vacuum", Kind.TOOL, "carrier", data=ToolData())
    on = after(
        cell, CreateNodes((NodeSpec("carrier", carrier, "arm.hand"), vacuum)), SelectTool("arm", "vacuum", "tcp")
    )
    off = after(on, AttachNode("carrier", "world"))
    robot = off.structure.node("arm").uid
    assert off.state.selections[robot].tool == 0
    assert [tool.name for tool in off.structure.tools_of(robot)] == ["arm_gripper"]
    again = after(off, AttachNode("carrier", "arm.hand"))
    assert again.state.selections[robot].tool == off.structure.node("vacuum").uid


def test_the_flange_keeps_its_link_under_other_names() -> None:
    robot = NodeSpec("r", Kind.ROBOT, data=RobotData(flange="r.end"))
    made = after(empty(), CreateNodes((robot, link("r.end", "r", Joint("j", JointType.REVOLUTE, Z, LIMITS)))))
    for command in (UpdateNode("r", new_name="s"), UpdateNode("s.end", new_name="tip")):
        made = after(made, command)
    assert made.structure.robot("s")[1].flange == made.structure.node("tip").uid


def test_a_robot_does_not_pick_what_it_stands_on(cell: Change) -> None:
    parts = CreateNodes((part("pallet", shifted(x=1.0)), part("box", shifted(x=1.3))))
    standing = after(cell, parts, AttachNode("arm", "pallet"))
    picked = after(standing, PickPart("arm", max_distance=10.0))
    assert [picked.structure.nodes[uid].name for uid in picked.picked] == ["box"]
    with pytest.raises(KernelError, match="'arm' stands on the part 'pallet'"):
        after(standing, PickPart("arm", "pallet"))


def test_a_deep_tree_can_be_removed(cell: Change) -> None:
    # Deeper than Python's limit of nested calls, 1000.
    tower = [NodeSpec(f"n{i}", Kind.OBJECT, f"n{i - 1}" if i else "world") for i in range(1500)]
    left = after(after(cell, CreateNodes(tuple(tower))), RemoveNode("n0"))
    assert left.structure.nodes.keys() == cell.structure.nodes.keys()


def test_where_a_motion_may_end_a_joint_may_be(cell: Change) -> None:
    """The planner lets a goal be outside by 1e-6 rad: such a scene must load again."""
    going = moving(cell, a=(0.0, 2.0 + 0.9e-6))
    while going.state.motions:
        going = ticked(going)
    state = going.state
    assert state.q[0] > 2.0
    again = after(cell, SetJointPositions("arm", coordinates=state.q))
    np.testing.assert_array_equal(again.state.q, state.q)


def test_a_motion_planned_before_its_limits_shrank_is_refused(cell: Change) -> None:
    shrunk = after(cell, UpdateNode("arm.one", data=turning(-1.0, 1.0)))
    with pytest.raises(KernelError, match=r"'a' of 'arm' cannot be at 1\.9 rad; its limits are -1 to 1"):
        moving(shrunk, a=(0.0, 1.9))
