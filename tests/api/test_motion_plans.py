"""PlanMotion and CheckMotion over TCP: what the world then does tick by tick, what is an answer and what an error."""

from __future__ import annotations

import time

import grpc
import numpy as np
import pytest
from virtualrobot._wire.signal_values import condition
from virtualrobot.v1 import motion_pb2, scene_pb2, signal_pb2

from tests.api.asking import IIWA, PANDA, apply, joints, load, refusal, start
from tests.api.moving import READY, TICK, linear, to_pose, trajectory
from tests.api.reading import matrices, matrix, state, step, values
from tests.kernels import Stubs

Wish = motion_pb2.Move | motion_pb2.ProgramStep


def motion_of(*wishes: Wish) -> motion_pb2.MotionSpec:
    moves = [wish for wish in wishes if isinstance(wish, motion_pb2.Move)]
    steps = [wish for wish in wishes if isinstance(wish, motion_pb2.ProgramStep)]
    return motion_pb2.MotionSpec(moves=moves, steps=steps)


def started(stubs: Stubs, *wishes: Wish) -> motion_pb2.Motion:
    leave = motion_pb2.DISCONNECT_POLICY_CONTINUE
    return stubs.motion.StartMotion(motion_pb2.StartMotionRequest(spec=motion_of(*wishes), on_disconnect=leave)).motion


def plan(stubs: Stubs, *wishes: Wish, seconds: float = 0.0) -> motion_pb2.PlanMotionResponse:
    return stubs.motion.PlanMotion(motion_pb2.PlanMotionRequest(spec=motion_of(*wishes), sample_seconds=seconds))


def check(stubs: Stubs, *wishes: Wish, margin: float = 0.0) -> motion_pb2.CheckMotionResponse:
    return stubs.motion.CheckMotion(motion_pb2.CheckMotionRequest(spec=motion_of(*wishes), min_singular_value=margin))


def ready(stubs: Stubs, name: str = "arm") -> np.ndarray:
    """Load an iiwa at READY; return where its flange is."""
    load(stubs, IIWA, name)
    jump = scene_pb2.SetJointPositions(robot=name, joint_positions=READY)
    apply(stubs, scene_pb2.Command(set_joint_positions=jump))
    return matrix(state(stubs, name).world_t_tcp)


def shifted(pose: np.ndarray, *by: float) -> np.ndarray:
    result = pose.copy()
    result[:3, 3] += by
    return result


def test_the_world_does_what_was_planned(stepped: Stubs) -> None:
    """Two arms, one on a line: each tick's joints and tool centre points, and nothing moved while it was planned."""
    here = ready(stepped)
    load(stepped, PANDA, "other")
    wishes = [linear("arm", shifted(here, 0.0, 0.05, -0.05)), joints("other", panda_joint1=0.3, panda_joint4=-1.0)]
    before, motions = state(stepped, "arm"), stepped.motion.ListMotions(motion_pb2.ListMotionsRequest()).motions
    told = plan(stepped, *wishes)
    assert state(stepped, "arm") == before
    assert stepped.motion.ListMotions(motion_pb2.ListMotionsRequest()).motions == motions
    times = values(told.times)
    assert times[-1] == told.duration_seconds
    np.testing.assert_allclose(times[:-1], np.arange(len(times) - 1) * TICK, atol=1e-12)
    arm, other = told.robots
    assert (arm.robot, other.robot) == ("arm", "other")
    assert list(other.joint_names) == ["panda_joint1", "panda_joint4"]
    ask = started(stepped, *wishes)
    assert ask.planned_duration_seconds == told.duration_seconds
    poses, efforts = matrices(arm.world_t_tcp), values(arm.efforts)
    assert efforts.shape == (len(times), 7) and np.abs(efforts[:, 1]).max() > 10.0
    for row in range(len(times)):
        now = state(stepped, "arm")
        np.testing.assert_allclose(now.positions, values(arm.positions)[row], atol=1e-12)
        np.testing.assert_allclose(now.velocities, values(arm.velocities)[row], atol=1e-11)
        np.testing.assert_allclose(matrix(now.world_t_tcp), poses[row], atol=1e-9)
        moved = state(stepped, "other").positions
        np.testing.assert_allclose([moved[0], moved[3]], values(other.positions)[row], atol=1e-12)
        assert bool(now.motion_ids) == (row < len(times) - 1)
        step(stepped)


