"""Laws of conduct of physics engines: bits that come again, refusals, and what falls apart."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from virtualrobot_sdk.errors import ComponentFault
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.physics import (
    Body,
    BodyJoint,
    BodyShape,
    Coupling,
    Driven,
    PhysicsModel,
    ShapeKind,
    Surface,
    motors_off,
    sizes,
)
from virtualrobot_sdk.testing.laws import LawBroken, Measured
from virtualrobot_sdk.testing.physics_scenes import (
    NONE_DRIVEN,
    TICK,
    EngineTrial,
    a_box,
    a_heap,
    bits_of,
    load_scene,
    pose_at,
    run_scene,
    step_scene,
)
from virtualrobot_sdk.testing.trial import must_refuse


def forgetting(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A state that is set goes on with the same bits, whatever came before it."""
    bodies, q, v = a_heap(rng)
    load_scene(trial, bodies, q, v)
    for _ in range(10):
        middle = run_scene(trial, bodies, TICK)
    runs = []
    for _ in range(2):
        trial.call("set_state", middle.q, middle.v)
        runs.append([bits_of(run_scene(trial, bodies, TICK)) for _ in range(10)])
    if runs[0] != runs[1]:
        raise LawBroken("the same state, set again, goes on otherwise; set_state must forget what came before")
    return Measured(2)


def determinism(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """The same calls since load give the same bits: again, and in another process."""
    bodies, q, v = a_heap(rng)
    runs = []
    with trial.twin() as twin:
        for one in (trial, trial, twin):
            load_scene(one, bodies, q, v)
            runs.append([bits_of(run_scene(one, bodies, TICK)) for _ in range(20)])
    for run, where in zip(runs[1:], ("", " in another process"), strict=True):
        if run != runs[0]:
            raise LawBroken(f"the same calls give other bits{where}")
    return Measured(2)


def refusals(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """Arguments that make no sense are refused by an ArgumentError, and the state is the same as before."""
    bodies, q, v = a_heap(rng)
    load_scene(trial, bodies, q, v)
    expected = bits_of(run_scene(trial, bodies, TICK))
    load_scene(trial, bodies, q, v)
    tried = must_refuse(trial, _senseless_steps(bodies))
    if bits_of(run_scene(trial, bodies, TICK)) != expected:
        raise LawBroken("after a step that was refused, the next one ends elsewhere")
    return Measured(tried + must_refuse(trial, _senseless_models(q, v)))


def divergence(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """A push beyond all numbers ends in an error or in finite numbers, and load begins anew."""
    bodies, q, v = a_heap(rng)
    load_scene(trial, bodies, q, v)
    wrench = np.zeros((len(bodies), 6))
    wrench[1, 0] = 1e308
    said = ""
    try:
        for _ in range(20):
            step_scene(trial, bodies, NONE_DRIVEN, 100, None, wrench)
    except ComponentFault as fault:
        said = str(fault)
    trial.renew()
    load_scene(trial, bodies, q, v)
    run_scene(trial, bodies, TICK)
    return Measured(1, note=said)


def cost(trial: EngineTrial, rng: np.random.Generator) -> Measured:
    """Nothing; it tells microseconds a substep of a heap of boxes."""
    bodies, q, v = a_heap(rng, 27)
    load_scene(trial, bodies, q, v)
    arguments = NONE_DRIVEN, motors_off(0), None, TICK
    return Measured(1, {"us a substep": 1e6 * float(np.median(trial.seconds(20, "step", *arguments))) / TICK})


def _senseless_steps(bodies: tuple[Body, ...]) -> Iterator[tuple[str, tuple[object, ...], str]]:
    """Yield steps that must be refused, of bodies of which none is driven and none has a motor."""
    off, nan = motors_off(0), np.full((len(bodies), 6), np.nan)
    yield "step", (NONE_DRIVEN, off, None, 0), "no substeps"
    yield "step", (NONE_DRIVEN, off, nan, TICK), "wrenches with NaN"
    yield "step", (NONE_DRIVEN, off, np.zeros((1, 6)), TICK), "too few wrenches"
    yield "step", (NONE_DRIVEN, motors_off(1), None, TICK), "too many motors"
    yield "step", (Driven(pose_at((0.0, 0.0, 0.0))[None], np.zeros((1, 6))), off, None, TICK), "a driven body too many"
    q, v = sizes(bodies)
    yield "set_state", (np.full(q, np.nan), np.zeros(v)), "NaN"
    yield "set_state", (np.zeros(q), np.zeros(v)), "quaternions without length"
    yield "set_state", (np.zeros(q + 1), np.zeros(v)), "a coordinate too many"


def _senseless_models(q: Floats, v: Floats) -> Iterator[tuple[str, tuple[object, ...], str]]:
    """Yield models that must be refused."""
    box, one, still = a_box("box", (0.1, 0.1, 0.1)), q[:7], v[:6]
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
        "a mass that no floor carries": replace(box, mass=1e15, inertia=1e15 * np.eye(3)),
    }
    field = BodyShape(ShapeKind.HEIGHTS, (0.1, 0.1), heights=np.zeros((3, 3)))
    wrong |= {
        "heights of a body that moves": replace(box, shapes=(field,)),
        "heights of one row": Body("ground", shapes=(replace(field, heights=np.zeros((1, 3))),)),
        "a height of NaN": Body("ground", shapes=(replace(field, heights=np.full((3, 3), math.nan)),)),
        "cells without length": Body("ground", shapes=(replace(field, size=(0.1, 0.0)),)),
    }
    for what, body in wrong.items():
        yield "load", (PhysicsModel((body,)), one, still), what
    yield "load", (PhysicsModel((box,), seconds=0.0), one, still), "substeps without length"
    yield "load", (PhysicsModel((box,)), np.full(7, np.nan), still), "NaN"
    yield "load", (PhysicsModel((box, box)), one, still), "the state of one body for two"
    slide = replace(box, joint=BodyJoint.PRISMATIC)
    for what, coupling in {
        "a joint that follows itself": Coupling(0, 0),
        "a joint that follows nothing": Coupling(0, 2),
        "a ratio of 0": Coupling(0, 1, 0.0),
        "an offset of NaN": Coupling(0, 1, 1.0, math.nan),
    }.items():
        model = PhysicsModel((slide, replace(slide, name="other")), couplings=(coupling,))
        yield "load", (model, np.zeros(2), np.zeros(2)), what
    driven = replace(box, driven=True)
    hinged = replace(box, parent=0, joint=BodyJoint.REVOLUTE)
    yield "load", (PhysicsModel((driven, hinged)), np.zeros(1), np.zeros(1)), "a joint on a driven body"
