"""Links of robots over the wire, with a far side that the test plays: what is let in, what stops, what is told."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any
from unittest import mock

import grpc
import numpy as np
import pytest
from virtualrobot.v1 import (
    collision_pb2,
    driver_pb2,
    geometry_pb2,
    history_pb2,
    kernel_pb2,
    motion_pb2,
    scene_pb2,
    signal_pb2,
)
from virtualrobot_kernel.drivers import link
from virtualrobot_kernel.drivers.played import GUARDED, STOOD, WHOLE, Played
from virtualrobot_kernel.kernel import Kernel
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.world.commands import PlayedTicks
from virtualrobot_sdk.drivers import About, DriverFault, Mode, Safety
from virtualrobot_sdk.drivers.shared import State

from tests.api.asking import IIWA, Refusal, apply, box, create, joints, load, refusal
from tests.api.leasing import Holder
from tests.api.streaming import Sender
from tests.drivers.sham_site import ShamProcess, ShamSite
from tests.inside import kernel_inside
from tests.kernels import Stubs

GUARD = collision_pb2.COLLISION_MODE_GUARD
EXECUTE, MONITOR = driver_pb2.DRIVER_MODE_EXECUTE, driver_pb2.DRIVER_MODE_MONITOR
SIMULATED = driver_pb2.DRIVER_MODE_SIMULATED
ACTIVE, INACTIVE = driver_pb2.DRIVER_STATE_ACTIVE, driver_pb2.DRIVER_STATE_INACTIVE
ERROR = driver_pb2.DRIVER_STATE_ERROR
FIRST = "lbr_iiwa_joint_1"
PATIENCE_SECONDS = 60.0


class Bench:
    """A kernel whose time follows the wall clock, with a guarded arm, and a client that has leased it."""

    def __init__(self, kernel: Kernel, address: str, site: ShamSite) -> None:
        """Set it up."""
        self.kernel, self.address, self.site = kernel, address, site
        self.alone = self.stubs()
        load(self.alone, IIWA, "arm")
        self.guard(GUARD)
        self.clock(kernel_pb2.CLOCK_MODE_REALTIME)
        self.holder = Holder(self, "arm")  # pyright: ignore[reportArgumentType] what it needs of a kernel is here

    def stubs(self) -> Stubs:
        """Return stubs on a channel of their own."""
        return Stubs(grpc.insecure_channel(self.address))

    def guard(self, mode: collision_pb2.CollisionMode) -> None:
        """Set the collision mode."""
        apply(self.alone, scene_pb2.Command(set_collision_settings=collision_pb2.SetCollisionSettings(mode=mode)))

    def clock(self, mode: kernel_pb2.ClockMode, factor: float = 0.0) -> None:
        """Set the clock."""
        self.alone.kernel.SetClock(kernel_pb2.SetClockRequest(mode=mode, speed_factor=factor))

    def call(self, name: str, **fields: Any) -> Any:  # noqa: ANN401 any answer
        """Make a call of the driver's service with the lease."""
        request = getattr(driver_pb2, f"{name}Request")(**fields)
        return getattr(self.holder.stubs.driver, name)(request, metadata=self.holder.metadata)

    def connect(self, **fields: Any) -> driver_pb2.DriverStatus:  # noqa: ANN401 any field
        """Connect a sham."""
        return self.call("ConnectDriver", **{"robot": "arm", "component": "sham", **fields}).driver

    def mode(self, mode: driver_pb2.DriverMode) -> Any:  # noqa: ANN401 the answer
        """Choose the mode."""
        return self.call("SetDriverMode", robot="arm", mode=mode)

    def move(self, speed: float = 1.0, **positions: float) -> str:
        """Start a move with the lease."""
        return self.holder.start(joints("arm", speed, **positions))

    @property
    def process(self) -> ShamProcess:
        """The newest sham."""
        return self.site.processes[-1]

    @property
    def status(self) -> driver_pb2.DriverStatus:
        """The driver as it is told."""
        return self.alone.driver.GetDrivers(driver_pb2.GetDriversRequest()).drivers[0]

    @property
    def cell(self) -> driver_pb2.CellStatus:
        """The cell as it is told."""
        return self.alone.driver.GetDrivers(driver_pb2.GetDriversRequest()).cell

    def motion(self, id: str) -> motion_pb2.Motion:
        """Return a motion as it is."""
        return self.alone.motion.GetMotion(motion_pb2.GetMotionRequest(id=id)).motion

    def await_end(self, id: str) -> motion_pb2.Motion:
        """Return a motion once it has ended."""
        until(lambda: bool(self.motion(id).end_cause) or self.motion(id).phase == motion_pb2.MOTION_PHASE_SUCCEEDED)
        until(lambda: not self.kernel.world.snapshot.state.motions)
        return self.motion(id)

    def joint(self, name: str = FIRST) -> float:
        """Return where a joint of the twin is."""
        now = self.kernel.world.snapshot
        return float(now.state.q[now.structure.robot("arm")[1].coordinates[name].q])


