"""Arc welding and G-code in a running cell: the tool every few ticks, and what is refused with its line."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot
from virtualrobot.errors import InvalidArgumentError, MalformedFileError, UnreachableError
from virtualrobot_apps.processes.part import part_mesh
from virtualrobot_apps.processes.process import plan_file
from virtualrobot_apps.processes.sources.edges import edges

from tests.kernels import KernelProcess

pytestmark = pytest.mark.long

TICKS = 4
STEP = 0.004 * TICKS
"""Time from sample to sample (s): a wave of the weave has 25 of them."""
SPEED = 0.02
WELD = """\
schema_version: 1
process: arc_weld
robot: arm
seams:
- {part: plate, near: [-0.05, 0, 0.01], trim: [0.02, 0.02]}
torch: {work_degrees: 45, travel_degrees: 10}
tolerance: {rotation: free, work_degrees: 5, travel_degrees: 5}
speed: 0.02
arc: {signal: arc, start_seconds: 0.2, end_seconds: 0.3}
"""


def cell(client: Client) -> Robot:
    """Return an arm with a torch before a wall of 10 x 200 x 100 mm on a plate, whose upper face is at z = 0.46 m."""
    arm = client.load_robot("model://puma560", name="arm")
    nozzle = virtualrobot.cylinder(0.008, 0.075, pose=virtualrobot.pose(z=0.0975))
    client.scene.add_tool("torch", arm.flange, [nozzle], tool_center_points={"wire": virtualrobot.pose(z=0.15)})
    plate = virtualrobot.box(0.4, 0.3, 0.02)
    client.scene.add_part("plate", plate, pose=virtualrobot.pose(0.65, 0.0, 0.45))
    wall = virtualrobot.box(0.01, 0.2, 0.1)
    client.scene.add_part("wall", wall, pose=virtualrobot.pose(z=0.06), parent="plate")
    client.signals.create("arc")
    return arm


def written(folder: Path, text: str = WELD) -> Path:
    """Return a file that says a text."""
    file = folder / "weld.yaml"
    file.write_text(text)
    return file


def welded(client: Client, arm: Robot, file: Path) -> np.ndarray:
    """Return the pose (n, 4, 4) of the wire, sampled while the arc burns."""
    planned = plan_file(client, file)
    assert planned.program.check().first_violation is None
    motion = planned.program.start(wait=False)
    poses = []
    for _ in range(int(motion.planned_duration / STEP) + 10):
        client.clock.step(TICKS)
        if client.signals["arc"]:
            poses.append(arm.tcp)
    assert motion.wait().phase is virtualrobot.Phase.SUCCEEDED
    assert not client.signals["arc"]
    return np.array(poses)


def test_the_wire_goes_along_the_foot_of_the_wall(steps: Client, tmp_path: Path) -> None:
    """Within 0.01 mm of the line, at its speed to 0.5%, at 45 degrees to the plate and pushed by 10, 5 either way."""
    arm = cell(steps)
    poses = welded(steps, arm, written(tmp_path))
    points = poses[:, :3, 3]
    np.testing.assert_allclose(points[:, [0, 2]], np.tile([0.645, 0.46], (len(points), 1)), atol=1e-5)
    np.testing.assert_allclose(np.sort(points[[0, -1], 1]), [-0.08, 0.08], atol=1e-5)
    speeds = np.abs(np.diff(points[:, 1])) / STEP
    standing, moving = int((speeds < 1e-6).sum()), speeds > 0.99 * SPEED
    assert standing * STEP == pytest.approx(0.5, abs=4 * STEP)
    held = np.flatnonzero(moving)[5:-5]  # beyond its ends it gathers speed, and gives it up
    np.testing.assert_allclose(speeds[held], SPEED, rtol=5e-3)
    assert moving.sum() * STEP == pytest.approx(0.16 / SPEED, abs=0.1)
    z = poses[:, :3, 2]
    work = np.degrees(np.arctan2(z[:, 0], -z[:, 2]))
    travel = np.degrees(np.arcsin(z[:, 1] * np.sign(points[-1, 1] - points[0, 1])))
    # By five degrees about x and then y of a frame that leans ten degrees along the seam.
    five, ten = np.radians([5.0, 10.0])
    aside = np.degrees(np.arctan(np.tan(five) / (np.cos(ten) - np.tan(five) * np.sin(ten))))
    least = np.degrees(np.arcsin(np.cos(five) ** 2 * np.sin(ten) - np.sin(five) * np.cos(ten)))
    assert np.abs(work - 45.0).max() <= aside + 0.01
    assert least - 0.01 <= travel.min() and travel.max() <= 15.0 + 0.01


def test_a_weave_goes_from_side_to_side(steps: Client, tmp_path: Path) -> None:
    """A sine of 4 mm, across torch and seam, in 20 waves; along the seam as fast as is wanted, in the mean."""
    arm = cell(steps)
    points = welded(steps, arm, written(tmp_path, f"{WELD}weave: {{width: 0.004, length: 0.008}}\n"))[:, :3, 3]
    across = (points[:, [0, 2]] - [0.645, 0.46]) @ [np.sqrt(0.5), np.sqrt(0.5)]
    beside = (points[:, [0, 2]] - [0.645, 0.46]) @ [np.sqrt(0.5), -np.sqrt(0.5)]
    way = np.abs(points[:, 1] - points[0, 1])
    np.testing.assert_allclose(np.abs(across), 0.002 * np.abs(np.sin(2.0 * np.pi * way / 0.008)), atol=2e-4)
    assert across.max() == pytest.approx(0.002, abs=2e-5) and across.min() == pytest.approx(-0.002, abs=2e-5)
    np.testing.assert_allclose(beside, 0.0, atol=1e-5)
    assert (np.diff(way) > 1e-7).sum() * STEP == pytest.approx(0.16 / SPEED, rel=0.05)


def test_a_seam_goes_through_targets(steps: Client, tmp_path: Path) -> None:
    """Three that were taught in a bow on the plate, the tool 30 degrees off its normal; one that is moved moves it."""
    arm = cell(steps)
    steps.scene["wall"].remove()
    places = np.array([[-0.1, -0.06, 0.01], [-0.07, 0.0, 0.01], [-0.1, 0.06, 0.01]])
    for name, place in zip("abc", places, strict=True):
        down = virtualrobot.pose(*place, roll=np.pi, pitch=np.radians(-30.0))
        steps.scene.add_target(name, pose=down, parent="plate")
    seam = "- {part: plate, targets: [a, b, c]}"
    text = WELD.replace("- {part: plate, near: [-0.05, 0, 0.01], trim: [0.02, 0.02]}", seam)
    text = text.replace("torch: {work_degrees: 45, travel_degrees: 10}", "torch: {standoff: 0.001}")
    poses = welded(steps, arm, written(tmp_path, text))
    here = poses[:, :3, 3] - [0.65, 0.0, 0.45]
    for place in places:
        assert np.linalg.norm(here - place, axis=1).min() < 1.2e-3
    steps.scene["b"].parent_t_node = virtualrobot.pose(-0.05, 0.0, 0.01, roll=np.pi, pitch=np.radians(-30.0))
    moved = welded(steps, arm, written(tmp_path, text))[:, :3, 3] - [0.65, 0.0, 0.45]
    assert np.linalg.norm(moved - [-0.05, 0.0, 0.01], axis=1).min() < 1.2e-3


def test_a_tool_follows_gcode(steps: Client, tmp_path: Path) -> None:
    """A circle of 60 mm on the plate, whose lines may be 0.1 mm within it; 5 mm before it, straight down."""
    arm = cell(steps)
    steps.scene["wall"].remove()
    (tmp_path / "ring.nc").write_text("G0 X0 Y30\nG3 X0 Y30 J-30\n")
    text = "schema_version: 1\nprocess: tool_path\nrobot: arm\nways: [{part: place, gcode: ring.nc}]\nspeed: 0.1\n"
    steps.scene.add_frame("place", pose=virtualrobot.pose(-0.07, 0.0, 0.01), parent="plate")
    poses = welded(steps, arm, written(tmp_path, f"{text}tool: {{heading: [1, 0, 0], standoff: 0.005}}\nsignal: arc\n"))
    points = poses[:, :3, 3] - [0.58, 0.0, 0.465]
    radii = np.linalg.norm(points[:, :2], axis=1)
    assert 0.03 - 1.2e-4 <= radii.min() and radii.max() <= 0.03 + 2e-5
    np.testing.assert_allclose(points[:, 2], 0.0, atol=1e-5)
    np.testing.assert_allclose(poses[:, :3, 2], np.tile([0.0, 0.0, -1.0], (len(poses), 1)), atol=1e-5)
    speeds = np.linalg.norm(np.diff(points, axis=0), axis=1) / STEP
    quarter = len(speeds) // 4
    np.testing.assert_allclose(speeds[quarter:-quarter], 0.1, rtol=1e-2)  # by chords


def test_the_mesh_of_a_part_is_in_its_own_frame(steps: Client) -> None:
    """Poses of the body and its pieces are no matter: a plate of 400 x 300 x 20 mm with a wall, in one node or two."""
    cell(steps)
    steps.scene["plate"].parent_t_node = virtualrobot.pose(0.3, -0.4, 0.2, roll=0.3, pitch=-0.2, yaw=1.0)
    steps.scene.add_part(
        "other", virtualrobot.box(0.01, 0.2, 0.1), pose=virtualrobot.pose(0.1, 0.0, 0.06), parent="plate"
    )
    mesh = part_mesh(steps, ["plate"])
    np.testing.assert_allclose(mesh.bounds, [[-0.2, -0.15, -0.01], [0.2, 0.15, 0.11]], atol=1e-6)
    assert len(edges(mesh)) == 8
    steps.scene["other"].attach("world")
    assert len(edges(part_mesh(steps, ["plate"]))) == 4
    both = part_mesh(steps, ["plate", "other"])
    assert len(edges(both)) == 8
    with pytest.raises(virtualrobot.UnknownNameError, match="plank"):
        part_mesh(steps, ["plank"])
    with pytest.raises(InvalidArgumentError, match="name the part"):
        part_mesh(steps, [])


def test_what_can_not_be_welded_is_told_with_its_line(steps: Client, tmp_path: Path) -> None:
    cell(steps)
    steps.signals.create("current", 0.0)
    for old, new, error, words in (
        (
            "near: [-0.05, 0, 0.01], ",
            "",
            MalformedFileError,
            r"5: seams\[0\]: 'plate' has 4 concave edges: say by `near",
        ),
        ("part: plate", "part: nothing", virtualrobot.UnknownNameError, "5: seam 1: .*nothing"),
        ("robot: arm", "robot: leg", virtualrobot.UnknownNameError, "3: robot: .*leg"),
        ("speed: 0.02", "speed: 5", virtualrobot.LimitError, "5: seam 1: "),
        (
            "signal: arc",
            "signal: arch",
            MalformedFileError,
            "9: arc.signal: there is no signal 'arch'; did you mean 'arc'",
        ),
        ("signal: arc", "signal: arc, value: 5", MalformedFileError, "'arc' is true or false, .* leave `value` out"),
        ("signal: arc", "signal: current", MalformedFileError, "'current' is a number, .* say its `value`"),
    ):
        with pytest.raises(error, match=words):
            plan_file(steps, written(tmp_path, WELD.replace(old, new))).program.check()
    steps.scene["plate"].parent_t_node = virtualrobot.pose(2.0)
    with pytest.raises(UnreachableError, match=r"weld.yaml:5: seam 1: .*no posture reaches there") as far:
        plan_file(steps, written(tmp_path))
    assert far.value.metadata["line"] == "5"


def test_the_command_plans_and_runs(client: Client, kernel: KernelProcess, tmp_path: Path) -> None:
    cell(client)
    client.clock.set_realtime(5.0)
    environment = {**os.environ, "VIRTUALROBOT_ADDRESS": kernel.address}

    def process(*arguments: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "virtualrobot", "process", *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, env=environment, timeout=300)

    program = tmp_path / "program.json"
    planned = process("plan", written(tmp_path), "--output", program)
    assert planned.returncode == 0, planned.stderr
    assert (
        planned.stdout.startswith("seam 1: 160.0 mm in ") and "keeps all limits and touches nothing" in planned.stdout
    )
    assert client.read_program(program).check().ok
    assert process("plan", tmp_path / "weld.yaml", "--output", tmp_path / "none" / "program.json").returncode == 2
    run = process("run", tmp_path / "weld.yaml")
    assert run.returncode == 0 and run.stdout.rstrip().endswith("is done"), run.stderr
    # Something stands where the torch would pass.
    client.scene.add_object("post", virtualrobot.box(0.02, 0.02, 0.1), pose=virtualrobot.pose(0.63, 0.0, 0.53))
    refused = process("plan", tmp_path / "weld.yaml")
    assert refused.returncode == 1 and "post" in refused.stdout + refused.stderr
