"""Crafts by the client over TCP: robots of the catalogue drive by twists, stop without them, and are saved."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError, LimitError, MotionAbortedError, WrongStateError
from virtualrobot.motions.state import Phase
from virtualrobot.robots.robot import Robot

from tests.api.client.conftest import Run
from tests.kernels import KernelProcess

LONG = 1e6
"""A timeout in seconds that never comes."""

HUSKY_RADIUS = 0.17775
"""Radius of its wheels (m), as their URDF has it."""


@pytest.fixture
def yard(client: Client) -> Client:
    """Return a client whose time goes on by steps."""
    client.clock.set_stepped()
    return client


def place(client: Client, link: str) -> np.ndarray:
    """Return x, y and the heading of a link."""
    pose = client.scene.poses()[link]
    return np.array([pose[0, 3], pose[1, 3], math.atan2(pose[1, 0], pose[0, 0])])


def driven(client: Client, robot: Robot, twist: tuple[float, float, float], ticks: int) -> np.ndarray:
    """Return the base's twist at the end of some ticks of a twist; then the craft comes to rest."""
    with robot.stream_twist(timeout=LONG) as stream:
        stream.send(twist, wait=True)
        now = client.clock.step(ticks).stamp.simulation_time
        told = next(state.velocities for state in stream if state.time >= now - 1e-9)
        stream.send((0.0, 0.0, 0.0), wait=True)
        client.clock.step(500)
        stream.cancel()  # it would wait for ticks
    client.clock.step(2)
    return told


@pytest.mark.parametrize(
    ("model", "root", "twist", "forward"),
    [
        ("husky", "base_footprint", (0.2, 0.0, 0.2), 0.0),
        pytest.param("r2d2", "base_link", (0.05, 0.0, 0.05), math.pi / 2.0, marks=pytest.mark.long),
        pytest.param("racecar", "base_link", (0.08, 0.0, -0.1), 0.0, marks=pytest.mark.long),
        pytest.param("ridgeback", "base_link", (0.2, 0.1, 0.1), 0.0, marks=pytest.mark.long),
        pytest.param("seekur", "base", (0.1, 0.1, 0.1), 0.0, marks=pytest.mark.long),
        pytest.param("frankie", "panda_base_arm", (0.2, 0.0, 0.2), 0.0, marks=pytest.mark.long),
        pytest.param("frankie_omni", "panda_base_arm", (0.1, 0.1, 0.1), 0.0, marks=pytest.mark.long),
    ],
)
def test_crafts_of_the_catalogue_drive(
    yard: Client, model: str, root: str, twist: tuple[float, float, float], forward: float
) -> None:
    robot = yard.load_robot(f"model://{model}", base="planar")
    told = driven(yard, robot, twist, 750)
    np.testing.assert_allclose(told, twist, atol=1e-6)
    x, y, heading = place(yard, f"{model}.{root}")
    assert heading == pytest.approx(twist[2] * 3.0, rel=0.3)
    assert math.cos(forward + heading / 2.0) * x + math.sin(forward + heading / 2.0) * y > 0.1
    before = place(yard, f"{model}.{root}")
    yard.clock.step(100)
    np.testing.assert_array_equal(place(yard, f"{model}.{root}"), before)


def test_what_it_cannot_do_is_refused_and_silence_stops_it(yard: Client) -> None:
    husky = yard.load_robot("model://husky", base="planar")
    with (
        pytest.raises(InvalidArgumentError, match="cannot move to the side"),
        husky.stream_twist(timeout=LONG) as stream,
    ):
        stream.send((0.1, 0.1, 0.0), wait=True)
    yard.clock.step(10)
    with pytest.raises(LimitError, match="wheel"), husky.stream_twist(timeout=LONG) as stream:
        stream.send((50.0, 0.0, 0.0), wait=True)
    yard.clock.step(10)
    with pytest.raises(WrongStateError, match="is moved by the drives of the craft 'husky'"):
        husky.move_joints({"base/x": 1.0}, wait=False)
    with (
        pytest.raises(MotionAbortedError, match=r"no setpoint came for 0\.1 s"),
        husky.stream_twist(timeout=0.1) as stream,
    ):
        stream.send((0.2, 0.0, 0.0), wait=True)
        yard.clock.step(400)
        list(stream)
    arm = yard.load_robot("model://puma560")
    with pytest.raises(WrongStateError, match="is no craft; make it one with set_craft"):
        arm.stream_twist()


def test_a_twist_beyond_limits_costs_no_other_craft_its_motion(client: Client, kernel: KernelProcess) -> None:
    """In real time: one craft is told to go too fast again and again, and the other one's base keeps to its wheels."""
    husky = client.load_robot("model://husky", base="planar")
    ugv = client.load_robot("model://ugv", base="planar")
    printed = len(kernel.lines)
    with husky.stream_twist(timeout=LONG) as going:
        going.send((0.15, 0.0, 0.0), wait=True)
        for _ in range(20):
            with pytest.raises(LimitError, match="wheel"), ugv.stream_twist(preempt=True) as stream:
                stream.send((20.0, 0.0, 0.0), wait=True)
                list(stream)
        going.send((0.0, 0.0, 0.0))
    places = dict(zip(husky.coordinates, husky.positions.tolist(), strict=True))
    turned = {places[name] for name in places if name.endswith("_wheel")}
    assert len(turned) == 1
    assert places["base/x"] == pytest.approx(HUSKY_RADIUS * turned.pop())
    assert places["base/x"] > 0.0
    assert not [line for line in kernel.lines[printed:] if "ERROR" in line or "Traceback" in line]


