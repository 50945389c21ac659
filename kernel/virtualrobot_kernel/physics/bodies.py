"""Bodies of a world for a physics engine: free parts, what joints move, and what stands."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.physics import WORLD, Body, BodyJoint, BodyShape, PhysicsModel, Surface
from virtualrobot_sdk.physics_checks import check_inertia
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.physics.solids import Hulls, Spread, evenly, shape_of, spread_of
from virtualrobot_kernel.world.figures import Material
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node, PartData, Structure

_PLAIN = Material()


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Model of a world, and which nodes its bodies are.

    Attributes:
        model: the bodies.
        free: (k,) rows in the world of the parts that forces move, in the order of the model.
        free_uids: their uids.
        driven: (d,) rows in the world of what joints move, in the order of the model.
    """

    model: PhysicsModel
    free: tuple[int, ...]
    free_uids: tuple[int, ...]
    driven: tuple[int, ...]


def movers(structure: Structure) -> dict[int, int]:
    """Return for each node (uid) the one that it moves with: a moved link, a free part, or 0 where it stands.

    A part that is dynamic is free unless what it hangs on moves.
    """
    found: dict[int, int] = {}
    rows = {row: uid for uid, row in structure.rows.items()}
    for row in structure.forest.order.tolist():
        node = structure.nodes[rows[row]]
        above = found.get(node.parent, 0)
        found[node.uid] = node.uid if node.is_moved or (not above and is_dynamic(node)) else above
    return found


def is_dynamic(node: Node) -> bool:
    """Return whether a node is a part that moves by forces where nothing else moves it."""
    return isinstance(node.data, PartData) and node.data.dynamic


def scene_of(snapshot: Snapshot, hull: Hulls, substep_seconds: float) -> Scene:
    """Return the bodies of a world: what stands, what joints move, and the parts that forces move.

    Raises KernelError, by the name of the node, for a part that no rigid body can be, and for a mesh without volume.
    """
    structure = snapshot.structure
    mover_of = movers(structure)
    rows = {row: uid for uid, row in structure.rows.items()}
    bodies: list[Body] = []
    place_of: dict[int, int] = {}
    free: list[int] = []
    driven: list[int] = []
    for row in structure.forest.order.tolist():
        node = structure.nodes[rows[row]]
        mover = mover_of[node.uid]
        pose = snapshot.world_t_node[row]
        made = [*_surfaced(node, hull)]
        if mover == node.uid:
            # The first of its materials is the body's own; others hang on it.
            own = replace(made.pop(0) if made else Body(node.name), joint=BodyJoint.FREE, driven=node.is_moved)
            (driven if node.is_moved else free).append(row)
            place_of[mover] = len(bodies)
            bodies.append(own if node.is_moved else _weighed(node, hull, own))
        parent, at = WORLD, pose
        if mover:
            parent, at = place_of[mover], inverse(snapshot.world_t(mover)) @ pose
            if mover != node.uid and is_dynamic(node) and not structure.nodes[mover].is_moved:
                made.append(_weighed(node, hull, Body(node.name)))
        bodies += [replace(body, parent=parent, parent_t_body=at) for body in made]
    model = PhysicsModel(tuple(bodies), snapshot.state.physics_settings.gravity, substep_seconds)
    uids = tuple(rows[row] for row in free)
    return Scene(model, tuple(free), uids, tuple(driven))


def _weighed(node: Node, hull: Hulls, body: Body) -> Body:
    """Return a body with the mass of its part; raise KernelError, by its name, where no rigid body has it."""
    assert isinstance(node.data, PartData)
    spread = _spread(node, node.data, hull)
    try:
        check_inertia(node.name, spread.mass, spread.inertia)
    except ArgumentError as error:
        raise KernelError(str(error), node=node.name) from error
    x, y, z = spread.center.tolist()
    return replace(body, mass=spread.mass, center_of_mass=(x, y, z), inertia=spread.inertia)


def _spread(node: Node, data: PartData, hull: Hulls) -> Spread:
    if not data.mass > 0.0:
        raise KernelError(
            f"the part {node.name!r} has no mass; what moves by forces needs mass_kilograms above 0", node=node.name
        )
    if data.inertial is not None and any((*data.inertial.diagonal, *data.inertial.products)):
        return spread_of(data.inertial)
    shapes = [shape for one in node.figures if one.collision and (shape := shape_of(one, hull, node.name))]
    spread = evenly(data.mass, shapes, node.name)
    if data.inertial is None:
        return spread
    return Spread(data.mass, spread_of(data.inertial).center, spread.inertia)


def _surfaced(node: Node, hull: Hulls) -> Iterator[Body]:
    """Yield a body without mass for each material of the figures of a node that are touched."""
    groups: dict[Material, list[BodyShape]] = {}
    for figure in node.figures:
        # A tool that looks otherwise in each state is touched as it looks in all of them.
        if figure.collision and not figure.tool_state and (shape := shape_of(figure, hull, node.name)) is not None:
            groups.setdefault(figure.material or _PLAIN, []).append(shape)
    for material, shapes in groups.items():
        yield Body(node.name, shapes=tuple(shapes), surface=Surface(material.friction))
