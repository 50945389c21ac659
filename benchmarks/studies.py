"""Studies beside a bare pool that keeps nothing; what a cell costs beside its function, and a pose and a place do."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import wait
from pathlib import Path
from typing import Any

import numpy as np
from loky import ProcessPoolExecutor
from virtualrobot_apps.studies.engines import Engine, Here, Local
from virtualrobot_apps.studies.ray_engine import Ray
from virtualrobot_apps.studies.reach import orientations
from virtualrobot_apps.studies.running import open_job
from virtualrobot_apps.studies.running import run as run_job
from virtualrobot_apps.studies.study_file import read_study
from virtualrobot_apps.studies.worlds import open_world

from benchmarks.rows import Row, row

WORKERS, ROUNDS = 2, 3
CELLS, LONG, BLOCK, CELL_SECONDS = 1000, 3000, 50, 0.01
EMPTY_CELLS = 20_000
POSES, TARGETS, PLACES = 1000, 12, 50
FURNITURE = """
- name: table
  object: {}
  parent_t_node: {position: {z: -0.03}}
  figures: [{box: {size: {x: 2, y: 2, z: 0.04}}}]
"""
MODEL = """
models: [{uri: "model://ur5e", name: arm}]
"""
# "DH Parameters for calculations of kinematics and dynamics", Universal Robots: UR5e, m.
TABLE = """
models:
- name: arm
  denavit_hartenberg:
    convention: DENAVIT_HARTENBERG_CONVENTION_STANDARD
    rows:
    - {d_meters: 0.1625, alpha_radians: 1.5707963267948966, LIMITS}
    - {a_meters: -0.425, LIMITS}
    - {a_meters: -0.3922, LIMITS}
    - {d_meters: 0.1333, alpha_radians: 1.5707963267948966, LIMITS}
    - {d_meters: 0.0997, alpha_radians: -1.5707963267948966, LIMITS}
    - {d_meters: 0.0996, LIMITS}
""".replace("LIMITS", "limits: {lower: -3.14159, upper: 3.14159}")
MESH = """
- name: mesh {number}
  object: {{}}
  parent_t_node: {{position: {{x: {x:.3f}, y: {y:.3f}, z: {z:.3f}}}}}
  figures: [{{mesh: {{uri: "package://pybullet_data/teddy2_VHACD_CHs.obj", scale: {{x: 0.1, y: 0.1, z: 0.1}}}}}}]
"""
FUNCTIONS = """
from benchmarks.studies import spin

def spun(cell):
    spin()
    return {"y": cell.rng.normal()}

def empty(cell):
    return {"y": cell.rng.normal()}
