"""SRDF files: groups in the robot's order, postures, pairs of links; what names the unknown is left out with a word."""

from __future__ import annotations

from pathlib import Path

import pytest
from virtualrobot.files.resolver import Resolver
from virtualrobot_kernel.errors import KernelError, MalformedFileError
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import ImportedModel
from virtualrobot_kernel.world.structure import JointGroup, JointType, LinkPair, RobotData

from tests.unit.formats.models import ROBOTS, imported, load, structure_of

SRDF = Path(__file__).with_name("panda.srdf")

STORE = AssetStore()
LIBRARY = MeshLibrary(STORE)

ARM = tuple(f"panda_joint{i}" for i in range(1, 8))


def panda(text: str | None = None, **options: object) -> ImportedModel:
    """Import the Panda with its SRDF file, or with another text in its place."""
    uploaded = {} if text is None else {"panda.srdf": STORE.put(text.encode())}
    files = Files(STORE, uploaded, Resolver())
    return imported(str(ROBOTS["panda"]), files, LIBRARY, srdf_uri="panda.srdf" if text else str(SRDF), **options)


def robot_data(model: ImportedModel) -> RobotData:
    data = model.nodes[0].data
    assert isinstance(data, RobotData)
    return data


def srdf(*lines: str) -> str:
    return "\n".join(['<robot name="panda">', *lines, "</robot>"])


def test_groups_have_the_robots_order_and_chains_their_ends() -> None:
    data = robot_data(panda())
    assert data.groups == (
        JointGroup("panda_arm", ARM, "panda_link0", "panda_link8"),
        # The second finger mimics the first and cannot be moved by itself.
        JointGroup("hand", ("panda_finger_joint1",)),
        JointGroup("wrist", ("panda_joint6", "panda_joint7")),
        JointGroup("panda_arm_hand", (*ARM, "panda_finger_joint1")),
    )


def test_states_are_postures_and_keep_their_name_until_it_is_taken() -> None:
    model = panda()
    data = robot_data(model)
    # Franka's "ready" posture, as MoveIt has it.
    ready = dict(zip(ARM, [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785], strict=True))
    assert data.postures == {
        "ready": ready,
        "open": {"panda_finger_joint1": 0.035},
        "hand/ready": {"panda_finger_joint1": 0.02},
    }
    # By PyBullet's URDF the fourth joint ends at 0.
    (left_out,) = [warning for warning in model.warnings if "left out" in warning]
    assert left_out.startswith("panda.srdf:36: the state 'straight' of 'panda_arm' has 'panda_joint4' at 0.1")
    assert "its limits are -3.1416 to 0" in left_out


def test_pairs_that_may_touch_have_their_reason_and_come_once() -> None:
    assert robot_data(panda()).allowed_collisions == (
        LinkPair("panda_link0", "panda_link1", "Adjacent"),
        LinkPair("panda_link0", "panda_link2", "Never"),
        LinkPair("panda_hand", "panda_leftfinger", "Adjacent"),
    )


def test_the_world_takes_it_and_tools_go_where_the_end_effector_is() -> None:
    model = panda(name="arm one")
    structure, _ = structure_of(model.nodes)
    node, index = structure.robot("arm one")
    assert structure.nodes[index.flange].name == "arm one.panda_link8"
    assert isinstance(node.data, RobotData) and node.data.groups[0].joint_names == ARM
    assert set(ARM) <= set(index.joint_names)


