"""Measured joints beside commanded ones: what is, and what motions go on from."""

from __future__ import annotations

import numpy as np
import pinocchio  # pyright: ignore[reportMissingImports] PyPI calls it pin
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.plan import plan_ptp
from virtualrobot_kernel.motion.program import of_plan
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import (
    CreateNodes,
    RemoveNode,
    SetJointPositions,
    SetMeasuredJoints,
    SetToolState,
    StartMotion,
)
from virtualrobot_kernel.world.measured import as_commanded, commanded
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, NodeSpec, RobotData

from tests.unit.world.builders import LIMITS, TICK, Z, after, arm, empty, link, part, shifted, ticked, world_t

OFF = np.array([0.01, -0.02, -0.001])
"""How far a real arm is behind its commands."""


@pytest.fixture
def cell() -> Change:
    return after(empty(), arm(), arm("other"))


def uid(change: Change) -> int:
    return change.structure.node("arm").uid


def move(goal: float, start: float = 0.0, joint: str = "a") -> StartMotion:
    lower, upper, *rates = (np.array([value]) for value in (-2.0, 2.0, 1.0, 4.0, 40.0))
    limits = JointLimits((joint,), lower, upper, rates[0], rates[1], rates[2])
    return StartMotion((("arm", joint),), of_plan(plan_ptp([start], [goal], limits)))


def test_without_readings_both_are_the_same_arrays(cell: Change) -> None:
    now = ticked(after(cell, move(0.5)), 20)
    q, v = commanded(now.structure, now.state)
    assert q is now.state.q
    assert v is now.state.v


def test_motions_command_the_same_as_without_readings_and_what_is_measured_is_where_things_are(cell: Change) -> None:
    ideal = real = after(cell, move(0.5))
    for _ in range(300):
        ideal = ticked(ideal)
        wanted = ideal.state.q[:3]
        real = ticked(after(real, SetMeasuredJoints(uid(real), wanted + OFF, ideal.state.v[:3])))
        assert commanded(real.structure, real.state)[0].tolist() == ideal.state.q.tolist()
        np.testing.assert_array_equal(real.state.q[:3], wanted + OFF)
    assert not real.state.motions
    there = after(cell, SetJointPositions("arm", {"a": 0.51, "b": -0.02, "f": 0.039}))
    np.testing.assert_allclose(world_t(real, "arm.left"), world_t(there, "arm.left"), atol=1e-12)
    np.testing.assert_array_equal(real.state.q[3:], cell.state.q[3:])


def test_a_reading_counts_with_the_tick_in_which_it_came_and_stays(cell: Change) -> None:
    told = after(cell, SetMeasuredJoints(uid(cell), OFF, np.full(3, 0.1)))
    assert told.state.q is cell.state.q
    now = ticked(told)
    assert now.state.q[:3].tolist() == OFF.tolist()
    assert ticked(now, 5).state.v[:3].tolist() == [0.1] * 3
    assert commanded(now.structure, now.state)[0].tolist() == cell.state.q.tolist()


def test_the_next_motion_starts_where_the_last_command_was(cell: Change) -> None:
    now = ticked(after(cell, SetMeasuredJoints(uid(cell), OFF)))
    now = ticked(after(now, move(0.2)), 200)
    assert commanded(now.structure, now.state)[0][0] == pytest.approx(0.2)
    assert now.state.q[0] == OFF[0]
    with pytest.raises(KernelError, match=r"planned from 0\.01"):
        after(now, move(0.5, start=0.01))
    snapshot = Snapshot(now.structure, now.state, world_poses(now.structure, now.state), 1, 0.0, TICK)
    planning = as_commanded(snapshot, world_poses)
    assert planning.state.q[0] == pytest.approx(0.2)
    there = after(cell, SetJointPositions("arm", {"a": 0.2}))
    np.testing.assert_allclose(planning.world_t_node, world_poses(there.structure, there.state), atol=1e-12)


