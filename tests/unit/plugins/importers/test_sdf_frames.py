"""Frames, joints and includes of SDFormat, by the rules of each version (sdformat.org, "Pose frame semantics")."""

import math

import numpy as np
import pytest
from virtualrobot_kernel.world.structure import JointType, LinkData, NodeSpec
from virtualrobot_plugins.importers.sdf.importer import SdfImporter
from virtualrobot_sdk.errors import FilesNeeded

from tests.unit.formats.models import forward, structure_of
from tests.unit.plugins.importers.reading import refusal, scene
from tests.unit.plugins.importers.test_sdf import BOX, sdf, specs

ARM = """<model name="arm"><pose>1 0 0 0 0 0</pose>
<link name="base"/>
<link name="upper"><pose>0 0 1 0 0 0</pose></link>
<link name="lower"><pose>0 0 2 0 0 {yaw}</pose></link>
<joint name="shoulder" type="revolute"><parent>base</parent><child>upper</child>
  <axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>2</upper><velocity>3</velocity><effort>9</effort></limit></axis>
</joint>
<joint name="elbow" type="prismatic"><pose>0 0 -0.5 0 0 0</pose><parent>upper</parent><child>lower</child>
  <axis><xyz{expressed}>1 0 0</xyz>{old}</axis></joint>
</model>"""


def links(nodes: tuple[NodeSpec, ...]) -> dict[str, LinkData]:
    return {node.name.partition(".")[2]: node.data for node in nodes if isinstance(node.data, LinkData)}


def world(nodes: tuple[NodeSpec, ...], **values: float) -> dict[str, np.ndarray]:
    """Return world_t_node at these joint positions."""
    structure, poses = structure_of(nodes)
    names = [name for robot in structure.robots.values() for name in robot.joint_names]
    assert sorted(values) == sorted(names)
    return forward(structure, poses, np.array([values[name] for name in names]))


def arm(version: str = "1.9", yaw: float = 0.0, expressed: str = "", old: str = "") -> tuple[NodeSpec, ...]:
    return specs(sdf(ARM.format(yaw=yaw, expressed=expressed, old=old), version))


def test_joints_limits_and_the_place_of_links() -> None:
    nodes = arm()
    assert [node.name for node in nodes] == ["arm", "arm.base", "arm.upper", "arm.lower"]
    shoulder, elbow = links(nodes)["upper"].joint, links(nodes)["lower"].joint
    limits = shoulder.limits
    assert shoulder.type is JointType.REVOLUTE and elbow.type is JointType.PRISMATIC
    # As for URDF: acceleration = 4 /s times velocity, jerk = 10 /s times acceleration.
    told = (limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk, limits.effort)
    assert told == (-1.0, 2.0, 3.0, 12.0, 120.0, 9.0)
    assert not np.isfinite(elbow.limits.lower)
    at = world(nodes, shoulder=math.pi / 2.0, elbow=0.0)
    # Bent by a quarter turn about y through (1, 0, 1): what was above lies along x.
    assert at["arm.upper"][:3, 3] == pytest.approx([1.0, 0.0, 1.0])
    assert at["arm.lower"][:3, 3] == pytest.approx([1.5, 0.0, 1.0])  # the joint's frame, 0.5 below the link's
    moved = world(nodes, shoulder=0.0, elbow=0.25)
    assert moved["arm.lower"][:3, 3] == pytest.approx([1.25, 0.0, 1.5])


@pytest.mark.parametrize(
    ("version", "expressed", "old", "direction"),
    [
        ("1.9", "", "", (0.0, 1.0)),  # in the joint's frame, which the link turns by 90 degrees
        ("1.9", ' expressed_in="__model__"', "", (1.0, 0.0)),
        ("1.9", ' expressed_in="base"', "", (1.0, 0.0)),
        ("1.9", ' expressed_in="lower"', "", (0.0, 1.0)),
        ("1.6", "", "", (0.0, 1.0)),
        ("1.6", "", "<use_parent_model_frame>1</use_parent_model_frame>", (1.0, 0.0)),
        ("1.4", "", "", (1.0, 0.0)),
    ],
)
def test_the_frame_of_an_axis(version: str, expressed: str, old: str, direction: tuple[float, float]) -> None:
    nodes = arm(version, math.pi / 2.0, expressed, old)
    way = (
        world(nodes, shoulder=0.0, elbow=1.0)["arm.lower"][:3, 3]
        - world(nodes, shoulder=0.0, elbow=0.0)["arm.lower"][:3, 3]
    )
    assert way == pytest.approx([*direction, 0.0], abs=1e-12)


