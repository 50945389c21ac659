"""Many configurations in one call against bare python-fcl in one process, and other calls meanwhile.

The kernel runs in a process of its own, and its processes for this in theirs; the call goes over TCP.
"""

from __future__ import annotations

import os
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import trimesh
import virtualrobot
from virtualrobot import Client

from benchmarks.collision_cell import IIWA, CollisionCell, collision_cell
from benchmarks.collision_peers import bare_fcl
from benchmarks.processes import kernel
from benchmarks.rows import Row, row
from benchmarks.rpc import latencies, unary

CONFIGURATIONS = 2000
REPEATS = 5
"""How often the configurations are in one call, so that it takes a while."""
ROUNDS = 3
BUDGET = 1.5
"""Of the time in one process of the peer, which is given all poses: ours come from joints, over TCP."""
CALLS = 300


def run() -> list[Row]:
    """Measure."""
    cell = collision_cell(1, 200, CONFIGURATIONS)
    rows = np.array([snapshot.state.q for snapshot in cell.snapshots])
    check = bare_fcl(cell)
    with kernel("--headless") as (address, _), virtualrobot.connect(address, token="") as client:
        furnish(client, cell)
        client.collisions.check_configurations("arm0", rows[:1])
        ours, peer = np.inf, np.inf
        for _ in range(ROUNDS):
            start = time.perf_counter()
            truth = np.array([check(place) for place in range(CONFIGURATIONS)])
            peer = min(peer, (time.perf_counter() - start) / CONFIGURATIONS)
            start = time.perf_counter()
            found = client.collisions.check_configurations("arm0", np.tile(rows, (REPEATS, 1)))
            ours = min(ours, (time.perf_counter() - start) / len(found.free))
        wrong = int((found.free[:CONFIGURATIONS] == truth).sum())
        rest = latencies(unary(address), CALLS)
        loaded = meanwhile(client, address, rows)
    count = max(1, len(os.sched_getaffinity(0)) - 1) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    note = f"{1.0 / ours:.0f} a second over TCP, {count} process(es); {wrong} of {CONFIGURATIONS} otherwise"
    return [
        row(
            "one of many configurations, 1 arm and 200 meshes",
            ours * 1e3,
            peer * 1e3,
            "bare python-fcl",
            "ms",
            BUDGET,
            note,
        ),
        *(
            row(
                f"unary call while configurations are checked, p{share}",
                float(np.percentile(loaded, share)),
                float(np.percentile(rest, share)),
                "the kernel at rest",
                "ms",
                None,
            )
            for share in (50, 99)
        ),
    ]


def furnish(client: Client, cell: CollisionCell) -> None:
    """Bring the arm and the meshes of the cell into a kernel's world."""
    client.load_robot(IIWA, name="arm0")
    with tempfile.TemporaryDirectory() as folder, client.scene.batch() as batch:
        figures = {}
        for element in np.flatnonzero(cell.groups == 0).tolist():
            vertices, faces = cell.triangles[element]
            if id(faces) not in figures:
                path = Path(folder) / f"{len(figures)}.stl"
                trimesh.Trimesh(vertices, faces, process=False).export(path)
                figures[id(faces)] = client.assets.mesh(path)
            batch.add_part(f"part {element}", figures[id(faces)], pose=cell.poses[0][element])


def meanwhile(client: Client, address: str, rows: np.ndarray) -> np.ndarray:
    """Return what calls take (ms) while configurations are checked."""
    ended = threading.Event()

    def work() -> None:
        while not ended.is_set():
            client.collisions.check_configurations("arm0", rows)

    thread = threading.Thread(target=work)
    thread.start()
    try:
        return latencies(unary(address), CALLS)
    finally:
        ended.set()
        thread.join()
