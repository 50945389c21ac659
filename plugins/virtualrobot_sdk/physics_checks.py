"""Checks of arguments that every physics engine makes; each refusal names the body and what would be right."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from virtualrobot_sdk.arrays import is_finite
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats, Integers
from virtualrobot_sdk.physics import (
    WORLD,
    Body,
    BodyJoint,
    BodyShape,
    Driven,
    MotorMode,
    Motors,
    PhysicsModel,
    ShapeKind,
    jointed,
    places,
    roots,
    sizes,
)

_MODES = sorted(mode.value for mode in MotorMode)
UNIT_TOLERANCE = 1e-6
"""Tolerance of the length of a quaternion and of an axis."""
TRIANGLE_TOLERANCE = 1e-9
"""Part by which a moment may exceed the sum of the other two: room for rounding."""
LEAST = 1e-14
"""Least mass (kg) and moment of inertia (kg m^2) that engines tell from none; that of a steel ball of 0.5 mm."""
MOST = 1e12
"""Greatest mass (kg) that engines hold up; heavier ones sink into what they lie on."""
_SIZES = {
    ShapeKind.BOX: 3,
    ShapeKind.SPHERE: 1,
    ShapeKind.CYLINDER: 2,
    ShapeKind.CAPSULE: 2,
    ShapeKind.HULL: 0,
    ShapeKind.HEIGHTS: 2,
}


def check_model(model: PhysicsModel) -> None:
    """Raise ArgumentError for a body that cannot be as it says, by its name."""
    if not (0.0 < model.seconds < math.inf):
        raise ArgumentError(f"a substep of {model.seconds} s; it must be above 0")
    if not np.isfinite(model.gravity).all():
        raise ArgumentError(f"gravity is {model.gravity}; it must be finite")
    for row, body in enumerate(model.bodies):
        _check_place(model.bodies, row)
        if (body.joint is not BodyJoint.FIXED and not body.driven) or body.mass:
            check_inertia(body.name, body.mass, body.inertia)
        if not np.isfinite(body.center_of_mass).all():
            raise _wrong(body, f"has its center of mass at {body.center_of_mass}; it must be finite")
        if not body.lower <= body.upper:
            raise _wrong(body, f"has limits from {body.lower} to {body.upper}; the lower must not be above the upper")
        for shape in body.shapes:
            _check_shape(body, shape)
            if shape.kind is ShapeKind.HEIGHTS and (len(body.shapes) > 1 or _moves(model.bodies, row)):
                raise _wrong(body, "has heights; they are the only shape of a body that nothing moves")
        surface = body.surface
        for name in ("friction", "spinning", "rolling", "restitution", "stiffness", "damping"):
            value = getattr(surface, name)
            if not 0.0 <= value < math.inf or (name == "restitution" and value > 1.0):
                right = "from 0 to 1" if name == "restitution" else "0 or more, and finite"
                raise _wrong(body, f"has a surface with {name} {value}; it must be {right}")
    _check_couplings(model)


def check_inertia(name: str, mass: float, inertia: Floats) -> None:
    """Raise ArgumentError, by the body's `name`, unless a rigid body can have this mass and inertia (3, 3).

    It can when the mass is from LEAST to MOST, the matrix symmetric and positive definite, and none of its principal
    moments above the sum of the other two.
    """
    if not LEAST <= mass <= MOST:
        raise ArgumentError(
            f"{name!r} has a mass of {mass} kg; what moves by itself needs {LEAST} at least and {MOST:g} at most",
            body=name,
        )
    matrix = np.asarray(inertia, float)
    if matrix.shape != (3, 3) or not np.isfinite(matrix).all() or not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0):
        raise ArgumentError(f"{name!r} has the inertia {matrix.tolist()}; it must be symmetric and finite", body=name)
    least, middle, greatest = np.linalg.eigvalsh(matrix)
    if least < LEAST:
        raise ArgumentError(
            f"{name!r} has a moment of inertia of {least:.6g} kg m^2; it must be {LEAST} at least", body=name
        )
    if greatest > (least + middle) * (1.0 + TRIANGLE_TOLERANCE):
        raise ArgumentError(
            f"{name!r} has the principal moments {least:.6g}, {middle:.6g} and {greatest:.6g} kg m^2; no body has one "
            "above the sum of the others",
            body=name,
        )


def check_state(model: PhysicsModel | None, q: Floats, v: Floats) -> None:
    """Raise ArgumentError unless q and v are a state of the model, and where there is none yet."""
    if model is None:
        raise ArgumentError("nothing is loaded yet; load comes before set_state")
    count = sizes(model.bodies)
    for name, values, size in (("q", q, count[0]), ("v", v, count[1])):
        if np.shape(values) != (size,):
            raise ArgumentError(f"{name} has shape {np.shape(values)}; it must be ({size},)")
        if not np.isfinite(values).all():
            raise ArgumentError(f"{name} is {np.asarray(values).tolist()}; it must be finite")
    for row, start in enumerate(places(model.bodies)[0]):
        if model.bodies[row].joint is BodyJoint.FREE and start >= 0:
            _check_quaternion(model.bodies[row].name, q[start + 3 : start + 7])


def check_step(
    model: PhysicsModel | None, driven: Driven, motors: Motors, wrenches: Floats | None, substeps: int
) -> PhysicsModel:
    """Return the model; raise ArgumentError where there is none yet, or where one of the others makes no sense."""
    if model is None:
        raise ArgumentError("nothing is loaded yet; load comes before step")
    if substeps < 1:
        raise ArgumentError(f"{substeps} substeps; there must be one at least")
    moved, count = _moved_from_outside(model)
    _check_values("poses of driven bodies", driven.poses, (len(moved), 7))
    _check_values("twists of driven bodies", driven.twists, (len(moved), 6))
    if moved:
        lengths = np.linalg.norm(driven.poses[:, 3:], axis=1)
        at = int(np.abs(lengths - 1.0).argmax())
        _check_quaternion(moved[at], driven.poses[at, 3:])
    modes = np.asarray(motors.mode)
    if modes.shape != (count,) or (count and not _are_modes(modes)):
        raise ArgumentError(f"modes of motors are {modes.tolist()}; they must be {count} of MotorMode")
    _check_values("targets of motors", motors.target, (count,))
    for name in ("stiffness", "damping", "max_effort"):
        values = np.asarray(getattr(motors, name))
        has_end = name == "max_effort" or is_finite(values)
        if values.shape != (count,) or not has_end or (count and not values.min() >= 0.0):
            raise ArgumentError(f"{name} of motors is {values.tolist()}; it must be {count} numbers, 0 or more")
    if wrenches is not None:
        _check_values("wrenches", wrenches, (len(model.bodies), 6))
    return model


def _are_modes(values: Integers) -> bool:
    return values.dtype.kind in "iu" and values.min() >= _MODES[0] and values.max() <= _MODES[-1]


@lru_cache(maxsize=4)
def _moved_from_outside(model: PhysicsModel) -> tuple[tuple[str, ...], int]:
    """Return the names of the driven bodies of a model, and how many joints have motors."""
    return tuple(body.name for body in model.bodies if body.driven), len(jointed(model.bodies))


def _check_place(bodies: Sequence[Body], row: int) -> None:
    body = bodies[row]
    if not WORLD <= body.parent < row:
        raise _wrong(body, f"hangs on row {body.parent}; parents come first")
    if body.joint is BodyJoint.FREE and body.parent != WORLD:
        raise _wrong(body, f"is free and hangs on {bodies[body.parent].name!r}; it must hang on the world")
    if body.driven and body.joint is not BodyJoint.FREE:
        raise _wrong(body, f"is driven and {body.joint.value}; what is driven must be free")
    if body.joint in (BodyJoint.REVOLUTE, BodyJoint.PRISMATIC):
        at = body.parent
        while at != WORLD:
            if bodies[at].driven:
                raise _wrong(body, f"hangs by a joint on {bodies[at].name!r}, which is driven; that cannot be")
            at = bodies[at].parent
        if abs(np.linalg.norm(body.axis) - 1.0) > UNIT_TOLERANCE:
            raise _wrong(body, f"has the axis {body.axis}; it must have length 1")
    pose = np.asarray(body.parent_t_body, float)
    if (
        pose.shape != (4, 4)
        or not np.isfinite(pose).all()
        or np.abs(pose[:3, :3].T @ pose[:3, :3] - np.eye(3)).max() > 1e-6
    ):
        raise _wrong(body, f"has the pose {pose.tolist()} in its parent; it must be rigid")


def _check_couplings(model: PhysicsModel) -> None:
    """Raise ArgumentError for a joint that cannot follow another one as it says, by the body's name."""
    bodies, single, followers = model.bodies, set(jointed(model.bodies)), set[int]()
    leaders, root_of = {one.leader for one in model.couplings}, roots(replace(model, couplings=()))
    for one in model.couplings:
        for row in (one.follower, one.leader):
            if row not in single:
                what = repr(bodies[row].name) if 0 <= row < len(bodies) else f"row {row}"
                raise ArgumentError(f"{what} is coupled; only what a joint turns or slides can be")
        body = bodies[one.follower]
        if one.follower in followers or one.follower in leaders:
            raise _wrong(body, "follows one joint and has another coupling; it must follow one, and lead none")
        if not (math.isfinite(one.ratio) and one.ratio and math.isfinite(one.offset)):
            said = f"follows {bodies[one.leader].name!r} by the ratio {one.ratio} and the offset {one.offset}"
            raise _wrong(body, f"{said}; both must be finite, and the ratio not 0")
        begins = root_of[one.follower], root_of[one.leader]
        if begins[0] != begins[1] and any(bodies[row].joint is BodyJoint.FREE for row in begins):
            raise _wrong(body, f"follows {bodies[one.leader].name!r}; they must hang on one body that moves freely")
        followers.add(one.follower)


