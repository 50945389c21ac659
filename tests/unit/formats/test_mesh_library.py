"""Meshes with what they name, parsed once; and the folders in which they travel."""

import hashlib
import json
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
import pytest
from virtualrobot.files.resolver import Resolver
from virtualrobot_kernel.errors import KernelError, MalformedFileError, MissingFileError, Reason
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.bundle import bundle
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.references import list_references
from virtualrobot_kernel.world.figures import Mesh
from virtualrobot_kernel.world.structure import Kind, PartData

from tests.unit.formats.models import (
    DATA,
    TETRAHEDRON,
    TETRAHEDRON_FACES,
    binary_stl,
    disk,
    imported,
    uploaded,
    volume,
)
from tests.unit.formats.test_meshes import BUFFER, dae, gltf_tree, obj_text

STL = binary_stl(TETRAHEDRON, TETRAHEDRON_FACES)
PNG = (DATA / "tex256.png").read_bytes()
TEXTURED = f"mtllib ../looks/t.mtl\nvt 0 0\nvt 1 0\nvt 0 1\n{obj_text()}\nusemtl wood\nf 1/1 2/2 3/3\n".encode()


def find(files: Files, *what: Any, **options: Any) -> tuple[Mesh, tuple[str, ...]]:  # noqa: ANN401  those of `find`
    """Find a mesh with a library of its own."""
    return MeshLibrary(files.store).find(files, *what, **options)


def textured(folder: str = "") -> dict[str, bytes]:
    """Return an OBJ file with a material file in another folder, whose texture is in a third."""
    return {
        f"{folder}meshes/t.obj": TEXTURED,
        f"{folder}looks/t.mtl": b"newmtl wood\nKd 1 1 1\nmap_Kd images\\wood.png\n",
        f"{folder}looks/images/wood.png": PNG,
    }


REFERENCES = {
    "a.urdf": (
        b'<robot name="r"><link name="a"><visual><geometry><mesh filename="package://p/a.stl"/></geometry></visual>'
        b'<collision><geometry><mesh filename="m\\b.stl"/></geometry></collision>'
        b'<visual><geometry><mesh filename="package://p/a.stl"/></geometry></visual></link></robot>',
        ["package://p/a.stl", "m/b.stl"],
    ),
    "a.obj": (b"# mtllib no.mtl\nmtllib my look.mtl\nv 0 0 0\n", ["my look.mtl"]),
    "a.mtl": (
        b"newmtl a\nmap_Kd wood.png\nnewmtl b\n map_Kd  maps\\b.jpg \nmap_Bump c.png\n",
        ["wood.png", "maps/b.jpg"],
    ),
    "a.dae": (
        dae().replace(
            b"<library_geometries>",
            b"<library_images><image id='i'><init_from>./my%20tex.png</init_from></image></library_images>"
            b"<library_effects><effect id='e'><profile_COMMON><newparam sid='s'><surface><init_from>i</init_from>"
            b"</surface></newparam></profile_COMMON></effect></library_effects><library_geometries>",
        ),
        ["my tex.png"],
    ),
    "a.gltf": (
        json.dumps({**gltf_tree({"uri": "a%20b.bin"}), "images": [{"uri": "x.png"}, {"uri": "data:,"}]}).encode(),
        ["a b.bin", "x.png"],
    ),
    "a.stl": (STL, []),
    "a.yaml": (
        b"schema_version: 1\nnodes:\n- figures: [{mesh: {uri: a.obj}}, {box: {}}]\nmodels: [{uri: arm/arm.urdf}]\n",
        ["a.obj", "arm/arm.urdf"],
    ),
    "a.txt": (b"mtllib a.mtl", []),
}


@pytest.mark.parametrize("name", REFERENCES)
def test_what_files_name(name: str) -> None:
    data, expected = REFERENCES[name]
    assert list(list_references(data, f"folder/{name}")) == expected


@pytest.mark.parametrize("name", ["a.urdf", "a.dae", "a.gltf", "a.glb", "a.yaml"])
def test_references_of_broken_files_are_refused(name: str) -> None:
    with pytest.raises(MalformedFileError):
        list_references(b"\xff\x00 no", name)


@pytest.mark.parametrize("folder", ["", "package://p/", "/robots/"])
def test_a_mesh_is_found_with_its_material_and_texture(folder: str) -> None:
    files = uploaded(textured(folder))
    mesh, warnings = find(files, f"{folder}meshes/t.obj")
    assert warnings == ()
    assert [name for name, _ in mesh.files] == ["../looks/t.mtl", "../looks/images/wood.png"]
    parts = MeshLibrary(files.store).load(mesh)
    assert sorted(part.texture is not None for part in parts) == [False, True]


