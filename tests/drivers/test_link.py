"""Links of robots over the wire, with a far side that the test plays: what is let in, what is refused."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from virtualrobot.v1 import (
    collision_pb2,
    driver_pb2,
    history_pb2,
    kernel_pb2,
    motion_pb2,
    scene_pb2,
)
from virtualrobot_sdk.drivers import DriverFault, Mode

from tests.api.asking import IIWA, box, create, joints, load, refusal
from tests.api.leasing import Holder
from tests.drivers.bench import ACTIVE, ERROR, EXECUTE, FIRST, GUARD, INACTIVE, SIMULATED, Bench, aspect, pose
from tests.waiting import until


def test_a_robot_does_what_its_twin_does_a_lead_later(bench: Bench) -> None:
    status = bench.connect(lead_seconds=0.05)
    assert (status.state, status.mode, len(status.joint_names)) == (INACTIVE, SIMULATED, 7)
    assert status.controller.model == "sham"
    told = bench.mode(EXECUTE)
    assert (told.driver.state, told.driver.mode) == (ACTIVE, EXECUTE)
    assert not told.twin_moved
    assert bench.await_end(bench.move(**{FIRST: 0.3})).phase == motion_pb2.MOTION_PHASE_SUCCEEDED
    until(lambda: abs(bench.process.stands[0] - 0.3) < 1e-9)
    back = bench.mode(SIMULATED).driver
    assert (back.state, back.mode) == (INACTIVE, SIMULATED)
    bench.clock(kernel_pb2.CLOCK_MODE_REALTIME, 2.0)
    last = bench.call("DisconnectDriver", robot="arm").driver
    assert last.robot == "arm"
    assert not bench.alone.driver.GetDrivers(driver_pb2.GetDriversRequest()).drivers


def test_a_line_in_the_network_is_one_robots(bench: Bench) -> None:
    """However it is written; it is free while its connection is in ERROR, and refused to whom has had it before."""
    load(bench.alone, IIWA, "other", parent_t_node=pose(2.0))
    others = Holder(bench, "other")  # pyright: ignore[reportArgumentType] what it needs of a kernel is here

    def connect(robot: str, url: str, note: str = "") -> None:
        ask = driver_pb2.ConnectDriverRequest(robot=robot, component="sham")
        ask.settings.update({"port": url, "note": note})
        holder = bench.holder if robot == "arm" else others
        holder.stubs.driver.ConnectDriver(ask, metadata=holder.metadata)

    connect("arm", "socket://localhost:4001", "socket://[::no address")
    one = bench.process
    for url in ("socket://127.0.0.1:4001", "SOCKET://LocalHost:4001/", "socket://[::1]:4001?logging=debug"):
        refused = refusal(lambda url=url: connect("other", url))
        assert aspect(refused) == "driver"
        assert "socket://127.0.0.1:4001 is the line of the driver 'sham' of 'arm' already" in refused.message
    one.fail(DriverFault("the board is silent", clears=True))
    until(lambda: bench.status.state == ERROR)
    connect("other", "socket://127.0.0.1:4001")
    refused = refusal(lambda: bench.call("ResetDriver", robot="arm"))
    assert (aspect(refused), "of 'other' already" in refused.message) == ("driver", True)


def test_a_joint_beyond_its_limits_is_told_with_where_it_is_and_these(bench: Bench) -> None:
    """The first joint of the iiwa goes to 170 degrees (data sheet): 2.967 rad."""
    bench.connect()
    bench.process.stands = np.array([3.2, *np.zeros(6)])
    until(lambda: bench.status.positions[0] == 3.2)
    refused = refusal(lambda: bench.mode(EXECUTE))
    assert aspect(refused) == "limits"
    assert f"outside their limits stand {FIRST} at 3.2 (-2.96706 to 2.96706)" in refused.message


def test_who_has_no_driver_is_told_that_before_a_lease(bench: Bench) -> None:
    asked = driver_pb2.SetDriverModeRequest(robot="arm", mode=EXECUTE)
    bench.holder.release()
    assert "no driver is connected to 'arm'" in refusal(lambda: bench.alone.driver.SetDriverMode(asked)).message


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo terminals")
def test_a_serial_port_is_one_robots(bench: Bench, tmp_path: Path) -> None:
    """By whatever link it is named; pyserial would only say that it cannot be locked."""
    load(bench.alone, IIWA, "other", parent_t_node=pose(2.0))
    others = Holder(bench, "other")  # pyright: ignore[reportArgumentType] what it needs of a kernel is here
    ends = os.openpty()
    try:
        port, link = os.ttyname(ends[1]), tmp_path / "ttyLUMO"
        link.symlink_to(port)
        bench.connect(settings={"port": port})
        ask = driver_pb2.ConnectDriverRequest(robot="other", component="sham")
        ask.settings.update({"port": str(link)})
        refused = refusal(lambda: others.stubs.driver.ConnectDriver(ask, metadata=others.metadata))
        assert aspect(refused) == "driver"
        assert f"{port} is the line of the driver 'sham' of 'arm' already" in refused.message
    finally:
        for end in ends:
            os.close(end)


@pytest.mark.long
def test_a_second_robot_is_told_ticks_at_once(bench: Bench) -> None:
    """Though the first one stands, so that its ticks are told no more."""
    load(bench.alone, IIWA, "other", parent_t_node=pose(2.0))
    others = Holder(bench, "other")  # pyright: ignore[reportArgumentType] what it needs of a kernel is here
    bench.connect()
    ask = driver_pb2.ConnectDriverRequest(robot="other", component="sham")
    others.stubs.driver.ConnectDriver(ask, metadata=others.metadata)
    bench.mode(EXECUTE)
    world = bench.kernel.world
    for _ in range(20):
        tick = world.snapshot.state.tick
        until(lambda tick=tick: world.snapshot.state.tick > tick + 5)
        for mode in (EXECUTE, SIMULATED):
            follow = driver_pb2.SetDriverModeRequest(robot="other", mode=mode)
            told = others.stubs.driver.SetDriverMode(follow, metadata=others.metadata).driver
            assert told.state == (ACTIVE if mode == EXECUTE else INACTIVE)
    assert bench.status.state == ACTIVE


@pytest.mark.long
def test_the_twin_is_first_put_to_where_the_robot_stands(bench: Bench) -> None:
    bench.connect()
    bench.process.stands = np.full(7, 0.2)
    until(lambda: list(bench.status.positions) == [0.2] * 7)
    assert bench.mode(EXECUTE).twin_moved == [0.2] * 7
    assert bench.joint() == 0.2
    np.testing.assert_allclose(bench.process.stands, 0.2)


@pytest.mark.long
def test_execute_names_the_condition_that_does_not_hold(bench: Bench) -> None:
    bench.connect()
    ask = driver_pb2.SetDriverModeRequest(robot="arm", mode=EXECUTE)

    def wanting() -> str:
        return aspect(refusal(lambda: bench.mode(EXECUTE)))

    assert refusal(lambda: bench.alone.driver.SetDriverMode(ask)).reason == "LEASED"
    bench.holder.stubs.scene.Apply(
        scene_pb2.ApplyRequest(
            commands=[
                scene_pb2.Command(
                    set_collision_settings=collision_pb2.SetCollisionSettings(mode=collision_pb2.COLLISION_MODE_OFF)
                )
            ]
        ),
        metadata=bench.holder.metadata,
    )
    assert wanting() == "guard"
    bench.holder.apply(
        scene_pb2.Command(set_collision_settings=collision_pb2.SetCollisionSettings(mode=GUARD)),
    )
    bench.clock(kernel_pb2.CLOCK_MODE_REALTIME, 0.5)
    assert wanting() == "clock"
    bench.clock(kernel_pb2.CLOCK_MODE_REALTIME, 1.0)
    bench.process.report = replace(bench.process.report, mode=Mode.LOCAL)
    until(lambda: bench.status.controller_mode == driver_pb2.CONTROLLER_MODE_LOCAL)
    assert wanting() == "controller"
    bench.process.report = replace(bench.process.report, mode=Mode.READY)
    until(lambda: bench.status.controller_mode == driver_pb2.CONTROLLER_MODE_READY)
    bench.call("StopCell", reason="lunch")
    assert (bench.cell.stopped, bench.cell.reason) == (True, "lunch")
    assert wanting() == "cell"
    bench.call("ReleaseCell")
    bench.process.refusal = DriverFault("key switch is off", "12")
    refused = refusal(lambda: bench.mode(EXECUTE))
    assert (refused.reason, refused.metadata["code"]) == ("DRIVER_FAULT", "12")
    assert (bench.status.state, bench.status.text) == (INACTIVE, "key switch is off")
    bench.clock(kernel_pb2.CLOCK_MODE_STEPPED)


@pytest.mark.long
def test_what_would_put_a_twin_elsewhere_is_refused_while_it_is_played(bench: Bench) -> None:
    bench.connect()
    bench.mode(EXECUTE)
    put = scene_pb2.SetJointPositions(robot="arm", joint_positions={FIRST: 0.1})
    away = pose(x=1.0)
    off = collision_pb2.SetCollisionSettings(mode=collision_pb2.COLLISION_MODE_OFF)
    for command in (
        scene_pb2.Command(set_joint_positions=put),
        scene_pb2.Command(attach_node=scene_pb2.AttachNode(name="arm", parent_t_node=away)),
        scene_pb2.Command(set_collision_settings=off),
        scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="arm")),
    ):
        refused = refusal(lambda command=command: bench.holder.apply(command))
        assert (refused.reason, refused.metadata["robot"]) == ("WRONG_STATE", "arm"), refused
        assert "a real robot is connected to 'arm'" in refused.message
    ask = kernel_pb2.SetClockRequest(mode=kernel_pb2.CLOCK_MODE_STEPPED)
    assert refusal(lambda: bench.alone.kernel.SetClock(ask)).reason == "WRONG_STATE"
    bench.holder.apply(create(box("far", x=3.0)))
    assert bench.status.state == ACTIVE


@pytest.mark.long
def test_a_motion_that_would_touch_something_is_refused_as_a_whole(bench: Bench) -> None:
    bench.connect()
    bench.mode(EXECUTE)
    # The first axis is vertical: the arm, stretched upwards by zeros, would come down on the box at the end.
    bench.holder.apply(create(box("in the way", x=0.8, z=0.36)))
    asked = {"lbr_iiwa_joint_2": 1.57}
    refused = refusal(lambda: bench.move(**asked))
    assert (refused.reason, refused.metadata["second"]) == ("COLLISION", "in the way"), refused
    assert "nothing was sent" in refused.message
    assert bench.joint("lbr_iiwa_joint_2") == 0.0
    bench.mode(SIMULATED)
    ended = bench.await_end(bench.move(**asked))
    assert ended.end_cause == motion_pb2.END_CAUSE_COLLISION, "the twin alone is stopped on its way"


def test_a_plan_that_nobody_has_checked_is_checked_before_a_real_robot_plays_it(bench: Bench) -> None:
    """One that was checked is started as it was, or refused with what has changed."""
    bench.connect()
    bench.mode(EXECUTE)
    spec = motion_pb2.MotionSpec(moves=[joints("arm", lbr_iiwa_joint_2=1.57)])

    def start(plan: motion_pb2.PlanReference) -> motion_pb2.Motion:
        leave = motion_pb2.DISCONNECT_POLICY_CONTINUE
        request = motion_pb2.StartMotionRequest(plan=plan, on_disconnect=leave)
        return bench.holder.stubs.motion.StartMotion(request, metadata=bench.holder.metadata).motion

    shown = bench.alone.motion.PlanMotion(motion_pb2.PlanMotionRequest(spec=spec, sample_seconds=1.0)).plan
    checked = bench.alone.motion.CheckMotion(motion_pb2.CheckMotionRequest(plan=shown)).plan
    bench.holder.apply(create(box("in the way", x=0.8, z=0.36)))
    refused = refusal(lambda: start(shown))
    assert (refused.reason, refused.metadata["second"]) == ("COLLISION", "in the way"), refused
    assert "nothing was sent" in refused.message
    refused = refusal(lambda: start(checked))
    assert (refused.reason, refused.metadata["changes"]) == ("PLAN_OUTDATED", "'in the way' is new")
    assert bench.joint("lbr_iiwa_joint_2") == 0.0
    bench.holder.apply(scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="in the way")))
    assert bench.await_end(start(checked).id).phase == motion_pb2.MOTION_PHASE_SUCCEEDED


@pytest.mark.long
def test_the_past_of_a_connected_robot_is_not_brought_back(bench: Bench) -> None:
    bench.alone.history.CreateCheckpoint(history_pb2.CreateCheckpointRequest(name="before"))
    bench.holder.apply(scene_pb2.Command(attach_node=scene_pb2.AttachNode(name="arm", parent_t_node=pose(x=0.5))))
    bench.connect()
    bench.mode(EXECUTE)
    history, metadata = bench.holder.stubs.history, bench.holder.metadata
    steps = bench.alone.history.ListSteps(history_pb2.ListStepsRequest(node="arm")).steps
    number = next(step.number for step in steps if step.label.startswith("attached 'arm'"))
    undo, back = history_pb2.UndoRequest(number=number), history_pb2.RestoreCheckpointRequest(name="before")
    for refused in (
        refusal(lambda: history.Undo(undo, metadata=metadata)),
        refusal(lambda: history.RestoreCheckpoint(back, metadata=metadata)),
    ):
        assert (refused.reason, refused.metadata["robot"]) == ("WRONG_STATE", "arm")
        assert "a real robot is connected to 'arm'" in refused.message
    bench.mode(SIMULATED)
    assert history.Undo(undo, metadata=metadata).undone.number == number


def test_bad_connections_are_refused_by_name(bench: Bench) -> None:
    assert refusal(lambda: bench.connect(component="shame")).reason == "UNKNOWN_NAME"
    assert refusal(lambda: bench.connect(robot="leg")).reason == "UNKNOWN_NAME"
    joint = driver_pb2.DriverJoint(joint="lbr_iiwa_joint_8")
    refused = refusal(lambda: bench.connect(joints=[joint]))
    assert refused.reason == "UNKNOWN_NAME"
    assert FIRST in refused.metadata["valid"]
    twice = [driver_pb2.DriverJoint(joint=FIRST)] * 2
    assert "named twice" in refusal(lambda: bench.connect(joints=twice)).message
    bad = driver_pb2.DriverJoint(joint=FIRST, offset=float("nan"))
    assert refusal(lambda: bench.connect(joints=[bad])).metadata["field"] == "joints"
    assert refusal(lambda: bench.connect(lead_seconds=1.0)).metadata["field"] == "lead_seconds"
    assert refusal(lambda: bench.connect(following_limit=0.001)).metadata["field"] == "following_warning"
    bench.site.refusal = DriverFault("no route to 10.0.0.9:30004")
    refused = refusal(bench.connect)
    assert (refused.reason, "10.0.0.9:30004" in refused.message) == ("DRIVER_FAULT", True)
    bench.site.refusal = None
    bench.connect()
    assert "connected to 'arm' already" in refusal(bench.connect).message
    other = driver_pb2.ConnectDriverRequest(robot="arm", component="sham")
    assert refusal(lambda: bench.alone.driver.ConnectDriver(other)).reason == "LEASED"
