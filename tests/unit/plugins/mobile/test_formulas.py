"""Crafts against formulas: circles, turning by v / R1 with R1 = b1 / tan alpha, and steering at an even rate."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import pytest
from virtualrobot_plugins.mobile.ackermann import Ackermann, AckermannSettings
from virtualrobot_plugins.mobile.bicycle import Bicycle, BicycleSettings
from virtualrobot_plugins.mobile.differential import Differential, DifferentialSettings
from virtualrobot_plugins.mobile.mecanum import Mecanum, MecanumSettings
from virtualrobot_plugins.mobile.skid_steer import SkidSteer, SkidSteerSettings
from virtualrobot_plugins.mobile.steered import Steered
from virtualrobot_plugins.mobile.tricycle import Tricycle, TricycleSettings
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.mobile import MobileKinematics

BASE, TRACK, RADIUS = 0.8, 0.5, 0.1


def after(craft: MobileKinematics, states: Floats, commands: Floats, seconds: float, steps: int = 1) -> np.ndarray:
    """Return x, y and heading after equal steps from the origin, unwrapped over each step."""
    pose, heading = np.eye(4), 0.0
    for _ in range(steps):
        before = pose
        pose, states = craft.step(pose, states, commands, seconds / steps)
        turned = before[:3, :3].T @ pose[:3, :3]
        heading += math.atan2(turned[1, 0], turned[0, 0])
    return np.array([pose[0, 3], pose[1, 3], heading])


def test_equal_commands_make_circles_however_long_the_step() -> None:
    craft = Differential(DifferentialSettings(TRACK, RADIUS))
    commands = craft.drive_commands(np.array([0.5, 0.0, 1.0]), np.zeros(2), 1.0)
    np.testing.assert_allclose(commands, [(0.5 - 0.25) / RADIUS, (0.5 + 0.25) / RADIUS])
    for steps in (1, 7, 250):
        there = after(craft, np.zeros(2), commands, 2.0, steps)
        np.testing.assert_allclose(there, [0.5 * math.sin(2.0), 0.5 * (1.0 - math.cos(2.0)), 2.0], atol=1e-12)


def test_equal_speeds_go_straight_opposite_ones_turn_on_the_spot_and_one_wheel_turns_about_the_other() -> None:
    craft = Differential(DifferentialSettings(TRACK, RADIUS))
    np.testing.assert_allclose(after(craft, np.zeros(2), np.array([3.0, 3.0]), 1.0), [0.3, 0.0, 0.0], atol=1e-14)
    np.testing.assert_allclose(after(craft, np.zeros(2), np.array([-3.0, 3.0]), 1.0), [0.0, 0.0, 1.2], atol=1e-14)
    x, y, turn = after(craft, np.zeros(2), np.array([0.0, 3.0]), 1.0)
    still = np.array([x, y]) + TRACK / 2.0 * np.array([-math.sin(turn), math.cos(turn)])
    np.testing.assert_allclose(still, [0.0, TRACK / 2.0], atol=1e-12)


@pytest.mark.parametrize("driven", ["rear", "front"])
@pytest.mark.parametrize("angle", [-0.5, 0.3])
def test_a_bicycle_turns_by_speed_over_radius(driven: Literal["rear", "front"], angle: float) -> None:
    """It is v / R1 with R1 = b1 / tan alpha, v at the rear wheel; the passive wheel rolls without slip."""
    craft = Bicycle(BicycleSettings(BASE, RADIUS, driven))
    states, commands = np.array([angle, 0.2]), np.array([0.0, 2.0])
    speed = 2.0 * RADIUS * (math.cos(angle) if driven == "front" else 1.0)
    vx, vy, omega = craft.base_twist(states, commands)
    assert (vx, vy) == (pytest.approx(speed), 0.0)
    assert omega == pytest.approx(speed * math.tan(angle) / BASE, abs=1e-15)
    rolled = craft.passive_states(np.zeros(1), states, commands, 0.5)[0]
    assert rolled == pytest.approx(0.5 * 2.0 * (math.cos(angle) if driven == "front" else 1.0 / math.cos(angle)))


def crafts() -> list[Steered]:
    settings = (BASE, TRACK, RADIUS)
    return [
        Bicycle(BicycleSettings(BASE, RADIUS)),
        Bicycle(BicycleSettings(BASE, RADIUS, "front")),
        Tricycle(TricycleSettings(*settings)),
        Ackermann(AckermannSettings(*settings)),
        Ackermann(AckermannSettings(*settings, driven="front")),
    ]


@pytest.mark.parametrize("craft", crafts(), ids=lambda craft: f"{type(craft).__name__}-{craft.drive_names[1]}")
def test_all_wheels_of_a_steered_craft_roll_about_one_point(craft: Steered) -> None:
    """Each wheel's speed is its distance from the centre of the circle times the turning, and it is across to it."""
    states, commands = np.array([0.4, 0.0]), np.array([0.0, 3.0])
    vx, _, omega = craft.base_twist(states, commands)
    centre = np.array([0.0, vx / omega])
    still = craft.passive_states(np.zeros(len(craft.passive_names)), states, np.zeros(2), 1.0)
    turned = dict(zip(craft.passive_names, craft.passive_states(still, states, commands, 1.0) - still, strict=True))
    turned[craft.drive_names[1]] = 3.0
    angles = dict(zip(craft.passive_names, still, strict=True)) | {craft.drive_names[0]: 0.4}
    for name, rolled in turned.items():
        if not name.endswith("_wheel"):
            continue
        side = 1.0 if "left" in name else -1.0 if "right" in name else 0.0
        arm = np.array([BASE if name.startswith("front") else 0.0, side * TRACK / 2.0]) - centre
        assert rolled * RADIUS == pytest.approx(omega * np.hypot(*arm)), name
        if name.startswith("front"):
            steering = angles.get(name.replace("wheel", "steering"), 0.4)
            assert math.tan(steering) == pytest.approx(-arm[0] / arm[1] if arm[1] else np.inf), name