def test_a_missing_texture_is_a_warning_and_a_missing_buffer_an_error() -> None:
    contents = textured()
    del contents["looks/images/wood.png"]
    mesh, (warning,) = find(uploaded(contents), "meshes/t.obj")
    assert [name for name, _ in mesh.files] == ["../looks/t.mtl"]
    assert "'images/wood.png', named by looks/t.mtl, is not there" in warning and "drawn without it" in warning
    with pytest.raises(MissingFileError, match=r"'gone\.bin', named by a\.gltf"):
        find(uploaded({"a.gltf": json.dumps(gltf_tree({"uri": "gone.bin"})).encode()}), "a.gltf")


@pytest.mark.parametrize(
    ("element", "color", "count"),
    [("visual", "", 1), ("visual", '<material name="m"><color rgba="1 0 0 1"/></material>', 0), ("collision", "", 0)],
)
def test_a_look_that_nobody_sees_may_be_missing(element: str, color: str, count: int) -> None:
    contents = textured()
    del contents["looks/t.mtl"]
    shape = '<geometry><mesh filename="meshes/t.obj"/></geometry>'
    urdf = f'<robot name="r"><link name="a"><{element}>{shape}{color}</{element}></link></robot>'
    files = uploaded({**contents, "r.urdf": urdf.encode()})
    assert len(imported("r.urdf", files, MeshLibrary(files.store)).warnings) == count


@pytest.mark.parametrize(
    "name", ["../../x.png", "../../secret", "../../../../../../../../etc/hostname", "/etc/hostname", "secret?v=1"]
)
def test_a_texture_above_its_folder_is_missing_whatever_it_is_called_and_never_read(tmp_path: Path, name: str) -> None:
    folder = tmp_path / "a" / "b"
    folder.mkdir(parents=True)
    for secret in (tmp_path / "x.png", tmp_path / "secret"):
        secret.write_bytes(PNG)
    (folder / "t.obj").write_bytes(TEXTURED.replace(b"../looks/", b""))
    (folder / "t.mtl").write_bytes(f"newmtl wood\nmap_Kd {name}\n".encode())
    (folder / "t.gltf").write_text(json.dumps({**gltf_tree({"uri": "t.bin"}), "images": [{"uri": name}]}))
    (folder / "t.bin").write_bytes(BUFFER)
    for file, named_by in (("t.obj", "t.mtl"), ("t.gltf", "t.gltf")):
        store = AssetStore()
        mesh, (warning,) = find(Files(store, resolver=Resolver()), str(folder / file))
        assert f"{named_by}: '{name}', named by" in warning and warning.endswith("drawn without it")
        assert not store.has(hashlib.sha256(PNG).hexdigest())
        assert MeshLibrary(store).load(mesh)


def test_a_texture_with_a_path_of_another_machine_is_found_beside_the_file() -> None:
    material = b"newmtl wood\nmap_Kd C:\\Users\\me\\wood.png\n"
    contents = {"t.obj": TEXTURED.replace(b"../looks/", b""), "t.mtl": material, "wood.png": PNG}
    files = uploaded(contents)
    mesh, warnings = find(files, "t.obj")
    assert warnings == ()
    assert any(part.texture for part in MeshLibrary(files.store).load(mesh))


def test_an_obj_cannot_take_any_file_of_the_disk_for_its_material(tmp_path: Path) -> None:
    (tmp_path / "models/arm/meshes").mkdir(parents=True)
    (tmp_path / "models/arm/package.xml").write_text("<package><name>arm</name></package>")
    for name in ("../../../passwords", str(tmp_path / "passwords")):
        obj = tmp_path / "models/arm/meshes/t.obj"
        obj.write_bytes(TEXTURED.replace(b"../looks/t.mtl", name.encode() + b".mtl"))
        (tmp_path / "passwords.mtl").write_bytes(b"newmtl wood\nKd 1 0 0\n")
        files = disk()
        mesh, (warning,) = find(files, str(obj))
        assert mesh.files == () and "is not there" in warning


def test_a_mesh_that_has_changed_is_refused() -> None:
    with pytest.raises(MalformedFileError, match=r"t\.stl has changed: its SHA-256 is"):
        find(uploaded({"t.stl": STL}), "t.stl", sha256="0" * 64)


def test_equal_meshes_are_parsed_once_and_scaled_ones_share_faces() -> None:
    files = uploaded({"t.stl": STL, "copy.STL": STL})
    library = MeshLibrary(files.store)
    first = library.load(find(files, "t.stl")[0])
    assert library.load(find(files, "copy.STL")[0]) is first
    double = library.load(find(files, "t.stl", scale=(2.0, 2.0, 2.0))[0])
    assert double is library.load(find(files, "copy.STL", scale=(2.0, 2.0, 2.0))[0])
    assert double[0].faces is first[0].faces
    assert volume(double[0].vertices, double[0].faces) == pytest.approx(0.008, rel=1e-6)


