"""Fossen's model against closed forms, laws of mechanics and the figures of published models."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_plugins.marine.component import FossenDynamics, FossenSettings
from virtualrobot_plugins.marine.parameters import parameters
from virtualrobot_plugins.marine.vehicle import bundled, read_bundled, read_document
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.poses import rotation_matrix
from virtualrobot_sdk.vehicles import DriveQuantity, Surroundings

from tests.unit.plugins.marine.ideal import DEEP, document, pusher, run, vehicle

AXES = {"surge": [1, 0, 0], "sway": [0, 1, 0], "heave": [0, 0, -1]}


@pytest.mark.parametrize(
    ("axis", "newtons", "metres_per_second"),
    [("surge", 85.0, 0.729363), ("sway", 85.0, 0.625863), ("heave", 60.0, 0.481780)],
)
def test_terminal_velocity_is_that_of_the_closed_form(axis: str, newtons: float, metres_per_second: float) -> None:
    """The positive root of b v^2 + a v = F, for the damping of von Benzon and others (2022)."""
    i = list(AXES).index(axis)
    linear, square = (13.7, 0.0, 33.0)[i], (141.0, 217.0, 190.0)[i]
    exact = (-linear + math.sqrt(linear**2 + 4.0 * square * newtons)) / (2.0 * square)
    assert exact == pytest.approx(metres_per_second, abs=1e-6)
    twist = run(vehicle(thrusters=[pusher("push", AXES[axis], [0, 0, 0])]), np.array([newtons]), 30.0, dt=0.02)[1]
    # The file's y is to the right and its z down.
    assert twist[i] == pytest.approx(exact * (1, -1, 1)[i], abs=1e-9)
    assert np.abs(np.delete(twist, i)).max() < 1e-12


def test_surge_from_rest_is_a_hyperbolic_tangent() -> None:
    """M v' + b v |v| = F without linear damping: v = sqrt(F / b) tanh(sqrt(F b) / M t)."""
    made = vehicle(linear_damping=[0.0] * 6, thrusters=[pusher("push", [1, 0, 0], [0, 0, 0])])
    mass, square, force = 13.5 + 6.36, 141.0, 50.0
    for seconds in (0.2, 0.6, 1.6):
        # The thruster has no lag, but is at rest where the first step starts: let it turn already.
        found = run(made, np.array([force]), seconds, states=np.array([force]))[1][0]
        exact = math.sqrt(force / square) * math.tanh(math.sqrt(force * square) / mass * seconds)
        assert found == pytest.approx(exact, abs=1e-8)


def test_a_small_roll_without_damping_swings_with_its_period() -> None:
    """2 pi sqrt((Ix + added) / (m g BG)) = 3.6567 s, taken from the instants at which it comes through upright."""
    made = vehicle(linear_damping=[0.0] * 6, quadratic_damping=[0.0] * 6)
    period = 2.0 * math.pi * math.sqrt((0.26 + 0.189) / (13.5 * 9.82 * 0.01))
    assert period == pytest.approx(3.6567, abs=1e-4)
    pose = np.eye(4)
    pose[:3, :3] = rotation_matrix(np.array([1e-3, 0.0, 0.0]))
    at = pose, np.zeros(6), np.zeros(8)
    crossings: list[float] = []
    for i in range(2400):
        after = made.step(*at, np.zeros(8), 0.004, DEEP)
        before, now = at[0][2, 1], after[0][2, 1]
        if before * now < 0.0:
            crossings.append(0.004 * (i + before / (before - now)))
        at = after
    assert 2.0 * float(np.diff(crossings).mean()) == pytest.approx(period, abs=1e-4)


