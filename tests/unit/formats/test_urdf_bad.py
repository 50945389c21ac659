"""Bad URDF files: each is refused with file, line, element and what would be right."""

import pytest
from virtualrobot_kernel.errors import MalformedFileError, MissingFileError, Reason
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import import_model

from tests.unit.formats.models import disk, read_text, refusal

TWO = '<robot name="r">\n<link name="a"/>\n<link name="b"/>\n{}\n</robot>'
ENDS = '<parent link="a"/><child link="b"/>'


def joint(inside: str, kind: str = "continuous", ends: str = ENDS) -> str:
    return TWO.format(f'<joint name="j" type="{kind}">{ends}{inside}</joint>')


def shape(inside: str) -> str:
    return f'<robot name="r"><link name="a">\n<visual><geometry>{inside}</geometry></visual></link></robot>'


CASES = {
    "no parent": (joint("", ends='<child link="b"/>'), "model.urdf:4: joint 'j': the joint has no <parent>"),
    "no child": (joint("", ends='<parent link="a"/>'), "model.urdf:4: joint 'j': the joint has no <child>"),
    "unknown parent": (
        joint("", ends='<parent link="x"/><child link="b"/>'),
        "model.urdf:4: joint 'j': its parent 'x' is no link; known: a, b",
    ),
    "unknown child": (
        joint("", ends='<parent link="a"/><child link="x"/>'),
        "model.urdf:4: joint 'j': its child 'x' is no link; known: a, b",
    ),
    "loop": (
        TWO.format(
            '<link name="root"/><joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>\n'
            '<joint name="k" type="fixed"><parent link="b"/><child link="a"/></joint>'
        ),
        "the links form a loop: a -> b -> a",
    ),
    "loop without a root": (
        TWO.format(
            '<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>\n'
            '<joint name="k" type="fixed"><parent link="b"/><child link="a"/></joint>'
        ),
        "model.urdf:5: joint 'k': the links form a loop: a -> b -> a",
    ),
    "its own parent": (
        TWO.format('<joint name="j" type="fixed"><parent link="b"/><child link="b"/></joint>'),
        "model.urdf:4: joint 'j': the links form a loop: b -> b",
    ),
    "two parents": (
        TWO.format(
            '<link name="c"/><joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>\n'
            '<joint name="k" type="fixed"><parent link="c"/><child link="b"/></joint>'
        ),
        "model.urdf:5: joint 'k': link 'b' has two parents: joint 'j' leads to it too",
    ),
    "two roots": (
        TWO.format(""),
        "model.urdf:3: the file has 2 roots, links that no joint leads to: 'a' (line 2), 'b' (line 3)",
    ),
    "two links of a name": (
        '<robot name="r">\n<link name="a"/>\n<link name="a"/></robot>',
        "model.urdf:3: link 'a': the name is taken by the link on line 2",
    ),
    "two joints of a name": (
        TWO.format(
            '<link name="c"/><joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>\n'
            '<joint name="j" type="fixed"><parent link="a"/><child link="c"/></joint>'
        ),
        "model.urdf:5: joint 'j': the name is taken by the joint on line 4",
    ),
    "no link": ('<robot name="r"/>', "model.urdf:1: the robot has no link"),
    "link without a name": ('<robot name="r"><link/></robot>', "model.urdf:1: link: <link> needs the attribute 'name'"),
    "NaN": (joint('<origin xyz="0 nan 0"/>'), "model.urdf:4: joint 'j': xyz='0 nan 0': 'nan' is no finite number"),
    "infinity": (joint('<origin rpy="inf 0 0"/>'), "rpy='inf 0 0': 'inf' is no finite number"),
    "too large": (joint('<origin xyz="1e999 0 0"/>'), "'1e999' is no finite number"),
    "no number": (joint('<origin xyz="0 0 1,5"/>'), "xyz='0 0 1,5': '1,5' is no finite number"),
    "two numbers": (joint('<origin xyz="0 1"/>'), "xyz='0 1' has 2 numbers, expected 3"),
    "zero axis": (
        joint('<axis xyz="0 0 0"/>'),
        "model.urdf:4: joint 'j': axis 0 0 0 has no direction: at least one number must not be 0",
    ),
    "no limit": (
        joint("", "revolute"),
        "model.urdf:4: joint 'j': a revolute joint needs a <limit>; one without limits has the type continuous",
    ),
    "limits the wrong way round": (
        joint('<limit lower="1" upper="-1" velocity="1"/>', "prismatic"),
        "the lower limit 1 is above the upper limit -1",
    ),
    "unknown joint type": (
        joint("", "spherical"),
        "unknown joint type 'spherical'; known: fixed, revolute, continuous, prismatic, floating, planar",
    ),
    "mimic of itself": (joint('<mimic joint="j"/>'), "the mimic joints follow each other: j -> j"),
    "mimic circle": (
        TWO.format(
            '<link name="c"/><joint name="j" type="continuous"><mimic joint="k"/><parent link="a"/><child link="b"/>'
            '</joint><joint name="k" type="continuous"><mimic joint="j"/><parent link="a"/><child link="c"/></joint>'
        ),
        "the mimic joints follow each other: j -> k -> j",
    ),
    "mimic of a fixed joint": (
        TWO.format(
            '<link name="c"/><joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>'
            '<joint name="k" type="continuous"><mimic joint="j"/><parent link="a"/><child link="c"/></joint>'
        ),
        "joint 'k': it mimics 'j', a fixed joint without one value",
    ),
    "no shape": (shape(""), "model.urdf:2: link 'a': <visual> needs a <geometry> with a shape"),
    "unknown shape": (shape("<cone/>"), "unknown geometry <cone>; known: box, sphere, cylinder, capsule, mesh"),
    "negative radius": (shape('<sphere radius="-1"/>'), "radius='-1' must not be below 0"),
    "no radius": (shape('<cylinder length="1"/>'), "<cylinder> needs 1 number in 'radius'"),
    "mesh without a name": (shape("<mesh/>"), "<mesh> needs the attribute 'filename'"),
    "zero scale": (shape('<mesh filename="a.stl" scale="1 0 1"/>'), "scale 1 0 1: no factor may be 0"),
    "negative mass": (
        '<robot name="r"><link name="a"><inertial><mass value="-1"/></inertial></link></robot>',
        "link 'a': mass -1 kg must not be below 0",
    ),
    "no mass": ('<robot name="r"><link name="a"><inertial/></link></robot>', "<inertial> needs a <mass>"),
    "another root": ("<sdf/>", "model.urdf:1: the root element is <sdf>, expected <robot>"),
    "not XML": ("solid ascii stl", "model.urdf:1: not XML: "),
    "empty": ("", "not XML: "),
    "cut off": ('<robot name="r">\n<link name="a">', "model.urdf:2: not XML: "),
    "xacro": (
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">\n<xacro:property name="a" value="1"/></robot>',
        "model.urdf:2: <xacro:property> is xacro, and no importer for xacro is there: expand the file first",
    ),
    "xacro expression": (joint('<origin xyz="${a} 0 0"/>'), "xyz='${a} 0 0' is xacro, and no importer"),
    "xacro argument": (joint('<origin xyz="$(arg a) 0 0"/>'), "xyz='$(arg a) 0 0' is xacro"),
}


