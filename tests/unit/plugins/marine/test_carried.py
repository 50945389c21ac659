"""Vehicles that carry something: the momentum of both changes by outer forces alone (Newton), whatever moves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from virtualrobot_plugins.marine.component import FossenDynamics
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.poses import skew
from virtualrobot_sdk.vehicles import Carried

from tests.unit.plugins.marine.ideal import DEEP, vehicle

DT = 0.004
MASS, INERTIA = 13.5, np.diag([0.26, 0.23, 0.37])
FREE: dict[str, Any] = {"linear_damping": [0.0] * 6, "quadratic_damping": [0.0] * 6, "center_of_buoyancy": [0.0] * 3}
NO_WATER: dict[str, Any] = {**FREE, "added_mass": [0.0] * 6}
STILL = replace(DEEP, gravity=0.0)
REST = np.zeros(8)

Points = Callable[[float], tuple[Floats, Floats]]
"""Places (n, 3) of points of mass in the base's frame at a time (s), and their velocities there."""


def load(masses: Floats, points: Points, time: float) -> tuple[Floats, Floats]:
    """Return the mass matrix of points of mass, and the momentum of their movement, each point on its own."""
    inertia, momentum = np.zeros((6, 6)), np.zeros(6)
    for mass, place, velocity in zip(masses, *points(time), strict=True):
        # What a twist of the base does to a point: v + w x c.
        point = np.hstack([np.eye(3), -skew(place)])
        inertia += mass * point.T @ point
        momentum += mass * point.T @ velocity
    return inertia, momentum


def carry(made: FossenDynamics, masses: Floats, points: Points, seconds: float) -> list[tuple[float, Floats, Floats]]:
    """Return times, poses and twists of a vehicle from rest."""
    at, found = (np.eye(4), np.zeros(6), REST), [(0.0, np.eye(4), np.zeros(6))]
    for tick in range(round(seconds / DT)):
        pairs = [load(masses, points, DT * at_tick) for at_tick in (tick, tick + 1)]
        carried = Carried(np.array([inertia for inertia, _ in pairs]), np.array([moved for _, moved in pairs]))
        at = made.step(*at, REST, DT, replace(STILL, carried=carried))
        found.append((DT * (tick + 1), at[0], at[1]))
    return found


def eased(way: float, seconds: float, time: float) -> tuple[float, float]:
    """Return a way and its rate that begins and ends at rest."""
    phase = np.pi * min(time / seconds, 1.0)
    return 0.5 * way * (1.0 - np.cos(phase)), 0.5 * way * np.pi / seconds * np.sin(phase)


@pytest.mark.parametrize("mass", [2.0, 21.0, 30.0])
@pytest.mark.parametrize(("changed", "added"), [(NO_WATER, 0.0), (FREE, 6.36)])
def test_a_vehicle_goes_back_as_far_as_momentum_wants(mass: float, changed: dict[str, Any], added: float) -> None:
    """A mass m that slides ahead by d pushes it back by m d / (M + m), with added mass by m d / (M + added + m).

    A reaction that is told a tick late diverges where m is more than the vehicle's own mass and that of the water.
    """

    def slider(time: float) -> tuple[Floats, Floats]:
        way, rate = eased(0.4, 1.0, time)
        return np.array([[way, 0.0, 0.0]]), np.array([[rate, 0.0, 0.0]])

    _, pose, twist = carry(vehicle(**changed), np.array([mass]), slider, 1.2)[-1]
    assert pose[0, 3] == pytest.approx(-mass * 0.4 / (MASS + added + mass), abs=1e-5)
    assert np.abs(twist).max() < 1e-9


