"""Links of robots over the wire that fault or are stopped, with a far side that the test plays."""

from __future__ import annotations

from dataclasses import replace
from unittest import mock

import numpy as np
import pytest
from virtualrobot.v1 import (
    driver_pb2,
    motion_pb2,
)
from virtualrobot_kernel.drivers import link
from virtualrobot_sdk.drivers import About, DriverFault, Mode, Safety
from virtualrobot_sdk.drivers.shared import NEVER, CellBlock, State, TickRing

from tests.api.asking import refusal
from tests.api.leasing import Holder
from tests.api.streaming import Sender
from tests.drivers.bench import ACTIVE, ERROR, EXECUTE, FIRST, INACTIVE, MONITOR, SIMULATED, Bench, aspect
from tests.drivers.sham_site import ShamProcess
from tests.waiting import until


@pytest.mark.long
def test_a_robot_that_faults_stops_its_twin_with_its_words(bench: Bench) -> None:
    bench.connect()
    bench.mode(EXECUTE)
    id = bench.move(0.2, **{FIRST: 2.0})
    until(lambda: bench.joint() > 0.05)
    bench.process.fail(DriverFault("joint 3 is too hot", "C204"))
    ended = bench.await_end(id)
    assert (ended.phase, ended.end_cause) == (motion_pb2.MOTION_PHASE_ABORTED, motion_pb2.END_CAUSE_DRIVER)
    assert "joint 3 is too hot" in ended.end_reason
    until(lambda: bench.status.mode == SIMULATED)
    assert (bench.status.state, bench.status.text, bench.status.code) == (ERROR, "joint 3 is too hot", "C204")
    assert bench.cell.stopped_by == "driver sham of arm"
    assert "joint 3 is too hot" in bench.cell.reason
    assert aspect(refusal(lambda: bench.mode(EXECUTE))) == "state"
    refused = refusal(lambda: bench.call("ResetDriver", robot="arm"))
    assert (refused.reason, refused.metadata["clears"]) == ("DRIVER_FAULT", "False")
    where = bench.joint()
    refused = refusal(lambda: bench.move(**{FIRST: 0.0}))
    assert "driver sham of arm stopped it" in refused.message and "joint 3 is too hot" in refused.message
    assert aspect(refused) == "cell"
    bench.connect()  # anew, once somebody has seen to it
    assert aspect(refusal(lambda: bench.mode(EXECUTE))) == "cell"
    bench.process.fail(DriverFault("joint 3 is too hot", "C204"))
    until(lambda: bench.status.state == ERROR)
    bench.call("ReleaseCell")
    refused = refusal(lambda: bench.move(**{FIRST: 0.0}))
    assert (refused.reason, refused.metadata["code"], refused.metadata["clears"]) == ("DRIVER_FAULT", "C204", "False")
    assert "joint 3 is too hot; see to it at the controller, connect its driver again" in refused.message
    bench.connect()  # anew, once somebody has seen to it
    assert "its driver was connected again after a fault" in refusal(lambda: bench.move(**{FIRST: 0.0})).message
    assert bench.joint() == where
    told = bench.mode(EXECUTE).driver
    assert (told.state, told.halted) == (ACTIVE, False)
    assert bench.joint() != where, "the new sham stands at 0, and the twin is put there"
    assert bench.await_end(bench.move(**{FIRST: 0.1})).phase == motion_pb2.MOTION_PHASE_SUCCEEDED


