"""Pairs of nodes that touch as a model is built or stands, found as it is imported: what is built right is not red.

Asked are only pairs that would be told as collisions: of a robot's own nodes, of what it begins with and the objects
that it cannot move against, and of what is mounted on a robot and the links next to it. Boxes come first, so that
solids are made only of what is near: of most arms of none.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import AllowedPairs, Pair, allowed_pairs, ordered
from virtualrobot_kernel.collision.bodies import collision_figures
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.nearest import Floats
from virtualrobot_kernel.collision.pairs import is_near
from virtualrobot_kernel.collision.placed import Placed
from virtualrobot_kernel.collision.touching import touches
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.numeric.boxes import overlapping_boxes
from virtualrobot_kernel.planning.robots import standing_at, with_state, world_poses
from virtualrobot_kernel.shapes.submesh import stacked
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.apply_tools import as_mounted
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import ClearWorld, Command, CreateNodes, MountTool, SetAllowedPairs
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Figure, Geometry, Mesh, Sphere
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, LinkData, Structure

DRAWS = 32
"""Number of postures near the one as loaded in which a pair must touch to count as built so."""

TURN, SHIFT = 0.05, 0.005
"""Farthest that a joint goes in these postures, in radians and in meters."""

SEED = 20131
"""Seed of these postures: equal models have equal pairs."""

MOST_TRIANGLES = 100_000
"""Number of triangles of a mesh up to which it is looked at: a second or two; what has more is left as it is."""

AT_LIMIT = 1e-6
"""Distance from its limit, in radians or meters, at which a joint is there."""

Named = tuple[str, str, str]
"""Two nodes by name, and why they may touch."""


@dataclass(frozen=True, slots=True)
class _Question:
    """Reason for which a pair may touch if it does as loaded, `always`: in all postures near that one."""

    reason: str
    always: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Elements:
    """Figures (e,) of nodes (uids (e,), rows (e,)), their places in these (e, 4, 4), and the paddings of these (e,)."""

    uids: list[int]
    figures: list[Figure]
    rows: NDArray[np.intp]
    node_t_element: Floats
    padding: Floats

    def among(self, places: Sequence[int]) -> _Elements:
        """Return some of the elements."""
        uids, figures = [self.uids[i] for i in places], [self.figures[i] for i in places]
        at = np.array(places, np.intp)
        return _Elements(uids, figures, self.rows[at], self.node_t_element[at], self.padding[at])

    def placed(self, snapshot: Snapshot) -> Floats:
        """Return where they are in the world's frame, (e, 4, 4)."""
        return snapshot.world_t_node[self.rows] @ self.node_t_element


def built_pairs(
    snapshot: Snapshot, commands: Sequence[Command], shapes: CollisionShapes, names: Collection[str] | None = None
) -> tuple[Named, ...]:
    """Return the pairs that touch as commands build a world; none where they are refused.

    Args:
        snapshot: the world before them.
        commands: those that create nodes, and what may touch by others; joints are taken where they begin.
        shapes: what figures collide as.
        names: of the nodes that are looked at, of those that are created; None means all.
    """
    commands = [one for one in commands if isinstance(one, ClearWorld | CreateNodes | MountTool | SetAllowedPairs)]
    specs = [spec for command in commands if isinstance(command, CreateNodes) for spec in command.specs]
    known = snapshot.structure.uid_by_name
    mounted = any(isinstance(one, MountTool) for one in commands) or any(
        snapshot.structure.robot_of(known[spec.parent]) for spec in specs if spec.parent in known
    )
    if not mounted and not any(spec.kind is Kind.ROBOT for spec in specs):
        return ()
    change = _applied(snapshot, commands)
    if change is None:
        return ()
    nodes = change.structure.nodes
    new = {uid for uid in change.created if isinstance(uid, int) and (names is None or nodes[uid].name in names)}
    return touching_as_built(with_state(snapshot, change.state, change.structure), new, shapes)


