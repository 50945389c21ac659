"""Laws of contacts of physics engines: stacks, shapes, impacts, and what is pushed and carried."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.physics import Body, BodyJoint, BodyShape, Driven, ShapeKind, Surface
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
    force_on,
    load_scene,
    pose_at,
    run_scene,
    step_scene,
)
from virtualrobot_sdk.testing.trial import numbers


def stack(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """Ten boxes on each other stay where they are, no deeper than said; contacts carry what is above them."""
    del rng
    side, count = 0.1, 10
    bodies = (a_floor(Surface(0.8)), *(a_box(f"box {i}", (side, side, side), Surface(0.8)) for i in range(count)))
    q = np.concatenate([pose_at((0.0, 0.0, side * (i + 0.5))) for i in range(count)])
    load_scene(trial, bodies, q, np.zeros(6 * count))
    after = run_scene(trial, bodies, 1000)
    moved = (after.q - q).reshape(count, 7)[:, :3]
    aside, sunk = float(np.abs(moved[:, :2]).max()), np.abs(np.diff(moved[:, 2], prepend=0.0)).max()
    if aside > 0.005 or sunk > trial.facts.sinking or abs(after.v).max() > 0.05:
        raise LawBroken(
            f"ten boxes on each other have gone {aside:.3g} m aside, one is {sunk:.3g} m deep in the next (`sinking` "
            f"of EngineFacts: {trial.facts.sinking:g}), and the fastest moves by {np.abs(after.v).max():.3g} m/s, rad/s"
        )
    worst = 0.0
    for lower in range(count):
        felt = force_on(after.contacts, lower, lower + 1)
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
    bodies = (a_floor(surface), *(replace(free, name=name, shapes=(shape,)) for name, (shape, _) in made.items()))
    q = np.concatenate([pose_at((0.5 * i, 0.0, height)) for i, (_, height) in enumerate(made.values())])
    load_scene(trial, bodies, q, np.zeros(6 * len(made)))
    after = run_scene(trial, bodies, 500)
    worst = 0.0
    for i, (name, (_, height)) in enumerate(made.items()):
        off = abs(float(after.q[7 * i + 2]) - height)
        worst = max(worst, off)
        if off > max(trial.facts.sinking, 2e-3):
            raise LawBroken(f"a {name} rests at {after.q[7 * i + 2]:.6g} m; its shape says {height:g} m")
    felt = np.sum([force_on(after.contacts, 0, row) for row in range(1, len(bodies))], axis=0)
    if abs(float(felt[2]) / (GRAVITY * len(made)) - 1.0) > 0.02:
        raise LawBroken(f"the floor carries {numbers(felt)} N; what lies on it weighs {GRAVITY * len(made):.6g} N")
    return Measured(len(made), {"m": worst})


def heights(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """Ground of heights is touched where it is: a ball rests in its groove, on both sides, and a box beside that.

    The sides of the groove rise by the angle a, so a ball of radius r rests with its middle r / cos a above the bottom.
    """
    del rng
    cell, angle, radius, half = 0.05, math.radians(30.0), 0.07, 0.04
    x = cell * np.arange(-40, 41)
    profile = np.minimum(np.abs(x), 0.5) * math.tan(angle)
    level = float(profile.max())
    surface = Surface(0.8, rolling=0.001)
    field = BodyShape(ShapeKind.HEIGHTS, (cell, cell), heights=np.tile(profile, (21, 1)))
    bodies = (
        Body("ground", shapes=(field,), surface=surface),
        a_ball("ball", radius, surface),
        a_box("box", (2.0 * half, 2.0 * half, 2.0 * half), surface),
    )
    wanted = {"ball": radius / math.cos(angle), "box": level + half}
    load_scene(
        trial, bodies, np.append(pose_at((0.0, 0.0, wanted["ball"])), pose_at((1.2, 0.0, wanted["box"]))), np.zeros(12)
    )
    after = run_scene(trial, bodies, 500)
    worst = 0.0
    for i, (name, height) in enumerate(wanted.items()):
        off = abs(float(after.q[7 * i + 2]) - height)
        worst = max(worst, off)
        if off > max(trial.facts.sinking, 2e-3) / math.cos(angle):
            raise LawBroken(f"a {name} rests at {after.q[7 * i + 2]:.6g} m; heights say {height:.6g} m")
        felt = force_on(after.contacts, 0, i + 1)
        if abs(float(felt[2]) / GRAVITY - 1.0) > 0.02:
            raise LawBroken(f"ground carries {numbers(felt)} N of a {name} that weighs {GRAVITY:.6g} N")
    return Measured(2, {"m": worst})


def restitution(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A ball and a box that fall on the floor come back as high as their surface says: to e^2 h from h.

    None comes back higher than it fell, but for half a per cent of what engines round.
    """
    del rng
    worst = 0.0
    cases = [(wanted, height) for wanted in (0.0, 0.3, 0.5, 0.9, 1.0) for height in (0.2, 1.0)]
    for number, (wanted, height) in enumerate(cases):
        surface = Surface(0.5, restitution=wanted)
        body = a_box("box", (0.2, 0.2, 0.2), surface) if number % 3 == 2 else a_ball("ball", 0.1, surface)
        bodies = (a_floor(surface), body)
        load_scene(trial, bodies, pose_at((0.0, 0.0, 0.1 + height)), np.zeros(6))
        falls = math.sqrt(2.0 * height / GRAVITY)
        # It is on its way up for no longer than it fell.
        run_scene(trial, bodies, round(falls / SUBSTEP) + 10 * TICK)
        top = max(float(run_scene(trial, bodies, TICK).q[2]) - 0.1 for _ in range(round(falls / SUBSTEP / TICK)))
        found = math.sqrt(max(top, 0.0) / height)
        worst = max(worst, abs(found - wanted))
        if abs(found - wanted) > trial.facts.bouncing or top > 1.005 * height:
            raise LawBroken(
                f"a {body.name} that falls by {height:g} m on the floor comes back by {top:.4g} m, as with {found:.3f} "
                f"of its speed; its restitution is {wanted:g} (`bouncing` of EngineFacts: {trial.facts.bouncing:g})"
            )
    return Measured(len(cases), {"of restitution": worst})


