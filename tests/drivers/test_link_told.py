"""Links of robots over the wire: what is told of them, with a far side that the test plays."""

from __future__ import annotations

from dataclasses import replace
from itertools import groupby, pairwise
from typing import Any
from unittest import mock

import numpy as np
import pytest
from virtualrobot.v1 import driver_pb2, geometry_pb2, scene_pb2, signal_pb2
from virtualrobot_kernel.drivers.played import GUARDED, STOOD, WHOLE, Played
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.world.history_commands import PlayedTicks
from virtualrobot_sdk.drivers import DriverFault

from tests.api.asking import IIWA, load
from tests.api.leasing import Holder
from tests.api.streaming import Sender
from tests.drivers.bench import ERROR, EXECUTE, FIRST, MONITOR, SIMULATED, Bench
from tests.waiting import until


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


def test_a_driver_ends_with_its_robot_and_the_next_one_connects(bench: Bench) -> None:
    """Of a robot that is removed no signal stays, and another of its name has a driver of its own."""

    def there() -> set[str]:
        return {name for name in bench.kernel.world.snapshot.state.signals if name.startswith("arm.")}

    for inputs in (0, 2):
        bench.connect()
        bench.mode(MONITOR)
        bench.process.report = replace(bench.process.report, inputs=inputs)
        connected = there()
        bench.holder.apply(scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="arm")))
        until(lambda: not there())
        until(lambda: bench.process.ended)
        assert not bench.alone.driver.GetDrivers(driver_pb2.GetDriversRequest()).drivers
        load(bench.alone, IIWA, "arm")
        bench.holder = Holder(bench, "arm")  # pyright: ignore[reportArgumentType] what it needs of a kernel is here
        assert len(connected) == 4


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
    played.reached(107)
    played.reached(-1)
    assert played.take() == [PlayedTicks(7, 101, 104, STOOD), PlayedTicks(7, 105, 107, WHOLE)]
    played.reached(120)
    assert played.take() == [
        PlayedTicks(7, 108, 110, WHOLE),
        PlayedTicks(7, 111, 114, STOOD),
        PlayedTicks(7, 115, 120, GUARDED),
    ]
    assert played.take() == []
