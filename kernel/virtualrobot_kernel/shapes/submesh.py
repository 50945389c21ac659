"""Triangles with one look: what every mesh format is read into."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.world.figures import Mesh


@dataclass(frozen=True, slots=True, eq=False)
class Submesh:
    """Triangles of a mesh file that share one look; arrays are read-only and may be shared between threads.

    Attributes:
        vertices: (n, 3) float32, meters, in the frame of the figure (node transforms, unit and scale applied).
        faces: (m, 3) int32, rows of `vertices`, counter-clockwise seen from outside (as the file has them; a mirroring
            scale has been made up for).
        normals: (n, 3) float32 unit vectors, or None where the file gives none.
        color: red, green, blue, alpha from 0 to 1, or None where the file tells none.
        vertex_colors: (n, 4) uint8 red, green, blue, alpha, or None.
        uv: (n, 2) float32 texture coordinates, origin at the image's lower left corner, or None.
        texture: the image as PNG bytes, or None; drawn with `color` as a factor.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    normals: NDArray[np.float32] | None = None
    color: tuple[float, float, float, float] | None = None
    vertex_colors: NDArray[np.uint8] | None = None
    uv: NDArray[np.float32] | None = None
    texture: bytes | None = None

    @property
    def size_bytes(self) -> int:
        """Return how much memory the arrays and the texture take."""
        arrays = (self.vertices, self.faces, self.normals, self.vertex_colors, self.uv)
        return sum(array.nbytes for array in arrays if array is not None) + len(self.texture or b"")


Meshes = Callable[[Mesh], tuple[Submesh, ...]]
"""Gives the triangles of a mesh, in the frame of its figure."""


def stacked(parts: Sequence[Submesh]) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Return the vertices (n, 3) of all parts together, and their faces (m, 3) as rows of these."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, starts[:-1], strict=True)]
    return (
        np.concatenate([np.zeros((0, 3), np.float32), *(part.vertices for part in parts)]),
        np.concatenate([np.zeros((0, 3), np.int32), *faces]).astype(np.int32),
    )


def transformed(submesh: Submesh, linear: NDArray[np.float64], shift: NDArray[np.float64] | None = None) -> Submesh:
    """Return the submesh under x -> linear @ x + shift; `linear` (3, 3) may scale and mirror but not be singular.

    Where it mirrors, the corners of each face change their order, so that outside stays outside.
    """
    vertices = submesh.vertices.astype(np.float64) @ linear.T
    if shift is not None:
        vertices += shift
    normals = submesh.normals
    if normals is not None:
        normals = frozen(_unit(normals @ np.linalg.inv(linear)), np.float32)
    faces = submesh.faces if np.linalg.det(linear) > 0.0 else frozen(submesh.faces[:, ::-1], np.int32)
    return Submesh(
        frozen(vertices, np.float32),
        faces,
        normals,
        submesh.color,
        submesh.vertex_colors,
        submesh.uv,
        submesh.texture,
    )


def merged(submesh: Submesh) -> Submesh:
    """Return the submesh with vertices that agree in every value made one: STL and COLLADA repeat each corner.

    The order of faces stays, and so does the order of the corners in each.
    """
    columns = [submesh.vertices + np.float32(0.0)]  # turns -0.0 into 0.0
    columns += [array + np.float32(0.0) for array in (submesh.normals, submesh.uv) if array is not None]
    if submesh.vertex_colors is not None:
        columns.append(submesh.vertex_colors.astype(np.float32))
    rows = np.ascontiguousarray(np.hstack(columns))
    if _all_differ(rows):
        return submesh
    keys = rows.view(np.dtype((np.void, rows.dtype.itemsize * rows.shape[1]))).ravel()
    _, first, place = np.unique(keys, return_index=True, return_inverse=True)
    if len(first) == len(keys):
        return submesh

    def pick(array: NDArray | None) -> NDArray | None:
        return None if array is None else frozen(array[first], array.dtype)

    return Submesh(
        frozen(submesh.vertices[first], np.float32),
        frozen(place.reshape(-1)[submesh.faces], np.int32),
        pick(submesh.normals),
        submesh.color,
        pick(submesh.vertex_colors),
        pick(submesh.uv),
        submesh.texture,
    )


def _all_differ(rows: NDArray[np.float32]) -> bool:
    """Return whether (n, k) rows certainly differ from one another: none has the hash of another one.

    The hash is a sum of words times odd numbers, modulo 2^64 (Knuth, The Art of Computer Programming 3, section 6.4).
    """
    factors = np.uint64(0x9E3779B97F4A7C15) ** np.arange(1, rows.shape[1] + 1, dtype=np.uint64)
    hashes = np.sort(rows.view(np.uint32).astype(np.uint64) @ factors)
    return not (hashes[1:] == hashes[:-1]).any()


def frozen(array: NDArray, dtype: type | np.dtype) -> NDArray:
    """Return a C-ordered, read-only copy (or the array itself where it is all that) of this type."""
    result = np.ascontiguousarray(array, dtype)
    if result.flags.writeable:
        result = result.copy() if result is array or result.base is not None else result
        result.setflags(write=False)
    return result


def _unit(vectors: NDArray) -> NDArray:
    """Return rows of length 1; a row of zeros stays."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)
