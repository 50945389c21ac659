"""Robot as rigid bodies: every moving link with all that is fixed to it, tools and held parts included."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.index import SINGLE
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import (
    Inertial,
    Joint,
    JointType,
    LinkData,
    Node,
    PartData,
    Structure,
    ToolData,
)

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Bodies:
    """Rigid bodies (b) of a robot as `numeric.dynamics.inverse_dynamics` takes them; the first is its base.

    joints are the k joints of one coordinate that move them, q_index (k,) says where these are in the world's q.
    `payload` is the mass (kg) of what hangs on the robot besides its own links.
    """

    joints: tuple[Joint, ...]
    q_index: NDArray[np.int32]
    parent: NDArray[np.int32]
    joint_type: NDArray[np.int8]
    axis: Floats
    joint_index: NDArray[np.int32]
    multiplier: Floats
    offset: Floats
    parent_t_body: Floats
    mass: Floats
    moment: Floats
    inertia: Floats
    payload: float
    warnings: tuple[str, ...]


def bodies_of(snapshot: Snapshot, robot: Node) -> Bodies:
    """Return the bodies of a robot with the masses of all that hangs on it.

    A floating or planar joint stands still, and so does a robot that is mounted on this one. A part with a mass and no
    inertial counts as a point at its origin.
    """
    structure, poses = snapshot.structure, snapshot.state.parent_t_node
    index, forest = structure.robots[robot.uid], structure.forest
    own = frozenset(index.links)
    singles = [
        (joint, start)
        for joint, start in zip(index.joints, index.q_start, strict=True)
        if joint.type.coordinate_count == 1
    ]
    column_of = {start: column for column, (_, start) in enumerate(singles)}

    body_of: dict[int, int] = {robot.uid: 0}
    body_t: dict[int, Pose] = {robot.uid: np.eye(4)}
    rows, parents, places = [structure.rows[robot.uid]], [0], [np.eye(4)]
    masses, moments, inertias = [0.0], [np.zeros(3)], [np.zeros((3, 3))]
    warnings: list[str] = []
    payload = 0.0
    for node in structure.below(robot.uid):
        if node.uid == robot.uid:
            continue
        row = structure.rows[node.uid]
        above, above_t = body_of[node.parent], body_t[node.parent]
        kind = node.data.joint.type if isinstance(node.data, LinkData) else JointType.FIXED
        if node.uid in own and kind in SINGLE:
            body_of[node.uid], body_t[node.uid] = len(rows), np.eye(4)
            rows.append(row)
            parents.append(above)
            places.append(above_t @ poses[row])
            masses.append(0.0)
            moments.append(np.zeros(3))
            inertias.append(np.zeros((3, 3)))
        else:
            # A joint of more coordinates, or of another robot, stands as it is.
            moved = inverse(snapshot.world_t(node.parent)) @ snapshot.world_t(node.uid)
            body_of[node.uid] = above
            body_t[node.uid] = above_t @ (poses[row] if kind is JointType.FIXED else moved)
        inertial = inertial_of(node, warnings)
        if inertial is None:
            continue
        body = body_of[node.uid]
        body_t_inertial = body_t[node.uid] @ inertial.link_t_inertial
        centre, turn = body_t_inertial[:3, 3], body_t_inertial[:3, :3]
        masses[body] += inertial.mass
        moments[body] += inertial.mass * centre
        # The parallel-axis theorem takes the inertia from the centre of mass to the body's origin.
        shifted = inertial.mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
        inertias[body] += turn @ inertia_tensor(inertial) @ turn.T + shifted
        payload += 0.0 if node.uid in own else inertial.mass
    warnings[:0] = _massless(structure, rows, masses)
    return Bodies(
        joints=tuple(joint for joint, _ in singles),
        q_index=np.array([start for _, start in singles], np.int32),
        parent=np.array(parents, np.int32),
        joint_type=np.ascontiguousarray(forest.joint_type[rows]),
        axis=np.ascontiguousarray(forest.axis[rows]),
        joint_index=np.array([0, *(column_of[int(start)] for start in forest.q_index[rows[1:]])], np.int32),
        multiplier=np.ascontiguousarray(forest.multiplier[rows]),
        offset=np.ascontiguousarray(forest.offset[rows]),
        parent_t_body=np.array(places),
        mass=np.array(masses),
        moment=np.array(moments),
        inertia=np.array(inertias),
        payload=payload,
        warnings=tuple(warnings),
    )


def load_of(snapshot: Snapshot, robot: Node) -> float:
    """Return the mass (kg) of what hangs at the flange of a robot, as far as it is known: tools, and what they hold."""
    structure = snapshot.structure
    index = structure.robots[robot.uid]
    found = (inertial_of(node) for node in structure.below(index.flange) if node.uid not in index.links)
    return sum(one.mass for one in found if one is not None)


def inertial_of(node: Node, warnings: list[str] | None = None) -> Inertial | None:
    """Return the mass of a node and how it is spread; say in `warnings`, where given, what is unknown.

    A part with a mass and no inertial counts as a point at its origin.
    """
    data, warnings = node.data, [] if warnings is None else warnings
    if isinstance(data, LinkData):
        return data.inertial
    if isinstance(data, ToolData):
        if data.inertial is None and node.figures:
            warnings.append(f"the tool {node.name!r} has no mass; give it an inertial")
        return data.inertial
    if not isinstance(data, PartData):
        return None
    if data.inertial is not None:
        return data.inertial
    if data.mass:
        warnings.append(f"the part {node.name!r} of {data.mass:g} kg counts as a point at its origin")
        return Inertial(data.mass, np.eye(4), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    warnings.append(f"the part {node.name!r} has no mass; give it mass_kilograms or an inertial")
    return None


def _massless(structure: Structure, rows: list[int], masses: list[float]) -> list[str]:
    """Return a warning for each body but the base that has no mass."""
    by_row = list(structure.nodes.values())
    return [
        f"the link {by_row[row].name!r} and what is fixed to it have no mass"
        for row, mass in zip(rows[1:], masses[1:], strict=True)
        if not mass
    ]


def inertia_tensor(inertial: Inertial) -> Floats:
    """Return the inertia (3, 3) about the centre of mass in the inertial frame, kg m^2."""
    (xx, yy, zz), (xy, xz, yz) = inertial.diagonal, inertial.products
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