"""
STUDY = """
schema_version: 1
function: cells:{function}
block: {block}
draws: {cells}
parameters: {{x: {{range: [0, 1]}}, u: {{law: norm}}}}
results: {{y: number}}
"""


def run() -> list[Row]:
    """Measure and return the rows."""
    ours, bare = [], []
    for _ in range(ROUNDS):
        bare.append(_bare())
        ours.append(_study("spun", CELLS, BLOCK, Local(WORKERS)))
    ray, loky = _clustered()
    each = 1e3 * _study("empty", EMPTY_CELLS, 1000, Here()) / EMPTY_CELLS
    what = f"{CELLS} cells of 10 ms by {WORKERS} workers, which start for it"
    return [
        # At least 0.9 of what the pool does.
        row(what, float(np.median(ours)), float(np.median(bare)), "bare pool of loky", "s", 1.0 / 0.9),
        # At least 0.85 of what loky does, which starts its workers within it too.
        row(f"{LONG} of them by a Ray cluster of two nodes of a core", ray, loky, "loky", "s", 1.0 / 0.85),
        row("a cell beside its function, two parameters drawn", each, 1.0, "1 ms", "ms", 1.0),
        *_asked("by its DH table, alone", TABLE, "", 0),
        *_asked("by its DH table, among 50 meshes", TABLE, "", 50),
        *_asked("on a table", MODEL, FURNITURE, 0),
        *_asked("on a table, among 50 meshes", MODEL, FURNITURE, 50),
    ]


def _asked(where: str, robot: str, nodes: str, meshes: int) -> list[Row]:
    """Return what poses and places of a UR5e's base cost one core, in process time."""
    angles = 2.0 * np.pi * np.arange(meshes) / max(meshes, 1)
    around = zip(0.85 * np.cos(angles), 0.85 * np.sin(angles), np.linspace(0.1, 0.6, meshes), strict=True)
    nodes += "".join(MESH.format(number=number, x=x, y=y, z=z) for number, (x, y, z) in enumerate(around))
    with tempfile.TemporaryDirectory() as name:
        file = Path(name) / "cell.yaml"
        file.write_text("schema_version: 1\n" + (f"nodes:\n{nodes}" if nodes else "") + robot)
        world = open_world(file)
    try:
        rng = np.random.default_rng(1)
        poses = np.tile(np.eye(4), (POSES, 1, 1))
        poses[:, :3, :3] = rng.permutation(orientations(POSES, 1))
        poses[:, :3, 3] = rng.uniform([-0.8, -0.8, 0.0], 0.8, (POSES, 3))
        world.postures("arm", poses[:10])
        each = 1e3 * _least(lambda: world.postures("arm", poses)) / POSES

        def place() -> None:
            for number in range(PLACES):
                world.restore()
                base = np.eye(4)
                base[0, 3] = 1e-3 * number
                world.place("arm", base)
                world.postures("arm", poses[:TARGETS])
                world.contacts("arm")

        places = 1e3 * _least(place) / PLACES
    finally:
        world.close()
    return [
        row(
            f"a pose of a UR5e {where}: all branches, and what they touch",
            each,
            0.05,
            "20,000 poses a second",
            "ms",
            None if nodes else 1.0,  # the budget is that of an arm alone
        ),
        # 15 s of two cores for 500 of them.
        row(
            f"a place of its base {where}, with {TARGETS} targets", places, 60.0, "500 in 15 s on two cores", "ms", 1.0
        ),
    ]


def _least(work: Callable[[], object]) -> float:
    """Return the least process time (s) of three runs."""
    times = []
    for _ in range(3):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def spin() -> None:
    """Compute for as long as a cell takes."""
    end = time.process_time() + CELL_SECONDS
    while time.process_time() < end:
        pass


def _block(count: int) -> None:
    for _ in range(count):
        spin()


def _bare() -> float:
    start = time.perf_counter()
    with ProcessPoolExecutor(WORKERS) as pool:
        wait([pool.submit(_block, BLOCK) for _ in range(CELLS // BLOCK)])
        return time.perf_counter() - start


def _clustered() -> tuple[float, float]:
    """Return the times (s) that a Ray cluster of two nodes, which runs already, and workers here take: medians."""
    import ray
    from ray.cluster_utils import Cluster

    # Ray has its workers give way to all else: beside other work they would hardly run.
    os.environ |= {"RAY_worker_niceness": "0", "RAY_USAGE_STATS_ENABLED": "0", "PYTHONPATH": os.getcwd()}
    cluster: Any = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    try:
        cluster.add_node(num_cpus=1)
        pairs = [
            (_study("spun", LONG, BLOCK, Ray(cluster.address)), _study("spun", LONG, BLOCK, Local(WORKERS)))
            for _ in range(ROUNDS)
        ]
    finally:
        ray.shutdown()
        cluster.shutdown()
    on_ray, here = np.median(pairs, axis=0).tolist()
    return on_ray, here


def _study(function: str, cells: int, block: int, engine: Engine) -> float:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "cells.py").write_text(FUNCTIONS)
        (folder / "study.yaml").write_text(STUDY.format(function=function, cells=cells, block=block))
        start = time.perf_counter()
        progress = run_job(open_job(read_study(folder / "study.yaml"), folder / "out", False), engine)
        assert progress.done == cells
        return time.perf_counter() - start


if __name__ == "__main__":
    for result in run():
        print(result)
