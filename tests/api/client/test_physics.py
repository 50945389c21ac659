"""Parts that move by forces: they fall, slide, rest, are pushed, and go on where they are let go."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot import Client
from virtualrobot.cli.physics import physics
from virtualrobot.errors import UnknownNameError, VirtualRobotError

from tests.kernels import KernelProcess, Stubs

GRAVITY = 9.81
TICK = 0.004


@pytest.fixture
def cell(stepped_kernel: KernelProcess, stepped: Stubs) -> Iterator[Client]:
    """Return a client of a world with a floor, in which parts fall."""
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.scene.add_object("floor", virtualrobot.box(10.0, 10.0, 1.0), pose=virtualrobot.pose(0.0, 0.0, -0.5))
        client.physics.set("mujoco")
        yield client


PUSHER = """<robot name="pusher">
  <link name="base"/>
  <link name="face"><collision><geometry><box size="0.1 0.4 0.2"/></geometry></collision></link>
  <joint name="slide" type="prismatic">
    <parent link="base"/><child link="face"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" velocity="0.3" effort="10"/>
  </joint>
</robot>"""


@pytest.fixture
def pusher(cell: Client, tmp_path: Path) -> virtualrobot.Robot:
    """Return a robot whose face slides along x, 0.1 m above the floor."""
    file = tmp_path / "pusher.urdf"
    file.write_text(PUSHER)
    return cell.load_robot(file, name="pusher", pose=virtualrobot.pose(0.0, 0.0, 0.12))


def put(client: Client, name: str, *position: float) -> None:
    figure = virtualrobot.box(0.1, 0.1, 0.1)
    client.scene.add_part(name, figure, pose=virtualrobot.pose(*position), mass=1.0, dynamic=True)


def place(client: Client, name: str) -> np.ndarray:
    return client.scene.node(name).pose[:3, 3]


def test_a_box_falls_and_rests(cell: Client) -> None:
    put(cell, "box", 0.0, 0.0, 2.0)
    cell.clock.step(100)
    fallen = 2.0 - GRAVITY * 0.4**2 / 2.0
    assert place(cell, "box") == pytest.approx([0.0, 0.0, fallen], abs=GRAVITY * 0.4 * 0.001)
    status = cell.physics.status
    assert (status.moving_parts, status.gravity.tolist()) == (("box",), [0.0, 0.0, -GRAVITY])
    cell.clock.step(600)
    assert place(cell, "box") == pytest.approx([0.0, 0.0, 0.05], abs=1e-3)
    assert cell.physics.status.moving_parts == ()


def test_a_stack_rests_and_carries_its_weight(cell: Client) -> None:
    for level in range(4):
        put(cell, f"box {level}", 0.0, 0.0, 0.05 + 0.1 * level)
    cell.clock.step(250)
    heights = [place(cell, f"box {level}")[2] for level in range(4)]
    assert heights == pytest.approx([0.05, 0.15, 0.25, 0.35], abs=2e-3)
    felt = sum(one.force[2] for one in cell.physics.status.contacts if (one.first, one.second) == ("floor", "box 0"))
    felt -= sum(one.force[2] for one in cell.physics.status.contacts if (one.first, one.second) == ("box 0", "floor"))
    assert felt == pytest.approx(4.0 * GRAVITY, rel=0.02)


@pytest.mark.long
def test_a_box_slides_down_a_slope(cell: Client) -> None:
    angle = np.radians(30.0)
    tilted = virtualrobot.pose(5.0, 0.0, 2.0, 0.0, angle, 0.0)
    cell.scene.add_object("slope", virtualrobot.box(6.0, 2.0, 0.2, pose=virtualrobot.pose(0, 0, -0.1)), pose=tilted)
    figure = virtualrobot.box(0.1, 0.1, 0.1, pose=virtualrobot.pose(0, 0, 0.05))
    cell.scene.add_part("box", figure, pose=tilted, mass=1.0, dynamic=True)
    cell.clock.step(50)
    begin, moved = place(cell, "box"), []
    for _ in range(5):
        cell.clock.step(50)
        moved.append(float(np.linalg.norm(place(cell, "box") - begin)))
    # The second differences of equal times, each 0.2 s.
    faster = np.diff(np.diff([0.0, *moved])) / 0.2**2
    expected = GRAVITY * (np.sin(angle) - 0.5 * np.cos(angle))
    assert faster.mean() == pytest.approx(expected, rel=0.15)


def test_a_robot_pushes_a_box(cell: Client, pusher: virtualrobot.Robot) -> None:
    put(cell, "box", 0.3, 0.0, 0.05)
    cell.clock.step(10)
    motion = pusher.move_joints([0.5], wait=False)
    cell.clock.run(motion)
    # The pusher's face is 0.05 m before its middle, the box's 0.05 m behind its own.
    assert place(cell, "box")[0] >= 0.5 + 0.1 - 1e-3
    assert place(cell, "box")[1:] == pytest.approx([0.0, 0.05], abs=5e-3)


def test_what_is_held_goes_along_and_goes_on_when_it_is_let_go(cell: Client, pusher: virtualrobot.Robot) -> None:
    put(cell, "box", 0.0, 0.0, 1.0)
    cell.scene.node("box").attach("pusher.face")
    held = place(cell, "box")
    motion = pusher.move_joints([0.5], wait=False)
    cell.clock.step(100)
    assert place(cell, "box")[2] == held[2]
    before = place(cell, "box")
    cell.clock.step(1)
    speed = (place(cell, "box") - before) / TICK
    assert speed[0] > 0.1
    at = place(cell, "box")
    cell.scene.node("box").attach("world")
    cell.clock.step(50)
    fallen = at + speed * 0.2 - np.array([0.0, 0.0, GRAVITY * 0.2**2 / 2.0])
    assert place(cell, "box") == pytest.approx(fallen, abs=5e-3)
    cell.clock.run(motion)


@pytest.mark.long
def test_a_box_that_is_put_elsewhere_falls_from_there(cell: Client) -> None:
    put(cell, "box", 0.0, 0.0, 0.05)
    cell.clock.step(200)
    assert cell.physics.status.moving_parts == ()
    cell.scene.node("box").attach("world", virtualrobot.pose(1.0, 0.0, 1.0))
    cell.clock.step(50)
    assert place(cell, "box") == pytest.approx([1.0, 0.0, 1.0 - GRAVITY * 0.2**2 / 2.0], abs=3e-3)


@pytest.mark.long
def test_what_rests_wakes_when_its_support_goes(cell: Client) -> None:
    cell.scene.add_object("shelf", virtualrobot.box(0.5, 0.5, 0.1), pose=virtualrobot.pose(0.0, 0.0, 0.95))
    put(cell, "box", 0.0, 0.0, 1.05)
    cell.clock.step(200)
    assert place(cell, "box")[2] == pytest.approx(1.05, abs=1e-3)
    assert cell.physics.status.moving_parts == ()
    cell.scene.node("shelf").remove()
    cell.clock.step(50)
    assert place(cell, "box")[2] < 0.9


@pytest.mark.long
def test_engines_are_swapped_while_it_runs(cell: Client) -> None:
    put(cell, "box", 0.0, 0.0, 2.0)
    cell.clock.step(25)
    cell.physics.set("bullet")
    cell.clock.step(25)
    cell.physics.set("mujoco", gravity=(0.0, 0.0, 0.0))
    cell.clock.step(25)
    fast = GRAVITY * 0.2
    assert place(cell, "box")[2] == pytest.approx(2.0 - GRAVITY * 0.2**2 / 2.0 - fast * 0.1, abs=3e-3)
    cell.physics.set("none")
    height = place(cell, "box")[2]
    cell.clock.step(25)
    assert place(cell, "box")[2] == height


@pytest.mark.long
def test_parts_are_let_fall_and_held_by_a_switch(cell: Client) -> None:
    figure = virtualrobot.box(0.1, 0.1, 0.1)
    cell.scene.add_part("box", figure, pose=virtualrobot.pose(0.0, 0.0, 1.0), mass=2.0)
    cell.clock.step(10)
    assert place(cell, "box")[2] == 1.0
    cell.physics.enable("box")
    cell.clock.step(10)
    assert place(cell, "box")[2] < 1.0
    cell.physics.disable("box")
    height = place(cell, "box")[2]
    cell.clock.step(10)
    assert place(cell, "box")[2] == height


def test_what_cannot_move_by_forces_is_named(cell: Client) -> None:
    put(cell, "good", 0.0, 0.0, 1.0)
    figure = virtualrobot.box(0.1, 0.1, 0.1)
    with pytest.raises(VirtualRobotError, match=r"'light' has no mass"):
        cell.scene.add_part("light", figure, dynamic=True)
    thin = virtualrobot.inertial(1.0, diagonal=(1.0, 1.0, 3.0))
    with pytest.raises(VirtualRobotError, match=r"'odd' has the principal moments 1, 1 and 3"):
        cell.scene.add_part("odd", figure, inertial=thin, dynamic=True)
    with pytest.raises(VirtualRobotError, match=r"'empty' has no figure with a volume"):
        cell.scene.add_part("empty", (), mass=1.0, dynamic=True)
    with pytest.raises(UnknownNameError, match="physics_engine component"):
        cell.physics.set("newton")
    with pytest.raises(VirtualRobotError, match="substeps must be 1 to 1000, not 5000"):
        cell.physics.set(substeps=5000)
    with pytest.raises(VirtualRobotError, match=r"'floor' is a node of the kind object; forces move parts and robots"):
        cell.physics.enable("floor")
    cell.load_robot("model://ugv", base="floating")
    with pytest.raises(VirtualRobotError, match=r"'ugv.base' is a link; forces move a robot as a whole: name 'ugv'"):
        cell.physics.enable("ugv.base")
    assert [node.name for node in cell.scene.nodes() if node.kind == "part"] == ["good"]


def test_thin_plates_fall_however_they_are_turned(cell: Client, seed: int) -> None:
    """The moment about a plate's normal is the sum of the others, to the last bit or one above it."""
    rng = np.random.default_rng(seed)
    for at in range(20):
        first, second = 10.0 ** rng.uniform(-5.0, 0.0, 2)
        turn = virtualrobot.pose(0.0, 0.0, 0.0, *rng.uniform(-3.0, 3.0, 3))[:3, :3]
        moments = turn @ np.diag([first, second, first + second]) @ turn.T
        inertial = virtualrobot.inertial(
            1.0, diagonal=np.diag(moments), products=(moments[0, 1], moments[0, 2], moments[1, 2])
        )
        figure, where = virtualrobot.box(0.1, 0.1, 0.01), virtualrobot.pose(float(at), 5.0, 5.0)
        cell.scene.add_part(f"plate_{at}", figure, pose=where, mass=1.0, inertial=inertial, dynamic=True)
    cell.clock.step(50)
    assert not cell.physics.status.fault
    assert place(cell, "plate_7")[2] == pytest.approx(5.0 - GRAVITY * 0.2**2 / 2.0, abs=5e-3)


