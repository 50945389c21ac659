"""Bodies as those of PyBullet: each tree is one of its multibodies, whose links come depth first."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats, Integers
from virtualrobot_sdk.physics import WORLD, Body, BodyJoint, BodyShape, Coupling, PhysicsModel, ShapeKind, roots
from virtualrobot_sdk.poses import quaternion

from virtualrobot_plugins.physics.principal import Quaternion, principal

BOUNCES_FROM = 0.02
"""Least speed of an impact that sends something back (m/s)."""
TOUCHES_FROM = 1e-4
"""Distance from which on two bodies touch (m): from farther away, Bullet would slow what is about to bounce."""
PUSHED_OUT = 0.02
"""Part of what something that bounces has gone into something else that goes within a substep, a quarter of it where
both bounce. What hits is as deep as it goes in a substep: its rebound is too fast by up to that part of the impact.
Bullet's own 0.08, without which high stacks lean, is what others have."""
RIGID = 1e12
"""Damping (N s/m) beside which a contact gives way to nothing: Bullet has PUSHED_OUT of one contact as a spring's."""
KEPT = 0.99
"""Part of a restitution that Bullet is told: the rest is what a rebound gains by PUSHED_OUT, and by the gravity of the
substep that it begins in, which Bullet leaves out. So nothing comes back higher than it fell, from 0.1 m on."""
HULL_MARGIN = 1e-4
"""Shell (m) around a hull that is a body's only shape; Bullet's own, which hulls of several have, is 1 mm thick."""
MOST_HEIGHTS = 100_000
"""Greatest number of heights of a field: Bullet takes 131,072 corners, and six numbers of corners for each."""
GEAR_RATE = 0.2
"""Part by which a gear comes right within a substep, where its joints are not as it says."""
STRONGEST = 1e9
"""Largest effort of a motor or a gear without a limit (N m, N); Bullet takes no infinity."""
FASTEST = 1000.0
"""Largest velocity of a joint (rad/s, m/s); Bullet's own choice would be 100."""


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """One of Bullet's bodies: the rows of ours, the base first, WORLD for a base that is none of ours."""

    body: int
    rows: tuple[int, ...]
    center: Floats
    """(3,) center of mass of the base in its frame (m)."""
    axes: Quaternion
    """Rotation of the base's inertial frame in its own."""

    @property
    def inverse_axes(self) -> Quaternion:
        """Return the inverse of that rotation."""
        x, y, z, w = self.axes
        return -x, -y, -z, w


def build(bullet: Any, client: int, model: PhysicsModel, iterations: int) -> list[Tree]:  # noqa: ANN401
    """Return the trees of a model, made in a client that has nothing else."""
    bullet.resetSimulation(physicsClientId=client)
    bullet.setGravity(*model.gravity, physicsClientId=client)
    bullet.setTimeStep(model.seconds, physicsClientId=client)
    bullet.setPhysicsEngineParameter(
        numSolverIterations=iterations,
        deterministicOverlappingPairs=1,
        enableConeFriction=1,
        restitutionVelocityThreshold=BOUNCES_FROM,
        contactBreakingThreshold=TOUCHES_FROM,
        physicsClientId=client,
    )
    children: dict[int, list[int]] = {}
    for row, body in enumerate(model.bodies):
        children.setdefault(body.parent, []).append(row)
    # Bullet couples joints of one of its bodies alone, to which what is coupled hangs on the world together.
    together: dict[int, list[int]] = {}
    root_of = roots(model)
    for row in children.get(WORLD, ()):
        together.setdefault(root_of[row], []).extend(_depth_first(row, children))
    trees = []
    for rows in together.values():
        # What hangs on the world by a joint needs a base that stands there.
        hangs = model.bodies[rows[0]].joint in (BodyJoint.REVOLUTE, BodyJoint.PRISMATIC)
        trees.append(_made(bullet, client, model, (WORLD, *rows) if hangs else tuple(rows)))
    for coupling in model.couplings:
        _couple(bullet, client, coupling, *(_place_of(trees, row) for row in (coupling.follower, coupling.leader)))
    return trees


def _place_of(trees: list[Tree], row: int) -> tuple[int, int]:
    """Return Bullet's body and link of a row."""
    return next((tree.body, tree.rows.index(row) - 1) for tree in trees if row in tree.rows)


def _couple(
    bullet: Any,  # noqa: ANN401
    client: int,
    coupling: Coupling,
    follower: tuple[int, int],
    leader: tuple[int, int],
) -> None:
    """Make a gear, which keeps q of the follower and its own ratio times q of the leader at one sum."""
    frames = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    gear = bullet.createConstraint(*follower, *leader, bullet.JOINT_GEAR, *frames, physicsClientId=client)
    bullet.changeConstraint(
        gear,
        gearRatio=-coupling.ratio,
        relativePositionTarget=coupling.offset,
        erp=GEAR_RATE,
        maxForce=STRONGEST,
        physicsClientId=client,
    )


