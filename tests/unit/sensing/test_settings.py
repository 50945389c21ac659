"""What a sensor does not say is the preset's, or else the contract's."""

from __future__ import annotations

import pytest
from virtualrobot_kernel.errors import KernelError, UnknownNameError
from virtualrobot_kernel.sensing.settings import Preset, range_settings, rate_hertz
from virtualrobot_kernel.world.sensing import CameraSensor, Fan, MotionSensor, RangeSensor, SingleBeam

FAN = Fan(360, 0.0, 6.0)
DEVICE = RangeSensor(
    pattern=FAN,
    rate_hertz=5.0,
    min_range_meters=0.1,
    max_range_meters=3.5,
    sensor_model="laser",
    sensor_model_settings={"rays": 1},
)
PRESETS = {"device": Preset("device", "a device", "its data sheet", DEVICE)}


def test_the_contracts_values_without_a_preset() -> None:
    settings = range_settings(RangeSensor(), {})
    assert isinstance(settings.pattern, SingleBeam)
    assert (settings.rate_hertz, settings.min_range_meters, settings.max_range_meters) == (10.0, 0.0, 10.0)
    assert (settings.ray_caster, settings.sensor_model) == ("embree", "ideal")


def test_the_preset_says_what_the_sensor_does_not() -> None:
    settings = range_settings(RangeSensor(preset="device", min_range_meters=0.0, rate_hertz=7.0), PRESETS)
    assert settings.pattern is FAN
    assert (settings.rate_hertz, settings.min_range_meters, settings.max_range_meters) == (7.0, 0.0, 3.5)
    assert (settings.sensor_model, settings.sensor_model_settings) == ("laser", {"rays": 1})


def test_settings_of_the_presets_model_are_not_given_to_another() -> None:
    assert range_settings(RangeSensor(preset="device", sensor_model="ideal"), PRESETS).sensor_model_settings == {}
    same = RangeSensor(preset="device", sensor_model="laser", sensor_model_settings={})
    assert range_settings(same, PRESETS).sensor_model_settings == {}
    assert range_settings(RangeSensor(preset="device", sensor_model="laser"), PRESETS).sensor_model_settings == {
        "rays": 1
    }


def test_what_is_refused() -> None:
    with pytest.raises(UnknownNameError, match=r"devise.*did you mean 'device'"):
        range_settings(RangeSensor(preset="devise"), PRESETS)
    with pytest.raises(KernelError, match=r"from 5 m to 3\.5 m"):
        range_settings(RangeSensor(preset="device", min_range_meters=5.0), PRESETS)
    with pytest.raises(KernelError, match=r"rate_hertz is 0\.5"):
        range_settings(RangeSensor(rate_hertz=0.5, motion_distortion=True), {})


def test_rates_of_all_kinds() -> None:
    assert rate_hertz(RangeSensor(preset="device"), PRESETS) == 5.0
    assert rate_hertz(RangeSensor(), {}) == 10.0
    assert rate_hertz(CameraSensor(), {}) == 10.0
    assert rate_hertz(MotionSensor(), {}) == 100.0
    assert rate_hertz(MotionSensor(rate_hertz=3.0), {}) == 3.0
