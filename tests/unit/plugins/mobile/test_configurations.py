"""Crafts of the document "VirtualRobot": which drives of each are ahead-, steering- and steer-ahead-drives.

An active ahead-drive makes the craft move, a passive one is turned by its motion; a steer-ahead-drive is an ahead-drive
on a steering-drive. The four configurations turn by the equations 2.1 and 2.2 of the document on the Boe-Bot:
theta' = v / R1, R1 = b1 / tan(alpha).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from virtualrobot_plugins.mobile.ackermann import Ackermann, AckermannSettings
from virtualrobot_plugins.mobile.bicycle import Bicycle, BicycleSettings
from virtualrobot_plugins.mobile.differential import Differential, DifferentialSettings
from virtualrobot_plugins.mobile.mecanum import Mecanum, MecanumSettings
from virtualrobot_plugins.mobile.omnidirectional import Omnidirectional, OmnidirectionalSettings
from virtualrobot_plugins.mobile.skid_steer import SkidSteer, SkidSteerSettings
from virtualrobot_plugins.mobile.tricycle import Tricycle, TricycleSettings
from virtualrobot_sdk.mobile import MobileKinematics

BASE, TRACK, RADIUS = 0.8, 0.5, 0.1


@dataclass(frozen=True)
class Configuration:
    """Craft, and its drives by their kind."""

    craft: MobileKinematics
    active: tuple[str, ...]
    passive: tuple[str, ...] = ()
    steering: tuple[str, ...] = ()
    steer_ahead: tuple[str, ...] = ()


SIDES = ("front_left", "front_right", "rear_left", "rear_right")
FOUR = tuple(f"{side}_wheel" for side in SIDES)

CONFIGURATIONS = {
    "differential": Configuration(Differential(DifferentialSettings(TRACK, RADIUS)), ("left_wheel", "right_wheel")),
    "skid_steer": Configuration(SkidSteer(SkidSteerSettings(TRACK, RADIUS)), FOUR),
    "mecanum": Configuration(Mecanum(MecanumSettings(BASE, TRACK, RADIUS)), FOUR),
    "omnidirectional": Configuration(
        Omnidirectional(OmnidirectionalSettings(TRACK, RADIUS)), ("wheel_1", "wheel_2", "wheel_3")
    ),
    # The document's own example: of a bicycle the front wheel is passive, and the rear wheel active.
    "bicycle": Configuration(Bicycle(BicycleSettings(BASE, RADIUS)), ("rear_wheel",), ("front_wheel",), ("steering",)),
    # And "the pair handlebar-wheel of a tricycle" is a steer-ahead-drive.
    "tricycle": Configuration(
        Tricycle(TricycleSettings(BASE, TRACK, RADIUS)),
        ("front_wheel",),
        ("rear_left_wheel", "rear_right_wheel"),
        ("steering",),
        ("front_wheel",),
    ),
    "bicycle, front driven": Configuration(
        Bicycle(BicycleSettings(BASE, RADIUS, "front")),
        ("front_wheel",),
        ("rear_wheel",),
        ("steering",),
        ("front_wheel",),
    ),
    "ackermann": Configuration(
        Ackermann(AckermannSettings(BASE, TRACK, RADIUS)),
        ("rear_left_wheel",),
        ("front_left_wheel", "front_right_wheel", "rear_right_wheel"),
        ("front_left_steering", "front_right_steering"),
    ),
    "ackermann, front driven": Configuration(
        Ackermann(AckermannSettings(BASE, TRACK, RADIUS, driven="front")),
        ("front_left_wheel",),
        ("front_right_wheel", "rear_left_wheel", "rear_right_wheel"),
        ("front_left_steering", "front_right_steering"),
        ("front_left_wheel",),
    ),
}


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_each_drive_is_of_its_kind(name: str) -> None:
    """Told alone, an active drive moves the craft, and a steering one does not; passive ones are told nothing."""
    one = CONFIGURATIONS[name]
    craft = one.craft
    told = [*one.active, *(drive for drive in one.steering if drive in craft.drive_names)]
    assert sorted(craft.drive_names) == sorted(told)
    followers = [drive for drive in one.steering if drive not in craft.drive_names]
    assert sorted(craft.passive_names) == sorted([*one.passive, *followers])
    states = np.zeros(len(craft.drive_names))
    for place, drive in enumerate(craft.drive_names):
        twist = craft.base_twist(states, np.eye(len(states))[place])
        assert bool(np.abs(twist).max() > 1e-3) == (drive in one.active)


@pytest.mark.parametrize("name", [name for name, one in CONFIGURATIONS.items() if one.passive])
def test_passive_wheels_turn_with_the_craft_and_with_nothing_else(name: str) -> None:
    one = CONFIGURATIONS[name]
    craft = one.craft
    ahead = craft.drive_commands(np.array([0.3, 0.0, 0.0]), np.zeros(len(craft.drive_names)), 1.0)
    before, states = np.zeros(len(craft.passive_names)), np.zeros(len(craft.drive_names))
    turned = dict(zip(craft.passive_names, craft.passive_states(before, states, ahead, 2.0), strict=True))
    for wheel in one.passive:
        assert turned[wheel] == pytest.approx(0.3 * 2.0 / RADIUS)
    rests = dict(zip(craft.passive_names, craft.passive_states(before, states, 0.0 * ahead, 2.0), strict=True))
    assert all(rests[wheel] == 0.0 for wheel in one.passive)


@pytest.mark.parametrize("name", [name for name, one in CONFIGURATIONS.items() if one.steering])
@pytest.mark.parametrize("alpha", [-0.45, 0.1, 0.5])
def test_steered_ones_turn_by_equations_2_1_and_2_2(name: str, alpha: float) -> None:
    """R1 = b1 / tan(alpha) with the steering angle of the middle: of a car's left wheel it is half a track less.

    A steer-ahead-drive drives at its own wheel, at v / cos(alpha).
    """
    craft = CONFIGURATIONS[name].craft
    middle = BASE / math.tan(alpha)
    if isinstance(craft, Ackermann):
        middle += TRACK / 2.0
    states = np.array([alpha, 0.0])
    commands = craft.drive_commands(np.array([0.4, 0.0, 0.4 / middle]), states, 1.0)
    assert commands[0] == pytest.approx(0.0, abs=1e-12)  # it is steered so already
    np.testing.assert_allclose(craft.base_twist(states, commands), [0.4, 0.0, 0.4 / middle], atol=1e-12)
    wheel = next(drive for drive in craft.drive_names if drive.endswith("wheel"))
    side = TRACK / 2.0 if "left" in wheel else 0.0
    inner = 0.4 / middle * math.hypot(middle - side, BASE if wheel.startswith("front") else 0.0)
    assert commands[1] * RADIUS == pytest.approx(abs(inner))


@pytest.mark.parametrize("name", ["differential", "skid_steer"])
def test_those_without_steering_turn_about_the_radius_that_their_sides_make(name: str) -> None:
    """Equation 2.1 with R1 = d / 2 (right + left) / (right - left): Siegwart and Nourbakhsh, section 3.2."""
    craft = CONFIGURATIONS[name].craft
    left, right = 2.0, 3.0
    commands = np.array([right if "right" in drive else left for drive in craft.drive_names])
    vx, vy, turning = craft.base_twist(np.zeros(len(commands)), commands)
    assert (vx, vy) == (pytest.approx(RADIUS * (left + right) / 2.0), pytest.approx(0.0, abs=1e-15))
    assert turning == pytest.approx(vx / (TRACK / 2.0 * (right + left) / (right - left)))