def mounted_pairs(snapshot: Snapshot, commands: Sequence[Command], shapes: CollisionShapes) -> tuple[Named, ...]:
    """Return the pairs that touch as commands mount tools that are there on robots; none where they are refused."""
    change = _applied(snapshot, commands)
    if change is None:
        return ()
    structure, new = change.structure, set[int]()
    for command in commands:
        if isinstance(command, MountTool) and structure.uid_by_name.keys() >= {command.robot, command.node}:
            top = as_mounted(structure, structure.node(command.robot), structure.node(command.node))
            new |= {node.uid for node in structure.below(top.uid) if node.kind is not Kind.PART}
    return touching_as_built(with_state(snapshot, change.state, structure), (), shapes, new)


def _applied(snapshot: Snapshot, commands: Sequence[Command]) -> Change | None:
    """Return the world after commands; None where they are refused, for which the world says why."""
    try:
        return apply(snapshot.structure, snapshot.state, commands, world_poses)
    except KernelError:
        return None


def touching_as_built(
    snapshot: Snapshot, new: Collection[int], shapes: CollisionShapes, mounted: Collection[int] = ()
) -> tuple[Named, ...]:
    """Return the pairs with one of the `new` nodes (uids) that touch as they are built or stand, in a fixed order.

    Of what is only `mounted` the pairs with what it is mounted on are looked at.

    A pair of a robot's own nodes counts where it touches in all postures near the present one, or where both hang on
    the same body by joints that are at their limits: fingers that close on each other.
    """
    allowed = allowed_pairs(snapshot.structure, snapshot.state.allowed_pairs)
    asked = _asked(snapshot, new, {*new, *mounted}, allowed)
    elements, near = _near(snapshot, {*new, *mounted}, asked, shapes)
    solids = [shapes.get(figure.geometry) for figure in elements.figures]
    made = [solid for solid in solids if solid is not None]
    if not made or len(made) < len(solids):
        return ()
    margins = np.array([solid.margin for solid in made])
    placed = Placed(made, elements.placed(snapshot), padding=elements.padding + margins)
    own, matrix = np.arange(len(made)), np.zeros((len(made), len(made)), np.bool_)
    for one, other in near:
        matrix[one, other] = True
    found = _touching(placed, own, matrix, elements.uids)
    always = {pair for pair in found if asked[pair].always}
    for posture in _postures(snapshot, {allowed.groups[uid] for pair in always for uid in pair}) if always else ():
        placed.move(elements.placed(posture))
        always &= _touching(placed, own, matrix, elements.uids)
        if not always:
            break
    nodes = snapshot.structure.nodes
    result = []
    for pair in sorted(found):
        reason = asked[pair].reason
        if asked[pair].always and pair not in always:
            if not _close_on_each_other(snapshot, pair, allowed):
                continue
            reason = "close on each other"
        result.append((nodes[pair[0]].name, nodes[pair[1]].name, reason))
    return tuple(result)