def test_an_srdf_file_beside_a_model_is_not_taken_by_itself(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text('<robot name="r"><link name="a"/></robot>')
    (tmp_path / "r.srdf").write_text('<robot name="r"><group name="g"><link name="a"/></group></robot>')
    assert robot_data(load(tmp_path / "r.urdf")[0]).groups == ()
    model, _ = load(tmp_path / "r.urdf", srdf_uri=str(tmp_path / "r.srdf"))
    assert robot_data(model).groups == (JointGroup("g", ()),)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (('<group name="a"><joint name="panda_jont3"/></group>',), "2: there is no joint named 'panda_jont3'; did you"),
        (('<group name="a"><link name="panda_link9"/></group>',), "2: there is no link named 'panda_link9'; did you"),
        (("", '<group name="a"><chain base_link="panda_link0" tip_link="hand"/></group>'), "3: there is no link named"),
        (
            ('<group name="a"><chain base_link="panda_hand" tip_link="panda_link3"/></group>',),
            "2: no chain leads from 'panda_hand' to 'panda_link3'",
        ),
        (('<group name="a"><group name="b"/></group>',), "2: there is no group named 'b'; there are 'a', 'kept'"),
        (
            ('<group name="a"><group name="b"/></group>', '<group name="b"><group name="a"/></group>'),
            "group 'a': the groups contain each other: a -> b -> a",
        ),
        (('<group name="a"/>', '<group name="a"/>'), "3: group 'a': the name is taken by the group on line 2"),
        (('<group name="a"><jont name="x"/></group>',), "unknown member <jont>; known: chain, joint, link, group"),
        (("<group/>",), "2: group: <group> needs the attribute 'name'"),
        (('<group_state name="s" group="x"/>',), "2: there is no group named 'x'"),
        (
            ('<group name="a"/>', '<group_state name="s" group="a">', '<joint name="j" value="1"/></group_state>'),
            "4: there is no joint named 'j'",
        ),
        (
            (
                '<group name="a"/>',
                '<group_state name="s" group="a"><joint name="panda_joint1" value="x"/></group_state>',
            ),
            "group_state 's': value='x': 'x' is no finite number",
        ),
        (('<disable_collisions link1="panda_link0" link2="panda"/>',), "2: there is no link named 'panda'; did you"),
        (('<group name="a"/>', '<end_effector name="e" group="a" parent_link="x"/>'), "3: there is no link named 'x'"),
        (('<passive_joint name="x"/>',), "2: there is no joint named 'x'"),
    ],
)
def test_what_is_wrong_is_left_out_with_file_line_and_the_nearest_right_name(
    lines: tuple[str, ...], message: str
) -> None:
    """Baxter, iCub, TALOS and others come with such files: what they say else is kept."""
    model = panda(srdf(*lines, '<group name="kept"><joint name="panda_joint2"/></group>'))
    assert JointGroup("kept", ("panda_joint2",)) in robot_data(model).groups
    told = [warning for warning in model.warnings if warning.startswith("panda.srdf:")]
    assert any(message in warning and warning.endswith(" (left out)") for warning in told)
    assert {warning.file for warning in told} == {"panda.srdf"}


def test_only_what_is_wrong_is_left_out() -> None:
    model = panda(
        srdf(
            '<group name="arm"><joint name="panda_joint1"/><joint name="head"/><joint name="panda_joint2"/></group>',
            '<group_state name="s" group="arm"><joint name="head" value="0"/>',
            '<joint name="panda_joint1" value="1"/></group_state>',
            '<disable_collisions link1="panda_link0" link2="head"/>',
            '<disable_collisions link1="panda_link0" link2="panda_link1"/>',
            '<disable_collisions link1="panda_link1" link2="head"/>',
        )
    )
    data = robot_data(model)
    assert data.groups == (JointGroup("arm", ("panda_joint1", "panda_joint2")),)
    assert (data.postures, data.allowed_collisions) == (
        {"s": {"panda_joint1": 1.0}},
        (LinkPair("panda_link0", "panda_link1", ""),),
    )
    told = [warning for warning in model.warnings if warning.startswith("panda.srdf")]
    assert [warning.line for warning in told] == [2, 5], "an unknown name is told once"
    docs = Path(__file__).parents[3] / "docs/models.md"
    assert panda(srdf('<group name="a"><joint name="panda_jont3"/></group>')).warnings[-1][13:] in docs.read_text()


def test_a_group_of_which_nothing_is_left_is_left_out_with_what_names_it() -> None:
    wrong = '<group name="{}"><chain base_link="panda_hand" tip_link="panda_link3"/></group>'
    state = '<group_state name="s" group="whole"><joint name="panda_joint1" value="1"/></group_state>'
    half = '<group name="half"><group name="wrong"/><joint name="panda_joint2"/></group>'
    circle = ('<group name="a"><group name="b"/></group>', '<group name="b"><group name="a"/></group>')
    whole = '<group name="whole"><group name="wrong"/></group>'
    model = panda(srdf(whole, wrong.format("wrong"), half, state, '<group name="empty"/>', *circle))
    data = robot_data(model)
    assert data.groups == (JointGroup("half", ("panda_joint2",)), JointGroup("empty", ()))
    assert data.postures == {}
    told = [warning for warning in model.warnings if warning.startswith("panda.srdf")]
    assert [warning.line for warning in told] == [3, 7]
    assert "no chain leads" in told[0] and "contain each other: a -> b -> a" in told[1]