def pose(x: float) -> geometry_pb2.Pose:
    """Return a pose that only shifts."""
    return geometry_pb2.Pose(position=geometry_pb2.Vector3(x=x))


def until(holds: Callable[[], bool]) -> None:
    """Wait until something holds; fail where it never does."""
    end = time.monotonic() + PATIENCE_SECONDS
    while not holds():
        assert time.monotonic() < end, "it never came to be"
        time.sleep(0.005)


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    """Give a bench of its own."""
    site = ShamSite(tmp_path)
    with (
        mock.patch("virtualrobot_kernel.kernel.DriverSite", lambda *_: site),
        mock.patch.object(link, "SILENT_SECONDS", PATIENCE_SECONDS),  # shams wait for the interpreter's lock
        kernel_inside() as (kernel, address),
    ):
        yield Bench(kernel, address, site)


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


@pytest.mark.long
def test_the_twin_is_first_put_to_where_the_robot_stands(bench: Bench) -> None:
    bench.connect()
    bench.process.stands = np.full(7, 0.2)
    until(lambda: list(bench.status.positions) == [0.2] * 7)
    assert bench.mode(EXECUTE).twin_moved == [0.2] * 7
    assert bench.joint() == 0.2
    np.testing.assert_allclose(bench.process.stands, 0.2)


def test_who_watches_the_scene_is_told_where_twin_and_robot_are_apart(bench: Bench) -> None:
    """The ghost is where the real robot is, and where motions command it once its readings are the twin's."""
    bench.connect()
    changes = bench.alone.scene.WatchScene(scene_pb2.WatchSceneRequest(names=["arm.lbr_iiwa_link_1"]))
    assert not next(changes).HasField("twin_ghosts")
    bench.process.stands = np.array([0.5, *np.zeros(6)])

    def told() -> tuple[list[str], list[float], list[float]]:
        """Return kinds, and by how much the ghost's first link is turned, as far as it was told; then the link's."""
        message = next(one for one in changes if one.HasField("twin_ghosts"))
        kinds = [scene_pb2.TwinGhostKind.Name(one.kind).rpartition("_")[2] for one in message.twin_ghosts.ghosts]
        assert all(len(one.node_uids) == 1 for one in message.twin_ghosts.ghosts)
        return kinds, [turn_of(one.world_t_node) for one in message.twin_ghosts.ghosts], [bench.joint()]

    assert told() == (["MEASURED"], [pytest.approx(0.5)], [0.0])
    bench.mode(MONITOR)
    until(lambda: bench.joint() == 0.5)
    kinds, turns, _ = told()
    while kinds != ["COMMANDED"]:  # the reading is the twin's a tick after the mode has changed
        kinds, turns, _ = told()
    assert turns == [pytest.approx(0.0)]
    bench.process.stands = np.zeros(7)
    assert told()[0] == []
    changes.cancel()


