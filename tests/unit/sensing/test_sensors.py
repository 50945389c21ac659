"""The loop of all sensors: what is due, who waits, what a fault or a hang does; with readers made for the test."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from dataclasses import replace

import pytest
from virtualrobot_kernel.background import NICENESS
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.sensing import sensors as module
from virtualrobot_kernel.sensing.reading import Moment, SensorState
from virtualrobot_kernel.sensing.schedule import Schedule
from virtualrobot_kernel.world.clock import Mode
from virtualrobot_kernel.world.commands import CreateNodes, RemoveNode, RunSensors, UpdateNode
from virtualrobot_kernel.world.figures import Figure, Sphere
from virtualrobot_kernel.world.sensing import RangeSensor
from virtualrobot_kernel.world.state import SensorStart
from virtualrobot_kernel.world.structure import Kind, NodeSpec

from tests.unit.sensing.bench import GUARD, Bench, Fake

STOPPED, RUNNING, FAULT = SensorState.STOPPED, SensorState.RUNNING, SensorState.FAULT


def test_each_reading_is_of_the_first_tick_at_or_after_its_time() -> None:
    """At 30 Hz and 4 ms: ceil(k 250 / 30) ticks after the start, 3 million readings later too."""
    schedule = Schedule(100, 250 / 30)
    assert [tick for tick in range(100, 200) if schedule.due(tick)] == [
        109,
        117,
        125,
        134,
        142,
        150,
        159,
        167,
        175,
        184,
        192,
    ]
    schedule.count = 0
    assert schedule.due(100 + 25_000_000) == 3_000_000
    assert (schedule.due(100 + 25_000_008), schedule.due(100 + 25_000_009)) == (0, 1)
    ten = Schedule(0, 1.0 / (10.0 * 0.004))
    assert sum(ten.due(tick) for tick in range(1, 10_001)) == 400


def test_the_step_waits_for_all_and_nothing_is_left_out(bench: Bench) -> None:
    bench.add("a", rate_hertz=100.0, running=True)
    bench.add("b", rate_hertz=30.0, running=True)
    bench.step(250)
    assert bench.numbers("a") == [(k, -(-k * 5 // 2)) for k in range(1, 101)]
    assert bench.numbers("b") == [(k, -(-k * 25 // 3)) for k in range(1, 31)]
    assert [one.missed for one in bench.told] == [0] * 130


def test_no_more_than_one_reading_a_tick(bench: Bench) -> None:
    bench.add("fast", rate_hertz=5000.0, running=True)
    bench.step(10)
    assert bench.numbers("fast") == [(k, k) for k in range(1, 11)]


def test_stop_start_and_removal(bench: Bench) -> None:
    bench.add("a", rate_hertz=250.0)
    bench.step(5)
    assert bench.state("a") == (STOPPED, "")
    bench.do(RunSensors(("a",), True))
    bench.step(2)
    bench.do(RunSensors((), True))  # it runs already: nothing changes
    bench.step(1)
    assert bench.numbers("a") == [(1, 6), (2, 7), (3, 8)]
    assert len(bench.made) == 1
    bench.do(RunSensors(("a",), False))
    bench.step(5)
    assert (bench.told[-1].state, bench.told[-1].content, len(bench.told)) == (STOPPED, None, 4)
    assert bench.made[0][1].closed.wait(GUARD)
    bench.do(RunSensors(("a",), True))
    bench.step(1)
    assert bench.numbers("a")[-1] == (1, 14)  # counted anew, by a new reader
    bench.do(RemoveNode("a"))
    assert bench.sensors.latest == {}
    assert bench.made[1][1].closed.wait(GUARD)
    bench.step(5)
    assert len(bench.told) == 5


def test_start_and_stop_are_state_and_no_structure(bench: Bench) -> None:
    """As docs/conventions.md says; what is stopped and started in one batch is started anew."""
    bench.add("a", rate_hertz=250.0)
    revision = bench.world.snapshot.structure.revision
    started = bench.do(RunSensors((), True))
    stopped = bench.do(RunSensors(("a",), False))
    assert [list(one.state.running_sensors.values()) for one in (started, stopped)] == [[SensorStart(1, 0)], []]
    again = bench.do(RunSensors(("a",), True), RunSensors(("a",), False), RunSensors(("a",), True))
    assert list(again.state.running_sensors.values()) == [SensorStart(3, 0)]
    assert again.structure.revision == revision
    bench.step(1)
    assert bench.state("a") == (RUNNING, "")


def test_a_changed_sensor_goes_on_to_count_by_a_new_reader(bench: Bench) -> None:
    bench.add("a", rate_hertz=50.0, running=True)
    bench.step(7)
    node = bench.world.snapshot.structure.node("a")
    assert isinstance(node.data, RangeSensor)
    bench.do(UpdateNode("a", data=replace(node.data, ray_caster="other")))
    bench.step(8)
    assert bench.numbers("a") == [(1, 5), (2, 10), (3, 15)]
    assert len(bench.made) == 2
    bench.do(UpdateNode("a", new_name="b"))
    bench.step(5)
    assert bench.numbers("b") == [(4, 20)]
    assert len(bench.made) == 2


def raising(moment: Moment) -> None:
    if moment.number == 2:
        raise KernelError("it broke", reason=Reason.PLUGIN_FAILED)


def test_a_fault_stays_until_the_sensor_is_started_or_changed(bench: Bench) -> None:
    bench.next["a"] = lambda: Fake(act=raising)
    bench.add("a", rate_hertz=250.0, running=True)
    bench.add("b", rate_hertz=250.0, running=True)
    bench.step(5)
    assert bench.numbers("a") == [(1, 1)]
    assert bench.state("a") == (FAULT, "it broke")
    assert [(one.state, one.fault) for one in bench.told if one.name == "a"][1:] == [(FAULT, "it broke")]
    assert len(bench.numbers("b")) == 5
    bench.do(CreateNodes((NodeSpec("box", Kind.PART),)))  # another's change is none of this sensor
    bench.step(1)
    assert bench.state("a")[0] is FAULT
    bench.do(RunSensors(("a",), True))
    bench.step(1)
    assert bench.state("a") == (RUNNING, "")
    assert bench.numbers("a")[-1] == (1, 7)


def test_a_reader_that_cannot_be_made_and_one_that_fails_inside(bench: Bench) -> None:
    def refuse() -> Fake:
        raise KernelError("no such thing")

    def divide(moment: Moment) -> None:
        _ = 1 / 0

    bench.next["a"] = refuse
    bench.next["b"] = lambda: Fake(act=divide)
    bench.add("a", running=True)
    bench.add("b", rate_hertz=250.0, running=True)
    bench.step(1)
    assert bench.state("a") == (FAULT, "no such thing")
    assert bench.state("b") == (FAULT, "it failed inside the kernel: ZeroDivisionError: division by zero")
    _, coming = bench.sensors.read("a")
    with pytest.raises(KernelError, match="no such thing"):
        coming.result(GUARD)


def test_a_hang_costs_a_deadline_and_the_step_goes_on(bench: Bench) -> None:
    forever = threading.Event()
    bench.next["a"] = lambda: Fake(deadline_seconds=0.05, act=lambda moment: forever.wait(GUARD) and None)
    bench.add("a", rate_hertz=250.0, running=True)
    bench.add("b", rate_hertz=250.0, running=True)
    bench.step(3)
    assert bench.state("a") == (FAULT, "a reading was not made within 0.05 s")
    assert len(bench.numbers("b")) == 3
    told = len(bench.told)
    forever.set()
    assert bench.made[0][1].closed.wait(GUARD)  # when it comes back at last, nobody is told
    assert len(bench.told) == told


def test_a_hang_is_noticed_where_time_follows_the_clock_too(bench: Bench) -> None:
    forever, faulted = threading.Event(), threading.Event()
    bench.sensors.subscribe(lambda reading: faulted.set() if reading is not None and reading.state is FAULT else None)
    bench.next["a"] = lambda: Fake(deadline_seconds=0.05, act=lambda moment: forever.wait(GUARD) and None)
    bench.world.set_clock(Mode.REALTIME, 1.0).result(GUARD)
    bench.add("a", rate_hertz=250.0, running=True)
    assert faulted.wait(GUARD)
    assert bench.state("a")[0] is FAULT
    forever.set()


def test_a_late_reading_is_left_out_and_counted(bench: Bench) -> None:
    busy, go = threading.Event(), threading.Event()

    def hold(moment: Moment) -> None:
        if not busy.is_set():
            busy.set()
            assert go.wait(GUARD)

    read = threading.Event()
    bench.next["a"] = lambda: Fake(act=hold)
    bench.world.set_clock(Mode.REALTIME, 1.0).result(GUARD)
    bench.add("a", rate_hertz=250.0, running=True)
    assert busy.wait(GUARD)
    began = bench.world.snapshot.state.tick
    waiting = threading.Event()
    bench.world.listen_ticks(lambda snapshot: waiting.set() if snapshot.state.tick >= began + 10 else None)
    assert waiting.wait(GUARD)
    bench.sensors.subscribe(lambda reading: read.set() if reading is not None and reading.number == 2 else None)
    go.set()
    assert read.wait(GUARD)
    first, second = bench.told[:2]
    left_out = second.snapshot.state.tick - first.snapshot.state.tick - 1
    assert left_out >= 9
    assert second.missed - first.missed == left_out


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere niceness is a whole process's")
def test_a_sensor_gives_way_once_time_does_not_wait_for_it(bench: Bench) -> None:
    found: list[int] = []

    def note(moment: Moment) -> None:
        found.append(os.getpriority(os.PRIO_PROCESS, threading.get_native_id()))

    bench.next["a"] = lambda: Fake(act=note)
    bench.add("a", rate_hertz=50.0)
    before = os.getpriority(os.PRIO_PROCESS, 0)
    for mode, niceness in ((Mode.STEPPED, before), (Mode.REALTIME, min(before + NICENESS, 19))):
        bench.world.set_clock(mode, 1.0).result(GUARD)
        bench.sensors.read("a")[1].result(GUARD)
        assert found[-1] == niceness
    assert os.getpriority(os.PRIO_PROCESS, 0) == before


def test_the_past_goes_back_as_far_as_a_reader_needs(bench: Bench) -> None:
    bench.next["a"] = lambda: Fake(history_seconds=0.1)
    bench.add("a", rate_hertz=10.0)
    bench.step(30)
    bench.add("b", rate_hertz=250.0, running=True)
    bench.do(RunSensors(("a",), True))
    bench.step(50)
    readers = dict(bench.made)
    for moment, tick in zip(readers["a"].moments, (55, 80), strict=True):
        assert moment.snapshot.state.tick == tick
        assert [one.state.tick for one in moment.history] == list(range(tick - 25, tick))
    assert {len(moment.history) for moment in readers["b"].moments} == {0}


def test_nothing_is_kept_where_nobody_needs_the_past(bench: Bench) -> None:
    bench.add("a", rate_hertz=10.0, running=True)
    bench.step(30)
    assert bench.sensors._history == ()


def test_single_readings_are_counted_by_themselves(bench: Bench) -> None:
    bench.add("a", rate_hertz=250.0)
    numbers = [bench.sensors.read("a")[1].result(GUARD).number for _ in range(2)]
    bench.do(RunSensors(("a",), True))
    bench.step(3)
    numbers.append(bench.sensors.read("a")[1].result(GUARD).number)
    assert numbers == [1, 2, 3]
    assert [number for number, _ in bench.numbers("a")] == [1, 2, 3]
    with pytest.raises(KernelError, match="no sensor named 'b'"):
        bench.sensors.read("b")


def test_noise_is_drawn_from_seed_and_number(bench: Bench) -> None:
    drawn: dict[str, list[float]] = {"a": [], "b": [], "c": []}

    def drawing(name: str) -> Callable[[], Fake]:
        return lambda: Fake(act=lambda moment: drawn[name].append(moment.rng.random()))

    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        bench.next[name] = drawing(name)
        bench.add(name, rate_hertz=250.0, running=True, seed=seed)
    bench.step(4)
    assert drawn["a"] == drawn["b"]
    assert len(set(drawn["a"] + drawn["c"])) == 8


def test_no_more_than_so_many_run_at_once(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MOST_RUNNING", 2)
    for name in "abc":
        bench.add(name, rate_hertz=250.0, running=True)
    bench.step(1)
    assert [bench.state(name)[0] for name in "abc"] == [RUNNING, RUNNING, FAULT]
    assert "2 sensors run already" in bench.state("c")[1]


@pytest.mark.parametrize("library", ["shapes", "solids"])
def test_shapes_of_figures_that_are_gone_are_forgotten(bench: Bench, library: str) -> None:
    shapes, forgotten = getattr(bench.sensors.room, library), threading.Event()
    keep = shapes.keep
    shapes.keep = lambda kept: (keep(kept), forgotten.set())
    bench.do(CreateNodes((NodeSpec("box", Kind.PART, figures=(Figure(Sphere(1.0)),)),)))
    for i in range(1, module.UNUSED_SHAPES + 2):
        shapes.get(Sphere(float(i)))
    bench.do(CreateNodes((NodeSpec("other", Kind.PART),)))
    assert forgotten.wait(GUARD)
    assert len(shapes) == 1


def test_the_end_of_the_kernel_ends_a_step_that_waits(bench: Bench) -> None:
    forever, busy = threading.Event(), threading.Event()
    bench.next["a"] = lambda: Fake(act=lambda moment: (busy.set(), forever.wait(GUARD)) and None)
    bench.add("a", rate_hertz=250.0, running=True)
    coming = bench.world.step(1)
    assert busy.wait(GUARD)
    threading.Timer(0.2, forever.set).start()
    bench.sensors.close()
    assert coming.result(GUARD).state.tick == 1
