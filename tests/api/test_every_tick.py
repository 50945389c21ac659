"""Watches that tell every tick and every reading: none is left out, what is lost is counted, sensors read for them."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import closing, contextmanager
from typing import Any

import grpc
import numpy as np
import pytest
from virtualrobot.v1 import kernel_pb2, robot_pb2, scene_pb2, sensor_pb2

from tests.api.asking import IIWA, apply, box, create, joints, load, refusal
from tests.api.asking import start as move
from tests.api.reading import step, values
from tests.api.test_sensor import FAN, RUNNING, STOPPED, ball, sensor, start, status, stop
from tests.kernels import Stubs


@contextmanager
def states(stubs: Stubs, *names: str, **fields: Any) -> Iterator[Iterator[robot_pb2.WatchRobotStatesResponse]]:  # noqa: ANN401
    """Watch each tick of robots: yields the ticks, the first one being that of the beginning."""
    request = robot_pb2.WatchRobotStatesRequest(names=names, every_tick=True, max_rate_hertz=1e6, **fields)
    call = stubs.robot.WatchRobotStates(request, timeout=120.0)
    try:
        yield (tick for message in call for tick in message.ticks)
    finally:
        call.cancel()


def positions(stubs: Stubs) -> list[float]:
    return list(stubs.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest()).robots[0].positions)


def test_each_tick_of_a_step_is_told_with_what_changed_in_it(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    move(stepped, joints("arm", lbr_iiwa_joint_1=0.5))
    with states(stepped, "arm") as ticks:
        first = next(ticks)
        assert [state.name for state in first.robots] == ["arm"]
        step(stepped, 400)
        told = list(itertools.islice(ticks, 400))
    assert [tick.stamp.tick for tick in told] == list(range(first.stamp.tick + 1, first.stamp.tick + 401))
    assert not any(tick.lost_ticks for tick in told)
    ways = [tick.robots[0].positions[0] for tick in told if tick.robots]
    assert 50 < len(ways) < 400  # the arm rests in the end, and ticks go on
    assert all(np.diff(ways) >= 0.0) and ways[-1] == pytest.approx(0.5)
    assert list(next(tick for tick in reversed(told) if tick.robots).robots[0].positions) == positions(stepped)
    assert len({tick.stamp.state_revision for tick in told}) == 400


def test_what_is_told_of_a_tick_is_what_single_steps_answer(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    move(stepped, joints("arm", lbr_iiwa_joint_2=0.4))
    with states(stepped) as ticks:
        next(ticks)
        answers = [stepped.kernel.StepClock(kernel_pb2.StepClockRequest(ticks=1)) for _ in range(20)]
        told = list(itertools.islice(ticks, 20))
    for tick, answer in zip(told, answers, strict=True):
        assert tick.stamp.tick == answer.stamp.tick
        assert not tick.robots or tick.robots[0] == answer.robots[0]


def test_a_change_between_two_ticks_is_told_where_time_is_stepped(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    put = scene_pb2.SetJointPositions(robot="arm", joint_positions={"lbr_iiwa_joint_1": 0.25})
    with states(stepped) as ticks:
        first = next(ticks)
        apply(stepped, scene_pb2.Command(set_joint_positions=put))
        told = next(ticks)
    assert (told.stamp.tick, told.robots[0].positions[0]) == (first.stamp.tick, 0.25)


def test_in_real_time_no_tick_is_left_out(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    move(stubs, joints("arm", lbr_iiwa_joint_1=0.5))
    with states(stubs, "arm") as ticks:
        told = list(itertools.islice(ticks, 101))
    steps = np.diff([tick.stamp.tick for tick in told])
    assert steps.tolist() == [1 + tick.lost_ticks for tick in told[1:]]
    assert not any(tick.lost_ticks for tick in told)


def test_each_tick_of_the_scene_is_told(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    apply(stepped, create(box("cube", x=1.0)))
    move(stepped, joints("arm", lbr_iiwa_joint_1=0.5))
    request = scene_pb2.WatchSceneRequest(names=["arm.lbr_iiwa_link_3"], every_tick=True, max_rate_hertz=1e6)
    call = stepped.scene.WatchScene(request, timeout=60.0)
    ticks = (tick for message in call for tick in message.ticks)
    first = next(ticks)
    assert [node.name for node in first.nodes] == ["arm.lbr_iiwa_link_3"]
    step(stepped, 50)
    told = list(itertools.islice(ticks, 50))
    call.cancel()
    assert [tick.stamp.tick - first.stamp.tick for tick in told] == list(range(1, 51))
    assert all(list(tick.moved_uids) == list(first.moved_uids) for tick in told)
    scene = stepped.scene.GetScene(scene_pb2.GetSceneRequest(names=["arm.lbr_iiwa_link_3"]))
    np.testing.assert_array_equal(values(told[-1].world_t_node), values(scene.world_t_node))


@pytest.mark.long
def test_what_a_slow_reader_loses_is_counted(stepped: Stubs) -> None:
    """Of each tick there is a message or it is counted, however late its reader is."""
    with states(stepped) as ticks:
        first = next(ticks)
        for _ in range(3):
            step(stepped, 9000)
        count, tick = 0, first
        while tick.stamp.tick < first.stamp.tick + 27_000:
            tick = next(ticks)
            count += 1 + tick.lost_ticks
    assert count == 27_000


def test_a_watch_without_every_tick_goes_on_as_before(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    call = stepped.robot.WatchRobotStates(robot_pb2.WatchRobotStatesRequest(), timeout=60.0)
    first = next(call)
    call.cancel()
    assert [state.name for state in first.robots] == ["arm"] and not first.ticks


class Readings:
    """Readings that a watch tells, one by one."""

    def __init__(self, stubs: Stubs, **fields: Any) -> None:  # noqa: ANN401 fields of the request
        """Begin to watch; the kernel watches when this returns."""
        request = sensor_pb2.WatchReadingsRequest(**fields)
        self._call = stubs.sensor.WatchReadings(request, timeout=60.0)
        assert not next(self._call).readings
        self.told = (reading for message in self._call for reading in message.readings)

    def next(self, count: int) -> list[sensor_pb2.SensorReading]:
        return list(itertools.islice(self.told, count))

    def close(self) -> None:
        self._call.cancel()


def test_a_sensor_reads_while_it_is_watched_and_each_reading_is_told(stepped: Stubs) -> None:
    apply(stepped, ball(), sensor(pattern=FAN, rate_hertz=50.0))
    with closing(Readings(stepped, sensors=["lidar"], every_reading=True, run=True)) as watch:
        step(stepped, 500)
        told = watch.next(100)
        assert [one.number for one in told] == list(range(1, 101))
        assert not any(one.lost or one.missed for one in told)
        assert status(stepped).state == RUNNING
        scene = stepped.scene.GetScene(scene_pb2.GetSceneRequest(names=["lidar"]))
        assert not scene.nodes[0].range_sensor.running  # it is no change of the world
    assert until_state(stepped, STOPPED)


def test_a_sensor_that_was_watched_before_tells_its_first_readings_again(stepped: Stubs) -> None:
    apply(stepped, ball(), sensor(pattern=FAN, rate_hertz=50.0))
    for _ in range(2):
        with closing(Readings(stepped, sensors=["lidar"], every_reading=True, run=True)) as watch:
            step(stepped, 60)
            told = [one for one in watch.next(11) if one.state == RUNNING]
            assert [one.number for one in told][:10] == list(range(1, 11))
        assert until_state(stepped, STOPPED)


def until_state(stubs: Stubs, state: int) -> bool:
    """Return whether a sensor comes into a state: what a cancelled call ends is done soon after it."""
    return any(status(stubs).state == state for _ in range(1000))


def test_a_sensor_that_was_started_goes_on_after_a_watch_and_two_watches_hold_it(stepped: Stubs) -> None:
    apply(stepped, ball(), sensor(pattern=FAN, rate_hertz=50.0))
    first = Readings(stepped, sensors=["lidar"], run=True)
    second = Readings(stepped, sensors=["lidar"], run=True)
    step(stepped, 10)
    first.close()
    step(stepped, 10)
    assert [one.number for one in second.next(2)][-1] <= 4
    assert status(stepped).state == RUNNING
    start(stepped, "lidar")  # while it is watched: its readings go on to be counted
    step(stepped, 10)
    second.close()
    step(stepped, 10)
    assert status(stepped).readings == 8 and status(stepped).state == RUNNING
    stop(stepped, "lidar")
    assert status(stepped).state == STOPPED


def test_a_watch_that_has_sensors_read_names_them(stepped: Stubs) -> None:
    def watch(**fields: Any) -> object:  # noqa: ANN401
        return next(stepped.sensor.WatchReadings(sensor_pb2.WatchReadingsRequest(**fields), timeout=60.0))

    said = refusal(lambda: watch(run=True))
    assert (said.code, said.metadata["field"]) == (grpc.StatusCode.INVALID_ARGUMENT, "sensors")
    assert refusal(lambda: watch(run=True, sensors=["radar"])).reason == "UNKNOWN_NAME"
