"""Set, step and read in one call; steps that end with an event."""

from __future__ import annotations

from typing import Any

import grpc
import pytest
from virtualrobot._wire.signal_values import condition, set_command
from virtualrobot.v1 import collision_pb2, kernel_pb2, motion_pb2, robot_pb2, scene_pb2, signal_pb2

from tests.api.asking import IIWA, apply, box, create, joints, load, refusal
from tests.api.asking import start as move
from tests.api.test_sensor import FAN, ball, sensor, start
from tests.kernels import Stubs

VELOCITY = motion_pb2.SETPOINT_MODE_VELOCITY


def go(stubs: Stubs, ticks: int = 1, **fields: Any) -> kernel_pb2.StepClockResponse:  # noqa: ANN401 fields of the request
    return stubs.kernel.StepClock(kernel_pb2.StepClockRequest(ticks=ticks, **fields), timeout=120.0)


def turning(*values: float, timeout: float = 10.0, robot: str = "arm") -> kernel_pb2.StepSetpoint:
    """Return a setpoint of the speed of the arm's first joint."""
    target = motion_pb2.SetpointTarget(
        robot=robot, joint_names=["lbr_iiwa_joint_1"], mode=VELOCITY, timeout_seconds=timeout
    )
    return kernel_pb2.StepSetpoint(target=target, values=values)


def on(name: str, value: bool = True) -> scene_pb2.Command:
    return set_command(name, value)


def created(name: str) -> scene_pb2.Command:
    return scene_pb2.Command(create_signal=scene_pb2.CreateSignal(signal=signal_pb2.Signal(name=name)))


def tick(stubs: Stubs) -> int:
    return stubs.kernel.GetClock(kernel_pb2.GetClockRequest()).stamp.tick