def test_the_published_remus_goes_as_fast() -> None:
    """At 1525 rpm Fossen's remus100 goes 2.5536 m/s, less 1e-4 of damping at low speed that this one leaves out."""
    made = FossenDynamics(FossenSettings("remus100"))
    twist = run(made, np.array([1525 * math.pi / 30, 0.0, 0.0]), 60.0, dt=0.05, water=replace(DEEP, density=1026.0))[1]
    rho, rps, diameter = 1026.0, 1525 / 60, 0.14

    def surplus(u: float) -> float:
        thrust = 0.9 * rho * diameter**4 * (0.4566 * rps**2 + (0.1798 - 0.4566) / 0.6632 * 0.944 * u / diameter * rps)
        return thrust - 0.5 * rho * 0.42 * math.pi * 0.095**2 * u * u

    low, high = 0.0, 5.0
    for _ in range(60):
        u = (low + high) / 2
        low, high = (u, high) if surplus(u) > 0.0 else (low, u)
    assert twist[0] == pytest.approx(low, abs=1e-6)
    assert twist[0] == pytest.approx(2.5536, abs=2e-4)
    assert np.abs(twist[1:]).max() < 1e-2


def test_a_rudder_turns_to_its_side() -> None:
    """A positive angle lifts the stern to port, so that the vehicle turns to starboard, by Fossen's signs."""
    made = FossenDynamics(FossenSettings("remus100"))
    assert [drive.quantity for drive in made.drives] == [DriveQuantity.SPEED] + 2 * [DriveQuantity.POSITION]
    water = replace(DEEP, density=1026.0)
    ahead = run(made, np.array([120.0, 0.0, 0.0]), 20.0, dt=0.05, water=water)
    turned = run(made, np.array([120.0, 0.2, 0.0]), 5.0, 0.05, *ahead, water=water)[1]
    dived = run(made, np.array([120.0, 0.0, -0.2]), 5.0, 0.05, *ahead, water=water)[1]
    assert turned[5] < -0.02
    assert dived[4] < -0.02, "negative stern planes lift the nose: about y to the left that is a negative turn"


def test_a_neutral_vehicle_stays_where_it_is() -> None:
    pose, twist, _ = run(vehicle(), np.zeros(8), 10.0, dt=0.02)
    assert np.abs(pose - np.eye(4)).max() < 1e-12
    assert np.abs(twist).max() < 1e-12


def test_one_that_is_too_light_comes_up_until_it_floats_by_its_weight() -> None:
    made = vehicle(volume=15.0)
    pose, twist, _ = run(made, np.zeros(8), 60.0, dt=0.02, water=replace(DEEP, surface=2.0))
    # Of 15 L 13.5 L are under water: the centre of buoyancy is by 0.4 of the hull's height below the surface.
    assert pose[2, 3] + 0.01 == pytest.approx(2.0 - 0.4 * 0.38, abs=1e-3)
    assert np.abs(twist).max() < 1e-2


def test_coriolis_forces_take_no_power(rng: np.random.Generator) -> None:
    """v^T M v' = 0 without damping and weight, whatever the mass matrix: C(v) is skew."""
    root = rng.normal(size=(6, 6))
    heavy = (root @ root.T).tolist()
    made = vehicle(
        added_mass=heavy, linear_damping=[0.0] * 6, quadratic_damping=[0.0] * 6, center_of_gravity=[0.1, 0.05, 0.02]
    )
    mass = parameters(read_document(document(added_mass=heavy, center_of_gravity=[0.1, 0.05, 0.02]))).mass_matrix
    still = replace(DEEP, gravity=0.0)
    for _ in range(10):
        v = rng.uniform(-1.0, 1.0, 6)
        after = made.step(np.eye(4), v, np.zeros(8), np.zeros(8), 1e-6, still)[1]
        power = v @ mass @ (after - v) / 1e-6
        assert abs(power) < 1e-4 * (v @ mass @ v)


def _energy_and_momentum(mass: Floats, pose: Floats, v: Floats) -> tuple[float, Floats]:
    h = mass @ v
    linear, angular = pose[:3, :3] @ h[:3], pose[:3, :3] @ h[3:]
    return 0.5 * float(v @ h), np.concatenate([linear, angular + np.cross(pose[:3, 3], linear)])


