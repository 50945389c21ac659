"""Correction at the tool: joint speeds of an arm that keep its tool in place while the vehicle below it moves.

Resolved motion rate control (D. E. Whitney, 1969) of an arm on a moving base (G. Antonelli, Underwater Robots, chapter
6): J q' = K e - V, where e is the error of the tool's pose and V the tool's velocity by the vehicle's movement alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot.geometry import rotation_vector_of

Floats = NDArray[np.float64]


def apart(world_t_a: Floats, world_t_b: Floats) -> Floats:
    """Return the way (3,) and the rotation vector (3,) from one pose to another, along the world's axes (m, rad)."""
    turn = rotation_vector_of(world_t_b[:3, :3] @ world_t_a[:3, :3].T)
    return np.concatenate([world_t_b[:3, 3] - world_t_a[:3, 3], turn])


def carried_along(position: Floats, origin: Floats, velocity: Floats, turning: Floats) -> Floats:
    """Return the velocity (6,) of a point of a vehicle: at `position`, its origin going by `velocity` and `turning`.

    All are along the world's axes, in m, m/s and rad/s.
    """
    return np.concatenate([velocity + np.cross(turning, position - origin), turning])


@dataclass(frozen=True, eq=False)
class ToolKeeper:
    """Law by which an arm of k joints keeps its tool; `limits` (k,) are the greatest speeds of the joints.

    `gain` (1/s) is the rate at which an error goes. `damping` (m, rad) keeps speeds finite near singular postures
    (C. W. Wampler, 1986), where it lets errors stand.
    """

    limits: Floats
    gain: float = 5.0
    damping: float = 0.01

    def rates(self, jacobian: Floats, error: Floats, along: Floats) -> Floats:
        """Return joint speeds (k,); where one is beyond its limit all are slower in proportion.

        `jacobian` (6, k) is that of the tool with the base at rest, `error` (6,) from where the tool is to where it
        should be, and `along` (6,) its velocity by the vehicle's movement, all along the world's axes.
        """
        wanted = self.gain * error - along
        square = jacobian @ jacobian.T + self.damping**2 * np.eye(6)
        rates = jacobian.T @ np.linalg.solve(square, wanted)
        return rates / max(1.0, float(np.max(np.abs(rates) / self.limits)))