def turn_of(pose: geometry_pb2.NumericArray) -> float:
    """Return by how much a single pose is turned about z."""
    *_, z, w = np.frombuffer(pose.data).tolist()
    return float(2.0 * np.arctan2(z, w))


def aspect(refused: Refusal) -> str:
    assert refused.reason == "WRONG_STATE", refused
    return refused.metadata["aspect"]


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
    assert bench.cell.stopped
    assert aspect(refusal(lambda: bench.mode(EXECUTE))) == "state"
    refused = refusal(lambda: bench.call("ResetDriver", robot="arm"))
    assert (refused.reason, refused.metadata["clears"]) == ("DRIVER_FAULT", "False")
    bench.connect()  # anew, once somebody has seen to it
    assert aspect(refusal(lambda: bench.mode(EXECUTE))) == "cell"
    bench.call("ReleaseCell")
    where = bench.joint()
    assert bench.mode(EXECUTE).driver.state == ACTIVE
    assert bench.joint() != where, "the new sham stands at 0, and the twin is put there"


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
        sham.rate = 1.0
        sham.report = replace(sham.report, on_brake=True)
        until(lambda: (seen := sham.ring.reported()) is not None and seen.on_brake)
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
    bench.alone.driver.ReleaseCell(driver_pb2.ReleaseCellRequest())
    assert not bench.cell.stopped


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


@pytest.mark.long
def test_a_monitored_robot_moves_its_twin_and_the_planned_one_stands_beside_it(bench: Bench) -> None:
    bench.connect()
    bench.mode(MONITOR)
    bench.process.stands = np.full(7, 0.1)
    until(lambda: bench.joint() == 0.1)
    now = bench.kernel.world.snapshot
    assert now.state.commanded[now.structure.robot("arm")[0].uid].q[0] == 0.0
    bench.process.stands = np.array([np.nan] + [0.0] * 6)
    bench.process.stands = np.full(7, 0.3)
    until(lambda: bench.joint() == 0.3)
    assert not np.isnan(bench.kernel.world.snapshot.state.q).any()
    bench.mode(SIMULATED)
    assert not bench.kernel.world.snapshot.state.commanded
    assert bench.joint() == 0.3


@pytest.mark.long
def test_controllers_inputs_and_outputs_are_signals(bench: Bench) -> None:
    bench.connect()
    bench.process.report = replace(bench.process.report, inputs=2)

    def value(name: str) -> object:
        return bench.kernel.world.snapshot.state.signals[name].value

    until(lambda: value("arm.di1") is True)
    assert value("arm.di0") is False
    bench.mode(EXECUTE)
    command = scene_pb2.SetSignal(name="arm.do1")
    command.value.boolean = True
    bench.holder.apply(scene_pb2.Command(set_signal=command))
    until(lambda: bool(bench.process.outputs) and bench.process.outputs[-1] == 2)


def test_signals_of_a_controller_go_with_it_and_no_others(bench: Bench) -> None:
    """Those that were there before stay, and so do all while a connection is in ERROR and is made anew."""
    own = signal_pb2.Signal(name="arm.di0", direction=signal_pb2.SIGNAL_DIRECTION_INPUT, owner="arm")
    own.value.boolean = False
    bench.holder.apply(scene_pb2.Command(create_signal=scene_pb2.CreateSignal(signal=own)))
    bench.connect()

    def there() -> set[str]:
        return {name for name in bench.kernel.world.snapshot.state.signals if name.startswith("arm.")}

    connected = there()
    assert {"arm.di1", "arm.do0", "arm.do1"} < connected
    bench.process.fail(DriverFault("the cable is out"))
    until(lambda: bench.status.state == ERROR)
    assert there() == connected
    bench.connect()
    assert there() == connected
    bench.call("DisconnectDriver", robot="arm")
    assert there() == {"arm.di0"}