@pytest.mark.parametrize("craft", crafts(), ids=lambda craft: f"{type(craft).__name__}-{craft.drive_names[1]}")
def test_an_angle_that_turns_evenly_comes_where_small_steps_come(craft: Steered) -> None:
    """Against the same way in 4000 steps at constant angles (the middle ones), whose error is below 1e-7."""
    states, commands = np.array([-0.3, 0.0]), np.array([0.8, 2.0])
    pose, count = np.eye(4), 4000
    for place in range(count):
        middle = states + commands * (place + 0.5) / count
        pose, _ = craft.step(pose, middle, commands * (0.0, 1.0), 1.0 / count)
    wanted = [pose[0, 3], pose[1, 3], math.atan2(pose[1, 0], pose[0, 0])]
    np.testing.assert_allclose(after(craft, states, commands, 1.0), wanted, atol=1e-7)
    np.testing.assert_allclose(after(craft, states, commands, 1.0), after(craft, states, commands, 1.0, 10), atol=1e-11)


def test_steering_stops_at_its_stop_and_a_step_over_it_is_as_good() -> None:
    craft = Bicycle(BicycleSettings(BASE, RADIUS, steering_limit_radians=0.5))
    states, commands = np.array([0.4, 0.0]), np.array([1.0, 3.0])
    assert craft.step(np.eye(4), states, commands, 0.3)[1].tolist() == [0.5, pytest.approx(0.9)]
    np.testing.assert_allclose(after(craft, states, commands, 0.3), after(craft, states, commands, 0.3, 9), atol=1e-13)


def test_what_a_craft_cannot_do_is_refused_in_words() -> None:
    two, car = Differential(DifferentialSettings(TRACK, RADIUS)), Ackermann(AckermannSettings(BASE, TRACK, RADIUS))
    with pytest.raises(ArgumentError, match=r"cannot move to the side, at 0\.2 m/s"):
        two.drive_commands(np.array([0.5, 0.2, 0.0]), np.zeros(2), 1.0)
    with pytest.raises(ArgumentError, match="cannot turn on the spot, at 1 rad/s"):
        car.drive_commands(np.array([0.0, 0.0, 1.0]), np.zeros(2), 1.0)
    with pytest.raises(ArgumentError, match=r"on a radius of 0\.5 m; its smallest to that side is 1\.42 m"):
        car.drive_commands(np.array([0.5, 0.0, 1.0]), np.zeros(2), 1.0)
    with pytest.raises(ArgumentError, match=r"its smallest to that side is 0\.919 m"):
        car.drive_commands(np.array([0.5, 0.0, -1.0]), np.zeros(2), 1.0)


def test_skidding_wheels_turn_it_less_and_mecanum_wheels_move_it_to_the_side() -> None:
    four = SkidSteer(SkidSteerSettings(TRACK, RADIUS, slip=2.0))
    np.testing.assert_allclose(
        four.base_twist(np.zeros(4), np.array([-1.0, 1.0, -1.0, 1.0])), [0.0, 0.0, RADIUS / TRACK], atol=1e-15
    )
    side = Mecanum(MecanumSettings(BASE, TRACK, RADIUS))
    np.testing.assert_allclose(
        side.base_twist(np.zeros(4), np.array([-1.0, 1.0, 1.0, -1.0])), [0.0, RADIUS, 0.0], atol=1e-15
    )


@pytest.mark.parametrize(
    ("counts", "off"),
    [(8, 0.138), *(pytest.param(*one, marks=pytest.mark.long) for one in ((64, 0.0052), (360, 0.0003)))],
)
def test_odometry_drifts_by_what_its_encoders_leave_out(counts: int, off: float) -> None:
    """A square of 2 m is driven on true angles of the wheels, and reckoned by whole counts of them."""
    craft = Differential(DifferentialSettings(0.24, 0.05))
    true = reckoned = np.eye(4)
    states, told = np.zeros(2), np.zeros(2)
    for _ in range(4):
        for twist, seconds in (((0.5, 0.0, 0.0), 4.0), ((0.0, 0.0, 1.0), math.pi / 2.0)):
            commands = craft.drive_commands(np.array(twist), states, 1.0)
            count = round(seconds / 0.004)
            for _ in range(count):
                true, states = craft.step(true, states, commands, seconds / count)
                # So little off a whole count that rounding decides nothing.
                now = np.floor(states * counts / math.tau + 1e-7) * math.tau / counts
                reckoned, told = craft.step(reckoned, told, now - told, 1.0)
    assert np.linalg.norm((true - reckoned)[:2, 3]) == pytest.approx(off, rel=0.1)
