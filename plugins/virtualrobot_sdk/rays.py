"""Interfaces of ray caster and sensor model: from rays in a scene to true hits, and on to a sensor's readings."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from enum import Enum
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from virtualrobot_sdk.kinematics import Floats, Integers

Singles = np.ndarray[Any, np.dtype[np.float32]]
Booleans = np.ndarray[Any, np.dtype[np.bool_]]

NO_ELEMENT = -1
"""Value of `element` for a ray that hits nothing."""


class Round(Enum):
    """Shapes whose surface is curved, all about the origin and along z."""

    SPHERE = "sphere"
    CYLINDER = "cylinder"
    """From -length/2 to length/2, with both discs."""
    CONE = "cone"
    """Its base at -length/2 and its tip at length/2, with the disc."""
    CAPSULE = "capsule"
    """A cylinder of this length without discs, with a half sphere on both ends."""


@dataclass(frozen=True, slots=True)
class Primitive:
    """A curved surface as it is meant, in meters; a sphere has no length."""

    kind: Round
    radius: float
    length: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """The triangles of one element, in its own frame; `make_shape` makes one.

    What a caster prepares for a shape, it keeps by `key`: in a process of its own, no two calls bring the same objects.
    """

    vertices: Singles
    """(v, 3) in meters."""
    triangles: Integers
    """(t, 3) rows of `vertices`, counter-clockwise as seen from outside; one without area is never hit."""
    key: str
    """Names the content: shapes of one key have the same triangles, in every call and process."""
    primitive: Primitive | None = None
    """The curved surface that the triangles stand for; None where they are the surface themselves. A caster that knows
    how meets this one; others meet the triangles."""


def make_shape(vertices: ArrayLike, triangles: ArrayLike, primitive: Primitive | None = None) -> Shape:
    """Return the shape of `triangles` (t, 3), rows of `vertices` (v, 3) in meters; its key is the content's SHA-256."""
    corners, rows = np.ascontiguousarray(vertices, np.float32), np.ascontiguousarray(triangles, np.int32)
    content = len(corners).to_bytes(8, "little") + corners.tobytes() + rows.tobytes() + repr(primitive).encode()
    return Shape(corners, rows, hashlib.sha256(content).hexdigest(), primitive)


@dataclass(frozen=True, slots=True, eq=False)
class RayScene:
    """Scene that rays are cast against: e elements, each a shape at a pose; e may be 0."""

    shapes: tuple[Shape, ...]
    """(e) the shape of each element; several may share one."""
    world_t_element: Floats
    """(e, 4, 4) pose of each element in the world's frame (m)."""


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """First hits of n rays on a surface, from either side of it."""

    distance: Floats
    """(n,) along the ray (m); inf where it meets nothing within the range."""
    element: Integers
    """(n,) row of the element; NO_ELEMENT where it meets nothing."""
    normal: Floats
    """(n, 3) unit normal of the surface in the world's frame, turned to the ray's origin; 0 where it meets nothing."""
    triangle: Integers | None = None
    """(n,) row of the shape's triangles; -1 on a curved surface and where a ray meets nothing. None where the
    caster does not tell."""


class RayCaster(Protocol):
    """Finds what rays hit; any stage of a student's own. One thread calls it."""

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        """Return the first hits of n rays: `origins` (n, 3) in meters, unit `directions` (n, 3), both in the world.

        Nothing farther than `max_range` (m, above 0, may be inf) counts; n may be 0. Arrays may be read-only. Raises
        ArgumentError for other shapes of arrays, for values that are not finite (the scene's poses too), for directions
        that are not of unit length (to 1e-6) and for a range that is not above 0.
        """
        ...


@dataclass(frozen=True, slots=True, eq=False)
class TrueHits:
    """True hits of the k rays of each of a sensor's n beams, as a sensor model gets them."""

    distance: Floats
    """(n, k) in meters; inf where a ray hits nothing within `farthest`."""
    incidence: Floats
    """(n, k) angle between ray and normal (rad), 0 to pi/2; 0 where a ray hits nothing."""
    reflectance: Floats
    """(n, k) part of the light that comes back at normal incidence, 0 to 1; 0 where a ray hits nothing."""
    element: Integers
    """(n, k) row of the element; NO_ELEMENT where a ray hits nothing."""
    nearest: float
    """The least distance that the sensor is set to measure (m), 0 or more."""
    farthest: float
    """The greatest one (m), finite and above `nearest`."""


@dataclass(frozen=True, slots=True, eq=False)
class Readings:
    """Readings of a sensor's n beams."""

    distance: Floats
    """(n,) in meters, 0 or more; where it is not valid, what this sensor says then (inf, 0 or its greatest range)."""
    intensity: Floats
    """(n,) the strength of the echo, 0 to 1."""
    valid: Booleans
    """(n,) true where the sensor trusts the distance."""


class SensorModel(Protocol):
    """Model of a sensor, from true hits to readings: noise, range, quantisation, dropouts. Pure."""

    def beam(self) -> Floats:
        """Return the rays that make up one beam: unit directions (k, 3) in the beam's frame, x along it, z upwards.

        k is at least 1, and the answer the same each time; the first is the one that a beam's element is told of. An
        ideal sensor has one, (1, 0, 0); one whose beam is a cone has as many as it takes to fill it.
        """
        ...

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        """Return the readings; all that is random comes of `rng`, so that equal draws give equal readings.

        `rng` is made anew for each call, of the sensor's seed and the number of the scan: what a call draws in another
        process does not come back. The number of beams may be 0, and another one each time.
        """
        ...