def swing(time: float) -> tuple[Floats, Floats]:
    """Return three points on circles and lines about the vehicle, which begin at rest."""
    angle, rate = eased(4.0, 2.0, time)
    way, speed = eased(-0.5, 1.5, time)
    c, s = np.cos(angle), np.sin(angle)
    places = [[0.5 * c, 0.5 * s, -0.2], [0.3 + way, 0.1, 0.2 * s], [0.1, 0.4 * s, 0.4 * c]]
    rates = [
        [-0.5 * s * rate, 0.5 * c * rate, 0.0],
        [speed, 0.0, 0.2 * c * rate],
        [0.0, 0.4 * c * rate, -0.4 * s * rate],
    ]
    return np.array(places), np.array(rates)


@pytest.mark.parametrize(("integrator", "slack"), [("rk4", 1e-7), ("lie", 1e-11)])
def test_momentum_is_that_of_all_bodies_and_stays_none(integrator: str, slack: float) -> None:
    """Summed over the bodies in the world, about its origin: what the points gain the vehicle loses."""
    masses = np.array([1.5, 2.0, 0.7])
    for time, pose, twist in carry(vehicle(integrator, **NO_WATER), masses, swing, 2.0)[::50]:
        turn, here = pose[:3, :3], pose[:3, 3]
        linear = MASS * turn @ twist[:3]
        angular = turn @ INERTIA @ twist[3:] + np.cross(here, linear)
        for mass, place, rate in zip(masses, *swing(time), strict=True):
            gone = mass * turn @ (twist[:3] + np.cross(twist[3:], place) + rate)
            linear, angular = linear + gone, angular + np.cross(here + turn @ place, gone)
        assert np.abs(linear).max() < slack
        assert np.abs(angular).max() < slack


def test_the_centre_of_mass_stays_where_it_is() -> None:
    masses = np.array([1.5, 2.0, 0.7])

    def centre(time: float, pose: Floats) -> Floats:
        places = pose[:3, 3] + swing(time)[0] @ pose[:3, :3].T
        return (MASS * pose[:3, 3] + masses @ places) / (MASS + masses.sum())

    way = carry(vehicle(**NO_WATER), masses, swing, 2.0)
    begin = centre(*way[0][:2])
    off = max(float(np.linalg.norm(centre(time, pose) - begin)) for time, pose, _ in way)
    assert off < 1e-5
    assert np.linalg.norm(way[-1][1][:3, 3]) > 0.01


@pytest.mark.parametrize(("density", "share"), [(0.0, 0.0), (2700.0, 1.0 - 1000.0 / 2700.0), (1000.0, 0.0)])
def test_what_it_carries_weighs_less_the_water_in_its_place(density: float, share: float) -> None:
    """Archimedes: a pull of m g (1 - water/body) at its centre, which turns the vehicle, too."""
    made = vehicle(carried_density=density, **NO_WATER)
    inertia, momentum = load(np.array([3.0]), lambda _: (np.array([[0.2, 0.0, 0.0]]), np.zeros((1, 3))), 0.0)
    carried = Carried(np.array([inertia, inertia]), np.array([momentum, momentum]))
    twist = made.step(np.eye(4), np.zeros(6), REST, REST, 1e-6, replace(DEEP, carried=carried))[1]
    whole = inertia + np.diag([MASS] * 3 + [0.26, 0.23, 0.37])
    pull = -3.0 * 9.82 * share
    exact = np.linalg.solve(whole, np.array([0.0, 0.0, pull, 0.0, -0.2 * pull, 0.0]))
    np.testing.assert_allclose(twist / 1e-6, exact, atol=1e-4)


@pytest.mark.parametrize(
    ("carried", "said"),
    [
        (Carried(np.zeros((6, 6)), np.zeros((2, 6))), r"the inertia of what is carried has shape \(6, 6\); it must be"),
        (Carried(np.zeros((2, 6, 6)), np.full((2, 6), np.nan)), "the momentum of what is carried is .*must be finite"),
    ],
)
def test_what_makes_no_sense_is_refused(carried: Carried, said: str) -> None:
    with pytest.raises(ArgumentError, match=said):
        vehicle().step(np.eye(4), np.zeros(6), REST, REST, DT, replace(STILL, carried=carried))
