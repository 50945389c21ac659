"""Worlds with real robots for tests of collisions, and the same asked of coal, pair by pair."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from virtualrobot.files.resolver import Resolver
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import ImportedModel, import_model
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.commands import Command, CreateNodes
from virtualrobot_kernel.world.figures import Geometry, Mesh
from virtualrobot_kernel.world.state import Snapshot, State
from virtualrobot_kernel.world.structure import NodeSpec, Structure

from tests.pybullet_models import pybullet_data
from tests.unit.collision.solids import coal, in_coal, model_in_coal
from tests.unit.world.builders import empty

DATA = Path(pybullet_data.getDataPath())
ROBOTS = {
    "iiwa": str(DATA / "kuka_iiwa/model.urdf"),
    "panda": str(DATA / "franka_panda/panda.urdf"),
    "xarm": str(DATA / "xarm/xarm6_with_gripper.urdf"),
}

STORE = AssetStore()
LIBRARY = MeshLibrary(STORE)
SHAPES = CollisionShapes(LIBRARY.load)


@lru_cache
def robot_nodes(uri: str, name: str) -> tuple[NodeSpec, ...]:
    """Return the nodes of a robot from its file."""
    model = import_model(uri, Files(STORE, {}, Resolver()), LIBRARY, name=name)
    assert isinstance(model, ImportedModel)
    return model.nodes


def pictured(structure: Structure, state: State) -> Snapshot:
    """Return the snapshot of a world."""
    return Snapshot(structure, state, world_poses(structure, state), 0, 0.0, 0.004)


def world(*commands: Command) -> Snapshot:
    """Return the world after commands."""
    before = empty()
    change = apply(before.structure, before.state, commands, world_poses)
    return pictured(change.structure, change.state)


def after(snapshot: Snapshot, *commands: Command) -> Snapshot:
    """Return a world after more commands."""
    change = apply(snapshot.structure, snapshot.state, commands, world_poses)
    return pictured(change.structure, change.state)


def with_robots(*kinds: str) -> Snapshot:
    """Return a world with a robot of each kind; its name is its kind."""
    return world(*(CreateNodes(robot_nodes(ROBOTS[kind], kind)) for kind in kinds))


def somewhere(snapshot: Snapshot, rng: np.random.Generator) -> Snapshot:
    """Return a world with all robots' joints at random places within their limits."""
    q = snapshot.state.q.copy()
    for index in snapshot.structure.robots.values():
        for joint, start in zip(index.joints, index.q_start, strict=True):
            q[start] = rng.uniform(max(joint.limits.lower, -np.pi), min(joint.limits.upper, np.pi))
    return pictured(snapshot.structure, replace(snapshot.state, q=q))


def scene_of(snapshot: Snapshot) -> CollisionScene:
    """Return a new scene of a world."""
    scene = CollisionScene(SHAPES)
    scene.place(snapshot)
    return scene


@lru_cache
def geometry_in_coal(geometry: Geometry) -> Any:  # noqa: ANN401 coal has no types
    """Return a figure as coal has it; a mesh as one."""
    if not isinstance(geometry, Mesh):
        return in_coal(geometry)
    parts = LIBRARY.load(geometry)
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])[:-1]
    faces = [part.faces + start for part, start in zip(parts, starts, strict=True)]
    return model_in_coal(np.concatenate([part.vertices for part in parts]), np.concatenate(faces))


def coal_distances(scene: CollisionScene, pairs: Sequence[tuple[int, int]]) -> list[float]:
    """Return the distance of each two nodes (uids) by coal: the least of their figures; at most 0 where they touch."""
    bodies, poses = scene.bodies, scene.world_t_element
    request = coal.DistanceRequest()
    request.gjk_tolerance, request.gjk_max_iterations = 1e-9, 1000
    found = []
    for pair in pairs:
        least = np.inf
        for one in bodies.elements[pair[0]]:
            for other in bodies.elements[pair[1]]:
                shapes = [geometry_in_coal(bodies.figures[each].geometry) for each in (one, other)]
                at = [coal.Transform3s(poses[each, :3, :3], poses[each, :3, 3]) for each in (one, other)]
                result = coal.DistanceResult()
                least = min(least, coal.distance(shapes[0], at[0], shapes[1], at[1], request, result))
        found.append(least)
    return found


def coal_touches(scene: CollisionScene, pairs: Sequence[tuple[int, int]]) -> set[tuple[int, int]]:
    """Return which pairs of nodes (uids) touch by coal."""
    bodies, poses = scene.bodies, scene.world_t_element
    at = [coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in poses]
    request = coal.CollisionRequest()
    # By itself coal takes what is nearer than 1e-6 m for touching.
    request.gjk_tolerance, request.gjk_max_iterations = 1e-9, 1000
    found = set()
    for pair in pairs:
        for one in bodies.elements[pair[0]]:
            for other in bodies.elements[pair[1]]:
                shapes = [geometry_in_coal(bodies.figures[each].geometry) for each in (one, other)]
                if coal.collide(shapes[0], at[one], shapes[1], at[other], request, coal.CollisionResult()):
                    found.add(pair)
    return found


def asked(scene: CollisionScene) -> list[tuple[int, int]]:
    """Return the pairs of nodes (uids, the smaller first) that may not touch and of which one is a robot's."""
    bodies = scene.bodies
    uids = sorted(bodies.elements)
    groups = bodies.allowed.groups
    return [
        (one, other)
        for place, one in enumerate(uids)
        for other in uids[place + 1 :]
        if (groups[one] or groups[other]) and bodies.allowed.why(one, other) is None
    ]