def test_a_twin_moves_alone_after_a_fault_only_where_somebody_chooses_that(bench: Bench) -> None:
    """No motion of any kind is let in before, and a reset is no choice."""
    bench.connect()
    bench.process.fail(DriverFault("the motors are cold", "7", clears=True))
    until(lambda: bench.status.halted)
    go = {FIRST: 0.1}
    refused = refusal(lambda: bench.move(**go))
    assert (refused.reason, refused.metadata["code"], refused.metadata["clears"]) == ("DRIVER_FAULT", "7", "True")
    assert "the motors are cold; clear that with ResetDriver" in refused.message
    jog = motion_pb2.Move(robot="arm", joint_jog=motion_pb2.JointJog(joint=FIRST, velocity=0.1))
    assert refusal(lambda: bench.holder.start(jog)).reason == "DRIVER_FAULT"
    assert refusal(lambda: Sender(bench.holder.stubs, metadata=bench.holder.metadata)).reason == "DRIVER_FAULT"
    reset = bench.call("ResetDriver", robot="arm").driver
    assert (reset.state, reset.mode, reset.halted) == (INACTIVE, SIMULATED, True)
    assert aspect(refusal(lambda: bench.move(**go))) == "mode"
    assert not bench.mode(SIMULATED).driver.halted
    assert bench.await_end(bench.move(**go)).phase == motion_pb2.MOTION_PHASE_SUCCEEDED
    bench.process.fail(DriverFault("the motors are hot", "8"))
    until(lambda: bench.status.halted)
    told = bench.mode(SIMULATED).driver  # in ERROR, too
    assert (told.state, told.halted) == (ERROR, False)
    assert bench.await_end(bench.move(**{FIRST: 0.0})).phase == motion_pb2.MOTION_PHASE_SUCCEEDED


@pytest.mark.long
@pytest.mark.parametrize("how", ["safety", "hangs", "dies", "away", "ends", "starves", "local"])
def test_each_way_in_which_a_robot_does_not_follow_stops_it(bench: Bench, how: str) -> None:
    bench.connect()
    bench.mode(EXECUTE)
    id = bench.move(0.2, **{FIRST: 2.5})
    until(lambda: bench.joint() > 0.05)
    sham = bench.process
    said = {
        "safety": "protective_stop",
        "hangs": "has been silent",
        "dies": "exit code 9",
        "away": "is allowed",
        "ends": "has ended what it played",
        "starves": "the real robots brake",
        "local": "is local",
    }[how]
    if how == "hangs":
        link.SILENT_SECONDS, sham.hangs = 0.1, True
    elif how == "away":
        sham.offset = np.array([0.2, 0, 0, 0, 0, 0, 0])
    elif how == "safety":
        sham.report = replace(sham.report, safety=Safety.PROTECTIVE_STOP)
    elif how == "dies":
        sham.fault = DriverFault("its process has ended: exit code 9")
    elif how == "ends":
        sham.report = replace(sham.report, state=State.INACTIVE)
    elif how == "starves":
        sham.tell(on_brake=True)
        sham.cell.stop()
    else:
        sham.report = replace(sham.report, mode=Mode.LOCAL)
    ended = bench.await_end(id)
    assert ended.end_cause == motion_pb2.END_CAUSE_DRIVER
    assert said in ended.end_reason.lower()
    assert bench.joint() < 2.5


@pytest.mark.long
def test_a_stop_of_the_cell_ends_motions_as_somebody_wanted_it(bench: Bench) -> None:
    bench.connect()
    bench.mode(EXECUTE)
    id = bench.move(0.2, **{FIRST: 2.0})
    until(lambda: bench.joint() > 0.05)
    bench.alone.driver.StopCell(driver_pb2.StopCellRequest(reason="a cat"))
    ended = bench.await_end(id)
    assert (ended.phase, ended.end_cause) == (motion_pb2.MOTION_PHASE_CANCELLED, motion_pb2.END_CAUSE_CELL_STOPPED)
    assert ended.end_reason == "a cat"
    until(lambda: bench.status.state == INACTIVE)
    assert bench.status.mode == SIMULATED
    assert aspect(refusal(lambda: bench.move(**{FIRST: 0.0}))) == "cell"
    bench.alone.driver.ReleaseCell(driver_pb2.ReleaseCellRequest())
    assert not bench.cell.stopped
    refused = refusal(lambda: bench.move(**{FIRST: 0.0}))
    assert aspect(refused) == "mode"
    assert "it does not follow: a cat; let it follow again with mode EXECUTE" in refused.message
    bench.mode(MONITOR)
    assert not bench.status.halted


