"""Appearance of surfaces: colours, textures and smooth normals of elements, in arrays that compiled code reads."""

from __future__ import annotations

import logging
import threading
from dataclasses import dataclass
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.srgb import to_linear

from virtualrobot_kernel.sensing.coats import CoatMesh, Coats
from virtualrobot_kernel.sensing.elements import Elements
from virtualrobot_kernel.sensing.textures import levels
from virtualrobot_kernel.shapes.creases import shaded
from virtualrobot_kernel.shapes.submesh import Meshes, Submesh
from virtualrobot_kernel.world.figures import Geometry, Mesh, meshes_of

log = logging.getLogger(__name__)

GREY = (0.72, 0.74, 0.77, 1.0)
"""Colour of figures that have none of their own, as in the viewer."""
WHITE = (1.0, 1.0, 1.0, 1.0)


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class Surface:
    """The looks of one mesh: f triangles in the order of its shape, v corners, p parts.

    Attributes:
        faces: (f, 3) rows of the arrays of corners.
        part: (f,) the part of each triangle.
        texel: (f,) the edge of a pixel of its texture on the surface, in meters; 0 without texture.
        normals: (v, 3) unit vectors.
        colors: (v, 4) sRGB and opacity; (0, 4) where no part has colours of its corners.
        uv: (v, 2) places in the texture; (0, 2) where there is none.
        part_colors: (p, 4) linear light and opacity; of textures a factor.
        part_looks: (p, 2) which of `textures` a part has (-1: none), and whether its corners have colours.
        textures: each the levels of one texture, the largest first.
    """

    faces: NDArray[np.int32]
    part: NDArray[np.int32]
    texel: NDArray[np.float32]
    normals: NDArray[np.float32]
    colors: NDArray[np.uint8]
    uv: NDArray[np.float32]
    part_colors: NDArray[np.float32]
    part_looks: NDArray[np.int32]
    textures: tuple[tuple[NDArray[np.uint8], ...], ...]


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class Surfaces:
    """Surfaces one behind the other; the last three tables are of levels of textures.

    Attributes:
        faces: (f, 3), see `Surface`; rows count from each surface's own first corner.
        part: (f,) counts from each surface's own first part.
        texel: (f,)
        normals: (v, 3)
        colors: (v, 4), or (0, 4) where no surface has any.
        uv: (v, 2), or (0, 2) where no surface has any.
        part_colors: (p, 4)
        part_looks: (p, 2), the texture being a row of `textures`.
        textures: (t, 2) the first row of `levels`, and how many there are.
        levels: (l, 3) where a level begins in `texels`, its width, its height.
        texels: (x, 4) sRGB and opacity.
        starts: the first triangle, corner and part of each mesh that could be read.
        made: the surfaces of those meshes.
    """

    faces: NDArray[np.int32]
    part: NDArray[np.int32]
    texel: NDArray[np.float32]
    normals: NDArray[np.float32]
    colors: NDArray[np.uint8]
    uv: NDArray[np.float32]
    part_colors: NDArray[np.float32]
    part_looks: NDArray[np.int32]
    textures: NDArray[np.int64]
    levels: NDArray[np.int64]
    texels: NDArray[np.uint8]
    starts: dict[Mesh, tuple[int, int, int]]
    made: dict[Mesh, Surface]

    @property
    def tables(self) -> tuple[NDArray, ...]:
        """Return all arrays in the order above, as `numeric.shading` takes them."""
        return (
            *(self.faces, self.part, self.texel, self.normals, self.colors, self.uv, self.part_colors),
            *(self.part_looks, self.textures, self.levels, self.texels),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Appearances:
    """Appearance of e elements.

    Attributes:
        colors: (e, 4) linear light and opacity: of a figure that says its colour, or has none at all.
        starts: (e, 4) first triangle, corner and part in `surfaces`, -1 where there is none; whether `colors` counts.
        surfaces: the tables of all meshes.
    """

    colors: NDArray[np.float32]
    starts: NDArray[np.int64]
    surfaces: Surfaces


class AppearanceLibrary:
    """Surfaces of meshes, kept for as long as anybody uses them; any thread may ask.

    Two threads that ask for the same new one at once both make it.

    Attributes:
        coats: what lies on nodes besides.
    """

    def __init__(self, meshes: Meshes, coats: Coats | None = None) -> None:
        """Take the triangles of meshes from `meshes`."""
        self._meshes = meshes
        self.coats = coats or Coats()
        self._lock = threading.Lock()
        self._made: WeakValueDictionary[Mesh, Surface] = WeakValueDictionary()
        self._joined: WeakValueDictionary[frozenset[Mesh], Surfaces] = WeakValueDictionary()

    def of(self, elements: Elements) -> Appearances:
        """Return what elements look like; a mesh that cannot be read looks grey, as nothing is there to be seen."""
        surfaces = self._surfaces(frozenset(meshes_of(elements.figures)))
        count = len(elements.figures)
        colors, starts = np.empty((count, 4)), np.empty((count, 4), np.int64)
        for row, figure in enumerate(elements.figures):
            own = figure.material.color if figure.material else None
            starts[row] = self._start(figure.geometry, len(elements.shapes[row].triangles), surfaces, own is not None)
            colors[row] = own or GREY
        return Appearances(linear(colors), starts, surfaces)

    @staticmethod
    def _start(geometry: Geometry, triangles: int, surfaces: Surfaces, has_color: bool) -> tuple[int, int, int, bool]:
        """Return a row of `Appearances.starts`."""
        surface = surfaces.made.get(geometry) if isinstance(geometry, Mesh) else None
        # A file that an importer translates otherwise the second time would have triangles without a look.
        if surface is None or len(surface.faces) != triangles or not isinstance(geometry, Mesh):
            return -1, -1, -1, True
        return *surfaces.starts[geometry], has_color

    def _surfaces(self, meshes: frozenset[Mesh]) -> Surfaces:
        """Return the tables of these meshes: those that are there, where they are."""
        with self._lock:
            joined = self._joined.get(meshes)
        if joined is not None:
            return joined
        found = {mesh: self._surface(mesh) for mesh in meshes}
        made = {mesh: surface for mesh, surface in found.items() if surface is not None}
        joined = join(made)
        with self._lock:
            self._joined[meshes] = joined
            self._made.update(made)
        return joined

    def _surface(self, mesh: Mesh) -> Surface | None:
        with self._lock:
            surface = self._made.get(mesh)
        if surface is not None:
            return surface
        if isinstance(mesh, CoatMesh) and mesh.part is not None:
            return surface_of((mesh.part,))
        try:
            return surface_of(self._meshes(mesh))
        except Exception:  # a mesh that cannot be read must not blind all cameras
            log.exception("mesh %s is not seen by cameras", mesh.uri)
            return None


def linear(colors: NDArray) -> NDArray[np.float32]:
    """Return (n, 4) sRGB and opacity as linear light and opacity."""
    return np.concatenate([to_linear(colors[:, :3]), colors[:, 3:]], axis=1).astype(np.float32)


def surface_of(parts: tuple[Submesh, ...]) -> Surface:
    """Return the looks of a mesh; a texture that is no picture is left out."""
    smooth = [shaded(part) for part in parts]
    first = np.cumsum([0, *(len(part.vertices) for part in smooth)]).tolist()
    corners = first.pop()
    has_colors = any(part.vertex_colors is not None for part in smooth)
    colors = np.full((corners if has_colors else 0, 4), 255, np.uint8)
    textures = [_levels(part) for part in smooth]
    uv = np.zeros((corners if any(textures) else 0, 2), np.float32)
    found: list[tuple[NDArray[np.uint8], ...]] = []
    looks = np.full((len(smooth), 2), -1, np.int32)
    texel = []
    for place, (part, texture, start) in enumerate(zip(smooth, textures, first, strict=True)):
        end = start + len(part.vertices)
        if part.vertex_colors is not None:
            colors[start:end] = part.vertex_colors
        looks[place, 1] = part.vertex_colors is not None
        texel.append(np.zeros(len(part.faces), np.float32))
        if texture and part.uv is not None:
            uv[start:end] = part.uv
            looks[place, 0] = len(found)
            found.append(texture)
            texel[-1] = _texel(part, texture[0])
    return Surface(
        faces=np.concatenate([part.faces + start for part, start in zip(smooth, first, strict=True)]).astype(np.int32),
        part=np.repeat(np.arange(len(smooth), dtype=np.int32), [len(part.faces) for part in smooth]),
        texel=np.concatenate(texel),
        normals=np.concatenate([part.normals for part in smooth if part.normals is not None]).astype(np.float32),
        colors=colors,
        uv=uv,
        part_colors=linear(
            np.array(
                [part.color or (WHITE if texture else GREY) for part, texture in zip(smooth, textures, strict=True)]
            )
        ),
        part_looks=looks,
        textures=tuple(found),
    )


def join(made: dict[Mesh, Surface]) -> Surfaces:
    """Return surfaces one behind the other."""
    starts: dict[Mesh, tuple[int, int, int]] = {}
    face = corner = part = texel = 0
    looks, textures, levels, texels = [], [], [], []
    has_colors = any(len(one.colors) for one in made.values())
    has_uv = any(len(one.uv) for one in made.values())
    for mesh, one in made.items():
        starts[mesh] = face, corner, part
        face, corner, part = face + len(one.faces), corner + len(one.normals), part + len(one.part_looks)
        look = one.part_looks.copy()
        look[:, 0] += np.where(look[:, 0] >= 0, len(textures), 0)
        looks.append(look)
        for texture in one.textures:
            textures.append((len(levels), len(texture)))
            for level in texture:
                levels.append((texel, level.shape[1], level.shape[0]))
                texels.append(level.reshape(-1, 4))
                texel += len(texels[-1])
    surfaces = list(made.values())

    def stacked(name: str, shape: tuple[int, ...], kind: type, wanted: bool = True) -> NDArray:
        arrays = [np.zeros((0, *shape), kind)]
        for one in surfaces if wanted else ():
            own = getattr(one, name)
            arrays.append(
                own if len(own) or name not in ("colors", "uv") else np.zeros((len(one.normals), *shape), kind)
            )
        return np.concatenate(arrays)

    return Surfaces(
        faces=stacked("faces", (3,), np.int32),
        part=stacked("part", (), np.int32),
        texel=stacked("texel", (), np.float32),
        normals=stacked("normals", (3,), np.float32),
        colors=stacked("colors", (4,), np.uint8, has_colors),
        uv=stacked("uv", (2,), np.float32, has_uv),
        part_colors=stacked("part_colors", (4,), np.float32),
        part_looks=np.concatenate([np.zeros((0, 2), np.int32), *looks]),
        textures=np.array(textures, np.int64).reshape(-1, 2),
        levels=np.array(levels, np.int64).reshape(-1, 3),
        texels=np.concatenate([np.zeros((0, 4), np.uint8), *texels]),
        starts=starts,
        made=made,
    )


def _levels(part: Submesh) -> tuple[NDArray[np.uint8], ...]:
    """Return the levels of a part's texture, none where it has none."""
    if part.texture is None or part.uv is None:
        return ()
    try:
        return levels(part.texture)
    except Exception:  # PIL raises of many classes, and a part without its texture is better than none
        log.warning("a texture is no picture; cameras see the part without it", exc_info=True)
        return ()


def _texel(part: Submesh, texture: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return (f,) the edge of a pixel of the texture on each triangle, in meters."""
    assert part.uv is not None  # asked of textured parts only
    corners, places = part.vertices[part.faces], part.uv[part.faces] * np.array(texture.shape[1::-1], np.float32)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    a, b = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
    pixels = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    return np.sqrt(area / np.maximum(pixels, 1e-12)).astype(np.float32)
