"""Four wheels that are steered and driven, against formulas and an integration by scipy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from virtualrobot_plugins.mobile.swerve import CORNERS, Swerve, SwerveSettings

BASE, TRACK, RADIUS, RATE = 0.8, 0.5, 0.1, 2.0
PLACES = ((BASE / 2, TRACK / 2), (BASE / 2, -TRACK / 2), (-BASE / 2, TRACK / 2), (-BASE / 2, -TRACK / 2))
COUNT = len(CORNERS)


def craft() -> Swerve:
    return Swerve(SwerveSettings(BASE, TRACK, RADIUS, RATE))


def steered(twist: np.ndarray, states: np.ndarray, seconds: float = 0.05) -> tuple[np.ndarray, np.ndarray]:
    """Return drives once they are steered for a twist, and their commands then."""
    for _ in range(40):
        _, states = craft().step(np.eye(4), states, craft().drive_commands(twist, states, seconds), seconds)
    return states, craft().drive_commands(twist, states, seconds)


def pose(x: float, y: float, heading: float) -> np.ndarray:
    cos, sin = math.cos(heading), math.sin(heading)
    return np.array([[cos, -sin, 0, x], [sin, cos, 0, y], [0, 0, 1, 0], [0, 0, 0, 1.0]])


def test_each_wheel_rolls_across_to_its_radius_about_one_point() -> None:
    """The point is at (-vy, vx) / omega; a wheel's speed is its distance from there times omega."""
    vx, vy, omega = 0.3, 0.2, 0.5
    states, commands = steered(np.array([vx, vy, omega]), np.zeros(2 * COUNT))
    np.testing.assert_allclose(craft().base_twist(states, commands), [vx, vy, omega], atol=1e-12)
    for corner, (x, y) in enumerate(PLACES):
        away = np.array([x + vy / omega, y - vx / omega])
        ahead = np.array([math.cos(states[corner]), math.sin(states[corner])])
        assert ahead @ away == pytest.approx(0.0, abs=1e-12)
        assert abs(commands[COUNT + corner]) * RADIUS == pytest.approx(float(np.linalg.norm(away)) * omega)


@pytest.mark.parametrize("steps", [1, 7])
def test_steered_wheels_make_circles_however_long_the_step(steps: int) -> None:
    vx, vy, omega, seconds = 0.3, 0.2, 0.5, 2.0
    states, commands = steered(np.array([vx, vy, omega]), np.zeros(2 * COUNT))
    commands[:COUNT] = 0.0
    at = np.eye(4)
    for _ in range(steps):
        at, states = craft().step(at, states, commands, seconds / steps)
    turn = omega * seconds
    x = (vx * math.sin(turn) - vy * (1.0 - math.cos(turn))) / omega
    y = (vx * (1.0 - math.cos(turn)) + vy * math.sin(turn)) / omega
    np.testing.assert_allclose(at, pose(x, y, turn), atol=1e-12)


def test_to_the_side_it_turns_its_wheels_by_a_quarter() -> None:
    twist = np.array([0.0, 0.4, 0.0])
    commands = craft().drive_commands(twist, np.zeros(2 * COUNT), 0.05)
    np.testing.assert_allclose(commands, [RATE] * COUNT + [0.4 / RADIUS] * COUNT, atol=1e-12)
    states, commands = steered(twist, np.zeros(2 * COUNT))
    np.testing.assert_allclose(states[:COUNT], math.pi / 2.0, atol=1e-12)
    np.testing.assert_allclose(craft().base_twist(states, commands), twist, atol=1e-12)


def test_what_is_nearer_by_rolling_back_rolls_back() -> None:
    states = np.zeros(2 * COUNT)
    states[:COUNT] = math.radians(20.0)
    commands = craft().drive_commands(np.array([-0.4, 0.0, 0.0]), states, 1.0)
    assert (commands[:COUNT] == pytest.approx(-math.radians(20.0))) and bool((commands[COUNT:] < 0.0).all())


def test_wheels_that_contradict_each_other_slip() -> None:
    """The least squares of two wheels at 1 m/s and two at rest are half of that."""
    commands = np.array([0.0] * COUNT + [10.0, 10.0, 0.0, 0.0])
    np.testing.assert_allclose(craft().base_twist(np.zeros(2 * COUNT), commands), [0.5, 0.0, 0.0], atol=1e-14)


def test_while_it_steers_it_moves_as_an_integration_says(rng: np.random.Generator) -> None:
    for _ in range(5):
        states, commands, seconds = rng.uniform(-3.0, 3.0, 2 * COUNT), rng.uniform(-5.0, 5.0, 2 * COUNT), 1.5

        def moving(
            time: float, at: np.ndarray, states: np.ndarray = states, told: np.ndarray = commands
        ) -> list[float]:
            vx, vy, omega = craft().base_twist(states + told * time, told)
            cos, sin = math.cos(at[2]), math.sin(at[2])
            return [cos * vx - sin * vy, sin * vx + cos * vy, omega]

        there = solve_ivp(moving, (0.0, seconds), np.zeros(3), rtol=1e-11, atol=1e-12).y[:, -1]
        at, after = craft().step(np.eye(4), states, commands, seconds)
        np.testing.assert_allclose(at, pose(*there), atol=1e-9)
        np.testing.assert_array_equal(after, states + commands * seconds)
