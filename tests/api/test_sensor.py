"""SensorService: range sensors and the loop of all sensors, over the wire."""

from __future__ import annotations

from contextlib import closing
from typing import Any

import numpy as np
from virtualrobot.v1 import geometry_pb2, nodes_pb2, scene_pb2, sensing_pb2, sensor_pb2

from tests.api.asking import IIWA, apply, create, load, refusal
from tests.api.reading import step, values
from tests.api.test_scene import remove
from tests.kernels import EMPTY_SCENE, Stubs

RUNNING, STOPPED, FAULT = (
    sensor_pb2.SENSOR_STATE_RUNNING,
    sensor_pb2.SENSOR_STATE_STOPPED,
    sensor_pb2.SENSOR_STATE_FAULT,
)
FAN = sensing_pb2.ScanPattern(fan=sensing_pb2.Fan(count=3, start_angle_radians=-0.1, end_angle_radians=0.1))


def place(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> geometry_pb2.Pose:
    return geometry_pb2.Pose(position=geometry_pb2.Vector3(x=x, y=y, z=z))


def ball(name: str = "ball", x: float = 2.0, radius: float = 0.5, parent: str = "") -> scene_pb2.Command:
    figure = nodes_pb2.Figure(sphere=nodes_pb2.Sphere(radius_meters=radius))
    return create(
        nodes_pb2.Node(name=name, parent=parent, part=nodes_pb2.Part(), parent_t_node=place(x), figures=[figure])
    )


def sensor(
    name: str = "lidar",
    parent: str = "",
    at: geometry_pb2.Pose | None = None,
    **fields: Any,  # noqa: ANN401 fields of RangeSensor
) -> scene_pb2.Command:
    range_sensor = sensing_pb2.RangeSensor(**fields)
    return create(nodes_pb2.Node(name=name, parent=parent, parent_t_node=at, range_sensor=range_sensor))


def read(stubs: Stubs, name: str = "lidar", **options: Any) -> sensor_pb2.SensorReading:  # noqa: ANN401 fields of ReadingOptions
    request = sensor_pb2.ReadSensorRequest(sensor=name, options=sensor_pb2.ReadingOptions(**options))
    return stubs.sensor.ReadSensor(request, timeout=60.0).reading


def status(stubs: Stubs, name: str = "lidar") -> sensor_pb2.SensorStatus:
    told = stubs.sensor.ListSensors(sensor_pb2.ListSensorsRequest()).sensors
    return next(one for one in told if one.name == name)


def tick(stubs: Stubs) -> int:
    return stubs.sensor.ListSensors(sensor_pb2.ListSensorsRequest()).stamp.tick


def start(stubs: Stubs, *names: str) -> None:
    apply(stubs, scene_pb2.Command(start_sensors=sensor_pb2.StartSensors(sensors=names)))


def stop(stubs: Stubs, *names: str) -> None:
    apply(stubs, scene_pb2.Command(stop_sensors=sensor_pb2.StopSensors(sensors=names)))


def latest(stubs: Stubs, *names: str, **options: Any) -> list[sensor_pb2.SensorReading]:  # noqa: ANN401 fields of ReadingOptions
    """Return what a watch tells at first."""
    request = sensor_pb2.WatchReadingsRequest(sensors=names, options=sensor_pb2.ReadingOptions(**options))
    with closing(Watch(stubs, request)) as watch:
        return watch.next()


class Watch:
    """Readings as they come."""

    def __init__(self, stubs: Stubs, request: sensor_pb2.WatchReadingsRequest) -> None:
        """Begin to watch."""
        self._call = stubs.sensor.WatchReadings(request, timeout=60.0)

    def next(self) -> list[sensor_pb2.SensorReading]:
        return list(next(self._call).readings)

    def close(self) -> None:
        self._call.cancel()


def test_a_reading_tells_distances_elements_and_points_in_three_frames(stepped: Stubs) -> None:
    """A sphere of 0.5 m, 2 m ahead: the middle beam meets it after 1.5 m; the others by the law of cosines."""
    load(stepped, IIWA, "arm", parent_t_node=place(0.0, 3.0, 0.0))
    apply(stepped, sensor(parent="arm.lbr_iiwa_link_0", at=place(0.0, 0.0, 5.0), pattern=FAN), ball(parent="lidar"))
    reading = read(stepped, intensities=True, elements=True, points=True, frame=sensor_pb2.READING_FRAME_WORLD)
    assert (reading.state, reading.number, reading.fault) == (STOPPED, 1, "")
    told = reading.range
    side = 2.0 * np.cos(0.1) - np.sqrt(0.25 - (2.0 * np.sin(0.1)) ** 2)
    np.testing.assert_allclose(values(told.distances), [[side, 1.5, side]], rtol=1e-6)
    assert values(told.valid).tolist() == [[1, 1, 1]]
    names = [told.element_names[i] for i in values(told.elements).ravel()]
    assert names == ["ball"] * 3
    np.testing.assert_allclose(values(told.points)[0, 1], [1.5, 3.0, 5.0], atol=1e-6)
    robot = read(stepped, points=True, frame=sensor_pb2.READING_FRAME_ROBOT).range
    np.testing.assert_allclose(values(robot.points)[0, 1], [1.5, 0.0, 5.0], atol=1e-6)
    own = read(stepped, points=True)
    assert own.range.frame == sensor_pb2.READING_FRAME_SENSOR
    np.testing.assert_allclose(values(own.range.points)[0, 1], [1.5, 0.0, 0.0], atol=1e-6)
    assert own.number == 3
    assert not own.range.HasField("intensities")


def test_readings_are_due_by_simulation_time_and_the_step_waits_for_them(stepped: Stubs) -> None:
    """30 Hz and ticks of 4 ms: reading k is due at the first tick at or after k / 30 s."""
    apply(stepped, ball(), sensor(pattern=FAN, rate_hertz=30.0))
    began = tick(stepped)
    start(stepped, "lidar")
    for k in range(1, 8):
        due = -(-k * 250 // 30)  # ceil
        step(stepped, began + due - tick(stepped))
        reading = latest(stepped)[0]
        assert (reading.number, reading.stamp.tick - began, reading.missed) == (k, due, 0)
    step(stepped, 7500 - due)  # 30 s in all
    told = status(stepped)
    assert (told.readings, told.missed, told.state, told.rate_hertz) == (900, 0, RUNNING, 30.0)


def test_who_watches_learns_that_a_sensor_stopped_or_is_gone(stepped: Stubs) -> None:
    apply(stepped, ball(), sensor(pattern=FAN, running=True))
    step(stepped, 25)
    with closing(Watch(stepped, sensor_pb2.WatchReadingsRequest())) as watch:
        assert [one.state for one in watch.next()] == [RUNNING]
        stop(stepped)
        assert [(one.state, one.HasField("range")) for one in watch.next()] == [(STOPPED, False)]
        apply(stepped, remove("lidar"))
        gone = watch.next()
        assert [(one.state, one.sensor) for one in gone] == [(STOPPED, "lidar")]
        assert "removed" in gone[0].fault


def test_a_scene_keeps_running_sensors(stepped: Stubs) -> None:
    apply(
        stepped,
        ball(),
        sensor(pattern=FAN, rate_hertz=250.0, sensor_model="laser", sensor_model_settings={"rays": 1}, running=True),
        sensor("device", preset="HC-SR04", seed=7, motion_distortion=True, running=True),
    )
    step(stepped, 3)
    text = stepped.scene.SaveScene(scene_pb2.SaveSceneRequest()).text
    assert stepped.scene.SaveScene(scene_pb2.SaveSceneRequest()).text == text
    stepped.scene.LoadScene(scene_pb2.LoadSceneRequest(text=text))
    assert stepped.scene.SaveScene(scene_pb2.SaveSceneRequest()).text == text
    step(stepped, 5)
    assert (status(stepped).state, status(stepped).readings) == (RUNNING, 5)
    assert status(stepped, "device").state == RUNNING
    stepped.scene.LoadScene(scene_pb2.LoadSceneRequest(text=EMPTY_SCENE))
    step(stepped, 2)
    assert not stepped.sensor.ListSensors(sensor_pb2.ListSensorsRequest()).sensors


def test_a_world_that_is_replaced_again_and_again_takes_its_sensors_with_it(stubs: Stubs) -> None:
    apply(stubs, ball(), *(sensor(f"s{i}", pattern=FAN, rate_hertz=250.0, running=True) for i in range(5)))
    text = stubs.scene.SaveScene(scene_pb2.SaveSceneRequest()).text
    with closing(Watch(stubs, sensor_pb2.WatchReadingsRequest())) as watch:
        for _ in range(5):
            stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text=text))
            seen: set[str] = set()
            while len(seen) < 5:
                seen |= {one.sensor for one in watch.next() if one.state == RUNNING}
    told = stubs.sensor.ListSensors(sensor_pb2.ListSensorsRequest()).sensors
    assert {one.state for one in told} == {RUNNING}, told


