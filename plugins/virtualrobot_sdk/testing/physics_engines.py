"""The contract suite for physics engines: motion against formulas, forces that add up, and bits that come again."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

from virtualrobot_sdk.errors import ComponentFault
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.physics import (
    Body,
    BodyJoint,
    BodyShape,
    Driven,
    MotorMode,
    Motors,
    PhysicsModel,
    ShapeKind,
    Stepped,
    Surface,
    TouchingBodies,
    jointed,
    motors_off,
    sizes,
)
from virtualrobot_sdk.poses import from_quaternion
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.component_contract import ComponentContract
from virtualrobot_sdk.testing.laws import LawBroken, Measured
from virtualrobot_sdk.testing.trial import Law, Trial, checked, must_refuse, numbers

GRAVITY = 9.81
"""In m/s^2, downwards."""
SUBSTEP = 0.001
"""Length of a substep in all laws (s)."""
TICK = 4
"""Substeps of the calls that most laws make."""
MU = 0.5
"""Coefficient of friction on slopes."""


@dataclass(frozen=True, slots=True)
class EngineFacts:
    """Properties of an engine that its author states.

    Attributes:
        sinking: how deep what rests may be in what it rests on, or how far above it (m).
        sliding: largest error of accelerations on slopes, as a part of them.
        bouncing: largest error of the coefficient of restitution.
        mixing: which friction counts of two: `smaller`, or `geometric mean`.
    """

    sinking: float = 1e-3
    sliding: float = 0.01
    bouncing: float = 0.05
    mixing: str = "smaller"


EngineTrial = Trial[EngineFacts]


def free_fall(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A body that is thrown falls by g t^2 / 2 and turns on at its rate, about its center of mass."""
    velocity, spin = rng.uniform(-2.0, 2.0, 3), float(rng.uniform(-5.0, 5.0))
    off_center = (0.03, 0.0, 0.0)
    thrown = replace(_box("thrown", (0.1, 0.1, 0.1)), center_of_mass=off_center, shapes=())
    q = _pose(rng.uniform(-5.0, 5.0, 3))
    # About z, the centre of mass is at rest against the origin but for the turn.
    v = np.array([*velocity, 0.0, 0.0, spin])
    _load(trial, (thrown,), q, v)
    seconds = 0.5
    after = _run(trial, (thrown,), round(seconds / SUBSTEP))
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
        found = _acceleration(trial, angle, _box("box", (0.2, 0.2, 0.1), Surface(MU)), 0.05, Surface(MU))
        worst = max(worst, _within(trial, f"a box on a slope of {degrees:g} degrees", found, expected))
    angle = math.radians(20.0)
    found = _acceleration(trial, angle, _box("box", (0.2, 0.2, 0.1), Surface(MU)), 0.05, Surface(MU))
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
        found = _acceleration(trial, angle, _box("box", (0.2, 0.2, 0.1), Surface(box)), 0.05, Surface(slope))
        worst = max(worst, _within(trial, f"a box of friction {box} on a slope of {slope}", found, expected))
    return Measured(2, {"part": worst})


