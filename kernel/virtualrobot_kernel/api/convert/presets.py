"""Devices that range sensors may be set as: from the table to what `sensing` knows, and to messages."""

from __future__ import annotations

from virtualrobot.v1 import sensor_pb2

from virtualrobot_kernel.formats import preset_file
from virtualrobot_kernel.messages.sensing import RANGE_SENSOR
from virtualrobot_kernel.sensing.settings import Preset, Presets


def presets() -> Presets:
    """Return the devices by name."""
    return {
        one.name: Preset(one.name, one.description, one.source, RANGE_SENSOR.read(one.sensor, f"preset {one.name}"))
        for one in preset_file.read().presets
    }


def preset_message(preset: Preset) -> sensor_pb2.SensorPreset:
    """Return the message of a device."""
    return sensor_pb2.SensorPreset(
        name=preset.name,
        description=preset.description,
        source=preset.source,
        sensor=RANGE_SENSOR.write(preset.sensor),
    )