def test_presets_are_told_as_they_can_be_set(stepped: Stubs) -> None:
    presets = stepped.sensor.ListSensorPresets(sensor_pb2.ListSensorPresetsRequest()).presets
    assert len(presets) >= 8
    for preset in presets:
        assert preset.source and preset.description
        apply(stepped, create(nodes_pb2.Node(name=preset.name, range_sensor=preset.sensor)))
    rates = {one.name: one.rate_hertz for one in stepped.sensor.ListSensors(sensor_pb2.ListSensorsRequest()).sensors}
    assert rates == {preset.name: preset.sensor.rate_hertz for preset in presets}


def test_what_is_refused(stepped: Stubs) -> None:
    apply(stepped, ball(), sensor(pattern=FAN))
    assert refusal(lambda: read(stepped, "lider")).metadata["nearest"] == "lidar"
    assert refusal(lambda: read(stepped, "ball")).reason == "UNKNOWN_NAME"
    assert refusal(lambda: start(stepped, "lidar", "radar")).reason == "UNKNOWN_NAME"
    assert status(stepped).state == STOPPED  # all or none
    assert "frame is 9" in refusal(lambda: read(stepped, frame=9)).message
    assert "options.images is 7" in refusal(lambda: read(stepped, images=[7])).message
    for bad in (-1.0, float("nan")):
        request = sensor_pb2.WatchReadingsRequest(max_rate_hertz=bad)
        assert refusal(lambda request=request: next(stepped.sensor.WatchReadings(request))).reason == "INVALID_ARGUMENT"
    request = sensor_pb2.WatchReadingsRequest(sensors=["radar"])
    assert refusal(lambda: next(stepped.sensor.WatchReadings(request))).reason == "UNKNOWN_NAME"
