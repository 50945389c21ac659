"""Figures of nodes: frozen primitives, meshes and annotations.

Lengths in meters, angles in radians. A figure's pose `node_t_figure` is a read-only 4x4 array. Geometry compares and
hashes by value, so that a worker builds a native object once for each geometry it has never seen.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Pose = NDArray[np.float64]
"""Rigid transform `parent_t_child` as a (4, 4) float64 array."""


def identity() -> Pose:
    """Return a read-only identity pose, shape (4, 4)."""
    pose = np.eye(4)
    pose.setflags(write=False)
    return pose


@dataclass(frozen=True, slots=True)
class Box:
    """Box about the origin; `size` holds the edge lengths."""

    size: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Sphere:
    """Sphere about the origin."""

    radius: float


@dataclass(frozen=True, slots=True)
class Cylinder:
    """Cylinder about the origin, along z."""

    radius: float
    length: float


@dataclass(frozen=True, slots=True)
class Cone:
    """Cone along z, its base at -length/2 and its tip at +length/2."""

    radius: float
    length: float


@dataclass(frozen=True, slots=True)
class Capsule:
    """Cylinder of `length` along z about the origin, with half spheres on both ends."""

    radius: float
    length: float


FEWEST_HULL_VERTICES = 4
MOST_HULL_VERTICES = 256
"""Greatest number of a hull's vertices: its 508 triangles are one piece for FCL, which is quick to make and to ask."""


@dataclass(frozen=True, slots=True)
class Mesh:
    """Triangles from a file that the asset store holds.

    `uri` says where the file came from and its ending the format; `files` are (uri, sha256) of the files it names.
    `collision_hull_vertices` says as what it collides: 0 as its triangles, else as its convex hull with at most so many
    corners.
    """

    uri: str
    sha256: str
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    files: tuple[tuple[str, str], ...] = ()
    collision_hull_vertices: int = 0

    @property
    def all_files(self) -> tuple[tuple[str, str], ...]:
        """Return (uri, sha256) of its own file and of those that it names."""
        return (self.uri, self.sha256), *self.files


@dataclass(frozen=True, slots=True)
class Points:
    """Points: `positions` holds the bytes of a float64 (n, 3) array in C order, `colors` of a uint8 (n, 3) or none."""

    positions: bytes
    colors: bytes = b""
    size: float = 0.01


@dataclass(frozen=True, slots=True)
class Lines:
    """Line segments: `segments` are the bytes of a C-ordered float64 (n, 2, 3) array; `width` is in pixels."""

    segments: bytes
    width: float = 2.0


@dataclass(frozen=True, slots=True)
class Frame:
    """Three arrows at the origin: x red, y green, z blue."""

    length: float = 0.1


@dataclass(frozen=True, slots=True)
class Label:
    """Words at the origin."""

    text: str


Geometry = Box | Sphere | Cylinder | Cone | Capsule | Mesh | Points | Lines | Frame | Label


@dataclass(frozen=True, slots=True)
class Material:
    """Material of a figure: colour (red, green, blue, alpha from 0 to 1), reflectance, and how it is touched by forces.

    friction: of sliding. restitution: speed after a normal impact as a part of that before, 0 to 1. rolling_friction,
    spinning_friction: torque against rolling, and against spinning about the normal, per normal force (m). stiffness
    (N/m) and damping (N s/m) of a contact; a stiffness of 0 means as stiff as the engine likes. roughness, metalness:
    of the surface as glTF has them, 0 to 1.
    """

    color: tuple[float, float, float, float] | None = None
    reflectance: float = 0.5
    friction: float = 0.5
    restitution: float = 0.0
    rolling_friction: float = 0.0
    spinning_friction: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    roughness: float = 0.62
    metalness: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Figure:
    """One shape of a node; `tool_state` names the only state of its tool in which it shows (empty: always)."""

    geometry: Geometry
    node_t_figure: Pose = field(default_factory=identity)
    material: Material | None = None
    visual: bool = True
    collision: bool = True
    tool_state: str = ""


def meshes_of(figures: Iterable[Figure]) -> Iterator[Mesh]:
    """Yield the geometries of figures that are meshes."""
    return (figure.geometry for figure in figures if isinstance(figure.geometry, Mesh))