def test_what_ends_leaves_the_robot_where_it_was_measured(cell: Change) -> None:
    now = ticked(after(cell, SetMeasuredJoints(uid(cell), OFF, np.zeros(3))))
    moving = ticked(after(now, move(0.5)))
    with pytest.raises(KernelError) as caught:
        after(moving, SetMeasuredJoints(uid(cell), None))
    assert caught.value.reason is Reason.ROBOT_BUSY
    ended = ticked(after(now, SetMeasuredJoints(uid(cell), None)))
    assert not ended.state.commanded
    assert commanded(ended.structure, ended.state)[0][:3].tolist() == OFF.tolist()
    assert after(ended, SetJointPositions("arm", {"a": 1.0})).state.q[0] == 1.0


@pytest.mark.parametrize(
    ("positions", "velocities", "said"),
    [
        ([0.0, 0.0], None, "'arm' has 3 coordinates, not 2"),
        ([0.0, np.nan, 0.0], None, "'arm' must be finite"),
        ([0.0] * 3, [0.0] * 2, "velocities of 'arm' must be 3 finite numbers"),
        ([0.0] * 3, [0.0, 0.0, np.inf], "velocities of 'arm' must be 3 finite numbers"),
    ],
)
def test_readings_that_are_none_are_refused(
    cell: Change, positions: list[float], velocities: list[float] | None, said: str
) -> None:
    rates = None if velocities is None else np.array(velocities)
    with pytest.raises(KernelError, match=said):
        after(cell, SetMeasuredJoints(uid(cell), np.array(positions), rates))


def test_measured_joints_cannot_be_put_elsewhere(cell: Change) -> None:
    now = ticked(after(cell, SetMeasuredJoints(uid(cell), OFF)))
    for command in (SetJointPositions("arm", {"a": 1.0}), SetToolState("arm_gripper", "open")):
        with pytest.raises(KernelError, match="'arm' are measured") as caught:
            after(now, command)
        assert caught.value.reason is Reason.WRONG_STATE
    assert after(now, SetJointPositions("other", {"a": 1.0})).state.q[3] == 1.0


def test_readings_find_their_joints_again_when_the_world_changes(cell: Change) -> None:
    now = ticked(after(ticked(after(cell, SetMeasuredJoints(uid(cell), OFF))), move(0.2)), 200)
    for changed in (after(now, RemoveNode("other")), after(now, CreateNodes((part("box", shifted()),)))):
        later = ticked(changed)
        assert later.state.q[:3].tolist() == OFF.tolist()
        assert commanded(later.structure, later.state)[0][0] == pytest.approx(0.2)
    gone = after(now, RemoveNode("arm"))
    assert not gone.state.commanded
    with pytest.raises(KernelError, match="no robot has the uid"):
        after(gone, SetMeasuredJoints(uid(now), OFF))


def test_a_floating_base_moves_by_readings_with_what_hangs_on_it() -> None:
    """The base goes on by constant twists in its own frame, integrated by pinocchio; the arm on it is rigid with it."""
    base = link("craft.hull", "craft", Joint("free", JointType.FLOATING))
    mast = link("craft.mast", "craft.hull", Joint("m", JointType.REVOLUTE, Z, LIMITS), shifted(x=0.3, z=0.5))
    now = after(empty(), CreateNodes((NodeSpec("craft", Kind.ROBOT, data=RobotData()), base, mast)))
    now = after(now, CreateNodes((part("load", shifted(x=0.2), "craft.mast"),)))
    model = pinocchio.Model()
    model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "free")
    craft, pose = now.structure.node("craft").uid, pinocchio.neutral(model)
    twist = np.array([0.4, -0.1, 0.2, 0.3, -0.5, 0.9])
    for _ in range(500):
        pose = pinocchio.integrate(model, pose, twist * TICK)
        now = ticked(after(now, SetMeasuredJoints(craft, np.append(pose, 0.25), np.append(twist, 0.0))))
    hull = pinocchio.exp6(twist * TICK * 500).homogeneous
    np.testing.assert_allclose(world_t(now, "craft.hull"), hull, atol=1e-12)
    turn = np.eye(4)
    turn[:2, :2] = [[np.cos(0.25), -np.sin(0.25)], [np.sin(0.25), np.cos(0.25)]]
    np.testing.assert_allclose(world_t(now, "load"), hull @ shifted(x=0.3, z=0.5) @ turn @ shifted(x=0.2), atol=1e-12)
    with pytest.raises(KernelError, match="'free' of 'craft' has the quaternion"):
        after(now, SetMeasuredJoints(craft, np.zeros(8)))