def _depth_first(row: int, children: dict[int, list[int]]) -> Iterator[int]:
    yield row
    for child in children.get(row, ()):
        yield from _depth_first(child, children)


def _made(bullet: Any, client: int, model: PhysicsModel, rows: tuple[int, ...]) -> Tree:  # noqa: ANN401
    bodies = [model.bodies[row] if row != WORLD else _NOTHING for row in rows]
    base, links = bodies[0], bodies[1:]
    kinds = {
        BodyJoint.REVOLUTE: bullet.JOINT_REVOLUTE,
        BodyJoint.PRISMATIC: bullet.JOINT_PRISMATIC,
        BodyJoint.FIXED: bullet.JOINT_FIXED,
    }
    moves = base.joint is BodyJoint.FREE and not base.driven
    axes, _ = principal(base) if moves else (_UNTURNED, None)
    center = np.array(base.center_of_mass if moves else (0.0, 0.0, 0.0), float)
    of_links: dict[str, Any] = {}
    if links:
        of_links = {
            "linkMasses": [link.mass for link in links],
            "linkCollisionShapeIndices": [_shapes(bullet, client, link) for link in links],
            "linkVisualShapeIndices": [-1] * len(links),
            "linkPositions": [link.parent_t_body[:3, 3].tolist() for link in links],
            "linkOrientations": [quaternion(link.parent_t_body[:3, :3]) for link in links],
            "linkInertialFramePositions": [link.center_of_mass for link in links],
            "linkInertialFrameOrientations": [principal(link)[0] for link in links],
            "linkParentIndices": [rows.index(link.parent) for link in links],
            "linkJointTypes": [kinds[link.joint] for link in links],
            "linkJointAxis": [link.axis for link in links],
        }
    body = bullet.createMultiBody(
        baseMass=base.mass if moves else 0.0,
        baseCollisionShapeIndex=_shapes(bullet, client, base),
        baseInertialFramePosition=center.tolist(),
        baseInertialFrameOrientation=axes,
        physicsClientId=client,
        **of_links,
    )
    if body < 0:
        raise RuntimeError(f"Bullet does not take {base.name!r} and what hangs on it")
    if base.joint is not BodyJoint.FREE:
        position, turn = base.parent_t_body[:3, 3].tolist(), quaternion(base.parent_t_body[:3, :3])
        bullet.resetBasePositionAndOrientation(body, position, turn, physicsClientId=client)
    for index, one in enumerate(bodies, start=-1):
        _set_dynamics(bullet, client, body, index, one, has_inertia=index >= 0 or moves)
        if one.surface.restitution and not any(other.surface.stiffness for other in model.bodies):
            # Springs in a row add their damping: a soft one would be none beside this.
            stiffness = RIGID * PUSHED_OUT / ((1.0 - PUSHED_OUT) * model.seconds)
            bullet.changeDynamics(body, index, contactStiffness=stiffness, contactDamping=RIGID, physicsClientId=client)
    return Tree(body, rows, center, axes)


def _set_dynamics(bullet: Any, client: int, body: int, link: int, one: Body, *, has_inertia: bool) -> None:  # noqa: ANN401
    """Say what Bullet would choose itself: damping, friction, inertia, limits.

    A call for inertia that says anything else besides would overwrite the inertia of the base.
    """
    surface = one.surface
    friction = math.sqrt(surface.friction)
    bullet.changeDynamics(
        body,
        link,
        # Two that touch are multiplied; rolling and spinning are each multiplied by the other's sliding, and added.
        lateralFriction=friction,
        rollingFriction=surface.rolling / (2.0 * friction) if friction else 0.0,
        spinningFriction=surface.spinning / (2.0 * friction) if friction else 0.0,
        restitution=math.sqrt(KEPT * surface.restitution),
        jointDamping=0.0,
        physicsClientId=client,
    )
    bullet.changeDynamics(
        body, link, linearDamping=0.0, angularDamping=0.0, maxJointVelocity=FASTEST, physicsClientId=client
    )
    if len(one.shapes) == 1 and one.shapes[0].kind in (ShapeKind.HULL, ShapeKind.HEIGHTS):
        bullet.changeDynamics(body, link, collisionMargin=HULL_MARGIN, physicsClientId=client)
    if surface.stiffness:
        bullet.changeDynamics(
            body,
            link,
            contactStiffness=surface.stiffness,
            contactDamping=surface.damping,
            physicsClientId=client,
        )
    if has_inertia and one.mass:
        bullet.changeDynamics(body, link, localInertiaDiagonal=principal(one)[1], physicsClientId=client)
    if one.joint in (BodyJoint.REVOLUTE, BodyJoint.PRISMATIC):
        if math.isfinite(one.lower) or math.isfinite(one.upper):
            lower, upper = max(one.lower, -_FAR), min(one.upper, _FAR)
            bullet.changeDynamics(body, link, jointLowerLimit=lower, jointUpperLimit=upper, physicsClientId=client)


