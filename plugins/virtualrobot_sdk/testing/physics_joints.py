"""Laws of joints of physics engines: motors, limits, and forces from outside."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from virtualrobot_sdk.physics import BodyJoint, Coupling, MotorMode, Motors, PhysicsModel, motors_off
from virtualrobot_sdk.testing.laws import LawBroken, Measured
from virtualrobot_sdk.testing.physics_scenes import (
    NONE_DRIVEN,
    SUBSTEP,
    EngineTrial,
    a_box,
    load_scene,
    pose_at,
    run_scene,
    step_scene,
)
from virtualrobot_sdk.testing.trial import numbers


def motors(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A joint's motor exerts an effort, holds a velocity or goes to a position, and no stronger than it may."""
    wheel = replace(a_box("wheel", (0.2, 0.2, 0.05)), joint=BodyJoint.REVOLUTE, shapes=())
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
        load_scene(trial, bodies, np.zeros(1), np.zeros(1), gravity=0.0)
        after = step_scene(trial, bodies, NONE_DRIVEN, round(seconds / SUBSTEP), motor)
        off = abs(float(after.v[0]) / expected - 1.0)
        worst = max(worst, off)
        if off > tolerance:
            raise LawBroken(f"a motor told {name} turns its joint by {after.v[0]:.6g} rad/s; it must be {expected:.6g}")
        if name == "an effort" and abs(float(after.efforts[0]) - effort) > 1e-6:
            raise LawBroken(f"a motor told {effort:.6g} N m says that it exerts {after.efforts[0]:.6g} N m")
    # Critically damped, at 20 rad/s.
    stiffness, damping = about * 400.0, about * 40.0
    load_scene(trial, bodies, np.zeros(1), np.zeros(1), gravity=0.0)
    after = step_scene(trial, bodies, NONE_DRIVEN, 1000, told(MotorMode.POSITION, 0.7, math.inf, stiffness, damping))
    if abs(float(after.q[0]) - 0.7) > 1e-3:
        raise LawBroken(f"a motor told the position 0.7 rad is at {after.q[0]:.6g} rad after 1 s")
    return Measured(5, {"part": worst})


def couplings(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A joint that follows another one goes its way, and both are as heavy as they are together.

    Pushed by F at the leader of mass m, whose follower goes k times its way, it accelerates by F / (m + k^2 m); pushed
    at the follower, by k F / (m + k^2 m): the kinetic energy of both is m (1 + k^2) v^2 / 2.
    """
    slide = replace(a_box("rack", (0.1, 0.1, 0.1)), joint=BodyJoint.PRISMATIC, axis=(0.0, 1.0, 0.0), shapes=())
    bodies = (replace(slide, name="follower", axis=(0.0, -1.0, 0.0)), slide)
    ratio, offset = float(rng.choice((-1.0, 1.0)) * rng.uniform(0.5, 2.0)), float(rng.uniform(-0.1, 0.1))
    force, seconds = float(rng.uniform(1.0, 3.0)), 0.2
    model = PhysicsModel(bodies, (0.0, 0.0, 0.0), SUBSTEP, (Coupling(0, 1, ratio, offset),))
    for pushed, share in ((1, 1.0), (0, ratio)):
        trial.call("load", model, np.array([offset, 0.0]), np.zeros(2))
        effort = replace(motors_off(2), mode=np.ones(2, np.int32), target=force * np.eye(2)[pushed])
        after = step_scene(trial, bodies, NONE_DRIVEN, round(seconds / SUBSTEP), effort)
        expected = share * force * seconds / (slide.mass * (1.0 + ratio * ratio))
        if abs(float(after.v[1]) / expected - 1.0) > 1e-2 or abs(float(after.v[0] / after.v[1]) / ratio - 1.0) > 1e-2:
            raise LawBroken(
                f"a joint that leads another one by {ratio:.4g}, pushed by {force:.4g} N at the "
                f"{('follower', 'leader')[pushed]}, has the velocities {numbers(after.v)} after {seconds} s; that of "
                f"the leader must be {expected:.6g}"
            )
        off = float(after.q[0]) - ratio * float(after.q[1]) - offset
        if abs(off) > 1e-3:
            raise LawBroken(f"a joint that follows another one is off by {1e3 * off:.3g} mm after {seconds} s")
    return Measured(2)


def limits(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A joint stops at its limits."""
    del rng
    wheel = replace(a_box("door", (0.2, 0.2, 0.05)), joint=BodyJoint.REVOLUTE, shapes=(), lower=-0.5, upper=0.5)
    load_scene(trial, (wheel,), np.zeros(1), np.ones(1), gravity=0.0)
    after = run_scene(trial, (wheel,), 1000)
    if not -0.52 <= float(after.q[0]) <= 0.52:
        raise LawBroken(f"a joint that ends at 0.5 rad is at {after.q[0]:.4g} rad")
    return Measured(1)


def wrenches(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A force at the center of mass moves a body without turning it, a torque turns it without moving it."""
    box = replace(a_box("box", (0.1, 0.1, 0.1)), shapes=(), center_of_mass=(0.02, 0.0, 0.0))
    force, torque = float(rng.uniform(1.0, 3.0)), 0.001
    load_scene(trial, (box,), pose_at((0.0, 0.0, 0.0)), np.zeros(6), gravity=0.0)
    pushed = step_scene(trial, (box,), NONE_DRIVEN, 100, None, np.array([[0.0, force, 0.0, 0.0, 0.0, 0.0]]))
    expected = force / box.mass * 0.1
    if abs(float(pushed.v[1]) - expected) > 1e-3 * expected or abs(float(pushed.v[5])) > 1e-6:
        raise LawBroken(f"pushed by {force:.4g} N for 0.1 s, it has the velocities {numbers(pushed.v)}")
    load_scene(trial, (box,), pose_at((0.0, 0.0, 0.0)), np.zeros(6), gravity=0.0)
    turned = step_scene(trial, (box,), NONE_DRIVEN, 100, None, np.array([[0.0, 0.0, 0.0, 0.0, 0.0, torque]]))
    expected = torque / float(box.inertia[2, 2]) * 0.1
    if abs(float(turned.v[5]) - expected) > 1e-3 * expected:
        raise LawBroken(f"turned by {torque} N m for 0.1 s, it turns by {turned.v[5]:.6g} rad/s, not {expected:.6g}")
    return Measured(2)