def test_what_was_not_asked_for_longest_is_forgotten() -> None:
    files = uploaded({"a.stl": STL, "b.stl": binary_stl(2.0 * TETRAHEDRON, TETRAHEDRON_FACES)})
    a, b = (find(files, name)[0] for name in ("a.stl", "b.stl"))
    library = MeshLibrary(files.store, limit_bytes=1)
    first = library.load(a)
    assert library.load(a) is first
    library.load(b)
    assert library.load(a) is not first


def test_a_mesh_whose_bytes_are_gone_is_refused() -> None:
    with pytest.raises(KernelError) as caught:
        MeshLibrary(AssetStore()).load(Mesh("t.stl", "0" * 64))
    assert caught.value.reason is Reason.UNKNOWN_ASSET


@pytest.mark.parametrize("as_part", [False, True])
def test_a_mesh_file_gives_one_node(as_part: bool) -> None:
    files = uploaded({"parts/my box.stl": STL})
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    model = imported(
        "parts/my box.stl",
        files,
        MeshLibrary(files.store),
        as_part=as_part,
        scale=(1.0, 1.0, -1.0),
        parent="table",
        parent_t_node=pose,
    )
    (node,) = model.nodes
    assert (node.name, node.parent, model.mesh_count) == ("my box", "table", 1)
    assert node.kind is (Kind.PART if as_part else Kind.OBJECT) and node.data == (PartData() if as_part else None)
    assert node.parent_t_node is pose
    assert node.figures[0].visual and node.figures[0].collision
    assert node.figures[0].geometry == Mesh("parts/my box.stl", files.uploaded["parts/my box.stl"], (1.0, 1.0, -1.0))


@pytest.mark.parametrize("folder", ["package://p/", "/robots/"])
def test_files_that_a_client_names_by_their_whole_names_are_found_and_bundled(folder: str, tmp_path: Path) -> None:
    # So the client library names the files of a mesh that it adds by itself.
    store = AssetStore()
    files = {name: store.put(data) for name, data in textured(folder).items()}
    main = f"{folder}meshes/t.obj"
    mesh = Mesh(main, files.pop(main), files=tuple(files.items()))
    assert any(part.texture for part in MeshLibrary(store).load(mesh))
    places, paths = bundle([mesh])
    unpack(tmp_path, paths, store)
    again, warnings = find(disk(), places[mesh], str(tmp_path / "scene.yaml"))
    assert warnings == () and [name for name, _ in again.files] == ["../looks/t.mtl", "../looks/images/wood.png"]


def unpack(folder: Path, paths: list[tuple[str, str]], store: AssetStore) -> None:
    for path, sha256 in paths:
        assert ".." not in PurePosixPath(path).parts and not PurePosixPath(path).is_absolute()
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(store.get(sha256))


def test_a_bundle_is_found_again_whole(tmp_path: Path) -> None:
    contents = {**textured("package://p/"), "a.gltf": json.dumps(gltf_tree({"uri": "b/buffer.bin"})).encode()}
    files = uploaded({**contents, "b/buffer.bin": BUFFER, "t.stl": STL, "other/t.stl": STL})
    uris = ("package://p/meshes/t.obj", "a.gltf", "t.stl", "other/t.stl")
    meshes = [find(files, uri)[0] for uri in uris]
    meshes.append(find(files, "t.stl", scale=(1.0, -1.0, 1.0))[0])
    places, paths = bundle(meshes)
    assert len(dict(paths)) == len(paths) == 6  # t.obj, t.mtl, wood.png, a.gltf, buffer.bin, and t.stl once
    assert all(place.startswith("assets/") for place in places.values())
    unpack(tmp_path, paths, files.store)
    again = disk()
    for mesh in meshes:
        found, warnings = find(again, places[mesh], str(tmp_path / "scene.yaml"), mesh.scale, mesh.sha256)
        assert warnings == () and found.sha256 == mesh.sha256 and found.files == mesh.files
        assert PurePosixPath(found.uri).name == PurePosixPath(mesh.uri).name


def test_a_bundle_stays_in_its_folder_whatever_files_are_called(tmp_path: Path) -> None:
    store = AssetStore()
    names = ["../../../etc/passwd", "/etc/passwd", "package://p/x.png", "a/../../b.png", "C:\\x\\y.png"]
    sha256 = store.put(STL)
    mesh = Mesh("http://evil/..", sha256, files=tuple((name, store.put(name.encode())) for name in names))
    places, paths = bundle([mesh])
    unpack(tmp_path, paths, store)
    assert len(paths) == 1 + len(names)
    assert (tmp_path / places[mesh]).read_bytes() == STL


def test_meshes_of_one_name_and_other_content_do_not_meet() -> None:
    store = AssetStore()
    meshes = [Mesh(f"{i}/t.stl", store.put(bytes([i]))) for i in range(50)]
    places, paths = bundle(meshes)
    assert len(set(places.values())) == len(paths) == 50
