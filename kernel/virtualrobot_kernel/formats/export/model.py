"""Export of a node as a model file, with the files that it names beside it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.formats.export.gltf import write_gltf
from virtualrobot_kernel.formats.export.mesh_files import MeshFiles
from virtualrobot_kernel.formats.export.names import legal
from virtualrobot_kernel.formats.export.robot_tree import robot_tree
from virtualrobot_kernel.formats.export.urdf import write_urdf
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, Node, Structure

EXPORT_FORMATS = (".glb", ".urdf")
"""Endings of the files that `export_model` writes."""


@dataclass(frozen=True, slots=True)
class Exported:
    """Exported files as (relative path, SHA-256), the main one first, and warnings of what the format could not say."""

    files: tuple[tuple[str, str], ...]
    warnings: tuple[str, ...]


def export_model(snapshot: Snapshot, library: MeshLibrary, name: str, format: str, tolerance: float = 0.0) -> Exported:
    """Write the node `name` (empty: the world) and what hangs below it; all files are in the asset store then.

    `format` is one of EXPORT_FORMATS; surfaces of glTF may be off by `tolerance` (m). The same world gives the same
    bytes. Takes from milliseconds to seconds: keep it off the threads of world and API.

    Raises:
        UnknownNameError: when no node has that name.
        KernelError: INVALID_ARGUMENT for another format, a tolerance below 0 or of another format, URDF of something
            that is no robot, and where there is nothing to write; TOO_LARGE over a limit of the store.
    """
    if format not in EXPORT_FORMATS:
        valid = ", ".join(EXPORT_FORMATS)
        raise KernelError(f"no model can be written as {format!r}; valid: {valid}", format=format, valid=valid)
    if not (math.isfinite(tolerance) and tolerance >= 0.0):
        raise KernelError(f"tolerance_meters is {tolerance:g}; valid: 0 (as it is) or more, such as 0.001")
    if tolerance > 0.0 and format != ".glb":
        raise KernelError(f"only .glb can be written with a tolerance, not {format}; leave tolerance_meters out")
    node = snapshot.structure.node(name)
    main = f"{legal(node.name)}{format}"
    if format == ".glb":
        data, warnings = write_gltf(snapshot, node, library.load, tolerance)
        return Exported(((main, library.store.put(data)),), tuple(warnings))
    if node.kind is not Kind.ROBOT:
        raise _no_robot(snapshot.structure, node)
    tree = robot_tree(snapshot, node)
    # Of its own, so that several robots can be written to one place.
    files = MeshFiles(library, f"meshes/{legal(node.name)}")
    text = write_urdf(tree, files)
    return Exported(((main, library.store.put(text)), *files.written.items()), (*tree.warnings, *files.warnings))


def _no_robot(structure: Structure, node: Node) -> KernelError:
    """Return the error that says what would be right instead of this node."""
    owner = structure.robot_of(node.uid)
    robots = sorted(structure.nodes[uid].name for uid in structure.robots)
    if owner is not None:
        right = f"its robot is {owner.name!r}"
    elif robots:
        right = f"robots: {', '.join(repr(name) for name in robots[:8])}{', ...' if len(robots) > 8 else ''}"
    else:
        right = "there is no robot yet; .glb takes any node"
    what = "the world" if node.kind is Kind.WORLD else f"{node.name!r}, a node of kind {node.kind.value},"
    return KernelError(
        f"URDF describes one robot, and {what} is none; {right}",
        node=node.name,
        kind=node.kind.value,
        nearest=owner.name if owner else "",
        valid="\n".join(robots[:50]),
    )