def test_warnings_come_in_the_order_of_the_file_and_tell_of_another_robot() -> None:
    lines = (
        '<disable_collisions link1="panda_link0" link2="head"/>',
        '<group_state name="s" group="x"/>',
        "<odd/>",
        '<group name="a"><joint name="arm"/></group>',
    )
    model = panda(srdf(*lines).replace('name="panda"', 'name="fr3"'), name="my arm")
    told = [warning for warning in model.warnings if warning.startswith("panda.srdf")]
    assert [warning.line for warning in told] == [1, 2, 3, 4, 5]
    assert told[0] == "panda.srdf:1: the file is about a robot 'fr3', and the model's own name is 'panda'"
    assert not [warning for warning in panda(srdf(), name="my arm").warnings if warning.startswith("panda.srdf")]


def test_what_is_not_kept_is_a_warning() -> None:
    model = panda(
        srdf(
            '<virtual_joint name="v" type="floating" parent_frame="odom" child_link="panda_link0"/>',
            '<passive_joint name="panda_joint1"/>',
            '<link_sphere_approximation link="panda_link1"/>',
            '<group name="a"><joint name="panda_joint1"/></group>',
            '<end_effector name="e" group="a" parent_link="panda_link1"/>',
            '<end_effector name="f" group="a" parent_link="panda_link2"/>',
        )
    )
    for text in (
        "panda.srdf:2: the virtual joint 'v' is floating: say so when the model is imported, by its base joint",
        "panda.srdf:3: the joint 'panda_joint1' is passive, which is not kept",
        "panda.srdf:4: <link_sphere_approximation> is not read",
        "panda.srdf:1: there are 2 end effectors; none of their parent links becomes the flange",
    ):
        assert any(warning.startswith(text) for warning in model.warnings), text
    assert robot_data(model).flange == ""


def test_a_base_that_moves_belongs_to_the_group_of_its_link() -> None:
    text = srdf('<group name="all"><link name="panda_link0"/><link name="panda_link1"/></group>')
    assert robot_data(panda(text)).groups == (JointGroup("all", ("panda_joint1",)),)
    floating = panda(text, base_joint=JointType.FLOATING)
    assert robot_data(floating).groups == (JointGroup("all", ("base", "panda_joint1")),)


def test_a_state_of_a_base_that_moves_is_a_posture_of_its_coordinates() -> None:
    """MoveIt gives x, y, theta of a planar joint in one value, of a floating one the place and the quaternion."""
    group = '<group name="g"><joint name="base"/></group>'
    for kind, value in ((JointType.PLANAR, "1 2 0.5"), (JointType.FLOATING, "1 2 3 0 0 0.6 0.8")):
        state = f'<group_state name="s" group="g"><joint name="base" value="{value}"/></group_state>'
        posture = robot_data(panda(srdf(group, state), base_joint=kind)).postures["s"]
        assert list(posture.values()) == [float(word) for word in value.split()]
        assert next(iter(posture)) == "base/x"
        short = panda(srdf(group, state.replace(f' {value.split()[-1]}"', '"')), base_joint=kind)
        assert any("value" in warning and warning.endswith("(left out)") for warning in short.warnings)


def test_an_srdf_file_for_what_is_no_robot_is_refused() -> None:
    with pytest.raises(KernelError, match=r"duck\.obj is no robot"):
        load(ROBOTS["panda"].parent.parent / "duck.obj", srdf_uri=str(SRDF))
    with pytest.raises(MalformedFileError, match=r"the root element is <sdf>, expected <robot>"):
        panda("<sdf/>")


def test_groups_and_states_may_name_the_virtual_joint() -> None:
    """As those of the PR2 and of TALOS do: how a robot stands in the world is no joint of its own."""
    model = panda(
        srdf(
            '<virtual_joint name="world_joint" type="planar" parent_frame="odom" child_link="panda_link0"/>',
            '<group name="a"><joint name="world_joint"/><joint name="panda_joint1"/></group>',
            '<group_state name="s" group="a"><joint name="world_joint" value="0 0 0"/></group_state>',
        )
    )
    assert robot_data(model).groups == (JointGroup("a", ("panda_joint1",)),)
    assert robot_data(model).postures["s"] == {}


def test_a_group_of_joints_ends_where_its_end_effector_is_mounted() -> None:
    joints = "".join(f'<joint name="{name}"/>' for name in ARM)
    effector = '<end_effector name="e" group="hand" parent_link="panda_link8" parent_group="arm"/>'
    hand = '<group name="hand"><joint name="panda_finger_joint1"/></group>'
    model = panda(srdf(f'<group name="arm">{joints}</group>', hand, effector))
    assert robot_data(model).groups[0] == JointGroup("arm", ARM, "", "panda_link8")
