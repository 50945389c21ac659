"""The page about sensor models names each setting with its default, and each device."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest
from ruamel.yaml import YAML
from virtualrobot_plugins.sensor_models.infrared import InfraredSettings
from virtualrobot_plugins.sensor_models.laser import LaserSettings
from virtualrobot_plugins.sensor_models.sonar import SonarSettings
from virtualrobot_plugins.sensor_models.ultrasonic import UltrasonicSettings

ROOT = Path(__file__).resolve().parent.parent
TEXT = (ROOT / "docs" / "sensor-models.md").read_text("utf-8")
PRESETS = ROOT / "kernel" / "virtualrobot_kernel" / "sensing" / "presets.yaml"


def table(heading: str) -> list[tuple[str, str]]:
    """Return the first two cells of the rows below a heading of a table, which stands between backticks or not."""
    rows = TEXT.partition(f"| {heading} |")[2].partition("\n\n")[0]
    return re.findall(r"^\| `([\w-]+)` \| ([^|]+) \|", rows, re.MULTILINE)


@pytest.mark.parametrize(
    ("model", "settings"),
    [
        ("laser", LaserSettings),
        ("ultrasonic", UltrasonicSettings),
        ("sonar", SonarSettings),
        ("infrared", InfraredSettings),
    ],
)
def test_each_setting_is_told_with_its_default(model: str, settings: type) -> None:
    def shown(value: object) -> str:
        return "[0, 0]" if value == (0.0, 0.0) else str(value)

    fields = [(field.name, shown(field.default)) for field in dataclasses.fields(settings)]
    assert table(f"setting of `{model}`") == fields


def test_each_device_is_told() -> None:
    presets = YAML(typ="safe", pure=True).load(PRESETS.read_text("utf-8"))["presets"]
    assert [name for name, _ in table("preset")] == [preset["name"] for preset in presets]
    models = {name: model for name, model in re.findall(r"^\| `([\w-]+)` \|[^|]+\| `(\w+)` \|$", TEXT, re.MULTILINE)}
    assert all(models[preset["name"]] == preset["sensor"]["sensor_model"] for preset in presets)