def test_poses_relative_to_frames_links_and_joints() -> None:
    text = sdf(
        f"""<model name="m"><static>1</static>
        <frame name="f" attached_to="a"><pose>0 0 1 0 0 0</pose></frame>
        <frame name="g"><pose relative_to="f" degrees="true">0 0 0 0 0 90</pose></frame>
        <link name="a"><pose>10 0 0 0 0 0</pose></link>
        <link name="b"><pose relative_to="g">1 0 0 0 0 0</pose><visual name="v">{BOX}</visual></link>
        <joint name="j" type="fixed"><pose>0 0 5 0 0 0</pose><parent>a</parent><child>b</child></joint>
        <link name="c"><pose relative_to="j" rotation_format="quat_xyzw">0 0 0 0 0 0 2</pose>
          <visual name="v">{BOX}</visual></link>
        </model>"""
    )
    (node,) = specs(text)
    places = [figure.node_t_figure[:3, 3] for figure in node.figures]
    assert places[0] == pytest.approx([10.0, 1.0, 1.0]) and places[1] == pytest.approx([10.0, 1.0, 6.0])


def test_nested_models_and_placement() -> None:
    text = sdf(
        """<world name="w"><frame name="corner"><pose>100 0 0 0 0 0</pose></frame>
        <model name="outer" placement_frame="inner::tip"><pose relative_to="corner">0 0 0 0 0 0</pose>
          <model name="inner"><pose>1 0 0 0 0 0</pose><link name="l"><pose>0 2 0 0 0 0</pose></link>
            <frame name="tip" attached_to="l"><pose>0 0 3 0 0 0</pose></frame></model>
          <link name="root"/>
          <joint name="turn" type="continuous"><parent>root</parent><child>inner</child>
            <axis><xyz>0 0 1</xyz></axis></joint>
        </model></world>"""
    )
    nodes = specs(text)
    assert [node.name for node in nodes] == ["outer", "outer.root", "outer.inner::l"]
    at = world(nodes, turn=0.0)
    assert at["outer.root"][:3, 3] == pytest.approx([99.0, -2.0, -3.0])  # so that inner::tip, at 1 2 3 in it, is there
    assert at["outer.inner::l"][:3, 3] == pytest.approx([100.0, -2.0, -3.0])  # the joint is at the child's model frame


def test_joints_written_the_other_way_round_and_from_the_world() -> None:
    text = sdf(
        """<model name="m"><link name="a"><pose>0 0 1 0 0 0</pose></link><link name="b"/>
        <joint name="lift" type="prismatic"><parent>world</parent><child>b</child><axis><xyz>0 0 1</xyz></axis></joint>
        <joint name="slide" type="prismatic"><parent>a</parent><child>b</child><axis><xyz>1 0 0</xyz></axis></joint>
        </model>"""
    )
    at = world(specs(text), lift=2.0, slide=0.5)
    assert at["m.b"][:3, 3] == pytest.approx([0.0, 0.0, 2.0])
    # The child b moves by +0.5 as seen from a, so a moves by -0.5 as seen from b; its frame is that of the joint.
    assert at["m.a"][:3, 3] == pytest.approx([-0.5, 0.0, 2.0])


def test_joints_of_two_axes_are_two_joints() -> None:
    text = sdf(
        """<model name="m"><link name="a"/><link name="b"/><joint name="u" type="universal"><parent>a</parent>
        <child>b</child><axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2></joint></model>"""
    )
    nodes = specs(text)
    assert [node.name for node in nodes] == ["m", "m.a", "m.u_between", "m.b"]
    first, second = 0.4, -0.7
    turned = world(nodes, u=first, u_2=second)["m.b"][:3, :3]
    about_x = np.array([[1, 0, 0], [0, math.cos(first), -math.sin(first)], [0, math.sin(first), math.cos(first)]])
    about_y = np.array([[math.cos(second), 0, math.sin(second)], [0, 1, 0], [-math.sin(second), 0, math.cos(second)]])
    assert turned == pytest.approx(about_x @ about_y)


