"""Denavit-Hartenberg tables read into nodes: a bare table becomes a robot that can be looked at, moved and hit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from virtualrobot_sdk.denavit_hartenberg import SerialArrays, Table, plain, pose, serial_arrays

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.formats.dh_figures import Skeleton, draw
from virtualrobot_kernel.formats.urdf import BASE_JOINTS
from virtualrobot_kernel.world.figures import Figure, Frame, Pose, identity
from virtualrobot_kernel.world.structure import (
    WORLD_NAME,
    Inertial,
    Joint,
    JointType,
    Kind,
    LinkData,
    LinkPair,
    NodeSpec,
    RobotData,
)

BASE, FLANGE = "base_link", "flange"
"""Names of the first and the last link; those between are `link_1`, `link_2` and so on."""


def read_table(
    table: Table,
    joints: Sequence[Joint],
    inertials: Sequence[Inertial | None] = (),
    *,
    name: str,
    parent: str = WORLD_NAME,
    parent_t_node: Pose | None = None,
    base_joint: JointType = JointType.FIXED,
) -> tuple[NodeSpec, ...]:
    """Return the robot that a table describes: the robot first, then its links, then the table's frames.

    Link i moves by joint i, and its frame is where the joint is; with modified tables that is the frame of row i, with
    standard ones that of row i - 1, turned by joint i. Annotations `frame_0` to `frame_n` show the frames of the
    textbooks. The figures are drawn from the lengths in the table, all in proportion to the arm.

    Args:
        table: the geometry.
        joints: a joint about or along z for each row, of the row's type; their names differ.
        inertials: for each row the mass of the link that its joint moves, in the row's frame; empty for none.
        name: of the robot.
        parent: the node that it is fixed to.
        parent_t_node: where it goes, in the parent's frame.
        base_joint: how its first link hangs below the robot: FIXED, FLOATING or PLANAR.

    Raises:
        KernelError: the base joint is none of the three.
    """
    if base_joint not in BASE_JOINTS:
        valid = ", ".join(joint_type.value[0] for joint_type in BASE_JOINTS)
        raise KernelError(f"the base joint cannot be {base_joint.value[0]}; valid: {valid}", valid=valid)
    arrays = serial_arrays(table)
    skeleton = Skeleton(table, arrays, joints)
    links = [BASE, *(f"link_{i + 1}" for i in range(len(joints))), FLANGE]
    taken = {joint.name for joint in joints}
    moves = [
        Joint(_free_name("base", taken), base_joint, (0.0, 0.0, 1.0)),
        *joints,
        Joint(_free_name("to_flange", taken), JointType.FIXED),
    ]
    places = [np.eye(4), *arrays.pre, arrays.post]
    data = RobotData(
        flange=FLANGE,
        kinematics="dh",
        kinematics_settings=plain(table),
        allowed_collisions=tuple(_touching(skeleton, links)),
    )
    nodes = [NodeSpec(name, Kind.ROBOT, parent, identity() if parent_t_node is None else parent_t_node, data=data)]
    masses = _masses(arrays, inertials)
    above = name
    for link, joint, place, figures, mass in zip(links, moves, places, draw(skeleton), masses, strict=True):
        data = LinkData(joint, mass)
        nodes.append(NodeSpec(f"{name}.{link}", Kind.LINK, above, _fixed(place), figures=figures, data=data))
        above = f"{name}.{link}"
    return (*nodes, *_frames(name, table, arrays, skeleton.radius(0)))


def _masses(arrays: SerialArrays, inertials: Sequence[Inertial | None]) -> list[Inertial | None]:
    """Return the mass of each link, base and flange included, in the link's own frame."""
    moved = (
        [
            told and replace(told, link_t_inertial=_fixed(joint_t_row @ told.link_t_inertial))
            for told, joint_t_row in zip(inertials, arrays.joint_t_row, strict=True)
        ]
        if inertials
        else [None] * len(arrays.joint_t_row)
    )
    return [None, *moved, None]


def _frames(name: str, table: Table, arrays: SerialArrays, length: float) -> list[NodeSpec]:
    """Return the annotations that show the table's frames, `frame_0` (before the first row) to `frame_n`."""
    figures = (Figure(Frame(1.5 * length), collision=False),)
    places = [(f"{name}.{BASE}", pose(table.base_t_first))]
    places += [(f"{name}.link_{i + 1}", place) for i, place in enumerate(arrays.joint_t_row)]
    return [
        NodeSpec(f"{name}.frame_{i}", Kind.ANNOTATION, link, _fixed(place), figures=figures)
        for i, (link, place) in enumerate(places)
    ]


def _touching(skeleton: Skeleton, links: Sequence[str]) -> list[LinkPair]:
    """Return the pairs that overlap as they are drawn: neighbours, and links with next to no length between them."""
    pairs = []
    for i, j in combinations(range(len(links)), 2):
        if j == i + 1:
            pairs.append(LinkPair(links[i], links[j], "Adjacent"))
        elif skeleton.length_between(i, j) < 1.5 * (skeleton.radius(i) + skeleton.radius(j)):
            pairs.append(LinkPair(links[i], links[j], "Drawn into each other"))
    return pairs


def _free_name(name: str, taken: set[str]) -> str:
    """Return `name`, with underscores behind it while a joint has that name."""
    while name in taken:
        name += "_"
    return name


def _fixed(place: Pose) -> Pose:
    place = place + 0.0  # a copy of its own, without -0.0
    place.setflags(write=False)
    return place
