"""Vehicles under water through the client: made by a call, saved with the water about them, undone, refused by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
import virtualrobot_plugins.marine
import yaml
from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError, LimitError, WrongStateError

pytestmark = pytest.mark.long
VEHICLES = Path(virtualrobot_plugins.marine.__file__).parent / "vehicles"
SEA = {"current": (0.2, 0.0, 0.0), "density": 1026.0, "surface": 10.0}


@pytest.fixture
def steps(client: Client) -> Client:
    """Return a client whose clock goes on by steps."""
    client.clock.set_stepped()
    return client


@pytest.fixture
def auv(steps: Client) -> virtualrobot.Robot:
    """Return a REMUS 100 in the sea."""
    robot = steps.load_robot("model://remus100", name="auv")
    steps.scene.set_craft("auv", "fossen", {"vehicle": "remus100"}, **SEA)
    return robot


def test_it_drifts_swims_and_is_saved_with_its_water(steps: Client, auv: virtualrobot.Robot, tmp_path: Path) -> None:
    steps.clock.step(250)
    drifted = auv.positions[0]
    assert drifted > 1e-3
    with auv.stream("velocity", ["propeller"], timeout=10.0) as stream:
        stream.send([150.0], wait=True)
        state = steps.clock.step(500).robots["auv"]
        assert state.velocities[6] == pytest.approx(150.0 * (1.0 - np.exp(-2.0)), rel=0.02)
        assert state.positions[0] > drifted + 0.5
        stream.cancel()
    (file, *_) = steps.scene.save(tmp_path / "sea.yaml")
    text = file.read_text()
    assert "fossen" in text
    assert "density: 1026" in text
    steps.scene.load_scene(file)
    before = steps.robot("auv").positions[0]
    steps.clock.step(50)
    assert steps.robot("auv").positions[0] > before


def test_it_is_no_vehicle_any_more_after_an_undo(steps: Client, auv: virtualrobot.Robot) -> None:
    steps.undo()
    there = auv.positions
    steps.clock.step(50)
    np.testing.assert_array_equal(auv.positions, there)


def test_its_base_is_its_own(steps: Client, auv: virtualrobot.Robot) -> None:
    with pytest.raises(WrongStateError, match="is moved by the drives of the craft 'auv'"):
        auv.stream("velocity", ["base"])


@pytest.mark.parametrize("way", ["stream", "step"])
def test_a_setpoint_past_the_table_of_its_drive_is_refused(steps: Client, auv: virtualrobot.Robot, way: str) -> None:
    """The joint takes 159.7 rad/s; the table of a REMUS without its last entries ends at 1334.375 rpm."""
    shorter = yaml.safe_load((VEHICLES / "remus100.yaml").read_text("utf-8"))
    thrust = shorter["thrusters"][0]["thrust"]
    thrust["of"], thrust["value"] = thrust["of"][1:-1], thrust["value"][1:-1]
    steps.scene.set_craft("auv", "fossen", {"vehicle": shorter}, **SEA)
    most = 1334.375 * 2.0 * np.pi / 60.0
    told = rf"'propeller' is told 150, and the table of its drive 'propeller' goes from -{most:.6g} to {most:.6g} rad/s"
    with pytest.raises(LimitError, match=told):
        if way == "step":
            steps.clock.step(10, velocities={"auv": {"propeller": 150.0}})
        else:
            with auv.stream("velocity", ["propeller"], timeout=10.0) as stream:
                stream.send([150.0], wait=True)
    steps.clock.step(5)
    assert steps.clock.step(100, velocities={"auv": {"propeller": most}}).robots["auv"].velocities[6] > 1.0


def test_a_vehicle_that_there_is_not_is_refused(steps: Client) -> None:
    steps.load_robot("model://remus100", name="auv")
    with pytest.raises(InvalidArgumentError, match="no vehicle 'nautilus'; the bundled ones are bluerov2_heavy, remus"):
        steps.scene.set_craft("auv", "fossen", {"vehicle": "nautilus"})
