"""Penetration depth of two elements.

FCL's own depths are not used: its search (EPA) was off by up to 0.3 m in 4,000 trials with bodies of that size, and its
depth of two boxes by 5 per cent, since it prefers the axes of faces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.placed import Placed
from virtualrobot_kernel.numeric.penetration import penetration

Floats = NDArray[np.float64]

TOLERANCE = 1e-8
"""Difference of the bounds of a depth (m) at which the search ends by itself."""

EXACT = 1e-6
"""A depth whose bounds are farther apart than this, in meters, is approximate."""

MOST = 32768
WORK = 10_000_000
"""Triangles of directions that are looked at in one go, and those times the corners of both outlines: 0.1 s at most."""


@dataclass(frozen=True, slots=True, eq=False)
class Depth:
    """Penetration depth of two elements.

    Attributes:
        meters: how far the second must be moved until they only touch.
        way: (3,) the unit vector along which, in the world's frame; from the first to the second.
        approximate: whether this is so of convex hulls, or to more than EXACT.
    """

    meters: float
    way: Floats
    approximate: bool


def depth_of(first: Placed, second: Placed, one: int, other: int) -> Depth:
    """Return how deep an element of each set that touch are in each other, with their radii and paddings.

    Of convex ones it is exact, to TOLERANCE; meshes that are not convex count as their hulls, and the depth is
    approximate.
    """
    sides = (first, one), (second, other)
    outlines = [placed.solids[each].outline for placed, each in sides]
    poses = [placed.world_t_element[each] for placed, each in sides]
    origin = poses[0][:3, 3]
    ours, theirs = (outline.placed(pose, origin) for outline, pose in zip(outlines, poses, strict=True))
    thickness = sum(placed.solids[each].radius + placed.padding[each] for placed, each in sides)
    found = np.empty(5)
    most = min(MOST, WORK // max(len(ours[0]) + len(theirs[0]), 1))
    penetration(*ours, *theirs, thickness, TOLERANCE, most, found)
    exact = outlines[0].exact and outlines[1].exact and found[0] - found[1] <= EXACT
    return Depth(max(float(found[0]), 0.0), found[2:], not exact)
