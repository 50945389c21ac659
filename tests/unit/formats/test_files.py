"""Where a model's files come from: the upload first, then the disk; what is nowhere is named with all places tried."""

from pathlib import Path

import pytest
from virtualrobot.resolver import Resolver
from virtualrobot_kernel.errors import KernelError, MissingFileError, Reason
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import Files, home_of

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


def test_packages_are_folders_that_the_request_tells(tmp_path: Path) -> None:
    (tmp_path / "checkout").mkdir()
    (tmp_path / "checkout/x.obj").write_bytes(b"mesh")
    files = Files(AssetStore(), {"arm.urdf": "0" * 64}, Resolver({"arm_description": str(tmp_path / "checkout")}))
    assert files.read("package://arm_description/x.obj", "arm.urdf").data == b"mesh"


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
    # A name with a folder in it may count from the two folders above as well.
    places = [tmp_path, tmp_path.parent, tmp_path.parent.parent]
    assert caught.value.metadata["tried"] == ", ".join(str(place / "meshes/x.obj") for place in places)


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


def tree(root: Path, *names: str) -> None:
    """Write files that hold their own name."""
    for name in names:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(name)


def test_a_files_own_files_lie_in_its_package(tmp_path: Path) -> None:
    tree(tmp_path, "ws/pkg/package.xml", "ws/pkg/a/b/meshes/x.obj", "gz/m/model.config", "gz/m/meshes/x.dae")
    assert home_of(tmp_path / "ws/pkg/a/b/meshes/x.obj") == tmp_path / "ws/pkg"
    assert home_of(tmp_path / "gz/m/meshes/x.dae") == tmp_path / "gz/m"
    assert home_of(Path("/srv/robots/arm/meshes/visual/x.obj")) == Path("/srv/robots/arm")
    assert home_of(Path("/home/me/x.obj")) == Path("/home")  # never the root of the disk
    assert home_of(Path("/x.obj")) == Path("/")


def test_only_files_of_the_package_are_read_where_that_is_asked(tmp_path: Path) -> None:
    tree(tmp_path, "w/pkg/package.xml", "w/pkg/m/x.obj", "w/pkg/looks/t.mtl", "w/secret.mtl", "w/other/t.mtl")
    tree(tmp_path, "w/other/package.xml")
    files = disk()
    main = files.read(str(tmp_path / "w/pkg/m/x.obj"))
    homes = files.homes(main)
    assert files.read("../looks/t.mtl", main.key, homes).data == b"w/pkg/looks/t.mtl"
    for name in ("../../secret.mtl", str(tmp_path / "w/secret.mtl"), (tmp_path / "w/secret.mtl").as_uri()):
        assert files.read(name, main.key).data == b"w/secret.mtl"
        with pytest.raises(MissingFileError, match="which is not taken, since it is outside of the model's folder"):
            files.read(name, main.key, homes)
    # Who names a package means it.
    assert files.read("package://other/t.mtl", main.key, homes).data == b"w/other/t.mtl"


def test_an_uploaded_file_has_no_own_files_on_the_kernels_disk(tmp_path: Path) -> None:
    tree(tmp_path, "x.obj", "x.mtl")
    key = str(tmp_path / "x.obj")
    store = AssetStore()
    files = Files(store, {key: store.put(b"mtllib x.mtl")}, Resolver())
    homes = files.homes(files.read(key))
    assert homes == ()
    with pytest.raises(MissingFileError):
        files.read(str(tmp_path / "x.mtl"), key, homes)
