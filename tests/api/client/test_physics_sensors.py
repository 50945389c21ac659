"""Forces of contacts in sensors: what lies on a plate weighs m g, and a replay without an engine says the same bits."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client

from tests.api.test_replay import replaying
from tests.kernels import StartKernel

GRAVITY = 9.81
MASS = 2.0
ENGINES = ["mujoco", pytest.param("bullet", marks=pytest.mark.long)]


def scales(client: Client, height: float = 0.0) -> None:
    """Put a box of 2 kg so high above a plate, whose top is at 0.2 m, on a force-torque sensor on a pillar."""
    scene = client.scene
    scene.add_object("pillar", virtualrobot.box(0.1, 0.1, 0.16), pose=virtualrobot.pose(z=0.08))
    settings = virtualrobot.force_torque_sensor()
    scene.add_motion_sensor("scale", settings, parent="pillar", pose=virtualrobot.pose(z=0.1))
    scene.add_object("plate", virtualrobot.box(0.5, 0.5, 0.02), parent="scale", pose=virtualrobot.pose(z=0.01))
    scene.add_contact_sensor("skin", virtualrobot.contact_sensor("plate"))
    at = virtualrobot.pose(0.1, 0.05, 0.25 + height)
    scene.add_part("box", virtualrobot.box(0.1, 0.1, 0.1), pose=at, mass=MASS, dynamic=True)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_box_on_a_plate_weighs_m_g(steps: Client, engine: str) -> None:
    scales(steps)
    steps.physics.set(engine)
    steps.clock.step(250)
    wrench = steps.sensors["scale"].read().value
    weight = np.array([0.0, 0.0, -MASS * GRAVITY])
    np.testing.assert_allclose(wrench.force, weight, atol=2e-3 * MASS * GRAVITY)
    # r x F, with the box 0.1 m ahead and 0.05 m to the left of the sensor.
    np.testing.assert_allclose(wrench.torque, np.cross([0.1, 0.05, 0.1], weight), atol=5e-3)
    felt = steps.sensors["skin"].read().value
    assert {(one.element, one.other, one.distance) for one in felt} == {("plate", "box", 0.0)}
    np.testing.assert_allclose(sum(one.force for one in felt), weight, atol=2e-3 * MASS * GRAVITY)
    # By the box's footprint, and about its middle as its weight is.
    points = np.array([one.point for one in felt])
    assert np.abs(points - [0.1, 0.05, 0.2]).max(axis=0) == pytest.approx([0.05, 0.05, 0.0], abs=1.5e-3)
    middle = sum(one.force[2] * one.point for one in felt) / -MASS / GRAVITY
    assert middle == pytest.approx([0.1, 0.05, 0.2], abs=1.5e-3)
    assert all(one.normal == pytest.approx([0.0, 0.0, 1.0], abs=1e-3) for one in felt)


def test_what_is_gone_is_felt_no_more(steps: Client) -> None:
    scales(steps)
    steps.physics.set("mujoco", gravity=(0.0, 0.0, -1.62))
    steps.clock.step(250)
    assert steps.sensors["scale"].read().value.force[2] == pytest.approx(-MASS * 1.62, rel=2e-3)
    steps.scene.set_pose("box", virtualrobot.pose(z=2.0))
    steps.clock.step(1)
    assert steps.sensors["skin"].read().value == ()
    np.testing.assert_array_equal(steps.sensors["scale"].read().value.force, np.zeros(3))
    steps.scene.set_pose("box", virtualrobot.pose(z=0.25))
    steps.clock.step(2)
    assert steps.sensors["scale"].read().value.force[2] < -1.0
    # Without physics, the figures alone say what touches.
    steps.physics.set("none")
    steps.scene.set_pose("box", virtualrobot.pose(z=0.2499))
    felt = steps.sensors["skin"].read().value
    assert {(one.element, one.other, one.force) for one in felt} == {("plate", "box", None)}
    np.testing.assert_array_equal(steps.sensors["scale"].read().value.force, np.zeros(3))


def test_nothing_is_felt_of_what_moves_no_more(steps: Client) -> None:
    scales(steps)
    steps.physics.set("mujoco")
    steps.clock.step(5)
    assert steps.sensors["scale"].read().value.force[2] < -1.0
    steps.physics.disable("box")
    steps.clock.step(1)
    np.testing.assert_array_equal(steps.sensors["scale"].read().value.force, np.zeros(3))


@pytest.mark.long
@pytest.mark.parametrize("engine", ["mujoco", "bullet"])
def test_a_replay_without_an_engine_feels_the_same_bits(start_kernel: StartKernel, tmp_path: Path, engine: str) -> None:
    folder = tmp_path / "cell"
    kernel = start_kernel("--stepped", "--data", str(folder), no_token=True)

    def told(client: Client) -> tuple[object, ...]:
        wrench, felt = client.sensors["scale"].read().value, client.sensors["skin"].read().value
        words = (client.scene.pose("box"), wrench.force, wrench.torque)
        words = (*words, *(each for one in felt for each in (one.point, one.normal, one.force)))
        return len(felt), b"".join(np.asarray(one).tobytes() for one in words)

    seen = {}
    with virtualrobot.connect(kernel.address) as client:
        scales(client, height=0.02)
        client.physics.set(engine)
        for _ in range(12):
            tick = client.clock.step(5).stamp.tick
            seen[tick] = told(client)
    assert kernel.end() == 0
    counts = {count for count, _ in seen.values()}
    assert 0 in counts and max(counts) >= 3, "it falls, and lies on the plate"
    again = replaying(folder)
    with virtualrobot.connect(again.address) as client:
        for tick, before in seen.items():
            client.clock.seek(tick * 0.004)
            assert told(client) == before, tick
        assert [use for one in client.plugins.components("physics_engine") for use in one.uses] == []
    again.end()