def test_a_program_is_planned_step_by_step(stepped: Stubs) -> None:
    """A dwell takes its time, waiting for a signal none; the steps of the samples grow."""
    ready(stepped)
    apply(stepped, scene_pb2.Command(create_signal=scene_pb2.CreateSignal(signal=signal_pb2.Signal(name="go"))))
    steps = [
        motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[joints("arm", lbr_iiwa_joint_1=0.5)])),
        motion_pb2.ProgramStep(dwell=motion_pb2.DwellStep(seconds=0.25)),
        motion_pb2.ProgramStep(wait_signal=motion_pb2.WaitSignalStep(condition=condition("go", True))),
        motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[joints("arm", lbr_iiwa_joint_2=0.3)])),
    ]
    told = plan(stepped, *steps)
    first, last = (plan(stepped, joints("arm", **{name: goal})) for name, goal in
                   (("lbr_iiwa_joint_1", 0.5), ("lbr_iiwa_joint_2", 0.3)))  # fmt: skip
    assert told.duration_seconds == pytest.approx(first.duration_seconds + 0.25 + last.duration_seconds, abs=1e-9)
    numbers = np.frombuffer(told.steps.data, "<i4")
    assert numbers.tolist() == sorted(numbers) and set(numbers) == {0, 1, 3}
    (arm,) = told.robots
    standing = values(arm.positions)[numbers == 1]
    assert np.ptp(standing, axis=0).max() == 0.0
    np.testing.assert_array_equal(values(arm.positions)[-1], [0.5, 0.3])


def test_what_is_left_of_a_motion_that_runs_is_told_as_it_was_planned(stepped: Stubs) -> None:
    """Steps that are done are no part of it, those that were appended are; the world then goes on as it was told."""
    ready(stepped)
    goals = ({"lbr_iiwa_joint_1": 0.5}, {"lbr_iiwa_joint_2": 0.3}, {"lbr_iiwa_joint_1": 0.1})
    steps = [motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[joints("arm", **one)])) for one in goals]
    whole = plan(stepped, *steps)
    times, numbers = values(whole.times), np.frombuffer(whole.steps.data, "<i4")
    leave = motion_pb2.DISCONNECT_POLICY_CONTINUE
    first = motion_pb2.StartMotionRequest(spec=motion_of(*steps[:2]), on_disconnect=leave, open=True)
    id = stepped.motion.StartMotion(first).motion.id

    def left(**more: motion_pb2.MotionSpec | float) -> motion_pb2.PlanMotionResponse:
        return stepped.motion.PlanMotion(motion_pb2.PlanMotionRequest(motion_id=id, **more))  # type: ignore[arg-type]

    assert left().duration_seconds < whole.duration_seconds
    stepped.motion.AppendMotion(motion_pb2.AppendMotionRequest(id=id, steps=steps[2:]))
    done = 0
    for place in (1, 30, int(np.searchsorted(numbers, 1)) + 20, int(np.searchsorted(numbers, 2)) + 3):
        step(stepped, place - done)
        done, told = place, left()
        assert told.duration_seconds == pytest.approx(whole.duration_seconds - times[place], abs=1e-9)
        assert np.frombuffer(told.steps.data, "<i4").tolist() == numbers[place:].tolist()
        (arm,), (planned,) = told.robots, whole.robots
        assert arm.joint_names == planned.joint_names
        for one in ("positions", "velocities", "world_t_tcp"):
            np.testing.assert_allclose(values(getattr(arm, one)), values(getattr(planned, one))[place:], atol=1e-9)
    step(stepped, len(times) + 10)
    assert values(left().times).tolist() == [0.0]
    assert refusal(lambda: left(spec=motion_of(*steps))).metadata["field"] == "motion_id"
    stepped.motion.CancelMotion(motion_pb2.CancelMotionRequest(id=id))
    assert refusal(left).reason == "WRONG_STATE"
    id = "none"
    assert refusal(left).reason == "UNKNOWN_NAME"


def test_samples_are_as_far_apart_as_asked(stepped: Stubs) -> None:
    ready(stepped)
    move = joints("arm", lbr_iiwa_joint_1=1.0)
    told = plan(stepped, move, seconds=0.1)
    times = values(told.times)
    np.testing.assert_allclose(times[:-1], np.arange(len(times) - 1) * 0.1, atol=1e-12)
    assert times[-1] == told.duration_seconds
    for seconds in (0.003, -1.0, float("nan"), float("inf")):
        refused = refusal(lambda seconds=seconds: plan(stepped, move, seconds=seconds))
        assert refused.code == grpc.StatusCode.INVALID_ARGUMENT
        assert "sample_seconds" in refused.message
    long = trajectory("arm", ["lbr_iiwa_joint_1"], [0.0, 9000.0], [[0.3], [1.0]])
    refused = refusal(lambda: plan(stepped, long))
    assert (refused.code, refused.reason) == (grpc.StatusCode.RESOURCE_EXHAUSTED, "TOO_LARGE")
    assert refused.metadata["samples"] == "2250001"
    enough = float(refused.message.rpartition("sample_seconds of ")[2].split()[0])
    assert len(values(plan(stepped, long, seconds=enough).times)) <= int(refused.metadata["most"])


