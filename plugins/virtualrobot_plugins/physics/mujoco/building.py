"""Bodies as a model of MuJoCo."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Any

import numpy as np
from virtualrobot_sdk.physics import WORLD, Body, BodyJoint, BodyShape, PhysicsModel, ShapeKind, Surface, jointed, roots
from virtualrobot_sdk.poses import quaternion

from virtualrobot_plugins.physics.mujoco.restitution import damping_ratio
from virtualrobot_plugins.physics.principal import principal

DRIVEN_MASS = 1e4
"""Mass of a driven body (kg, and its moments in kg m^2): what it pushes yields to it."""
STIFF_SUBSTEPS = 8.0
"""Time constant of a contact as stiff as it may be, in substeps; what slides would hop on a stiffer one."""
STIFF_DAMPING = 2.0
"""Damping ratio of such a contact: what hits it comes back with 4% of its speed, and with 10% at a ratio of 1."""
STIFF_IMPEDANCE = (0.95, 0.99, 0.001, 0.5, 2.0)
"""Impedance of such a contact, as below."""
LEAST_SUBSTEPS = 2.0
"""The least one that MuJoCo takes."""
BOUNCE_SUBSTEPS = 20.0
"""Duration of an elastic impact, in substeps: fewer don't resolve its spring."""
LEAST_DAMPING = 1e-4
"""Least damping ratio of what bounces: MuJoCo's stiffness is the inverse of its square, times that of a time."""
BOUNCE_IMPEDANCE = (0.99, 0.99, 0.001, 0.5, 2.0)
"""Impedance (d0, dmax, width, midpoint, power) of contacts that bounce: constant, so that restitution is as said."""
LEAST_HEIGHT = 1e-3
"""Height of a level field (m), which it never takes; MuJoCo wants one above 0."""
GROUND_DEPTH = 1.0
"""Depth (m) to which a height field is solid below its lowest place."""
MOVES, STAYS = 1, 2
"""Bits of geoms: what stays does not touch what stays."""