def _moves(bodies: Sequence[Body], row: int) -> bool:
    """Return whether a joint moves a body, or it is driven."""
    while row != WORLD:
        if bodies[row].joint is not BodyJoint.FIXED:
            return True
        row = bodies[row].parent
    return False


def _check_shape(body: Body, shape: BodyShape) -> None:
    needed = _SIZES[shape.kind]
    if len(shape.size) != needed or not all(0.0 < value < math.inf for value in shape.size):
        raise _wrong(body, f"has a {shape.kind.value} of size {shape.size}; it needs {needed} lengths above 0")
    if shape.kind is ShapeKind.HEIGHTS:
        heights = np.asarray(shape.heights if shape.heights is not None else (), float)
        if heights.ndim != 2 or min(heights.shape) < 2 or not np.isfinite(heights).all():
            raise _wrong(body, f"has heights of shape {heights.shape}; two rows and columns at least, all finite")
    if shape.kind is not ShapeKind.HULL:
        return
    vertices = np.asarray(shape.vertices if shape.vertices is not None else (), float)
    if vertices.ndim != 2 or vertices.shape[1:] != (3,) or not np.isfinite(vertices).all() or len(vertices) < 4:
        raise _wrong(
            body, f"has a hull of {len(vertices)} vertices; it needs four at least, each of three finite numbers"
        )
    spread = np.linalg.svd(vertices - vertices.mean(axis=0), compute_uv=False)
    if spread[-1] <= 1e-9 * max(spread[0], 1e-300):
        raise _wrong(body, "has a hull without volume; its vertices must not lie in one plane")


def _check_values(what: str, values: Floats, shape: tuple[int, ...]) -> None:
    if np.shape(values) != shape:
        raise ArgumentError(f"{what} have shape {np.shape(values)}; it must be {shape}")
    if not is_finite(values):
        raise ArgumentError(f"{what} are {np.asarray(values).tolist()}; they must be finite")


def _check_quaternion(name: str, quaternion: Floats) -> None:
    if abs((length := float(np.linalg.norm(quaternion))) - 1.0) > UNIT_TOLERANCE:
        raise ArgumentError(f"the quaternion of {name!r} has length {length:g}; it must be 1", body=name)


def _wrong(body: Body, said: str) -> ArgumentError:
    return ArgumentError(f"{body.name!r} {said}", body=body.name)
