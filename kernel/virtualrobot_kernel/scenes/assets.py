"""Meshes that nodes name: found, parsed once and named by their content."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from virtualrobot.files.resolver import Resolver
from virtualrobot.v1 import nodes_pb2

from virtualrobot_kernel.errors import KernelError, MissingFileError, Reason
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.xml import FileWarning
from virtualrobot_kernel.world.commands import Command, CreateNodes, UpdateNode
from virtualrobot_kernel.world.figures import Figure, Mesh, meshes_of
from virtualrobot_kernel.world.structure import Structure

MOST_NAMED = 10
"""Greatest number of missing files that are named one by one."""


def files_of(meshes: MeshLibrary, files: Iterable[nodes_pb2.AssetFile]) -> Files:
    """Return the sources of a request's files: what was uploaded, then the kernel's disk."""
    return Files(meshes.store, {file.uri: file.sha256 for file in files}, Resolver(folders=meshes.folders))


def check_assets(structure: Structure, store: AssetStore) -> None:
    """Have each file of the world's meshes held; raise KernelError, which names nodes and files, when some are gone.

    One that isn't held is taken from where it came from, if it is the same there.
    """
    gone: dict[str, str] = {}
    for node in structure.nodes.values():
        for mesh in meshes_of(node.figures):
            for uri, sha256 in mesh.all_files:
                try:
                    store.get(sha256)
                except KernelError as error:
                    if _taken_anew(store, uri, sha256):
                        continue
                    if error.reason is not Reason.UNKNOWN_ASSET:
                        raise error.at(f"the node {node.name!r} has a mesh {mesh.uri}") from error
                    gone.setdefault(sha256, f"{sha256} ({uri}, of the node {node.name!r})")
    if gone:
        names = [*gone.values()][:MOST_NAMED]
        more = f" and {len(gone) - MOST_NAMED} more" if len(gone) > MOST_NAMED else ""
        where = store.folder or "the store of assets"
        raise MissingFileError(
            f"{where} lacks {len(gone)} files of meshes, copy them back: {', '.join(names)}{more}",
            folder=where,
            count=len(gone),
        )


def _taken_anew(store: AssetStore, path: str, sha256: str) -> bool:
    """Return whether a file of the disk is the asset that isn't held; it is then."""
    try:
        data = Path(path).read_bytes()
    except (OSError, ValueError):
        return False
    if hashlib.sha256(data).hexdigest() != sha256:
        return False
    store.put(data)
    return True


def with_assets(
    meshes: MeshLibrary,
    commands: Sequence[Command],
    files: Files | None = None,
    referrer: str = "",
    warnings: list[FileWarning] | None = None,
) -> list[Command]:
    """Return the commands with every mesh found, parsed once and named by its content; see `found_figures`."""
    odd = [] if warnings is None else warnings
    found = partial(found_figures, meshes, files=files or files_of(meshes, ()), referrer=referrer, warnings=odd)
    result: list[Command] = []
    for command in commands:
        if isinstance(command, CreateNodes):
            result.append(CreateNodes(tuple(replace(spec, figures=found(spec.figures)) for spec in command.specs)))
        elif isinstance(command, UpdateNode) and command.figures is not None:
            result.append(replace(command, figures=found(command.figures)))
        else:
            result.append(command)
    return result


def found_figures(
    meshes: MeshLibrary, figures: tuple[Figure, ...], files: Files, referrer: str, warnings: list[FileWarning]
) -> tuple[Figure, ...]:
    """Return figures with every mesh found, parsed once and named by its content; `warnings` takes what is odd."""
    return tuple(_found(meshes, figure, files, referrer, warnings) for figure in figures)


def _found(meshes: MeshLibrary, figure: Figure, files: Files, referrer: str, warnings: list[FileWarning]) -> Figure:
    mesh = figure.geometry
    if not isinstance(mesh, Mesh):
        return figure
    held = mesh.sha256 and all(meshes.store.has(sha256) for _, sha256 in mesh.all_files)
    if not held:
        found, odd = meshes.find(files, mesh.uri, referrer, mesh.scale, mesh.sha256)
        warnings.extend(warning for warning in odd if warning not in warnings)
        mesh = replace(found, collision_hull_vertices=mesh.collision_hull_vertices)
    meshes.load(mesh)
    return replace(figure, geometry=mesh)