def _asked(
    snapshot: Snapshot, new: Collection[int], mounted: Collection[int], allowed: AllowedPairs
) -> dict[Pair, _Question]:
    """Return the pairs (uids) that are looked at, with what follows if they touch."""
    structure, groups, bodies = snapshot.structure, allowed.groups, allowed.bodies
    solid = list(dict.fromkeys(uid for uid, _ in collision_figures(snapshot)))
    asked: dict[Pair, _Question] = {}

    def ask(ones: Iterable[int], others: Iterable[int], question: _Question) -> None:
        others = tuple(others)
        pairs = (ordered(one, other) for one in ones for other in others if allowed.why(one, other) is None)
        asked.update(dict.fromkeys(pairs, question))

    for robot in (uid for uid in structure.robots if uid in new):
        own = [uid for uid in solid if groups[uid] == robot]
        ask(own, own, _Question("touch as built", True))
        base = [uid for uid in own if bodies[uid] == bodies[robot]]
        for uid in solid:
            if structure.nodes[uid].kind is Kind.OBJECT and not groups[uid] and bodies[uid] == bodies[robot]:
                ask(base, [uid], _Question(f"stands on {structure.nodes[uid].name!r}", False))
    for top in (structure.nodes[uid] for uid in sorted(mounted)):
        carrier = groups[top.parent]
        if top.parent in mounted or not carrier or top.kind is Kind.PART:
            continue
        at = structure.nodes[top.parent]
        body = bodies[at.uid]
        fixed = [uid for uid in solid if uid in mounted and bodies[uid] == body]
        old = [uid for uid in solid if uid not in mounted and groups[uid] == carrier]
        question = _Question(f"mounted on {at.name!r}", False)
        ask(fixed, (uid for uid in old if bodies[uid] == body), question)
        if structure.nodes[body].kind is Kind.LINK:
            above = bodies[structure.nodes[body].parent]
            ask(fixed, (uid for uid in old if bodies[uid] == above), replace(question, always=True))
    return asked


def _near(
    snapshot: Snapshot, new: Collection[int], asked: Collection[Pair], shapes: CollisionShapes
) -> tuple[_Elements, list[tuple[int, int]]]:
    """Return the elements whose boxes overlap with those of an asked pair, and these pairs of them by their places."""
    wanted = {uid for pair in asked for uid in pair}
    uids: list[int] = []
    figures: list[Figure] = []
    boxes: list[tuple[Floats, Floats]] = []
    for uid, figure in collision_figures(snapshot):
        if uid in wanted and (box := _box(figure, shapes)) is not None:
            uids.append(uid)
            figures.append(figure)
            boxes.append(box)
    paddings, rows = snapshot.state.collisions.paddings, snapshot.structure.rows
    elements = _Elements(
        uids,
        figures,
        np.array([rows[uid] for uid in uids], np.intp),
        np.array([figure.node_t_figure for figure in figures], np.float64).reshape(-1, 4, 4),
        np.array([paddings.get(uid, 0.0) for uid in uids]),
    )
    of_node: dict[int, list[int]] = {}
    for place, uid in enumerate(uids):
        of_node.setdefault(uid, []).append(place)
    own = np.array([place for place, uid in enumerate(uids) if uid in new], np.int64)
    row_of = {place: row for row, place in enumerate(own.tolist())}
    matrix = np.zeros((len(own), len(uids)), np.bool_)
    for pair in asked:
        one, other = pair if pair[0] in new else pair[::-1]
        for place in of_node.get(one, ()):
            matrix[row_of[place], of_node.get(other, ())] = True
    if not matrix.any():
        return elements.among([]), []
    poses = elements.placed(snapshot)
    centre = np.array([box[0] for box in boxes])
    half = np.array([box[1] for box in boxes]) + elements.padding[:, None]
    turn = poses[:, :3, :3]
    world_centre = (turn @ centre[:, :, None])[..., 0] + poses[:, :3, 3]
    world_half = (np.abs(turn) @ half[:, :, None])[..., 0]
    count = int(matrix.sum())
    out, depths = np.empty((count, 4), np.int64), np.empty(count)
    block = np.arange(len(uids) + 1)
    count = overlapping_boxes(own, matrix, world_centre, world_half, poses, block, centre, half, out, depths)
    pairs = [(int(one), int(other)) for one, other, _, _ in out[:count]]
    places = sorted({place for pair in pairs for place in pair})
    at = {place: row for row, place in enumerate(places)}
    return elements.among(places), [(at[one], at[other]) for one, other in pairs]


