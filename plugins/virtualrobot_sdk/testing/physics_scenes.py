"""Scenes of the laws of physics engines: bodies, states and steps whose answers are looked at."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.physics import (
    Body,
    BodyJoint,
    BodyShape,
    Driven,
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
from virtualrobot_sdk.testing.laws import LawBroken
from virtualrobot_sdk.testing.trial import Trial, checked, numbers

GRAVITY = 9.81
"""In m/s^2, downwards."""
SUBSTEP = 0.001
"""Length of a substep in all laws (s)."""
TICK = 4
"""Substeps of the calls that most laws make."""
NONE_DRIVEN = Driven(np.zeros((0, 7)), np.zeros((0, 6)))
"""Driven bodies of a scene without any."""


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


def load_scene(trial: EngineTrial, bodies: tuple[Body, ...], q: Floats, v: Floats, gravity: float = GRAVITY) -> None:
    """Load bodies in a state; gravity points downwards (m/s^2)."""
    trial.call("load", PhysicsModel(bodies, (0.0, 0.0, -gravity), SUBSTEP), q, v)


def run_scene(trial: EngineTrial, bodies: tuple[Body, ...], substeps: int) -> Stepped:
    """Return the answer to some substeps in which nothing is driven and no motor is told anything."""
    return step_scene(trial, bodies, NONE_DRIVEN, substeps)


def step_scene(
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


def a_box(name: str, size: tuple[float, float, float], surface: Surface = Surface()) -> Body:  # noqa: B008  frozen
    """Return a free box of 1 kg with these lengths."""
    x, y, z = (side * side / 12.0 for side in size)
    inertia = np.diag([y + z, x + z, x + y])
    half = size[0] / 2.0, size[1] / 2.0, size[2] / 2.0
    shape = BodyShape(ShapeKind.BOX, half)
    return Body(name, joint=BodyJoint.FREE, mass=1.0, inertia=inertia, shapes=(shape,), surface=surface)


def a_ball(name: str, radius: float, surface: Surface) -> Body:
    """Return a free solid sphere of 1 kg."""
    shape = BodyShape(ShapeKind.SPHERE, (radius,))
    inertia = np.eye(3) * 0.4 * radius**2
    return Body(name, joint=BodyJoint.FREE, mass=1.0, inertia=inertia, shapes=(shape,), surface=surface)


def a_floor(surface: Surface, angle: float = 0.0) -> Body:
    """Return a floor through the origin, turned about y so that it falls towards x."""
    pose = np.eye(4)
    pose[:3, :3] = [
        [math.cos(angle), 0.0, math.sin(angle)],
        [0.0, 1.0, 0.0],
        [-math.sin(angle), 0.0, math.cos(angle)],
    ]
    pose[:3, 3] = -0.5 * pose[:3, 2]
    return Body("floor", parent_t_body=pose, shapes=(BodyShape(ShapeKind.BOX, (20.0, 20.0, 0.5)),), surface=surface)


def force_on(contacts: TouchingBodies, first: int, second: int) -> Floats:
    """Return the force on `second` by `first` (3,) in N."""
    total = np.zeros(3)
    for (one, other), force in zip(contacts.bodies.tolist(), contacts.forces, strict=True):
        if (one, other) == (first, second):
            total += force
        elif (other, one) == (first, second):
            total -= force
    return total


def a_heap(rng: np.random.Generator, count: int = 8) -> tuple[tuple[Body, ...], Floats, Floats]:
    """Return a floor and boxes that fall on it and each other."""
    bodies = (a_floor(Surface(0.6)), *(a_box(f"box {i}", (0.1, 0.1, 0.1), Surface(0.6)) for i in range(count)))
    places = [(0.13 * (i % 2), 0.04 * (i % 3), 0.06 + 0.11 * (i // 2)) for i in range(count)]
    q = np.concatenate([pose_at(np.array(place) + rng.uniform(-0.01, 0.0, 3)) for place in places])
    return bodies, q, np.concatenate([np.append(rng.uniform(-0.5, 0.0, 3), np.zeros(3)) for _ in range(count)])


def pose_at(position: Any) -> Floats:  # noqa: ANN401
    """Return a pose (7,) that is not turned."""
    return np.array([*position, 0.0, 0.0, 0.0, 1.0])


def frame_at(position: tuple[float, float, float]) -> Floats:
    """Return a pose (4, 4) that is not turned."""
    pose = np.eye(4)
    pose[:3, 3] = position
    return pose


def bits_of(answer: Stepped) -> bytes:
    """Return the state of an answer as bytes."""
    return answer.q.tobytes() + answer.v.tobytes()
