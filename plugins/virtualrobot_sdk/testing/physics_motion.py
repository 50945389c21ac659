"""Laws of motion of physics engines: falling, sliding, rolling, swinging, against their formulas."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from virtualrobot_sdk.physics import Body, BodyJoint, Surface
from virtualrobot_sdk.poses import from_quaternion
from virtualrobot_sdk.testing.laws import LawBroken, Measured
from virtualrobot_sdk.testing.physics_scenes import (
    GRAVITY,
    SUBSTEP,
    TICK,
    EngineTrial,
    a_ball,
    a_box,
    a_floor,
    frame_at,
    load_scene,
    pose_at,
    run_scene,
)
from virtualrobot_sdk.testing.trial import numbers

MU = 0.5
"""Coefficient of friction on slopes."""


def free_fall(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A body that is thrown falls by g t^2 / 2 and turns on at its rate, about its center of mass."""
    velocity, spin = rng.uniform(-2.0, 2.0, 3), float(rng.uniform(-5.0, 5.0))
    off_center = (0.03, 0.0, 0.0)
    thrown = replace(a_box("thrown", (0.1, 0.1, 0.1)), center_of_mass=off_center, shapes=())
    q = pose_at(rng.uniform(-5.0, 5.0, 3))
    # About z, the centre of mass is at rest against the origin but for the turn.
    v = np.array([*velocity, 0.0, 0.0, spin])
    load_scene(trial, (thrown,), q, v)
    seconds = 0.5
    after = run_scene(trial, (thrown,), round(seconds / SUBSTEP))
    center = q[:3] + off_center
    speed = velocity + np.cross((0.0, 0.0, spin), off_center)
    expected = center + speed * seconds - (0.0, 0.0, GRAVITY * seconds**2 / 2.0)
    pose = from_quaternion(after.q[3:7])
    found = after.q[:3] + pose[:3, :3] @ np.array(off_center)
    off = float(np.linalg.norm(found - expected))
    # A substep that takes one of its ends for all of it is off by half a substep.
    if off > GRAVITY * seconds * SUBSTEP / 2.0 + 1e-4:
        raise LawBroken(f"after {seconds} s its center is at {numbers(found)}; it must be at {numbers(expected)}")
    turned = math.atan2(pose[1, 0], pose[0, 0])
    apart = abs(math.remainder(turned - spin * seconds, 2.0 * math.pi))
    if apart > 1e-3:
        raise LawBroken(f"turning by {spin:.4g} rad/s, it is at {turned:.6g} rad after {seconds} s")
    return Measured(1, {"m": off, "rad": apart})


