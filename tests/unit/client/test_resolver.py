"""The resolver finds what URIs of model files mean, in the stated order, and says where it looked."""

from __future__ import annotations

import hashlib
import os
import re
import sys
from pathlib import Path

import pytest
from virtualrobot.files import packages
from virtualrobot.files.resolver import Resolver, UnresolvedUriError, is_relative, join_uri

GAZEBO_VARIABLES = ("GZ_SIM_RESOURCE_PATH", "GAZEBO_MODEL_PATH", "SDF_PATH")


def make(root: Path, *names: str) -> None:
    """Create empty files below `root`."""
    for name in names:
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()


def declare(folder: Path, name: str) -> None:
    """Write a package.xml that gives the folder a package name."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "package.xml").write_text(f"<package format='3'>\n <name> {name} </name>\n</package>", encoding="utf-8")


@pytest.fixture(autouse=True)
def no_environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Start from an environment that names no packages, and a machine without ROS."""
    monkeypatch.setattr(packages, "ROS_FOLDER", tmp_path / "no ros")
    variables = ("VIRTUALROBOT_PACKAGE_PATH", "ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", *GAZEBO_VARIABLES)
    for variable in variables:
        monkeypatch.delenv(variable, raising=False)


def test_relative_absolute_and_file_uris(tmp_path: Path) -> None:
    make(tmp_path, "model/arm.urdf", "model/meshes/link 0.stl")
    urdf, mesh = tmp_path / "model/arm.urdf", tmp_path / "model/meshes/link 0.stl"
    resolver = Resolver()
    for uri in (
        "meshes/link 0.stl",
        "./meshes/../meshes/link 0.stl",
        "meshes\\link 0.stl",
        str(mesh),
        mesh.as_uri(),
        f"file://localhost{str(mesh).replace(' ', '%20')}",
        "file://meshes/link%200.stl",
    ):
        assert resolver.resolve(uri, urdf) == mesh, uri


def test_relative_without_referrer_counts_from_the_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make(tmp_path, "arm.urdf")
    monkeypatch.chdir(tmp_path)
    assert Resolver().resolve("arm.urdf") == tmp_path / "arm.urdf"


def test_a_told_package_wins_and_is_the_only_place(tmp_path: Path) -> None:
    make(tmp_path, "pkg/urdf/a.urdf", "pkg/x.stl", "told/x.stl", "pkg/y.stl")
    resolver = Resolver({"pkg": tmp_path / "told"})
    assert resolver.resolve("package://pkg/x.stl", tmp_path / "pkg/urdf/a.urdf") == tmp_path / "told/x.stl"
    with pytest.raises(UnresolvedUriError) as refused:
        resolver.resolve("package://pkg/y.stl", tmp_path / "pkg/urdf/a.urdf")
    assert refused.value.tried == (tmp_path / "told/y.stl",)


@pytest.mark.parametrize("variable", ["VIRTUALROBOT_PACKAGE_PATH", "ROS_PACKAGE_PATH"])
def test_the_environment_names_packages_and_folders_of_packages(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, variable: str
) -> None:
    make(tmp_path, "src/repository/arm/x.stl", "src/other_folder/y.stl", "direct/z.stl", "model/a.urdf")
    declare(tmp_path / "src/other_folder", "gripper")
    monkeypatch.setenv(variable, os.pathsep.join([str(tmp_path / "src"), str(tmp_path / "direct")]))
    urdf = tmp_path / "model/a.urdf"
    assert Resolver().resolve("package://arm/x.stl", urdf) == tmp_path / "src/repository/arm/x.stl"
    assert Resolver().resolve("package://gripper/y.stl", urdf) == tmp_path / "src/other_folder/y.stl"
    assert Resolver().resolve("model://direct/z.stl", urdf) == tmp_path / "direct/z.stl"


def test_ament_prefixes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make(tmp_path, "opt/share/arm/meshes/x.stl", "a.urdf")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path / 'none'}{os.pathsep}{tmp_path / 'opt'}")
    assert (
        Resolver().resolve("package://arm/meshes/x.stl", tmp_path / "a.urdf") == tmp_path / "opt/share/arm/meshes/x.stl"
    )


