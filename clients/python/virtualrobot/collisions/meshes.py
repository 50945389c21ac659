"""Collision shapes of meshes: their triangles, or convex hulls of few corners."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from google.protobuf.field_mask_pb2 import FieldMask

from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.showing import shown
from virtualrobot.errors import UnknownNameError
from virtualrobot.v1 import collision_pb2, nodes_pb2, scene_pb2


@shown
@dataclass(frozen=True, slots=True)
class CollisionMesh:
    """Collision shape of a figure's mesh.

    Attributes:
        node: the node's name.
        figure: the figure's place among those of the node, from 0.
        uri: the mesh's file.
        mesh_triangles: number of triangles in the file.
        triangles: number of triangles that it collides with.
        hull: true where it collides as a hull, which is a solid.
        deviation: largest distance that the mesh reaches out of its hull (m); the hull counts as thicker by as much.
        convex: true where its collision shape is closed and convex: then depths are exact.
        build_time: the time that making it took (s).
        warning: the fault of the mesh, in words; empty when there is none.
    """

    node: str
    figure: int
    uri: str
    mesh_triangles: int
    triangles: int
    hull: bool
    deviation: float
    convex: bool
    build_time: float
    warning: str


def list_meshes(services: Services, nodes: Iterable[str]) -> list[CollisionMesh]:
    """Return what the meshes of nodes and of all below them collide as; no node means all."""
    request = collision_pb2.ListCollisionMeshesRequest(nodes=nodes)
    return [
        CollisionMesh(
            mesh.node,
            mesh.figure,
            mesh.uri,
            mesh.mesh_triangles,
            mesh.triangles,
            mesh.hull,
            mesh.deviation_meters,
            mesh.convex,
            mesh.seconds,
            mesh.warning,
        )
        for mesh in services.collision.ListCollisionMeshes(request, timeout=LONG_TIMEOUT_SECONDS).meshes
    ]


def use_hulls(services: Services, nodes: Iterable[str], vertices: int) -> None:
    """Have meshes of nodes and of all below them collide as hulls, or with 0 vertices as triangles, in one change."""
    mask = FieldMask(paths=["name", "parent", "figures"])
    every = services.scene.GetScene(scene_pb2.GetSceneRequest(read_mask=mask)).nodes
    commands = [_changed(node) for node in _below(every, set(nodes)) if _set_vertices(node, vertices)]
    if commands:
        services.apply(commands)


def _below(every: Iterable[nodes_pb2.Node], tops: set[str]) -> Iterator[nodes_pb2.Node]:
    """Yield the nodes among these or below them; parents come before children."""
    known, found = set(), set(tops)
    for node in every:
        known.add(node.name)
        if node.name in found or node.parent in found:
            found.add(node.name)
            yield node
    for name in tops - known:
        raise UnknownNameError(f"there is no node {name!r}")


def _set_vertices(node: nodes_pb2.Node, vertices: int) -> bool:
    """Set what the node's meshes collide as, and return whether that is something else than before."""
    changed = False
    for figure in node.figures:
        roles = figure.roles
        collides = not roles or nodes_pb2.FIGURE_ROLE_COLLISION in roles
        if collides and figure.HasField("mesh") and figure.mesh.collision_hull_vertices != vertices:
            figure.mesh.collision_hull_vertices = vertices
            changed = True
    return changed


def _changed(node: nodes_pb2.Node) -> scene_pb2.Command:
    update = scene_pb2.UpdateNode(
        name=node.name, node=nodes_pb2.Node(figures=node.figures), update_mask=FieldMask(paths=["figures"])
    )
    return scene_pb2.Command(update_node=update)