def _shapes(bullet: Any, client: int, body: Body) -> int:  # noqa: ANN401
    """Return a new collision shape of all of a body's, or -1."""
    if not body.shapes:
        return -1
    kinds = {
        ShapeKind.BOX: bullet.GEOM_BOX,
        ShapeKind.SPHERE: bullet.GEOM_SPHERE,
        ShapeKind.CYLINDER: bullet.GEOM_CYLINDER,
        ShapeKind.CAPSULE: bullet.GEOM_CAPSULE,
        ShapeKind.HULL: bullet.GEOM_MESH,
        ShapeKind.HEIGHTS: bullet.GEOM_MESH,
    }
    if len(body.shapes) == 1:
        (shape,) = body.shapes
        sizes: dict[str, Any] = {"halfExtents": shape.size} if shape.kind is ShapeKind.BOX else {}
        if shape.kind is ShapeKind.HULL:
            sizes = {"vertices": np.asarray(shape.vertices).tolist()}
        elif shape.kind is ShapeKind.HEIGHTS:
            corners, triangles = _triangles(body, shape)
            sizes = {"vertices": corners.tolist(), "indices": triangles.ravel().tolist()}
            sizes["flags"] = bullet.GEOM_FORCE_CONCAVE_TRIMESH
        elif shape.kind is not ShapeKind.BOX:
            sizes = {"radius": shape.size[0], "height": _length(shape)}
        return bullet.createCollisionShape(
            kinds[shape.kind],
            collisionFramePosition=shape.body_t_shape[:3, 3].tolist(),
            collisionFrameOrientation=quaternion(shape.body_t_shape[:3, :3]),
            physicsClientId=client,
            **sizes,
        )
    with TemporaryDirectory() as folder:
        # Of several shapes, hulls are read from files alone.
        files = [_written(Path(folder) / f"{at}.obj", shape) for at, shape in enumerate(body.shapes)]
        return bullet.createCollisionShapeArray(
            shapeTypes=[kinds[shape.kind] for shape in body.shapes],
            radii=[shape.size[0] if shape.size else 1.0 for shape in body.shapes],
            halfExtents=[shape.size if len(shape.size) == 3 else (1.0, 1.0, 1.0) for shape in body.shapes],
            lengths=[_length(shape) for shape in body.shapes],
            fileNames=files,
            meshScales=[(1.0, 1.0, 1.0)] * len(files),
            collisionFramePositions=[shape.body_t_shape[:3, 3].tolist() for shape in body.shapes],
            collisionFrameOrientations=[quaternion(shape.body_t_shape[:3, :3]) for shape in body.shapes],
            physicsClientId=client,
        )


def _triangles(body: Body, shape: BodyShape) -> tuple[Floats, Integers]:
    """Return corners (n, 3) and triangles (m, 3) of a height field; raise ArgumentError for one that is too large."""
    heights = np.asarray(shape.heights, float)
    rows, columns = heights.shape
    if heights.size > MOST_HEIGHTS:
        raise ArgumentError(
            f"{body.name!r} has {heights.size} heights; Bullet takes {MOST_HEIGHTS} at most", body=body.name
        )
    x, y = (shape.size[axis] * (np.arange(n) - 0.5 * (n - 1)) for axis, n in enumerate((columns, rows)))
    corners = np.stack([*np.meshgrid(x, y), heights], axis=-1).reshape(-1, 3)
    first = (columns * np.arange(rows - 1)[:, None] + np.arange(columns - 1)).ravel()
    lower = np.stack([first, first + 1, first + columns + 1], axis=-1)
    upper = np.stack([first, first + columns + 1, first + columns], axis=-1)
    return corners, np.concatenate([lower, upper]).astype(np.int32)


def _written(file: Path, shape: BodyShape) -> str:
    """Return the path of a file that has the hull of a shape; an empty one for other shapes."""
    if shape.vertices is None:
        return ""
    vertices = np.asarray(shape.vertices, float)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    # Bullet takes vertices of faces alone, and makes their hull.
    lines += [f"f {at} {at + 1} {at + 2}" for at in range(1, len(vertices) - 1)]
    file.write_text("\n".join(lines) + "\n")
    return str(file)


def _length(shape: BodyShape) -> float:
    return 2.0 * shape.size[1] if len(shape.size) == 2 else 1.0


_NOTHING = Body("")
_UNTURNED: Quaternion = (0.0, 0.0, 0.0, 1.0)
_FAR = 1e10
"""A limit that Bullet takes for none."""
