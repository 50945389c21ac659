"""What changes between planning and starting: a plan that would come out otherwise now is never started."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.planning.moves import CartesianJog, Linear, Move, PointToPoint, ToolStateMove
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import (
    AttachNode,
    Command,
    CreateNodes,
    CreateSignal,
    RemoveNode,
    SelectTool,
    SetJointPositions,
    SetSpeedFactor,
    StartMotion,
    UpdateNode,
)
from virtualrobot_kernel.world.state import Signal
from virtualrobot_kernel.world.structure import Actuator, Kind, LinkData, NodeSpec, RobotData, ToolData
from virtualrobot_sdk.poses import inverse

from tests.tiers import Draws
from tests.unit.planning.cell import cell, chain, pictured, tcp
from tests.unit.planning.starts import start_of
from tests.unit.world.builders import after, shifted, ticked, world_t


def line(change: Change, reference: str) -> Linear:
    """Return a line of 5 cm up, given in the frame of a node."""
    goal = inverse(world_t(change, reference)) @ shifted(z=0.05) @ tcp(change)
    return Linear("arm", PoseGoal(goal, reference))


def moved(rng: np.random.Generator) -> np.ndarray:
    return shifted(*rng.uniform(0.001, 0.01, 3))


def limits(change: Change, name: str, **limits: float) -> UpdateNode:
    """Return what gives a link's joint other limits."""
    data = change.structure.node(name).data
    assert isinstance(data, LinkData)
    joint = replace(data.joint, limits=replace(data.joint.limits, **limits))
    return UpdateNode(name, data=replace(data, joint=joint))


def tool_point(change: Change, point: np.ndarray) -> UpdateNode:
    data = change.structure.node("hand").data
    assert isinstance(data, ToolData)
    return UpdateNode("hand", data=replace(data, tool_center_points={**data.tool_center_points, "tip": point}))


def posture(change: Change, name: str) -> UpdateNode:
    data = change.structure.node("arm").data
    assert isinstance(data, RobotData)
    there = {**data.postures["ready"], "lbr_iiwa_joint_1": 0.4}
    return UpdateNode("arm", data=replace(data, postures={**data.postures, name: there}))


Changes = Callable[[Change, np.random.Generator], list[Command]]

HARMLESS: dict[str, Changes] = {
    "signal": lambda c, rng: [CreateSignal(Signal("ready", True))],
    "speed": lambda c, rng: [SetSpeedFactor("arm", 0.5)],
    "another robot's joints": lambda c, rng: [SetJointPositions("belt", {"slide": rng.uniform(-1.0, 1.0)})],
    "another part": lambda c, rng: [UpdateNode("box", parent_t_node=moved(rng))],
    "a part more": lambda c, rng: [CreateNodes((NodeSpec("more", Kind.PART, "hand", moved(rng)),))],
    "a part gone": lambda c, rng: [RemoveNode("box")],
    "a robot gone": lambda c, rng: [RemoveNode("belt")],
    "names": lambda c, rng: [UpdateNode("bench", new_name="table"), UpdateNode("hand", new_name="gripper")],
    "hidden": lambda c, rng: [UpdateNode("arm.lbr_iiwa_link_3", hidden=True)],
    "a posture more": lambda c, rng: [posture(c, "other")],
}
ARM: dict[str, tuple[str, Changes]] = {
    "base": ("arm", lambda c, rng: [UpdateNode("arm", parent_t_node=moved(rng))]),
    "stand": ("stand", lambda c, rng: [UpdateNode("stand", parent_t_node=moved(rng))]),
    "other parent": ("arm", lambda c, rng: [AttachNode("arm", "bench", moved(rng))]),
    "link": ("arm.lbr_iiwa_link_3", lambda c, rng: [UpdateNode("arm.lbr_iiwa_link_3", parent_t_node=moved(rng))]),
    "limits": ("arm.lbr_iiwa_link_2", lambda c, rng: [limits(c, "arm.lbr_iiwa_link_2", velocity=0.1)]),
    "adapter": ("adapter", lambda c, rng: [UpdateNode("adapter", parent_t_node=moved(rng))]),
    "tool": ("arm", lambda c, rng: [SelectTool("arm")]),
    "tool centre point": ("arm", lambda c, rng: [SelectTool("arm", "hand", "side")]),
    "the point itself": ("arm", lambda c, rng: [tool_point(c, moved(rng))]),
}
REFERENCE: dict[str, tuple[str, Changes]] = {
    "fixture": ("fixture", lambda c, rng: [UpdateNode("fixture", parent_t_node=moved(rng))]),
    "bench": ("bench", lambda c, rng: [UpdateNode("bench", parent_t_node=moved(rng))]),
    "gone": ("fixture", lambda c, rng: [RemoveNode("fixture")]),
}


def refused(change: Change, command: StartMotion, *changes: Command) -> KernelError:
    with pytest.raises(KernelError) as caught:
        after(change, *changes, command)
    return caught.value


@pytest.mark.parametrize("what", HARMLESS)
def test_harmless_changes_let_a_motion_start(what: str, rng: np.random.Generator) -> None:
    change = cell()
    command = start_of(pictured(change), [line(change, "fixture")], chain)
    later = after(change, *HARMLESS[what](change, rng))
    assert after(later, command).state.motions