def _box(figure: Figure, shapes: CollisionShapes) -> tuple[Floats, Floats] | None:
    """Return centre and half (3,) of the box around a figure in its own frame; None for what is not looked at."""
    if not isinstance(figure.geometry, Mesh):
        half = _half(figure.geometry)
        return None if half is None else (np.zeros(3), np.array(half))
    try:
        vertices, faces = stacked(shapes.meshes(figure.geometry))
    except KernelError:
        return None  # it touches nothing, as a check tells
    if not 0 < len(faces) <= MOST_TRIANGLES:
        return None
    low, high = (end(vertices, axis=0).astype(np.float64) for end in (np.min, np.max))
    # A hull is within the box too; what the mesh reaches out of it makes the hull thicker by less than the box is long.
    return 0.5 * (low + high), 0.5 * (high - low) * (2.0 if figure.geometry.collision_hull_vertices else 1.0)


def _half(geometry: Geometry) -> tuple[float, float, float] | None:
    """Return half the extents of a primitive; None for what nothing touches. Its middle is the figure's origin."""
    match geometry:
        case Box((x, y, z)):
            return 0.5 * x, 0.5 * y, 0.5 * z
        case Sphere(radius):
            return radius, radius, radius
        case Capsule(radius, length):
            return radius, radius, 0.5 * length + radius
        case Cylinder(radius, length) | Cone(radius, length):
            return radius, radius, 0.5 * length
    return None


def _touching(placed: Placed, own: NDArray[np.int64], asked: NDArray[np.bool_], uids: Sequence[int]) -> set[Pair]:
    """Return the pairs of nodes of elements that are asked and touch."""
    found: set[Pair] = set()
    for one, other, row, to in placed.overlaps(own, asked):
        pair = ordered(uids[one], uids[other])
        if pair not in found and (touches(placed, one, other, row, to) or is_near(placed, one, other, row, to)):
            found.add(pair)
    return found


def _postures(snapshot: Snapshot, robots: Collection[int]) -> Iterator[Snapshot]:
    """Yield the world with the joints of robots (uids) at random places near where they are, within their limits."""
    rng = np.random.default_rng(SEED)
    index = [snapshot.structure.robots[uid] for uid in sorted(robots) if uid in snapshot.structure.robots]
    single = [
        (joint, start)
        for robot in index
        for joint, start in zip(robot.joints, robot.q_start, strict=True)
        if joint.type.coordinate_count == 1
    ]
    q_index = np.array([start for _, start in single], np.int32)
    reach = np.array([SHIFT if joint.type is JointType.PRISMATIC else TURN for joint, _ in single])
    q = snapshot.state.q[q_index]
    lower = np.minimum(q, np.maximum(q - reach, [joint.limits.lower for joint, _ in single]))
    upper = np.maximum(q, np.minimum(q + reach, [joint.limits.upper for joint, _ in single]))
    for _ in range(DRAWS):
        yield standing_at(snapshot, q_index, rng.uniform(lower, upper))


def _close_on_each_other(snapshot: Snapshot, pair: Pair, allowed: AllowedPairs) -> bool:
    """Return whether two nodes are moved on the same body by a joint each, and these are at a limit."""
    structure = snapshot.structure
    links = [structure.nodes[allowed.bodies[uid]] for uid in pair]
    if any(not isinstance(link.data, LinkData) for link in links) or links[0] is links[1]:
        return False
    one, other = (allowed.bodies[link.parent] for link in links)
    return one == other and all(_at_limit(snapshot, structure, link.uid) for link in links)


def _at_limit(snapshot: Snapshot, structure: Structure, link: int) -> bool:
    """Return whether the joint that moves a link, or the one that it mimics, is at a limit."""
    place = int(structure.forest.q_index[structure.rows[link]])
    joint = _joint_at(structure, place)
    if joint is None:
        return False
    value = float(snapshot.state.q[place])
    return min(abs(value - joint.limits.lower), abs(value - joint.limits.upper)) <= AT_LIMIT


def _joint_at(structure: Structure, place: int) -> Joint | None:
    """Return the joint whose only coordinate is at a place in q."""
    for robot in structure.robots.values():
        for joint, start in zip(robot.joints, robot.q_start, strict=True):
            if start == place and joint.type.coordinate_count == 1:
                return joint
    return None
