"""Actuators as combinations of joints: positions, limits, and the way back; ratios and joints are random."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, LimitError, Reason, UnknownNameError
from virtualrobot_kernel.planning.moves import ActuatorGoal, PointToPoint
from virtualrobot_kernel.world.actuators import actuator_positions, joint_positions
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import (
    CreateNodes,
    RemoveNode,
    SetJointPositions,
    SetToolState,
    StartMotion,
    UpdateNode,
)
from virtualrobot_kernel.world.structure import Actuator, Node, NodeSpec, RobotData

from tests.unit.planning.starts import start_of
from tests.unit.planning.test_moves import nobody, pictured
from tests.unit.world.builders import after, arm, empty, ticked


def geared(*actuators: Actuator) -> Change:
    """Return a world with the arm of two joints, `a` and `b`, driven by these actuators."""
    robot, *rest = arm().specs
    assert isinstance(robot, NodeSpec) and isinstance(robot.data, RobotData)
    return after(empty(), CreateNodes((replace(robot, data=replace(robot.data, actuators=actuators)), *rest)))


def node(world: Change) -> Node:
    return world.structure.node("arm")


@pytest.fixture
def ratios(rng: np.random.Generator) -> np.ndarray:
    """Two actuators that both move both joints, far from parallel."""
    while True:
        drawn = rng.uniform(-100.0, 100.0, (2, 2))
        if np.linalg.cond(drawn) < 20.0:
            return drawn


def coupled(ratios: np.ndarray, offset: np.ndarray, **limits: float) -> tuple[Actuator, Actuator]:
    one, two = (
        Actuator(name, (("a", float(row[0])), ("b", float(row[1]))), float(shift))
        for name, row, shift in zip(("one", "two"), ratios, offset, strict=True)
    )
    return one, replace(two, **limits)


def test_positions_are_linear_in_the_joints_and_lead_back(rng: np.random.Generator, ratios: np.ndarray) -> None:
    offset, joints = rng.uniform(-10.0, 10.0, 2), rng.uniform(-1.5, 1.5, 2)
    world = geared(*coupled(ratios, offset))
    world = after(world, SetJointPositions("arm", {"a": joints[0], "b": joints[1]}))
    found = actuator_positions(world.structure, node(world), world.state.q)
    np.testing.assert_allclose(found, ratios @ joints + offset, rtol=1e-12, atol=1e-12)
    back = joint_positions(node(world), dict(zip(("one", "two"), found, strict=True)))
    np.testing.assert_allclose([back["a"], back["b"]], joints, atol=1e-11)


def test_a_move_to_actuator_positions_ends_there(rng: np.random.Generator, ratios: np.ndarray) -> None:
    joints = rng.uniform(-1.5, 1.5, 2)
    wanted = ratios @ joints
    world = geared(*coupled(ratios, np.zeros(2)))
    goal = ActuatorGoal({"two": float(wanted[1]), "one": float(wanted[0])})
    going = after(world, start_of(pictured(world), [PointToPoint("arm", goal)], nobody))
    while going.state.motions:
        going = ticked(going)
    state = going.state
    np.testing.assert_allclose(actuator_positions(world.structure, node(world), state.q), wanted, atol=1e-9)


def test_what_leads_an_actuator_beyond_its_limits_is_refused_with_the_place() -> None:
    """The absolute angle a + b may be at most 1; on the way from (0, 0) to (1.2, -0.1) it is 1 after 1 / 1.1."""
    rods = Actuator("rods", (("a", 1.0), ("b", 1.0)), 0.0, -0.5, 1.0)
    world = geared(rods)
    within = PointToPoint("arm", {"a": 1.2, "b": -0.2})
    start_of(pictured(world), [within], nobody)
    with pytest.raises(LimitError, match=r"'rods' of 'arm', which moves 'a' and 'b', would be at 1.1 after 90.9% of"):
        start_of(pictured(world), [replace(within, goal={"a": 1.2, "b": -0.1})], nobody)
    with pytest.raises(LimitError, match=r"would be at 1.2; its limits are -0.5 to 1"):
        after(world, SetJointPositions("arm", {"a": 1.2}))
    bent = after(world, SetJointPositions("arm", {"a": 0.8}))
    with pytest.raises(LimitError, match=r"would be at 1.1 after"):  # a joint that stands still counts, too
        start_of(pictured(bent), [PointToPoint("arm", {"b": 0.3})], nobody)
    data = node(bent).data
    assert isinstance(data, RobotData)
    with pytest.raises(LimitError, match=r"would be at 0.8; its limits are -0.5 to 0.7"):
        after(bent, UpdateNode("arm", data=replace(data, actuators=(replace(rods, upper=0.7),))))


def test_actuator_goals_that_say_too_little_too_much_or_nothing_known(ratios: np.ndarray) -> None:
    robot = node(geared(*coupled(ratios, np.zeros(2)), Actuator("third", (("a", 1.0),))))
    with pytest.raises(KernelError, match="do not say where all of a, b are; give one, two, third"):
        joint_positions(robot, {"one": 1.0})
    with pytest.raises(KernelError, match="no joints put the actuators one, two, third of 'arm' there together"):
        joint_positions(robot, {"one": 0.0, "two": 0.0, "third": 1.0})
    with pytest.raises(UnknownNameError, match="'four'"):
        joint_positions(robot, {"four": 1.0})
    with pytest.raises(KernelError, match="names no actuator"):
        joint_positions(robot, {})


def test_a_link_whose_joint_an_actuator_moves_is_not_removed() -> None:
    world = geared(Actuator("one", (("f", 1.0),)))
    world = after(world, RemoveNode("arm.right"), RemoveNode("arm_gripper"))
    with pytest.raises(UnknownNameError, match=r"the actuator 'one' of 'arm': .*'f'"):
        after(world, RemoveNode("arm.left"))


def test_an_actuator_of_a_joint_that_is_not_there_or_mimics_is_refused() -> None:
    with pytest.raises(UnknownNameError, match=r"the actuator 'one' of 'arm': .*'elbow'"):
        geared(Actuator("one", (("elbow", 1.0),)))
    with pytest.raises(UnknownNameError, match=r"the actuator 'one' of 'arm': .*'g'"):
        geared(Actuator("one", (("g", 1.0),)))


def test_a_renamed_joint_is_renamed_in_the_actuators() -> None:
    world = geared(Actuator("one", (("a", 2.0), ("b", 3.0))))
    link = world.structure.node("arm.one")
    joint = replace(link.data.joint, name="shoulder")  # pyright: ignore[reportAttributeAccessIssue, reportOptionalMemberAccess] a link
    world = after(world, UpdateNode("arm.one", data=replace(link.data, joint=joint)))  # pyright: ignore[reportArgumentType, reportCallIssue]
    assert node(world).data.actuators == (Actuator("one", (("shoulder", 2.0), ("b", 3.0))),)  # pyright: ignore


RODS = Actuator("rods", (("a", 1.0), ("b", 1.0)), 0.0, -0.5, 1.0)


def test_joints_of_one_actuator_do_not_move_in_two_motions_at_once() -> None:
    """Each of the two would end within the limits of -0.5 to 1 if the other joint stood still; together at 1.2."""

    def plans(world: Change) -> list[StartMotion]:
        return [start_of(pictured(world), [PointToPoint("arm", {name: 0.6})], nobody) for name in ("a", "b")]

    world = geared(RODS)
    one, two = plans(world)
    moving = after(world, one)
    with pytest.raises(KernelError, match="'arm' moves in 'motion-1'") as refused:
        after(moving, two)
    assert refused.value.reason is Reason.ROBOT_BUSY
    with pytest.raises(KernelError, match=r"'arm.one' is not what the motion was planned with: where its joint stands"):
        after(ticked(moving, 1000), two)
    free = geared(replace(RODS, lower=-np.inf, upper=np.inf))
    assert len(after(free, *plans(free)).state.motions) == 2


def test_moves_of_one_step_keep_the_limits_of_an_actuator_together() -> None:
    world = geared(RODS)
    moves = [PointToPoint("arm", {"a": 0.6}), PointToPoint("arm", {"b": 0.4})]
    start_of(pictured(world), moves, nobody)
    with pytest.raises(LimitError, match=r"'rods' of 'arm'.*be at 1.2 somewhere on the ways of its joints"):
        start_of(pictured(world), [moves[0], PointToPoint("arm", {"b": 0.6})], nobody)
    with pytest.raises(LimitError, match=r"be at -0.6 somewhere"):
        start_of(pictured(world), [PointToPoint("arm", {"a": -0.3}), PointToPoint("arm", {"b": -0.3})], nobody)


def test_tool_states_keep_the_limits_of_actuators() -> None:
    """The gripper starts open, at 0.04 m."""
    with pytest.raises(LimitError, match=r"'clamp' of 'arm'.*would be at 40; its limits are -1 to 30"):
        geared(Actuator("clamp", (("f", 1000.0),), 0.0, -1.0, 30.0))
    world = geared(Actuator("clamp", (("f", 1000.0),), 0.0, 10.0, 40.0))
    with pytest.raises(LimitError, match=r"'clamp' of 'arm'.*would be at 0; its limits are 10 to 40"):
        after(world, SetToolState("arm_gripper", "closed"))
    assert after(world, SetToolState("arm_gripper", "open")).state.q is not world.state.q