@pytest.mark.parametrize("what", [*ARM, *REFERENCE])
def test_a_line_is_refused_when_what_it_assumes_has_changed(what: str, rng: np.random.Generator) -> None:
    change = cell()
    command = start_of(pictured(change), [line(change, "fixture")], chain)
    node, changes = {**ARM, **REFERENCE}[what]
    error = refused(change, command, *changes(change, rng))
    assert error.reason is Reason.PLAN_OUTDATED
    assert error.metadata["node"] == node
    assert repr(node) in str(error) and "plan again" in str(error)


def test_joints_mind_their_limits_alone(rng: np.random.Generator) -> None:
    change = cell()
    command = start_of(pictured(change), [PointToPoint("arm", {"lbr_iiwa_joint_2": 0.7})], chain)
    for what, (_, changes) in {**ARM, **REFERENCE}.items():
        if what == "limits":
            assert refused(change, command, *changes(change, rng)).metadata["node"] == "arm.lbr_iiwa_link_2"
        else:
            assert after(change, *changes(change, rng), command).state.motions, what


def test_a_posture_and_a_tool_s_state_by_name(rng: np.random.Generator) -> None:
    change = after(cell(), SetJointPositions("arm", {"lbr_iiwa_joint_1": 0.0}))
    command = start_of(pictured(change), [PointToPoint("arm", "ready")], chain)
    assert after(change, posture(change, "other"), command).state.motions
    assert refused(change, command, posture(change, "ready")).metadata["aspect"] == "POSTURE"
    command = start_of(pictured(change), [ToolStateMove("arm", "hand", "on")], chain)
    data = change.structure.node("hand").data
    assert isinstance(data, ToolData)
    other = UpdateNode("hand", data=replace(data, states={**data.states, "on": {"lbr_iiwa_joint_7": 0.1}}))
    error = refused(change, command, other)
    assert (error.metadata["node"], error.metadata["aspect"]) == ("hand", "STATE")


def test_a_jog_in_the_robot_s_own_frame_minds_the_arm_and_not_where_it_stands(rng: np.random.Generator) -> None:
    change = cell()
    jog = CartesianJog("arm", (0.0, 0.0, 1.0), distance=0.05)
    command = start_of(pictured(change), [jog], chain)
    stands = ("base", "stand", "other parent")
    for what, (node, changes) in ARM.items():
        if what in stands:
            assert after(change, *changes(change, rng), command).state.motions, what
        else:
            assert refused(change, command, *changes(change, rng)).metadata["node"] == node


def test_a_robot_s_actuators_count(rng: np.random.Generator) -> None:
    change = cell()
    command = start_of(pictured(change), [PointToPoint("arm", {"lbr_iiwa_joint_2": 0.7})], chain)
    data = change.structure.node("arm").data
    assert isinstance(data, RobotData)
    motor = Actuator("motor", (("lbr_iiwa_joint_2", 100.0),), lower=-500.0, upper=500.0)
    error = refused(change, command, UpdateNode("arm", data=replace(data, actuators=(motor,))))
    assert (error.reason, error.metadata["aspect"]) == (Reason.PLAN_OUTDATED, "ACTUATORS")


def test_a_frame_on_a_joint_counts_where_the_joint_stands() -> None:
    """A tray that stood still when the line was planned; one that was already on its way is nobody's surprise."""
    change = cell()
    command = start_of(pictured(change), [line(change, "belt.tray")], chain)
    assert after(change, command).state.motions
    jump = SetJointPositions("belt", {"slide": 0.01})
    error = refused(change, command, jump)
    assert (error.metadata["node"], error.metadata["aspect"]) == ("belt.tray", "POSITION")

    going = after(change, start_of(pictured(change), [PointToPoint("belt", {"slide": 1.0})], chain))
    command = start_of(pictured(going), [line(going, "belt.tray")], chain)
    assert len(after(ticked(going), command).state.motions) == 2


def test_what_carries_arm_and_goal_may_be_moved_with_both() -> None:
    """The bench hangs on the stand too: only where they hang apart counts."""
    change = after(cell(), AttachNode("bench", "stand"))
    command = start_of(pictured(change), [line(change, "fixture")], chain)
    assert after(change, UpdateNode("stand", parent_t_node=shifted(x=1.0)), command).state.motions


def test_random_changes_never_start_a_plan_that_would_be_another_one(rng: np.random.Generator, draws: Draws) -> None:
    """What the same wish gives in the changed world is the judge: a plan that starts is that one, to the last bit."""
    change = cell()
    pool = [*HARMLESS.values(), *HARMLESS.values(), *(one for _, one in (ARM | REFERENCE).values())]
    started = 0
    for _ in range(draws(40)):
        reference = str(rng.choice(["world", "fixture", "belt.tray", "box"]))
        moves: list[Move] = [line(change, reference)]
        command = start_of(pictured(change), moves, chain)
        try:
            later = after(change, *pool[rng.integers(len(pool))](change, rng))
            later = after(later, *pool[rng.integers(len(pool))](later, rng))
        except KernelError:
            continue  # the second one found nothing to change
        try:
            after(later, command)
        except KernelError as error:
            assert error.reason in (Reason.PLAN_OUTDATED, Reason.UNKNOWN_NAME)
            continue
        started += 1
        if reference in later.structure.uid_by_name:
            again = start_of(pictured(later), moves, chain)
            np.testing.assert_array_equal(again.program.highest, command.program.highest)
            np.testing.assert_array_equal(again.program.lowest, command.program.lowest)
            assert again.program.duration == command.program.duration
    assert started > 0
