"""Table of devices that range sensors may be set as: `sensing/presets.yaml`, in the names of the contract."""

from __future__ import annotations

from importlib.resources import files

import yaml
from google.protobuf.json_format import ParseDict
from virtualrobot.v1 import sensor_pb2

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def read() -> sensor_pb2.ListSensorPresetsResponse:
    """Return the devices that come with the kernel."""
    text = (files("virtualrobot_kernel") / "sensing" / "presets.yaml").read_text("utf-8")
    return ParseDict(yaml.load(text, _LOADER), sensor_pb2.ListSensorPresetsResponse())
