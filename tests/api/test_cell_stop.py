"""The stop of a cell without real robots: it brakes, latches, says whose it is, and stays over kills and undo."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot.errors import WrongStateError
from virtualrobot.v1 import driver_pb2, history_pb2, kernel_pb2, motion_pb2

from tests.api.asking import IIWA, Refusal, apply, box, create, joints, load, refusal, start
from tests.api.moving import CANCELLED, READY, RUNNING, SUCCEEDED, finished, motion
from tests.api.reading import state, step
from tests.api.streaming import FIRST, Sender
from tests.api.test_data_folder import kill, names
from tests.api.test_replay import replaying, told
from tests.kernels import StartKernel, Stubs

Start = Callable[[], object]


def stop(stubs: Stubs, reason: str = "") -> driver_pb2.CellStatus:
    return stubs.driver.StopCell(driver_pb2.StopCellRequest(reason=reason)).cell


def release(stubs: Stubs) -> driver_pb2.CellStatus:
    return stubs.driver.ReleaseCell(driver_pb2.ReleaseCellRequest()).cell


def cell(stubs: Stubs) -> driver_pb2.CellStatus:
    return stubs.driver.GetDrivers(driver_pb2.GetDriversRequest()).cell


def orders(stubs: Stubs) -> Iterator[Start]:
    """Yield each way in which a client has a robot move."""
    jog = motion_pb2.Move(robot="arm", joint_jog=motion_pb2.JointJog(joint=FIRST, velocity=0.1))
    yield lambda: start(stubs, joints("arm", **READY))
    yield lambda: start(stubs, joints("arm", **READY), busy=motion_pb2.BUSY_POLICY_PREEMPT)
    yield lambda: start(stubs, jog)
    yield lambda: Sender(stubs)
    steps = [motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[joints("arm", **READY)]))]
    program = motion_pb2.MotionSpec(steps=steps)
    yield lambda: stubs.motion.StartMotion(motion_pb2.StartMotionRequest(spec=program))
    yield lambda: stubs.motion.StartMotion(motion_pb2.StartMotionRequest(spec=program, hold=True))
    plan = stubs.motion.PlanMotion(motion_pb2.PlanMotionRequest(spec=program)).plan
    yield lambda: stubs.motion.StartMotion(motion_pb2.StartMotionRequest(plan=plan))


def is_of_stop(refused: Refusal, reason: str) -> bool:
    metadata = refused.metadata
    return (
        (refused.reason, metadata["aspect"], metadata["stop_reason"]) == ("WRONG_STATE", "cell", reason)
        and f"the cell is stopped: {metadata['stopped_by']} stopped it at " in refused.message
        and "released, by ReleaseCell" in refused.message
    )


def test_a_stop_brakes_and_stays_until_it_is_released(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    began = time.time()
    running = start(stepped, joints("arm", 0.2, **READY)).id
    step(stepped, 60)
    stopped = stop(stepped, "a hand")
    assert (stopped.stopped, stopped.reason) == (True, "a hand")
    assert " at ipv4:127.0.0.1" in stopped.stopped_by
    assert began - 1.0 < stopped.stop_time.ToNanoseconds() * 1e-9 < time.time() + 1.0
    assert motion(stepped, running).end_cause == motion_pb2.END_CAUSE_CELL_STOPPED

    # Its brake goes on by ticks: until then nobody releases it, and nobody lets the motion go on.
    assert refusal(lambda: release(stepped)).metadata["aspect"] == "rest"
    resume = motion_pb2.ResumeMotionRequest(id=running)
    assert is_of_stop(refusal(lambda: stepped.motion.ResumeMotion(resume)), "a hand")
    assert [is_of_stop(refusal(order), "a hand") for order in orders(stepped)] == [True] * 7
    ended = finished(stepped, running)
    assert (ended.phase, ended.end_reason) == (CANCELLED, "a hand")
    assert 0.0 < ended.progress < 1.0

    was = np.array(state(stepped, "arm").positions)
    assert [is_of_stop(refusal(order), "a hand") for order in orders(stepped)] == [True] * 7
    stepped.motion.Stop(motion_pb2.StopRequest())
    assert stop(stepped, "another one") == stopped, "the first one counts"
    apply(stepped, create(box("cube")))
    stepped.history.Undo(history_pb2.UndoRequest())
    assert "cube" not in names(stepped), "the world may be edited"
    step(stepped, 100)
    assert np.array_equal(state(stepped, "arm").positions, was)
    assert cell(stepped) == stopped

    assert not release(stepped).stopped
    assert not release(stepped).stopped, "there is nothing to release any more"
    step(stepped, 100)
    assert np.array_equal(state(stepped, "arm").positions, was), "nothing moves by a release"
    assert finished(stepped, start(stepped, joints("arm", **READY)).id).phase == SUCCEEDED


def test_a_stream_of_setpoints_ends_with_the_stop_and_begins_after_it(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    sender = Sender(stepped)
    sender.give(0.5)
    step(stepped, 50)
    stop(stepped, "the jog")
    sender.send(0.9)  # a setpoint that comes too late changes nothing
    step(stepped, 200)
    last = sender.rest().motion
    assert (last.phase, last.end_cause) == (CANCELLED, motion_pb2.END_CAUSE_CELL_STOPPED)
    assert not any(state(stepped, "arm").velocities)
    release(stepped)
    assert Sender(stepped).told.motion.phase == RUNNING


def test_it_is_watched_and_written_down(stepped: Stubs) -> None:
    watch = stepped.driver.WatchDrivers(driver_pb2.WatchDriversRequest(), timeout=60)
    assert not next(watch).cell.stopped
    told = stop(stepped, "look")
    assert next(one.cell for one in watch if one.cell.stopped) == told
    release(stepped)
    assert next(one.cell for one in watch if not one.cell.stopped).stopped_by == ""
    watch.cancel()
    request = history_pb2.ListStepsRequest(page_size=2)
    labels = [one.label for one in stepped.history.ListSteps(request).steps]
    assert sorted(labels) == ["released the cell", "stopped the cell: look"]


def test_the_client_tells_who_stopped_when_and_why(stepped: Stubs, stepped_kernel: object) -> None:
    address = stepped_kernel.address  # pyright: ignore[reportAttributeAccessIssue]
    with virtualrobot.connect(address, name="the pendant") as client:
        arm = client.load_robot(IIWA, name="arm")
        watch = client.cell.watch()
        assert next(watch) is None and client.cell.stopped is None
        client.cell.stop("a cat")
        stopped = next(watch)
        assert stopped is not None and stopped == client.cell.stopped
        assert (stopped.by.partition(" at ")[0], stopped.reason) == ("the pendant", "a cat")
        assert abs((datetime.now(UTC) - stopped.time).total_seconds()) < 600.0
        with pytest.raises(WrongStateError, match=r"the pendant at .* \(a cat\)") as refused:
            arm.move_joints(list(READY.values()), wait=False)
        assert datetime.fromisoformat(refused.value.metadata["stop_time"]).tzinfo is UTC
        assert "stopped by the pendant" in repr(client.cell)
        client.cell.release()
        assert next(watch) is None
        assert repr(client.cell) == "<Cell: not stopped>"


@pytest.mark.long
def test_it_stays_when_the_kernel_is_killed_and_when_the_world_goes_back(
    tmp_path: Path, start_kernel: StartKernel
) -> None:
    folder = tmp_path / "cell"
    options = ("--stepped", "--data", str(folder))
    kernel = start_kernel(*options)
    stubs = kernel.stubs()
    load(stubs, IIWA, "arm")
    stubs.history.CreateCheckpoint(history_pb2.CreateCheckpointRequest(name="before"))
    start(stubs, joints("arm", 0.2, **READY))
    step(stubs, 60)
    stopped = stop(stubs, "fire")
    step(stubs, 7)
    was = np.array(state(stubs, "arm").positions)
    kill(kernel)

    kernel = start_kernel(*options)
    stubs = kernel.stubs()
    assert cell(stubs) == stopped
    assert np.array_equal(state(stubs, "arm").positions, was)
    assert is_of_stop(refusal(lambda: start(stubs, joints("arm", **READY))), "fire")
    stubs.history.CreateCheckpoint(history_pb2.CreateCheckpointRequest(name="stopped"))
    stubs.history.RestoreCheckpoint(history_pb2.RestoreCheckpointRequest(name="before"))
    assert cell(stubs) == stopped, "a world that goes back to before the stop is stopped"
    release(stubs)
    stubs.history.RestoreCheckpoint(history_pb2.RestoreCheckpointRequest(name="stopped"))
    assert not cell(stubs).stopped, "and one that goes back to a stop that was released isn't"
    assert finished(stubs, start(stubs, joints("arm", **READY)).id).phase == SUCCEEDED
    assert kernel.end() == 0

    code, text = told("replay", str(folder), "--verify")
    assert code == 0 and "ticks are the same" in text
    past = replaying(folder)
    stubs = past.stubs()
    stubs.kernel.SeekClock(kernel_pb2.SeekClockRequest(tick=63))
    assert cell(stubs) == stopped
    assert refusal(lambda: stop(stubs)).reason == "WRONG_STATE", "what was isn't stopped"
    past.end()
