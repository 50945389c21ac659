"""What models cost to load, and what it costs to find their files, against PyBullet on the same files."""

from __future__ import annotations

import itertools
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import pybullet
import pybullet_data
from virtualrobot.files.resolver import Resolver
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.components.importing import Importers
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_cache import MeshCache
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import ImportedModel, import_model

from benchmarks.rows import Row, row

DATA = Path(pybullet_data.getDataPath())
URDFS = {
    "iiwa": "kuka_iiwa/model.urdf",
    "Panda": "franka_panda/panda.urdf",
    "A1": "a1/a1.urdf",
}
XACROS = {"KR 210": "model://kr210", "Ridgeback": "model://ridgeback"}
ROUNDS = 3
LOOKUPS = 200
FIRST_BUDGET, KEPT_BUDGET = 2.0, 0.8


def seconds(call: Callable[[], object]) -> float:
    """Return the least time of a call."""
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times)


def loaded(uri: str, importers: Importers, cache: MeshCache | None = None) -> ImportedModel:
    """Load a model with nothing kept from before, or only on the disk; the importer's process runs already."""
    store = AssetStore()
    model = import_model(uri, Files(store, {}, Resolver()), MeshLibrary(store, importers, cache=cache))
    assert isinstance(model, ImportedModel)
    return model


def in_pybullet(path: Path) -> None:
    """Load a model into a fresh world of PyBullet, which parses its meshes too."""
    client = pybullet.connect(pybullet.DIRECT)
    pybullet.loadURDF(str(path), physicsClientId=client)
    pybullet.disconnect(client)


def resolving(importers: Importers) -> list[Row]:
    """Return what it costs to find a file by a package that is named as its folder, and by one that is not."""
    iiwa = DATA / URDFS["iiwa"]
    resolver = Resolver()
    plain = "package://pybullet_data/kuka_iiwa/meshes/link_0.obj"
    renamed = "package://some_other_name/meshes/link_0.obj"

    def each(call: Callable[[], object]) -> float:
        return seconds(lambda: [call() for _ in range(LOOKUPS)]) / LOOKUPS * 1e6

    bare = each((DATA / "kuka_iiwa/meshes/link_0.obj").is_file)
    rows = []
    for what, uri in (("a Python package", plain), ("a package named otherwise, by search", renamed)):
        resolver.resolve(uri, iiwa)
        took = each(lambda uri=uri: resolver.resolve(uri, iiwa))
        rows.append(row(f"a file of {what} resolved", took, bare, "is_file of the right path", "µs", None))
    return rows


def beside_pybullet(name: str, path: Path, importers: Importers) -> list[Row]:
    """Return what a model costs the first time, when its meshes are parsed and kept, and from the disk."""
    count = loaded(str(path), importers).mesh_count
    peer = seconds(lambda: in_pybullet(path))
    with tempfile.TemporaryDirectory() as folder:
        fresh = itertools.count()
        first = seconds(lambda: loaded(str(path), importers, MeshCache(Path(folder) / str(next(fresh)))))
        kept = MeshCache(Path(folder) / "0")
        again = seconds(lambda: loaded(str(path), importers, kept))
    return [
        row(f"{name} loaded the first time, {count} meshes", first, peer, "PyBullet", "s", FIRST_BUDGET),
        row(f"{name} loaded from the cache, {count} meshes", again, peer, "PyBullet", "s", KEPT_BUDGET),
    ]


def run() -> list[Row]:
    """Measure and return the rows."""
    importers = Importers(Catalog())
    rows = []
    try:
        for name, file in URDFS.items():
            rows.extend(beside_pybullet(name, DATA / file, importers))
        for name, uri in XACROS.items():
            took = seconds(lambda uri=uri: loaded(uri, importers))
            meshes = loaded(uri, importers).mesh_count
            rows.append(row(f"{name} from xacro loaded, {meshes} meshes", took, 1.0, "one second", "s", None))
        rows.extend(resolving(importers))
    finally:
        importers.close()
    return rows


if __name__ == "__main__":
    for result in run():
        print(result)
