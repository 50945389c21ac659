"""Parts of a running cell as meshes: what a process works on is what the kernel has."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import trimesh
from trimesh import Trimesh
from virtualrobot import Client, WrongStateError, pose
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.processes.sources.surface import solid_of

GRID = 1e-6
"""Distance (m) to whose multiples corners go before bodies are joined, so that faces which touch are in one plane."""


def part_mesh(client: Client, nodes: Sequence[str]) -> trimesh.Trimesh:
    """Return the mesh of nodes and of all that hangs below them, as it stands, in the first one's frame (m).

    Where it has several bodies, of one node or more, they are joined to one as far as they touch, by Manifold.

    Raises:
        InvalidArgumentError: for no node, and for bodies that `solid_of` refuses where they are to be joined.
        UnknownNameError: for a node that there is not.
        WrongStateError: where bodies are to be joined and manifold3d is not installed.
    """
    if not nodes:
        raise InvalidArgumentError("name the part, or several, whose edges are looked for")
    first = client.scene[nodes[0]].pose
    meshes = []
    for node in nodes:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "part.glb"
            client.scene.export(node, file)
            mesh = trimesh.load_mesh(file)
        # glTF has y upwards: the root node is turned, which is undone here.
        mesh.apply_transform(np.linalg.inv(first) @ client.scene[node].pose @ pose(roll=0.5 * np.pi))
        meshes.append(mesh)
    return joined(meshes)


def joined(meshes: Sequence[trimesh.Trimesh]) -> trimesh.Trimesh:
    """Return the bodies of meshes as one mesh, joined where they are several.

    Raises InvalidArgumentError for bodies that `solid_of` refuses, and WrongStateError without manifold3d.
    """
    bodies = [body for mesh in meshes for body in _bodies(mesh)]
    if len(bodies) == 1:
        return bodies[0]
    if find_spec("manifold3d") is None:
        raise WrongStateError("joining bodies needs manifold3d: pip install 'virtualrobot[processes]'")
    for number, body in enumerate(bodies, 1):
        body.vertices = GRID * np.round(body.vertices / GRID)
        try:
            solid_of(body)
        except InvalidArgumentError as error:
            raise InvalidArgumentError(f"body {number} of {len(bodies)} can't be joined: {error.message}") from None
    return trimesh.boolean.union(bodies, engine="manifold")


def _bodies(mesh: trimesh.Trimesh) -> list[trimesh.Trimesh]:
    """Return the bodies of a mesh, by triangles that hang together by edges."""
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    return list(mesh.split(only_watertight=False, repair=False)) or [mesh]


def divided(mesh: Trimesh, longest: float) -> Trimesh:
    """Return a mesh whose triangles are divided until no edge is longer than a length (m)."""
    found = mesh.subdivide_to_size(longest, max_iter=20)
    assert isinstance(found, Trimesh)
    return found
