"""Small worlds for the tests of export, and what is written of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from virtualrobot_kernel.formats.export.model import Exported, export_model
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import ImportedModel, import_model
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.figures import Figure
from virtualrobot_kernel.world.state import Snapshot, State
from virtualrobot_kernel.world.structure import JointType, Kind, NodeSpec, Structure

from tests.unit.formats.models import disk, forward, structure_of


def snapshot_of(
    nodes: Sequence[NodeSpec], q: np.ndarray | None = None, tool_states: Mapping[str, str] | None = None
) -> Snapshot:
    """Return the world that holds the nodes, at the coordinates q (nq,) or at zero."""
    structure, poses = structure_of(tuple(nodes))
    hidden = {spec.name for spec in nodes if spec.hidden}
    made = {uid: replace(node, hidden=node.name in hidden) for uid, node in structure.nodes.items()}
    structure = index.build(made, structure.next_uid, 1)
    at = neutral(structure) if q is None else q
    placed = forward(structure, poses, at)
    rows = np.array([placed[node.name] for node in structure.nodes.values()])
    states = {structure.uid_by_name[name]: state for name, state in (tool_states or {}).items()}
    return Snapshot(
        structure, State(0, at, np.zeros(structure.v_count), poses, tool_states=states), rows, 1, 0.0, 0.004
    )


def neutral(structure: Structure) -> np.ndarray:
    """Return coordinates (nq,) of zero, floating joints unturned."""
    q = np.zeros(structure.q_count)
    for robot in structure.robots.values():
        for joint, place in zip(robot.joints, robot.q_start, strict=True):
            if joint.type is JointType.FLOATING:
                q[place + 6] = 1.0
    return q


def drawn(structure: Structure, rng: np.random.Generator) -> np.ndarray:
    """Return random coordinates (nq,) within limits; floating and planar joints somewhere within 2 m."""
    q = neutral(structure)
    for robot in structure.robots.values():
        for joint, place in zip(robot.joints, robot.q_start, strict=True):
            if joint.type is JointType.FLOATING:
                q[place : place + 3] = rng.uniform(-2.0, 2.0, 3)
                turn = rng.normal(size=4)
                q[place + 3 : place + 7] = turn / np.linalg.norm(turn)
            elif joint.type is JointType.PLANAR:
                q[place : place + 3] = rng.uniform(-2.0, 2.0, 3)
            else:
                q[place] = rng.uniform(max(joint.limits.lower, -3.0), min(joint.limits.upper, 3.0))
    return q


def written(snapshot: Snapshot, library: MeshLibrary, name: str, format: str, folder: Path) -> tuple[Path, Exported]:
    """Export a node into a folder; return the main file's path and what was told."""
    exported = export_model(snapshot, library, name, format)
    for path, sha256 in exported.files:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(library.store.get(sha256))
    return folder / exported.files[0][0], exported


def read_back(file: Path, library: MeshLibrary, name: str = "") -> ImportedModel:
    """Import a URDF file from the disk."""
    model = import_model(str(file), disk(library.store), library, name=name)
    assert isinstance(model, ImportedModel)
    return model


def one(*figures: Figure, name: str = "thing", hidden: bool = False) -> NodeSpec:
    """Return an object with some figures."""
    return NodeSpec(name, Kind.OBJECT, figures=figures, hidden=hidden)