@pytest.mark.parametrize(("integrator", "of_energy", "of_momentum"), [("rk4", 1e-9, 1e-9), ("lie", 1e-4, 1e-11)])
def test_a_body_without_forces_keeps_energy_and_momentum(integrator: str, of_energy: float, of_momentum: float) -> None:
    """By rk4 to its order; the step on the group keeps the momentum to rounding."""
    made = vehicle(integrator, linear_damping=[0.0] * 6, quadratic_damping=[0.0] * 6)
    mass = parameters(read_document(document())).mass_matrix
    at = np.eye(4), np.array([0.8, 0.3, -0.2, 0.5, -0.4, 0.9]), np.zeros(8)
    energy, momentum = _energy_and_momentum(mass, *at[:2])
    still = replace(DEEP, gravity=0.0)
    for _ in range(2500):
        at = made.step(*at, np.zeros(8), 0.004, still)
    after, last = _energy_and_momentum(mass, *at[:2])
    assert after == pytest.approx(energy, rel=of_energy)
    assert np.linalg.norm(last - momentum) < of_momentum * np.linalg.norm(momentum)


@pytest.mark.parametrize(("integrator", "order"), [("euler", 1), ("lie", 2), ("rk4", 4)])
def test_each_integrator_has_its_order(integrator: str, order: int) -> None:
    """Errors of two step lengths, thrusters with their lag among it: held during a step they would make it 1.

    Damping is linear: |v| v has a kink where v comes through 0.
    """
    across = [pusher("right", [1, 0, 0], [0, 0.2, 0], 0.3), pusher("up", [0, 0, -1], [0.1, 0, 0], 0.2)]
    commands, twist = np.array([30.0, 20.0]), np.array([0.8, 0.3, 0.4, 0.2, 0.3, 0.4])
    water = replace(DEEP, current=(0.2, -0.1, 0.05))

    def end(method: str, dt: float) -> Floats:
        slow = [20.0, 20.0, 40.0, 0.5, 0.5, 0.5]
        made = vehicle(method, 1.0, thrusters=across, linear_damping=slow, quadratic_damping=[0.0] * 6)
        pose, after, _ = run(made, commands, 0.96, dt, twist=twist, water=water)
        return np.concatenate([pose[:3].ravel(), after])

    exact = end("rk4", 0.001)
    coarse, fine = (np.linalg.norm(end(integrator, dt) - exact) for dt in (0.04, 0.02))
    assert math.log2(coarse / fine) == pytest.approx(order, abs=0.35)


def test_a_thruster_follows_its_command_and_its_table() -> None:
    """First order: 1 - 1/e after the time constant; the thrust is straight between entries and level beyond them."""
    made = FossenDynamics(FossenSettings())
    assert run(made, np.full(8, 100.0), 0.15, dt=0.15)[2] == pytest.approx(100.0 * (1.0 - math.exp(-1.0)), abs=1e-12)
    rpm = math.pi / 30.0
    speed = np.array([0.0, 0.0, 0.0, 0.0, *4 * [1293.75 * rpm]])
    after = made.step(np.eye(4), np.zeros(6), speed, speed, 1e-6, replace(DEEP, gravity=0.0))[1]
    between = 4.0 * (0.328125 + 1.3125) / 2.0 * 9.80665
    assert after[2] / 1e-6 == pytest.approx(between / (13.5 + 18.68), rel=1e-5)


def test_a_current_carries_it_along() -> None:
    water = replace(DEEP, current=(0.3, -0.2, 0.0))
    pose, twist, _ = run(vehicle(), np.zeros(8), 200.0, dt=0.1, water=water)
    assert (pose[:3, :3] @ twist[:3])[:2] == pytest.approx([0.3, -0.2], abs=0.02)
    assert pose[0, 3] > 40.0


@pytest.mark.parametrize("name", bundled())
def test_every_bundled_vehicle_can_be_made(name: str) -> None:
    made = FossenDynamics(FossenSettings(name))
    assert all(drive.lowest < 0.0 < drive.highest for drive in made.drives)
    assert len(read_bundled(name).sources) >= 2
    rest = np.zeros(len(made.drives))
    twist = made.step(np.eye(4), np.zeros(6), rest, rest, 0.02, Surroundings(surface=9.0))[1]
    assert np.abs(twist).max() < 0.01
