"""History: what an undo costs, against the edit that it takes back, in a world of 5,000 nodes."""

from __future__ import annotations

import time
from collections.abc import Callable

import grpc
import numpy as np
from google.protobuf.field_mask_pb2 import FieldMask
from virtualrobot.v1 import (
    geometry_pb2,
    history_pb2,
    history_pb2_grpc,
    nodes_pb2,
    scene_pb2,
    scene_pb2_grpc,
)

from benchmarks.processes import kernel
from benchmarks.rows import Row, row

NODES, ROUNDS = 5_000, 150

Edit = Callable[[int], scene_pb2.Command]


def _updated(field: str, **fields: object) -> scene_pb2.Command:
    node = nodes_pb2.Node(**fields)  # pyright: ignore[reportArgumentType] fields by name
    update = scene_pb2.UpdateNode(name="node 7", node=node, update_mask=FieldMask(paths=[field]))
    return scene_pb2.Command(update_node=update)


def _created(name: str, x: float = 0.0) -> scene_pb2.Command:
    pose = geometry_pb2.Pose(position=geometry_pb2.Vector3(x=x))
    node = nodes_pb2.Node(name=name, parent_t_node=pose, object=nodes_pb2.SceneObject())
    return scene_pb2.Command(create_node=scene_pb2.CreateNode(node=node))


EDITS: dict[str, Edit] = {
    "moving a node": lambda at: _updated(
        "parent_t_node", parent_t_node=geometry_pb2.Pose(position=geometry_pb2.Vector3(x=-1.0 - at))
    ),
    "renaming one": lambda at: _updated("name", name=f"other {at}"),
    "hanging it elsewhere": lambda at: scene_pb2.Command(
        attach_node=scene_pb2.AttachNode(name="node 7", parent="node 9")
    ),
    "creating one": lambda at: _created(f"new {at}"),
    "removing one": lambda at: scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="node 7")),
}


def run() -> list[Row]:
    """Return a row for each kind of edit: the undo's median against the edit's, called in turn."""
    with kernel("--headless") as (address, _), grpc.insecure_channel(address) as channel:
        scene, history = scene_pb2_grpc.SceneServiceStub(channel), history_pb2_grpc.HistoryServiceStub(channel)
        scene.Apply(scene_pb2.ApplyRequest(commands=[_created(f"node {k}", float(k)) for k in range(NODES)]))
        results = []
        for name, edit in EDITS.items():
            times = np.empty((ROUNDS, 2))
            for at in range(ROUNDS):
                request = scene_pb2.ApplyRequest(commands=[edit(at)])
                start = time.perf_counter()
                scene.Apply(request)
                between = time.perf_counter()
                history.Undo(history_pb2.UndoRequest())
                times[at] = between - start, time.perf_counter() - between
            edited, undone = np.median(times, axis=0) * 1e3
            results.append(row(f"undo of {name} of {NODES:,}", undone, edited, "the edit", "ms, p50", 1.5))
        return results
