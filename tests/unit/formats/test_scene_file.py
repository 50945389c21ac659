"""Scene files: what is saved is read back, and what is wrong is named with line, path and the nearest right word."""

import io

import numpy as np
import pytest
from google.protobuf import json_format
from ruamel.yaml import YAML
from virtualrobot.v1 import nodes_pb2, scene_pb2
from virtualrobot_kernel.errors import KernelError, MalformedFileError, Reason
from virtualrobot_kernel.formats import scene_file
from virtualrobot_kernel.formats.yaml_text import MOST_CHARACTERS

from tests.unit.formats.random_scenes import WORDS, random_scene

START = "schema_version: 1\nnodes:\n"


def refusal(text: str) -> MalformedFileError:
    with pytest.raises(MalformedFileError) as caught:
        scene_file.parse(text, "cells/scene.yaml")
    assert caught.value.reason is Reason.MALFORMED_FILE
    assert caught.value.metadata["file"] == "cells/scene.yaml"
    return caught.value


def test_random_scenes_come_back_the_same(rng: np.random.Generator) -> None:
    for _ in range(25):
        scene = random_scene(rng)
        text = scene_file.format(scene)
        again = scene_file.parse(text)
        assert again == scene
        # Equality of messages takes 0.0 and -0.0 for the same; their bytes don't.
        assert again.SerializeToString(deterministic=True) == scene.SerializeToString(deterministic=True)
        assert scene_file.format(again) == text


def test_the_text_is_yaml_1_2_of_the_json_mapping(rng: np.random.Generator) -> None:
    # Read by a YAML library and protobuf's own JSON reader, neither of which knows our schema-led reader.
    for _ in range(10):
        scene = random_scene(rng)
        text = scene_file.format(scene)
        tree = YAML(typ="safe", pure=True).load(io.StringIO(text))
        assert json_format.ParseDict(tree, scene_pb2.SceneFile()) == scene


def test_the_text_is_the_same_whatever_order_maps_were_filled_in() -> None:
    scenes = [scene_pb2.SceneFile(schema_version=1), scene_pb2.SceneFile(schema_version=1)]
    names = [f"joint_{i}" for i in range(20)]
    for scene, order in zip(scenes, (names, names[::-1]), strict=True):
        posture = scene.nodes.add(name="arm").robot.postures.add(name="home")
        for name in order:
            posture.joint_positions[name] = 1.0
    assert scene_file.format(scenes[0]) == scene_file.format(scenes[1])


def test_how_it_reads() -> None:
    scene = scene_pb2.SceneFile(schema_version=1, speed_factor=0.5)
    node = scene.nodes.add(name="on")
    node.parent_t_node.position.x = 0.5
    node.object.SetInParent()
    figure = node.figures.add(roles=[nodes_pb2.FIGURE_ROLE_VISUAL])
    figure.box.size.CopyFrom(type(figure.box.size)(x=1.0, y=2.0, z=0.1))
    assert (
        scene_file.format(scene)
        == """# A VirtualRobot scene: meters, radians, kilograms; parents before children.
schema_version: 1
nodes:
- name: "on"
  parent_t_node:
    position: {x: 0.5}
  figures:
  - roles:
    - FIGURE_ROLE_VISUAL
    box:
      size: {x: 1.0, y: 2.0, z: 0.1}
  object: {}
speed_factor: 0.5
"""
    )


@pytest.mark.parametrize("written", ["on", "off", "yes", "no", "5", "1.0", "0x10", "true", "1e3", "2026-01-01", "'on'"])
def test_a_name_stays_what_is_written(written: str) -> None:
    scene = scene_file.parse(f"{START}- name: {written}\n")
    assert scene.nodes[0].name == written.strip("'")


@pytest.mark.parametrize("name", WORDS)
def test_any_name_is_saved_and_read(name: str) -> None:
    scene = scene_pb2.SceneFile(schema_version=1)
    scene.nodes.add(name="a", parent=name).robot.postures.add(name="p").joint_positions[name] = 1.0
    assert scene_file.parse(scene_file.format(scene)) == scene


def test_flow_style_comments_and_nulls_are_yaml_too() -> None:
    text = (
        START + "- {name: table, figures: [{box: {size: {x: 1, y: 1, z: 1e-1}}}]}  # a table\n- name: b\n  parent: ~\n"
    )
    scene = scene_file.parse(text)
    assert scene.nodes[0].figures[0].box.size.z == 0.1
    assert [node.name for node in scene.nodes] == ["table", "b"]


