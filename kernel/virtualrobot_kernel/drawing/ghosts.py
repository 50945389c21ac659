"""Ghosts: the visible figures of robots where they are not, on the robots' bases."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np

from virtualrobot_kernel.drawing.view import Ghost
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.world.figures import (
    Box,
    Capsule,
    Cone,
    Cylinder,
    Figure,
    Frame,
    Geometry,
    Label,
    Lines,
    Material,
    Mesh,
    Points,
    Sphere,
)
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import FOR_PEOPLE, Kind, Structure
from virtualrobot_kernel.world.visibility import inherited_visibility

SLIM = 0.985
"""Size of ghosts beside that of robots."""


def is_there(structure: Structure, ghost: Ghost) -> bool:
    """Return whether the robot of a ghost is there and has the coordinates that it had."""
    robot = structure.robots.get(ghost.robot)
    return robot is not None and all(robot.q_slice.stop - robot.q_slice.start == len(q) for q in ghost.rows)


def ghost_figures(snapshot: Snapshot, ghosts: tuple[Ghost, ...]) -> Iterator[tuple[int, Figure]]:
    """Yield (uid of the robot, figure in the robot's frame) of ghosts; one whose robot is gone is passed over.

    What hangs below the robot counts, in the tools' states and where it hangs in this snapshot, with its grippers, but
    not other robots there. What its joints do not move is left out, and what is at one place in several configurations
    comes once.
    """
    structure = snapshot.structure
    for ghost in ghosts:
        if not is_there(structure, ghost):
            continue
        parts = [(structure.rows[uid], figure) for uid, figure in moved_parts(snapshot, ghost.robot)]
        material = Material((*ghost.color, ghost.opacity))
        places = structure.robots[ghost.robot].q_slice
        q_index = np.arange(places.start, places.stop, dtype=np.int32)
        base = structure.rows[ghost.robot]
        shown: set[tuple[int, bytes]] = set()
        for q in ghost.rows:
            world_t_node = standing_at(snapshot, q_index, np.array(q)).world_t_node
            robot_t_node = np.linalg.inv(world_t_node[base]) @ world_t_node
            for part, (row, figure) in enumerate(parts):
                place = robot_t_node[row] @ figure.node_t_figure
                known = part, (np.round(place, 9) + 0.0).tobytes()  # there is a negative zero
                if known in shown:
                    continue
                shown.add(known)
                yield ghost.robot, replace(figure, node_t_figure=place, material=material, tool_state="")


def moved_parts(snapshot: Snapshot, robot: int) -> Iterator[tuple[int, Figure]]:
    """Yield (uid of the node, figure) of what a robot's joints move and people see: links, tools, what they hold."""
    structure = snapshot.structure
    hidden, states = inherited_visibility(structure, snapshot.state.tool_states)
    grippers = structure.grippers_of(robot)
    for node in structure.below(robot):
        if hidden[node.uid] or node.kind in FOR_PEOPLE or not _is_moved(structure, node.uid, robot, grippers):
            continue
        for figure in node.figures:
            is_solid = not isinstance(figure.geometry, Points | Lines | Frame | Label)
            if figure.visual and is_solid and figure.tool_state in ("", states[node.uid]):
                yield node.uid, replace(figure, geometry=slimmer(figure.geometry))


def slimmer(geometry: Geometry) -> Geometry:
    """Return a solid geometry a little smaller, so that where ghost and robot are at one place the robot is seen."""
    match geometry:
        case Box(size):
            return Box((SLIM * size[0], SLIM * size[1], SLIM * size[2]))
        case Mesh(scale=scale):
            return replace(geometry, scale=(SLIM * scale[0], SLIM * scale[1], SLIM * scale[2]))
        case Sphere(radius):
            return Sphere(SLIM * radius)
        case Cylinder() | Cone() | Capsule():
            return replace(geometry, radius=SLIM * geometry.radius, length=SLIM * geometry.length)
    return geometry


def _is_moved(structure: Structure, uid: int, robot: int, grippers: Collection[int]) -> bool:
    """Return whether a node belongs to a robot or one of its grippers, and goes with a joint of the robot."""
    moved = False
    for node in structure.ancestors(uid):
        if node.uid == robot:
            return moved
        if node.kind is Kind.ROBOT:
            if node.uid not in grippers:
                return False
            moved = False  # by a joint of the gripper, which stands as it is
        moved = moved or node.is_moved
    return False
