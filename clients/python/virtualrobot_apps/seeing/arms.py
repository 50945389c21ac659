"""Arms that see and act: postures that reach poses and touch nothing, and a range sensor that an arm carries."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError

Floats = NDArray[np.float64]
Posture = dict[str, float]
"""Joint positions (rad or m) by joint."""

VIEW_T_SENSOR = np.array([[0.0, -1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""Pose (4, 4) of a range sensor, which looks along x, in the frame of a view, which does along z."""


def postures(client: Client, robot: str, world_t_tcps: Iterable[Floats]) -> list[Posture | None]:
    """Return for each pose (4, 4) of the tool centre point the nearest posture that touches nothing; None: none."""
    arm, rows, of, names = client.robot(robot), list[Floats](), list[int](), ()
    found: list[Posture | None] = []
    for number, pose in enumerate(world_t_tcps):
        solved = arm.solve_inverse(pose)
        names = solved.joint_names
        rows += list(solved.solutions)
        of += [number] * len(solved.solutions)
        found.append(None)
    if not rows:
        return found
    free = client.collisions.check_configurations(robot, np.array(rows), joint_names=names).free
    for row, number, clear in zip(rows, of, free, strict=True):
        if clear and found[number] is None:
            found[number] = dict(zip(names, row.tolist(), strict=True))
    return found


class Eye:
    """Range sensor of two or three dimensions that an arm carries."""

    def __init__(self, client: Client, robot: str, sensor: str) -> None:
        """Take an arm and its sensor, as it is mounted now."""
        self._client, self._robot, self._sensor = client, robot, sensor
        self._tcp_t_sensor = np.linalg.inv(client.robot(robot).tcp) @ client.scene.pose(sensor)

    def postures(self, world_t_views: Floats) -> list[Posture | None]:
        """Return postures with which the sensor has views (n, 4, 4), which look along z; None: it can't have that one.

        The sensor may be turned about its view by quarters.
        """
        turns = np.tile(np.eye(4), (4, 1, 1))
        turns[:, :2, :2] = [((1, 0), (0, 1)), ((0, -1), (1, 0)), ((-1, 0), (0, -1)), ((0, 1), (-1, 0))]
        tcps = world_t_views[:, None] @ turns @ VIEW_T_SENSOR @ np.linalg.inv(self._tcp_t_sensor)
        found = iter(postures(self._client, self._robot, tcps.reshape(-1, 4, 4)))
        return [next(filter(None, [next(found) for _ in turns]), None) for _ in world_t_views]

    def look(self, posture: Mapping[str, float] | None = None) -> tuple[Floats, Floats]:
        """Go to a posture and measure; return the sensor's place (3,) and its echoes (n, 3).

        Those of the arm itself and its tools are left out. In a stepped clock, time goes on until the arm is there.

        Raises:
            InvalidArgumentError: for a sensor that isn't one of ranges.
        """
        if posture is not None:
            motion = self._client.robot(self._robot).move_joints(posture, wait=False)
            if self._client.clock.read().mode == "stepped":
                self._client.clock.run(motion)
            else:
                motion.wait()
        reading = self._client.sensors[self._sensor].read(points=True, elements=True, frame="world")
        said = reading.range
        if said.points is None or said.elements is None:
            raise InvalidArgumentError(f"{self._sensor!r} tells no points")
        mine = tuple(f"{name}." for name in (self._robot, *self._client.robot(self._robot).tools))
        own = np.array([f"{name}.".startswith(mine) for name in said.element_names] + [False])
        counts = said.valid & ~own[said.elements]
        return reading.world_t_sensor[:3, 3], said.points[counts].astype(np.float64)