ERRORS = {
    "misspelt key": (
        f"{START}- name: a\n  figures:\n  - box:\n      siez: {{x: 1}}\n",
        "scene.yaml:6: nodes[0].figures[0].box: there is no field 'siez'; did you mean 'size'? known: size",
    ),
    "misspelt key at the top": (
        "schema_version: 1\nnodez: []\n",
        "scene.yaml:2: the scene: there is no field 'nodez'; did you mean 'nodes'? known: schema_version, nodes,",
    ),
    "misspelt vector": (
        f"{START}- parent_t_node: {{position: {{X: 1}}}}\n",
        "nodes[0].parent_t_node.position: there is",
    ),
    "camel case": (f"{START}- parentTNode: {{}}\n", "no field 'parentTNode'; did you mean 'parent_t_node'?"),
    "merge key": (f"{START}- <<: {{name: a}}\n", "scene.yaml:3: nodes[0]: there is no field '<<'"),
    "duplicate key": (
        f"{START}- name: a\n  parent: b\n  name: c\n",
        "scene.yaml:5: nodes[0]: the key 'name' is there twice; first on line 3",
    ),
    "duplicate key at the top": (
        "schema_version: 1\nnodes: []\nnodes: []\n",
        "scene.yaml:3: the scene: the key 'nodes'",
    ),
    "duplicate joint": (
        f"{START}- robot: {{postures: [{{joint_positions: {{a: 1, a: 2}}}}]}}\n",
        "nodes[0].robot.postures[0].joint_positions: the key 'a' is there twice",
    ),
    "text for a number": (
        f"{START}- figures:\n  - sphere:\n      radius_meters: big\n",
        "scene.yaml:5: nodes[0].figures[0].sphere.radius_meters: expected a number, got 'big'",
    ),
    "NaN": (f"{START}- figures: [{{sphere: {{radius_meters: .nan}}}}]\n", "expected a number, got '.nan'"),
    "infinity": (f"{START}- figures: [{{sphere: {{radius_meters: .inf}}}}]\n", "expected a number, got '.inf'"),
    "too large": (f"{START}- figures: [{{sphere: {{radius_meters: 1e999}}}}]\n", "1e999 is too large for a number"),
    "list for a vector": (
        f"{START}- parent_t_node:\n    position: [1, 2, 3]\n",
        "scene.yaml:4: nodes[0].parent_t_node.position: expected the fields of Vector3, got a list",
    ),
    "text for a message": (f"{START}- object: yes\n", "nodes[0].object: expected the fields of SceneObject, got 'yes'"),
    "mapping for a list": ("schema_version: 1\nnodes: {name: a}\n", "nodes: expected a list, got keys and values"),
    "list for a name": (f"{START}- name: [a]\n", "scene.yaml:3: nodes[0].name: expected text, got a list"),
    "yes for true": (f"{START}- hidden: yes\n", "nodes[0].hidden: expected true or false, got 'yes'"),
    "text for true": (f"{START}- hidden: 'true'\n", "nodes[0].hidden: expected true or false, got 'true'"),
    "misspelt role": (
        f"{START}- figures: [{{roles: [FIGURE_ROLE_VISAUL]}}]\n",
        "nodes[0].figures[0].roles[0]: 'FIGURE_ROLE_VISAUL' is no FigureRole; did you mean FIGURE_ROLE_VISUAL?",
    ),
    "a value's name without its beginning": (
        "schema_version: 1\nmodels:\n- denavit_hartenberg: {convention: standard}\n",
        "'standard' is no DenavitHartenbergConvention; did you mean DENAVIT_HARTENBERG_CONVENTION_STANDARD? "
        "known: DENAVIT_HARTENBERG_CONVENTION_STANDARD, DENAVIT_HARTENBERG_CONVENTION_MODIFIED",
    ),
    "two kinds": (
        f"{START}- name: a\n  object: {{}}\n  part: {{}}\n",
        "scene.yaml:5: nodes[0].part: only one kind may be given; there is 'object' too",
    ),
    "two geometries": (f"{START}- figures: [{{box: {{}}, sphere: {{}}}}]\n", "only one geometry may be given"),
    "uid below 0": (f"{START}- uid: -1\n", "nodes[0].uid: -1 is out of range: 0 to 18446744073709551615"),
    "half a uid": (f"{START}- uid: 1.5\n", "nodes[0].uid: expected a whole number, got '1.5'"),
    "not base64": (
        f"{START}- figures: [{{points: {{positions: {{data: '?'}}}}}}]\n",
        "nodes[0].figures[0].points.positions.data: not base64",
    ),
    "no version": ("nodes: []\n", "scene.yaml:1: schema_version: the version is missing; a scene file begins with"),
    "newer version": (
        "schema_version: 2\n",
        "scene.yaml:1: schema_version: unknown version '2'; this kernel reads version 1",
    ),
    "empty": ("", "scene.yaml:1: the file is empty; a scene file begins with `schema_version: 1`"),
    "comment only": ("# nothing\n", "the file is empty"),
    "a list": ("- a\n", "scene.yaml:1: expected keys and values"),
    "text": ("hello\n", "scene.yaml:1: expected keys and values"),
    "not YAML": ("schema_version: 1\nnodes: [\n", "scene.yaml:3: not YAML: "),
    "tab": ("schema_version: 1\nnodes:\n\t- name: a\n", "scene.yaml:3: not YAML: "),
    "control character": ("schema_version: 1\nnodes: \x01\n", "not YAML: "),
    "two documents": ("schema_version: 1\n---\nschema_version: 1\n", "scene.yaml:2: a file has one document"),
    "alias": (
        f"{START}- &a {{name: a}}\n- *a\n",
        "scene.yaml:4: aliases (*name) are not read: write it out",
    ),
    "tag": (f"{START}- !!python/object:os.system {{name: a}}\n", "nodes[0]: tags"),
    "own tag": (f"{START}- name: !secret a\n", "nodes[0].name: tags (!secret) are not read in scene files"),
    "key that is a list": (f"{START}- [a]: b\n", "nodes[0]: a key is a word, not a list"),
    "deep": (START + "- " * 5000 + "a", "scene.yaml:3: nested too deeply: more than 32"),
    "deep on one line": (
        "schema_version: 1\nnodes:\n  " + "[" * 100_000,
        "scene.yaml:3: nested too deeply: more than 32",
    ),
}


