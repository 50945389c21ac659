"""Each bundled driver has a page, which tells its settings, and a row of the overview."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path
from typing import get_args

import pytest
from click.testing import CliRunner
from virtualrobot_apps.bridges.ros import driver as ros_driver
from virtualrobot_apps.new.driver import BUNDLED, driver
from virtualrobot_plugins import drivers
from virtualrobot_plugins.drivers.loopback.settings import What

from tests.drivers.test_faults import AT_END, FAULTS, HARMLESS

DOCS = Path(__file__).resolve().parents[2] / "docs"


def registered() -> dict[str, type]:
    """Return the settings of the bundled drivers, by their names."""
    found: dict[str, type] = {}

    def register(name: str, factory: object, config_type: type | None = None, **_: object) -> None:
        assert config_type is not None
        found[name] = config_type

    drivers.virtualrobot_register_robot_drivers(register)
    ros_driver.virtualrobot_register_robot_drivers(register)
    return found


def test_the_overview_and_the_pages_are_those_of_the_drivers() -> None:
    told = (DOCS / "drivers.md").read_text("utf-8")
    rows = re.findall(r"^\| \[`(\w+)`\]\(drivers/(\w+)\.md\) \|", told, re.MULTILINE)
    assert rows == [(name, name) for name in sorted(registered())]
    assert {page.stem for page in (DOCS / "drivers").glob("*.md")} == set(registered())


def test_no_new_driver_is_called_as_a_bundled_one() -> None:
    assert sorted(BUNDLED) == sorted(registered())
    refused = CliRunner().invoke(driver, ["new", "ur_rtde"])
    assert (refused.exit_code, "'ur_rtde' is a bundled driver" in refused.output) == (2, True)


@pytest.mark.parametrize("name", registered())
def test_a_page_tells_each_setting(name: str) -> None:
    told = (DOCS / "drivers" / f"{name}.md").read_text("utf-8")
    rows = {word for row in re.findall(r"^\|([^|]*)\|", told, re.MULTILINE) for word in re.findall(r"`(\w+)`", row)}
    assert [field.name for field in dataclasses.fields(registered()[name]) if field.name not in rows] == []


def test_the_matrix_of_faults_is_what_was_tried() -> None:
    """Each fault that is caused has its row and its words, and each row a test that there is."""
    told = (DOCS / "drivers.md").read_text("utf-8").partition("### Matrix")[2].partition("\n## ")[0]
    rows = [[cell.strip() for cell in line[1:-1].split("|")] for line in told.splitlines() if line.startswith("| ")][1:]
    words = {row[0].strip("`"): row[3].strip('"') for row in rows if re.fullmatch("`[a-z_]+`", row[0])}
    assert words == {fault.split()[0]: said for fault, said in (FAULTS | AT_END).items()}
    borne = next(row[0] for row in rows if row[4].endswith("test_what_is_borne_costs_nobody_anything`"))
    assert re.findall(r"`(\w+)`", borne) == [fault.split()[0] for fault in HARMLESS]
    named = [re.fullmatch(r"`(\w+\.py)::(\w+)`", row[4]) for row in rows if row[4] != "the same"]
    for test in named:
        assert test is not None
        assert f"def {test[2]}(" in (Path(__file__).parent / test[1]).read_text("utf-8"), test[0]


def test_each_fault_on_demand_has_been_tried() -> None:
    assert {fault.split()[0] for fault in (*FAULTS, *AT_END, *HARMLESS)} == set(get_args(What))
