"""The same scene for others: bare python-fcl and coal with managers and a pair list, MuJoCo, PyBullet."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import fcl
import numpy as np
import trimesh
from numpy.typing import NDArray

from benchmarks.collision_cell import CollisionCell

Checks = Callable[[int], bool]
"""Puts the elements where they are in a configuration, by its place, and returns whether anything touches."""


def bare_fcl(cell: CollisionCell) -> Checks:
    """Return the check of python-fcl: a manager for each arm and one for the rest, default callbacks, a pair list."""
    models: dict[int, Any] = {}
    for vertices, faces in cell.triangles:
        if id(faces) not in models:
            model = models[id(faces)] = fcl.BVHModel()
            model.beginModel(len(vertices), len(faces))
            model.addSubModel(vertices, faces)
            model.endModel()
    objects = [fcl.CollisionObject(models[id(faces)], fcl.Transform()) for _, faces in cell.triangles]
    for at, pose in zip(objects, cell.poses[0], strict=True):
        at.setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
    managers = []
    for group in dict.fromkeys(cell.groups.tolist()):
        manager = fcl.DynamicAABBTreeCollisionManager()
        manager.registerObjects([objects[e] for e in np.flatnonzero(cell.groups == group)])
        manager.setup()
        managers.append((group, manager))
    arms = [manager for group, manager in managers if group]
    rest = [manager for group, manager in managers if not group]
    against = [(one, other) for place, one in enumerate(arms) for other in (*arms[place + 1 :], *rest)]
    moving = np.flatnonzero(cell.groups).tolist()

    def check(place: int) -> bool:
        poses = cell.poses[place]
        for element in moving:
            pose = poses[element]
            objects[element].setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
        for arm in arms:
            arm.update()
        request = fcl.CollisionRequest()
        for one, other in against:
            data = fcl.CollisionData()
            one.collide(other, data, fcl.defaultCollisionCallback)
            if data.result.is_collision:
                return True
        return any(fcl.collide(objects[a], objects[b], request, fcl.CollisionResult()) > 0 for a, b in cell.pairs)

    return check


def in_coal(cell: CollisionCell) -> Checks:
    """Return the check of coal, in the same way."""
    coal: Any = import_module("coal")
    models: dict[int, Any] = {}
    for vertices, faces in cell.triangles:
        if id(faces) not in models:
            model = models[id(faces)] = coal.BVHModelOBBRSS()
            corners, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
            for vertex in vertices:
                corners.append(vertex)
            for face in faces.tolist():
                triangles.append(coal.Triangle(*face))
            model.beginModel(len(faces), len(vertices))
            model.addSubModel(corners, triangles)
            model.endModel()
    poses = cell.poses[0]
    objects = [
        coal.CollisionObject(models[id(faces)], coal.Transform3s(pose[:3, :3], pose[:3, 3]))
        for (_, faces), pose in zip(cell.triangles, poses, strict=True)
    ]
    managers = []
    for group in dict.fromkeys(cell.groups.tolist()):
        manager = coal.DynamicAABBTreeCollisionManager()
        for element in np.flatnonzero(cell.groups == group):
            manager.registerObject(objects[element])
        manager.setup()
        managers.append((group, manager))
    arms = [manager for group, manager in managers if group]
    rest = [manager for group, manager in managers if not group]
    against = [(one, other) for place, one in enumerate(arms) for other in (*arms[place + 1 :], *rest)]
    moving = np.flatnonzero(cell.groups).tolist()
    callback, request = coal.CollisionCallBackDefault(), coal.CollisionRequest()

    def check(place: int) -> bool:
        poses = cell.poses[place]
        for element in moving:
            pose = poses[element]
            objects[element].setTransform(coal.Transform3s(pose[:3, :3], pose[:3, 3]))
            objects[element].computeAABB()
        for arm in arms:
            arm.update()
        for one, other in against:
            callback.init()
            one.collide(other, callback)
            if callback.data.result.isCollision():
                return True
        return any(coal.collide(objects[a], objects[b], request, coal.CollisionResult()) for a, b in cell.pairs)

    return check


def in_pybullet(cell: CollisionCell) -> Checks:
    """Return the check of PyBullet: all elements are bodies, meshes their hulls; an arm's allowed pairs are masked."""
    import pybullet

    client = pybullet.connect(pybullet.DIRECT)
    shapes: dict[int, int] = {}
    bodies = []
    with tempfile.TemporaryDirectory() as folder:
        for (vertices, faces), pose in zip(cell.triangles, cell.poses[0], strict=True):
            if id(faces) not in shapes:
                file = Path(folder) / f"{len(shapes)}.obj"
                trimesh.Trimesh(vertices, faces, process=False).export(file)
                shapes[id(faces)] = pybullet.createCollisionShape(
                    pybullet.GEOM_MESH, fileName=str(file), physicsClientId=client
                )
            bodies.append(pybullet.createMultiBody(1.0, shapes[id(faces)], physicsClientId=client))
            _put(pybullet, client, bodies[-1], pose)
    asked = set(cell.pairs)
    for one in np.flatnonzero(cell.groups).tolist():
        for other in np.flatnonzero(cell.groups == cell.groups[one]).tolist():
            if one < other and (one, other) not in asked:
                pybullet.setCollisionFilterPair(bodies[one], bodies[other], -1, -1, 0, physicsClientId=client)
    rest = np.flatnonzero(cell.groups == 0).tolist()
    for body in (bodies[element] for element in rest):
        pybullet.setCollisionFilterGroupMask(body, -1, 2, 1, physicsClientId=client)
    moving = np.flatnonzero(cell.groups).tolist()
    for element in moving:
        pybullet.setCollisionFilterGroupMask(bodies[element], -1, 1, 3, physicsClientId=client)

    def check(place: int) -> bool:
        for element in moving:
            _put(pybullet, client, bodies[element], cell.poses[place][element])
        pybullet.performCollisionDetection(physicsClientId=client)
        points = pybullet.getContactPoints(physicsClientId=client)
        return any(point[8] < 0.0 for point in points or ())

    return check


