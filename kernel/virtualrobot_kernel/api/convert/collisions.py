"""Collisions and distances: messages to values and back."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from virtualrobot.v1 import collision_pb2

from virtualrobot_kernel.collision.allowed import Cause
from virtualrobot_kernel.collision.bodies import BODILESS, Bodies
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.report import thinned
from virtualrobot_kernel.collision.scene import Collision, Detail, Nearest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import EnumTable
from virtualrobot_kernel.messages.values import by_name, vector_message
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.world.change import with_positions
from virtualrobot_kernel.world.figures import Mesh
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, Structure

DETAILS = EnumTable(Detail, collision_pb2.CollisionDetail, Detail.PAIRS)
CAUSES = EnumTable(Cause, collision_pb2.AllowedCause)


def configured(snapshot: Snapshot, messages: Sequence[collision_pb2.RobotConfiguration]) -> Snapshot:
    """Return the world with robots elsewhere; raise KernelError for joints and values that cannot be.

    Raises UnknownNameError for a robot or joint that there is not, LimitError for a value outside limits.
    """
    q = snapshot.state.q
    for row, message in enumerate(messages):
        robot = snapshot.structure.node(message.robot, Kind.ROBOT)
        if message.robot in {other.robot for other in messages[:row]}:
            raise KernelError(
                f"configurations[{row}] names the robot {message.robot!r} again; give all its joints in one",
                field=f"configurations[{row}].robot",
                robot=message.robot,
            )
        q = with_positions(
            snapshot.structure, robot, q, by_name(message.joint_positions, f"configurations[{row}].joint_positions")
        )
    return standing_at(snapshot, ..., q) if messages else snapshot


def nodes_below(structure: Structure, names: Iterable[str]) -> set[int]:
    """Return nodes and all below them (uids); raise UnknownNameError for a name that there is not."""
    return {node.uid for name in names for node in structure.below(structure.node(name).uid)}


def collision_message(structure: Structure, found: Collision) -> collision_pb2.CollisionPair:
    """Return two nodes that touch as a message."""
    return pair_message((structure.nodes[found.first].name, structure.nodes[found.second].name), found)


def pair_message(names: tuple[str, str], found: Collision) -> collision_pb2.CollisionPair:
    """Return two nodes of these names that touch as a message."""
    return collision_pb2.CollisionPair(
        first=names[0],
        second=names[1],
        contacts=[
            collision_pb2.CollisionContact(point=vector_message(point), normal=vector_message(one.normal))
            for one in thinned(found).contacts
            for point in one.points
        ],
        depth_meters=found.depth.meters if found.depth else None,
        depth_approximate=found.depth is not None and found.depth.approximate,
    )


def distance_message(structure: Structure, found: Nearest) -> collision_pb2.DistancePair:
    """Return the distance of two nodes as a message."""
    return collision_pb2.DistancePair(
        first=structure.nodes[found.first].name,
        second=structure.nodes[found.second].name,
        distance_meters=found.distance,
        first_point=vector_message(found.points[0]),
        second_point=vector_message(found.points[1]),
    )


def allowed_messages(structure: Structure, bodies: Bodies, among: set[int]) -> Iterator[collision_pb2.AllowedPair]:
    """Yield the pairs of nodes with elements that may touch, in the order of the nodes, with one `among` these."""
    nodes = list(bodies.elements)
    groups = bodies.allowed.groups
    robots: dict[int, list[int]] = {}
    for uid in nodes:
        robots.setdefault(groups[uid], []).append(uid)
    by_node: dict[int, set[int]] = {}
    for first, second in bodies.allowed.pairs:
        by_node.setdefault(first, set()).add(second)
    for uid in nodes:
        others = by_node.get(uid, set()) | (set(robots[groups[uid]]) if groups[uid] else set())
        for other in sorted(others):
            why = bodies.allowed.why(uid, other)
            if other <= uid or why is None or other not in bodies.elements or not {uid, other} & among:
                continue
            yield collision_pb2.AllowedPair(
                first=structure.nodes[uid].name,
                second=structure.nodes[other].name,
                cause=CAUSES.write(why[0]),
                reason=why[1],
            )


def mesh_messages(
    structure: Structure, shapes: CollisionShapes, among: set[int]
) -> Iterator[collision_pb2.CollisionMesh]:
    """Yield what the meshes of nodes `among` these collide as, in the order of the nodes; makes what isn't made yet."""
    for uid, node in structure.nodes.items():
        if uid not in among or node.kind in BODILESS:
            continue
        for place, figure in enumerate(node.figures):
            solid = shapes.get(figure.geometry) if figure.collision and isinstance(figure.geometry, Mesh) else None
            if solid is None or solid.mesh is None:
                continue
            assert isinstance(figure.geometry, Mesh)
            yield collision_pb2.CollisionMesh(
                node=node.name,
                figure=place,
                uri=figure.geometry.uri,
                mesh_triangles=solid.mesh.triangles,
                triangles=sum(len(piece.triangles) for piece in solid.pieces),
                hull=solid.solid is not None,
                deviation_meters=solid.margin,
                convex=bool(solid.pieces) and solid.outline.exact and not solid.margin,
                seconds=solid.mesh.seconds,
                warning=solid.mesh.warning,
            )