@pytest.mark.parametrize("variable", GAZEBO_VARIABLES)
def test_folders_of_models_of_gazebo(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, variable: str) -> None:
    make(tmp_path, "models/coke_can/meshes/can.dae", "more/table/a.stl", "w/world.sdf", "models/deep/er/x.stl")
    monkeypatch.setenv(variable, os.pathsep.join(["", str(tmp_path / "none"), *map(str, tmp_path.glob("mo*"))]))
    world = tmp_path / "w/world.sdf"
    assert Resolver().resolve("model://coke_can/meshes/can.dae", world) == tmp_path / "models/coke_can/meshes/can.dae"
    assert Resolver().resolve("package://table/a.stl", world) == tmp_path / "more/table/a.stl"
    with pytest.raises(UnresolvedUriError):  # models lie directly in such a folder
        Resolver().resolve("model://er/x.stl", world)


def test_the_environment_goes_before_the_parents(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make(tmp_path, "env/arm/x.stl", "arm/x.stl", "arm/urdf/a.urdf")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "env"))
    assert Resolver().resolve("package://arm/x.stl", tmp_path / "arm/urdf/a.urdf") == tmp_path / "env/arm/x.stl"


def test_parents_by_name_by_package_xml_and_by_what_exists(tmp_path: Path) -> None:
    make(tmp_path, "work/arm/urdf/a.urdf", "work/arm/m/named.stl", "work/renamed/urdf/a.urdf", "work/renamed/m/own.stl")
    declare(tmp_path / "work/renamed", "gripper")
    resolver = Resolver()
    assert resolver.resolve("package://arm/m/named.stl", tmp_path / "work/arm/urdf/a.urdf").name == "named.stl"
    # Declared by package.xml: from inside, and from a neighbour.
    for urdf in ("work/renamed/urdf/a.urdf", "work/arm/urdf/a.urdf"):
        assert resolver.resolve("package://gripper/m/own.stl", tmp_path / urdf) == tmp_path / "work/renamed/m/own.stl"
    # A package that is named by nothing: the folder under which the rest exists.
    found = resolver.resolve("package://whatever/m/named.stl", tmp_path / "work/arm/urdf/a.urdf")
    assert found == tmp_path / "work/arm/m/named.stl"


def test_a_named_folder_goes_before_a_guess(tmp_path: Path) -> None:
    make(tmp_path, "work/models/a.urdf", "work/models/x.stl", "work/arm/x.stl", "work/arm/model.config")
    assert Resolver().resolve("package://arm/x.stl", tmp_path / "work/models/a.urdf") == tmp_path / "work/arm/x.stl"


def test_a_package_of_another_name_is_the_near_folder_with_the_most_of_its_name(tmp_path: Path) -> None:
    make(
        tmp_path, "kuka/kr10/urdf/a.urdf", "kuka/kuka_kr6/m/x.stl", "kuka/kuka_kr16/m/x.stl", "far/kr6/support/m/x.stl"
    )
    for name in ("kuka_kr6", "kuka_kr16", "odd"):
        declare(tmp_path / "kuka" / name, f"another_{name[-1]}")
    found = Resolver().resolve("package://kuka_kr6_support/m/x.stl", tmp_path / "kuka/kr10/urdf/a.urdf")
    assert found == tmp_path / "kuka/kuka_kr6/m/x.stl"
    # A file that only one folder has needs no name.
    make(tmp_path, "kuka/odd/m/only.stl")
    urdf = tmp_path / "kuka/kr10/urdf/a.urdf"
    assert Resolver().resolve("package://zzz/m/only.stl", urdf) == tmp_path / "kuka/odd/m/only.stl"


def test_which_of_several_folders_is_meant_is_not_guessed(tmp_path: Path) -> None:
    make(tmp_path, "robots/a/urdf/a.urdf", "robots/b/m/x.stl", "robots/c/m/x.stl", "robots/package.xml")
    with pytest.raises(UnresolvedUriError) as refused:
        Resolver().resolve("package://zzz/m/x.stl", tmp_path / "robots/a/urdf/a.urdf")
    assert "several folders near it have such a file and none has the package's name" in str(refused.value)
    assert str(tmp_path / "robots/b/m/x.stl") in str(refused.value)
    told = Resolver({"zzz": tmp_path / "robots/c"})
    assert told.resolve("package://zzz/m/x.stl", tmp_path / "robots/a/urdf/a.urdf") == tmp_path / "robots/c/m/x.stl"


def test_a_package_that_is_known_is_not_looked_for_in_others(tmp_path: Path) -> None:
    make(tmp_path, "arm/urdf/a.urdf", "arm_copy/m/x.stl")
    with pytest.raises(UnresolvedUriError, match="VIRTUALROBOT_PACKAGE_PATH") as refused:
        Resolver().resolve("package://arm/m/x.stl", tmp_path / "arm/urdf/a.urdf")
    assert f"; the package 'arm' is {tmp_path / 'arm'}, without 'm/x.stl'; if another is meant" in str(refused.value)


