"""The importers of `.ply` and `.off`, on trimesh."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from virtualrobot_sdk.errors import ArgumentError, FilesNeeded
from virtualrobot_sdk.importers import Translation

from virtualrobot_plugins.importers.glb import Color, Piece, write_glb
from virtualrobot_plugins.importers.images import drawable
from virtualrobot_plugins.importers.refusal import described, library, refusal, short_name

_TEXTURE = re.compile(rb"^comment\s+TextureFile\s+(.+?)\s*$", re.MULTILINE | re.IGNORECASE)
_COUNT = re.compile(rb"^element\s+(\w+)\s+(\d+)\s*$", re.MULTILINE)


class PlyImporter:
    """Reads PLY meshes, text and binary, with the colours of vertices and faces or a texture; numbers are meters."""

    def translate(self, data: bytes, uri: str, files: Mapping[str, bytes | None], /) -> Translation:
        """Return the mesh as GLB.

        Raises:
            FilesNeeded: for its texture, without which it is grey.
            ArgumentError: for a broken file or one that has points only.
        """
        end = data.find(b"end_header")
        if not data.startswith(b"ply") or end < 0:
            raise refusal(uri, "not a PLY file: it has no header from 'ply' to 'end_header'")
        header = data[:end]
        _check_counts(header, len(data), uri)
        warnings: list[str] = []
        texture = None
        named = _TEXTURE.search(header)
        if named:
            name = named[1].decode("utf-8", "replace").strip("\"'").replace("\\", "/")
            if name not in files:
                raise FilesNeeded([name])
            texture = drawable(files[name])
            if texture is None:
                why = "is not there" if files[name] is None else "is no PNG or JPEG file"
                warnings.append(f"{short_name(uri)}: the texture {name} {why}; drawn without it")
        return Translation(".glb", write_glb([_read(data, uri, ".ply", texture)], uri), tuple(warnings))


class OffImporter:
    """Reads OFF meshes (text); numbers are meters."""

    def translate(self, data: bytes, uri: str, files: Mapping[str, bytes | None], /) -> Translation:
        """Return the mesh as GLB.

        Raises:
            ArgumentError: for a broken file.
        """
        if b"OFF" not in data[:512]:
            raise refusal(uri, "not an OFF file: it does not begin with OFF")
        return Translation(".glb", write_glb([_read(data, uri, ".off", None)], uri))


def _check_counts(header: bytes, size: int, uri: str) -> None:
    """Refuse elements that the file cannot hold, before memory is taken for them; each has a byte at least."""
    for name, count in _COUNT.findall(header):
        if int(count) > size:
            raise refusal(uri, f"the header announces {int(count)} of {name.decode()}, but the file has {size} bytes")


def _read(data: bytes, uri: str, kind: str, texture: bytes | None) -> Piece:
    trimesh = library("trimesh", kind, "kernel")
    try:
        with np.errstate(all="ignore"):  # a broken file is told by what it yields
            mesh = trimesh.load(io.BytesIO(data), file_type=kind[1:], process=False)
        if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0:
            raise refusal(uri, "the file holds points or lines, but no face")
        return _piece(mesh, texture)
    except ArgumentError:
        raise
    except Exception as error:  # trimesh raises whatever a broken file makes it run into
        raise refusal(uri, f"broken or not a {kind[1:].upper()} file ({described(error)})") from error


def _piece(mesh: Any, texture: bytes | None) -> Piece:  # noqa: ANN401  trimesh's mesh
    vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.intp)
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise ValueError(f"a face names vertex {faces.max()}, but there are {len(vertices)}")
    kept = mesh._cache.cache.get("vertex_normals")  # asking for the property would make some up
    normals = kept if kept is not None and np.shape(kept) == vertices.shape and np.isfinite(kept).all() else None
    visual = mesh.visual
    uv = getattr(visual, "uv", None)
    if visual.kind == "texture" and texture is not None and uv is not None and np.shape(uv) == (len(vertices), 2):
        return Piece(vertices, faces, (1.0, 1.0, 1.0, 1.0), normals, uv=np.asarray(uv), texture=texture)
    if visual.kind == "face":
        colors = np.repeat(np.asarray(visual.face_colors, np.uint8), 3, axis=0)
        corners = vertices[faces].reshape(-1, 3)
        return _plain(Piece(corners, np.arange(len(corners)).reshape(-1, 3), vertex_colors=colors))
    if visual.kind == "vertex":
        return _plain(Piece(vertices, faces, None, normals, np.asarray(visual.vertex_colors, np.uint8)))
    return Piece(vertices, faces, None, normals)


def _plain(piece: Piece) -> Piece:
    """Return the piece with one colour where all of its vertices have the same."""
    colors = piece.vertex_colors
    if colors is None or len(colors) == 0 or (colors != colors[0]).any():
        return piece
    red, green, blue, alpha = (float(value) / 255.0 for value in colors[0])
    color: Color = (red, green, blue, alpha)
    return Piece(piece.vertices, piece.faces, color, piece.normals)
