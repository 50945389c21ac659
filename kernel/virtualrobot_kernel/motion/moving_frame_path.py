"""Path in a frame that moves while it is followed: on a positioner's table, or seen from an arm that is carried."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from virtualrobot_kernel.motion.cartesian_path import RelatedPath
from virtualrobot_kernel.motion.polynomial import Array


@dataclass(frozen=True, eq=False)
class MovingFramePath(RelatedPath):
    """Path base_t_tcp(u) = base_t_frame(u) frame_t_tcp(u), with `inner` the path in the frame.

    frame: from the fraction u to base_t_frame (4, 4) and its derivative by u, a twist (6,) in m and rad, base frame, at
    the frame's origin. turns: fractions where a derivative of the frame's own way jumps.
    """

    kind: ClassVar[str] = "carried"
    noun: ClassVar[str] = "way"

    frame: Callable[[float], tuple[Array, Array]]
    turns: tuple[float, ...]

    @property
    def knots(self) -> tuple[float, ...]:
        """Fractions where a derivative of the path, or of the frame's way, jumps."""
        return tuple(sorted({*self.inner.knots, *self.turns}))

    def pose(self, u: float) -> Array:
        """Return base_t_tcp (4, 4) at the fraction `u`."""
        return self.frame(u)[0] @ self.inner.pose(u)

    def twist(self, u: float) -> Array:
        """Return the derivative (6,) of the pose by u at `u`: m, then rad, base frame, at the TCP."""
        base_t_frame, rate = self.frame(u)
        turn = base_t_frame[:3, :3]
        arm = turn @ self.inner.pose(u)[:3, 3]
        inner = self.inner.twist(u)
        linear = rate[:3] + np.cross(rate[3:], arm) + turn @ inner[:3]
        return np.concatenate([linear, rate[3:] + turn @ inner[3:]])