def sliding(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A box slides down a slope by g (sin a - mu cos a), and one whose friction is enough stays."""
    del rng
    worst = 0.0
    for degrees in (30.0, 40.0):
        angle = math.radians(degrees)
        expected = GRAVITY * (math.sin(angle) - MU * math.cos(angle))
        found = _acceleration(trial, angle, a_box("box", (0.2, 0.2, 0.1), Surface(MU)), 0.05, Surface(MU))
        worst = max(worst, _within(trial, f"a box on a slope of {degrees:g} degrees", found, expected))
    angle = math.radians(20.0)
    found = _acceleration(trial, angle, a_box("box", (0.2, 0.2, 0.1), Surface(MU)), 0.05, Surface(MU))
    if abs(found) > 0.01:
        raise LawBroken(f"a box on a slope of 20 degrees goes by {found:.4g} m/s^2; friction of {MU} must hold it")
    return Measured(3, {"part": worst})


def mixing(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """Of two frictions counts what the author says: the smaller one, or the geometric mean of both."""
    del rng
    angle, own, other = math.radians(40.0), 0.2, 0.6
    counts = {"smaller": min(own, other), "geometric mean": math.sqrt(own * other)}[trial.facts.mixing]
    expected = GRAVITY * (math.sin(angle) - counts * math.cos(angle))
    worst = 0.0
    for box, slope in ((own, other), (other, own)):
        found = _acceleration(trial, angle, a_box("box", (0.2, 0.2, 0.1), Surface(box)), 0.05, Surface(slope))
        worst = max(worst, _within(trial, f"a box of friction {box} on a slope of {slope}", found, expected))
    return Measured(2, {"part": worst})


def rolling(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A sphere rolls down a slope by 5/7 g sin a; on the level, rolling friction slows it by mu_r g / (1.4 r)."""
    del rng
    angle, radius = math.radians(15.0), 0.05
    ball = a_ball("ball", radius, Surface(0.8))
    expected = 5.0 / 7.0 * GRAVITY * math.sin(angle)
    found = _acceleration(trial, angle, ball, radius, Surface(0.8))
    worst = _within(trial, "a sphere on a slope of 15 degrees", found, expected)
    slowed = Surface(0.8, rolling=0.002)
    bodies = (a_floor(slowed), replace(ball, surface=slowed))
    speed = 1.0
    load_scene(trial, bodies, pose_at((0.0, 0.0, radius)), np.array([speed, 0.0, 0.0, 0.0, speed / radius, 0.0]))
    before = run_scene(trial, bodies, 200).v[0]
    after = run_scene(trial, bodies, 500).v[0]
    resisted = 0.002 * GRAVITY / (1.4 * radius)
    found = (before - after) / (500 * SUBSTEP)
    worst = max(worst, _within(trial, "a sphere that rolling friction slows", found, resisted, 0.03))
    return Measured(2, {"part": worst})


def pendulum(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A pendulum swings with the period of its elliptic integral, and keeps its energy."""
    length, amplitude = float(rng.uniform(0.2, 0.6)), float(rng.uniform(0.3, 1.2))
    rod = replace(
        a_box("rod", (0.02, 0.02, length)),
        joint=BodyJoint.REVOLUTE,
        parent=0,
        axis=(0.0, 1.0, 0.0),
        center_of_mass=(0.0, 0.0, -length / 2.0),
        shapes=(),
    )
    bodies = (Body("post", parent_t_body=frame_at((0.0, 0.0, 2.0))), rod)
    about = float(rod.inertia[1, 1]) + rod.mass * length**2 / 4.0
    small = 2.0 * math.pi * math.sqrt(about / (rod.mass * GRAVITY * length / 2.0))
    # The complete elliptic integral by the mean of Gauss: pi / (2 agm(1, cos(amplitude / 2))).
    one, other = 1.0, math.cos(amplitude / 2.0)
    for _ in range(20):
        one, other = (one + other) / 2.0, math.sqrt(one * other)
    period = small / one
    load_scene(trial, bodies, np.array([amplitude]), np.zeros(1))
    times, angle, elapsed, highest = [], amplitude, 0.0, 0.0
    while len(times) < 3 and elapsed < 6.0 * period:
        after = run_scene(trial, bodies, TICK)
        elapsed += TICK * SUBSTEP
        now = float(after.q[0])
        if angle > 0.0 >= now:
            times.append(elapsed - TICK * SUBSTEP * now / (now - angle))
        highest, angle = max(highest, abs(now)) if len(times) >= 2 else 0.0, now
    if len(times) < 3:
        raise LawBroken(f"a pendulum with a period of {period:.6g} s has not swung twice in {elapsed:.4g} s")
    found = (times[2] - times[0]) / 2.0
    if abs(found / period - 1.0) > 0.003:
        raise LawBroken(f"a pendulum let go at {amplitude:.4g} rad has a period of {found:.6g} s, not {period:.6g} s")
    if abs(highest / amplitude - 1.0) > 0.02:
        raise LawBroken(f"a pendulum let go at {amplitude:.4g} rad still swings to {highest:.4g} rad, not as far")
    return Measured(
        1, {"part of the period": abs(found / period - 1.0), "part of the swing": abs(highest / amplitude - 1.0)}
    )


def _acceleration(trial: EngineTrial, angle: float, body: Body, height: float, slope: Surface) -> float:
    """Return how fast a body gets faster down a slope, after it has settled (m/s^2)."""
    bodies = (a_floor(slope, angle), body)
    along = np.array([math.cos(angle), 0.0, -math.sin(angle)])
    up = np.array([math.sin(angle), 0.0, math.cos(angle)])
    q = np.array([*(height * up), 0.0, math.sin(angle / 2.0), 0.0, math.cos(angle / 2.0)])
    load_scene(trial, bodies, q, np.zeros(6))
    run_scene(trial, bodies, 300)
    # A line through many speeds: engines with soft contacts hop a little on their way.
    speeds = [float(run_scene(trial, bodies, 50).v[:3] @ along) for _ in range(40)]
    return float(np.polyfit(np.arange(len(speeds)) * 50 * SUBSTEP, speeds, 1)[0])


def _within(trial: EngineTrial, what: str, found: float, expected: float, part: float | None = None) -> float:
    """Return the error of an acceleration as a part of it; raise LawBroken where it is too large."""
    allowed = trial.facts.sliding if part is None else max(part, trial.facts.sliding)
    if (off := abs(found / expected - 1.0)) > allowed:
        raise LawBroken(
            f"{what} changes its speed by {found:.5g} m/s^2; it must be {expected:.5g} (`sliding` of EngineFacts: "
            f"{allowed:g})"
        )
    return off
