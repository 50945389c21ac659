"""Path of an object that an arm carries along a tool that stands apart from it, and that tool as the object sees it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.motion.cartesian_path import RelatedPath
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.resolved_rate import TcpKinematics


@dataclass(frozen=True, eq=False)
class ApartPath(RelatedPath):
    """Path base_t_object(u) = base_t_tool object_t_tool(u)^-1, with `inner` the path of the tool in the object."""

    kind: ClassVar[str] = "apart"
    noun: ClassVar[str] = "way"

    base_t_tool: Array

    def pose(self, u: float) -> Array:
        """Return base_t_object (4, 4) at the fraction `u`."""
        return self.base_t_tool @ inverse(self.inner.pose(u))

    def twist(self, u: float) -> Array:
        """Return the derivative (6,) of the object's pose by u: m, then rad, base frame, at its origin.

        Of the inverse of a pose (R, p) with twist (v, w) the origin is -Rᵀp, which moves by Rᵀ(w x p - v), and it turns
        by -Rᵀw.
        """
        pose, inner = self.inner.pose(u), self.inner.twist(u)
        turn = self.base_t_tool[:3, :3] @ pose[:3, :3].T
        return np.concatenate([turn @ (np.cross(inner[3:], pose[:3, 3]) - inner[:3]), -turn @ inner[3:]])


@dataclass(frozen=True, eq=False)
class ApartTcp:
    """Tool that stands at base_t_tool (4, 4), as an object sees it that is the tool centre point of `held`.

    name: what both are called, the same for the same tool and object.
    """

    held: TcpKinematics
    base_t_tool: Array
    name: tuple[str, str]

    def position(self, q: Array) -> Array:
        """Return where the tool is in the object (3,), in m."""
        return (inverse(self.held.pose(q)) @ self.base_t_tool)[:3, 3]

    def jacobian(self, q: Array) -> Array:
        """Return how fast the object moves at the tool's place, and turns, by the joints: (6, k), base frame."""
        jacobian = np.array(self.held.jacobian(q))
        lever = self.base_t_tool[:3, 3] - self.held.pose(q)[:3, 3]
        jacobian[:3] += np.cross(jacobian[3:], lever, axis=0)
        return jacobian
