"""Inverse dynamics against pinocchio in the same run: one iiwa, movements drawn by a fresh seed, which it prints."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio  # pyright: ignore[reportMissingImports]  a path file makes it importable
import pybullet_data
from virtualrobot.files.resolver import Resolver
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import ImportedModel, import_model
from virtualrobot_kernel.planning.bodies import bodies_of
from virtualrobot_kernel.planning.dynamics import GRAVITY, solve_inverse_dynamics
from virtualrobot_kernel.planning.dynamics import run as solve_bodies
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import World

from benchmarks.rows import Row, row

IIWA = str(Path(pybullet_data.getDataPath()) / "kuka_iiwa/model.urdf")
SAMPLES = 1000
ROUNDS = 15


def snapshot_of(urdf: str) -> Snapshot:
    """Return a world that holds one robot."""
    store = AssetStore()
    model = import_model(urdf, Files(store, {}, Resolver()), MeshLibrary(store), name="arm")
    assert isinstance(model, ImportedModel)
    world = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, 4_000_000))
    world.start()
    world.submit([CreateNodes(model.nodes)]).result()
    snapshot = world.snapshot
    world.close()
    return snapshot


def fastest(*calls: Callable[[], object]) -> list[float]:
    """Return the least seconds of each call, the calls taken in turn."""
    best = [np.inf] * len(calls)
    for _ in range(ROUNDS):
        for place, call in enumerate(calls):
            start = time.perf_counter()
            call()
            best[place] = min(best[place], time.perf_counter() - start)
    return best


def run() -> list[Row]:
    """Return the time of a sample: bare compiled against compiled, from Python against from Python."""
    seed = secrets.randbits(32)
    print(f"seed of the movements: {seed}")
    rng = np.random.default_rng(seed)
    model = pinocchio.buildModelFromUrdf(IIWA)
    data, pool = model.createData(), pinocchio.ModelPool(model, 1)
    snapshot = snapshot_of(IIWA)
    node = snapshot.structure.node("arm")
    bodies = bodies_of(snapshot, node)
    gravity = np.array(GRAVITY)
    q = rng.uniform(model.lowerPositionLimit, model.upperPositionLimit, (SAMPLES, model.nq))
    v, a = rng.normal(size=(2, SAMPLES, model.nv))
    columns = [np.asfortranarray(values.T) for values in (q, v, a)]
    torques = np.empty((model.nv, SAMPLES), order="F")

    def theirs_one_by_one() -> None:
        for sample in range(SAMPLES):
            pinocchio.rnea(model, data, q[sample], v[sample], a[sample])

    bare, whole, theirs, called = fastest(
        lambda: solve_bodies(bodies, gravity, q, v, a),
        lambda: solve_inverse_dynamics(snapshot, node, (), q, v, a),
        lambda: pinocchio.rneaInParallel(1, pool, *columns, torques),
        theirs_one_by_one,
    )
    error = np.abs(solve_bodies(bodies, gravity, q, v, a)[0] - torques.T).max()
    assert error < 1e-9, f"the torques differ by {error}"
    name, each = "inverse dynamics, 7 axes", 1e6 / SAMPLES
    return [
        row(f"{name}, bare compiled", bare * each, theirs * each, "pinocchio.rneaInParallel, 1 thread", "µs", 1.5),
        row(
            f"{name}, with gravity's part and checks, {SAMPLES} samples",
            whole * each,
            called * each,
            "pinocchio.rnea called from Python",
            "µs",
            None,
        ),
    ]
