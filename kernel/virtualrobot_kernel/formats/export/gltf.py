"""Part of the world as one binary glTF file: a tree of nodes with the scene's names, as it stands now.

Source: Khronos Group, glTF 2.0 Specification. Only what can be seen is written: visual figures of nodes that are not
hidden. Each figure is a child of its node, named `NODE figure K`, so that the nodes keep their own frames.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.glb import pack_glb
from virtualrobot_sdk.poses import quaternion

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.formats.export.gltf_meshes import MeshTable
from virtualrobot_kernel.formats.export.names import listed
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.version import VERSION
from virtualrobot_kernel.world.figures import Label, Lines, Mesh, Points
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node
from virtualrobot_kernel.world.visibility import inherited_visibility

Y_UP = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""Pose of the root: a quarter turn about x, by which the scene's z becomes glTF's y, which viewers show upwards."""

DECIMALS = 12
"""Poses are written to the picometer: what is beyond is noise of their products."""


def write_gltf(
    snapshot: Snapshot, root: Node, load: Callable[[Mesh], tuple[Submesh, ...]], tolerance: float = 0.0
) -> tuple[bytes, list[str]]:
    """Return the GLB file of a node and what hangs below it, and warnings; the node's frame is the file's.

    `load` gives the triangles of a mesh. Surfaces are nowhere farther than `tolerance` (m) from where they are; above 0
    the file is smaller. Raises KernelError when there is nothing to be seen.
    """
    structure = snapshot.structure
    hidden, states = inherited_visibility(structure, snapshot.state.tool_states)
    meshes = MeshTable(load, tolerance)
    nodes: list[dict[str, Any]] = []
    place: dict[int, int] = {}
    labelled: list[str] = []
    widths = False
    for node in structure.below(root.uid):
        if hidden[node.uid]:
            continue
        seen = [figure for figure in node.figures if figure.visual and figure.tool_state in ("", states[node.uid])]
        labelled.extend(node.name for figure in seen if isinstance(figure.geometry, Label))
        widths = widths or any(isinstance(figure.geometry, (Points, Lines)) for figure in seen)
        pose = Y_UP if node is root else np.linalg.inv(snapshot.world_t(node.parent)) @ snapshot.world_t(node.uid)
        place[node.uid] = len(nodes)
        if node is not root:
            _hang(nodes, place[node.parent], len(nodes))
        nodes.append({"name": node.name, **_placed(pose)})
        for number, figure in enumerate(seen, 1):
            mesh = None if isinstance(figure.geometry, Label) else meshes.index(figure)
            if mesh is not None:
                _hang(nodes, place[node.uid], len(nodes))
                name = f"{node.name} figure {number}"
                cube, placed = meshes.cubes.get(mesh), {"name": name, **_placed(figure.node_t_figure)}
                if cube is None:
                    nodes.append({**placed, "mesh": mesh})
                else:
                    nodes.append({**placed, "children": [len(nodes) + 1]})
                    nodes.append({"name": f"{name} shape", "mesh": mesh, **cube.placed()})
    if not meshes.meshes:
        raise _nothing(root, hidden[root.uid])
    warnings = (
        [f"glTF has no labels: those of {listed(list(dict.fromkeys(labelled)))} are left out"] if labelled else []
    )
    if widths:
        warnings.append("glTF has no sizes of points and no widths of lines: viewers choose them")
    document = {
        "asset": {"version": "2.0", "generator": f"VirtualRobot {VERSION}"},
        "scene": 0,
        "scenes": [{"name": root.name, "nodes": [0]}],
        "nodes": nodes,
        **meshes.document(),
    }
    return pack_glb(document, meshes.buffers.data), warnings


def _hang(nodes: list[dict[str, Any]], parent: int, child: int) -> None:
    nodes[parent].setdefault("children", []).append(child)


def _placed(pose: NDArray[np.float64]) -> dict[str, list[float]]:
    """Return translation and rotation of a glTF node; what changes nothing is left out."""
    shift = (np.round(pose[:3, 3], DECIMALS) + 0.0).tolist()
    turn = (np.round(quaternion(pose[:3, :3]), DECIMALS) + 0.0).tolist()
    placed = {"translation": shift} if any(shift) else {}
    return placed if turn == [0.0, 0.0, 0.0, 1.0] else {**placed, "rotation": turn}


def _nothing(root: Node, hidden: bool) -> KernelError:
    why = "it is hidden, or below a hidden node: show it" if hidden else "a visual figure that is not hidden is needed"
    return KernelError(f"there is nothing to be seen at or below {root.name!r}; {why}", node=root.name)
