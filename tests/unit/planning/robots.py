"""Robots of the kernel's model table, alone in a world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.change import Change, single_joint
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, Node

from tests.unit.formats.models import XacroOnly, disk, imported
from tests.unit.world.builders import after, empty


@cache
def _world(model: str) -> Change:
    files = disk()
    found = imported(f"model://{model}", files, MeshLibrary(files.store, XacroOnly()))
    return after(empty(), CreateNodes(found.nodes))


def standing(model: str, positions: Mapping[str, float] | None = None) -> tuple[Snapshot, Node]:
    """Return a world with the robot of this name, its joints at these radians or metres, and the robot."""
    world = _world(model)
    node = next(node for node in world.structure.nodes.values() if node.kind is Kind.ROBOT)
    q = world.state.q.copy()
    for name, value in (positions or {}).items():
        q[single_joint(world.structure, node, name)[1]] = value
    state = replace(world.state, q=q)
    return Snapshot(world.structure, state, world_poses(world.structure, state), 1, 0.0, 0.004), node
