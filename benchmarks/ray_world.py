"""The scene of `ray_cell` as a world of the kernel: 200 objects and a body of eight links, each a mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.figures import Figure, Mesh
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, NodeData, NodeSpec

from benchmarks.ray_cell import RayCell
from tests.drawing.cell import Cell


def ray_world(
    cell: RayCell, sensor: NodeData, kind: Kind, world_t_sensor: NDArray[np.float64], texture: bytes | None = None
) -> Cell:
    """Return the world, with a sensor called `sensor`; with a texture (PNG), everything shows it."""
    world = Cell()
    specs = []
    for place, (shape, pose) in enumerate(zip(cell.shapes, cell.world_t_element, strict=True)):
        uri = f"{place}.stl"
        uv = shape.vertices[:, :2] + shape.vertices[:, 2:] if texture else None
        world.told[uri] = (Submesh(shape.vertices, shape.triangles, uv=uv, texture=texture),)
        specs.append(NodeSpec(f"object{place}", Kind.OBJECT, parent_t_node=pose, figures=(Figure(Mesh(uri, uri)),)))
    specs.append(NodeSpec("sensor", kind, parent_t_node=world_t_sensor, data=sensor))
    world.do(CreateNodes(tuple(specs)))
    return world


def snapshots(world: Cell, cell: RayCell, count: int) -> list[Snapshot]:
    """Return the world with its links turned more and more."""
    return [moved(world.snapshot, cell, 0.1 * place) for place in range(count)]


def moved(snapshot: Snapshot, cell: RayCell, angle: float) -> Snapshot:
    """Return the world with its links turned; only the places in the world's frame are changed."""
    places = snapshot.world_t_node.copy()
    places[1 : 1 + len(cell.shapes)] = cell.moved(angle)
    return Snapshot(
        snapshot.structure, snapshot.state, places, snapshot.revision, snapshot.wall_time, snapshot.tick_seconds
    )
