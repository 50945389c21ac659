"""glTF with a tolerance, read by the rules of KHR_mesh_quantization (Khronos), beside the same without."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.export.model import export_model
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import import_model
from virtualrobot_kernel.world.figures import Box, Figure, Frame, Sphere
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_sdk.glb import unpack_glb

from tests.khronos import NEEDS_VALIDATOR, issues_of
from tests.unit.formats.export.worlds import one, snapshot_of
from tests.unit.formats.models import DATA, ROBOTS, disk

KINDS = {5120: np.int8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}


@pytest.fixture(scope="module")
def world() -> tuple[Snapshot, MeshLibrary]:
    """Return a robot with textures, one with vertex colors, a ball and the axes of a frame."""
    library = MeshLibrary(AssetStore())
    nodes = [one(Figure(Sphere(0.5)), Figure(Frame(0.3)))]
    for file in (ROBOTS["r2d2"], ROBOTS["xarm6"], DATA / "franka_panda/panda.urdf", DATA / "duck.obj"):
        nodes.extend(import_model(str(file), disk(library.store), library).nodes)  # pyright: ignore
    return snapshot_of(nodes), library


def corners(data: bytes) -> dict[str, np.ndarray]:
    """Return the places of all corners (n, 3) of each figure, in the frame of the file."""
    tree, binary = unpack_glb(data)
    found: dict[str, list[np.ndarray]] = {}

    def numbers(index: int) -> np.ndarray:
        told = tree["accessors"][index]
        view, kind = tree["bufferViews"][told["bufferView"]], np.dtype(KINDS[told["componentType"]])
        stride = view.get("byteStride", 3 * kind.itemsize)
        assert stride % 4 == 0
        shape, strides = (told["count"], 3), (stride, kind.itemsize)
        values = np.ndarray(shape, kind, binary, view["byteOffset"], strides)
        return values / np.iinfo(kind).max if told.get("normalized") else values

    def walk(index: int, above: np.ndarray, name: str) -> None:
        node = tree["nodes"][index]
        x, y, z, w = node.get("rotation", (0, 0, 0, 1))
        pose = np.eye(4)
        pose[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        pose[:3, :3] *= node.get("scale", (1, 1, 1))
        pose[:3, 3] = node.get("translation", (0, 0, 0))
        here = above @ pose
        name = node["name"] if " figure " in node["name"] and not node["name"].endswith(" shape") else name
        for primitive in tree["meshes"][node["mesh"]]["primitives"] if "mesh" in node else ():
            places = numbers(primitive["attributes"]["POSITION"])
            found.setdefault(name, []).append(places @ here[:3, :3].T + here[:3, 3])
        for child in node.get("children", ()):
            walk(child, here, name)

    walk(tree["scenes"][0]["nodes"][0], np.eye(4), "")
    return {name: np.vstack(parts) for name, parts in found.items()}


def test_every_figure_is_where_it_was(world: tuple[Snapshot, MeshLibrary]) -> None:
    """Corners of the small file are corners of the large one, rounded, and reach as far in all directions."""
    snapshot, library = world
    full, small = (
        library.store.get(export_model(snapshot, library, "", ".glb", tolerance).files[0][1])
        for tolerance in (0.0, 1e-3)
    )
    assert len(small) < 0.25 * len(full)
    before, after = corners(full), corners(small)
    assert list(before) == list(after)
    for name, places in after.items():
        assert np.abs(places.min(axis=0) - before[name].min(axis=0)).max() <= 1e-3, name
        assert np.abs(places.max(axis=0) - before[name].max(axis=0)).max() <= 1e-3, name


def test_colors_are_factors_on_what_a_texture_shows(world: tuple[Snapshot, MeshLibrary]) -> None:
    """The Panda's rings show grey of a texture, 118 to 145 of 255, under the white of its URDF."""
    snapshot, library = world
    tree, _ = unpack_glb(library.store.get(export_model(snapshot, library, "", ".glb", 1e-3).files[0][1]))
    (mesh,) = [one for one in tree["meshes"] if one["name"] == "finger.obj"]
    grey, white = (tree["materials"][primitive["material"]]["pbrMetallicRoughness"] for primitive in mesh["primitives"])
    assert "baseColorTexture" not in grey and "baseColorTexture" not in white
    # By IEC 61966-2-1 sRGB of 118 and 145 of 255 is linear light of 0.181 and 0.283.
    assert 0.181 < grey["baseColorFactor"][0] < 0.283
    assert white["baseColorFactor"] == [1.0, 1.0, 1.0, 1.0]


def test_a_tolerance_that_integers_cannot_keep_costs_nothing(world: tuple[Snapshot, MeshLibrary]) -> None:
    snapshot, library = world
    fine, full = (export_model(snapshot, library, "", ".glb", tolerance).files for tolerance in (1e-9, 0.0))
    assert fine == full


@pytest.mark.parametrize("tolerance", [-1e-3, float("nan"), float("inf")])
def test_what_is_no_tolerance_is_refused(tolerance: float) -> None:
    box = snapshot_of([one(Figure(Box((1, 1, 1))))])
    with pytest.raises(KernelError, match=r"tolerance_meters is .*valid: 0"):
        export_model(box, MeshLibrary(AssetStore()), "", ".glb", tolerance)


def test_urdf_has_no_tolerance() -> None:
    with pytest.raises(KernelError, match=r"only \.glb"):
        export_model(snapshot_of([one()]), MeshLibrary(AssetStore()), "", ".urdf", 1e-3)


@NEEDS_VALIDATOR
def test_the_validator_of_khronos_finds_nothing(world: tuple[Snapshot, MeshLibrary], tmp_path: Path) -> None:
    snapshot, library = world
    data = library.store.get(export_model(snapshot, library, "", ".glb", 1e-3).files[0][1])
    (tmp_path / "world.glb").write_bytes(data)
    issues = issues_of(tmp_path / "world.glb")
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"][:5]