@pytest.mark.long
def test_what_was_played_stands_in_the_journal_with_its_check(bench: Bench) -> None:
    noted: list[PlayedTicks] = []
    submit = bench.kernel.world.submit

    def told(commands: Any, *args: Any, **named: Any) -> Any:  # noqa: ANN401 as they come
        noted.extend(one for one in commands if isinstance(one, PlayedTicks))
        return submit(commands, *args, **named)

    def checks() -> list[str]:
        return [check for check, _ in groupby(one.check for one in noted)]

    with mock.patch.object(bench.kernel.world, "submit", told):
        bench.connect()
        bench.mode(EXECUTE)
        until(lambda: checks() == [STOOD])
        bench.await_end(bench.move(1.0, **{FIRST: 0.1}))
        until(lambda: checks() == [STOOD, WHOLE, STOOD])
        stream = Sender(bench.holder.stubs, metadata=bench.holder.metadata)
        stream.give(0.1)
        stream.end()
        stream.rest()
        until(lambda: checks() == [STOOD, WHOLE, STOOD, GUARDED, STOOD])
        bench.mode(SIMULATED)
    assert all(one.last + 1 == later.first for one, later in pairwise(noted))
    assert all((one.last - one.first) * 0.004 < 2.0 for one in noted)


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


@pytest.mark.parametrize(("lead", "rate", "seconds"), [(0.05, 250.0, 0.1), (0.4, 250.0, 0.4), (0.1, 10.0, 0.3)])
def test_a_host_is_silent_after_its_lead_and_three_cycles(lead: float, rate: float, seconds: float) -> None:
    """So that a busy machine is borne in both directions by one number."""
    report = mock.Mock(cycles=5, state=State.ACTIVE, is_faulty=False, safety=Safety.NORMAL, mode=Mode.RUNNING)
    report.error = report.q = np.zeros(1)
    asked = mock.Mock(lead=lead, following_warning=1.0, following_limit=1.0)
    process, ring = mock.Mock(fault=None), mock.Mock()
    ring.reported.return_value = report
    one = link.Link(mock.Mock(), asked, process, ring, mock.Mock(rate=rate), state=State.ACTIVE)
    looks = 0
    while one.fault(looks * 10_000_000, False) is None:
        looks += 1
    assert one.is_silent
    assert seconds - 1e-9 <= looks * 0.01 <= seconds + 0.03


def test_ranges_that_were_played_are_those_of_the_twins_ticks() -> None:
    """The robot is a lead later; what an open program does stays guarded, though it is closed."""
    played, still = Played(7, 100), mock.Mock(motions=())
    run = mock.Mock(spec=ProgramRun, program=mock.Mock(open=False))
    whole = mock.Mock(id="one", robots=(7,), running=run, nodes=frozenset(), searcher=0)
    open_run = mock.Mock(spec=ProgramRun, program=mock.Mock(open=True))
    first, later = (mock.Mock(id="two", robots=(7,), running=r, nodes=frozenset(), searcher=0) for r in (open_run, run))
    other = mock.Mock(id="three", robots=(8,), running=mock.Mock(), nodes=frozenset(), searcher=0)
    for tick, motions in ((101, ()), (105, (whole,)), (110, (other,)), (115, (first,)), (118, (later, other))):
        still.tick, still.motions = tick, motions
        played.twin_at(still)
    assert played.take() == []
    played.reached(107.6)
    played.reached(-1)
    assert played.waiting == 7
    assert played.take() == [PlayedTicks(7, 101, 104, STOOD), PlayedTicks(7, 105, 107, WHOLE)]
    played.reached(120)
    assert played.take() == [
        PlayedTicks(7, 108, 110, WHOLE),
        PlayedTicks(7, 111, 114, STOOD),
        PlayedTicks(7, 115, 120, GUARDED),
    ]
    assert played.take() == []


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
