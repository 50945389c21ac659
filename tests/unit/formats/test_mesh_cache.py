"""Meshes from the disk: what comes back is what was parsed, to the last bit, and what is broken is parsed anew."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from virtualrobot.files.resolver import Resolver
from virtualrobot_kernel.formats import mesh_cache, mesh_library
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_cache import MeshCache
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.meshes import parse_mesh
from virtualrobot_kernel.shapes.submesh import Submesh

from tests.unit.formats.models import DATA

TEXTURED = "franka_panda/meshes/visual/link1.obj"
MESHES = (TEXTURED, "kuka_iiwa/meshes/link_0.obj", "kuka_iiwa/meshes/link_3.stl", "a1/meshes/trunk.obj")
CONTENT = (".obj", "abc", ())


def assert_same(ours: tuple[Submesh, ...], theirs: tuple[Submesh, ...]) -> None:
    """Assert that submeshes are the same to the last bit, types and orders among them."""
    assert len(ours) == len(theirs)
    for one, other in zip(ours, theirs, strict=True):
        for field in fields(Submesh):
            mine, its = getattr(one, field.name), getattr(other, field.name)
            if isinstance(its, np.ndarray):
                assert (mine.dtype, mine.shape, mine.tobytes()) == (its.dtype, its.shape, its.tobytes())
                assert mine.flags.c_contiguous and not mine.flags.writeable
            else:
                assert mine == its


def some(rng: np.random.Generator, vertices: int = 50, faces: int = 80) -> Submesh:
    """Return a submesh with everything that one may have."""
    arrays = [
        np.float32(rng.normal(size=(vertices, 3))),
        np.int32(rng.integers(0, vertices, (faces, 3))),
        np.float32(rng.normal(size=(vertices, 3))),
        np.uint8(rng.integers(0, 256, (vertices, 4))),
        np.float32(rng.normal(size=(vertices, 2))),
    ]
    for array in arrays:
        array.setflags(write=False)
    corners, triangles, normals, colors, uv = arrays
    return Submesh(corners, triangles, normals, (0.1, 0.2, 1.0 / 3.0, 1.0), colors, uv, rng.bytes(30))


@pytest.mark.parametrize("name", MESHES)
def test_a_kernel_that_starts_later_has_the_same_triangles(tmp_path: Path, name: str) -> None:
    store = AssetStore()
    first = MeshLibrary(store, cache=MeshCache(tmp_path))
    mesh, _ = first.find(Files(store, {}, Resolver()), str(DATA / name))
    bare = MeshLibrary(store).load(mesh)
    assert_same(first.load(mesh), bare)
    with mock.patch.object(mesh_library, "parse_mesh", side_effect=AssertionError("it is there")):
        again = MeshLibrary(store, cache=MeshCache(tmp_path)).load(mesh)
        assert_same(again, bare)
    if name == TEXTURED:
        texture = next(part.texture for part in again if part.texture)
        assert any(texture is store.get(sha256) for _, sha256 in mesh.files)  # the image is in memory once


def test_everything_that_a_submesh_has_comes_back(tmp_path: Path, rng: np.random.Generator) -> None:
    cache = MeshCache(tmp_path)
    whole = some(rng)
    bare = replace(whole, normals=None, color=None, vertex_colors=None, uv=None, texture=None)
    named = {"wood.png": rng.bytes(40)}
    parts = (whole, bare, replace(whole, texture=named["wood.png"]))
    assert cache.get(CONTENT, named) is None
    cache.put(CONTENT, named, parts)
    found = cache.get(CONTENT, named)
    assert found is not None
    assert_same(found, parts)
    assert cache.get((".obj", "abc", (("wood.png", "def"),)), named) is None


def test_a_file_that_is_broken_anywhere_counts_for_nothing(tmp_path: Path, rng: np.random.Generator) -> None:
    cache = MeshCache(tmp_path)
    cache.put(CONTENT, {}, (some(rng, 5, 4),))
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    for at in range(0, len(whole), 7):
        broken = bytearray(whole)
        broken[at] ^= 1 << int(rng.integers(8))
        file.write_bytes(broken)
        assert cache.get(CONTENT, {}) is None
        file.write_bytes(whole[:at])
        assert cache.get(CONTENT, {}) is None
    file.write_bytes(whole)
    assert cache.get(CONTENT, {}) is not None


def test_a_broken_file_is_replaced(tmp_path: Path) -> None:
    store = AssetStore()
    mesh, _ = MeshLibrary(store).find(Files(store, {}, Resolver()), str(DATA / TEXTURED))
    bare = MeshLibrary(store, cache=MeshCache(tmp_path)).load(mesh)
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2])
    assert_same(MeshLibrary(store, cache=MeshCache(tmp_path)).load(mesh), bare)
    assert file.read_bytes() == whole


def test_another_parser_finds_nothing(tmp_path: Path, rng: np.random.Generator) -> None:
    cache = MeshCache(tmp_path)
    cache.put(CONTENT, {}, (some(rng),))
    with mock.patch.object(mesh_cache, "_parser", lambda: "one of another version"):
        assert cache.get(CONTENT, {}) is None
    assert cache.get(CONTENT, {}) is not None


def test_what_was_not_asked_for_longest_makes_room(tmp_path: Path, rng: np.random.Generator) -> None:
    part = some(rng)
    size = part.size_bytes
    cache = MeshCache(tmp_path, limit_bytes=10 * size)
    for number in range(40):
        cache.put((".obj", str(number), ()), {}, (part,))
        assert cache.get((".obj", "0", ()), {}) is not None  # asked for all the time
    assert sum(file.stat().st_size for file in tmp_path.iterdir()) <= 11 * size
    assert cache.get((".obj", "39", ()), {}) is not None
    assert cache.get((".obj", "1", ()), {}) is None


def test_one_that_is_larger_than_a_quarter_is_left_out(tmp_path: Path, rng: np.random.Generator) -> None:
    part = some(rng)
    MeshCache(tmp_path, limit_bytes=3 * part.size_bytes).put(CONTENT, {}, (part,))
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_made_costs_nothing_else(tmp_path: Path, rng: np.random.Generator) -> None:
    (tmp_path / "file").write_bytes(b"")
    cache = MeshCache(tmp_path / "file" / "meshes")
    cache.put(CONTENT, {}, (some(rng),))
    assert cache.get(CONTENT, {}) is None


def test_small_files_are_parsed_each_time(tmp_path: Path) -> None:
    data = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    store = AssetStore()
    files = Files(store, {"a.obj": store.put(data)})
    library = MeshLibrary(store, cache=MeshCache(tmp_path))
    mesh, _ = library.find(files, "a.obj")
    assert_same(library.load(mesh), parse_mesh(data, "a.obj"))
    assert list(tmp_path.iterdir()) == []
