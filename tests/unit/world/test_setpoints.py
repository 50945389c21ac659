"""Motions that follow setpoints, as commands; how they move is in tests/unit/motion/test_setpoint_motion.py."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, LimitError, Reason, UnknownNameError
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.plan import plan_ptp
from virtualrobot_kernel.motion.program import of_plan
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode, SetpointMotion
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import (
    CancelMotion,
    Command,
    EndSetpoints,
    PauseMotion,
    ResumeMotion,
    SetSetpoint,
    SetSpeedFactor,
    StartMotion,
    StartSetpointMotion,
    UpdateNode,
)
from virtualrobot_kernel.world.journal import Entry, replay
from virtualrobot_kernel.world.state import Cancellation, EndCause, Motion
from virtualrobot_kernel.world.structure import Actuator, RobotData
from virtualrobot_kernel.world.tick import advance

from tests.unit.world.builders import after, arm, empty

TICK = 0.004
POSITION, VELOCITY = SetpointMode.POSITION, SetpointMode.VELOCITY


@pytest.fixture
def cell() -> Change:
    return after(empty(), arm())


def ticked(change: Change, ticks: int = 1) -> Change:
    state = change.state
    for _ in range(ticks):
        state = advance(change.structure, state, TICK, world_poses)
    return Change(change.structure, state)


def following(change: Change) -> SetpointMotion:
    running = change.state.motions[0].running
    assert isinstance(running, SetpointMotion)
    return running


def last(change: Change) -> Motion:
    return change.state.ended[-1]


def finger(goal: float) -> StartMotion:
    """Return a motion of the gripper of the arm, which is open: at 0.04."""
    limits = JointLimits(("f",), *(np.array([value]) for value in (0.0, 0.04, 0.2, 1.0, 10.0)))
    return StartMotion((("arm", "f"),), of_plan(plan_ptp([0.04], [goal], limits)))


def test_joints_follow_while_the_gripper_moves(cell: Change) -> None:
    change = after(cell, StartSetpointMotion("arm", ("b", "a"), VELOCITY, 0.2), finger(0.0))
    assert change.created == ("motion-1", "motion-2")
    for _ in range(200):
        change = ticked(after(change, SetSetpoint("motion-1", (0.5, -0.25))))
    a, b, f = change.state.q[:3]
    assert change.state.v[:2].tolist() == [-0.25, 0.5]
    assert a == pytest.approx(-b / 2.0, rel=0.3)
    assert (f, change.state.ended[0].id) == (0.0, "motion-2")


def test_a_stream_begins_where_the_joints_are_and_stays_there(cell: Change) -> None:
    change = ticked(after(cell, StartSetpointMotion("arm", ("a", "b"), POSITION, 0.2)), 20)
    assert following(change).phase is Phase.RUNNING
    assert np.array_equal(change.state.q, cell.state.q)


@pytest.mark.parametrize(
    ("command", "error", "reason"),
    [
        (StartSetpointMotion("nobody", ("a",), POSITION, 0.2), UnknownNameError, Reason.UNKNOWN_NAME),
        (StartSetpointMotion("arm", ("a", "x"), POSITION, 0.2), UnknownNameError, Reason.UNKNOWN_NAME),
        (StartSetpointMotion("arm", ("a", "a"), POSITION, 0.2), KernelError, Reason.INVALID_ARGUMENT),
        (StartSetpointMotion("arm", (), POSITION, 0.2), KernelError, Reason.INVALID_ARGUMENT),
        (StartSetpointMotion("arm", ("a",), POSITION, -1.0), KernelError, Reason.INVALID_ARGUMENT),
        (SetSetpoint("motion-9", (0.0,)), UnknownNameError, Reason.UNKNOWN_NAME),
        (EndSetpoints("motion-9"), UnknownNameError, Reason.UNKNOWN_NAME),
    ],
)
def test_impossible_streams_are_refused(
    cell: Change, command: Command, error: type[KernelError], reason: Reason
) -> None:
    with pytest.raises(error) as refused:
        after(cell, command)
    assert refused.value.reason is reason


def test_joints_that_move_are_busy_for_streams_and_those_of_streams_for_others(cell: Change) -> None:
    change = after(cell, finger(0.01))
    with pytest.raises(KernelError, match="moves in 'motion-1'") as refused:
        after(change, StartSetpointMotion("arm", ("a", "f"), POSITION, 0.2))
    assert refused.value.reason is Reason.ROBOT_BUSY
    with pytest.raises(KernelError, match="follows no setpoints"):
        after(change, SetSetpoint("motion-1", (0.0,)))
    change = after(cell, StartSetpointMotion("arm", ("f",), POSITION, 0.2))
    with pytest.raises(KernelError, match="moves in 'motion-1'"):
        after(change, finger(0.01))


def test_a_refused_setpoint_changes_nothing(cell: Change) -> None:
    change = ticked(after(cell, StartSetpointMotion("arm", ("a", "b"), POSITION, 0.2)), 3)
    with pytest.raises(LimitError, match="joint 'b' would go from 0 to 1"):
        after(change, SetSetpoint("motion-1", (0.0, 1.0)))
    with pytest.raises(KernelError, match="it must be finite"):
        after(change, SetSetpoint("motion-1", (0.0, float("nan"))))
    assert np.array_equal(ticked(change, 10).state.q, cell.state.q)


def test_a_silent_stream_is_cancelled_with_its_cause(cell: Change) -> None:
    change = ticked(after(cell, StartSetpointMotion("arm", ("a",), POSITION, 0.1)), 26)
    cancellation = last(change).cancellation
    assert cancellation is not None
    assert (cancellation.cause, cancellation.reason) == (EndCause.SETPOINT_TIMEOUT, "no setpoint came for 0.1 s")
    with pytest.raises(KernelError, match="has ended") as refused:
        after(change, SetSetpoint("motion-1", (0.0,)))
    assert refused.value.reason is Reason.WRONG_STATE


def test_a_stream_that_is_ended_succeeds(cell: Change) -> None:
    change = after(cell, StartSetpointMotion("arm", ("a",), POSITION, 0.2), SetSetpoint("motion-1", (0.03,)))
    change = ticked(after(change, EndSetpoints("motion-1")), 100)
    assert (last(change).running.phase, last(change).cancellation) == (Phase.SUCCEEDED, None)
    assert change.state.q[0] == 0.03


def test_a_stream_goes_on_when_its_robot_is_renamed(cell: Change) -> None:
    change = after(cell, StartSetpointMotion("arm", ("a",), VELOCITY, 0.2), UpdateNode("arm", new_name="other"))
    change = ticked(after(change, SetSetpoint("motion-1", (0.5,))), 10)
    assert change.state.v[0] > 0.0


def test_actuators_keep_their_limits(cell: Change) -> None:
    """A gear of joint `b` alone, and rods that move `a` and `b` together."""
    gear, rods = (
        Actuator("gear", (("b", -100.0),), 5.0, -45.0, 55.0),
        Actuator("rods", (("a", 1.0), ("b", 1.0)), upper=0.8),
    )
    robot = cell.structure.node("arm")
    assert isinstance(robot.data, RobotData)
    geared = after(cell, UpdateNode("arm", data=replace(robot.data, actuators=(gear, rods))))
    with pytest.raises(KernelError, match="'rods' of 'arm' moves 'a' and 'b' together") as refused:
        after(geared, StartSetpointMotion("arm", ("a",), VELOCITY, 0.2))
    assert refused.value.metadata["actuator"] == "rods"
    change = after(geared, StartSetpointMotion("arm", ("a", "b"), VELOCITY, 1e9), SetSetpoint("motion-1", (-0.1, 0.9)))
    change = ticked(change, 1000)
    assert change.state.q[1] == pytest.approx(0.5, abs=2e-3), "the gear's -45 is at 0.5 rad"
    assert change.state.q[1] <= 0.5
    change = ticked(after(change, SetSetpoint("motion-1", (0.9, 0.0))), 1000)
    assert change.state.q[:2].sum() == pytest.approx(0.8, abs=2e-3)
    assert change.state.q[:2].sum() <= 0.8
    follow = after(geared, StartSetpointMotion("arm", ("a", "b"), POSITION, 1e9))
    change = ticked(after(follow, SetSetpoint("motion-1", (0.04, 0.04))), 500)
    for _ in range(80):
        place = change.state.q[:2] + 0.01
        if place.sum() > 0.8 or place[1] > 0.5:
            break
        change = ticked(after(change, SetSetpoint("motion-1", tuple(place.tolist()))), 20)
    with pytest.raises(LimitError, match="the actuator 'rods' would be at 0\\.8"):
        after(change, SetSetpoint("motion-1", (0.41, 0.41)))


def test_a_run_with_setpoints_is_replayed_bit_for_bit(cell: Change, rng: np.random.Generator) -> None:
    entries: list[Entry] = []
    change = cell

    def do(*commands: Command) -> None:
        nonlocal change
        entries.append(Entry(change.state.tick, "", commands))
        change = after(change, *commands)

    do(StartSetpointMotion("arm", ("a", "b"), POSITION, 0.2), StartSetpointMotion("arm", ("f",), VELOCITY, 1.0))
    place = np.zeros(2)
    steering = PauseMotion("motion-1"), ResumeMotion("motion-1"), SetSpeedFactor("arm", 0.5)
    for _ in range(150):
        for _ in range(int(rng.integers(0, 3))):
            place = np.clip(place + rng.uniform(-0.002, 0.002, 2), -2.0, 2.0)
            do(SetSetpoint("motion-1", tuple(place.tolist())))
        if rng.random() < 0.1:
            do(SetSetpoint("motion-2", (rng.uniform(-0.2, 0.2),)))
        if rng.random() < 0.05:
            do(steering[rng.integers(3)])
        change = ticked(change, int(rng.integers(1, 3)))
    do(CancelMotion("motion-2"), EndSetpoints("motion-1"))
    change = ticked(change, 300)
    again = replay(cell.structure, cell.state, entries, change.state.tick, TICK, world_poses)
    assert again.state.q.tobytes() == change.state.q.tobytes()
    assert again.state.v.tobytes() == change.state.v.tobytes()
    assert [motion.running.phase for motion in again.state.ended] == [
        motion.running.phase for motion in change.state.ended
    ]


def test_a_motion_that_fails_in_the_tick_ends_alone(
    cell: Change, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    both = after(
        cell, StartSetpointMotion("arm", ("a",), VELOCITY, 1.0), StartSetpointMotion("arm", ("b",), VELOCITY, 1.0)
    )
    go_on = SetpointMotion.advance

    def fail(self: SetpointMotion, *arguments: Any) -> SetpointMotion:  # noqa: ANN401 those of the method
        if self.limits.names == ("a",):
            raise ZeroDivisionError("no way")
        return go_on(self, *arguments)

    monkeypatch.setattr(SetpointMotion, "advance", fail)
    change = ticked(both, 2)
    assert [motion.id for motion in change.state.motions] == ["motion-2"]
    assert last(change).end_tick == both.state.tick + 1
    assert last(change).cancellation == Cancellation(EndCause.FAILED, "it failed inside the kernel: ZeroDivisionError")
    assert "the motion 'motion-1' failed inside the kernel" in caplog.text


def test_a_motion_that_leads_nowhere_ends_where_it_is(
    cell: Change, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    going = after(cell, StartSetpointMotion("arm", ("a",), VELOCITY, 1.0))
    nowhere = np.array([np.nan])
    monkeypatch.setattr(SetpointMotion, "sample", lambda self: (nowhere, nowhere, nowhere))
    change = ticked(going, 2)
    assert not change.state.motions
    assert last(change).cancellation == Cancellation(EndCause.FAILED, "it failed inside the kernel: no finite numbers")
    assert change.state.q.tobytes() == going.state.q.tobytes()
    assert not change.state.v.any()
    assert "leads to [nan]" in caplog.text
