"""Crafts in air and space against closed forms and the laws of mechanics."""

from __future__ import annotations

import math
from typing import Any

import msgspec
import numpy as np
import pytest
import yaml
from virtualrobot_plugins.marine.component import FreeBodyDynamics, FreeBodySettings
from virtualrobot_plugins.marine.vehicle import BODIES, FreeBody
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.vehicles import Surroundings

MASS, GRAVITY, CONSTANT, DRAG = 0.716, 9.80665, 8.54858e-06, 0.00643125
"""Of the Hummingbird: kg, m/s^2, N s^2, N s^2/m^2 along z."""
STILL = Surroundings()


def craft(changed: dict[str, Any] | None = None, **settings: Any) -> FreeBodyDynamics:  # noqa: ANN401
    """Return a Hummingbird with some of its file's values changed, their units and sources kept."""
    found = yaml.safe_load((BODIES / "hummingbird.yaml").read_text("utf-8"))
    for key, value in (changed or {}).items():
        found[key] = {**found[key], "value": value}
    return FreeBodyDynamics(FreeBodySettings(msgspec.convert(found, FreeBody), **settings))


def flown(
    made: FreeBodyDynamics, commands: Floats, seconds: float, twist: Floats | None = None, air: Surroundings = STILL
) -> tuple[Floats, Floats, Floats]:
    """Return pose, twist and states of drives after some time, drives having been as they are told."""
    at = np.eye(4), np.zeros(6) if twist is None else twist, commands
    for _ in range(round(seconds / 0.01)):
        at = made.step(*at, commands, 0.01, air)
    return at


def test_it_hovers_where_thrust_is_its_weight() -> None:
    """Straight between two entries of the table, which are of k w^2: there each of four rotors bears m g / 4."""
    low, high = 838.0 / 8.0 * np.array([4.0, 5.0])
    share = (MASS * GRAVITY / 4.0 - CONSTANT * low**2) / (CONSTANT * (high**2 - low**2))
    pose, twist, _ = flown(craft(), np.full(4, low + share * (high - low)), 5.0)
    assert np.abs(twist).max() < 1e-6  # entries have seven digits
    assert np.abs(pose - np.eye(4)).max() < 1e-5


@pytest.mark.parametrize("density", [1.225, 0.4135])
def test_it_falls_at_the_speed_at_which_drag_is_its_weight(density: float) -> None:
    """Sqrt(m g / b), with b by the density of the air: that of the ground, and of 10 km (standard atmosphere)."""
    twist = flown(craft(density=density), np.zeros(4), 60.0)[1]
    exact = -math.sqrt(MASS * GRAVITY / (DRAG * density / 1.225))
    assert twist[2] == pytest.approx(exact, rel=1e-6)
    assert np.abs(np.delete(twist, 2)).max() < 1e-12


def test_it_falls_freely_where_there_is_no_air_and_goes_straight_where_nothing_weighs() -> None:
    pose, twist, _ = flown(craft(density=0.0), np.zeros(4), 2.0)
    assert (pose[2, 3], twist[2]) == (pytest.approx(-2.0 * GRAVITY), pytest.approx(-2.0 * GRAVITY))
    wind = Surroundings((3.0, -2.0, 1.0))
    pose, twist, _ = flown(craft(density=0.0, gravity=0.0), np.zeros(4), 2.0, np.array([1.0, 2.0, 3.0, 0, 0, 0]), wind)
    np.testing.assert_allclose(pose[:3, 3], [2.0, 4.0, 6.0], atol=1e-9)  # nothing there carries it along
    np.testing.assert_allclose(twist, [1.0, 2.0, 3.0, 0, 0, 0], atol=1e-9)


def test_wind_takes_it_along() -> None:
    """With v the speed against the wind: m v' = -b v^2, so that v = v0 / (1 + b v0 t / m)."""
    twist = flown(craft(gravity=0.0), np.zeros(4), 10.0, air=Surroundings((4.0, 0.0, 0.0)))[1]
    assert twist[0] == pytest.approx(4.0 - 4.0 / (1.0 + 0.0077175 * 4.0 * 10.0 / MASS), abs=1e-9)


