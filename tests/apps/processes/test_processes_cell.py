"""Processes in a running cell: what each one plans keeps all limits and touches nothing, and where its tool goes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot
from virtualrobot.geometry import Matrix
from virtualrobot_apps.languages.writers import rapid
from virtualrobot_apps.languages.writers.resolve import robot_program
from virtualrobot_apps.languages.writers.words import Language
from virtualrobot_apps.processes.process import PlannedProcess, plan_file

pytestmark = pytest.mark.long

STEP, TICKS = 0.02, 5
"""Time from sample to sample (s), and ticks."""
TOP = 0.46
"""Height (m) of the plate's upper face."""


def cell(client: Client) -> Robot:
    """Return an arm with a tool, its tip 150 mm from the wrist's centre, before a plate of 300 x 300 x 20 mm."""
    arm = client.load_robot("model://puma560", name="arm")
    nozzle = virtualrobot.cylinder(0.004, 0.085, pose=virtualrobot.pose(z=0.1025))
    client.scene.add_tool("tool", arm.flange, [nozzle], tool_center_points={"tip": virtualrobot.pose(z=0.15)})
    plate = virtualrobot.box(0.3, 0.3, 0.02)
    client.scene.add_part("plate", plate, pose=virtualrobot.pose(0.55, 0.0, 0.45))
    client.signals.create("on")
    return arm


def planned(client: Client, folder: Path, text: str) -> PlannedProcess:
    """Return the plan of a file, which keeps all limits and touches nothing."""
    file = folder / "work.yaml"
    file.write_text(f"schema_version: 1\nrobot: arm\n{text}")
    found = plan_file(client, file)
    assert found.program.check().first_violation is None
    return found


def gone(client: Client, arm: Robot, work: PlannedProcess) -> Matrix:
    """Return the pose (n, 4, 4) of the tip after each few ticks, where the signal is on."""
    motion = work.program.start(wait=False)
    poses = []
    for _ in range(int(motion.planned_duration / STEP) + 10):
        client.clock.step(TICKS)
        if client.signals["on"]:
            poses.append(arm.tcp)
    assert motion.wait().phase is virtualrobot.Phase.SUCCEEDED and not client.signals["on"]
    return np.array(poses)


def test_glue_is_laid_along_an_edge(steps: Client, tmp_path: Path) -> None:
    """A bead of half a circle, 2 mm in radius, along 260 mm of an edge, 3 mm above it."""
    arm = cell(steps)
    text = """process: dispense
speed: 0.05
ways: [{part: plate, points: [[-0.1, -0.13, 0.01], [-0.1, 0.13, 0.01]], normal: [0, 0, 1]}]
gun: {standoff: 0.003}
bead: {width: 0.004, height: 0.002}
valve: "on"
"""
    work = planned(steps, tmp_path, text)
    assert f"{1e6 * 0.26 * 0.5 * np.pi * 0.002**2:.3g} ml in beads" in work.measures[-1]
    points = gone(steps, arm, work)[:, :3, 3]
    np.testing.assert_allclose(points[:, [0, 2]], np.tile([0.45, TOP + 0.003], (len(points), 1)), atol=1e-5)
    assert np.ptp(points[:, 1]) == pytest.approx(0.26, abs=1e-3)


def test_a_plate_is_painted_evenly(steps: Client, tmp_path: Path) -> None:
    """Overlap of one half: half-way between two passes the film is thickest, 8 / (3 pi) 2 (3 / 4)^1.5 of the mean.

    That is flow by speed and step over, as far as none of it goes beside the plate. Where the gun reaches its speed and
    loses it, none of its disc is on the plate.
    """
    cell(steps)
    text = """process: paint
speed: 0.2
ways: [{part: plate, raster: {step_over: 0.04, direction: [0, 1, 0], axis: [0, 0, -1], lead_in: 0.08, lead_out: 0.08}}]
gun: {standoff: 0.1}
jet: {width: 0.08, flow_millilitres: 2, solids: 0.5}
tolerance: {rotation: free}
trigger: "on"
"""
    work = planned(steps, tmp_path, text)
    film = next(line for line in work.measures if line.startswith("film on plate"))
    thickest = float(film.split(" um at the most")[0].split()[-1])
    assert thickest == pytest.approx(125.0 * 16 / (3 * np.pi) * 0.75**1.5, rel=0.02)


def test_a_disc_goes_to_and_fro(steps: Client, tmp_path: Path) -> None:
    arm = cell(steps)
    text = """process: grind
speed: 0.05
ways: [{part: plate, points: [[0, -0.1, 0.01], [0, 0.1, 0.01]], normal: [0, 0, 1]}]
tool: {standoff: 0.002}
strokes: 2
motor: "on"
"""
    way = gone(steps, arm, planned(steps, tmp_path, text))[:, 1, 3]
    turn = int(np.abs(way - way[0]).argmax())
    assert np.ptp(way) == pytest.approx(0.2, abs=1e-3) and way[-1] == pytest.approx(way[0], abs=1e-3)
    assert 0.3 < turn / len(way) < 0.7


