"""The scenes that collision checks are compared on: arms among meshes, at random configurations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot.files.resolver import Resolver
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import ImportedModel, import_model
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import Command, CreateNodes, UpdateNode
from virtualrobot_kernel.world.figures import Figure, Mesh
from virtualrobot_kernel.world.state import Snapshot, empty_state
from virtualrobot_kernel.world.structure import Kind, NodeSpec, PartData

from benchmarks.ray_cell import DATA, MESHES, unit_mesh

Floats = NDArray[np.float64]

IIWA = str(DATA / "kuka_iiwa/model.urdf")
SIZE = (0.1, 0.25)
"""The greatest extents of the meshes, in meters."""
REACH = 1.3
APART = 2.0
"""How far arms are from each other, in meters."""


@dataclass(frozen=True, slots=True, eq=False)
class CollisionCell:
    """A scene of ours, what it may be asked at, and the same as arrays for others.

    Attributes:
        shapes: the geometry of the scene.
        scene: ours.
        snapshots: worlds with the arms at random configurations.
        poses: (n, e, 4, 4) where the elements are in each of them.
        triangles: (e) vertices and faces of each element; equal ones are one object.
        groups: (e,) the arm (a uid) of each element; 0 for the meshes around.
        pairs: elements of one arm that are asked against each other.
    """

    shapes: CollisionShapes
    scene: CollisionScene
    snapshots: tuple[Snapshot, ...]
    poses: Floats
    triangles: tuple[tuple[Floats, NDArray[np.int32]], ...]
    groups: NDArray[np.int64]
    pairs: tuple[tuple[int, int], ...]


def collision_cell(arms: int, meshes: int, configurations: int, seed: int = 1) -> CollisionCell:
    """Return arms in a row with meshes around them, none of which touches an arm's first two links or hangs in one."""
    rng = np.random.default_rng(seed)
    store = AssetStore()
    library = MeshLibrary(store)
    around = {f"{name} {row}": _scaled(name, rng.uniform(*SIZE)) for row, name in enumerate(MESHES * 8)}

    def load(mesh: Mesh) -> tuple[Submesh, ...]:
        return (Submesh(*around[mesh.uri]),) if mesh.uri in around else library.load(mesh)

    commands: list[Command] = []
    for arm in range(arms):
        model = import_model(IIWA, Files(store, {}, Resolver()), library, name=f"arm{arm}")
        assert isinstance(model, ImportedModel)
        at = np.eye(4)
        at[0, 3] = APART * arm
        commands += [CreateNodes(model.nodes), UpdateNode(f"arm{arm}", parent_t_node=at)]
    commands.append(CreateNodes(tuple(_part(row, arms, around, rng) for row in range(meshes))))
    change = apply(index.empty(), empty_state(), commands, world_poses)
    snapshots = tuple(_somewhere(change, rng) for _ in range(configurations))
    shapes = CollisionShapes(load)
    scene = CollisionScene(shapes)
    poses = []
    for snapshot in snapshots:
        scene.place(snapshot)
        poses.append(scene.world_t_element.copy())
    bodies = scene.bodies
    known: dict[Mesh, tuple[Floats, NDArray[np.int32]]] = {}
    for figure in bodies.figures:
        assert isinstance(figure.geometry, Mesh)
        if figure.geometry not in known:
            known[figure.geometry] = _joined(load(figure.geometry))
    geometries = (figure.geometry for figure in bodies.figures)
    groups = np.array([bodies.allowed.groups[uid] for uid in bodies.uids.tolist()])
    pairs = [
        (int(own[row]), int(other))
        for robot, own, asked in bodies.groups
        for row, other in np.argwhere(asked & (groups == robot)).tolist()
    ]
    return CollisionCell(
        shapes,
        scene,
        snapshots,
        np.array(poses),
        tuple(known[one] for one in geometries if isinstance(one, Mesh)),
        groups,
        tuple(pairs),
    )


def _part(row: int, arms: int, around: Mapping[str, object], rng: np.random.Generator) -> NodeSpec:
    pose = np.eye(4)
    pose[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    pose[:3, :3] *= np.sign(np.linalg.det(pose[:3, :3]))
    angle, distance = rng.uniform(-np.pi, np.pi), rng.uniform(0.5, REACH)
    pose[:3, 3] = distance * np.cos(angle) + APART * rng.integers(arms), distance * np.sin(angle), rng.uniform(0.0, 1.4)
    figure = Figure(Mesh(list(around)[row % len(around)], f"{row % len(around):064x}"))
    return NodeSpec(f"part {row}", Kind.PART, parent_t_node=pose, figures=(figure,), data=PartData(1.0))


def _scaled(name: str, size: float) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    vertices, faces = unit_mesh(DATA / name)
    return np.asarray(vertices * size, np.float32), faces


def _joined(parts: tuple[Submesh, ...]) -> tuple[Floats, NDArray[np.int32]]:
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])[:-1]
    faces = [part.faces + start for part, start in zip(parts, starts, strict=True)]
    vertices = np.concatenate([part.vertices for part in parts])
    return vertices.astype(np.float64), np.concatenate(faces).astype(np.int32)


def _somewhere(change: Change, rng: np.random.Generator) -> Snapshot:
    q = change.state.q.copy()
    for robot in change.structure.robots.values():
        for joint, start in zip(robot.joints, robot.q_start, strict=True):
            q[start] = rng.uniform(joint.limits.lower, joint.limits.upper)
    state = replace(change.state, q=q)
    return Snapshot(change.structure, state, world_poses(change.structure, state), 0, 0.0, 0.004)
