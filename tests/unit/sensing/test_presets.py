"""The table of devices: each entry is a range sensor whose model can be made, with the numbers of its data sheet."""

from __future__ import annotations

import math
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
import virtualrobot_kernel.sensing
from google.protobuf.json_format import MessageToDict, ParseDict
from ruamel.yaml import YAML
from virtualrobot.v1 import sensor_pb2
from virtualrobot_sdk.loading import load
from virtualrobot_sdk.settings import make_settings

FILE = Path(virtualrobot_kernel.sensing.__file__).with_name("presets.yaml")
PRESETS = {
    preset.name: preset
    for preset in ParseDict(
        YAML(typ="safe", pure=True).load(FILE.read_text("utf-8")), sensor_pb2.ListSensorPresetsResponse()
    ).presets
}
PLUGIN = "virtualrobot_plugins.sensor_models"
MODELS = {one.name: one for one in load(EntryPoint(PLUGIN, PLUGIN, "virtualrobot.plugins"))[1]}


def model(name: str) -> dict:
    return MessageToDict(PRESETS[name].sensor.sensor_model_settings)


def test_names_are_in_order_and_the_file_has_no_other_presets() -> None:
    names = [entry["name"] for entry in YAML(typ="safe", pure=True).load(FILE.read_text("utf-8"))["presets"]]
    assert names == sorted(set(names))
    assert {"LDS-01", "URG-04LX", "VLP-16", "HC-SR04", "SRF05", "GP2Y0A21"} <= set(names)


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_says_everything_and_its_model_can_be_made(name: str) -> None:
    preset = PRESETS[name]
    sensor = preset.sensor
    assert preset.description
    assert "ssumed" in preset.source
    assert sensor.pattern.WhichOneof("pattern")
    assert 0.0 < sensor.min_range_meters < sensor.max_range_meters
    assert sensor.rate_hertz > 0.0
    registered = MODELS[sensor.sensor_model]
    settings = make_settings(registered.config_type, MessageToDict(sensor.sensor_model_settings))
    assert len(registered.factory(settings).beam()) >= 1


@pytest.mark.parametrize(
    ("name", "beams", "degrees"),
    [
        ("LDS-01", 360, 359.0),  # 1 degree a step (ROBOTIS e-Manual)
        ("URG-04LX", 682, 681 * 360 / 1024),  # steps 44 to 725 of 1024 (SCIP 2.0 specification, table 2)
        ("UTM-30LX", 1081, 270.0),  # steps 0 to 1080 of 1440 (the same)
        ("LMS111", 541, 270.0),  # 0.5 degrees a step (SICK 8012471)
        ("M750d", 512, 130.0),  # data sheet of the Oculus M series
    ],
)
def test_scanners_have_the_steps_of_their_data_sheets(name: str, beams: int, degrees: float) -> None:
    fan = PRESETS[name].sensor.pattern.fan
    assert fan.count == beams
    assert math.degrees(fan.end_angle_radians - fan.start_angle_radians) == pytest.approx(degrees, abs=1e-6)


def test_the_velodyne_has_sixteen_beams_and_288000_points_a_second() -> None:
    """16 beams from -15 to 15 degrees, 0.2 degrees a column at 10 Hz; the manual says about 300,000 a second."""
    sensor = PRESETS["VLP-16"].sensor
    spinning = sensor.pattern.spinning
    assert [round(math.degrees(e), 6) for e in spinning.elevations_radians] == [float(e) for e in range(-15, 16, 2)]
    assert spinning.columns * len(spinning.elevations_radians) * sensor.rate_hertz == 288000


@pytest.mark.parametrize(
    ("name", "difference"),
    # "Output voltage difference" of the three data sheets; all have 0.4 V at the farthest.
    [("GP2Y0A21", 1.9), ("GP2Y0A02", 2.05), ("GP2Y0A41", 2.25)],
)
def test_infrared_sensors_have_the_voltages_of_their_data_sheets(name: str, difference: float) -> None:
    settings, sensor = model(name), PRESETS[name].sensor
    assert settings["far_volts"] == 0.4
    assert settings["near_volts"] - settings["far_volts"] == pytest.approx(difference)
    assert (settings["near_meters"], settings["far_meters"]) == (sensor.min_range_meters, sensor.max_range_meters)


def test_ultrasonic_sensors_count_with_the_speed_of_their_data_sheets() -> None:
    """HC-SR04: 340 m/s; SRF05: 58 us for a centimeter there and back; c = 331.3 + 0.606 T."""
    for name, speed in (("HC-SR04", 340.0), ("SRF05", 0.02 / 58e-6)):
        assert 331.3 + 0.606 * model(name)["assumed_temperature_celsius"] == pytest.approx(speed, abs=0.01)
