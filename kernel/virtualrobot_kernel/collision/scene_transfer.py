"""Worlds as they travel to collision processes: what can touch, once for each structure, and the state of a moment.

A mesh travels as a `Shape`, once by its content for each process (see `virtualrobot_sdk.worker.sent`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from virtualrobot_sdk.rays import Shape

from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.figures import Mesh
from virtualrobot_kernel.world.state import State
from virtualrobot_kernel.world.structure import Node, Structure

KEPT_OF_STATE = ("tool_states", "allowed_pairs", "collisions")
"""Parts of a world for which scenes are made anew when they are other objects."""


@dataclass(frozen=True, slots=True, eq=False)
class TransferredWorld:
    """A structure whose nodes have only the figures that can touch, and the triangles of its meshes."""

    structure: Structure
    meshes: Mapping[Mesh, Shape]


def transferred_world(structure: Structure, shapes: ShapeLibrary) -> TransferredWorld:
    """Return what a process needs of a structure."""
    nodes = {uid: _touchable(node) for uid, node in structure.nodes.items()}
    meshes: dict[Mesh, Shape] = {}
    for node in nodes.values():
        for figure in node.figures:
            if isinstance(figure.geometry, Mesh) and figure.geometry not in meshes:
                shape = shapes.get(figure.geometry)
                assert shape is not None, "every mesh has a shape"
                meshes[figure.geometry] = shape
    return TransferredWorld(replace(structure, nodes=nodes), meshes)


def transferred_state(state: State) -> State:
    """Return what a process needs of a state: nothing that runs or has ended, no signals."""
    return replace(state, motions=(), ended=(), signals={})


def as_before(state: State, before: State) -> State:
    """Return a state with the objects of the one before where they are equal: by these, scenes know what is new."""
    same = {name: getattr(before, name) for name in KEPT_OF_STATE if getattr(before, name) == getattr(state, name)}
    return replace(state, **same)


def _touchable(node: Node) -> Node:
    kept = tuple(figure for figure in node.figures if figure.collision)
    return node if len(kept) == len(node.figures) else replace(node, figures=kept)
