"""The pages on formats say what the code does."""

import re
from collections.abc import Sequence
from pathlib import Path

from virtualrobot.v1 import nodes_pb2, scene_pb2
from virtualrobot_kernel.formats import scene_file
from virtualrobot_kernel.formats.models import MODEL_FORMATS
from virtualrobot_plugins import importers
from virtualrobot_plugins.importers.solid import grammar

from tests.unit.formats.models import refusal
from tests.unit.formats.test_urdf_bad import joint

DOCS = Path(__file__).parents[3] / "docs"


def test_every_model_format_is_in_the_table() -> None:
    table = re.findall(r"^\| (`\..*?) \|", (DOCS / "formats.md").read_text(), re.MULTILINE)
    imported: list[str] = []

    def register(name: str, factory: object, endings: Sequence[str], *_: object, **options: object) -> None:
        imported.extend(endings)

    importers.virtualrobot_register_importers(register)
    assert sorted(re.findall(r"`(\.\w+)`", " ".join(table))) == sorted({*MODEL_FORMATS, *imported})


def test_every_field_of_a_scene_and_every_kind_and_geometry_is_told() -> None:
    text = (DOCS / "scene-file.md").read_text()
    fields = [field.name for field in scene_pb2.SceneFile.DESCRIPTOR.fields]
    assert re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE) == fields
    told = set(re.findall(r"`(\w+)`", text))
    node, figure = nodes_pb2.Node.DESCRIPTOR, nodes_pb2.Figure.DESCRIPTOR
    assert {field.name for field in node.fields} - {"world"} <= told
    assert {field.name for field in figure.oneofs_by_name["geometry"].fields} <= told


def test_the_example_of_a_scene_is_one() -> None:
    (example,) = re.findall(r"```yaml\n(.*?)```", (DOCS / "scene-file.md").read_text(), re.DOTALL)
    scene = scene_file.parse(example)
    assert scene_file.parse(scene_file.format(scene)) == scene
    assert len(scene.nodes) == 2 and len(scene.models) == 1


def test_the_example_of_an_error_is_one() -> None:
    text = (DOCS / "formats.md").read_text()
    assert str(refusal(joint('<axis xyz="0 0 0"/>'))).partition("joint 'j'")[2] in text


def test_every_word_of_the_modeller_is_in_its_tables() -> None:
    """With what it takes, in the order of the grammar."""
    rows = re.findall(r"^\| `(\w+)` \| (.*?) \|", (DOCS / "modeller.md").read_text(), re.MULTILINE)
    words = {**grammar.SOLIDS, **grammar.PROFILES}
    assert [name for name, _ in rows] == [*grammar.SOLIDS, *grammar.PROFILES, *grammar.File.__dataclass_fields__]
    for name, takes in rows[: -len(grammar.File.__dataclass_fields__)]:
        fields = getattr(words[name], "__dataclass_fields__", None)
        if fields is not None:
            assert re.findall(r"`(\w+)`", takes) == list(fields)