def test_a_step_whose_second_twist_is_refused_leaves_the_first_craft_as_it_was(yard: Client) -> None:
    yard.load_robot("model://husky", base="planar")
    yard.load_robot("model://ugv", base="planar")
    yard.clock.step(300, twists={"husky": (0.1, 0.0, 0.0), "ugv": (0.1, 0.0, 0.0)})
    with pytest.raises(LimitError, match="wheel"):
        yard.clock.step(1, twists={"husky": (0.3, 0.0, 0.0), "ugv": (20.0, 0.0, 0.0)})
    speed = yard.clock.step(300).robots["husky"].velocities
    assert speed[0] == pytest.approx(0.1)


@pytest.mark.long
def test_a_robot_becomes_a_craft_and_is_saved_as_one(yard: Client, tmp_path: Path) -> None:
    """The husky of the catalogue with another component, saved, loaded again, and undone."""
    husky = yard.load_robot("model://husky", base="planar")
    wheels = {"wheelbase_meters": 0.512, "track_meters": 0.5708, "wheel_radius_meters": 0.17775}
    yard.scene.set_craft("husky", "mecanum", wheels)
    told = driven(yard, husky, (0.0, 0.2, 0.0), 400)
    np.testing.assert_allclose(told, [0.0, 0.2, 0.0], atol=1e-6)
    assert place(yard, "husky.base_footprint")[1] > 0.2
    yard.scene.save(tmp_path / "yard.yaml")
    yard.scene.load_scene(tmp_path / "yard.yaml")
    np.testing.assert_allclose(driven(yard, yard.robot("husky"), (0.0, 0.2, 0.0), 400), [0.0, 0.2, 0.0], atol=1e-6)
    with pytest.raises(InvalidArgumentError, match="has no drive 'left'"):
        yard.scene.set_craft("husky", "mecanum", wheels, {"left": "front_left_wheel"})
    yard.scene.remove_craft("husky")
    with pytest.raises(WrongStateError, match="is no craft"):
        yard.robot("husky").stream_twist()


@pytest.mark.long
def test_the_command_drives_for_some_seconds(client: Client, run: Run) -> None:
    client.load_robot("model://husky", base="planar")
    said = run("drive", "husky", "--forward", "0.3", "--seconds", "0.5")
    assert said.startswith("husky rests at 0.")
    assert place(client, "husky.base_footprint")[0] > 0.03
    assert "'inf' is no finite number" in run("drive", "husky", "--seconds", "inf", code=2)
    said = run("drive", "husky", "--to", "1", "0", "--forward", "3", code=2)
    assert "--to plans its own speeds; leave --forward" in said
    with pytest.raises(InvalidArgumentError, match="seconds is above 0 and finite, not inf"):
        client.robot("husky").drive(0.1, seconds=math.inf)


@pytest.mark.long
def test_a_planned_way_of_lines_and_arcs_ends_where_it_should(yard: Client) -> None:
    husky = yard.load_robot("model://husky", base="planar")
    motion = husky.drive_path([[0.3, 0.0, 0.4], [0.0, 0.0, -1.0], [-0.2, 0.0, 0.0]], wait=False)
    yard.clock.step(4000)
    assert motion.state.phase is Phase.SUCCEEDED
    turned, back = 0.4 - 1.0, -0.2
    x, y = 0.3 / 0.4 * math.sin(0.4), 0.3 / 0.4 * (1.0 - math.cos(0.4))
    wanted = [x + back * math.cos(turned), y + back * math.sin(turned), turned]
    np.testing.assert_allclose(place(yard, "husky.base_footprint"), wanted, atol=1e-6)
    with pytest.raises(InvalidArgumentError, match="a way has a part at least"):
        husky.drive_path([])
    husky.drive_to(0.5, 0.5, heading=1.0, wait=False)
    yard.clock.step(6000)
    np.testing.assert_allclose(place(yard, "husky.base_footprint"), [0.5, 0.5, 1.0], atol=1e-6)


@pytest.mark.long
def test_a_car_steers_before_it_rolls_and_does_not_turn_on_the_spot(yard: Client) -> None:
    car = yard.load_robot("model://racecar", base="planar")
    car.drive_path([[0.3, 0.0, 0.2], [-0.1, 0.0, 0.1]], wait=False)
    yard.clock.step(6000)
    x, y = 1.5 * math.sin(0.2), 1.5 * (1.0 - math.cos(0.2))
    chord = -0.1 * np.sinc(0.05 / np.pi)
    wanted = [x + chord * math.cos(0.25), y + chord * math.sin(0.25), 0.3]
    np.testing.assert_allclose(place(yard, "racecar.base_link"), wanted, atol=1e-6)
    with pytest.raises(InvalidArgumentError, match="cannot turn on the spot"):
        car.drive_path([[0.0, 0.0, 1.0]], wait=False)