@pytest.mark.long
def test_a_lost_lease_stops_the_robot(bench: Bench) -> None:
    bench.connect()
    bench.mode(EXECUTE)
    id = bench.move(0.05, **{FIRST: 2.0})
    until(lambda: bench.joint() > 0.0)
    bench.holder.told.cancel()
    ended = bench.await_end(id)
    assert ended.end_cause == motion_pb2.END_CAUSE_LEASE_EXPIRED
    until(lambda: bench.status.state == INACTIVE)
    assert bench.status.mode == SIMULATED
    bench.holder = Holder(bench, "arm")  # pyright: ignore[reportArgumentType] what it needs of a kernel is here
    assert "nobody has leased the robot any more" in refusal(lambda: bench.move(**{FIRST: 0.0})).message
    assert aspect(refusal(lambda: bench.move(**{FIRST: 0.0}))) == "mode"


def test_a_stop_is_nobodys_before_all_reports_could_be_read(bench: Bench) -> None:
    """A host tells its fault, and stops the cell then; where it writes the next report just now, that is waited for."""
    bench.connect()
    bench.mode(EXECUTE)
    world = bench.kernel.world
    asks, hot = link.Link.fault, DriverFault("joint 3 is too hot", "C204")

    def fault(asked: link.Link, now_ns: int, block: CellBlock) -> link.Words | None:
        assert asked.report is not None
        asked.report = replace(asked.report, state=State.BEGINNING)  # the one before may be of before it was played
        return asks(asked, now_ns, block)

    with mock.patch.object(TickRing, "reported", lambda ring: None), mock.patch.object(link.Link, "fault", fault):
        for tells in (lambda: bench.process.tell(speed_scaling=0.9), lambda: bench.process.fail(hot)):
            tells()
            until(lambda tick=world.snapshot.state.tick: world.snapshot.state.tick > tick + 3)
            assert world.snapshot.state.stop is None
    until(lambda: world.snapshot.state.stop is not None)
    assert (bench.cell.stopped_by, "joint 3 is too hot" in bench.cell.reason) == ("driver sham of arm", True)
    until(lambda: bench.status.mode == SIMULATED)


def test_what_keeps_a_controller_from_being_read_is_told(bench: Bench) -> None:
    connects = ShamProcess.connect

    def fails(sham: ShamProcess) -> About:
        about = connects(sham)
        sham.fail(DriverFault("the board is silent", "E1"))
        until(lambda: (said := sham.ring.reported()) is not None and said.state is State.ERROR)
        return about

    with mock.patch.object(ShamProcess, "connect", fails):
        refused = refusal(bench.connect)
    assert (refused.reason, refused.metadata["code"]) == ("DRIVER_FAULT", "E1")
    assert "the board is silent" in refused.message


def test_words_that_come_late_are_told_all_the_same(bench: Bench) -> None:
    bench.connect()
    with mock.patch.object(link, "WORDS_SECONDS", 0.0):
        bench.process.fail(DriverFault("joint 3 is too hot", "C204"))
        until(lambda: bench.status.state == ERROR)
        until(lambda: (bench.status.text, bench.status.code) == ("joint 3 is too hot", "C204"))


@pytest.mark.parametrize(("lead", "rate", "seconds"), [(0.05, 250.0, 0.1), (0.4, 250.0, 0.4), (0.1, 10.0, 0.3)])
def test_a_host_is_silent_after_its_lead_and_three_cycles(lead: float, rate: float, seconds: float) -> None:
    """So that a busy machine is borne in both directions by one number."""
    report = mock.Mock(cycles=5, state=State.ACTIVE, is_faulty=False, safety=Safety.NORMAL, mode=Mode.RUNNING)
    report.error = report.q = np.zeros(1)
    asked = mock.Mock(lead=lead, following_warning=1.0, following_limit=1.0)
    process, ring = mock.Mock(fault=None), mock.Mock()
    ring.reported.return_value, ring.pulse.return_value = report, (5, 1, 0.0)
    one = link.Link(mock.Mock(), asked, process, ring, mock.Mock(rate=rate), state=State.ACTIVE)
    looks = 0
    while one.fault(looks * 10_000_000, mock.Mock(stop_ns=NEVER)) is None:
        looks += 1
    assert one.is_silent
    assert seconds - 1e-9 <= looks * 0.01 <= seconds + 0.03