def _put(pybullet: Any, client: int, body: int, pose: NDArray[np.float64]) -> None:  # noqa: ANN401 a module
    turn = trimesh.transformations.quaternion_from_matrix(pose)
    xyzw = [*turn[1:], turn[0]]
    pybullet.resetBasePositionAndOrientation(body, pose[:3, 3].tolist(), xyzw, physicsClientId=client)


def in_mujoco(cell: CollisionCell) -> Checks:
    """Return the check of MuJoCo: every element floats, its mesh a hull; allowed pairs are excluded."""
    mujoco: Any = import_module("mujoco")
    spec = mujoco.MjSpec()
    names: dict[int, str] = {}
    for element, ((vertices, faces), group) in enumerate(zip(cell.triangles, cell.groups.tolist(), strict=True)):
        if id(faces) not in names:
            names[id(faces)] = f"mesh{len(names)}"
            spec.add_mesh(
                name=names[id(faces)],
                uservert=vertices.ravel().tolist(),
                userface=faces.ravel().tolist(),
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
            )
        body = spec.worldbody.add_body(name=f"body{element}")
        body.add_freejoint()
        kind = 1 if group else 2
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH, meshname=names[id(faces)], contype=kind, conaffinity=3 if group else 1
        )
    asked = set(cell.pairs)
    for one in np.flatnonzero(cell.groups).tolist():
        for other in np.flatnonzero(cell.groups == cell.groups[one]).tolist():
            if one < other and (one, other) not in asked:
                spec.add_exclude(bodyname1=f"body{one}", bodyname2=f"body{other}")
    model = spec.compile()
    data = mujoco.MjData(model)
    quaternions = np.array(
        [[trimesh.transformations.quaternion_from_matrix(pose) for pose in poses] for poses in cell.poses]
    )
    moving = np.flatnonzero(cell.groups)
    q = data.qpos.reshape(-1, 7)
    q[:, :3], q[:, 3:] = cell.poses[0][:, :3, 3], quaternions[0]

    def check(place: int) -> bool:
        q[moving, :3], q[moving, 3:] = cell.poses[place][moving, :3, 3], quaternions[place][moving]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        return data.ncon > 0

    return check