@pytest.mark.parametrize("case", CASES)
def test_refused_with_place_and_reason(case: str) -> None:
    text, message = CASES[case]
    error = refusal(text)
    assert message in str(error)
    assert error.reason is Reason.MALFORMED_FILE
    assert error.metadata["file"] == "model.urdf"


def test_an_entity_bomb_is_refused_at_once() -> None:
    entities = "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, 10))
    bomb = f'<!DOCTYPE robot [<!ENTITY a0 "ha">{entities}]><robot name="&a9;"><link name="a"/></robot>'
    assert "entities" in str(refusal(bomb))


def test_an_external_entity_is_not_read(tmp_path: pytest.TempPathFactory) -> None:
    text = f'<!DOCTYPE robot [<!ENTITY x SYSTEM "file://{__file__}">]><robot name="r"><link name="a">&x;</link></robot>'
    assert "entities" in str(refusal(text))


def test_binary_rubbish_is_refused() -> None:
    assert "model.urdf:1: not text in utf-8" in str(refusal(bytes(range(250, 0, -1))))


def test_a_missing_mesh_is_named_with_each_place_that_was_tried(tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("robots")
    (folder / "model.urdf").write_text(shape('<mesh filename="package://nowhere_description/arm.stl"/>'))
    files = disk()
    with pytest.raises(MissingFileError) as caught:
        import_model(str(folder / "model.urdf"), files, MeshLibrary(files.store))
    message = str(caught.value)
    assert message.startswith("model.urdf:2: link 'a': 'package://nowhere_description/arm.stl', named by ")
    assert str(folder / "arm.stl") in message and caught.value.reason is Reason.MISSING_FILE
    assert caught.value.metadata["file"] == "package://nowhere_description/arm.stl"


def test_a_missing_uploaded_mesh_is_named() -> None:
    with pytest.raises(
        MissingFileError, match=r"model\.urdf:2: link 'a': 'arm\.stl', named by model\.urdf, is not there"
    ):
        read_text(shape('<mesh filename="arm.stl"/>'))


def test_a_broken_mesh_is_named_with_the_link_that_shows_it() -> None:
    with pytest.raises(MalformedFileError, match=r"model\.urdf:2: link 'a': arm\.stl: the file holds no triangle"):
        read_text(shape('<mesh filename="arm.stl"/>'), {"arm.stl": b"no triangles"})


def test_an_unknown_ending_is_refused_with_the_known_ones() -> None:
    assert "no model format has the ending '.step'; known: .urdf, .stl, .obj, .dae, .gltf, .glb" in str(
        refusal("ISO-10303-21;", "model.step")
    )


def colored(rgba: str) -> str:
    return shape(f'<sphere radius="1"/></geometry>\n<material name="m"><color rgba="{rgba}"/></material><geometry>')


@pytest.mark.parametrize(
    ("text", "warning"),
    [
        (joint('<mimic joint="x"/>'), "model.urdf:4: joint 'j': it mimics 'x', which is no joint; it moves by itself"),
        (joint('<mimic joint="j"/>', "fixed"), "model.urdf:4: joint 'j': a fixed joint cannot follow another one"),
        (colored("1 0 0 1 1"), "model.urdf:3: material 'm': rgba='1 0 0 1 1' has 5 numbers; the first 4 are taken"),
        (colored("255 0 0 1"), "model.urdf:3: material 'm': rgba='255 0 0 1': each part is from 0 to 1, and the near"),
        (colored("1 0 0"), "model.urdf:3: material 'm': rgba='1 0 0' has 3 numbers, expected 4; it is no colour"),
        (colored("red"), "model.urdf:3: material 'm': rgba='red': 'red' is no finite number; it is no colour"),
    ],
)
def test_what_does_no_harm_is_a_warning_with_file_and_line(text: str, warning: str) -> None:
    """Others load such files too: Stretch 4 has colours of five numbers, Alex a mimic of a joint that is nowhere."""
    (told,) = (one for one in read_text(text).warnings if "velocity" not in one)
    assert told.startswith(warning)
    assert (told.file, told.line) == ("model.urdf", int(warning.split(":")[1]))
