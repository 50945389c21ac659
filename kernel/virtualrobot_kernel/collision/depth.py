"""How deep two convex solids are in each other."""

from __future__ import annotations

from dataclasses import dataclass

import fcl
import numpy as np

from virtualrobot_kernel.collision.nearest import segments_nearest
from virtualrobot_kernel.collision.placed import Placed


@dataclass(frozen=True, slots=True)
class Depth:
    """How far (m) one of two must be moved, in the best direction, until they only touch.

    approximate: found by a search that may end early, not in closed form.
    """

    meters: float
    approximate: bool


def depth_of(placed: Placed, one: int, other: int) -> Depth | None:
    """Return how deep two elements that touch are in each other; None where one is a mesh: a surface has no inside.

    Spheres and capsules in closed form: their Minkowski difference is what is nearer than the sum of the radii to that
    of two segments, which is flat. Boxes and others as FCL has it: by separating axes, or by a search (EPA).
    """
    if placed.whole(one) is None or placed.whole(other) is None:
        return None
    radii = placed.solids[one].radius, placed.solids[other].radius
    if radii[0] and radii[1]:
        first, second = segments_nearest(placed.segment(one), placed.segment(other))
        return Depth(sum(radii) - float(np.linalg.norm(second - first)), False)
    result = fcl.CollisionResult()
    fcl.collide(placed.whole(one), placed.whole(other), fcl.CollisionRequest(8, enable_contact=True), result)
    if not result.contacts:
        return None
    closed = all(isinstance(placed.solids[each].solid, fcl.Box) for each in (one, other))
    return Depth(max(contact.penetration_depth for contact in result.contacts), not closed)
