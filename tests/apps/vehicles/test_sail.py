"""Missions in a real kernel: a vehicle follows its path against a current, and the command tells its numbers."""

from __future__ import annotations

from pathlib import Path as FilePath
from xml.etree import ElementTree

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot.cli import cli
from virtualrobot_apps.vehicles import sail
from virtualrobot_apps.vehicles.guidance import Path
from virtualrobot_apps.vehicles.mission import Follow, Hold, Mission
from virtualrobot_apps.vehicles.vehicle_file import read

from tests.kernels import KernelProcess

LEG = Follow(Path.through(np.array([[0, 0, -2], [1.5, 0, -2.2]], dtype=np.float64)), 0.4)


@pytest.mark.long
def test_a_vehicle_follows_its_path_in_a_kernel(steps: virtualrobot.Client) -> None:
    vehicle = read(sail.VEHICLE)
    sail.build(steps, vehicle, [LEG])
    record = sail.sail(steps, vehicle, Mission([LEG, Hold(1.0)]), seconds=30.0)
    assert record.done
    rms, most = record.numbers()
    assert rms < 0.1
    assert most < 0.2
    assert np.linalg.norm(record.positions[-1] - LEG.path.points[-1]) < 0.15
    # A wide beam hears the nearest place of the bottom, which is as far as the vehicle is high.
    assert len(record.heights) >= 5
    assert record.sounding() < 0.1
    # From where it stands in the end the sonar at its bow is nearest to the first pile.
    (x, y), end = sail.PILES[0], record.positions[-1]
    assert record.nearest == pytest.approx(np.hypot(x - end[0] - 0.25, y - end[1]) - sail.RADIUS, abs=0.3)


@pytest.mark.long
def test_the_demo_tells_its_numbers(stepped_kernel: KernelProcess, tmp_path: FilePath) -> None:
    mission, plot = tmp_path / "mission.yaml", tmp_path / "auv.svg"
    mission.write_text("schema_version: 1\nsteps: [{follow: {points: [[0, 0, -2], [0.6, 0, -2]], speed: 0.4}}]\n")
    given = ["demo", "auv", "--address", stepped_kernel.address, "--mission", str(mission), "--plot", str(plot)]
    result = CliRunner().invoke(cli, [*given, "--headless"])
    assert result.exit_code == 0, result.output
    assert "mission                done in" in result.output
    assert "m rms" in result.output
    assert "m by the echo sounder" in result.output
    assert "m by the sonar ahead" in result.output
    assert ElementTree.parse(plot).getroot().tag.endswith("svg")


def test_a_plot_is_an_svg() -> None:
    result = CliRunner().invoke(cli, ["demo", "auv", "--plot", "a.png"])
    assert result.exit_code == 2
    assert "--plot takes a name that ends in .svg" in result.output
