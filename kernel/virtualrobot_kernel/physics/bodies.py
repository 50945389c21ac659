"""Bodies of a world for a physics engine: free parts, robots with motors, what other joints move, and what stands."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.physics import WORLD, Body, BodyJoint, BodyShape, Coupling, PhysicsModel, ShapeKind, Surface
from virtualrobot_sdk.physics_checks import check_inertia
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.physics.solids import Solids, Spread, evenly, placed, shape_of, spread_of, together
from virtualrobot_kernel.world import motored
from virtualrobot_kernel.world.figures import Material
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Joint, JointType, LinkData, Node, PartData, Structure, ToolData

Floats = NDArray[np.float64]

_PLAIN = Material()
_JOINTS = {
    JointType.FLOATING: BodyJoint.FREE,
    JointType.REVOLUTE: BodyJoint.REVOLUTE,
    JointType.CONTINUOUS: BodyJoint.REVOLUTE,
    JointType.PRISMATIC: BodyJoint.PRISMATIC,
}


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Model of a world, and which nodes its bodies are: uids, each list in the order of the model.

    Attributes:
        model: the bodies.
        parts: the parts that forces move.
        links: the links of robots that forces move.
        followers: those of `links` whose joints mimic others, in the order of the model's couplings.
        driven: the links that other joints move.
        rows: row in the model of each of them.
        nodes: the node of each body, in the order of the model.
    """

    model: PhysicsModel
    parts: tuple[int, ...]
    links: tuple[int, ...]
    followers: tuple[int, ...]
    driven: tuple[int, ...]
    rows: dict[int, int]
    nodes: tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Base:
    """Body (its row) that others hang on, and its pose in what theirs are told in."""

    row: int = WORLD
    above_t_base: Floats = field(default_factory=lambda: np.eye(4))

    def hang(self, body: Body, above_t_body: Floats) -> Body:
        """Return a body that hangs on it."""
        return replace(body, parent=self.row, parent_t_body=inverse(self.above_t_base) @ above_t_body)


_WORLD = _Base()


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


def moves_by_forces(node: Node) -> bool:
    """Return whether a node is a part or a robot that moves by forces where an engine is set."""
    return is_dynamic(node) or motored.is_dynamic(node)


def scene_of(snapshot: Snapshot, solids: Solids, substep_seconds: float) -> Scene:
    """Return the bodies of a world: what stands, what joints move, and the parts and robots that forces move.

    Raises KernelError, by the name of the node, for what no rigid body can be, for a mesh without volume, and for a
    robot whose joints an engine doesn't have or that hangs on what moves.
    """
    structure = snapshot.structure
    mover_of = movers(structure)
    uids = {row: uid for uid, row in structure.rows.items()}
    bodies: list[Body] = []
    owners: list[int] = []
    rows: dict[int, int] = {}
    bases: dict[int, _Base] = {}
    masses: dict[int, list[Spread]] = {}
    mover_t: dict[int, Floats] = {}
    parts: list[int] = []
    links: list[int] = []
    driven: list[int] = []
    for row in structure.forest.order.tolist():
        node = structure.nodes[uids[row]]
        mover, pose = mover_of[node.uid], snapshot.state.parent_t_node[row]
        # Where it is in what it moves with, or in the world where it stands.
        above_t_node = mover_t.get(node.parent, np.eye(4)) @ pose
        mover_t[node.uid] = np.eye(4) if mover == node.uid else above_t_node
        made = [*_surfaced(node, solids, stands=not mover)]
        if mover == node.uid:
            # The first of its materials is the body's own; others hang on it.
            own = made.pop(0) if made else Body(node.name)
            rows[mover] = len(bodies)
            if not node.is_moved:
                parts.append(node.uid)
                own = replace(own, joint=BodyJoint.FREE)
            elif _is_of_dynamic(structure, node):
                links.append(node.uid)
                own = _jointed(structure, node, own, above_t_node, mover_of[node.parent], rows, bases)
            else:
                driven.append(node.uid)
                own = replace(own, joint=BodyJoint.FREE, driven=True)
                _refuse_on_dynamic(structure, node, mover_of[node.parent])
            bodies.append(own)
        if mover and mover not in driven:
            found = _spreads(structure, node, mover, solids)
            masses.setdefault(mover, []).extend(placed(one, mover_t[node.uid]) for one in found)
        robot = 0 if mover else _dynamic_robot_of(structure, node)
        base = _Base(rows[mover]) if mover else bases.get(robot, _WORLD)
        for body in made:
            bodies.append(base.hang(body, mover_t[node.uid]))
            if robot and robot not in bases:
                base = bases[robot] = _Base(len(bodies) - 1, mover_t[node.uid])
        owners += [node.uid] * (len(bodies) - len(owners))
    for uid in (*parts, *links):
        bodies[rows[uid]] = _weighed(structure.nodes[uid], bodies[rows[uid]], together(masses[uid]))
    followers = tuple(uid for uid in links if _joint(structure.nodes[uid]).mimic is not None)
    couplings = _couplings(structure, links, followers, rows)
    model = PhysicsModel(tuple(bodies), snapshot.state.physics_settings.gravity, substep_seconds, couplings)
    return Scene(model, tuple(parts), tuple(links), followers, tuple(driven), rows, tuple(owners))


