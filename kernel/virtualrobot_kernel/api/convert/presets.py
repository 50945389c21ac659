"""Devices that range sensors may be set as: from the table to what `sensing` knows, and to messages."""

from __future__ import annotations

from virtualrobot.v1 import sensor_pb2

from virtualrobot_kernel.formats import preset_file
from virtualrobot_kernel.messages.sensing import RANGE_SENSOR
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.sensing.settings import Preset, Presets

PRESET = Table(Preset, sensor_pb2.SensorPreset, sensor=RANGE_SENSOR)


def presets() -> Presets:
    """Return the devices by name."""
    return {one.name: PRESET.read(one, f"preset {one.name}") for one in preset_file.read().presets}
