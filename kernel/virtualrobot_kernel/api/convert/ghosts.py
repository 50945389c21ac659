"""Ghosts of the view: messages to frozen settings and back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from virtualrobot.v1 import collision_pb2, view_pb2

from virtualrobot_kernel.api.convert.configurations import robot_rows
from virtualrobot_kernel.drawing.ghosts import is_there
from virtualrobot_kernel.drawing.view import GHOST_COLOR, GHOST_OPACITY, Ghost, check_ghost_count
from virtualrobot_kernel.messages.values import array_message, color, color_message
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Structure


def ghosts(messages: Sequence[view_pb2.Ghost], snapshot: Snapshot) -> tuple[Ghost, ...]:
    """Return ghosts with all coordinates of their robots; those that no message names are as in the snapshot.

    Raises:
        KernelError: a joint named twice, an array of a wrong shape, numbers that are not finite, too many rows.
        UnknownNameError: a robot or joint that there is not.
        LimitError: a position outside its joint's limits.
    """
    check_ghost_count(sum(one.configurations.positions.shape[0] for one in messages if _is_table(one)))
    return tuple(_ghost(one, snapshot) for one in messages)


def ghost_messages(shown: Sequence[Ghost], structure: Structure) -> list[view_pb2.Ghost]:
    """Return ghosts as messages; those of robots that are gone are left out."""
    return [_message(one, structure) for one in shown if is_there(structure, one)]


def _is_table(message: view_pb2.Ghost) -> bool:
    return len(message.configurations.positions.shape) == 2


def _ghost(message: view_pb2.Ghost, snapshot: Snapshot) -> Ghost:
    what, structure = f"ghosts[{message.name!r}]", snapshot.structure
    places, rows = robot_rows(structure, message.configurations, f"{what}.configurations")
    node, robot = structure.robot(message.configurations.robot)
    everything = np.tile(snapshot.state.q, (len(rows), 1))
    everything[:, places] = rows
    red, green, blue = color(message.color, f"{what}.color")[:3] if message.HasField("color") else GHOST_COLOR
    return Ghost(
        message.name,
        node.uid,
        tuple(map(tuple, everything[:, robot.q_slice].tolist())),
        (red, green, blue),
        message.opacity if message.HasField("opacity") else GHOST_OPACITY,
    )


def _message(ghost: Ghost, structure: Structure) -> view_pb2.Ghost:
    robot = structure.robots[ghost.robot]
    joints = zip(robot.joints, robot.q_start, strict=True)
    columns = [start - robot.q_slice.start for joint, start in joints if joint.type.coordinate_count == 1]
    configurations = collision_pb2.RobotConfigurations(
        robot=structure.nodes[ghost.robot].name, positions=array_message(np.array(ghost.rows)[:, columns])
    )
    return view_pb2.Ghost(
        name=ghost.name, configurations=configurations, color=color_message((*ghost.color, 1.0)), opacity=ghost.opacity
    )
