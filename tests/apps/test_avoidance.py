"""The avoidance application in a real kernel, in steps: distances that are kept, how far the tool is off, its plot."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot.cli import cli
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.demos.avoidance import avoid
from virtualrobot_apps.demos.avoidance.control import Gains

OFF = Gains(alpha=0.0, repulsion=0.0)
SECONDS = 2.4
"""Of each run."""


@pytest.fixture(scope="module")
def kernel() -> Iterator[KernelProcess]:
    with KernelProcess("--stepped", headless=True) as process:
        yield process


@pytest.fixture(scope="module")
def client(kernel: KernelProcess) -> Iterator[virtualrobot.Client]:
    with virtualrobot.connect(kernel.address) as client:
        yield client


@pytest.mark.long
@pytest.mark.parametrize("name", ["iiwa", "panda"])
def test_links_keep_away_while_the_tool_stays(client: virtualrobot.Client, name: str) -> None:
    """By the subtask alone, which acts in the null space: the tool is off only by how joints lag when they start."""
    cell = replace(avoid.CELLS[name], ball=avoid.CELLS[name].ball[:3])
    avoid.build(client, cell)
    without, by_law = (avoid.run(client, cell, True, SECONDS, gains, "") for gains in (OFF, Gains(repulsion=0.0)))
    assert by_law.least.min() > without.least.min() + 0.015
    assert np.linalg.norm(by_law.errors, axis=1).max() < 8e-3
    assert np.linalg.norm(by_law.errors[-1]) < 5e-4
    assert np.abs(by_law.positions[-1] - by_law.positions[0]).max() > 0.1
    # What is recorded is what the kernel says of these joints and of the ball as it is at the end.
    q = dict(zip(client.robot("arm").chain_joint_names, by_law.positions[-1].tolist(), strict=True))
    near = client.collisions.distances("arm", max_distance=0.5, configurations={"arm": q})
    assert by_law.least[-1] == pytest.approx(near[0].distance, abs=1e-9)


@pytest.mark.long
def test_a_tool_gives_way_and_comes_back(client: virtualrobot.Client) -> None:
    """The ball comes by the tool: by the repulsive velocity it stays farther off, and is where it was at the end."""
    cell = replace(avoid.CELLS["iiwa"], ball=((0.8, -0.4, 0.5), (0.6, -0.18, 0.5), (0.8, -0.4, 0.5)))
    avoid.build(client, cell)
    stiff, soft = (
        avoid.run(client, cell, True, SECONDS, gains, "") for gains in (replace(Gains(), repulsion=0.0), Gains())
    )
    assert np.linalg.norm(stiff.errors, axis=1).max() < 2e-3
    assert soft.least.min() > stiff.least.min() + 0.01
    assert 0.01 < np.linalg.norm(soft.errors, axis=1).max() < 0.1
    assert np.linalg.norm(soft.errors[-1]) < 2e-3


@pytest.mark.long
def test_the_same_start_gives_the_same_joints(client: virtualrobot.Client) -> None:
    cell = avoid.CELLS["iiwa"]
    avoid.build(client, cell)
    one, other = (avoid.run(client, cell, False, 1.0, Gains(), "") for _ in range(2))
    np.testing.assert_array_equal(one.positions, other.positions)
    np.testing.assert_array_equal(one.distances, other.distances)
    assert np.ptp(one.positions, axis=0).min() > 0.0


@pytest.mark.long
def test_the_command_draws_its_picture(kernel: KernelProcess, tmp_path: Path) -> None:
    file = tmp_path / "avoidance.svg"
    arguments = ["avoid", "--address", kernel.address, "--hold", "--seconds", "1", "--plot", str(file)]
    done = CliRunner().invoke(cli, arguments, catch_exceptions=False)
    assert done.exit_code == 0, done.output
    assert re.search(r"^without +[\d.]+ mm +[\d.]+ mm +[\d.]+ mm$", done.output, re.MULTILINE), done.output
    assert re.search(r"^with +[\d.]+ mm", done.output, re.MULTILINE), done.output
    curves = [line for line in ElementTree.parse(file).iter() if line.tag.endswith("polyline")]
    assert len(curves) >= 2 + 2 * 3


def test_the_command_refuses_other_pictures(tmp_path: Path) -> None:
    for name, said in (("a.png", ".svg"), ("none/a.svg", "no folder")):
        done = CliRunner().invoke(cli, ["avoid", "--plot", str(tmp_path / name)])
        assert done.exit_code == 2 and said in done.output


@pytest.mark.long
def test_real_time_works_as_well() -> None:
    """As often as states come; the arm rests at the end. Slowly: the stream may be silent for 0.2 s of its time."""
    with KernelProcess(headless=True) as process, virtualrobot.connect(process.address) as client:
        client.clock.speed_factor = 0.2
        cell = replace(avoid.CELLS["iiwa"], ball=((0.2, -0.25, 0.75), (0.2, -0.3, 0.75)))
        avoid.build(client, cell)
        record = avoid.run(client, cell, True, 1.0, Gains(), "")
        assert len(record.times) > 5 and record.least[-1] > record.least[0] + 0.01
        robot = client.robot("arm")
        assert not robot.state.motion_ids and not robot.state.velocities.any()
