"""GLB files of figures for the browser: as few as the looks of a figure allow.

Everything opaque without a texture becomes one file, so that a link of many colours costs one batch. Each texture and
each translucent colour needs its own.
"""

from __future__ import annotations

import numpy as np

from virtualrobot_kernel.drawing import glb
from virtualrobot_kernel.shapes.submesh import Submesh, stacked

Rgba = tuple[float, float, float, float]

GREY: Rgba = (0.72, 0.74, 0.77, 1.0)
"""Colour of figures that have none of their own."""


def encode(parts: tuple[Submesh, ...], color: Rgba | None) -> tuple[bytes, ...]:
    """Return GLB files that show all parts, which have normals.

    `color` replaces the parts' own colours, and is a factor on their textures; None keeps them as they are.
    """
    opaque: list[Submesh] = []
    translucent: dict[Rgba, list[Submesh]] = {}
    files = []
    for part in parts:
        main = _color_of(part, color)
        if part.texture is not None and part.uv is not None:
            files.append(_textured(part, color or part.color or (1.0, 1.0, 1.0, 1.0)))
        elif main[3] < 1.0:
            translucent.setdefault(main, []).append(part)
        else:
            opaque.append(part)
    if opaque:
        files.insert(0, _opaque(opaque, color))
    files.extend(_plain(group, main) for main, group in translucent.items())
    return tuple(files)


def _color_of(part: Submesh, color: Rgba | None) -> Rgba:
    """Return the one colour of a part without texture; for one with a colour for each vertex, their mean."""
    if color is not None:
        return color
    if part.vertex_colors is not None:
        red, green, blue, alpha = (part.vertex_colors.mean(axis=0) / 255.0).tolist()
        return red, green, blue, alpha
    return part.color or GREY


def _opaque(parts: list[Submesh], color: Rgba | None) -> bytes:
    mains = [_color_of(part, color) for part in parts]
    if len(set(mains)) == 1 and (color is not None or all(part.vertex_colors is None for part in parts)):
        return _plain(parts, mains[0])
    colors = [
        np.tile(np.asarray(main[:3]), (len(part.vertices), 1))
        if part.vertex_colors is None or color is not None
        else part.vertex_colors[:, :3] / 255.0
        for part, main in zip(parts, mains, strict=True)
    ]
    return glb.encode(*_stacked(parts), vertex_colors=np.concatenate(colors))


def _plain(parts: list[Submesh], color: Rgba) -> bytes:
    return glb.encode(*_stacked(parts), color=color)


def _textured(part: Submesh, factor: Rgba) -> bytes:
    return glb.encode(*_stacked([part]), color=factor, uv=part.uv, texture=part.texture)


def _stacked(parts: list[Submesh]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return vertices, normals and faces of all parts together."""
    vertices, faces = stacked(parts)
    return vertices, np.concatenate([part.normals for part in parts if part.normals is not None]), faces