@pytest.mark.parametrize("case", ERRORS)
def test_refused_with_line_path_and_hint(case: str) -> None:
    text, message = ERRORS[case]
    assert message in str(refusal(text))


def test_aliases_that_would_grow_to_gigabytes_are_refused_at_once() -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 12)]
    refusal("schema_version: 1\n" + "\n".join(lines))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (START + "#" * MOST_CHARACTERS, "8,000,025 characters; a file may have 8,000,000"),
        (START + "- {}\n" * 200_000, "more keys and values; a file may have 400,000"),
    ],
    ids=["characters", "values"],
)
def test_a_file_that_would_take_minutes_is_refused(text: str, said: str) -> None:
    with pytest.raises(KernelError, match=said) as refused:
        scene_file.parse(text)
    assert refused.value.reason is Reason.TOO_LARGE


@pytest.mark.parametrize("most", [3, 40], ids=["while the text is read", "while the message is filled"])
def test_reading_ends_when_nobody_waits_any_more(most: int) -> None:
    asked = 0

    def check() -> None:
        nonlocal asked
        asked += 1
        if asked > most:
            raise KernelError("nobody waits")

    with pytest.raises(KernelError, match="nobody waits"):
        scene_file.parse(START + "- {name: a}\n" * 5000, check=check)  # 30 thousand events
    assert asked == most + 1


def test_metadata_tells_line_and_path() -> None:
    error = refusal(ERRORS["text for a number"][0])
    assert (error.metadata["line"], error.metadata["path"]) == ("5", "nodes[0].figures[0].sphere.radius_meters")


def test_no_field_of_a_scene_has_a_type_with_a_json_form_of_its_own() -> None:
    # Timestamps and durations are written otherwise in the JSON mapping; the reader knows structs alone.
    seen, todo = set(), [scene_pb2.SceneFile.DESCRIPTOR]
    while todo:
        message = todo.pop()
        if message.full_name in seen:
            continue
        seen.add(message.full_name)
        if message.full_name == "google.protobuf.Struct":
            continue
        todo += [field.message_type for field in message.fields if field.message_type is not None]
    assert len(seen) > 20
    assert [name for name in seen if name.startswith("google.protobuf.")] == ["google.protobuf.Struct"]
