"""Sensors whose components do what none may: that sensor has a fault, all others run on."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Iterator
from contextlib import closing
from typing import Any

import pytest
from virtualrobot.v1 import plugin_pb2, plugin_pb2_grpc, sensing_pb2, sensor_pb2

from tests.api.asking import apply, refusal
from tests.api.reading import array, step, values
from tests.api.test_scene import remove
from tests.api.test_sensor import (
    FAN,
    FAULT,
    RUNNING,
    STOPPED,
    Watch,
    ball,
    latest,
    read,
    sensor,
    start,
    status,
    stop,
)
from tests.kernels import KernelProcess, StartKernel, Stubs, emptied
from tests.plugins.install import environment, install
from tests.tiers import every_fifth


@pytest.fixture(scope="module")
def odd_kernel(start_kernel: StartKernel, tmp_path_factory: pytest.TempPathFactory) -> KernelProcess:
    """Return a kernel with odd components."""
    site = install(tmp_path_factory.mktemp("site"), "odd_sensors")
    return start_kernel("--stepped", environment=environment(site))


@pytest.fixture
def odd(odd_kernel: KernelProcess) -> Iterator[Stubs]:
    """Return stubs to it, with an empty world."""
    with emptied(odd_kernel) as stubs:
        yield stubs


def process_of(stubs: Stubs, component: str, sensor: str) -> int:
    """Return the process of a sensor's component."""
    told = plugin_pb2_grpc.PluginServiceStub(stubs.channel).ListPlugins(plugin_pb2.ListPluginsRequest()).plugins
    components = [one for plugin in told for one in plugin.components if one.name == component]
    return next(use.process_id for one in components for use in one.uses if use.sensor == sensor)


CASTERS = {
    "raising": "ZeroDivisionError: a ray too many",
    "hanging": "within 2 s",
    "dying": "ended|died|killed|SIGKILL",
    "short": r"\(3,\)",
    "nan": "NaN",
    "ghost": "an element that is not there",
}


@pytest.mark.parametrize("name", every_fifth(CASTERS))
def test_a_caster_that_fails_faults_its_sensor_alone(odd: Stubs, name: str) -> None:
    apply(odd, ball(), sensor("well", pattern=FAN), sensor("odd", pattern=FAN, ray_caster=name))
    start(odd)
    with closing(Watch(odd, sensor_pb2.WatchReadingsRequest(sensors=["odd"]))) as watch:
        step(odd, 25)
        told = status(odd, "odd")
        assert (told.state, told.readings) == (RUNNING, 1)
        step(odd, 50)
        told = status(odd, "odd")
        assert told.state == FAULT
        assert re.search(CASTERS[name], told.fault), told.fault
        assert f"the ray_caster component {name!r} of the sensor 'odd' failed" in told.fault
        assert (status(odd, "well").state, status(odd, "well").readings) == (RUNNING, 3)
        last = next(one for one in iter(lambda: watch.next()[-1], None) if one.state != RUNNING)
        assert (last.state, last.fault, last.HasField("range")) == (FAULT, told.fault, False)
    refused = refusal(lambda: read(odd, "odd"))
    assert refused.reason == "PLUGIN_FAILED"
    start(odd, "odd")  # tried anew, with a new process
    step(odd, 25)
    assert (status(odd, "odd").state, status(odd, "odd").readings) == (RUNNING, 1)
    assert status(odd, "well").readings == 4


def test_a_model_that_fails_faults_its_sensor_alone(odd: Stubs) -> None:
    apply(odd, ball(), sensor("well", pattern=FAN), sensor("odd", pattern=FAN, sensor_model="one_too_many"))
    assert values(read(odd, "odd").range.distances).tolist() == [[1.0, 1.0, 1.0]]
    refused = refusal(lambda: read(odd, "odd"))
    assert refused.reason == "PLUGIN_FAILED"
    assert "distance of shape (4,)" in refused.message
    assert read(odd, "odd").number == 3  # a single reading is tried anew


def test_components_are_tried_before_a_sensor_gets_them(odd: Stubs) -> None:
    apply(odd, ball(), sensor(pattern=FAN))

    def swap(**fields: Any) -> sensor_pb2.SetRangeComponentsResponse:  # noqa: ANN401 fields of the request
        return odd.sensor.SetRangeComponents(sensor_pb2.SetRangeComponentsRequest(sensor="lidar", **fields))

    refused = refusal(lambda: swap(sensor_model="backwards"))
    assert refused.reason == "PLUGIN_FAILED"
    assert "x above 0" in refused.message
    assert refusal(lambda: swap(ray_caster="embre")).metadata["nearest"] == "embree"
    assert refusal(lambda: swap(ray_caster="laser")).reason == "UNKNOWN_NAME"
    answer = swap(ray_caster="reference")
    assert (answer.rays, answer.cast_seconds > 0.0, answer.model_seconds > 0.0) == (3, True, True)
    assert read(odd).range.distances


def test_the_process_of_a_component_is_killed(odd: Stubs) -> None:
    apply(odd, ball(), sensor(pattern=FAN, ray_caster="reference"), sensor("well", pattern=FAN))
    start(odd)
    step(odd, 25)
    os.kill(process_of(odd, "reference", "lidar"), signal.SIGKILL)
    step(odd, 50)
    assert status(odd).state == FAULT
    assert status(odd, "well").readings == 3
    start(odd)
    step(odd, 25)
    assert (status(odd).state, status(odd).readings) == (RUNNING, 1)


def test_what_a_sensor_may_be_set_to(odd: Stubs) -> None:
    def refused(**fields: object) -> str:
        return refusal(lambda: apply(odd, sensor(**fields))).message  # pyright: ignore[reportArgumentType]

    zero = sensing_pb2.ScanPattern(free=sensing_pb2.FreeBeams(directions=array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])))
    nan = sensing_pb2.ScanPattern(free=sensing_pb2.FreeBeams(directions=array([[float("nan"), 0.0, 0.0]])))
    many = sensing_pb2.ScanPattern(raster=sensing_pb2.Raster(columns=100_000, rows=10_000))
    assert "row 1 is zero" in refused(pattern=zero)
    assert "not finite" in refused(pattern=nan)
    assert "1 to 2,000,000, not 1,000,000,000" in refused(pattern=many)
    assert "max_range_meters must be 0 or above" in refused(max_range_meters=-1.0)
    assert "did you mean 'LDS-01'" in refused(preset="LDS-1")
    assert "did you mean 'embree'" in refused(ray_caster="embre")
    assert "did you mean 'laser'" in refused(sensor_model="lasr")
    assert "sensor_model component 'laser'" in refused(sensor_model="laser", sensor_model_settings={"rays": 0})
    assert refused(motion_distortion=True, rate_hertz=0.1).startswith("rate_hertz is 0.1")


def test_a_sensor_on_a_node_that_is_removed_stops(odd: Stubs) -> None:
    apply(
        odd,
        ball("mount"),
        sensor(parent="mount", pattern=FAN, running=True),
        sensor("other", pattern=FAN, running=True),
    )
    step(odd, 25)
    with closing(Watch(odd, sensor_pb2.WatchReadingsRequest())) as watch:
        assert {one.sensor for one in watch.next()} == {"lidar", "other"}
        apply(odd, remove("mount"))
        gone = watch.next()
        assert [(one.sensor, one.state) for one in gone] == [("lidar", STOPPED)]
        assert "'lidar' was removed" in gone[0].fault
    assert refusal(lambda: read(odd)).reason == "UNKNOWN_NAME"
    step(odd, 25)
    assert [one.number for one in latest(odd)] == [2]
    stop(odd)
