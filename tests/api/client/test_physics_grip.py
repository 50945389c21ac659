"""Grippers under physics: fingers that are geared together, and hold by friction alone what forces say they can."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, JointMotor

from tests.api.client.physics_world import floor, place
from tests.kernels import KernelProcess, Stubs

ENGINES = ["mujoco", pytest.param("bullet", marks=pytest.mark.long)]
GRAVITY, MASS, WIDTH, FRICTION = 9.81, 0.2, 0.03, 0.5
NEEDED = MASS * GRAVITY / FRICTION
"""Effort (N) of the one motor of both fingers by which they just hold: each presses by half of it, and rubs by that
times the coefficient of friction (Coulomb)."""
DOWN = (np.pi, 0.0, 0.0)
OVER = virtualrobot.pose(0.45, 0.1, 0.15, *DOWN)


@pytest.fixture
def client(stepped_kernel: KernelProcess, stepped: Stubs) -> Client:
    """Return a client of a world with a floor."""
    client = virtualrobot.connect(stepped_kernel.address)
    floor(client)
    return client


def add_box(client: Client, x: float, y: float, z: float) -> None:
    """Put a box of 0.2 kg that is 30 mm wide."""
    figure = virtualrobot.box(WIDTH, WIDTH, 0.05)
    client.scene.add_part("box", figure, pose=virtualrobot.pose(x, y, z), mass=MASS, dynamic=True)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("part", "holds"), [(0.7, False), (1.5, True)])
def test_fingers_hold_what_their_friction_carries(client: Client, engine: str, part: float, holds: bool) -> None:
    hand = client.load_robot("model://parallel_gripper", name="hand", pose=virtualrobot.pose(0, 0, 0.5, *DOWN))
    hand.set_positions([0.03])
    client.scene.add_object("plate", virtualrobot.box(0.2, 0.2, 0.02), pose=virtualrobot.pose(z=0.345))
    add_box(client, 0.0, 0.005, 0.38)
    client.physics.set(engine)
    client.physics.set_motors("hand", {"left_finger": JointMotor("position", max_effort=part * NEEDED)})
    client.physics.enable("hand")
    client.clock.run(hand.move_joints([0.01], wait=False))
    client.clock.step(100)
    assert hand.positions[0] == pytest.approx(WIDTH / 2, abs=5e-4), "the box is between the fingers"
    assert place(client, "box")[1] == pytest.approx(0.0, abs=2e-3), "fingers that are geared bring it to their middle"
    client.scene["plate"].parent_t_node = virtualrobot.pose(1.0)
    client.clock.step(100)
    fallen = 0.38 - place(client, "box")[2]
    assert fallen < 0.004 if holds else fallen > 0.05


@pytest.mark.parametrize("engine", ENGINES)
def test_an_arm_lifts_what_its_fingers_hold_by_friction(client: Client, engine: str) -> None:
    arm = client.load_robot("model://iiwa", name="arm")
    arm.set_positions([0.0, 0.6, 0.0, -1.4, 0.0, 1.1, 0.0])
    hand = arm.mount("model://parallel_gripper", name="hand")
    run = client.clock.run
    run(hand.open(wait=False))
    run(arm.move_pose(OVER, wait=False))
    add_box(client, 0.45, 0.1, 0.025)
    client.physics.set(engine)
    client.physics.enable("arm", "hand")
    client.clock.step(1)
    touch = {name for one in client.physics.status.contacts for name in (one.first, one.second)}
    assert touch == {"box", "floor"}, "an arm doesn't touch itself"
    run(arm.move_linear(virtualrobot.pose(0.45, 0.1, 0.03, *DOWN), wait=False))
    run(hand.move_to_width(0.02, wait=False))
    run(arm.move_linear(OVER, wait=False))
    client.clock.step(100)
    assert place(client, "box") == pytest.approx([0.45, 0.1, 0.145], abs=2e-3)
    assert arm.tcp[:3, 3] == pytest.approx(OVER[:3, 3], abs=2e-3)
    run(hand.open(wait=False))
    client.clock.step(150)
    assert place(client, "box")[2] < 0.027, "it falls where fingers let it go, upright or on a side"