def test_mimic_joints() -> None:
    text = sdf(
        """<model name="m"><link name="a"/><link name="b"/><link name="c"/>
        <joint name="lead" type="prismatic"><parent>a</parent><child>b</child><axis><xyz>1 0 0</xyz></axis></joint>
        <joint name="follow" type="prismatic"><parent>a</parent><child>c</child><axis><xyz>1 0 0</xyz>
        <mimic joint="lead"><multiplier>-2</multiplier><offset>0.5</offset><reference>0.1</reference></mimic></axis>
        </joint>
        </model>""",
        "1.11",
    )
    at = world(specs(text), lead=0.3)
    assert at["m.c"][0, 3] == pytest.approx(-2.0 * (0.3 - 0.1) + 0.5)  # multiplier (leader - reference) + offset


def test_inertia_is_in_the_frame_of_the_node() -> None:
    text = sdf(
        """<model name="m"><link name="a"/><link name="b"><pose>0 0 1 0 0 0</pose><inertial><pose>0.1 0 0 0 0 0</pose>
        <mass>2</mass><inertia><ixx>1</ixx><iyy>2</iyy><izz>3</izz><ixy>0.1</ixy><ixz>0.2</ixz><iyz>0.3</iyz></inertia>
        </inertial></link><joint name="j" type="revolute"><pose>0 0 -0.25 0 0 0</pose><parent>a</parent><child>b</child>
        <axis><xyz>0 0 1</xyz></axis></joint></model>"""
    )
    inertial = links(specs(text))["b"].inertial
    assert inertial is not None and inertial.mass == 2.0
    assert inertial.link_t_inertial[:3, 3] == pytest.approx([0.1, 0.0, 0.25])
    assert inertial.diagonal == (1.0, 2.0, 3.0) and inertial.products == (0.1, 0.2, 0.3)


CONFIG = b'<model><sdf version="1.4">old.sdf</sdf><sdf version="1.6">new.sdf</sdf></model>'
CUP = sdf(
    '<model name="cup"><link name="l"><visual name="v"><geometry><mesh><uri>meshes/cup.dae</uri></mesh></geometry>'
    "</visual></link></model>"
).encode()


def test_included_models() -> None:
    text = sdf(
        """<world name="w"><include><uri>model://cup</uri><pose>1 0 0 0 0 0</pose></include>
        <include><uri>model://cup</uri><name>other</name><static>true</static></include></world>"""
    )
    files: dict[str, bytes] = {}
    for expected, content in (("model://cup/model.config", CONFIG), ("model://cup/new.sdf", CUP)):
        with pytest.raises(FilesNeeded) as needed:
            specs(text, files)
        assert needed.value.names == (expected,)
        files[expected] = content
    nodes = scene(SdfImporter(), text, "w.sdf", files).nodes
    assert [(node.name, node.WhichOneof("kind")) for node in nodes] == [("cup", "part"), ("other", "object")]
    assert nodes[0].parent_t_node.position.x == 1.0
    assert nodes[0].figures[0].mesh.uri == "model://cup/meshes/cup.dae"
    plain = {"model://cup/model.config": None, "model://cup/model.sdf": CUP}
    assert len(scene(SdfImporter(), text, "w.sdf", plain).nodes) == 2  # pyright: ignore[reportArgumentType]  None: nowhere
    gone = {"model://cup/model.config": None, "model://cup/model.sdf": None}
    assert "w.sdf:3: the included model 'model://cup/model.sdf' is nowhere" in refusal(
        SdfImporter(), text, "w.sdf", gone
    )


def test_includes_in_included_models_count_from_there() -> None:
    text = sdf('<model name="m"><include><uri>parts/a.sdf</uri></include></model>')
    inner = sdf('<model name="a"><include><uri>b.sdf</uri></include></model>').encode()
    files = {"parts/a.sdf": inner, "parts/b.sdf": CUP}
    (node,) = scene(SdfImporter(), text, "w.sdf", files).nodes
    assert node.figures[0].mesh.uri == "parts/meshes/cup.dae"
    plugged = {**files, "parts/b.sdf": CUP.replace(b"<link", b'<plugin name="p"/><link', 1)}
    assert SdfImporter().translate(text.encode(), "w.sdf", plugged).warnings == ("b.sdf:3: <plugin> is left out",)
    files["parts/b.sdf"] = inner.replace(b"b.sdf", b"a.sdf")
    assert "includes itself" in refusal(SdfImporter(), text, "w.sdf", files)


LOOP = """<model name="m"><link name="a"/><link name="b"/><link name="c"/>{}</model>"""