@pytest.mark.parametrize(("integrator", "energy", "momentum"), [("rk4", 1e-8, 1e-8), ("lie", 1e-4, 1e-11)])
def test_a_body_without_torque_keeps_angular_momentum_and_energy(
    integrator: str, energy: float, momentum: float
) -> None:
    """It tumbles about its middle axis, which is unstable, for 10 s, its centre of gravity beside the base's origin."""
    moments = np.array([0.005, 0.008, 0.012])
    center = np.array([0.03, -0.02, 0.01])
    made = craft(
        {"inertia": moments.tolist(), "center_of_gravity": center.tolist()},
        density=0.0,
        gravity=0.0,
        integrator=integrator,
    )
    begin = np.array([0.2, -0.1, 0.3, 0.01, 2.0, 0.02])

    def kept(pose: Floats, twist: Floats) -> tuple[float, Floats]:
        velocity, turning = twist[:3] + np.cross(twist[3:], center), twist[3:]
        whole = 0.5 * MASS * velocity @ velocity + 0.5 * turning @ (moments * turning)
        linear = MASS * pose[:3, :3] @ velocity
        angular = pose[:3, :3] @ (moments * turning) + np.cross(pose[:3, 3] + pose[:3, :3] @ center, linear)
        return float(whole), np.concatenate([angular, linear])  # about the world's origin

    pose, twist, _ = flown(made, np.zeros(4), 10.0, begin)
    before, after = kept(np.eye(4), begin), kept(pose, twist)
    assert after[0] == pytest.approx(before[0], rel=energy)
    np.testing.assert_allclose(after[1], before[1], atol=momentum)
    assert abs(twist[3]) > 0.1  # it has tumbled


def test_a_symmetric_top_precesses_at_its_rate() -> None:
    """Euler 1758: seen from the body the turning rate goes round its axis at (Iz - Ix) / Ix wz."""
    twist = flown(craft(density=0.0, gravity=0.0), np.zeros(4), 3.0, np.array([0, 0, 0, 0.5, 0.0, 2.0]))[1]
    angle = (0.012 - 0.007) / 0.007 * 2.0 * 3.0
    np.testing.assert_allclose(twist[3:], [0.5 * math.cos(angle), 0.5 * math.sin(angle), 2.0], atol=1e-6)


def test_rotors_that_turn_alike_turn_it() -> None:
    """Front and back at the end of their table: 2 F c / Iz, and 2 F / m upwards."""
    told = np.array([838.0, 0.0, 838.0, 0.0])
    twist = flown(craft(density=0.0, gravity=0.0), told, 0.5)[1]
    force = CONSTANT * 838.0**2
    assert twist[5] == pytest.approx(2.0 * force * 0.016 / 0.012 * 0.5, rel=1e-6)
    assert twist[2] == pytest.approx(2.0 * force / MASS * 0.5, rel=1e-6)
    assert np.abs(twist[[0, 1, 3, 4]]).max() < 1e-9


def test_what_is_wrong_is_named() -> None:
    with pytest.raises(ArgumentError, match="there is no vehicle 'kestrel'; the bundled ones are hummingbird"):
        FreeBodyDynamics(FreeBodySettings("kestrel"))
    with pytest.raises(ArgumentError, match=r"density is 0.*; it must be above 0"):
        craft({"density": 0})
    with pytest.raises(ArgumentError, match=r"mass is -1.*; it must be above 0"):
        craft({"mass": -1})
    with pytest.raises(ArgumentError, match="drive front is told 900; it takes 0 to 838 rad/s"):
        craft().step(np.eye(4), np.zeros(6), np.zeros(4), np.array([900.0, 0, 0, 0]), 0.01, STILL)