def rolling(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A sphere rolls down a slope by 5/7 g sin a; on the level, rolling friction slows it by mu_r g / (1.4 r)."""
    del rng
    angle, radius = math.radians(15.0), 0.05
    ball = _ball("ball", radius, Surface(0.8))
    expected = 5.0 / 7.0 * GRAVITY * math.sin(angle)
    found = _acceleration(trial, angle, ball, radius, Surface(0.8))
    worst = _within(trial, "a sphere on a slope of 15 degrees", found, expected)
    slowed = Surface(0.8, rolling=0.002)
    bodies = (_floor(slowed), replace(ball, surface=slowed))
    speed = 1.0
    _load(trial, bodies, _pose((0.0, 0.0, radius)), np.array([speed, 0.0, 0.0, 0.0, speed / radius, 0.0]))
    before = _run(trial, bodies, 200).v[0]
    after = _run(trial, bodies, 500).v[0]
    resisted = 0.002 * GRAVITY / (1.4 * radius)
    found = (before - after) / (500 * SUBSTEP)
    worst = max(worst, _within(trial, "a sphere that rolling friction slows", found, resisted, 0.03))
    return Measured(2, {"part": worst})


def pendulum(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A pendulum swings with the period of its elliptic integral, and keeps its energy."""
    length, amplitude = float(rng.uniform(0.2, 0.6)), float(rng.uniform(0.3, 1.2))
    rod = replace(
        _box("rod", (0.02, 0.02, length)),
        joint=BodyJoint.REVOLUTE,
        parent=0,
        axis=(0.0, 1.0, 0.0),
        center_of_mass=(0.0, 0.0, -length / 2.0),
        shapes=(),
    )
    bodies = (Body("post", parent_t_body=_at((0.0, 0.0, 2.0))), rod)
    about = float(rod.inertia[1, 1]) + rod.mass * length**2 / 4.0
    small = 2.0 * math.pi * math.sqrt(about / (rod.mass * GRAVITY * length / 2.0))
    # The complete elliptic integral by the mean of Gauss: pi / (2 agm(1, cos(amplitude / 2))).
    one, other = 1.0, math.cos(amplitude / 2.0)
    for _ in range(20):
        one, other = (one + other) / 2.0, math.sqrt(one * other)
    period = small / one
    _load(trial, bodies, np.array([amplitude]), np.zeros(1))
    times, angle, elapsed, highest = [], amplitude, 0.0, 0.0
    while len(times) < 3 and elapsed < 6.0 * period:
        after = _run(trial, bodies, TICK)
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


def stack(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """Ten boxes on each other stay where they are, no deeper than said; contacts carry what is above them."""
    del rng
    side, count = 0.1, 10
    bodies = (_floor(Surface(0.8)), *(_box(f"box {i}", (side, side, side), Surface(0.8)) for i in range(count)))
    q = np.concatenate([_pose((0.0, 0.0, side * (i + 0.5))) for i in range(count)])
    _load(trial, bodies, q, np.zeros(6 * count))
    after = _run(trial, bodies, 1000)
    moved = (after.q - q).reshape(count, 7)[:, :3]
    aside, sunk = float(np.abs(moved[:, :2]).max()), np.abs(np.diff(moved[:, 2], prepend=0.0)).max()
    if aside > 0.005 or sunk > trial.facts.sinking or abs(after.v).max() > 0.05:
        raise LawBroken(
            f"ten boxes on each other have gone {aside:.3g} m aside, one is {sunk:.3g} m deep in the next (`sinking` "
            f"of EngineFacts: {trial.facts.sinking:g}), and the fastest moves by {np.abs(after.v).max():.3g} m/s, rad/s"
        )
    worst = 0.0
    for lower in range(count):
        felt = _force(after.contacts, lower, lower + 1)
        weight = (count - lower) * GRAVITY
        worst = max(worst, float(np.linalg.norm(felt - (0.0, 0.0, weight))) / weight)
        if worst > 0.02:
            raise LawBroken(f"{bodies[lower].name!r} carries {numbers(felt)} N; what is above it weighs {weight:.6g} N")
    return Measured(1, {"m aside": aside, "m deep": float(sunk), "part of the weight": worst})


def shapes(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A box, a sphere, cylinders, a capsule and a hull each rest where their shape says, turned as they are."""
    del rng
    lying = np.eye(4)
    lying[:3, :3] = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    corners = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.05, 0.05)])
    made = {
        "box": (BodyShape(ShapeKind.BOX, (0.1, 0.1, 0.05)), 0.05),
        "sphere": (BodyShape(ShapeKind.SPHERE, (0.07,)), 0.07),
        "cylinder": (BodyShape(ShapeKind.CYLINDER, (0.06, 0.08)), 0.08),
        "lying cylinder": (BodyShape(ShapeKind.CYLINDER, (0.06, 0.08), lying), 0.06),
        "lying capsule": (BodyShape(ShapeKind.CAPSULE, (0.05, 0.1), lying), 0.05),
        "hull": (BodyShape(ShapeKind.HULL, (), np.eye(4), corners), 0.05),
    }
    surface = Surface(0.8, rolling=0.001)
    inertia = np.eye(3) * 0.004
    free = Body("", joint=BodyJoint.FREE, mass=1.0, inertia=inertia, surface=surface)
    bodies = (_floor(surface), *(replace(free, name=name, shapes=(shape,)) for name, (shape, _) in made.items()))
    q = np.concatenate([_pose((0.5 * i, 0.0, height)) for i, (_, height) in enumerate(made.values())])
    _load(trial, bodies, q, np.zeros(6 * len(made)))
    after = _run(trial, bodies, 500)
    worst = 0.0
    for i, (name, (_, height)) in enumerate(made.items()):
        off = abs(float(after.q[7 * i + 2]) - height)
        worst = max(worst, off)
        if off > max(trial.facts.sinking, 2e-3):
            raise LawBroken(f"a {name} rests at {after.q[7 * i + 2]:.6g} m; its shape says {height:g} m")
    felt = np.sum([_force(after.contacts, 0, row) for row in range(1, len(bodies))], axis=0)
    if abs(float(felt[2]) / (GRAVITY * len(made)) - 1.0) > 0.02:
        raise LawBroken(f"the floor carries {numbers(felt)} N; what lies on it weighs {GRAVITY * len(made):.6g} N")
    return Measured(len(made), {"m": worst})


def restitution(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A ball that hits the floor comes back with as much of its speed as its surface says."""
    del rng
    worst = 0.0
    for wanted in (0.0, 0.5, 0.8):
        surface = Surface(0.5, restitution=wanted)
        bodies = (_floor(surface), _ball("ball", 0.1, surface))
        speed = 3.0
        _load(trial, bodies, _pose((0.0, 0.0, 0.2)), np.array([0.0, 0.0, -speed, 0.0, 0.0, 0.0]))
        fastest, hit = 0.0, math.sqrt(speed**2 + 2.0 * GRAVITY * 0.1)
        for _ in range(40):
            fastest = max(fastest, float(_run(trial, bodies, TICK).v[2]))
        found = fastest / hit
        worst = max(worst, abs(found - wanted))
        if abs(found - wanted) > trial.facts.bouncing:
            raise LawBroken(
                f"a ball that hits the floor by {hit:.4g} m/s comes back by {fastest:.4g} m/s, {found:.3f} of it; its "
                f"restitution is {wanted:g} (`bouncing` of EngineFacts: {trial.facts.bouncing:g})"
            )
    return Measured(3, {"of restitution": worst})


def momentum(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """Bodies that hit each other where nothing else pulls keep their momentum, linear and angular."""
    bodies = (_box("first", (0.1, 0.2, 0.1)), replace(_box("second", (0.1, 0.1, 0.1)), mass=3.0))
    q = np.concatenate([_pose((-0.3, 0.0, 0.0)), _pose((0.0, float(rng.uniform(0.02, 0.08)), 0.0))])
    v = np.zeros(12)
    v[0] = float(rng.uniform(1.0, 2.0))
    _load(trial, bodies, q, v, gravity=0.0)
    before, after = _momentum(bodies, q, v), _run(trial, bodies, 400)
    if abs(float(after.v[6])) < 0.1:
        raise LawBroken(f"a box thrown at another one by {v[0]:.4g} m/s has not moved it: {after.v[6]:.4g} m/s")
    off = np.abs(_momentum(bodies, after.q, after.v) - before)
    scale = abs(before[0])
    if off.max() > 0.005 * scale:
        raise LawBroken(
            f"two boxes had the momentum {numbers(before)} (N s, and N m s about the origin), and have "
            f"{numbers(_momentum(bodies, after.q, after.v))} after they have met"
        )
    return Measured(1, {"part": float(off.max()) / scale})


def pushing(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A driven body pushes what is in its way as fast as it goes itself, and yields to nothing."""
    del rng
    paddle = replace(_box("paddle", (0.05, 0.4, 0.2), Surface(0.1)), driven=True)
    bodies = (_floor(Surface(0.3)), paddle, _box("box", (0.2, 0.2, 0.2), Surface(0.3)))
    speed, start, steps = 0.2, -0.2, 250
    _load(trial, bodies, _pose((0.0, 0.0, 0.1)), np.zeros(6))
    twist = np.array([[speed, 0.0, 0.0, 0.0, 0.0, 0.0]])
    answer = None
    for step in range(1, steps + 1):
        pose = _pose((start + speed * step * TICK * SUBSTEP, 0.0, 0.2))[None]
        answer = _step(trial, bodies, Driven(pose, twist), TICK)
    assert answer is not None
    expected = start + speed * steps * TICK * SUBSTEP + 0.025 + 0.1
    off = float(answer.q[0]) - expected
    if abs(off) > 0.01 or abs(float(answer.v[0]) - speed) > 0.05:
        raise LawBroken(
            f"pushed by {speed} m/s, a box is at {answer.q[0]:.4g} m and goes by {answer.v[0]:.4g} m/s; it must be at "
            f"{expected:.4g} m"
        )
    return Measured(1, {"m": abs(off)})


def carrying(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A driven body that stands, but has a velocity, carries what lies on it as a belt does."""
    del rng
    belt = replace(_box("belt", (4.0, 0.5, 0.1), Surface(0.8)), driven=True)
    bodies = (belt, _box("box", (0.2, 0.2, 0.2), Surface(0.8)))
    speed, seconds = 0.2, 1.0
    _load(trial, bodies, _pose((0.0, 0.0, 0.1)), np.zeros(6))
    driven = Driven(_pose((0.0, 0.0, -0.05))[None], np.array([[speed, 0.0, 0.0, 0.0, 0.0, 0.0]]))
    answer = None
    for _ in range(round(seconds / (TICK * SUBSTEP))):
        answer = _step(trial, bodies, driven, TICK)
    assert answer is not None
    # It slips until friction has brought it up to the belt's speed.
    expected = speed * (seconds - speed / (2.0 * 0.8 * GRAVITY))
    off = abs(float(answer.q[0]) - expected)
    if off > 0.02 * expected:
        raise LawBroken(
            f"a belt of {speed} m/s has carried a box by {answer.q[0]:.4g} m in {seconds} s, not {expected:.4g}"
        )
    return Measured(1, {"m": off})


def motors(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A joint's motor exerts an effort, holds a velocity or goes to a position, and no stronger than it may."""
    wheel = replace(_box("wheel", (0.2, 0.2, 0.05)), joint=BodyJoint.REVOLUTE, shapes=())
    bodies = (wheel,)
    about = float(wheel.inertia[2, 2])
    effort, seconds = float(rng.uniform(0.01, 0.05)), 0.2
    worst = 0.0

    def told(
        mode: MotorMode, target: float, most: float = math.inf, stiffness: float = 0.0, damping: float = 0.0
    ) -> Motors:
        one = np.ones(1)
        return Motors(np.array([mode], np.int32), target * one, stiffness * one, damping * one, most * one)

    cases = {
        "an effort": (told(MotorMode.EFFORT, effort), effort / about * seconds, 1e-3),
        "a limited effort": (told(MotorMode.EFFORT, 10.0 * effort, effort), effort / about * seconds, 1e-3),
        "a velocity": (told(MotorMode.VELOCITY, 2.0), 2.0, 0.01),
        "a velocity out of reach": (told(MotorMode.VELOCITY, 1e3, effort), effort / about * seconds, 0.01),
    }
    for name, (motor, expected, tolerance) in cases.items():
        _load(trial, bodies, np.zeros(1), np.zeros(1), gravity=0.0)
        after = _step(trial, bodies, _NONE_DRIVEN, round(seconds / SUBSTEP), motor)
        off = abs(float(after.v[0]) / expected - 1.0)
        worst = max(worst, off)
        if off > tolerance:
            raise LawBroken(f"a motor told {name} turns its joint by {after.v[0]:.6g} rad/s; it must be {expected:.6g}")
        if name == "an effort" and abs(float(after.efforts[0]) - effort) > 1e-6:
            raise LawBroken(f"a motor told {effort:.6g} N m says that it exerts {after.efforts[0]:.6g} N m")
    # Critically damped, at 20 rad/s.
    stiffness, damping = about * 400.0, about * 40.0
    _load(trial, bodies, np.zeros(1), np.zeros(1), gravity=0.0)
    after = _step(trial, bodies, _NONE_DRIVEN, 1000, told(MotorMode.POSITION, 0.7, math.inf, stiffness, damping))
    if abs(float(after.q[0]) - 0.7) > 1e-3:
        raise LawBroken(f"a motor told the position 0.7 rad is at {after.q[0]:.6g} rad after 1 s")
    return Measured(5, {"part": worst})


def limits(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A joint stops at its limits."""
    del rng
    wheel = replace(_box("door", (0.2, 0.2, 0.05)), joint=BodyJoint.REVOLUTE, shapes=(), lower=-0.5, upper=0.5)
    _load(trial, (wheel,), np.zeros(1), np.ones(1), gravity=0.0)
    after = _run(trial, (wheel,), 1000)
    if not -0.52 <= float(after.q[0]) <= 0.52:
        raise LawBroken(f"a joint that ends at 0.5 rad is at {after.q[0]:.4g} rad")
    return Measured(1)


def wrenches(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A force at the center of mass moves a body without turning it, a torque turns it without moving it."""
    box = replace(_box("box", (0.1, 0.1, 0.1)), shapes=(), center_of_mass=(0.02, 0.0, 0.0))
    force, torque = float(rng.uniform(1.0, 3.0)), 0.001
    _load(trial, (box,), _pose((0.0, 0.0, 0.0)), np.zeros(6), gravity=0.0)
    pushed = _step(trial, (box,), _NONE_DRIVEN, 100, None, np.array([[0.0, force, 0.0, 0.0, 0.0, 0.0]]))
    expected = force / box.mass * 0.1
    if abs(float(pushed.v[1]) - expected) > 1e-3 * expected or abs(float(pushed.v[5])) > 1e-6:
        raise LawBroken(f"pushed by {force:.4g} N for 0.1 s, it has the velocities {numbers(pushed.v)}")
    _load(trial, (box,), _pose((0.0, 0.0, 0.0)), np.zeros(6), gravity=0.0)
    turned = _step(trial, (box,), _NONE_DRIVEN, 100, None, np.array([[0.0, 0.0, 0.0, 0.0, 0.0, torque]]))
    expected = torque / float(box.inertia[2, 2]) * 0.1
    if abs(float(turned.v[5]) - expected) > 1e-3 * expected:
        raise LawBroken(f"turned by {torque} N m for 0.1 s, it turns by {turned.v[5]:.6g} rad/s, not {expected:.6g}")
    return Measured(2)


def forgetting(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A state that is set goes on with the same bits, whatever came before it."""
    bodies, q, v = _heap(rng)
    _load(trial, bodies, q, v)
    for _ in range(10):
        middle = _run(trial, bodies, TICK)
    runs = []
    for _ in range(2):
        trial.call("set_state", middle.q, middle.v)
        runs.append([_bits(_run(trial, bodies, TICK)) for _ in range(10)])
    if runs[0] != runs[1]:
        raise LawBroken("the same state, set again, goes on otherwise; set_state must forget what came before")
    return Measured(2)


def determinism(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """The same calls since load give the same bits: again, and in another process."""
    bodies, q, v = _heap(rng)
    runs = []
    with trial.twin() as twin:
        for one in (trial, trial, twin):
            _load(one, bodies, q, v)
            runs.append([_bits(_run(one, bodies, TICK)) for _ in range(20)])
    for run, where in zip(runs[1:], ("", " in another process"), strict=True):
        if run != runs[0]:
            raise LawBroken(f"the same calls give other bits{where}")
    return Measured(2)


def refusals(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """Arguments that make no sense are refused by an ArgumentError, and the state is the same as before."""
    bodies, q, v = _heap(rng)
    _load(trial, bodies, q, v)
    expected = _bits(_run(trial, bodies, TICK))
    _load(trial, bodies, q, v)
    tried = must_refuse(trial, _senseless_steps(bodies))
    if _bits(_run(trial, bodies, TICK)) != expected:
        raise LawBroken("after a step that was refused, the next one ends elsewhere")
    return Measured(tried + must_refuse(trial, _senseless_models(q, v)))


def divergence(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A push beyond all numbers ends in an error or in finite numbers, and load begins anew."""
    bodies, q, v = _heap(rng)
    _load(trial, bodies, q, v)
    wrench = np.zeros((len(bodies), 6))
    wrench[1, 0] = 1e308
    said = ""
    try:
        for _ in range(20):
            _step(trial, bodies, _NONE_DRIVEN, 100, None, wrench)
    except ComponentFault as fault:
        said = str(fault)
    trial.renew()
    _load(trial, bodies, q, v)
    _run(trial, bodies, TICK)
    return Measured(1, note=said)


def cost(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """Nothing; it tells microseconds a substep of a heap of boxes."""
    bodies, q, v = _heap(rng, 27)
    _load(trial, bodies, q, v)
    arguments = _NONE_DRIVEN, motors_off(0), None, TICK
    return Measured(1, {"us a substep": 1e6 * float(np.median(trial.seconds(20, "step", *arguments))) / TICK})


LAWS: Mapping[str, Law] = MappingProxyType(
    {
        law.__name__: law
        for law in (
            *(free_fall, sliding, mixing, rolling, pendulum, stack, shapes, restitution, momentum, pushing, carrying),
            *(motors, limits, wrenches, forgetting, determinism, refusals, divergence, cost),
        )
    }
)
"""Laws of all physics engines, by name, in the order in which they are tried."""


class PhysicsEngineContract(ComponentContract):
    """Contract of all physics engines; subclass it in a test file.

    class TestMyEngine(PhysicsEngineContract):
        component = "my_package/my_engine"
        facts = EngineFacts(mixing="geometric mean")
    """

    kind = ComponentKind.PHYSICS_ENGINE
    laws = LAWS
    facts: ClassVar[EngineFacts] = EngineFacts()


_NONE_DRIVEN = Driven(np.zeros((0, 7)), np.zeros((0, 6)))


def _load(trial: EngineTrial, bodies: tuple[Body, ...], q: Floats, v: Floats, gravity: float = GRAVITY) -> None:
    trial.call("load", PhysicsModel(bodies, (0.0, 0.0, -gravity), SUBSTEP), q, v)


def _run(trial: EngineTrial, bodies: tuple[Body, ...], substeps: int) -> Stepped:
    return _step(trial, bodies, _NONE_DRIVEN, substeps)


def _step(
    trial: EngineTrial,
    bodies: tuple[Body, ...],
    driven: Driven,
    substeps: int,
    told: Motors | None = None,
    wrench: Floats | None = None,
) -> Stepped:
    """Return an answer of the right shapes, all finite."""
    joints = len(jointed(bodies))
    answer = trial.call("step", driven, told or motors_off(joints), wrench, substeps)
    if not isinstance(answer, Stepped) or not isinstance(answer.contacts, TouchingBodies):
        raise LawBroken(f"step returned {type(answer).__name__}; it must be Stepped, with TouchingBodies")
    nq, nv = sizes(bodies)
    touching = answer.contacts
    count = len(touching.bodies)
    parts: list[tuple[Any, str, tuple[int, ...]]] = [
        *((answer.q, "q", (nq,)), (answer.v, "v", (nv,)), (answer.efforts, "efforts", (joints,))),
        *((touching.positions, "positions", (count, 3)), (touching.normals, "normals", (count, 3))),
        (touching.forces, "forces", (count, 3)),
    ]
    for value, name, shape in parts:
        if not np.isfinite(checked(value, name, np.float64, shape)).all():
            raise LawBroken(f"{name} of a step is {numbers(value)}; all must be finite")
    checked(touching.bodies, "the contacts' bodies", np.int32, (count, 2))
    return answer


def _box(name: str, size: tuple[float, float, float], surface: Surface = Surface()) -> Body:  # noqa: B008  frozen
    """Return a free box of 1 kg with these lengths."""
    x, y, z = (side * side / 12.0 for side in size)
    inertia = np.diag([y + z, x + z, x + y])
    half = size[0] / 2.0, size[1] / 2.0, size[2] / 2.0
    shape = BodyShape(ShapeKind.BOX, half)
    return Body(name, joint=BodyJoint.FREE, mass=1.0, inertia=inertia, shapes=(shape,), surface=surface)


def _ball(name: str, radius: float, surface: Surface) -> Body:
    """Return a free solid sphere of 1 kg."""
    shape = BodyShape(ShapeKind.SPHERE, (radius,))
    inertia = np.eye(3) * 0.4 * radius**2
    return Body(name, joint=BodyJoint.FREE, mass=1.0, inertia=inertia, shapes=(shape,), surface=surface)


def _floor(surface: Surface, angle: float = 0.0) -> Body:
    """Return a floor through the origin, turned about y so that it falls towards x."""
    pose = np.eye(4)
    pose[:3, :3] = [
        [math.cos(angle), 0.0, math.sin(angle)],
        [0.0, 1.0, 0.0],
        [-math.sin(angle), 0.0, math.cos(angle)],
    ]
    pose[:3, 3] = -0.5 * pose[:3, 2]
    return Body("floor", parent_t_body=pose, shapes=(BodyShape(ShapeKind.BOX, (20.0, 20.0, 0.5)),), surface=surface)


def _acceleration(trial: EngineTrial, angle: float, body: Body, height: float, slope: Surface) -> float:
    """Return how fast a body gets faster down a slope, after it has settled (m/s^2)."""
    bodies = (_floor(slope, angle), body)
    along = np.array([math.cos(angle), 0.0, -math.sin(angle)])
    up = np.array([math.sin(angle), 0.0, math.cos(angle)])
    q = np.array([*(height * up), 0.0, math.sin(angle / 2.0), 0.0, math.cos(angle / 2.0)])
    _load(trial, bodies, q, np.zeros(6))
    _run(trial, bodies, 300)
    # A line through many speeds: engines with soft contacts hop a little on their way.
    speeds = [float(_run(trial, bodies, 50).v[:3] @ along) for _ in range(40)]
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


def _force(contacts: TouchingBodies, first: int, second: int) -> Floats:
    """Return the force on `second` by `first` (3,) in N."""
    total = np.zeros(3)
    for (one, other), force in zip(contacts.bodies.tolist(), contacts.forces, strict=True):
        if (one, other) == (first, second):
            total += force
        elif (other, one) == (first, second):
            total -= force
    return total


def _momentum(bodies: tuple[Body, ...], q: Floats, v: Floats) -> Floats:
    """Return linear and angular momentum (6,) about the origin of free bodies whose centers are their origins."""
    total = np.zeros(6)
    for body, pose, twist in zip(bodies, q.reshape(-1, 7), v.reshape(-1, 6), strict=True):
        rotation = from_quaternion(pose[3:])[:3, :3]
        linear = body.mass * twist[:3]
        total[:3] += linear
        total[3:] += np.cross(pose[:3], linear) + rotation @ body.inertia @ twist[3:]
    return total


def _heap(rng: np.random.Generator, count: int = 8) -> tuple[tuple[Body, ...], Floats, Floats]:
    """Return a floor and boxes that fall on it and each other."""
    bodies = (_floor(Surface(0.6)), *(_box(f"box {i}", (0.1, 0.1, 0.1), Surface(0.6)) for i in range(count)))
    places = [(0.13 * (i % 2), 0.04 * (i % 3), 0.06 + 0.11 * (i // 2)) for i in range(count)]
    q = np.concatenate([_pose(np.array(place) + rng.uniform(-0.01, 0.0, 3)) for place in places])
    return bodies, q, np.concatenate([np.append(rng.uniform(-0.5, 0.0, 3), np.zeros(3)) for _ in range(count)])


def _pose(position: Any) -> Floats:  # noqa: ANN401
    """Return a pose (7,) that is not turned."""
    return np.array([*position, 0.0, 0.0, 0.0, 1.0])


def _at(position: tuple[float, float, float]) -> Floats:
    pose = np.eye(4)
    pose[:3, 3] = position
    return pose


def _bits(answer: Stepped) -> bytes:
    return answer.q.tobytes() + answer.v.tobytes()


def _senseless_steps(bodies: tuple[Body, ...]) -> Iterator[tuple[str, tuple[object, ...], str]]:
    """Yield steps that must be refused, of bodies of which none is driven and none has a motor."""
    off, nan = motors_off(0), np.full((len(bodies), 6), np.nan)
    yield "step", (_NONE_DRIVEN, off, None, 0), "no substeps"
    yield "step", (_NONE_DRIVEN, off, nan, TICK), "wrenches with NaN"
    yield "step", (_NONE_DRIVEN, off, np.zeros((1, 6)), TICK), "too few wrenches"
    yield "step", (_NONE_DRIVEN, motors_off(1), None, TICK), "too many motors"
    yield "step", (Driven(_pose((0.0, 0.0, 0.0))[None], np.zeros((1, 6))), off, None, TICK), "a driven body too many"
    q, v = sizes(bodies)
    yield "set_state", (np.full(q, np.nan), np.zeros(v)), "NaN"
    yield "set_state", (np.zeros(q), np.zeros(v)), "quaternions without length"
    yield "set_state", (np.zeros(q + 1), np.zeros(v)), "a coordinate too many"


def _senseless_models(q: Floats, v: Floats) -> Iterator[tuple[str, tuple[object, ...], str]]:
    """Yield models that must be refused."""
    box, one, still = _box("box", (0.1, 0.1, 0.1)), q[:7], v[:6]
    flat = BodyShape(ShapeKind.HULL, (), np.eye(4), np.array([[x, y, 0.0] for x in (0.0, 1.0) for y in (0.0, 1.0)]))
    wrong = {
        "a body without mass": replace(box, mass=0.0),
        "a negative mass": replace(box, mass=-1.0),
        "a negative moment of inertia": replace(box, inertia=np.diag([1.0, 1.0, -1.0])),
        "a moment above the sum of the others": replace(box, inertia=np.diag([1.0, 1.0, 3.0])),
        "an inertia that is not symmetric": replace(box, inertia=np.eye(3) + np.triu(np.full((3, 3), 0.1), 1)),
        "a hull without volume": replace(box, shapes=(flat,)),
        "a box without height": replace(box, shapes=(BodyShape(ShapeKind.BOX, (0.1, 0.1, 0.0)),)),
        "negative friction": replace(box, surface=Surface(-0.1)),
        "a restitution above 1": replace(box, surface=Surface(restitution=1.5)),
        "a parent that comes later": replace(box, parent=3),
        "a mass of NaN": replace(box, mass=math.nan),
    }
    for what, body in wrong.items():
        yield "load", (PhysicsModel((body,)), one, still), what
    yield "load", (PhysicsModel((box,), seconds=0.0), one, still), "substeps without length"
    yield "load", (PhysicsModel((box,)), np.full(7, np.nan), still), "NaN"
    yield "load", (PhysicsModel((box, box)), one, still), "the state of one body for two"
    driven = replace(box, driven=True)
    hinged = replace(box, parent=0, joint=BodyJoint.REVOLUTE)
    yield "load", (PhysicsModel((driven, hinged)), np.zeros(1), np.zeros(1)), "a joint on a driven body"
