"""Models by name, `model://NAME`; that each can be loaded is tested in tests/api/client/test_catalogue.py."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from virtualrobot_kernel.errors import KernelError, MalformedFileError, MissingFileError, UnknownNameError
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.model_table import named_by
from virtualrobot_kernel.formats.models import import_model
from virtualrobot_kernel.world.structure import LinkPair, RobotData
from virtualrobot_sdk.models import Model

from tests.unit.formats.models import MODELS, XacroAndSdf, XacroOnly, disk, imported, uploaded

ROOT = Path(__file__).resolve().parents[3]
STORE = AssetStore()
LIBRARY = MeshLibrary(STORE, XacroAndSdf())


def test_a_name_that_is_not_in_the_table_is_refused_with_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="there is no model named 'pumma560'; did you mean 'puma560'"):
        import_model("model://pumma560", disk(), LIBRARY)


def test_a_model_whose_package_is_not_installed_says_how_to_get_it() -> None:
    far = Model("far", "x", "package://not_installed_anywhere/far.urdf", package="far-data")
    assert not far.installed
    with pytest.raises(MissingFileError, match="'far' comes with the Python package far-data: pip install far-data"):
        import_model("model://far", disk(), MeshLibrary(STORE, XacroOnly({"far": far})))


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
    for name, told in (("ar_manipulator", r"ar_manipulator\.yaml"), ("ur5e", "ur5e")):
        with pytest.raises(KernelError, match=rf"^{told} is a robot's, and as_part is for meshes"):
            import_model(f"model://{name}", disk(), LIBRARY, as_part=True)


def test_pairs_of_links_that_may_touch_are_added_with_their_reason() -> None:
    robot = imported("model://parallel_gripper", disk(STORE), LIBRARY).nodes[0]
    assert isinstance(robot.data, RobotData)
    assert LinkPair("left_finger", "right_finger", "the fingers close on each other") in robot.data.allowed_collisions


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
    text = (ROOT / "docs/models.md").read_text().partition("## Known models")[2].partition("\n## ")[0]
    assert re.findall(r"^\| `[a-z0-9_]+` .*$", text, re.MULTILINE) == [row(MODELS[name]) for name in sorted(MODELS)]


def row(model: Model) -> str:
    """Return the row of docs/models.md for a model."""
    payload = f"{model.payload_kilograms:g} kg" if model.payload_kilograms else ""
    reach = f"{model.reach_meters:g} m" if model.reach_meters else ""
    return f"| `{model.name}` | {model.description} | {model.axes} | {payload} | {reach} | {model.package or '-'} |"
