"""OBJ files as most are, without trimesh's parser, in a tenth of its time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import trimesh
from trimesh.exchange.obj import parse_mtl
from trimesh.resolvers import Resolver
from trimesh.visual.material import SimpleMaterial
from trimesh.visual.texture import TextureVisuals

from virtualrobot_kernel.numeric.wavefront import NONE, Integers, Places, read_faces, weld

_LINE_ENDS = ("\x85".encode(), "\u2028".encode(), "\u2029".encode())
"""Ends of lines for Python besides those of ASCII."""


def read(data: bytes, files: Resolver) -> list[trimesh.Trimesh] | None:
    """Return the meshes of a file, one for each material, the last one first, as trimesh has them.

    None for a file that says what is read by trimesh alone, or what is wrong. Vertices are in the order of their first
    use, triangles in that of the file, polygons as fans; trimesh has other orders.
    """
    if not _is_plain(data):
        return None
    is_all, vertices, uvs, normals, corners, uses = read_faces(np.frombuffer(data, np.uint8))
    if not is_all:
        return None
    materials = _materials(data, files)
    meshes = []
    for name, own in _by_material(data, corners, uses):
        # As trimesh does: what one corner lacks is nothing to the others.
        has_uv, has_normals = (bool(own[:, column].min() > NONE) for column in (1, 2))
        rows, place = weld(own if has_uv and has_normals else own * np.array([True, has_uv, has_normals], np.int32))
        uv = uvs[rows[:, 1], :2] if has_uv else None
        visual: Any = None
        if name in materials:
            visual = TextureVisuals(uv=uv, material=materials[name])
        elif uv is not None:
            visual = TextureVisuals(uv=uv)
        mesh = trimesh.Trimesh(
            vertices[rows[:, 0]],
            place.reshape(-1, 3),
            vertex_normals=normals[rows[:, 2]] if has_normals else None,
            visual=visual,
            process=False,
        )
        meshes.append(mesh)
    return meshes[::-1]


def _is_plain(data: bytes) -> bool:
    """Return whether a file is text in ASCII or UTF-8 whose lines end as those of ASCII do."""
    if data.isascii():
        return True
    try:
        data.decode()
    except UnicodeDecodeError:
        return False  # trimesh guesses which encoding it is
    return not any(end in data for end in _LINE_ENDS)


def _by_material(data: bytes, corners: Integers, uses: Places) -> Iterator[tuple[str | None, Integers]]:
    """Yield the name of each material, None before the first, and the corners (3 f, 3) of its triangles."""
    changes = uses[:, 0].tolist()
    names = [None, *(data[begin:end].partition(b"usemtl")[2].decode().strip() for _, begin, end in uses.tolist())]
    found: dict[str | None, list[Integers]] = {}
    for name, begin, end in zip(names, [0, *changes], [*changes, len(corners)], strict=True):
        if end > begin:
            found.setdefault(name, []).append(corners[begin:end])
    for name, pieces in found.items():
        yield name, np.concatenate(pieces)


def _materials(data: bytes, files: Resolver) -> dict[str, SimpleMaterial]:
    """Return the materials of the first file of materials that is named, by name; none of one that can't be read."""
    begin = data.find(b"mtllib") + len(b"mtllib")
    if begin < len(b"mtllib"):
        return {}
    end = data.find(b"\n", begin)
    try:
        told = parse_mtl(files.get(data[begin : end if end >= 0 else None].decode().strip()), resolver=files)
        return {name: SimpleMaterial(**about) for name, about in told.items()}
    except Exception:  # a file that is missing or broken costs the look only, whatever trimesh makes of it
        return {}