def test_what_cannot_be_planned_is_refused_by_plan_and_answered_by_check(stepped: Stubs) -> None:
    here = ready(stepped)
    far = to_pose("arm", shifted(here, 3.0))
    assert refusal(lambda: plan(stepped, far)).reason == "UNREACHABLE"
    told = check(stepped, far)
    assert told.first_violation.kind == motion_pb2.VIOLATION_KIND_REACH
    assert told.first_violation.robot == "arm" and told.first_violation.value > 1.0
    assert not told.first_violation.HasField("time_seconds")
    assert (told.duration_seconds, told.HasField("min_singular_value")) == (0.0, False)

    beyond = joints("arm", lbr_iiwa_joint_1=4.0)
    assert refusal(lambda: plan(stepped, beyond)).reason == "LIMIT_EXCEEDED"
    first = check(stepped, beyond).first_violation
    assert (first.kind, first.joint) == (motion_pb2.VIOLATION_KIND_JOINT_POSITION, "lbr_iiwa_joint_1")
    assert first.limit == pytest.approx(2.96706, abs=1e-5)
    assert first.path_fraction == pytest.approx((first.limit - READY["lbr_iiwa_joint_1"]) / (4.0 - 0.3), abs=1e-5)
    turned = matrix(first.world_t_tcp)
    angle = np.arctan2(turned[1, 3], turned[0, 3]) - np.arctan2(here[1, 3], here[0, 3])
    assert np.mod(angle, 2.0 * np.pi) == pytest.approx(first.limit - 0.3, abs=1e-5), "joint 1 turns about the world's z"
    assert "lbr_iiwa_joint_1" in first.message


def test_a_motion_that_is_well_is_told_so(stepped: Stubs) -> None:
    here = ready(stepped)
    move = linear("arm", shifted(here, 0.0, 0.05, 0.0))
    told = check(stepped, move)
    assert not told.HasField("first_violation")
    assert told.duration_seconds == plan(stepped, move).duration_seconds
    assert told.min_singular_value > 0.01
    near = check(stepped, move, margin=told.min_singular_value * 1.01)
    assert near.first_violation.kind == motion_pb2.VIOLATION_KIND_SINGULARITY
    assert (near.first_violation.value, near.first_violation.limit) == (
        pytest.approx(told.min_singular_value, rel=0.05), pytest.approx(told.min_singular_value * 1.01)
    )  # fmt: skip


def test_bad_requests_are_errors_of_both(stepped: Stubs) -> None:
    here = ready(stepped)
    nan = joints("arm", lbr_iiwa_joint_1=float("nan"))
    for ask in (plan, check):
        assert refusal(lambda ask=ask: ask(stepped, joints("arn"))).reason == "UNKNOWN_NAME"
        assert "lbr_iiwa_joint_1" in refusal(lambda ask=ask: ask(stepped, nan)).message
        assert refusal(lambda ask=ask: ask(stepped)).reason == "INVALID_ARGUMENT"
    for margin in (-1.0, float("nan")):
        refused = refusal(lambda margin=margin: check(stepped, linear("arm", here), margin=margin))
        assert "min_singular_value" in refused.message


def test_the_revision_that_a_motion_is_meant_for(stepped: Stubs) -> None:
    ready(stepped)
    move = joints("arm", lbr_iiwa_joint_1=0.5)
    told = plan(stepped, move)
    meant = {"spec": motion_of(move), "expected_structure_revision": told.stamp.structure_revision}
    load(stepped, PANDA, "other")
    for call in (
        lambda: stepped.motion.StartMotion(motion_pb2.StartMotionRequest(**meant)),
        lambda: stepped.motion.PlanMotion(motion_pb2.PlanMotionRequest(**meant)),
        lambda: stepped.motion.CheckMotion(motion_pb2.CheckMotionRequest(**meant)),
    ):
        refused = refusal(call)
        assert (refused.code, refused.reason) == (grpc.StatusCode.ABORTED, "STALE_REVISION")
        assert refused.metadata["expected_structure_revision"] == str(told.stamp.structure_revision)
    meant["expected_structure_revision"] = plan(stepped, move).stamp.structure_revision
    assert stepped.motion.StartMotion(motion_pb2.StartMotionRequest(**meant)).motion.id


def test_a_busy_arm_can_be_planned_for(stepped: Stubs) -> None:
    """From where it is at this tick."""
    ready(stepped)
    start(stepped, joints("arm", lbr_iiwa_joint_1=1.5))
    step(stepped, 50)
    told = plan(stepped, joints("arm", lbr_iiwa_joint_1=0.0))
    np.testing.assert_allclose(values(told.robots[0].positions)[0], [state(stepped, "arm").positions[0]])
    assert not check(stepped, joints("arm", lbr_iiwa_joint_1=0.0)).HasField("first_violation")


def test_a_client_that_gives_up_ends_the_work(stepped: Stubs) -> None:
    """Long checks are given up after at most a chunk: else these would hold up the last one for minutes."""
    ready(stepped)
    names, goal = ["lbr_iiwa_joint_1"], [[0.3], [1.0]]
    long = motion_of(trajectory("arm", names, [0.0, 100000.0], goal))
    calls = [stepped.motion.CheckMotion.future(motion_pb2.CheckMotionRequest(spec=long)) for _ in range(8)]
    time.sleep(0.1)
    for call in calls:
        call.cancel()
    short = trajectory("arm", names, [0.0, 2.0], goal)
    assert not check(stepped, short).HasField("first_violation")
