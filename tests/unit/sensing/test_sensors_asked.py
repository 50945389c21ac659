"""Single readings of sensors: who stays ready, who is answered, who waits."""

from __future__ import annotations

import threading
import time

import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.sensing import sensors as module
from virtualrobot_kernel.sensing.cpu_slots import CpuSlots
from virtualrobot_kernel.sensing.readers import READERS
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.world.commands import CreateNodes, UpdateNode
from virtualrobot_kernel.world.sensing import MotionSensor, PoseSensor, RangeSensor
from virtualrobot_kernel.world.structure import Kind, NodeSpec

from tests.unit.sensing.bench import GUARD, Bench, Fake


def test_of_sensors_that_do_not_run_only_some_stay_ready(bench: Bench) -> None:
    count = module.MOST_IDLE + 10
    for i in range(count):
        bench.add(f"s{i}")
    for i in range(count):
        bench.sensors.read(f"s{i}")[1].result(GUARD)
    assert len(bench.sensors.workers) == module.MOST_IDLE
    assert bench.made[9][1].closed.wait(GUARD)
    assert not bench.made[10][1].closed.is_set()
    assert bench.sensors.read("s0")[1].result(GUARD).number == 2


def test_who_asks_is_answered_where_the_sensor_is_changed_while_its_reader_cannot_be_made(bench: Bench) -> None:
    going, go_on = threading.Event(), threading.Event()

    def fail() -> Fake:
        going.set()
        go_on.wait(GUARD)
        raise KernelError("there is no such component")

    bench.next["a"] = fail
    bench.add("a")
    coming = bench.sensors.read("a")[1]
    assert going.wait(GUARD)
    bench.do(UpdateNode("a", data=RangeSensor(seed=3)))
    go_on.set()
    with pytest.raises(KernelError, match="'a' was changed or removed meanwhile"):
        coming.result(GUARD)


def test_what_waits_for_its_turn_is_not_late(bench: Bench) -> None:
    going, go_on = threading.Event(), threading.Event()

    def slow(moment: Moment) -> None:
        going.set()
        go_on.wait(GUARD)

    bench.next["a"] = lambda: Fake(act=slow, deadline_seconds=0.0)
    bench.next["b"] = lambda: Fake(act=slow)
    bench.add("a")
    bench.add("b")
    for name, late in (("a", True), ("b", False)):
        going.clear()
        worker, coming = bench.sensors.read(name)
        assert going.wait(GUARD)
        assert worker.is_late() == late
        go_on.set()
        coming.result(GUARD)
        assert not worker.is_late()
        go_on.clear()


def test_motion_sensors_take_turns_of_their_own(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    going, go_on = threading.Event(), threading.Event()
    at_work: list[None] = []
    most: list[int] = []

    def hold(moment: Moment) -> None:
        going.set()
        go_on.wait(GUARD)

    def note(moment: Moment) -> None:
        at_work.append(None)
        most.append(len(at_work))
        time.sleep(0.002)
        at_work.pop()

    monkeypatch.setitem(READERS, Kind.MOTION_SENSOR, lambda *_: Fake(act=note, takes_turns=True))
    bench.next["picture"] = lambda: Fake(act=hold, takes_turns=True)
    bench.add("picture")
    data = MotionSensor(PoseSensor())
    bench.do(CreateNodes(tuple(NodeSpec(f"m{i}", Kind.MOTION_SENSOR, "world", data=data) for i in range(8))))
    picture = bench.sensors.read("picture")[1]
    assert going.wait(GUARD)
    for one in [bench.sensors.read(f"m{i % 8}")[1] for i in range(24)]:
        one.result(GUARD)
    assert not picture.done()
    assert max(most) <= module.MOST_SHORT
    go_on.set()
    picture.result(GUARD)


def test_quick_sensors_wait_behind_no_picture(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """A lidar beside a camera reads at its own rate: in the middle of a picture it has turns of its own."""
    take = CpuSlots.take
    monkeypatch.setattr(CpuSlots, "take", lambda self: take(self, 10.0 * GUARD))  # nobody loses patience
    going, go_on = threading.Event(), threading.Event()

    def hold(moment: Moment) -> None:
        going.set()
        go_on.wait(GUARD)

    bench.next["lidar"] = Fake
    bench.next["camera"] = lambda: Fake(act=hold)
    bench.add("lidar", running=True)
    bench.add("camera")
    bench.world.step(25).result(GUARD)  # a reading of 10 Hz: how long it takes is known from now on
    pictures = [bench.sensors.read("camera")[1]]
    assert going.wait(GUARD)
    bench.world.step(250).result(GUARD)  # it waits for each reading of the lidar, and never for the picture
    assert not pictures[0].done()
    numbers = [reading.number for reading in bench.told if reading.name == "lidar"]
    assert numbers == list(range(1, 12))
    go_on.set()
    pictures[0].result(GUARD)
