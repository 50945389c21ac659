"""Many sensors on moving robots: nothing is lost or drifts, equal runs give equal bits, slow readers get the latest."""

from __future__ import annotations

import math
from contextlib import closing

import numpy as np
import pytest
from virtualrobot.v1 import scene_pb2, sensing_pb2, sensor_pb2

from tests.api.asking import IIWA, apply, joints, load
from tests.api.asking import start as move
from tests.api.reading import matrix, step, values
from tests.api.test_sensor import RUNNING, Watch, ball, latest, place, sensor, start, status, stop, tick
from tests.kernels import EMPTY_SCENE, Stubs

LINKS = [f"lbr_iiwa_link_{i}" for i in range(3, 8)]
SPINNING = sensing_pb2.ScanPattern(
    spinning=sensing_pb2.Spinning(columns=90, elevations_radians=[math.radians(e) for e in (-10, 0, 10)])
)
FAN = sensing_pb2.ScanPattern(
    fan=sensing_pb2.Fan(count=181, start_angle_radians=-math.pi / 2, end_angle_radians=math.pi / 2)
)
RATES = (10.0, 30.0, 7.0, 50.0, 100.0)
KINDS = (
    {"pattern": FAN, "sensor_model": "laser"},
    {"pattern": SPINNING, "motion_distortion": True, "sensor_model": "laser"},
    {"preset": "HC-SR04"},
    {"preset": "URG-04LX"},
    {"pattern": SPINNING},
)


def cell(stubs: Stubs) -> list[str]:
    """Make two arms with five sensors each, whose rates are those of RATES; return the sensors."""
    names = []
    for robot, y in (("left", 0.6), ("right", -0.6)):
        load(stubs, IIWA, robot, parent_t_node=place(0.0, y, 0.0))
        for i, (link, rate, kind) in enumerate(zip(LINKS, RATES, KINDS, strict=True)):
            name = f"{robot}-{i}"
            fields = {**kind, "rate_hertz": rate, "seed": i, "max_range_meters": 5.0}
            apply(stubs, sensor(name, f"{robot}.{link}", place(z=0.3), **fields))
            names.append(name)
    apply(stubs, ball(x=1.2))
    return names


def swing(stubs: Stubs, sign: float = 1.0) -> None:
    """Let both arms move for two seconds and more."""
    for robot in ("left", "right"):
        goals = {f"lbr_iiwa_joint_{i}": sign * 0.9 for i in range(1, 8)}
        move(stubs, joints(robot, 0.3, **goals))


@pytest.mark.long
def test_ten_sensors_on_moving_robots_lose_nothing_and_do_not_drift(stepped: Stubs) -> None:
    names = cell(stepped)
    swing(stepped)
    start(stepped)
    began = tick(stepped)
    with closing(Watch(stepped, sensor_pb2.WatchReadingsRequest())) as watch:
        seen: dict[str, list[tuple[int, int]]] = {name: [] for name in names}
        for _ in range(25):
            step(stepped, 20)
            for reading in latest(stepped):
                seen[reading.sensor].append((reading.number, reading.stamp.tick - began))
        assert watch.next()
    for name, rate in zip(names, RATES * 2, strict=True):
        told = status(stepped, name)
        assert (told.state, told.missed, told.readings) == (RUNNING, 0, int(500 * 0.004 * rate + 1e-9)), told
        assert all(due == math.ceil(k * 250.0 / rate - 1e-9) for k, due in seen[name])
    scene = stepped.scene.GetScene(scene_pb2.GetSceneRequest(names=names))
    poses = dict(zip(names, values(scene.world_t_node), strict=True))
    for reading in latest(stepped):
        if reading.stamp.tick == scene.stamp.tick:
            np.testing.assert_allclose(matrix(reading.world_t_sensor)[:3, 3], poses[reading.sensor][:3], atol=1e-12)
            moved = True
    assert moved


def run(stubs: Stubs) -> list[bytes]:
    """Return what ten sensors say on moving robots, without what tells when."""
    stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text=EMPTY_SCENE))
    cell(stubs)
    swing(stubs)
    start(stubs)
    said = []
    for _ in range(10):
        step(stubs, 15)
        for reading in sorted(latest(stubs, intensities=True, elements=True, points=True), key=lambda one: one.sensor):
            reading.ClearField("stamp")
            said.append(reading.SerializeToString(deterministic=True))
    return said


def test_two_runs_give_equal_bits(stepped: Stubs) -> None:
    first = run(stepped)
    assert len(first) > 80
    assert run(stepped) == first


def test_in_real_time_each_reading_is_of_its_tick_and_what_is_left_out_is_counted(stubs: Stubs) -> None:
    names = cell(stubs)
    swing(stubs)
    start(stubs)
    seen: dict[str, list[tuple[int, int]]] = {name: [] for name in names}
    with closing(Watch(stubs, sensor_pb2.WatchReadingsRequest())) as watch:
        while min(map(len, seen.values())) < 5:
            for reading in watch.next():
                assert reading.state == RUNNING, reading.fault
                seen[reading.sensor].append((reading.number + reading.missed, reading.stamp.tick))
    stop(stubs)
    for name, rate in zip(names, RATES * 2, strict=True):
        # One tick is the start of all: the due ticks of every reading lead back to it.
        first = {due - math.ceil(k * 250.0 / rate - 1e-9) for k, due in seen[name]}
        assert len(first) == 1, (name, seen[name])


def test_a_slow_reader_gets_the_latest(stepped: Stubs) -> None:
    apply(stepped, ball(), sensor(preset="VLP-16", rate_hertz=250.0, sensor_model="ideal", running=True))
    request = sensor_pb2.WatchReadingsRequest(options=sensor_pb2.ReadingOptions(points=True))
    with closing(Watch(stepped, request)) as slow, closing(Watch(stepped, request)):  # the other never reads
        step(stepped, 1)
        assert [one.number for one in slow.next()] == [1]
        step(stepped, 200)
        assert status(stepped).readings == 201
        numbers = []
        while not numbers or numbers[-1] < 201:
            numbers += [one.number for one in slow.next()]
    assert numbers == sorted(set(numbers))
    assert len(numbers) < 100
    stop(stepped)
