"""What a ray caster and a sensor model are: from rays in a scene to true hits, and on to a sensor's readings."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from virtualrobot_sdk.kinematics import Floats, Integers

Singles = np.ndarray[Any, np.dtype[np.float32]]
Booleans = np.ndarray[Any, np.dtype[np.bool_]]

NO_ELEMENT = -1
"""What `element` says of a ray that hits nothing."""


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


def make_shape(vertices: ArrayLike, triangles: ArrayLike) -> Shape:
    """Return the shape of `triangles` (t, 3), rows of `vertices` (v, 3) in meters; its key is their SHA-256."""
    corners, rows = np.ascontiguousarray(vertices, np.float32), np.ascontiguousarray(triangles, np.int32)
    content = len(corners).to_bytes(8, "little") + corners.tobytes() + rows.tobytes()
    return Shape(corners, rows, hashlib.sha256(content).hexdigest())


@dataclass(frozen=True, slots=True, eq=False)
class RayScene:
    """What rays are cast against: e elements, each a shape at a place; e may be 0."""

    shapes: tuple[Shape, ...]
    """(e) the shape of each element; several may share one."""
    world_t_element: Floats
    """(e, 4, 4) where each element is."""


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """Where n rays first meet a surface, from either side of it."""

    distance: Floats
    """(n,) along the ray (m); inf where it meets nothing within the range."""
    element: Integers
    """(n,) which element; NO_ELEMENT where it meets nothing."""
    normal: Floats
    """(n, 3) unit normal of the surface in the world's frame, turned to the ray's origin; 0 where it meets nothing."""


class RayCaster(Protocol):
    """Finds what rays hit; any stage of a student's own. One thread calls it."""

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        """Return the first hits of n rays: `origins` (n, 3) in meters, unit `directions` (n, 3), both in the world.

        Nothing farther than `max_range` (m, above 0, may be inf) counts; n may be 0. Raises ArgumentError for other
        shapes of arrays, for values that are not finite (the scene's poses too), for directions that are not of unit
        length (to 1e-6) and for a range that is not above 0.
        """
        ...


@dataclass(frozen=True, slots=True, eq=False)
class TrueHits:
    """What a sensor's n rays truly hit, as a sensor model gets it."""

    distance: Floats
    """(n,) in meters; inf where a ray hits nothing."""
    incidence: Floats
    """(n,) angle between ray and normal (rad), 0 to pi/2; 0 where a ray hits nothing."""
    reflectance: Floats
    """(n,) part of the light that comes back at normal incidence, 0 to 1; 0 where a ray hits nothing."""
    element: Integers
    """(n,) which element; NO_ELEMENT where a ray hits nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Readings:
    """What the sensor says of its n rays."""

    distance: Floats
    """(n,) in meters, 0 or more; where it is not valid, what this sensor says then (inf, 0 or its greatest range)."""
    intensity: Floats
    """(n,) the strength of the echo, 0 to 1."""
    valid: Booleans
    """(n,) whether the sensor trusts the distance."""


class SensorModel(Protocol):
    """From true hits to what a given sensor says: noise, range, quantisation, dropouts. Pure."""

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        """Return the readings; all that is random comes of `rng`, so that equal draws give equal readings.

        `rng` is made anew for each call, of the sensor's seed and the number of the scan: what a call draws in another
        process does not come back. The number of hits may be 0, and another one each time.
        """
        ...
