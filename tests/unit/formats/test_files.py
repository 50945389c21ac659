"""Where a model's files come from: the upload first, then the disk; what is nowhere is named with all places tried."""

from pathlib import Path

import pytest
from virtualrobot.files.resolver import Resolver
from virtualrobot_kernel.errors import KernelError, MissingFileError, Reason
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import Files

from tests.unit.formats.models import disk, uploaded


def test_uploaded_files_by_joined_name_and_by_the_name_as_written() -> None:
    files = uploaded({"package://a/meshes/x.mtl": b"joined", "tex.png": b"as written", "m.urdf": b"main"})
    assert files.read("x.mtl", "package://a/meshes/x.obj").data == b"joined"
    assert files.read("../meshes/x.mtl", "package://a/other/x.obj").key == "package://a/meshes/x.mtl"
    assert files.read("tex.png", "package://a/meshes/x.obj").data == b"as written"
    assert files.read("m.urdf").key == "m.urdf"


def test_the_upload_wins_over_the_disk(tmp_path: Path) -> None:
    (tmp_path / "x.obj").write_bytes(b"disk")
    key = str(tmp_path / "x.obj")
    store = AssetStore()
    files = Files(store, {key: store.put(b"upload")}, Resolver())
    assert files.read(key).data == b"upload"
    assert Files(store, {}, Resolver()).read(key).data == b"disk"


def test_files_of_the_disk_are_kept_and_named_by_their_place(tmp_path: Path) -> None:
    (tmp_path / "robots/meshes").mkdir(parents=True)
    (tmp_path / "robots/meshes/x.obj").write_bytes(b"mesh")
    (tmp_path / "robots/meshes/x.mtl").write_bytes(b"material")
    files = disk()
    mesh = files.read("package://robots/meshes/x.obj", str(tmp_path / "robots/arm.urdf"))
    assert mesh.key == str(tmp_path / "robots/meshes/x.obj")
    assert files.store.get(mesh.sha256) == b"mesh"
    assert files.read("x.mtl", mesh.key).data == b"material"


def test_a_relative_name_in_an_uploaded_file_is_not_looked_for_on_the_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "x.obj").write_bytes(b"secret")
    monkeypatch.chdir(tmp_path)
    store = AssetStore()
    files = Files(store, {"arm.urdf": store.put(b"")}, Resolver())
    with pytest.raises(MissingFileError, match=r"'x\.obj', named by arm\.urdf, is not there; tried uploaded as"):
        files.read("x.obj", "arm.urdf")


def test_the_disk_may_be_forbidden(tmp_path: Path) -> None:
    (tmp_path / "x.obj").write_bytes(b"mesh")
    with pytest.raises(MissingFileError, match="the kernel's disk is not looked at"):
        Files(AssetStore()).read(str(tmp_path / "x.obj"))


def test_what_is_nowhere_is_named_with_each_place(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError) as caught:
        disk().read("meshes/x.obj", str(tmp_path / "arm.urdf"))
    assert str(tmp_path / "meshes/x.obj") in str(caught.value) and str(tmp_path / "arm.urdf") in str(caught.value)
    assert caught.value.metadata["tried"] == str(tmp_path / "meshes/x.obj")


@pytest.mark.parametrize("uri", ["", "/", "/dev/zero", "a\0b", "x" * 5000, "http://example.com/x.obj"])
def test_names_that_are_no_files_are_refused(uri: str) -> None:
    with pytest.raises(MissingFileError):
        disk().read(uri)


def test_a_file_over_the_limit_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "x.obj").write_bytes(bytes(11))
    with pytest.raises(KernelError, match="has 11 bytes; an asset may have at most 10") as caught:
        disk(AssetStore(limit_bytes=10)).read(str(tmp_path / "x.obj"))
    assert caught.value.reason is Reason.TOO_LARGE


def test_an_upload_that_was_only_promised_is_refused() -> None:
    with pytest.raises(KernelError) as caught:
        Files(AssetStore(), {"x.obj": "0" * 64}).read("x.obj")
    assert caught.value.reason is Reason.UNKNOWN_ASSET


def test_what_a_file_of_the_disk_names_lies_in_its_package(tmp_path: Path) -> None:
    for name in ("pkg/package.xml", "pkg/m/x.obj", "pkg/looks/t.mtl", "secret.mtl", "o/t.mtl", "o/package.xml"):
        (tmp_path / "w" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "w" / name).write_text(name)
    files = disk()
    main, secret = files.read(str(tmp_path / "w/pkg/m/x.obj")), tmp_path / "w/secret.mtl"
    assert files.read("../looks/t.mtl", main.key).data == b"pkg/looks/t.mtl"
    assert files.read("package://o/t.mtl", main.key).data == b"o/t.mtl"
    stated = files.read(str(secret)).sha256
    for name in ("../../secret.mtl", str(secret), secret.as_uri(), "package://o/../secret.mtl"):
        with pytest.raises(MissingFileError):
            files.read(name, main.key)
        assert files.read(name, main.key, stated).data == b"secret.mtl"


def test_an_uploaded_file_has_no_own_files_on_the_kernels_disk(tmp_path: Path) -> None:
    for name in ("x.obj", "x.mtl"):
        (tmp_path / name).write_text(name)
    key = str(tmp_path / "x.obj")
    store = AssetStore()
    files = Files(store, {key: store.put(b"mtllib x.mtl")}, Resolver())
    with pytest.raises(MissingFileError):
        files.read(str(tmp_path / "x.mtl"), key)
    assert files.read("package://pybullet_data/r2d2.urdf", key).key.endswith("pybullet_data/r2d2.urdf")