def momentum(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """Bodies that hit each other where nothing else pulls keep their momentum, linear and angular."""
    bodies = (a_box("first", (0.1, 0.2, 0.1)), replace(a_box("second", (0.1, 0.1, 0.1)), mass=3.0))
    q = np.concatenate([pose_at((-0.3, 0.0, 0.0)), pose_at((0.0, float(rng.uniform(0.02, 0.08)), 0.0))])
    v = np.zeros(12)
    v[0] = float(rng.uniform(1.0, 2.0))
    load_scene(trial, bodies, q, v, gravity=0.0)
    before, after = _momentum(bodies, q, v), run_scene(trial, bodies, 400)
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
    paddle = replace(a_box("paddle", (0.05, 0.4, 0.2), Surface(0.1)), driven=True)
    bodies = (a_floor(Surface(0.3)), paddle, a_box("box", (0.2, 0.2, 0.2), Surface(0.3)))
    speed, start, steps = 0.2, -0.2, 250
    load_scene(trial, bodies, pose_at((0.0, 0.0, 0.1)), np.zeros(6))
    twist = np.array([[speed, 0.0, 0.0, 0.0, 0.0, 0.0]])
    answer = None
    for step in range(1, steps + 1):
        pose = pose_at((start + speed * step * TICK * SUBSTEP, 0.0, 0.2))[None]
        answer = step_scene(trial, bodies, Driven(pose, twist), TICK)
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
    belt = replace(a_box("belt", (4.0, 0.5, 0.1), Surface(0.8)), driven=True)
    bodies = (belt, a_box("box", (0.2, 0.2, 0.2), Surface(0.8)))
    speed, seconds = 0.2, 1.0
    load_scene(trial, bodies, pose_at((0.0, 0.0, 0.1)), np.zeros(6))
    driven = Driven(pose_at((0.0, 0.0, -0.05))[None], np.array([[speed, 0.0, 0.0, 0.0, 0.0, 0.0]]))
    answer = None
    for _ in range(round(seconds / (TICK * SUBSTEP))):
        answer = step_scene(trial, bodies, driven, TICK)
    assert answer is not None
    # It slips until friction has brought it up to the belt's speed.
    expected = speed * (seconds - speed / (2.0 * 0.8 * GRAVITY))
    off = abs(float(answer.q[0]) - expected)
    if off > 0.02 * expected:
        raise LawBroken(
            f"a belt of {speed} m/s has carried a box by {answer.q[0]:.4g} m in {seconds} s, not {expected:.4g}"
        )
    return Measured(1, {"m": off})


def _momentum(bodies: tuple[Body, ...], q: Floats, v: Floats) -> Floats:
    """Return linear and angular momentum (6,) about the origin of free bodies whose centers are their origins."""
    total = np.zeros(6)
    for body, pose, twist in zip(bodies, q.reshape(-1, 7), v.reshape(-1, 6), strict=True):
        rotation = from_quaternion(pose[3:])[:3, :3]
        linear = body.mass * twist[:3]
        total[:3] += linear
        total[3:] += np.cross(pose[:3], linear) + rotation @ body.inertia @ twist[3:]
    return total
