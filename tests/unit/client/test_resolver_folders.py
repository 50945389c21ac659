"""A resolver that was given folders finds nothing else for who names files in calls, whatever the name looks like."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from virtualrobot.files.resolver import Resolver, UnresolvedUriError


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder that files may be named in, which is the working folder; secrets lie beside it."""
    for name in ("cell/arm.urdf", "cell/meshes/link.stl", "cell/.ssh/key", "secret/key", "cell2/key"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    monkeypatch.chdir(tmp_path / "cell")
    monkeypatch.setenv("VIRTUALROBOT_PACKAGE_PATH", "")
    return tmp_path / "cell"


def test_what_lies_below_is_found_by_each_of_its_names(here: Path) -> None:
    resolver = Resolver(folders=[here])
    mesh = here / "meshes/link.stl"
    for uri in ("meshes/link.stl", "./meshes/../meshes/link.stl", str(mesh), mesh.as_uri(), "../cell/meshes/link.stl"):
        assert resolver.resolve(uri) == mesh, uri
    assert resolver.resolve("meshes/link.stl", here / "arm.urdf") == mesh


TRICKS = (
    "{root}/secret/key",
    "../secret/key",
    "meshes/../../secret/key",
    "{root}/cell/../secret/key",
    "{root}/cell2/key",
    "file://{root}/secret/key",
    "file:{root}/secret/key",
    "file://localhost{root}/secret/key",
    "file://{root}/cell/..%2Fsecret/key",
    "file://{root}/cell/%2e%2e/secret/key",
    "package://secret/key",
    "package://cell/../secret/key",
    "package://cell/..%2Fsecret/key",
    "package://../secret/key",
    "package://./../secret/key",
    "package:///{root}/secret/key",
    "model://secret/key",
    "//{root}/secret/key",
    "..\\secret\\key",
    "{root}/cell/.ssh/key",
    ".ssh/key",
    "{root}/cell/link",
    "link",
    "linked/key",
    "~/secret/key",
    "/etc/passwd",
    "/proc/self/environ",
    "/dev/zero",
    "\\\\?\\{root}\\secret\\key",
)


@pytest.mark.skipif(sys.platform == "win32", reason="links need a right on Windows")
@pytest.mark.parametrize("uri", TRICKS)
def test_what_lies_elsewhere_is_not_found(here: Path, uri: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(here.parent))
    (here / "link").symlink_to(here.parent / "secret/key")
    (here / "linked").symlink_to(here.parent / "secret")
    with pytest.raises(UnresolvedUriError) as error:
        Resolver(folders=[here]).resolve(uri.format(root=here.parent))
    assert not [place for place in error.value.tried if not place.is_relative_to(here)]


def test_whether_it_is_there_is_not_told(here: Path) -> None:
    said = set()
    for name in ("secret/key", "secret/none"):
        with pytest.raises(UnresolvedUriError) as error:
            Resolver(folders=[here]).resolve(str(here.parent / name))
        said.add(str(error.value).replace(name, "X"))
    assert len(said) == 1
    assert f"what calls name must lie below {here} or in a known package" in said.pop()


def test_without_any_folder_known_packages_are_left(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (here.parent / "packages/arms/meshes").mkdir(parents=True)
    mesh = here.parent / "packages/arms/meshes/link.stl"
    mesh.touch()
    monkeypatch.setenv("VIRTUALROBOT_PACKAGE_PATH", str(here.parent / "packages"))
    resolver = Resolver(folders=[])
    assert resolver.resolve("package://arms/meshes/link.stl") == mesh
    assert resolver.resolve(str(mesh)) == mesh
    assert resolver.may_name(mesh) and not resolver.may_name(here / "arm.urdf")
    with pytest.raises(UnresolvedUriError):
        resolver.resolve("arm.urdf")


def test_a_file_names_no_more_than_its_own_folder_whoever_named_it(here: Path) -> None:
    """The folder of the package around it may be wider than what calls may name."""
    (here.parent / "package.xml").write_text("<package><name>wide</name></package>")
    (here / "deep/er").mkdir(parents=True)
    (here / "deep/er/a.obj").touch()
    resolver = Resolver(folders=[here / "deep"])
    assert resolver.resolve(str(here / "deep/er/a.obj"))
    for name in ("../../arm.urdf", "../../../secret/key", str(here.parent / "secret/key")):
        with pytest.raises(UnresolvedUriError):
            resolver.resolve(name, here / "deep/er/a.obj")
    other = Resolver(folders=[here])
    assert other.resolve("deep/er/a.obj")
    (here / "other").mkdir()
    (here / "other/b.mtl").touch()
    (here.parent / "package.xml").unlink()
    again = Resolver(folders=[here])
    again.resolve("deep/er/a.obj")
    with pytest.raises(UnresolvedUriError, match="its own folder"):
        again.resolve("../../other/b.mtl", here / "deep/er/a.obj")