def revolute(
    name: str, parent: str, child: str, more: str = "<axis><xyz>0 0 1</xyz></axis>", kind: str = "revolute"
) -> str:
    return f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{more}</joint>'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<sdf", "m.sdf:1: not XML"),
        ("", "m.sdf:1: not XML"),
        ('<robot name="r"/>', "this is URDF"),
        ("<html/>", "the root element is <html>, expected <sdf>"),
        ('<sdf version="2.0"/>', "version='2.0': versions 1.0 to 1.12 are read"),
        (sdf(""), "m.sdf: the file holds no model with a link"),
        ('<!DOCTYPE a [<!ENTITY b "c">]><sdf version="1.6"/>', "declares entities"),
        (sdf('<model name=""/>'), "<model> needs a name"),
        (sdf('<model name="__x__"/>'), "<model> needs a name"),
        (sdf('<model name="m"><link name="a"/><link name="a"/></model>'), "the name 'a' is taken; first on line 3"),
        (
            sdf(LOOP.format(revolute("1", "a", "b") + revolute("2", "b", "c") + revolute("3", "c", "a"))),
            "joint '3': it closes a kinematic loop from 'c' to 'a'; only trees are read",
        ),
        (sdf(LOOP.format(revolute("1", "a", "a"))), "joint '1': it connects the link 'a' with itself"),
        (sdf(LOOP.format(revolute("1", "a", "x"))), "there is no link or frame 'x'; links: a, b, c"),
        (sdf(LOOP.format(revolute("1", "x", "a"))), "there is no link or frame 'x'; links: a, b, c"),
        (sdf(LOOP.format(revolute("1", "a", ""))), "joint '1': a joint needs <child>"),
        (sdf(LOOP.format(revolute("1", "a", "b", kind="spring"))), "the type 'spring' is not read; known: fixed"),
        (sdf(LOOP.format(revolute("1", "a", "b", ""))), "a revolute joint needs <axis>"),
        (sdf(LOOP.format(revolute("1", "a", "b", "<axis><xyz>0 0 0</xyz></axis>"))), "<xyz> is 0 0 0"),
        (
            sdf(LOOP.format(revolute("1", "a", "b", "<axis><limit><lower>2</lower><upper>1</upper></limit></axis>"))),
            "the lower limit 2 is above the upper one 1",
        ),
        (sdf('<model name="m"><link name="a"><pose>1 2 3</pose></link></model>'), "<pose> has 3 numbers, expected 6"),
        (sdf('<model name="m"><link name="a"><pose>1 2 3 nan 0 0</pose></link></model>'), "'nan' is no finite number"),
        (
            sdf('<model name="m"><link name="a"><pose relative_to="b">0 0 0 0 0 0</pose></link>'
                '<link name="b"><pose relative_to="a">0 0 0 0 0 0</pose></link></model>'),
            "poses relative to each other form a loop: a → b → a",
        ),
        (
            sdf('<model name="m"><link name="a"/><frame name="f" attached_to="g"/><frame name="g" attached_to="f"/>'
                + revolute("1", "f", "a") + "</model>"),
            "frames attached to each other form a loop",
        ),
        (sdf('<model name="m"><link name="a"/><static>maybe</static></model>'), "<static> is 'maybe'; expected true"),
        (sdf("<model name='m'>" * 60 + "</model>" * 60), "models are nested more than 32 deep"),
        (sdf("<model name='m'>" * 5000), "not XML"),
        (sdf('<model name="m"><link name="a"><inertial><mass>-1</mass></inertial></link></model>'), "<mass> is -1 kg"),
    ],
)  # fmt: skip
def test_refusals(text: str, words: str) -> None:
    assert words in refusal(SdfImporter(), text, "m.sdf")


def test_what_cannot_be_moved_is_fixed_and_told() -> None:
    text = sdf(LOOP.format(revolute("1", "a", "b", kind="ball") + revolute("2", "a", "c")))
    translation = SdfImporter().translate(text.encode(), "m.sdf", {})
    assert translation.warnings == ("m.sdf:3: joint '1': a ball joint is not moved here: it is fixed at zero",)
    free = sdf(LOOP.format(revolute("1", "a", "b")))
    warnings = SdfImporter().translate(free.encode(), "m.sdf", {}).warnings
    assert warnings == ("m.sdf:3: model 'm': the link 'c' hangs on no joint; here it is fixed to the robot",)
    assert links(specs(free))["c"].joint.name == "base_"
