"""AssetService: files by content; a model that the kernel cannot see comes whole from its client."""

from __future__ import annotations

import hashlib
import shutil
import threading
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import grpc
import numpy as np
import pytest
from virtualrobot.v1 import asset_pb2, kernel_pb2, nodes_pb2, scene_pb2

from tests.api.asking import MODELS, load, refusal
from tests.api.reading import scene, unchanged
from tests.kernels import Stubs

MEBIBYTE = 1024 * 1024
Upload, Find, References = asset_pb2.UploadAssetRequest, asset_pb2.FindAssetsRequest, asset_pb2.ListReferencesRequest


def sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def chunks(data: bytes, stated: str, size: int = MEBIBYTE) -> Iterator[asset_pb2.UploadAssetRequest]:
    """Yield a file in chunks; the first says its SHA-256."""
    yield Upload(sha256=stated)
    for start in range(0, len(data), size):
        yield Upload(chunk=data[start : start + size])


def upload(stubs: Stubs, data: bytes) -> str:
    return stubs.asset.UploadAsset(chunks(data, sha256(data))).sha256


def download(stubs: Stubs, key: str) -> list[bytes]:
    return [answer.chunk for answer in stubs.asset.DownloadAsset(asset_pb2.DownloadAssetRequest(sha256=key))]


