"""Walking machines in a kernel: feet that don't slip, support that holds, speed as commanded, ground that is felt."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot.cli import cli
from virtualrobot_apps.vehicles.walking import demo
from virtualrobot_apps.vehicles.walking.course import Part
from virtualrobot_apps.vehicles.walking.footholds import Stand
from virtualrobot_apps.vehicles.walking.gaits import HEXAPOD_GAITS, QUADRUPED_GAITS
from virtualrobot_apps.vehicles.walking.machine import HEXAPOD_LEGS, hexapod
from virtualrobot_apps.vehicles.walking.play import Record, play, strayed
from virtualrobot_apps.vehicles.walking.terrain import SensedGround
from virtualrobot_apps.vehicles.walking.walk import plan_walk

from tests.kernels import KernelProcess

CORNERS = np.array([[0.2, 0.1], [0.2, -0.1], [-0.2, 0.1], [-0.2, -0.1]])


def test_a_leg_is_that_of_its_table(steps: virtualrobot.Client) -> None:
    """The table that README.md of the models prints, against the nodes."""
    machine = hexapod(steps)
    table = {
        "convention": "standard",
        "rows": [{"a_meters": 0.052, "alpha_radians": np.pi / 2}, {"a_meters": 0.066}, {"a_meters": 0.133}],
    }
    leg = machine.legs[3].mechanism
    assert leg.set_kinematics("dh", table).forward_position_error < 1e-9
    assert leg.chain_joint_names == ["coxa", "femur", "tibia"]
    assert [steps.scene.node(f"hexapod.{name}").parent for name in HEXAPOD_LEGS] == ["hexapod.body"] * 6
    # However a tibia is tilted, its end lies within the ball of the foot, which touches the ground before it.
    shank = steps.scene.node("hexapod.left_rear.tibia")._message.figures[0].capsule
    assert 0.133 / 2.0 < (shank.length_meters + 2.0 * shank.radius_meters) / 2.0 < 0.133 / 2.0 + 0.008
    assert shank.radius_meters < 0.008
    assert not steps.collisions.check().pairs


@pytest.mark.long
def test_a_hexapod_walks_without_slipping_or_falling(steps: virtualrobot.Client) -> None:
    machine, ground = demo.build(steps)
    stand, gait = demo.stand_of(machine), HEXAPOD_GAITS["tripod"]
    speed = gait.speed(0.06)
    walk = plan_walk(gait, stand, [Part(1.5 * gait.cycle, speed, 0.0, 0.3)], ground)
    record = play(machine, walk)
    below, _ = ground(record.feet[-1][:, :2])
    np.testing.assert_allclose(below, 0.0, atol=1e-5)
    np.testing.assert_allclose(record.feet[-1][:, 2], machine.foot_radius, atol=1e-5)
    assert record.slips.max() < 1e-4
    assert record.margins.min() > 0.0
    assert record.speed(gait.cycle, 1.5 * gait.cycle) == pytest.approx(0.06 / (0.5 * gait.cycle), rel=1e-4)
    # In each tick feet and body are where the walk has them.
    for place in range(3):
        planned = [np.interp(record.times, walk.times, walk.feet[:, leg, place]) for leg in range(6)]
        assert np.abs(record.feet[:, :, place] - np.transpose(planned)).max() < 2e-4
    assert record.bodies[-1] == pytest.approx(walk.bodies[-1], abs=1e-6)
    assert record.feet[record.stance][:, 2] == pytest.approx(0.008, abs=1e-4)
    # Nothing but feet touches the ground, and no leg another one.
    assert not steps.collisions.check().pairs


@pytest.mark.long
def test_a_hexapod_walks_on_rolling_ground(steps: virtualrobot.Client, seed: int) -> None:
    machine, ground = demo.build(steps, ground_name="rolling", seed=seed)
    assert isinstance(ground, SensedGround)
    gait = HEXAPOD_GAITS["ripple"]
    walk = plan_walk(gait, demo.stand_of(machine, ground_name="rolling"), [Part(gait.cycle, 0.08)], ground)
    record = play(machine, walk)
    # Rays find the ground below feet that stand on it: each ball's middle is its radius above the plane that they meet.
    feet = record.feet[-1]
    below, normals = ground(feet[:, :2])
    np.testing.assert_allclose((feet[:, 2] - below) * normals[:, 2], machine.foot_radius, atol=1e-3)
    assert record.slips.max() < 1e-4
    assert record.margins.min() > 0.0
    heights = np.array([step.goal[2] for of in walk.steps for step in of])
    assert np.ptp(heights) > 0.002


def test_what_cannot_be_walked_is_refused(steps: virtualrobot.Client) -> None:
    machine, ground = demo.build(steps)
    stand, gait = demo.stand_of(machine), HEXAPOD_GAITS["tripod"]
    with pytest.raises(virtualrobot.VirtualRobotError, match=r"the point \d+ is not reached"):
        play(machine, plan_walk(gait, stand, [Part(2.0, 0.9)], ground), shown=False)
    with pytest.raises(ValueError, match="there is no ground for a foot at x"):
        plan_walk(gait, stand, [Part(2.0, 0.1)], ground, (2.9, 0.0, 0.0))
    with pytest.raises(ValueError, match="the ground is level or rolling, not 'ice'"):
        demo.build(steps, ground_name="ice")


@pytest.mark.long
def test_the_demo_tells_its_numbers(stepped_kernel: KernelProcess, tmp_path: Path) -> None:
    plot = tmp_path / "hexapod.svg"
    given = ["demo", "hexapod", "--gait", "tripod", "--plot", str(plot), "--headless"]
    result = CliRunner().invoke(cli, [*given, "--address", stepped_kernel.address])
    assert result.exit_code == 0, result.output
    assert "mm at most, of feet on the ground" in result.output
    assert "stability margin  " in result.output
    assert ElementTree.parse(plot).getroot().tag.endswith("svg")


@pytest.mark.long
@pytest.mark.parametrize("model", ["a1", "aliengo"])
def test_quadrupeds_of_the_catalogue_crawl_and_trot(steps: virtualrobot.Client, model: str) -> None:
    machine, ground = demo.build(steps, model)
    walker = demo.MACHINES[model]
    for name, cycles in (("crawl", 0.5), ("trot", 1.0)):
        gait = QUADRUPED_GAITS[name]
        speed = gait.speed(walker.stroke)
        walk = plan_walk(gait, demo.stand_of(machine, model, name), [Part(cycles * gait.cycle, speed)], ground)
        record = play(machine, walk, shown=False)
        assert record.slips.max() < 2e-4, name
        way = record.bodies[-1][:2, 3] - record.bodies[0][:2, 3]
        # The course is told for some cycles, and one more brings the feet below the body.
        assert way[0] > 0.8 * speed * cycles * gait.cycle, name
        np.testing.assert_allclose(record.feet[-1][:, 2], machine.foot_radius, atol=1e-4)
        # A crawl is statically stable (McGhee and Frank 1968); a trot has two feet in the air, and is not.
        assert bool(record.margins.min() > 0.0) is (name == "crawl"), name
        assert not steps.collisions.check().pairs


@pytest.mark.long
def test_a_quadruped_crawls_on_rolling_ground(steps: virtualrobot.Client, seed: int) -> None:
    machine, ground = demo.build(steps, "a1", "rolling", seed)
    gait = QUADRUPED_GAITS["crawl"]
    stand = demo.stand_of(machine, "a1", "crawl", "rolling")
    record = play(machine, plan_walk(gait, stand, [Part(0.5 * gait.cycle, 0.03)], ground), shown=False)
    below, normals = ground(record.feet[-1][:, :2])
    np.testing.assert_allclose((record.feet[-1][:, 2] - below) * normals[:, 2], machine.foot_radius, atol=1e-3)
    assert record.slips.max() < 1e-4


@pytest.mark.long
def test_the_demo_trots(stepped_kernel: KernelProcess) -> None:
    arguments = ["demo", "quadruped", "--gait", "trot", "--ground", "level", "--address", stepped_kernel.address]
    result = CliRunner().invoke(cli, [*arguments, "--headless"])
    assert result.exit_code == 0, result.output
    assert "a1, trot on level ground: duty factor 0.5, cycle 0.5 s" in result.output
    assert "stability margin" in result.output


@pytest.mark.long
@pytest.mark.parametrize("slope", [0.0, 5.0])
def test_a_hexapod_walks_by_forces(steps: virtualrobot.Client, slope: float) -> None:
    machine, ground = demo.build(steps, slope=np.radians(slope), engine="mujoco")
    gait = HEXAPOD_GAITS["tripod"]
    speed = gait.speed(0.06)
    walk = plan_walk(gait, demo.stand_of(machine), [Part(gait.cycle, speed)], ground)
    record = play(machine, walk, shown=False)
    gone = record.bodies[-1][:3, 3] - record.bodies[0][:3, 3]
    planned = walk.bodies[-1][:3, 3] - walk.bodies[0][:3, 3]
    assert gone == pytest.approx(planned, abs=0.1 * float(np.linalg.norm(planned)))
    assert gone[2] == pytest.approx(gone[0] * np.tan(np.radians(slope)), abs=0.01)
    # It stands as high above the ground, and as level with it, as it is planned.
    np.testing.assert_allclose(record.bodies[:, 2, 2], np.cos(np.radians(slope)), atol=0.01)
    assert record.margins.min() > 0.0
    assert steps.physics.status.fault == ""


@pytest.mark.long
@pytest.mark.parametrize("engine", ["mujoco", "bullet"])
def test_a_hexapod_walks_on_rolling_ground_by_forces(steps: virtualrobot.Client, engine: str) -> None:
    """Feet stand on the surface that rays find, which a hull of the ground would be far above."""
    machine, ground = demo.build(steps, ground_name="rolling", engine=engine)
    gait = HEXAPOD_GAITS["tripod"]
    walk = plan_walk(gait, demo.stand_of(machine, ground_name="rolling"), [Part(gait.cycle, gait.speed(0.06))], ground)
    record = play(machine, walk, shown=False)
    off = strayed(record, walk)
    assert off.fell is None
    planned = float(np.linalg.norm(walk.bodies[-1][:2, 3] - walk.bodies[0][:2, 3]))
    assert off.way < 0.15 * planned
    assert off.tilt < np.radians(4.0)
    assert record.margins.min() > 0.0
    below, normals = ground(record.feet[-1][:, :2])
    np.testing.assert_allclose((record.feet[-1][:, 2] - below) * normals[:, 2], machine.foot_radius, atol=3e-3)
    assert steps.physics.status.fault == ""


@pytest.mark.long
@pytest.mark.parametrize(
    ("gait_name", "engine", "slope", "cycles", "part", "tilt"),
    [
        ("trot", "mujoco", 0.0, 4.0, 0.1, 5.0),
        ("trot", "mujoco", 3.0, 4.0, 0.1, 5.0),
        ("crawl", "bullet", 0.0, 1.0, 0.2, 2.0),
        # Its motors yield, and the plan's margin is 0.3 mm as it begins: it leans on the foot that is lifted.
        ("crawl", "mujoco", 0.0, 1.0, 0.7, 8.0),
    ],
)
def test_a_quadruped_walks_by_forces(
    steps: virtualrobot.Client, gait_name: str, engine: str, slope: float, cycles: float, part: float, tilt: float
) -> None:
    machine, ground = demo.build(steps, "a1", slope=np.radians(slope), engine=engine)
    gait = QUADRUPED_GAITS[gait_name]
    course = [Part(cycles * gait.cycle, gait.speed(0.08))]
    walk = plan_walk(gait, demo.stand_of(machine, "a1", gait_name), course, ground)
    off = strayed(play(machine, walk, shown=False), walk)
    assert off.fell is None
    assert off.way < part * float(np.linalg.norm(walk.bodies[-1][:3, 3] - walk.bodies[0][:3, 3]))
    assert off.tilt < np.radians(tilt)
    assert steps.physics.status.fault == ""


def test_a_walk_that_falls_is_told() -> None:
    """A body 0.1 m above its feet: tilted by 60 degrees from its second instant on, or sunk to 0.04 m."""
    walk = plan_walk(QUADRUPED_GAITS["trot"], Stand(CORNERS, 0.1, 0.0, 0.02), [Part(0.5)])
    times = np.array([0.0, 0.004, 0.008])
    bodies, feet = np.repeat(walk.bodies[:1], 3, axis=0), np.repeat(walk.feet[:1], 3, axis=0)
    record = Record(times, bodies, feet, bodies[:, :3, 3], np.ones((3, 4), bool), np.ones(3))
    off = strayed(record, walk)
    assert (off.way, off.tilt, off.fell) == (pytest.approx(0.0, abs=1e-9), pytest.approx(0.0, abs=1e-6), None)
    tilted, sunk = bodies.copy(), bodies.copy()
    tilted[1:, :3, :3] = virtualrobot.pose(roll=np.pi / 3.0)[:3, :3]
    sunk[2:, 2, 3] = 0.04
    off = strayed(replace(record, bodies=tilted), walk)
    assert (off.tilt, off.fell) == (pytest.approx(np.pi / 3.0), 0.004)
    off = strayed(replace(record, bodies=sunk), walk)
    assert (off.way, off.tilt, off.fell) == (pytest.approx(0.06), pytest.approx(0.0, abs=1e-6), 0.008)


@pytest.mark.parametrize("machine", ["hexapod", "quadruped"])
def test_rolling_ground_has_no_slope(machine: str) -> None:
    result = CliRunner().invoke(cli, ["demo", machine, "--slope", "5"])
    assert result.exit_code == 2
    assert "--slope is of level ground: say --ground level" in result.output


@pytest.mark.long
def test_the_demo_by_forces_tells_whether_it_fell(stepped_kernel: KernelProcess) -> None:
    given = ["demo", "quadruped", "--gait", "trot", "--physics", "mujoco", "--ground", "level", "--headless"]
    result = CliRunner().invoke(cli, [*given, "--address", stepped_kernel.address])
    assert result.exit_code == 0, result.output
    assert "a1 by mujoco, trot on level ground" in result.output
    assert "off its plan" in result.output
    assert "did not fall" in result.output or "fell after" in result.output
