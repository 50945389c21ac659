"""Layout of a scene's files when the scene travels: a folder for each mesh, in which names inside files hold."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable
from posixpath import normpath

from virtualrobot.files.resolver import is_relative

from virtualrobot_kernel.formats.references import counted_from
from virtualrobot_kernel.world.figures import Mesh

_FORBIDDEN = re.compile(r'[\x00-\x1f<>:"|?*\\/]')  # in file names of one system or another


def bundle(meshes: Iterable[Mesh]) -> tuple[dict[Mesh, str], list[tuple[str, str]]]:
    """Return the new URI of each mesh, relative to the scene file, and all files as (relative path, SHA-256).

    A mesh goes to `assets/<8 hex digits>/<name>`, the digits being those of its content, so that equal meshes share a
    folder and others with the same name don't meet. What the mesh file names keeps its path relative to it; where
    such paths climb (`../textures/a.png`) the mesh goes deeper by as many folders. Files that are named by an absolute
    path or a package lie beside the mesh, where they are found by their name alone.
    """
    uris: dict[Mesh, str] = {}
    paths: dict[str, str] = {}
    folders: dict[str, str] = {}
    for mesh in meshes:
        content = hashlib.sha256(repr((mesh.sha256, _file_name(mesh.uri), mesh.files)).encode()).hexdigest()
        length = 8
        while folders.setdefault(content[:length], content) != content:
            length += 1
        files = laid_out(mesh, f"assets/{content[:length]}")
        uris[mesh] = files[0][0]
        paths.update(files)
    return uris, list(paths.items())


def laid_out(mesh: Mesh, folder: str) -> list[tuple[str, str]]:
    """Return the files of a mesh below `folder` as (path, SHA-256), the mesh first, so that names inside files hold."""
    relative = [(_inside(mesh.uri, name), sha256) for name, sha256 in mesh.files]
    depth = max((name.split("/").count("..") for name, _ in relative), default=0)
    folder = "/".join([folder, *["mesh"] * depth])
    main = f"{folder}/{_file_name(mesh.uri)}"
    return [(main, mesh.sha256), *((normpath(f"{folder}/{name}"), sha256) for name, sha256 in relative)]


def _file_name(uri: str) -> str:
    """Return the last part of a URI, made a name that any system takes."""
    return _FORBIDDEN.sub("_", uri.replace("\\", "/").rpartition("/")[2]).lstrip(".") or "mesh"


def _inside(uri: str, name: str) -> str:
    """Return a dependent's path relative to its mesh, `..` only at the start."""
    relative = normpath(name) if is_relative(name) else counted_from(uri, name)
    return relative if is_relative(relative) else _file_name(name)