@pytest.mark.parametrize("size", [0, 1, MEBIBYTE, 5 * MEBIBYTE + 17])
def test_bytes_come_back_as_they_went(stepped: Stubs, rng: np.random.Generator, size: int) -> None:
    data = rng.bytes(size)
    answer = stepped.asset.UploadAsset(chunks(data, sha256(data).upper(), int(rng.integers(MEBIBYTE // 2, MEBIBYTE))))
    assert (answer.sha256, answer.size_bytes) == (sha256(data), size)
    parts = download(stepped, answer.sha256)
    assert b"".join(parts) == data
    assert all(len(part) <= MEBIBYTE for part in parts)


def test_find_tells_which_of_the_asked_ones_are_held(stepped: Stubs, rng: np.random.Generator) -> None:
    held = [upload(stepped, rng.bytes(100)) for _ in range(2)]
    unknown = sha256(rng.bytes(100))
    asked = [held[1], unknown, "nonsense", held[0]]
    assert list(stepped.asset.FindAssets(Find(sha256s=asked)).sha256s) == [held[1], held[0]]
    assert upload(stepped, download(stepped, held[0])[0]) == held[0], "the same bytes again cost nothing"


def test_uploads_that_do_not_match_are_refused(stepped: Stubs, rng: np.random.Generator) -> None:
    data = rng.bytes(1000)
    key = sha256(data)
    wrong = refusal(lambda: stepped.asset.UploadAsset(chunks(data[:-1], key)))
    assert (wrong.code, wrong.reason) == (grpc.StatusCode.INVALID_ARGUMENT, "MALFORMED_ASSET")
    assert (wrong.metadata["stated_sha256"], wrong.metadata["sha256"]) == (key, sha256(data[:-1]))
    for messages in ([Upload(chunk=data)], [], [Upload(sha256="abc", chunk=data)]):
        assert refusal(lambda m=messages: stepped.asset.UploadAsset(iter(m))).reason == "MALFORMED_ASSET"
    assert not stepped.asset.FindAssets(Find(sha256s=[key, sha256(data[:-1])])).sha256s


@pytest.mark.long
def test_oversized_chunks_and_files_are_refused(stepped: Stubs) -> None:
    large = refusal(lambda: stepped.asset.UploadAsset(iter([Upload(sha256="0" * 64, chunk=bytes(MEBIBYTE + 1))])))
    assert (large.code, large.reason) == (grpc.StatusCode.RESOURCE_EXHAUSTED, "TOO_LARGE")
    assert str(MEBIBYTE) in large.message
    limit = stepped.kernel.GetInfo(kernel_pb2.GetInfoRequest()).max_asset_bytes
    chunk, sent = bytes(MEBIBYTE), 0

    def endless() -> Iterator[asset_pb2.UploadAssetRequest]:
        nonlocal sent
        while sent <= 2 * limit:
            sent += len(chunk)
            yield Upload(sha256="0" * 64, chunk=chunk)

    refused = refusal(lambda: stepped.asset.UploadAsset(endless()))
    assert refused.reason == "TOO_LARGE"
    assert (refused.metadata["limit_bytes"], int(refused.metadata["size_bytes"]) > limit) == (str(limit), True)
    assert sent < 2 * limit, "refused before the end"


def test_an_upload_that_breaks_off_leaves_nothing(stepped: Stubs, rng: np.random.Generator) -> None:
    data = rng.bytes(3 * MEBIBYTE)
    half = data[: 2 * MEBIBYTE]

    begun = threading.Event()

    def broken() -> Iterator[asset_pb2.UploadAssetRequest]:
        yield from chunks(half, sha256(data))
        begun.wait()
        call.cancel()
        yield Upload(chunk=data[2 * MEBIBYTE :])

    call = stepped.asset.UploadAsset.future(broken())
    begun.set()
    with pytest.raises(grpc.FutureCancelledError):
        call.result(30)
    assert not stepped.asset.FindAssets(Find(sha256s=[sha256(data), sha256(half)])).sha256s
    assert upload(stepped, data) == sha256(data), "the next one is none the worse"


def test_what_is_not_held_is_refused(stepped: Stubs, rng: np.random.Generator) -> None:
    key = sha256(rng.bytes(10))
    unknown = refusal(lambda: download(stepped, key))
    assert (unknown.code, unknown.reason) == (grpc.StatusCode.NOT_FOUND, "UNKNOWN_ASSET")
    assert unknown.metadata["sha256"] == key
    assert refusal(lambda: download(stepped, "abc")).reason == "MALFORMED_ASSET"
    assert refusal(lambda: stepped.asset.ListReferences(References(sha256=key, uri="a.urdf"))).reason == "UNKNOWN_ASSET"
    figure = nodes_pb2.Figure(mesh=nodes_pb2.Mesh(uri="a.stl", sha256=key))
    node = nodes_pb2.Node(name="a", object=nodes_pb2.SceneObject(), figures=[figure])
    command = scene_pb2.Command(create_node=scene_pb2.CreateNode(node=node))
    with unchanged(stepped):
        refused = refusal(lambda: stepped.scene.Apply(scene_pb2.ApplyRequest(commands=[command])))
    assert refused.reason in ("UNKNOWN_ASSET", "MISSING_FILE")


def references(stubs: Stubs, key: str, uri: str) -> list[str]:
    return [file.uri for file in stubs.asset.ListReferences(References(sha256=key, uri=uri)).files]


def test_references_are_listed_as_written(stepped: Stubs) -> None:
    path = MODELS / "franka_panda/panda.urdf"
    meshes = {mesh.get("filename") for mesh in ElementTree.parse(path).iterfind(".//mesh")}  # another parser
    assert set(references(stepped, upload(stepped, path.read_bytes()), "panda.urdf")) == meshes
    assert references(stepped, upload(stepped, b"mtllib a b.mtl\nv 0 0 0\n"), "x.OBJ") == ["a b.mtl"]
    assert references(stepped, upload(stepped, b"newmtl m\nmap_Kd wood.png\n"), "a b.mtl") == ["wood.png"]
    assert references(stepped, upload(stepped, b"solid\nendsolid\n"), "x.stl") == []
    assert refusal(lambda: references(stepped, upload(stepped, b"<robot"), "x.urdf")).reason == "MALFORMED_FILE"


@pytest.mark.parametrize(("folder", "main"), [("kuka_iiwa", "model.urdf"), ("franka_panda", "panda.urdf")])
def test_a_model_that_the_kernel_cannot_see_comes_from_its_client(
    stepped: Stubs, tmp_path: Path, folder: str, main: str
) -> None:
    """The client sends what each file names; then the files are gone from the disk that both share in this test."""
    copy = tmp_path / "client" / folder
    shutil.copytree(MODELS / folder, copy)
    files: dict[str, str] = {}

    def send(uri: str, path: Path) -> None:
        if uri in files or not path.exists():
            return
        files[uri] = upload(stepped, path.read_bytes())
        parent, slash, _ = uri.rpartition("/")
        for name in references(stepped, files[uri], uri):
            if name.startswith("package://"):
                places = [above / name.removeprefix("package://") for above in (copy, copy.parent)]
                send(name, next(place for place in places if place.exists()))
            else:
                send(f"{parent}{slash}{name}", path.parent / name)

    send(main, copy / main)
    shutil.rmtree(copy.parent)
    assets = [nodes_pb2.AssetFile(uri=uri, sha256=key) for uri, key in files.items()]
    sent = load(stepped, main, "sent", files=assets)
    urdf = ElementTree.parse(MODELS / folder / main)
    assert sent.mesh_count == len(list(urdf.iterfind(".//mesh"))) > 15, "as many as the file names"
    seen = load(stepped, str(MODELS / folder / main), "seen")
    assert (sent.mesh_count, len(sent.warnings)) == (seen.mesh_count, len(seen.warnings))
    poses = scene(stepped)
    for created in seen.created:
        twin = "sent" + created.name.removeprefix("seen")
        assert np.array_equal(poses[twin], poses[created.name])
    nodes = {node.name: node for node in stepped.scene.GetScene(scene_pb2.GetSceneRequest()).nodes}
    hashes = {
        name: [figure.mesh.sha256 for node in nodes.values() if node.name.startswith(name) for figure in node.figures]
        for name in ("sent", "seen")
    }
    assert hashes["sent"] == hashes["seen"], "the very same meshes"


MATERIAL = b"mtllib %s\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
TEXTURED = b"newmtl m\nmap_Kd %s\n"
WORLD = (
    b'#VRML V2.0 utf8\nShape { appearance Appearance { texture ImageTexture { url "%s" } } geometry IndexedFaceSet {'
    b" coord Coordinate { point [0 0 0, 1 0 0, 0 1 0] } coordIndex [0 1 2 -1] } }\n"
)


@pytest.mark.parametrize("way", ["material", "texture", "vrml"])
@pytest.mark.parametrize(
    "name",
    [
        "{}",
        "file://{}",
        "package://pybullet_data{up}{}",
        "package://p/{}",
        "package://x{}",
        "package://pybullet_data/{}",
    ],
)
def test_an_uploaded_mesh_reads_no_file_of_the_kernels_disk(
    stepped: Stubs, tmp_path: Path, way: str, name: str
) -> None:
    """The secret is on the disk of the kernel, which these tests share; whether it is there makes no difference."""
    secret = tmp_path / "secret.png"
    named = name.format(secret, up="/.." * len(MODELS.parts)).encode()
    main = b"x.wrl" if way == "vrml" else b"x.obj"
    sent = {main: (WORLD if way == "vrml" else MATERIAL) % (b"x.mtl" if way == "texture" else named)}
    if way == "texture":
        sent[b"x.mtl"] = TEXTURED % named
    files = [nodes_pb2.AssetFile(uri=uri.decode(), sha256=upload(stepped, data)) for uri, data in sent.items()]
    told = []
    content = str(tmp_path).encode()
    for there in (False, True):
        if there:
            secret.write_bytes(content)
        answer = load(stepped, main.decode(), f"mesh_{len(told)}", files=files)
        mesh = next(node for node in nodes(stepped) if node.name == f"mesh_{len(told)}").figures[0].mesh
        assert {file.sha256 for file in mesh.files} <= {file.sha256 for file in files}
        told.append(list(answer.warnings))
    assert told[0] == told[1]
    assert not stepped.asset.FindAssets(Find(sha256s=[sha256(content)])).sha256s


def nodes(stubs: Stubs) -> list[nodes_pb2.Node]:
    return list(stubs.scene.GetScene(scene_pb2.GetSceneRequest()).nodes)


ROBOT = """<robot name="r"><link name="a"/>
<link name="b">{}</link><joint name="j" type="continuous"><parent link="a"/>
<child link="b"/><limit velocity="1"/>{}</joint></robot>"""
SPHERE = '<visual><geometry><sphere radius="1"/></geometry><material name="m"><color rgba="{}"/></material></visual>'


@pytest.mark.parametrize(
    ("look", "mimic", "srdf", "warning"),
    [
        ("", '<mimic joint="nobody"/>', "", "r.urdf:2: joint 'j': it mimics 'nobody', which is no joint; it moves by "),
        (SPHERE.format("1 0 0 1 1"), "", "", "r.urdf:2: material 'm': rgba='1 0 0 1 1' has 5 numbers; the first 4 are"),
        (SPHERE.format("9 0 0 1"), "", "", "r.urdf:2: material 'm': rgba='9 0 0 1': each part is from 0 to 1, and the"),
        ("", "", '<group name="g">\n<joint name="i"/></group>', "r.srdf:2: there is no joint named 'i'; there are"),
        ("", "", '<group name="g">\n<link name="c"/></group>', "r.srdf:2: there is no link named 'c'; there are"),
        ("", "", '\n\n<disable_collisions link1="a" link2="d"/>', "r.srdf:3: there is no link named 'd'; there are"),
        ("", "", '<group_state name="s" group="h"/>', "r.srdf:1: there is no group named 'h'; there is none yet"),
        ("", "", '<group_state name="s"/>', "r.srdf:1: group_state: <group_state> needs the attribute 'group'"),
    ],
)
def test_a_warning_has_file_and_line_and_is_refused_where_that_is_asked(
    stepped: Stubs, look: str, mimic: str, srdf: str, warning: str
) -> None:
    texts = {"folder/r.urdf": ROBOT.format(look, mimic), "folder/r.srdf": f'<robot name="r">{srdf}</robot>'}
    files = [nodes_pb2.AssetFile(uri=uri, sha256=upload(stepped, text.encode())) for uri, text in texts.items()]
    (told,) = load(stepped, "folder/r.urdf", files=files, srdf_uri="folder/r.srdf").warnings
    assert told.text.startswith(warning)
    assert (told.file, told.line) == (f"folder/{warning[:6]}", int(warning.split(":")[1]))
    model = "{uri: folder/r.urdf, srdf_uri: folder/r.srdf, name: again}"
    request = scene_pb2.LoadSceneRequest(text=f"schema_version: 1\nmodels:\n- {model}\n", files=files, add=True)
    assert list(stepped.scene.LoadScene(request).warnings) == [told]
    request.text = request.text.replace("again", "third")
    request.strict = True
    with unchanged(stepped):
        refused = [
            refusal(lambda: load(stepped, "folder/r.urdf", files=files, srdf_uri="folder/r.srdf", strict=True)),
            refusal(lambda: stepped.scene.LoadScene(request)),
        ]
    for one in refused:
        assert (one.reason, one.message) == ("MALFORMED_FILE", told.text)
        assert (one.metadata["file"], one.metadata["line"]) == (told.file, str(told.line))


def test_a_missing_upload_names_the_file_and_what_was_tried(stepped: Stubs) -> None:
    text = b"""<robot name="r"><link name="a"><visual><geometry><mesh filename="package://mine/a.stl"/></geometry>
    </visual></link></robot>"""
    files = [nodes_pb2.AssetFile(uri="r.urdf", sha256=upload(stepped, text))]
    with unchanged(stepped):
        refused = refusal(lambda: load(stepped, "r.urdf", files=files))
    assert (refused.code, refused.reason) == (grpc.StatusCode.NOT_FOUND, "MISSING_FILE")
    assert "package://mine/a.stl" in refused.message
    assert refused.metadata["tried"]
