"""The world never comes to contradict itself: what is saved of it can be loaded, and time always goes on."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.motion.limits import JointLimits as PlanLimits
from virtualrobot_kernel.motion.plan import Plan, plan_ptp
from virtualrobot_kernel.motion.running import Phase
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import SetSpeedFactor, StartMotion, StopMotions
from virtualrobot_kernel.world.tick import advance

from tests.unit.world.builders import after, arm, empty

TICK = 0.004


@pytest.fixture
def cell() -> Change:
    return after(empty(), arm())


def plan(**joints: tuple[float, float]) -> Plan:
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
    return plan_ptp(np.array(start), np.array(goal), limits)


def moving(cell: Change, **joints: tuple[float, float]) -> Change:
    """Return the world with the arm's motion of these joints started."""
    return after(cell, StartMotion(tuple(("arm", name) for name in joints), plan(**joints)))


def test_the_slowest_factors_multiply_to_no_standstill(cell: Change) -> None:
    slow = after(moving(cell, a=(0.0, 1.0)), SetSpeedFactor("", 1e-200), SetSpeedFactor("arm", 1e-200))
    state = slow.state
    for _ in range(200):
        state = advance(state, TICK)
    assert state.motions[0].running.phase is Phase.RUNNING
    assert 0.0 < state.q[0] < 1.0


def test_a_stop_leaves_a_motion_without_length_its_success(cell: Change) -> None:
    gripped = StartMotion((("arm", "f"),), plan(f=(0.04, 0.04)), (("arm_gripper", "closed"),))
    state = advance(after(cell, gripped, StopMotions()).state, TICK)
    (motion,) = state.ended
    assert (motion.running.phase, motion.cancel_reason) == (Phase.SUCCEEDED, "")
    assert list(state.tool_states.values()) == ["closed"]
