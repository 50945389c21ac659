"""Triangles as a Wavefront OBJ file with an MTL file for colours and PNG files for textures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.shapes.submesh import Submesh


def write_obj(parts: Sequence[Submesh], stem: str) -> dict[str, bytes]:
    """Return the files by name, `STEM.obj` first, that show the parts; meters, a group for each part.

    Colours of vertices follow their coordinates, as many programs write and read them.
    """
    beside: dict[str, bytes] = {}
    materials: list[str] = []
    # Parts with colours of their vertices come first, since nothing ends the material of the part before.
    ordered = sorted(parts, key=_has_materials)
    colored = not all(map(_has_materials, parts))
    lines: list[str] = []
    vertices = textures = normals = 0
    for place, part in enumerate(ordered):
        lines.append(f"g part_{place}")
        if _has_materials(part):
            lines.append(f"usemtl material_{place}")
            materials.extend(_material(part, place, stem, beside))
        lines.extend(_vertices(part, colored))
        corners = [part.faces + (vertices + 1)]
        pattern = "{0}"
        if part.texture is not None and part.uv is not None:
            lines.extend(f"vt {u:.9g} {v:.9g}" for u, v in part.uv.tolist())
            corners.append(part.faces + (textures + 1))
            textures += len(part.uv)
            pattern = "{0}/{1}"
        if part.normals is not None:
            lines.extend(f"vn {x:.6g} {y:.6g} {z:.6g}" for x, y, z in part.normals.tolist())
            pattern += f"{'/' * (3 - len(corners))}{{{len(corners)}}}"
            corners.append(part.faces + (normals + 1))
            normals += len(part.normals)
        lines.extend(_faces(pattern, corners))
        vertices += len(part.vertices)
    if materials:
        lines.insert(0, f"mtllib {stem}.mtl")
        beside = {f"{stem}.mtl": _text(materials), **beside}
    return {f"{stem}.obj": _text(lines), **beside}


def _has_materials(part: Submesh) -> bool:
    return part.vertex_colors is None or (part.texture is not None and part.uv is not None)


def _material(part: Submesh, place: int, stem: str, beside: dict[str, bytes]) -> Iterator[str]:
    """Yield the lines of a part's material; its texture goes to the files `beside`."""
    textured = part.texture is not None and part.uv is not None
    red, green, blue, alpha = part.color or ((1.0, 1.0, 1.0, 1.0) if textured else (0.72, 0.74, 0.77, 1.0))
    yield f"newmtl material_{place}"
    yield f"Kd {red:.6g} {green:.6g} {blue:.6g}"
    yield f"d {alpha:.6g}"
    if part.texture is not None and textured:
        name = next((known for known, png in beside.items() if png == part.texture), f"{stem}_{place}.png")
        beside[name] = part.texture
        yield f"map_Kd {name}"


def _vertices(part: Submesh, colored: bool) -> Iterator[str]:
    """Yield the lines of the places, with colours where any part of the file has some."""
    if not colored:
        yield from (f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in part.vertices.tolist())
        return
    own: NDArray = np.ones((len(part.vertices), 3)) if part.vertex_colors is None else part.vertex_colors[:, :3] / 255.0
    for (x, y, z), (red, green, blue) in zip(part.vertices.tolist(), own.tolist(), strict=True):
        yield f"v {x:.9g} {y:.9g} {z:.9g} {red:.6g} {green:.6g} {blue:.6g}"


def _faces(pattern: str, corners: list[NDArray]) -> Iterator[str]:
    """Yield a line for each triangle; `corners` are (m, 3) numbers of places, texture coordinates and normals."""
    for row in np.stack(corners, axis=2).tolist():
        yield "f " + " ".join(pattern.format(*corner) for corner in row)


def _text(lines: Sequence[str]) -> bytes:
    return ("\n".join(lines) + "\n").encode()
