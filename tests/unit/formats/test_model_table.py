"""The table of known models: each that is installed can be imported by name alone."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from virtualrobot.files.resolver import Resolver
from virtualrobot.v1 import scene_pb2
from virtualrobot_kernel.errors import KernelError, MalformedFileError, MissingFileError, UnknownNameError
from virtualrobot_kernel.formats import model_table
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.model_table import KnownModel, find, list_models, named_by
from virtualrobot_kernel.formats.models import import_model
from virtualrobot_kernel.scenes.models import read_model
from virtualrobot_kernel.world.structure import JointType, Kind, LinkData

from tests.tiers import every_fifth
from tests.unit.formats.models import XacroAndSdf, disk, imported, uploaded

ROOT = Path(__file__).resolve().parents[3]
STORE = AssetStore()
LIBRARY = MeshLibrary(STORE, XacroAndSdf())
INSTALLED = [model for model in list_models() if model.installed]


@pytest.mark.parametrize("model", every_fifth(INSTALLED), ids=lambda model: model.name)
def test_every_installed_model_is_imported_by_its_name(model: KnownModel) -> None:
    request = scene_pb2.ModelSource(uri=f"model://{model.name}")
    found = read_model(LIBRARY, request, Files(STORE, {}, Resolver()), ())
    robot, *others = found.nodes
    links = [node for node in others if node.kind is Kind.LINK]
    assert robot.kind is Kind.ROBOT and links
    if model.name == "wsg50":
        text = Resolver().resolve(model.uri).read_text()
        assert found.mesh_count == len(re.findall("<mesh>", text)) > 0
    else:
        assert robot.name == model.name
    # What the description says: the axes that can be moved by themselves.
    said = re.search(r"\b(\d+) axes", model.description)
    if said and "gripper" not in model.description and "fingers" not in model.description:
        joints = [node.data.joint for node in links if isinstance(node.data, LinkData)]
        assert sum(j.type is not JointType.FIXED and j.mimic is None for j in joints) == int(said[1])


def test_the_table_has_what_the_project_promises() -> None:
    names = {model.name for model in list_models()}
    assert names >= {
        *("iiwa", "panda", "xarm6", "a1", "laikago", "husky", "r2d2", "racecar", "wsg50", "puma560", "irb140"),
        *("kr3", "kr5", "kr6_r700", "kr6_r900", "kr10", "kr16", "kr120", "kr150", "kr210", "iiwa14"),
        *("ridgeback", "al5d"),
        *("px100", "px150", "rx150", "rx200", "vx250", "vx300", "vx300s", "wx200", "wx250", "wx250s"),
    }
    assert [model.name for model in list_models()] == sorted(names)
    assert all(re.fullmatch(r"[a-z0-9_]+", name) for name in names)
    assert all(model.installed for model in list_models())  # the tests' own environment has both packages
    assert all(model.description and model.license for model in list_models())
    own = "ar_manipulator conveyor nine_axis palletizer parallel_gripper positioner puma560 rail"
    assert [model.name for model in list_models() if not model.package] == own.split()


def test_a_name_that_is_not_in_the_table_is_refused_with_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="there is no model named 'pumma560'; did you mean 'puma560'"):
        import_model("model://pumma560", disk(), LIBRARY)


def test_a_model_whose_package_is_not_installed_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    table = (KnownModel("far", "x", "package://not_installed_anywhere/far.urdf", "far-data"),)
    monkeypatch.setattr(model_table, "list_models", lambda: table)
    assert not table[0].installed
    with pytest.raises(MissingFileError, match="'far' comes with the Python package far-data: pip install far-data"):
        import_model("model://far", disk(), LIBRARY)


def test_who_leaves_the_scheme_away_is_told_so() -> None:
    for given, meant in (("puma560", "puma560"), ("KR16", "kr16"), ("irb14", "irb140")):
        files = uploaded({given: b""})
        with pytest.raises(MalformedFileError, match=rf"ending ''; did you mean 'model://{meant}'\? known: \.urdf"):
            import_model(given, files, LIBRARY)
    with pytest.raises(MalformedFileError, match="ending ''; known:"):
        import_model("notes", uploaded({"notes": b""}), LIBRARY)


def test_what_only_meshes_take_is_refused_for_robots() -> None:
    with pytest.raises(KernelError, match=r"^puma560\.urdf is a robot's, and the scale 2, 2, 2 is for meshes"):
        import_model("model://puma560", disk(), LIBRARY, scale=(2.0, 2.0, 2.0))
    with pytest.raises(KernelError, match=r"^ar_manipulator\.yaml is a robot's, and as_part is for meshes"):
        import_model("model://ar_manipulator", disk(), LIBRARY, as_part=True)


def test_an_uploaded_file_of_the_name_wins() -> None:
    files = uploaded({"model://iiwa": b""})
    with pytest.raises(Exception, match="no model format has the ending ''"):
        import_model("model://iiwa", files, MeshLibrary(files.store))


@pytest.mark.parametrize(
    ("uri", "name"),
    [("model://iiwa", "iiwa"), ("model://iiwa/a.stl", ""), ("package://iiwa", ""), ("iiwa", ""), ("model://", "")],
)
def test_only_a_name_alone_is_one_of_the_table(uri: str, name: str) -> None:
    assert named_by(uri) == name


def test_a_known_model_is_named_after_the_table_with_a_number_when_taken() -> None:
    model = imported("model://puma560", disk(STORE), LIBRARY, taken={"puma560"})
    assert model.nodes[0].name == "puma560_2"
    assert imported("model://puma560", disk(STORE), LIBRARY, name="arm").nodes[0].name == "arm"


def test_the_docs_list_the_table() -> None:
    text = (ROOT / "docs/models.md").read_text().partition("## Known robots")[2].partition("\n## ")[0]
    rows = dict(re.findall(r"^\| `([a-z0-9_]+)` \| (.+?) \|", text, re.MULTILINE))
    assert rows == {model.name: model.description for model in list_models()}


def test_find_gives_the_uri() -> None:
    assert find("iiwa").uri == "package://pybullet_data/kuka_iiwa/model.urdf"
    assert find("iiwa").package == "pybullet"
