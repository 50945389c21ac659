"""Time laws chosen per move: what each keeps in every tick, and what has no law to choose."""

from __future__ import annotations

import math

import numpy as np
import pytest
import virtualrobot
from virtualrobot.v1 import motion_pb2

from tests.api.asking import IIWA, joints, load, refusal, start
from tests.api.moving import READY, TICK
from tests.api.reading import array, state, step
from tests.api.test_motion_laws import limits
from tests.api.test_robot import drawn, put
from tests.kernels import KernelProcess, Stubs

OPTIMAL = motion_pb2.TIME_LAW_TIME_OPTIMAL


def in_law(move: motion_pb2.Move, law: motion_pb2.TimeLaw) -> motion_pb2.Move:
    chosen = motion_pb2.Move()
    chosen.CopyFrom(move)
    chosen.time_law = law
    return chosen


def run(stubs: Stubs, id: str) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and velocities (n, 7) after each tick until the motion has ended."""
    rows = []
    while True:
        answer = step(stubs)
        rows.append((list(answer.robots[0].positions), list(answer.robots[0].velocities)))
        if not any(one.id == id and one.phase == motion_pb2.MOTION_PHASE_RUNNING for one in answer.motions):
            positions, velocities = zip(*rows, strict=True)
            return np.array(positions), np.array(velocities)


def test_a_point_to_point_move_takes_the_bang_bang_time(stepped: Stubs, rng: np.random.Generator) -> None:
    """The time is the trapezoid's: Biagiotti, Melchiorri 2008, section 3.2."""
    load(stepped, IIWA, "arm")
    put(stepped, "arm", drawn(stepped, "arm", rng))
    first, goal, bound = np.array(state(stepped, "arm").positions), drawn(stepped, "arm", rng), limits(stepped)
    ask = start(stepped, in_law(joints("arm", **goal), OPTIMAL))
    travel = np.abs(np.array(list(goal.values())) - first)
    velocity, acceleration = (bound["velocity"] / travel).min(), (bound["acceleration"] / travel).min()
    best = 1.0 / velocity + velocity / acceleration if velocity**2 < acceleration else 2.0 / math.sqrt(acceleration)
    assert ask.planned_duration_seconds == pytest.approx(best, rel=1e-9)
    positions, velocities = run(stepped, ask.id)
    assert np.all(np.abs(velocities) <= bound["velocity"] * (1 + 1e-9))
    changes = np.diff(np.vstack([np.zeros(7), velocities]), axis=0) / TICK
    assert np.all(np.abs(changes) <= bound["acceleration"] * (1 + 1e-6))
    np.testing.assert_array_equal(positions[-1], list(goal.values()))


def test_what_has_no_law_to_choose_is_refused(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    now = np.array(state(stepped, "arm").positions)
    path = motion_pb2.JointTrajectory(
        joint_names=list(READY), times=array(np.array([0.0, 1.0])), positions=array(np.stack([now, now]))
    )
    timed = motion_pb2.Move(robot="arm", joint_trajectory=path)
    told = refusal(lambda: start(stepped, in_law(timed, OPTIMAL)))
    assert "moves[0].joint_trajectory has its own times; give no time_law" in told.message
    jog = motion_pb2.Move(robot="arm", joint_jog=motion_pb2.JointJog(joint="lbr_iiwa_joint_1", velocity=0.1))
    told = refusal(lambda: start(stepped, in_law(jog, OPTIMAL)))
    assert "a jog is jerk-limited" in told.message
    start(stepped, in_law(jog, motion_pb2.TIME_LAW_JERK_LIMITED))
    for move, kind in ((timed, "joint_trajectory"), (jog, "joint_jog")):
        gentle = motion_pb2.Move()
        gentle.CopyFrom(move)
        gentle.jerk_factor = 0.5
        told = refusal(lambda gentle=gentle: start(stepped, gentle))
        assert f"jerk_factor is for point_to_point, linear, circular, spline; a {kind} takes none" in told.message
    gentle = motion_pb2.Move()
    gentle.CopyFrom(joints("arm", **READY))
    gentle.acceleration_factor = 1.5
    told = refusal(lambda: start(stepped, gentle))
    assert "moves[0].acceleration_factor must be above 0 and at most 1, not 1.5" in told.message
    strange = motion_pb2.Move(robot="arm")
    strange.CopyFrom(joints("arm", **READY))
    strange.time_law = 7  # pyright: ignore[reportAttributeAccessIssue]
    told = refusal(lambda: start(stepped, strange))
    assert "time_law is 7" in told.message


def test_the_client_chooses_a_law_by_name(stepped_kernel: KernelProcess, stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    put(stepped, "arm", READY)
    with virtualrobot.connect(stepped_kernel.address, stepped_kernel.token) as client:
        arm = client.robot("arm")
        up = arm.tcp @ virtualrobot.pose(z=-0.1)
        asked = [
            arm.ptp({"lbr_iiwa_joint_1": 1.0}, time_law="time_optimal"),
            arm.linear(up, time_law="time_optimal"),
            arm.circular(center=up[:3, 3], axis=[1, 0, 0], angle=1.0, time_law="time_optimal"),
        ]
        assert {move._message.time_law for move in asked} == {OPTIMAL}
        durations = []
        for law in ("jerk_limited", "time_optimal"):
            motion = arm.move_linear(up, time_law=law, wait=False)
            durations.append(motion.planned_duration)
            motion.cancel()
            step(stepped, 500)
            put(stepped, "arm", READY)
        assert durations[1] < durations[0]
        with pytest.raises(
            virtualrobot.InvalidArgumentError, match="time_law is one of 'jerk_limited', 'time_optimal'"
        ):
            arm.move_joints({"lbr_iiwa_joint_1": 1.0}, time_law="fast")