def test_the_search_has_bounds_and_the_error_names_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make(tmp_path, "w/x/y/z/urdf/a.urdf", "w/x/b1/b2/deep/m/x.stl", "w/high/m/y.stl", "w/x/y/z/in/m/z.stl")
    urdf = tmp_path / "w/x/y/z/urdf/a.urdf"
    for name in ("x", "w"):  # one folder too deep, and found only one level above the last
        with pytest.raises(UnresolvedUriError, match="2 levels below those 3 levels above the file have 'm/"):
            Resolver().resolve(f"package://deep/m/{name}.stl", urdf)
    assert Resolver().resolve("package://deep/m/z.stl", urdf) == tmp_path / "w/x/y/z/in/m/z.stl"
    monkeypatch.setattr(packages, "SEARCH_FOLDERS", 1)
    with pytest.raises(UnresolvedUriError):
        Resolver().resolve("package://deep/m/z.stl", urdf)


def test_ros_distributions_of_the_machine_are_found_without_their_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make(tmp_path, "ros/humble/share/arm/m/x.stl", "ros/jazzy/share/arm/m/x.stl", "w/a.urdf")
    monkeypatch.setattr(packages, "ROS_FOLDER", tmp_path / "ros")
    monkeypatch.setattr(sys, "platform", "linux")
    assert Resolver().resolve("package://arm/m/x.stl", tmp_path / "w/a.urdf") == (
        tmp_path / "ros/jazzy/share/arm/m/x.stl"
    )


def test_a_relative_name_may_count_from_a_folder_above(tmp_path: Path) -> None:
    make(tmp_path, "data/car/a.urdf", "data/wheels/x.stl", "data/y.stl", "data/package.xml")
    urdf = tmp_path / "data/car/a.urdf"
    assert Resolver().resolve("wheels/x.stl", urdf) == tmp_path / "data/wheels/x.stl"
    assert Resolver().resolve("/wheels/x.stl", urdf) == tmp_path / "data/wheels/x.stl"
    with pytest.raises(UnresolvedUriError):  # a name without a folder is too common
        Resolver().resolve("y.stl", urdf)


def test_links_to_a_model_find_files_on_both_sides(tmp_path: Path) -> None:
    make(tmp_path, "store/arm/a.urdf", "store/arm/m/x.stl", "cell/y.stl")
    (tmp_path / "cell/a.urdf").symlink_to(tmp_path / "store/arm/a.urdf")
    assert Resolver().resolve("y.stl", tmp_path / "cell/a.urdf") == tmp_path / "cell/y.stl"
    assert Resolver().resolve("m/x.stl", tmp_path / "cell/a.urdf") == tmp_path / "store/arm/m/x.stl"


def test_an_error_lists_every_place_once(tmp_path: Path) -> None:
    make(tmp_path, "arm/urdf/a.urdf")
    with pytest.raises(UnresolvedUriError) as refused:
        Resolver().resolve("package://arm/x.stl", tmp_path / "arm/urdf/a.urdf")
    tried = refused.value.tried
    assert tried[0] == tmp_path / "arm/x.stl"
    assert len(set(tried)) == len(tried)
    assert tmp_path / "arm/urdf/x.stl" in tried
    assert all(str(place) in str(refused.value) for place in tried)
    assert "VIRTUALROBOT_PACKAGE_PATH" in str(refused.value)
    assert isinstance(refused.value, FileNotFoundError)


def test_letter_case_counts_and_is_hinted_at(tmp_path: Path) -> None:
    make(tmp_path, "a.urdf", "Meshes/Link0.STL")
    with pytest.raises(UnresolvedUriError, match=re.escape(f"{tmp_path / 'Meshes/Link0.STL'} differs in letter case")):
        Resolver().resolve("meshes/link0.stl", tmp_path / "a.urdf")


def test_what_is_not_read_is_said(tmp_path: Path) -> None:
    with pytest.raises(UnresolvedUriError, match="https:// is not read"):
        Resolver().resolve("https://example.org/x.stl", tmp_path / "a.urdf")
    if os.name != "nt":
        with pytest.raises(UnresolvedUriError, match="path of Windows"):
            Resolver().resolve(r"C:\models\x.stl", tmp_path / "a.urdf")
    for empty in ("", "package://", "package://arm", "file://"):
        with pytest.raises(UnresolvedUriError):
            Resolver().resolve(empty, tmp_path / "a.urdf")