@pytest.mark.long
def test_an_engine_that_dies_is_named_and_everything_else_goes_on(cell: Client, pusher: virtualrobot.Robot) -> None:
    put(cell, "box", 0.0, 2.0, 3.0)
    cell.physics.set("bullet")
    cell.clock.step(10)
    engines = cell.plugins.components("physics_engine")
    (process,) = (use.process_id for one in engines if one.name == "bullet" for use in one.uses)
    os.kill(process, signal.SIGKILL)
    cell.clock.step(1)
    status = cell.physics.status
    assert "the physics_engine component 'bullet' of the world failed" in status.fault
    assert status.moving_parts == ()
    height = place(cell, "box")[2]
    cell.clock.run(pusher.move_joints([0.1], wait=False))
    assert place(cell, "box")[2] == height
    cell.physics.set("mujoco")
    cell.clock.step(25)
    assert place(cell, "box")[2] == pytest.approx(height - GRAVITY * 0.1**2 / 2.0, abs=1e-3)
    assert cell.physics.status.fault == ""


@pytest.mark.long
def test_a_scene_file_keeps_it(cell: Client, tmp_path: Path) -> None:
    put(cell, "box", 0.0, 0.0, 1.0)
    cell.physics.set(engine_settings={"cone": "pyramidal"}, gravity=(0.0, 0.0, -1.62), substeps=2)
    cell.clock.step(50)
    height = place(cell, "box")[2]
    assert height == pytest.approx(1.0 - 1.62 * 0.2**2 / 2.0, abs=1e-3)
    file = tmp_path / "moon.yaml"
    cell.scene.save(file)
    cell.scene.load_scene(file)
    status = cell.physics.status
    assert (status.engine, status.engine_settings, status.substeps) == ("mujoco", {"cone": "pyramidal"}, 2)
    cell.clock.step(50)
    # It begins at rest: a file has no speeds.
    assert place(cell, "box")[2] == pytest.approx(height - 1.62 * 0.2**2 / 2.0, abs=1e-3)


@pytest.mark.long
def test_undo_and_checkpoints_reach_the_engine(cell: Client) -> None:
    put(cell, "box", 0.0, 0.0, 0.05)
    cell.clock.step(250)
    cell.history.checkpoint("resting")
    cell.scene.set_pose("box", virtualrobot.pose(1.0, 0.0, 2.0))
    cell.clock.step(25)
    cell.history.restore("resting")
    assert place(cell, "box") == pytest.approx([0.0, 0.0, 0.05], abs=1e-3)
    cell.clock.step(25)
    assert place(cell, "box") == pytest.approx([0.0, 0.0, 0.05], abs=1e-3)


@pytest.mark.long
def test_commands_show_and_set_it(cell: Client, stepped_kernel: KernelProcess) -> None:
    put(cell, "box", 0.0, 0.0, 0.05)
    told = CliRunner().invoke(physics, ["use", "mujoco", "--gravity", "0,0,-5", "--address", stepped_kernel.address])
    assert "mujoco moves parts, in 4 steps a tick; gravity is 0, 0, -5 m/s^2" in told.output
    CliRunner().invoke(physics, ["disable", "box", "--address", stepped_kernel.address])
    cell.clock.step(1)
    assert cell.physics.status.moving_parts == ()