def _joint(link: Node) -> Joint:
    assert isinstance(link.data, LinkData)
    return link.data.joint


def _couplings(
    structure: Structure, links: Sequence[int], followers: Sequence[int], rows: Mapping[int, int]
) -> tuple[Coupling, ...]:
    """Return the gears of links whose joints mimic others, which have their coordinates in the world."""
    forest = structure.forest
    leaders = {int(forest.q_index[structure.rows[uid]]): rows[uid] for uid in links if uid not in followers}
    found: list[Coupling] = []
    for uid in followers:
        at = structure.rows[uid]
        leader = leaders[int(forest.q_index[at])]
        found.append(Coupling(rows[uid], leader, float(forest.multiplier[at]), float(forest.offset[at])))
    return tuple(found)


def _dynamic_robot_of(structure: Structure, node: Node) -> int:
    """Return the robot (uid) whose link a node is, where forces move that; otherwise 0."""
    robot = structure.robot_of(node.uid) if isinstance(node.data, LinkData) else None
    return robot.uid if robot is not None and motored.is_dynamic(robot) else 0


def _is_of_dynamic(structure: Structure, link: Node) -> bool:
    return bool(_dynamic_robot_of(structure, link))


def _jointed(
    structure: Structure,
    node: Node,
    body: Body,
    above_t_node: Floats,
    above: int,
    rows: Mapping[int, int],
    bases: Mapping[int, _Base],
) -> Body:
    """Return the body of a link of a robot that forces move, on what it hangs on (uid; 0: what stands).

    What stands of the robot itself is of one tree with it, and does not touch it.
    """
    joint = _joint(node)
    robot = structure.robot_of(node.uid)
    assert robot is not None

    def refused(why: str) -> KernelError:
        return KernelError(
            f"the joint {joint.name!r} of {robot.name!r} {why}, which physics do not know; keep {robot.name!r} from "
            "being dynamic",
            robot=robot.name,
            joint=joint.name,
        )

    if joint.type not in _JOINTS:
        raise refused(f"is {joint.type.value[0]}")
    if above and joint.type is JointType.FLOATING:
        raise refused(f"floats and hangs on {structure.nodes[above].name!r}")
    if above and not _moves_by_forces(structure, structure.nodes[above]):
        raise refused(f"hangs on {structure.nodes[above].name!r}, which joints without motors move")
    if joint.type is JointType.FLOATING:
        return replace(body, joint=BodyJoint.FREE)
    base = _Base(rows[above]) if above else bases.get(robot.uid, _WORLD)
    return replace(
        base.hang(body, above_t_node),
        joint=_JOINTS[joint.type],
        axis=joint.axis,
        lower=joint.limits.lower,
        upper=joint.limits.upper,
    )


