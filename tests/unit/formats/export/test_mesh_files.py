"""Files beside a URDF file: names that differ, dependents that are found, OBJ for what few programs read."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.export.mesh_files import MeshFiles
from virtualrobot_kernel.formats.export.obj import write_obj
from virtualrobot_kernel.formats.export.stl import write_stl
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.meshes import parse_mesh
from virtualrobot_kernel.shapes.primitives import box, sphere
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.figures import Capsule, Cone, Mesh

from tests.unit.formats.models import TETRAHEDRON, TETRAHEDRON_FACES, binary_stl, disk

STL = binary_stl(TETRAHEDRON, TETRAHEDRON_FACES)


def png(color: tuple[int, int, int]) -> bytes:
    image = io.BytesIO()
    Image.new("RGB", (2, 2), color).save(image, "PNG")
    return image.getvalue()


def part(shape: Submesh, **look: object) -> Submesh:
    return Submesh(shape.vertices, shape.faces, shape.normals, **look)  # pyright: ignore[reportArgumentType]  the test's own


def test_equal_meshes_are_one_file_and_others_have_names_that_differ() -> None:
    library = MeshLibrary(AssetStore())
    files = MeshFiles(library, "meshes")
    first, other = library.store.put(STL), library.store.put(STL + b" ")
    assert files.path(Mesh("a/Link 1.STL", first)) == "meshes/Link_1.stl"
    assert files.path(Mesh("a/Link 1.STL", first, (2.0, 1.0, 1.0))) == "meshes/Link_1.stl", "the scale is not in it"
    assert files.path(Mesh("elsewhere/other.stl", first)) == "meshes/Link_1.stl", "the same bytes"
    assert files.path(Mesh("b/link_1.stl", other)) == "meshes/link_1_2.stl", "some disks take cases for the same"
    assert files.path(Mesh("c/link_1.stl", other, files=(("a.png", first),))) == "meshes/link_1_3/link_1.stl"
    assert [files.path(Cone(0.1, 0.2)), files.path(Cone(0.1, 0.2)), files.path(Cone(0.1, 0.3))] == [
        "meshes/cone.stl",
        "meshes/cone.stl",
        "meshes/cone_2.stl",
    ]
    assert files.path(Capsule(0.1, 0.2)) == "meshes/capsule.stl"
    assert list(files.written)[:4] == [
        "meshes/Link_1.stl",
        "meshes/link_1_2.stl",
        "meshes/link_1_3/link_1.stl",
        "meshes/link_1_3/a.png",
    ]
    assert files.warnings == []


def test_dependents_are_found_where_the_mesh_looks_for_them(tmp_path: Path) -> None:
    """An OBJ below one folder whose material and texture are in others."""
    library = MeshLibrary(AssetStore())
    source = tmp_path / "source"
    for folder in ("meshes", "looks/images"):
        (source / folder).mkdir(parents=True)
    texture = png((200, 100, 50))
    (source / "meshes/a.obj").write_text(
        "mtllib ../looks/a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n"
    )
    (source / "looks/a.mtl").write_text("newmtl m\nKd 1 1 1\nmap_Kd images/a.png\n")
    (source / "looks/images/a.png").write_bytes(texture)
    mesh, _ = library.find(disk(library.store), str(source / "meshes/a.obj"))
    files = MeshFiles(library, "meshes")
    path = files.path(mesh)
    for name, sha256 in files.written.items():
        (tmp_path / "copy" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "copy" / name).write_bytes(library.store.get(sha256))
    assert all(name.startswith("meshes/a/") for name in files.written)
    copied, warnings = library.find(disk(library.store), str(tmp_path / "copy" / path))
    assert warnings == () and [sha for _, sha in copied.files] == [sha for _, sha in mesh.files]
    (read,) = library.load(copied)
    assert read.texture == texture


def test_a_binary_stl_is_what_trimesh_reads() -> None:
    shape = sphere()
    read = trimesh.load_mesh(io.BytesIO(write_stl(shape)), "stl")
    assert read.is_watertight and read.volume == pytest.approx(4 / 3 * np.pi, rel=0.02)
    assert np.abs(read.triangles - shape.vertices[shape.faces]).max() < 1e-8
    normals = np.frombuffer(write_stl(shape), np.dtype([("n", "<f4", 3), ("r", "V38")]), offset=84)["n"]
    assert np.abs(normals - read.face_normals).max() < 1e-4


def test_other_formats_become_obj(tmp_path: Path) -> None:
    library = MeshLibrary(AssetStore())
    body = trimesh.creation.box((0.1, 0.2, 0.3))
    # trimesh writes the factor as it is, and glTF means linear light: 0.2 is 0.4845 in sRGB (IEC 61966-2-1).
    body.visual = TextureVisuals(material=PBRMaterial(baseColorFactor=[255, 0, 51, 255]))
    mesh = Mesh("part.glb", library.store.put(body.export(file_type="glb")), (2.0, 2.0, 2.0))  # pyright: ignore
    files = MeshFiles(library, "meshes")
    assert files.path(mesh) == "meshes/part.obj"
    assert list(files.written) == ["meshes/part.obj", "meshes/part.mtl"]
    assert len(files.warnings) == 1 and "part.glb" in files.warnings[0]
    data = {name.removeprefix("meshes/"): library.store.get(sha256) for name, sha256 in files.written.items()}
    (read,) = parse_mesh(data["part.obj"], "part.obj", data)
    assert np.ptp(read.vertices, axis=0) == pytest.approx([0.1, 0.2, 0.3]), "the scale is the URDF's"
    assert read.color == pytest.approx((1.0, 0.0, 0.4845, 1.0), abs=1 / 255)


def test_obj_keeps_colours_textures_and_normals(rng: np.random.Generator) -> None:
    texture, uv = png((10, 200, 30)), rng.uniform(size=(24, 2)).astype(np.float32)
    normals = box().normals
    assert normals is not None
    parts = (
        Submesh(box().vertices, box().faces, -normals, color=(0.25, 0.5, 0.75, 0.5)),
        part(box(), uv=uv, texture=texture),
        part(box(), uv=uv, texture=texture),
        Submesh(box().vertices, box().faces),
    )
    files = write_obj(parts, "a")
    assert list(files) == ["a.obj", "a.mtl", "a_1.png"] and files["a_1.png"] == texture
    # Readers sort the parts by their materials.
    read = sorted(
        parse_mesh(files["a.obj"], "a.obj", files), key=lambda one: (one.texture is not None, one.color or ())
    )
    plain, grey, first, second = read
    assert plain.color == pytest.approx((0.25, 0.5, 0.75, 0.5), abs=1 / 255)
    assert grey.color == pytest.approx((0.72, 0.74, 0.77, 1.0), abs=1 / 255)
    assert first.texture == second.texture == texture and first.uv is not None
    assert np.abs(first.uv[first.faces] - uv[box().faces]).max() < 1e-6
    for one in read:
        assert np.array_equal(one.vertices[one.faces], box().vertices[box().faces])
    for one, before in ((plain, parts[0]), (first, parts[1]), (second, parts[2])):
        assert one.normals is not None and before.normals is not None
        assert np.abs(one.normals[one.faces] - before.normals[before.faces]).max() < 1e-5


def test_obj_keeps_colours_of_vertices(rng: np.random.Generator) -> None:
    colors = rng.integers(0, 256, (24, 4), dtype=np.uint8)
    colors[:, 3] = 255
    files = write_obj((part(box(), vertex_colors=colors),), "a")
    assert list(files) == ["a.obj"]
    (read,) = parse_mesh(files["a.obj"], "a.obj", files)
    assert read.vertex_colors is not None
    assert np.abs(read.vertex_colors[read.faces].astype(int) - colors[box().faces]).max() <= 1
    mixed = write_obj((part(box(), color=(1.0, 0.0, 0.0, 1.0)), part(box(), vertex_colors=colors)), "a")
    looks = [(one.color, one.vertex_colors is None) for one in parse_mesh(mixed["a.obj"], "a.obj", mixed)]
    assert sorted(looks, key=str) == [((1.0, 0.0, 0.0, 1.0), True), (None, False)]
