"""STL, OBJ, COLLADA and glTF files read into submeshes, as RViz and MoveIt read them.

Numbers are meters; COLLADA's `<unit>` is applied. Transforms of nodes inside a file are applied. The up axis that a
file declares (COLLADA `<up_axis>`, glTF's y) is NOT applied: the file's axes are the figure's axes. That is the ROS
convention, by which URDF files are written (rviz `mesh_loader.cpp` leaves out Assimp's root node, geometric_shapes
`mesh_operations.cpp` resets it). PyBullet does turn COLLADA files by their up axis.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from virtualrobot_kernel.errors import MalformedFileError
from virtualrobot_kernel.formats.collada import length_unit, parse_collada, without_unreadable_materials
from virtualrobot_kernel.formats.references import ending
from virtualrobot_kernel.formats.xml import malformed
from virtualrobot_kernel.shapes.submesh import Submesh, merged, transformed

MESH_FORMATS = (".stl", ".obj", ".dae", ".gltf", ".glb")
"""Endings of the mesh files that are read."""


def parse_mesh(data: bytes, uri: str, dependents: Mapping[str, bytes] | None = None) -> tuple[Submesh, ...]:
    """Return the triangles of a mesh file.

    `dependents` holds the files that it names: by the name in the file, by that name joined to `uri`, or as counted
    from the folder of the mesh.

    A texture or material file that is not among the dependents costs the look only. Lines and points are left out.

    Raises:
        MalformedFileError: when the format is unknown, the file is broken, or it holds no triangle.
    """
    kind = ending(uri)
    if kind not in MESH_FORMATS:
        raise malformed(uri, None, f"no mesh format has the ending {kind!r}; known: {', '.join(MESH_FORMATS)}")
    unit = 1.0
    if kind == ".dae":
        root = parse_collada(data, uri)
        unit = length_unit(root, uri)
        data = without_unreadable_materials(data, root)
    # Only now, so that a kernel that reads no mesh starts without trimesh.
    from virtualrobot_kernel.formats import trimesh_reader

    try:
        parts = trimesh_reader.read(data, kind, uri, dependents or {}, unit)
    except MalformedFileError:
        raise
    except Exception as error:  # the readers below trimesh raise whatever a broken file makes them run into
        text = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        raise malformed(uri, None, f"broken or not a {kind[1:].upper()} file ({text})") from error
    if not parts:
        raise malformed(uri, None, "the file holds no triangle")
    for part in parts:
        _check(part, uri)
    return tuple(merged(part) for part in parts)


def _check(part: Submesh, uri: str) -> None:
    """Raise MalformedFileError for numbers that no shape can have."""
    if part.vertices.ndim != 2 or part.vertices.shape[1] != 3:
        raise malformed(uri, None, f"a vertex has {part.vertices.shape[-1]} numbers, not three")
    if len(part.vertices) == 0 or not np.isfinite(part.vertices).all():
        bad = np.flatnonzero(~np.isfinite(part.vertices).all(axis=1))
        raise malformed(uri, None, f"vertex {bad[0] if len(bad) else 0} is not finite")
    if part.faces.min() < 0 or part.faces.max() >= len(part.vertices):
        raise malformed(
            uri, None, f"a face names vertex {int(part.faces.max())}, but there are {len(part.vertices)} vertices"
        )


def scaled(parts: tuple[Submesh, ...], scale: tuple[float, float, float]) -> tuple[Submesh, ...]:
    """Return the parts scaled along x, y, z; factors may be negative (mirrored) but not 0.

    Raises:
        MalformedFileError: for a factor of 0 or one that is not finite.
    """
    if scale == (1.0, 1.0, 1.0):
        return parts
    if not all(np.isfinite(factor) and factor != 0.0 for factor in scale):
        raise MalformedFileError(f"the scale {scale} is impossible: factors are finite and not 0", scale=scale)
    linear = np.diag(np.asarray(scale, dtype=np.float64))
    return tuple(transformed(part, linear) for part in parts)