def _moves_by_forces(structure: Structure, mover: Node) -> bool:
    return not mover.is_moved or _is_of_dynamic(structure, mover)


def _refuse_on_dynamic(structure: Structure, node: Node, above: int) -> None:
    """Raise KernelError for a link that a joint without a motor moves against a robot that forces move."""
    if above and structure.nodes[above].is_moved and _is_of_dynamic(structure, structure.nodes[above]):
        robot, carrier = structure.robot_of(node.uid), structure.robot_of(above)
        assert robot is not None and carrier is not None
        raise KernelError(
            f"{robot.name!r} hangs on {carrier.name!r}, which moves by forces; make {robot.name!r} dynamic, too",
            robot=robot.name,
        )


def _spreads(structure: Structure, node: Node, mover: int, solids: Solids) -> Iterator[Spread]:
    """Yield the mass that a node adds to what it moves with, in its own frame."""
    of_part = not structure.nodes[mover].is_moved
    if isinstance(node.data, PartData) and (node.data.dynamic or (not of_part and node.data.mass > 0.0)):
        spread = _spread(node, node.data, solids)
        _check(node, spread)
        yield spread
    elif isinstance(node.data, LinkData | ToolData) and node.data.inertial is not None and node.data.inertial.mass:
        yield spread_of(node.data.inertial)


def _weighed(node: Node, body: Body, spread: Spread) -> Body:
    """Return a body with the mass of all that moves with it; raise KernelError, by its name, where no body has it."""
    if not spread.mass:
        raise KernelError(
            f"the link {node.name!r} has no mass; what moves by forces needs an inertial with one above 0",
            node=node.name,
        )
    _check(node, spread)
    x, y, z = spread.center.tolist()
    return replace(body, mass=spread.mass, center_of_mass=(x, y, z), inertia=spread.inertia)


def _check(node: Node, spread: Spread) -> None:
    try:
        check_inertia(node.name, spread.mass, spread.inertia)
    except ArgumentError as error:
        raise KernelError(str(error), node=node.name) from error


def _spread(node: Node, data: PartData, solids: Solids) -> Spread:
    if not data.mass > 0.0:
        raise KernelError(
            f"the part {node.name!r} has no mass; what moves by forces needs mass_kilograms above 0", node=node.name
        )
    if data.inertial is not None and any((*data.inertial.diagonal, *data.inertial.products)):
        return spread_of(data.inertial)
    shapes = [shape for one in node.figures if one.collision and (shape := shape_of(one, solids, node.name))]
    spread = evenly(data.mass, shapes, node.name)
    if data.inertial is None:
        return spread
    return Spread(data.mass, spread_of(data.inertial).center, spread.inertia)


def _surfaced(node: Node, solids: Solids, *, stands: bool) -> Iterator[Body]:
    """Yield a body without mass for each surface of the figures of a node that are touched, and each height field."""
    groups: dict[Surface, list[BodyShape]] = {}
    for figure in node.figures:
        # A tool that looks otherwise in each state is touched as it looks in all of them.
        if not figure.collision or figure.tool_state:
            continue
        shape, surface = shape_of(figure, solids, node.name, stands=stands), _surface(figure.material or _PLAIN)
        if shape is not None and shape.kind is ShapeKind.HEIGHTS:
            yield Body(node.name, shapes=(shape,), surface=surface)
        elif shape is not None:
            groups.setdefault(surface, []).append(shape)
    for surface, shapes in groups.items():
        yield Body(node.name, shapes=tuple(shapes), surface=surface)


def _surface(material: Material) -> Surface:
    return Surface(
        friction=material.friction,
        spinning=material.spinning_friction,
        rolling=material.rolling_friction,
        restitution=material.restitution,
        stiffness=material.stiffness,
        damping=material.damping,
    )
