"""The bundled sensor models and devices at work in a kernel: their noise as set, and the same in every run."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from scipy import stats
from virtualrobot.v1 import geometry_pb2, nodes_pb2, scene_pb2, sensor_pb2

from tests.api.asking import apply, create, refusal
from tests.api.reading import step, values
from tests.api.test_scene import remove
from tests.api.test_sensor import FAULT, RUNNING, latest, read, sensor, start, status
from tests.kernels import StartKernel, Stubs
from tests.plugins.install import environment, install, write_package

ALARM = 1e-9
"""How often chance may fail a test here."""


def hollow(radius: float, reflectance: float = 0.9) -> scene_pb2.Command:
    """Return the command that puts a sphere around the world's origin, which sensors there see from inside."""
    figure = nodes_pb2.Figure(
        sphere=nodes_pb2.Sphere(radius_meters=radius), material=nodes_pb2.Material(reflectance=reflectance)
    )
    return create(nodes_pb2.Node(name="hollow", part=nodes_pb2.Part(), figures=[figure]))


def wall(x: float, tilt: float = 0.0) -> scene_pb2.Command:
    """Return the command that puts a wide wall where the x axis meets it at x, turned about z by `tilt` (rad)."""
    size = geometry_pb2.Vector3(x=0.1, y=20.0, z=20.0)
    normal = np.array([np.cos(tilt), np.sin(tilt)])
    middle = np.array([x, 0.0]) + 0.05 * normal
    turn = geometry_pb2.Quaternion(z=np.sin(tilt / 2), w=np.cos(tilt / 2))
    at = geometry_pb2.Pose(position=geometry_pb2.Vector3(x=middle[0], y=middle[1]), orientation=turn)
    figure = nodes_pb2.Figure(box=nodes_pb2.Box(size=size), material=nodes_pb2.Material(reflectance=0.9))
    return create(nodes_pb2.Node(name="wall", part=nodes_pb2.Part(), parent_t_node=at, figures=[figure]))


def distances(stubs: Stubs, name: str, count: int = 1) -> np.ndarray:
    """Return the distances of some readings one after the other; all must be valid."""
    told = [read(stubs, name).range for _ in range(count)]
    assert all(values(one.valid).all() for one in told)
    return np.array([values(one.distances) for one in told], np.float64)


def presets(stubs: Stubs) -> list[sensor_pb2.SensorPreset]:
    return list(stubs.sensor.ListSensorPresets(sensor_pb2.ListSensorPresetsRequest()).presets)


def test_a_scanner_by_name_has_the_noise_of_its_data_sheet(stepped: Stubs, seed: int) -> None:
    """Hokuyo URG-04LX, 2 m: +-1% of the distance as two deviations, and the rounding to 1 mm (Sheppard's twelfth)."""
    apply(stepped, hollow(2.0), sensor("hokuyo", preset="URG-04LX", seed=seed))
    told = distances(stepped, "hokuyo", 40)
    assert told.shape == (40, 1, 682)
    steps = told / 0.001
    np.testing.assert_allclose(steps, np.rint(steps), atol=2e-3)  # float32 on the wire
    off = (told - 2.0).ravel()
    deviation = np.hypot(0.01, 0.001 / np.sqrt(12.0))
    n = len(off)
    assert abs(off.mean()) < stats.norm.isf(ALARM / 2) * deviation / np.sqrt(n)
    low, high = stats.chi2.ppf([ALARM / 2, 1 - ALARM / 2], n)
    assert low < (off**2).sum() / deviation**2 < high
    # Neither beams beside each other nor readings one after the other have noise in common.
    for one, other in ((told[:, 0, 1:], told[:, 0, :-1]), (told[1:], told[:-1])):
        r = np.corrcoef(one.ravel(), other.ravel())[0, 1]
        assert abs(r) < stats.norm.isf(ALARM / 2) / np.sqrt(one.size)


def test_every_device_reads_in_a_room(stepped: Stubs) -> None:
    """Inside a white sphere, halfway through its range, each beam of each device finds it."""
    listed = presets(stepped)
    assert len(listed) == 13
    for preset in listed:
        away = 0.5 * (preset.sensor.min_range_meters + preset.sensor.max_range_meters)
        apply(stepped, hollow(away), sensor("device", preset=preset.name))
        told = distances(stepped, "device")
        # Temperature is the largest of their systematic errors; eight deviations of the noise are the rest.
        assert np.abs(told / away - 1.0).max() < 0.25, preset.name
        assert abs(np.median(told) / away - 1.0) < 0.12, preset.name
        for name in ("device", "hollow"):
            apply(stepped, remove(name))


def test_settings_that_make_no_sense_are_refused_with_the_name(stepped: Stubs) -> None:
    apply(stepped, sensor("lidar"))
    request = sensor_pb2.SetRangeComponentsRequest(sensor="lidar", sensor_model="laser")
    request.sensor_model_settings.update({"deviation": 0.1})
    said = refusal(lambda: stepped.sensor.SetRangeComponents(request))
    assert "did you mean 'deviation_meters'" in said.message


RAISES = """
from virtualrobot_plugins.sensor_models.ideal import Ideal
from virtualrobot_sdk.hookspecs import hookimpl

api_version = "1.0"


class RaisesLater(Ideal):
    \"\"\"Raises at the third reading.\"\"\"

    def __init__(self):
        self.count = 0

    def apply(self, hits, rng, /):
        self.count += 1
        if self.count == 3:
            raise RuntimeError("out of ink")
        return super().apply(hits, rng)


@hookimpl
def virtualrobot_register_sensor_models(register):
    register("raises_later", RaisesLater)
"""


@pytest.fixture
def among_wrong(start_kernel: StartKernel, tmp_path: Path) -> Iterator[Stubs]:
    """Return stubs to a stepped kernel with two wrong sensor models."""
    write_package(install(tmp_path, "wrong_shape"), "raises_later", RAISES)
    stubs = start_kernel("--stepped", environment=environment(tmp_path)).stubs()
    yield stubs
    stubs.channel.close()


@pytest.mark.long
def test_a_wrong_model_costs_its_own_sensor_and_no_other(among_wrong: Stubs) -> None:
    names = {"well": "ideal", "shape": "wrong_shape", "later": "raises_later"}
    sensors = [sensor(name, sensor_model=model, rate_hertz=50.0) for name, model in names.items()]
    apply(among_wrong, hollow(3.0), *sensors)
    start(among_wrong, *names)
    step(among_wrong, 25)
    told = {name: status(among_wrong, name) for name in names}
    assert [one.state for one in told.values()] == [RUNNING, FAULT, FAULT]
    assert "distance of shape (1, 2); it must be (1,)" in told["shape"].fault
    assert "RuntimeError: out of ink" in told["later"].fault
    assert told["well"].readings == 5
    (well,) = latest(among_wrong, "well")
    np.testing.assert_allclose(values(well.range.distances), [[3.0]], rtol=1e-6)
    # What cannot be chosen changes nothing.
    request = sensor_pb2.SetRangeComponentsRequest(sensor="well", sensor_model="wrong_shape")
    assert refusal(lambda: among_wrong.sensor.SetRangeComponents(request)).reason == "PLUGIN_FAILED"
    step(among_wrong, 5)
    assert status(among_wrong, "well").state == RUNNING
    # With another model a sensor that failed goes on.
    among_wrong.sensor.SetRangeComponents(sensor_pb2.SetRangeComponentsRequest(sensor="later", sensor_model="laser"))
    start(among_wrong, "later")
    step(among_wrong, 5)
    assert status(among_wrong, "later").state == RUNNING