def test_a_package_of_ros_may_lie_among_those_of_python(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "cmeel.prefix" / "share" / "robots-of-mine"
    (folder / "meshes").mkdir(parents=True)
    (folder / "meshes" / "a.stl").write_bytes(b"")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(UnresolvedUriError):
        Resolver().resolve("package://robots-of-mine/meshes/a.stl")
    (folder / "package.xml").write_text("<package><name>robots-of-mine</name></package>")
    assert Resolver().resolve("package://robots-of-mine/meshes/a.stl") == folder / "meshes" / "a.stl"


def test_a_python_package_is_found_but_not_imported() -> None:
    pytest.importorskip("pybullet_data")
    for name in [name for name in sys.modules if name.startswith("pybullet_data")]:
        del sys.modules[name]
    assert Resolver().resolve("package://pybullet_data/kuka_iiwa/model.urdf").is_file()
    assert "pybullet_data" not in sys.modules


@pytest.mark.parametrize(
    "model",
    ["kuka_iiwa/model.urdf", "franka_panda/panda.urdf", "xarm/xarm6_robot.urdf", "a1/a1.urdf", "husky/husky.urdf",
     "r2d2.urdf"],
)  # fmt: skip
def test_every_mesh_of_real_models_is_found(model: str) -> None:
    data = pytest.importorskip("pybullet_data").getDataPath()
    urdf = Path(data) / model
    text = re.sub(r"<!--.*?-->", "", urdf.read_text(encoding="utf-8"), flags=re.DOTALL)
    uris = set(re.findall(r"<mesh[^>]*filename=\"([^\"]+)\"", text))
    assert uris
    for uri in uris:
        # The files of pybullet_data all lie in the model's folder, so the name alone tells which one is right.
        found = Resolver().resolve(uri, urdf)
        assert str(found).endswith(uri.partition("://")[2].partition("/")[2] if "://" in uri else uri)
        assert urdf.parent in found.parents


def refused(uri: str, referrer: Path | None, resolver: Resolver | None = None) -> str:
    """Return what is said where a file names something that it may not name; None is a file of another machine."""
    resolver = resolver or Resolver()
    with pytest.raises(UnresolvedUriError) as caught:
        resolver.resolve_known(uri) if referrer is None else resolver.resolve(uri, referrer)
    return str(caught.value)


def test_own_files_lie_in_a_package_or_in_the_folder_of_the_model(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make(tmp_path, "ws/pkg/package.xml", "gz/m/model.config", "site/robots/__init__.py")
    monkeypatch.syspath_prepend(str(tmp_path / "site"))
    for file, own in {
        "ws/pkg/a/b/meshes/x.obj": "ws/pkg",
        "gz/m/meshes/x.dae": "gz/m",
        "site/robots/arm/deep/down/below/x.urdf": "site/robots",
        "arm/meshes/visual/x.obj": "arm",
        "arm/urdf/x.urdf": "arm",
        "downloads/x.obj": "downloads",
    }.items():
        assert packages.own_folder(tmp_path / file) == tmp_path / own, file
    monkeypatch.setattr(Path, "home", lambda: Path("/people/me"))
    for file in ("/people/me/x.obj", "/people/me/meshes/x.obj", "/home/you/meshes/x.obj", "/srv/urdf/x.urdf", "/x.obj"):
        assert packages.own_folder(Path(file)) == Path(file).parent, file


def test_what_a_file_names_lies_in_its_own_folder(tmp_path: Path) -> None:
    make(tmp_path, "w/arm/urdf/a.urdf", "w/arm/meshes/x.obj", "w/secret.mtl", "w/arm/.key/s.mtl", "w/arm/t.png")
    mesh, secret, hidden = tmp_path / "w/arm/meshes/x.obj", tmp_path / "w/secret.mtl", tmp_path / "w/arm/.key/s.mtl"
    (tmp_path / "w/arm/meshes/link.mtl").symlink_to(secret)
    (tmp_path / "w/arm/meshes/up").symlink_to(tmp_path / "w")
    ways = ("../../secret.mtl", str(secret), secret.as_uri(), "link.mtl", "up/secret.mtl", "meshes/../../../secret.mtl",
            "package://arm/../secret.mtl", "package://arm//" + str(secret), "package://w/secret.mtl",
            "package://../secret.mtl", "package://arm/%2e%2e/secret.mtl", "package://other/secret.mtl",
            "../.key/s.mtl", str(hidden))  # fmt: skip
    told = [refused(uri, mesh) for uri in ways]
    secret.unlink()
    hidden.unlink()
    assert told == [refused(uri, mesh) for uri in ways], "nor is told what is there"
    assert Resolver().resolve("../t.png", mesh) == tmp_path / "w/arm/t.png"


@pytest.mark.parametrize(
    "uri",
    ["package://etc/passwd", "package://x/etc/passwd", "package://pybullet_data/../../../x", "/etc/passwd",
     "file:///etc/passwd", "~/.profile", "x.stl", "package://./setup.py"],
)  # fmt: skip
def test_a_file_of_another_machine_names_known_packages_alone(uri: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in ("/", str(Path(__file__).parents[3])):
        monkeypatch.chdir(folder)
        monkeypatch.syspath_prepend(folder)
        assert "is not there" in refused(uri, None)
    assert Resolver().resolve_known("package://virtualrobot_plugins/models/puma560.urdf").is_file()


def test_known_packages_may_be_named_by_any_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make(tmp_path, "w/a.urdf", "src/arm/m/x.stl", "told/m/y.stl")
    urdf, mesh = tmp_path / "w/a.urdf", tmp_path / "src/arm/m/x.stl"
    refused(str(mesh), urdf)
    assert Resolver({"p": tmp_path / "told"}).resolve(str(tmp_path / "told/m/y.stl"), urdf).is_file()
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "src"))
    assert Resolver().resolve(str(mesh), urdf) == Resolver().resolve("package://arm/m/x.stl", urdf) == mesh


def test_a_package_installed_by_links_to_its_sources_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make(tmp_path, "src/arm/m/x.stl", "src/secret.stl", "w/a.urdf", "install/share/arm/n")
    declare(tmp_path / "src/arm", "arm")
    installed = tmp_path / "install/share/arm"
    for name, target in {"package.xml": "arm/package.xml", "m": "arm/m", "s.stl": "secret.stl"}.items():
        (installed / name).symlink_to(tmp_path / "src" / target)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    assert Resolver().resolve("package://arm/m/x.stl", tmp_path / "w/a.urdf") == installed / "m/x.stl"
    refused("package://arm/s.stl", tmp_path / "w/a.urdf")


def test_what_states_its_content_may_lie_anywhere(tmp_path: Path) -> None:
    make(tmp_path, "scenes/a.yaml")
    mesh = tmp_path / "x.stl"
    mesh.write_bytes(b"mesh")
    scene, stated = tmp_path / "scenes/a.yaml", hashlib.sha256(b"mesh").hexdigest()
    assert Resolver().resolve(str(mesh), scene, stated.upper()) == mesh
    for wrong in ("", stated[:-1], hashlib.sha256(b"").hexdigest()):
        with pytest.raises(UnresolvedUriError):
            Resolver().resolve(str(mesh), scene, wrong)


def test_the_textures_of_a_mesh_may_lie_beside_the_model_that_names_it(tmp_path: Path) -> None:
    make(tmp_path, "arm/urdf/a.urdf", "arm/meshes/link0/x.dae", "arm/textures/t.png", "arm/t.png")
    resolver = Resolver()
    mesh = resolver.resolve("../meshes/link0/x.dae", tmp_path / "arm/urdf/a.urdf")
    assert resolver.resolve("../../textures/t.png", mesh) == tmp_path / "arm/textures/t.png"
    refused("../../../t.png", mesh, resolver)
    refused("../../textures/t.png", mesh)


def test_joined_names() -> None:
    assert join_uri("package://a/meshes/x.obj", "x.mtl") == "package://a/meshes/x.mtl"
    assert join_uri("package://a/meshes/x.obj", "../textures/t.png") == "package://a/textures/t.png"
    assert join_uri("/home/me/arm.urdf", "./meshes/x.stl") == "/home/me/meshes/x.stl"
    assert join_uri("arm.urdf", "meshes\\x.stl") == "meshes/x.stl"
    assert join_uri("C:\\models\\arm.urdf", "x.stl") == "C:/models/x.stl"
    assert join_uri("arm.urdf", "../x.stl") == "../x.stl"
    for absolute in ("package://b/y.stl", "/y.stl", "file:///y.stl", "C:/y.stl"):
        assert join_uri("/home/me/arm.urdf", absolute) == absolute
        assert not is_relative(absolute)
