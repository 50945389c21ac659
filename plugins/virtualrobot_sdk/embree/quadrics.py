"""Intersection of a ray with a sphere, cylinder, cone or capsule, in double precision, compiled into what calls it.

Each surface is a quadric cut off along z: the roots of its quadratic equation along the ray are hits where they lie on
the part that counts (A. Glassner, ed., An Introduction to Ray Tracing, 1989, chapter 2).
"""

from __future__ import annotations

import math

from virtualrobot_sdk.compiled.cache import inlined
from virtualrobot_sdk.rays import Primitive, Round

SPHERE, CYLINDER, CONE, CAPSULE = 0.0, 1.0, 2.0, 3.0
FLAT = -1.0
"""Kind of a shape of triangles."""
_KINDS = {Round.SPHERE: SPHERE, Round.CYLINDER: CYLINDER, Round.CONE: CONE, Round.CAPSULE: CAPSULE}
_SEAM = 1.0 + 1e-12
"""Factor by which each part of a surface reaches over its edge, so that no ray slips through between two."""

Surface = tuple[float, float, float]
"""Kind, radius and length, as compiled code takes them."""


def surface_of(primitive: Primitive | None) -> Surface:
    """Return a curved surface as numbers; FLAT and zeros for None."""
    if primitive is None:
        return FLAT, 0.0, 0.0
    return _KINDS[primitive.kind], primitive.radius, primitive.length


@inlined
def _roots(a: float, b: float, c: float) -> tuple[float, float]:
    """Return the roots of a t^2 + 2 b t + c, the smaller first; NaN where there are none.

    Without cancellation, and right for a = 0, where one is infinite (W. Press et al., Numerical Recipes, section 5.6).
    """
    under = b * b - a * c
    if under < 0.0 or (a == 0.0 and b == 0.0):
        return math.nan, math.nan
    q = -(b + math.copysign(math.sqrt(under), b))
    if q == 0.0:
        return 0.0, 0.0
    first = q / a
    second = c / q
    return min(first, second), max(first, second)


@inlined
def nearest(
    kind: float,
    radius: float,
    length: float,
    x: float,
    y: float,
    z: float,
    dx: float,
    dy: float,
    dz: float,
    near: float,
    far: float,
) -> tuple[float, float, float, float]:
    """Return the first t from `near` to `far` at which (x, y, z) + t (dx, dy, dz) is on the surface, and its normal.

    The normal is of unit length and looks outwards; t is inf where there is none.
    """
    # Counted from the point of the line next to the origin, so that no digits are lost on a ray from far away.
    shift = -(x * dx + y * dy + z * dz) / (dx * dx + dy * dy + dz * dz)
    x += shift * dx
    y += shift * dy
    z += shift * dz
    low = near - shift
    best = far - shift
    half = length / 2.0
    part = -1
    across = dx * dx + dy * dy
    around = x * dx + y * dy
    from_axis = x * x + y * y - radius * radius
    if kind == SPHERE:
        for t in _roots(across + dz * dz, around + z * dz, from_axis + z * z):
            if low <= t <= best:
                best = t
                part = 0
    elif kind == CONE:
        slope = radius / length
        for t in _roots(
            across - (slope * dz) ** 2,
            around + slope * slope * (half - z) * dz,
            x * x + y * y - (slope * (half - z)) ** 2,
        ):
            below = half - (z + t * dz)
            if low <= t <= best and (1.0 - _SEAM) * length <= below <= length * _SEAM:
                best = t
                part = 1
    else:
        for t in _roots(across, around, from_axis):
            if low <= t <= best and abs(z + t * dz) <= half * _SEAM:
                best = t
                part = 2
    if kind == CYLINDER or kind == CONE:
        for end in (-half, half):
            if dz != 0.0 and (kind == CYLINDER or end < 0.0):
                t = (end - z) / dz
                if low <= t <= best and (x + t * dx) ** 2 + (y + t * dy) ** 2 <= radius * radius * _SEAM:
                    best = t
                    part = 3 if end < 0.0 else 4
    if kind == CAPSULE:
        for end in (-half, half):
            outwards = math.copysign(1.0, end) if end != 0.0 else 0.0
            for t in _roots(across + dz * dz, around + (z - end) * dz, from_axis + (z - end) ** 2):
                if low <= t <= best and (z + t * dz - end) * outwards >= (1.0 - _SEAM) * radius:
                    best = t
                    part = 5 if end < 0.0 else 6
    if part < 0:
        return math.inf, 0.0, 0.0, 0.0
    x += best * dx
    y += best * dy
    z += best * dz
    if part == 1:
        z = (radius / length) ** 2 * (half - z)
        if x == 0.0 and y == 0.0 and z == 0.0:  # the tip
            z = 1.0
    elif part == 2:
        z = 0.0
    elif part == 3 or part == 4:
        x = 0.0
        y = 0.0
        z = -1.0 if part == 3 else 1.0
    elif part == 5 or part == 6:
        z -= -half if part == 5 else half
    norm = math.sqrt(x * x + y * y + z * z)
    return best + shift, x / norm, y / norm, z / norm