def test_one_call_sets_steps_and_reads(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    apply(stepped, ball(), sensor(pattern=FAN), created("valve"))
    before = tick(stepped)
    first = go(stepped, 10, commands=[on("valve")], setpoints=[turning(0.3)], sensors=["lidar"])
    assert (first.ticks, first.stamp.tick - before) == (10, 10)
    assert first.signals[0].value.boolean and first.robots[0].velocities[0] > 0.0
    assert first.readings[0].range.distances.shape == [1, 3] and first.readings[0].stamp.tick == first.stamp.tick
    second = go(stepped, 250, setpoints=[turning(0.3)])
    assert second.setpoint_motion_ids == first.setpoint_motion_ids
    assert second.robots[0].velocities[0] == pytest.approx(0.3)
    # No setpoint is given any more: it follows the last one until its timeout, and no other motion moves the arm.
    assert go(stepped, 5).robots[0].motion_ids == second.setpoint_motion_ids
    ended = go(stepped, 500, setpoints=[turning()])
    assert ended.robots[0].velocities[0] == 0.0 and not ended.robots[0].motion_ids
    assert ended.motions[0].phase == motion_pb2.MOTION_PHASE_SUCCEEDED
    other = go(stepped, 5, setpoints=[turning(-0.2)])
    assert other.setpoint_motion_ids != first.setpoint_motion_ids and other.robots[0].velocities[0] < 0.0


def test_the_same_by_one_call_a_period_and_by_a_stream_is_the_same_motion(stepped: Stubs) -> None:
    """A velocity that is reached within the jerk limit: the ticks of a stream with the same setpoints, bit for bit."""
    load(stepped, IIWA, "arm")
    load(stepped, IIWA, "other")
    stream = iter([motion_pb2.StreamSetpointsRequest(target=turning(robot="other").target, values=[0.3])])

    def forever() -> Any:  # noqa: ANN401
        yield from stream
        done.wait(60.0)

    import threading

    done = threading.Event()
    call = stepped.motion.StreamSetpoints(forever(), timeout=60.0)
    while not next(call).setpoint_count:
        pass
    answers = [go(stepped, 1, setpoints=[turning(0.3)]) for _ in range(60)]
    done.set()
    for answer in answers:
        arm, other = answer.robots
        assert (arm.positions[0], arm.velocities[0]) == (other.positions[0], other.velocities[0])
    assert answers[-1].robots[0].velocities[0] > 0.1


def test_what_is_refused_changes_nothing_and_no_time_goes_by(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    apply(stepped, created("valve"))
    before = tick(stepped)
    fast = turning(99.0)
    cases: list[tuple[dict[str, Any], str]] = [
        ({"commands": [on("valve"), on("vlave")]}, "UNKNOWN_NAME"),
        ({"commands": [on("valve")], "setpoints": [fast]}, "LIMIT"),
        ({"commands": [on("valve")], "setpoints": [turning(0.1, 0.2)]}, "INVALID"),
        ({"commands": [on("valve")], "setpoints": [turning(0.1), turning(0.2)]}, "INVALID"),
        ({"commands": [on("valve")], "setpoints": [turning(0.1, robot="leg")]}, "UNKNOWN_NAME"),
        ({"commands": [on("valve")], "sensors": ["lidar"]}, "UNKNOWN_NAME"),
        ({"commands": [on("valve")], "until": [kernel_pb2.StepEvent()]}, "INVALID"),
        ({"commands": [on("valve")], "until": [kernel_pb2.StepEvent(motion_ended="motion-x")]}, "UNKNOWN_NAME"),
        ({"commands": [on("valve")], "until": [kernel_pb2.StepEvent(collision_of="arm")]}, "WRONG_STATE"),
        ({"commands": [on("valve")], "until": [kernel_pb2.StepEvent(signal=condition("valve", 3))]}, "INVALID"),
    ]
    for fields, reason in cases:
        said = refusal(lambda fields=fields: go(stepped, 5, **fields))
        assert reason in said.reason or (reason == "INVALID" and said.code == grpc.StatusCode.INVALID_ARGUMENT), said
    assert tick(stepped) == before
    now = go(stepped, 1)
    assert not now.signals[0].value.boolean and not now.robots[0].motion_ids
    assert now.robots[0].positions[0] == 0.0
    assert refusal(lambda: go(stepped, 0, commands=[on("valve")])).code == grpc.StatusCode.INVALID_ARGUMENT


def test_in_real_time_nothing_is_set_by_a_step(stubs: Stubs) -> None:
    apply(stubs, created("valve"))
    assert refusal(lambda: go(stubs, 5, commands=[on("valve")])).reason == "WRONG_STATE"
    assert not stubs.signal.GetSignals(signal_pb2.GetSignalsRequest()).signals[0].value.boolean


def test_a_motion_that_was_stopped_meanwhile_is_told_once_and_begins_anew(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    id = go(stepped, 20, setpoints=[turning(0.3)]).setpoint_motion_ids[0]
    stepped.motion.Stop(motion_pb2.StopRequest(robots=["arm"]))
    go(stepped, 200)
    said = refusal(lambda: go(stepped, 5, setpoints=[turning(0.3)]))
    assert (said.reason, said.metadata["motion"]) == ("WRONG_STATE", id)
    assert go(stepped, 5, setpoints=[turning(0.3)]).setpoint_motion_ids[0] != id


def test_without_setpoints_the_robot_stops_after_its_timeout(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    go(stepped, 50, setpoints=[turning(0.3, timeout=0.5)])
    ended = go(stepped, 500)
    assert ended.robots[0].velocities[0] == 0.0
    assert ended.motions[0].end_cause == motion_pb2.END_CAUSE_SETPOINT_TIMEOUT


def test_a_step_ends_with_an_event(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    apply(stepped, ball(), sensor(pattern=FAN, rate_hertz=10.0), created("valve"))
    id = move(stepped, joints("arm", lbr_iiwa_joint_1=0.5)).id
    end = kernel_pb2.StepEvent(motion_ended=id)
    valve = kernel_pb2.StepEvent(signal=condition("valve", True))
    short = go(stepped, 10, until=[valve, end])
    assert (short.ticks, list(short.events)) == (10, [])
    ended = go(stepped, 5000, until=[valve, end])
    assert list(ended.events) == [1] and 0 < ended.ticks < 1000
    assert [motion.phase for motion in ended.motions] == [motion_pb2.MOTION_PHASE_SUCCEEDED]
    assert ended.robots[0].positions[0] == pytest.approx(0.5)
    met = go(stepped, 100, commands=[on("valve")], until=[valve, end])
    assert (met.ticks, list(met.events)) == (1, [0, 1])
    assert refusal(lambda: go(stepped, 5, until=[kernel_pb2.StepEvent(reading_of="lidar")])).reason == "WRONG_STATE"
    start(stepped, "lidar")
    # 10 Hz: the next reading is due 25 ticks of 4 ms after the start.
    read = go(stepped, 1000, until=[kernel_pb2.StepEvent(reading_of="lidar")], sensors=["lidar"])
    assert (read.ticks, read.readings[0].number) == (25, 1)
    again = go(stepped, 1000, until=[kernel_pb2.StepEvent(reading_of="lidar")], sensors=["lidar"])
    assert (again.ticks, again.readings[0].number) == (25, 2)


def test_a_step_ends_when_a_robot_touches(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    apply(stepped, create(box("cube", x=0.35, z=1.1)))
    mode = collision_pb2.SetCollisionSettings(mode=collision_pb2.COLLISION_MODE_MONITOR)
    apply(stepped, scene_pb2.Command(set_collision_settings=mode))
    move(stepped, joints("arm", lbr_iiwa_joint_2=1.2))
    touched = go(stepped, 5000, until=[kernel_pb2.StepEvent(collision_of="arm")])
    assert list(touched.events) == [0] and touched.ticks < 1000
    assert any(one.phase == motion_pb2.MOTION_PHASE_RUNNING for one in touched.motions)


def test_leases_hold_for_what_a_step_sets(stepped: Stubs) -> None:
    from virtualrobot.v1 import lease_pb2

    load(stepped, IIWA, "arm")
    lease = stepped.lease.AcquireLease(lease_pb2.AcquireLeaseRequest(robots=["arm"], owner="somebody"))
    said = refusal(lambda: go(stepped, 5, setpoints=[turning(0.3)]))
    assert said.reason == "LEASED"
    carried = (("virtualrobot-lease", lease.token),)
    request = kernel_pb2.StepClockRequest(ticks=5, setpoints=[turning(0.3)])
    assert stepped.kernel.StepClock(request, metadata=carried).robots[0].velocities[0] > 0.0
    assert go(stepped, 1).ticks == 1  # time is nobody's


def test_robot_states_of_a_step_are_all(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    told = go(stepped, 1).robots
    assert list(told) == list(stepped.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest()).robots)
