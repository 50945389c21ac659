"""Meshes with fewer triangles, which stay within a tolerance of those that they are made of."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from virtualrobot_kernel.numeric.simplifying import simplify
from virtualrobot_kernel.shapes.submesh import Submesh, frozen, merged

ONE_COLOR = 16
"""A picture whose tones are less than this apart from their middle, of 255, counts as one color."""


Tone = tuple[float, float, float]
"""The one color that triangles show of a texture, from 0 to 1: a factor on whatever color they have."""


def coarser(part: Submesh, tolerance: float) -> tuple[Submesh, Tone | None]:
    """Return the submesh with fewer triangles: its surface and the former are nowhere farther apart than `tolerance`.

    Its normals are to be made anew. Where it shows one color of its texture alone, that is returned and the texture
    left out. With a texture of several colors, or colors of its corners, it stays as it is.
    """
    if part.vertex_colors is not None:
        return part, None
    tone = None
    if part.texture is not None and part.uv is not None:
        tone = _one_color(part.texture, part.uv[part.faces])
        if tone is None:
            return part, None
    bare = merged(Submesh(part.vertices, part.faces))
    points, faces = bare.vertices.astype(np.float64), np.array(bare.faces, np.int32)
    faces = faces[: simplify(points, faces, tolerance)]
    if len(faces) == 0:  # nothing but triangles without an area
        return Submesh(part.vertices, part.faces, part.normals, part.color), tone
    rows, places = np.unique(faces, return_inverse=True)
    return Submesh(bare.vertices[rows], frozen(places.reshape(faces.shape), np.int32), color=part.color), tone


def _one_color(png: bytes, corners: NDArray[np.float32]) -> Tone | None:
    """Return the color that triangles show of a picture; None where they show several, or see through.

    `corners` (m, 3, 2) are texture coordinates.
    """
    if not np.isfinite(corners).all() or corners.min() < 0.0 or corners.max() > 1.0:
        return None
    with Image.open(io.BytesIO(png)) as image:
        size = np.array(image.size)
        places = corners * [1.0, -1.0] * size + [-0.5, size[1] - 0.5]
        least = np.clip(np.floor(places.min(axis=1)), 0, size - 1).astype(int)
        most = np.clip(np.ceil(places.max(axis=1)), 0, size - 1).astype(int)
        first, last = least.min(axis=0), most.max(axis=0) + 1
        pixels = np.asarray(image.crop((*first.tolist(), *last.tolist())).convert("RGBA"))
    least, most = least - first, most - first + 1
    # Rectangles about the triangles as marks at their corners, whose sums count how many cover a pixel.
    marks = np.zeros((pixels.shape[0] + 1, pixels.shape[1] + 1), np.int32)
    for columns, rows, sign in (
        (least[:, 0], least[:, 1], 1),
        (most[:, 0], most[:, 1], 1),
        (least[:, 0], most[:, 1], -1),
        (most[:, 0], least[:, 1], -1),
    ):
        np.add.at(marks, (rows, columns), sign)
    shown = pixels[marks.cumsum(axis=0).cumsum(axis=1)[:-1, :-1] > 0]
    lowest, highest = shown.min(axis=0).astype(float), shown.max(axis=0).astype(float)
    if (highest - lowest).max() > 2 * ONE_COLOR or lowest[3] < 255.0:
        return None
    red, green, blue = ((lowest + highest)[:3] / 510.0).tolist()
    return red, green, blue