def compiled(mujoco: Any, model: PhysicsModel, cone: str, impratio: float, iterations: int) -> Any:  # noqa: ANN401
    """Return the MjModel: a body is called as its row is in `model`, and actuators are the motors in their order.

    Raises ValueError with MuJoCo's words for what it does not take.
    """
    spec = mujoco.MjSpec()
    option = spec.option
    option.timestep, option.gravity = model.seconds, model.gravity
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC if cone == "elliptic" else mujoco.mjtCone.mjCONE_PYRAMIDAL
    option.impratio, option.iterations = impratio, iterations
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # It would begin anew, silently, with a scene that has fallen apart.
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    spec.compiler.degree = False
    spec.compiler.autolimits = False
    priorities = _priorities(model)
    root_of = roots(model)
    made: list[Any] = []
    for row, body in enumerate(model.bodies):
        at = (spec.worldbody if body.parent == WORLD else made[body.parent]).add_body(name=str(row))
        made.append(at)
        if body.joint is not BodyJoint.FREE:
            at.pos, at.quat = body.parent_t_body[:3, 3], _wxyz(body.parent_t_body)
        _hang(mujoco, at, body, row)
        stays = body.driven or not _moves(model, row)
        for shape in body.shapes:
            geom = _shaped(mujoco, spec, at, body, shape)
            geom.mass = 0.0
            geom.contype, geom.conaffinity = (STAYS, MOVES) if stays else (MOVES, MOVES | STAYS)
            geom.priority = priorities[body.surface.friction]
            mass = sum(one.mass for one, root in zip(model.bodies, root_of, strict=True) if root == root_of[row])
            _surfaced(geom, body.surface, mass, model.seconds)
    for first, second in _of_one_tree(model, root_of):
        spec.add_exclude(bodyname1=str(first), bodyname2=str(second))
    for coupling in model.couplings:
        gear = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, objtype=mujoco.mjtObj.mjOBJ_JOINT)
        gear.name1, gear.name2 = str(coupling.follower), str(coupling.leader)
        gear.data[:5] = coupling.offset, coupling.ratio, 0.0, 0.0, 0.0
        gear.solref = LEAST_SUBSTEPS * model.seconds, 1.0
    for row in jointed(model.bodies):
        motor = spec.add_actuator(name=str(row), target=str(row), trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.gaintype, motor.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
        motor.gainprm, motor.biasprm = [0.0] * 10, [0.0] * 10
    return spec.compile()


def _hang(mujoco: Any, at: Any, body: Body, row: int) -> None:  # noqa: ANN401
    """Give a body its joint and its mass."""
    if body.joint is BodyJoint.FREE:
        at.add_freejoint(name=str(row))
    elif body.joint is not BodyJoint.FIXED:
        slides = body.joint is BodyJoint.PRISMATIC
        joint = at.add_joint(name=str(row), axis=body.axis)
        joint.type = mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE
        if math.isfinite(body.lower) or math.isfinite(body.upper):
            joint.limited = True
            joint.range = max(body.lower, -_FAR), min(body.upper, _FAR)
    if body.driven:
        at.explicitinertial, at.mass, at.gravcomp = True, DRIVEN_MASS, 1.0
        at.ipos, at.inertia = (0.0, 0.0, 0.0), [DRIVEN_MASS] * 3
    elif body.mass:
        axes, moments = principal(body)
        at.explicitinertial, at.mass, at.ipos = True, body.mass, body.center_of_mass
        at.iquat, at.inertia = (axes[3], *axes[:3]), moments


def _shaped(mujoco: Any, spec: Any, at: Any, body: Body, shape: BodyShape) -> Any:  # noqa: ANN401
    """Return a new geom of this shape."""
    geom = at.add_geom(pos=shape.body_t_shape[:3, 3], quat=_wxyz(shape.body_t_shape))
    if shape.kind is ShapeKind.HEIGHTS:
        return _rolling(mujoco, spec, geom, shape)
    if shape.kind is not ShapeKind.HULL:
        geom.type = getattr(mujoco.mjtGeom, f"mjGEOM_{shape.kind.name}")
        geom.size = (*shape.size, 0.0, 0.0)[:3]
        return geom
    name = f"{body.name}/{len(spec.meshes)}"
    mesh = spec.add_mesh(name=name)
    mesh.uservert = np.asarray(shape.vertices, float).ravel()
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, name
    return geom


def _rolling(mujoco: Any, spec: Any, geom: Any, shape: BodyShape) -> Any:  # noqa: ANN401
    """Return a geom as a height field; MuJoCo has its lowest place at the geom's origin."""
    heights = np.asarray(shape.heights, float)
    rows, columns = heights.shape
    name = f"heights/{len(spec.hfields)}"
    spec.add_hfield(
        name=name,
        nrow=rows,
        ncol=columns,
        size=(
            0.5 * shape.size[0] * (columns - 1),
            0.5 * shape.size[1] * (rows - 1),
            max(float(np.ptp(heights)), LEAST_HEIGHT),
            GROUND_DEPTH,
        ),
        userdata=heights.ravel(),
    )
    geom.type, geom.hfieldname = mujoco.mjtGeom.mjGEOM_HFIELD, name
    geom.pos = shape.body_t_shape[:3, 3] + heights.min() * shape.body_t_shape[:3, 2]
    return geom


def _surfaced(geom: Any, surface: Surface, mass: float, seconds: float) -> None:  # noqa: ANN401
    """Give a geom its friction and its contacts' time constant and damping ratio."""
    geom.friction = surface.friction, surface.spinning, surface.rolling
    geom.condim = 6 if surface.rolling else 4 if surface.spinning else 3
    if not surface.friction:
        geom.condim = 1
    stiff = STIFF_SUBSTEPS * seconds, STIFF_DAMPING
    if surface.restitution:
        ratio = max(damping_ratio(surface.restitution), LEAST_DAMPING)
        geom.solref = BOUNCE_SUBSTEPS * seconds / math.pi / ratio, ratio
        geom.solimp = BOUNCE_IMPEDANCE
    elif surface.stiffness and mass:
        rate = math.sqrt(surface.stiffness / mass)
        ratio = min(max(surface.damping / (2.0 * math.sqrt(surface.stiffness * mass)), 0.01), 100.0)
        geom.solref = max(1.0 / (rate * ratio), LEAST_SUBSTEPS * seconds), ratio
    else:
        geom.solref, geom.solimp = stiff, STIFF_IMPEDANCE


def _priorities(model: PhysicsModel) -> dict[float, int]:
    """Return a geom's priority by its friction: where two differ, MuJoCo takes all from the higher one."""
    frictions = sorted({body.surface.friction for body in model.bodies}, reverse=True)
    return {friction: rank for rank, friction in enumerate(frictions)}


def _of_one_tree(model: PhysicsModel, root_of: tuple[int, ...]) -> list[tuple[int, int]]:
    """Return pairs of bodies of one tree, which don't touch."""
    trees: dict[int, list[int]] = {}
    for row, root in enumerate(root_of):
        trees.setdefault(root, []).append(row)
    return [pair for rows in trees.values() for pair in combinations(rows, 2)]


def _moves(model: PhysicsModel, row: int) -> bool:
    """True where a joint moves a body."""
    while row != WORLD:
        body = model.bodies[row]
        if body.joint is not BodyJoint.FIXED:
            return not body.driven
        row = body.parent
    return False


def _wxyz(pose: Any) -> tuple[float, float, float, float]:  # noqa: ANN401
    x, y, z, w = quaternion(np.asarray(pose)[:3, :3])
    return w, x, y, z


_FAR = 1e10
"""A limit that MuJoCo takes for none."""