def test_holes_are_drilled_straight(steps: Client, tmp_path: Path) -> None:
    """Two pecks each: in the plate the tip is on the hole's axis, to 0.02 mm, on its way in and on its way out."""
    arm = cell(steps)
    text = """process: drill
speed: 0.02
approach: 0.05
may_touch: [plate]
holes: [{part: plate, spots: {points: [[0, -0.05, 0.01], [0, 0.05, 0.01]], normal: [0, 0, 1], depth: 0.015, pecks: 2}}]
drill: {heading: [1, 0, 0]}
spindle: {signal: "on"}
diameter: 0.008
length: 0.1
"""
    with pytest.raises(virtualrobot.CollisionError, match=r"'tool' would touch 'plate'|'plate' would touch 'tool'"):
        planned(steps, tmp_path, text.replace("may_touch: [plate]\n", ""))
    with pytest.raises(virtualrobot.UnknownNameError, match="plat"):
        planned(steps, tmp_path, text.replace("may_touch: [plate]", "may_touch: [plat]"))
    work = planned(steps, tmp_path, text)
    assert float(work.measures[-2].split()[0]) == pytest.approx(1e6 * 2 * np.pi * 0.004**2 * 0.015, rel=7e-3)
    points = gone(steps, arm, work)[:, :3, 3]
    inside = points[points[:, 2] < TOP - 1e-4]
    np.testing.assert_allclose(inside[:, 0], 0.55, atol=2e-5)
    np.testing.assert_allclose(np.abs(inside[:, 1]), 0.05, atol=2e-5)
    assert inside[:, 2].min() == pytest.approx(TOP - 0.015, abs=1e-5)
    # They may touch no more; who had let them touch before still does.
    assert not [pair for pair in steps.collisions.allowed.list("tool") if "plate" in (pair.first, pair.second)]
    steps.collisions.allowed.add("tool", "plate", "it drills")
    gone(steps, arm, planned(steps, tmp_path, text))
    assert [pair.reason for pair in steps.collisions.allowed.list("tool") if pair.second == "plate"] == ["it drills"]


def test_a_slot_is_milled_at_the_feeds_of_its_g_code(steps: Client, tmp_path: Path) -> None:
    arm = cell(steps)
    steps.collisions.allowed.add("tool", "plate", "it mills")
    (tmp_path / "slot.nc").write_text("G21 G90\nG0 X-50 Y0 Z12\nG1 Z8 F300\nG1 X50 F900\nG0 Z20\nM2\n")
    text = """process: mill
speed: 0.05
approach: 0.03
cuts: [{part: plate, gcode: slot.nc}]
cutter: {heading: [1, 0, 0]}
spindle: {signal: "on"}
"""
    points = gone(steps, arm, planned(steps, tmp_path, text))[:, :3, 3]
    assert points[:, 2].min() == pytest.approx(TOP - 0.002, abs=1e-5)  # and no deeper at a corner
    deep = points[points[:, 2] < TOP - 0.0015]
    assert np.ptp(deep[:, 0]) == pytest.approx(0.1, abs=2e-3)
    assert np.linalg.norm(np.diff(deep, axis=0), axis=1).max() / STEP < 0.3


def test_spots_are_welded_one_after_the_other(steps: Client, tmp_path: Path) -> None:
    """At each of three spots, 1 mm above the plate, the signal is on for 0.4 s, and the tool stands."""
    arm = cell(steps)
    text = """process: spot_weld
speed: 0.05
spots:
- part: plate
  spots: {points: [[0, -0.1, 0.011], [0, 0.1, 0.011], [0, 0, 0.011]], normal: [0, 0, 1], order: shortest}
tongs: {heading: [1, 0, 0]}
weld: {signal: "on", seconds: 0.4}
"""
    points = gone(steps, arm, planned(steps, tmp_path, text))[:, :3, 3]
    assert len(points) * STEP == pytest.approx(1.2, abs=0.08)
    places = np.unique(np.round(points, 4), axis=0)
    np.testing.assert_allclose(places[:, 1], [-0.1, 0.0, 0.1], atol=1e-4)


def test_a_process_leaves_for_a_controller(steps: Client, tmp_path: Path) -> None:
    """A bead in RAPID: its lines are along the way, and the signal is set before the first and after the last one."""
    arm = cell(steps)
    text = """process: tool_path
speed: 0.05
ways: [{part: plate, points: [[0, -0.1, 0.012], [0.02, 0, 0.012], [0, 0.1, 0.012]], normal: [0, 0, 1]}]
signal: "on"
"""
    work = planned(steps, tmp_path, text)
    lines = rapid.write(robot_program(steps, work.program, arm, "bead"), Language({})).splitlines()
    on, off = (next(row for row, line in enumerate(lines) if f"SetDO on, {value};" in line) for value in (1, 0))
    between = [line for line in lines[on:off] if "Move" in line]
    assert len(between) > 3 and all("MoveL" in line for line in between)
    assert "fine" in between[-1] and not any("fine" in line for line in between[:-1])
