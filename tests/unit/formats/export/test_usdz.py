"""Stills as USDZ: archives by Pixar's specification, read and judged by its own library, beside their glTF."""

from __future__ import annotations

import io
import struct
import zipfile
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from virtualrobot.files.usdz import ALIGNMENT, usdz_of
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.export.model import export_model
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import import_model
from virtualrobot_kernel.world.figures import Box, Cone, Figure, Frame, Material, Mesh

from tests.unit.formats.export.glb_reading import Glb, checked
from tests.unit.formats.export.worlds import one, snapshot_of
from tests.unit.formats.models import DATA, ROBOTS, disk

pytest.importorskip("pxr", reason="usd-core has no wheel for this machine")
PARTS = "Gf", "Usd", "UsdGeom", "UsdShade", "UsdUtils", "UsdValidation"
Gf, Usd, UsdGeom, UsdShade, UsdUtils, UsdValidation = (import_module(f"pxr.{part}") for part in PARTS)


def world() -> bytes:
    """Return a world as GLB: a robot, a texture, colours of vertices, a cone that one sees through, and lines."""
    nodes, library = [], MeshLibrary(AssetStore())
    for file in (ROBOTS["xarm6"], DATA / "duck.obj"):
        nodes.extend(import_model(str(file), disk(library.store), library).nodes)  # pyright: ignore
    body = trimesh.creation.box((0.1, 0.2, 0.3))
    body.visual.vertex_colors = [[10 * row, 128, 255, 255] for row in range(len(body.vertices))]  # pyright: ignore
    painted = Mesh("a.glb", library.store.put(body.export(file_type="glb")))  # pyright: ignore[reportArgumentType]
    cone = Figure(Cone(0.1, 0.3), material=Material((1.0, 0.5, 0.0, 0.5)))
    nodes.append(one(Figure(painted), cone, Figure(Frame()), Figure(Box((0.1, 0.1, 0.1)))))
    ((_, sha256),) = export_model(snapshot_of(nodes), library, "", ".glb").files
    return library.store.get(sha256)


def corners_of(glb: Glb) -> np.ndarray:
    """Return the corners (n, 3) of all triangles of a GLB file, in its frame."""
    poses, found = glb.poses(), []
    for node in glb.json["nodes"]:
        for part in glb.json["meshes"][node["mesh"]]["primitives"] if "mesh" in node else ():
            if part.get("mode", 4) == 4:
                points = glb.array(part["attributes"]["POSITION"])[glb.array(part["indices"]).ravel()]
                found.append(points @ poses[node["name"]][:3, :3].T + poses[node["name"]][:3, 3])
    return np.concatenate(found)


def test_a_still_is_what_the_gltf_file_shows(tmp_path: Path) -> None:
    glb = world()
    data = usdz_of(glb)
    assert usdz_of(glb) == data
    # The archive: nothing compressed, each file's data at a multiple of 64 bytes, the scene first.
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        entries = archive.infolist()
        assert entries[0].filename == "cell.usda" and archive.testzip() is None
        for entry in entries:
            name, extra = struct.unpack_from("<HH", data, entry.header_offset + 26)
            assert entry.compress_type == zipfile.ZIP_STORED
            assert (entry.header_offset + 30 + name + extra) % ALIGNMENT == 0
        with Image.open(io.BytesIO(archive.read("textures/0.png"))) as ours, Image.open(DATA / "duckCM.png") as theirs:
            assert np.array_equal(np.asarray(ours.convert("RGB")), np.asarray(theirs.convert("RGB")))

    # What Pixar's validators say of it, as a package.
    file = tmp_path / "cell.usdz"
    file.write_bytes(data)
    stage = Usd.Stage.Open(str(file))
    context = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
    assert [error.GetErrorAsString() for error in context.Validate(stage)] == []
    assert UsdGeom.GetStageUpAxis(stage) == "Y" and UsdGeom.GetStageMetersPerUnit(stage) == 1.0

    # All triangles are where they are in the glTF file; single precision is written with six figures.
    cache, found = UsdGeom.XformCache(), []
    meshes = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    for prim in meshes:
        mesh, pose = UsdGeom.Mesh(prim), np.array(cache.GetLocalToWorldTransform(prim))
        points = np.array(mesh.GetPointsAttr().Get(), float)[np.array(mesh.GetFaceVertexIndicesAttr().Get())]
        found.append(points @ pose[:3, :3] + pose[3, :3])
    wanted, seen = corners_of(checked(glb)), np.concatenate(found)
    assert seen.shape == wanted.shape
    assert np.abs(np.sort(seen, axis=0) - np.sort(wanted, axis=0)).max() < 1e-5

    # Each has its look: colours in linear light, a texture, colours of its vertices, and one to see through.
    sources, opacities = set(), set()
    for prim in meshes:
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        shader, *_ = material.ComputeSurfaceSource()
        color = shader.GetInput("diffuseColor")
        sources.add(color.GetConnectedSources()[0][0].source.GetPrim().GetName() if color.HasConnectedSource() else "")
        opacities.add(round(shader.GetInput("opacity").Get(), 3))
        if not color.HasConnectedSource() and opacities == {0.5}:
            assert Gf.IsClose(color.Get(), Gf.Vec3f(1.0, 0.2140411, 0.0), 1e-5)  # IEC 61966-2-1
    assert sources == {"", "Texture", "Colors"} and opacities == {0.5, 1.0}
    # It names nothing but what is in the archive.
    assert UsdUtils.ExtractExternalReferences(str(file)) == ([], ["textures/0.png"], [])
