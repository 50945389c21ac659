"""What the viewer costs its process: 50 moving iiwa arms with a browser connected, against bare viser in the same run.

Both draw the same poses at the same rate. Bare viser gets them ready-made as quaternions and 32-bit positions, in one
batch for each link; ours gets snapshots and makes the rest itself. A picture counts only when the browser got it.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from pathlib import Path

import numpy as np
import viser
from numpy.typing import NDArray
from virtualrobot_kernel.drawing.batches import wxyz_of
from virtualrobot_kernel.drawing.inventory import take
from virtualrobot_kernel.drawing.view import ViewStore
from virtualrobot_kernel.drawing.viewer import Viewer
from virtualrobot_kernel.world.commands import SetJointPositions
from virtualrobot_kernel.world.figures import Mesh
from virtualrobot_kernel.world.state import Snapshot

from benchmarks.rows import Row, row
from tests.drawing.cell import Cell, at

ARMS = 50
RATE = 30.0
SECONDS = 8.0
PICTURES = 60
"""So many different snapshots are made before the measurement and shown in turn."""

BUDGET = 20.0
"""Percent of one core."""


def moving_arms() -> tuple[Cell, list[Snapshot]]:
    """Return a cell with the arms, and snapshots of them in motion."""
    cell = Cell()
    for arm in range(ARMS):
        cell.load("kuka_iiwa/model.urdf", f"arm{arm}", at(1.5 * (arm % 10), 1.5 * (arm // 10), 0.0))
    snapshots = []
    for picture in range(PICTURES):
        angle = 2.0 * np.pi * picture / PICTURES
        moves = [
            SetJointPositions(f"arm{arm}", coordinates=np.sin(angle + arm + np.arange(7.0))) for arm in range(ARMS)
        ]
        cell.do(*moves)
        snapshots.append(cell.snapshot)
    return cell, snapshots


@contextmanager
def browser(url: str) -> Iterator[Callable[[], int]]:
    """Connect what stands in for a browser; give a function that ends it and returns how many messages it took."""
    program = Path(__file__).parent / "browser.py"
    process = subprocess.Popen(
        [sys.executable, program, url.rpartition(":")[2]], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "connected\n"

    def end() -> int:
        process.terminate()
        assert process.stdout is not None
        lines = process.stdout.read().split()
        return int(lines[-1]) if lines else 0

    try:
        yield end
    finally:
        process.kill()
        process.wait()


def share(show: Callable[[int], None]) -> float:
    """Call `show` with the number of each picture, at the rate; return percent of a core that this process took."""
    for picture in range(int(2 * RATE)):  # until everything has been sent once
        show(picture)
        time.sleep(1.0 / RATE)
    cpu, start = time.process_time(), time.perf_counter()
    pictures = int(SECONDS * RATE)
    for picture in range(pictures):
        show(picture)
        time.sleep(max(0.0, start + (picture + 1) / RATE - time.perf_counter()))
    return 100.0 * (time.process_time() - cpu) / (time.perf_counter() - start)


def ours(cell: Cell, snapshots: list[Snapshot]) -> tuple[float, int]:
    """Return the share of the viewer, and the messages that the browser took."""
    now = [snapshots[0]]

    def show(picture: int) -> None:
        now[0] = snapshots[picture % PICTURES]

    viewer = Viewer(lambda: now[0], ViewStore(), cell.meshes, rate=RATE)
    viewer.start()
    try:
        with browser(viewer.url) as end:
            return share(show), end()
    finally:
        viewer.close()


def bare(cell: Cell, snapshots: list[Snapshot]) -> tuple[float, int]:
    """Return the share of viser alone, and the messages that the browser took."""
    inventory = take(snapshots[0].structure, {})
    groups = [(key[0], batch) for key, batch in inventory.batches.items()]
    poses: list[list[tuple[NDArray, NDArray]]] = []
    for snapshot in snapshots:
        placed = [snapshot.world_t_node[batch.rows] @ batch.node_t_shape for _, batch in groups]
        poses.append([(wxyz_of(pose[:, :3, :3]), pose[:, :3, 3].astype(np.float32)) for pose in placed])
    with redirect_stdout(StringIO()):
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    handles = []
    for index, (mesh, _) in enumerate(groups):
        assert isinstance(mesh, Mesh)
        (part,) = cell.meshes(mesh)
        wxyzs, positions = poses[0][index]
        handles.append(
            server.scene.add_batched_meshes_simple(f"/link/{index}", part.vertices, part.faces, wxyzs, positions)
        )

    def show(picture: int) -> None:
        with server.atomic():
            for handle, (wxyzs, positions) in zip(handles, poses[picture % PICTURES], strict=True):
                handle.batched_wxyzs = wxyzs
                handle.batched_positions = positions

    try:
        with browser(f"http://127.0.0.1:{server.get_port()}") as end:
            return share(show), end()
    finally:
        with redirect_stdout(StringIO()):
            server.stop()


def run() -> list[Row]:
    """Measure and return the rows."""
    cell, snapshots = moving_arms()
    bare_share, bare_messages = bare(cell, snapshots)
    our_share, our_messages = ours(cell, snapshots)
    name = f"viewer, {ARMS} iiwa at {RATE:.0f} Hz"
    unit = "% of a core"
    note = f"the browser took {our_messages} messages from ours and {bare_messages} from bare viser"
    return [
        row(f"{name}, against bare viser", our_share, bare_share, "viser, batched, poses ready-made", unit, None, note),
        row(f"{name}, against the budget", our_share, BUDGET, "budget", unit, 1.0),
    ]


if __name__ == "__main__":
    for result in run():
        print(result)
