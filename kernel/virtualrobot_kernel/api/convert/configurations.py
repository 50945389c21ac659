"""Checks of many configurations at once, and their results: messages to values and back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from virtualrobot.v1 import collision_pb2, geometry_pb2

from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.messages.values import array, array_message
from virtualrobot_kernel.motion.orientation import unit
from virtualrobot_kernel.world.change import check_joint_value, joint_limits, single_joint
from virtualrobot_kernel.world.structure import Joint, Kind, Node, Structure


def configuration_rows(
    structure: Structure, messages: Sequence[collision_pb2.RobotConfigurations]
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Return the coordinates (k,) that differ in n configurations, and their values (n, k).

    Raises:
        KernelError: a robot or joint named twice, arrays of a wrong shape, numbers that are not finite.
        UnknownNameError: a robot or joint that there is not.
        LimitError: a position outside its joint's limits.
    """
    if not messages:
        raise KernelError("configurations names no robot; name at least one", field="configurations")
    places: list[int] = []
    columns: list[NDArray[np.float64]] = []
    for at, message in enumerate(messages):
        field = f"configurations[{at}]"
        if message.robot in {other.robot for other in messages[:at]}:
            raise KernelError(
                f"{field} names the robot {message.robot!r} again; give all its joints in one",
                field=f"{field}.robot",
                robot=message.robot,
            )
        own, rows = robot_rows(structure, message, field)
        if columns and len(rows) != len(columns[0]):
            raise KernelError(
                f"{field}.positions has {len(rows)} rows, and that of {messages[0].robot!r} has {len(columns[0])}; "
                "give all robots as many",
                field=f"{field}.positions",
            )
        places.extend(own)
        columns.append(rows)
    return np.array(places, np.int32), np.concatenate(columns, axis=1)


def robot_rows(
    structure: Structure, message: collision_pb2.RobotConfigurations, field: str
) -> tuple[list[int], NDArray[np.float64]]:
    """Return the coordinates (k,) of one robot that differ in n configurations, and their values (n, k).

    Raises as `configuration_rows`, naming `field`.
    """
    robot = structure.node(message.robot, Kind.ROBOT)
    names = _columns(structure, robot, message.joint_names, f"{field}.joint_names")
    rows = array(message.positions, (None, len(names)), f"{field}.positions")
    places = []
    for name, column in zip(names, rows.T, strict=True):
        joint, place, _ = single_joint(structure, robot, name)
        _check_limits(robot.name, joint, column)
        places.append(place)
    for columns in map(list, joint_limits(structure, robot, names).quaternions):
        for number, row in enumerate(rows):
            unit(row[columns], f"{field}.positions[{number}] of {robot.name!r}")
    return places, rows


def block_message(
    structure: Structure, found: NDArray[np.int64]
) -> tuple[geometry_pb2.NumericArray, list[collision_pb2.CollisionPair]]:
    """Return the index of the touching pair in each of m rows, -1 where it is free, and these pairs.

    Args:
        structure: knows the names.
        found: (m, 2) the nodes (uids) of a pair that touches in each row, zeros where it is free.
    """
    pairs, places = np.unique(found, axis=0, return_inverse=True)
    # Uids are above 0: what is free is first.
    free = int(not pairs[0].any())
    touching = array_message(places.reshape(-1) - free, geometry_pb2.NUMERIC_TYPE_INT32)
    names = [[structure.nodes[uid].name for uid in pair] for pair in pairs[free:].tolist()]
    return touching, [collision_pb2.CollisionPair(first=first, second=second) for first, second in names]


def _columns(structure: Structure, robot: Node, names: Sequence[str], field: str) -> Sequence[str]:
    """Return the joints that the columns are."""
    single = [one.name for one in structure.robots[robot.uid].joints if one.type.coordinate_count == 1]
    if not single:
        raise KernelError(f"the robot {robot.name!r} has no joint of one coordinate to move", robot=robot.name)
    if twice := next((name for place, name in enumerate(names) if name in names[:place]), None):
        raise KernelError(f"{field} names {twice!r} twice; give each joint one column", field=field, joint=twice)
    return names or single


def _check_limits(robot: str, joint: Joint, column: NDArray[np.float64]) -> None:
    for row in (int(column.argmin()), int(column.argmax())) if len(column) else ():
        try:
            check_joint_value(robot, joint, float(column[row]))
        except LimitError as error:
            refusal = LimitError(f"in row {row}, {error}", row=row)
            refusal.metadata.update(error.metadata)
            raise refusal from None
