"""Each bundled driver has a page, which tells its settings, and a row of the overview."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest
from virtualrobot_plugins import drivers

DOCS = Path(__file__).resolve().parents[2] / "docs"


def registered() -> dict[str, type]:
    """Return the settings of the bundled drivers, by their names."""
    found: dict[str, type] = {}

    def register(name: str, factory: object, config_type: type | None = None, **_: object) -> None:
        assert config_type is not None
        found[name] = config_type

    drivers.virtualrobot_register_robot_drivers(register)
    return found


def test_the_overview_and_the_pages_are_those_of_the_drivers() -> None:
    told = (DOCS / "drivers.md").read_text("utf-8")
    rows = re.findall(r"^\| \[`(\w+)`\]\(drivers/(\w+)\.md\) \|", told, re.MULTILINE)
    assert rows == [(name, name) for name in sorted(registered())]
    assert {page.stem for page in (DOCS / "drivers").glob("*.md")} == set(registered())


@pytest.mark.parametrize("name", registered())
def test_a_page_tells_each_setting(name: str) -> None:
    told = (DOCS / "drivers" / f"{name}.md").read_text("utf-8")
    rows = {word for row in re.findall(r"^\|([^|]*)\|", told, re.MULTILINE) for word in re.findall(r"`(\w+)`", row)}
    assert [field.name for field in dataclasses.fields(registered()[name]) if field.name not in rows] == []
