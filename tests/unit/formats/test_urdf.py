"""What URDF says, element by element, on small files."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot.files.resolver import Resolver
from virtualrobot_kernel.errors import KernelError, MissingFileError
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import import_model
from virtualrobot_kernel.world.figures import Box, Capsule, Cylinder, Mesh, Sphere
from virtualrobot_kernel.world.structure import JointLimits, JointType, Kind, LinkData, NodeSpec, RobotData

from tests.unit.formats.models import (
    TETRAHEDRON,
    TETRAHEDRON_FACES,
    binary_stl,
    forward,
    read_text,
    structure_of,
    uploaded,
)

TETRA = {"t.stl": binary_stl(TETRAHEDRON, TETRAHEDRON_FACES)}


def link_data(node: NodeSpec) -> LinkData:
    assert isinstance(node.data, LinkData)
    return node.data


def chain(count: int, joint: str, link: str = "") -> str:
    """Return a robot of links l0 .. l<count>, joined by j1 .. j<count> with what `joint` says."""
    links = "".join(f'<link name="l{i}">{link}</link>' for i in range(count + 1))
    joints = "".join(
        f'<joint name="j{i}" {joint.format(i=i)}<parent link="l{i - 1}"/><child link="l{i}"/></joint>'
        for i in range(1, count + 1)
    )
    return f'<robot name="r">{links}{joints}</robot>'


def test_links_follow_their_parents_and_carry_the_robots_name() -> None:
    # The file has them the other way round, and branches.
    text = """<robot name="r">
      <link name="tip"/><link name="side"/><link name="middle"/><link name="root"/>
      <joint name="c" type="fixed"><parent link="middle"/><child link="tip"/></joint>
      <joint name="b" type="fixed"><parent link="root"/><child link="side"/></joint>
      <joint name="a" type="fixed"><parent link="root"/><child link="middle"/></joint></robot>"""
    nodes = read_text(text).nodes
    assert [(node.name, node.parent) for node in nodes] == [
        ("r", "world"),
        ("r.root", "r"),
        ("r.side", "r.root"),
        ("r.middle", "r.root"),
        ("r.tip", "r.middle"),
    ]
    assert [node.kind for node in nodes] == [Kind.ROBOT] + [Kind.LINK] * 4
    assert nodes[0].data == RobotData(source="model.urdf")


def test_the_name_may_be_chosen_and_gets_a_number_when_it_is_taken() -> None:
    text = '<robot name="r"><link name="a"/></robot>'
    assert [node.name for node in read_text(text, name="arm").nodes] == ["arm", "arm.a"]
    assert read_text(text, taken={"r", "r_2"}).nodes[0].name == "r_3"
    assert read_text(text.replace(' name="r"', "", 1)).nodes[0].name == "model"  # the file's own name


def test_origin_is_fixed_axis_roll_pitch_yaw(rng: np.random.Generator) -> None:
    xyz, rpy = rng.uniform(-1, 1, 3), rng.uniform(-3, 3, 3)
    words = f'xyz="{" ".join(map(repr, xyz.tolist()))}" rpy="{" ".join(map(repr, rpy.tolist()))}"'
    node = read_text(chain(1, f'type="fixed"><origin {words}/>')).nodes[2]
    assert node.parent_t_node[:3, 3].tolist() == xyz.tolist()
    assert np.abs(node.parent_t_node[:3, :3] - Rotation.from_euler("xyz", rpy).as_matrix()).max() < 1e-14
    assert not node.parent_t_node.flags.writeable


def test_joint_types_axes_and_limits() -> None:
    text = """<robot name="r"><link name="l0"/><link name="l1"/><link name="l2"/><link name="l3"/><link name="l4"/>
      <link name="l5"/>
      <joint name="turn" type="revolute"><parent link="l0"/><child link="l1"/><axis xyz="0 3 4"/>
        <limit lower="-1" upper="2.5" velocity="1.5" effort="7"/></joint>
      <joint name="slide" type="prismatic"><parent link="l1"/><child link="l2"/><limit upper="0.4" velocity="0.5"/>
        </joint>
      <joint name="wheel" type="continuous"><parent link="l2"/><child link="l3"/></joint>
      <joint name="float" type="floating"><parent link="l3"/><child link="l4"/></joint>
      <joint name="plane" type="planar"><parent link="l4"/><child link="l5"/><axis xyz="0 0 2"/></joint></robot>"""
    data = {link_data(node).joint.name: link_data(node).joint for node in read_text(text).nodes[1:]}
    turn, slide, wheel = data["turn"], data["slide"], data["wheel"]
    assert turn.type is JointType.REVOLUTE and turn.axis == (0.0, 0.6, 0.8)
    # acceleration = 4 / s * velocity, jerk = 10 / s * acceleration: the rule of `formats.limits`
    assert turn.limits == JointLimits(-1.0, 2.5, 1.5, 6.0, 60.0, 7.0)
    assert slide.axis == (1.0, 0.0, 0.0) and slide.limits == JointLimits(0.0, 0.4, 0.5, 2.0, 20.0, 0.0)
    assert (wheel.type, wheel.limits) == (JointType.CONTINUOUS, JointLimits())
    assert data["float"].type is JointType.FLOATING
    assert data["plane"].type is JointType.PLANAR and data["plane"].axis == (0.0, 0.0, 1.0)


def test_a_limit_without_velocity_gets_the_default_and_a_warning() -> None:
    model = read_text(chain(1, 'type="revolute"><limit lower="-1" upper="1"/>'))
    assert link_data(model.nodes[2]).joint.limits == JointLimits(-1.0, 1.0)
    assert "model.urdf:1: joint 'j1': the limit tells no velocity" in model.warnings[0]


@pytest.mark.parametrize("base", [JointType.FIXED, JointType.FLOATING, JointType.PLANAR])
def test_the_root_link_hangs_by_the_base_joint(base: JointType) -> None:
    text = '<robot name="r"><link name="a"/><link name="b"/>{}</robot>'
    joint = '<joint name="base" type="continuous"><parent link="a"/><child link="b"/></joint>'
    first = link_data(read_text(text.format(joint), base_joint=base).nodes[1]).joint
    assert (first.name, first.type) == ("base_", base)  # the file has a joint named base
    assert first.axis == (0.0, 0.0, 1.0)  # a planar base moves on the floor


def test_a_floating_and_a_planar_base_move_the_robot() -> None:
    text = '<robot name="r"><link name="a"/></robot>'
    rotation = Rotation.from_rotvec([0.2, -0.5, 1.1])
    structure, poses = structure_of(read_text(text, base_joint=JointType.FLOATING).nodes)
    pose = forward(structure, poses, np.array([1.0, 2.0, 3.0, *rotation.as_quat()]))["r.a"]
    assert np.abs(pose[:3, :3] - rotation.as_matrix()).max() < 1e-12 and pose[:3, 3].tolist() == [1.0, 2.0, 3.0]
    structure, poses = structure_of(read_text(text, base_joint=JointType.PLANAR).nodes)
    pose = forward(structure, poses, np.array([1.0, 2.0, 0.5]))["r.a"]
    assert np.abs(pose[:3, :3] - Rotation.from_euler("z", 0.5).as_matrix()).max() < 1e-12
    assert pose[:3, 3].tolist() == [1.0, 2.0, 0.0]


def test_a_chain_of_mimics_is_worked_out_to_the_joint_that_moves() -> None:
    # j3 = 2 j2 + 1 and j2 = -3 j1 + 0.5, so j3 = -6 j1 + 2.
    text = """<robot name="r"><link name="l0"/><link name="l1"/><link name="l2"/><link name="l3"/>
      <joint name="j3" type="continuous"><parent link="l2"/><child link="l3"/>
        <mimic joint="j2" multiplier="2" offset="1"/></joint>
      <joint name="j2" type="continuous"><parent link="l1"/><child link="l2"/>
        <mimic joint="j1" multiplier="-3" offset="0.5"/></joint>
      <joint name="j1" type="continuous"><parent link="l0"/><child link="l1"/></joint></robot>"""
    nodes = read_text(text).nodes
    mimic = link_data(nodes[-1]).joint.mimic
    assert mimic is not None and (mimic.joint, mimic.multiplier, mimic.offset) == ("j1", -6.0, 2.0)
    structure, poses = structure_of(nodes)
    tip = forward(structure, poses, np.array([0.1]))["r.l3"]
    assert np.abs(tip[:3, :3] - Rotation.from_euler("x", 0.1 + 0.2 + 1.4).as_matrix()).max() < 1e-12


def test_shapes_of_a_link() -> None:
    shapes = [
        'box size="1 2 3"',
        'sphere radius="0.5"',
        'cylinder radius="0.1" length="2"',
        'capsule radius="1" length="3"',
    ]
    elements = "".join(
        f'<{role}><origin xyz="0 0 1"/><geometry><{shape}/></geometry></{role}>'
        for role in ("visual", "collision")
        for shape in shapes
    )
    figures = read_text(chain(0, "", elements)).nodes[1].figures
    expected = [Box((1.0, 2.0, 3.0)), Sphere(0.5), Cylinder(0.1, 2.0), Capsule(1.0, 3.0)]
    assert [figure.geometry for figure in figures] == expected * 2
    assert [(figure.visual, figure.collision) for figure in figures] == [(True, False)] * 4 + [(False, True)] * 4
    assert all(figure.node_t_figure[:3, 3].tolist() == [0.0, 0.0, 1.0] for figure in figures)


def test_a_sphere_of_radius_0_is_left_out_and_told() -> None:
    model = read_text(chain(0, "", '<collision><geometry><sphere radius="0"/></geometry></collision>'))
    assert model.nodes[1].figures == ()
    assert model.warnings == ("model.urdf:1: link 'l0': this <sphere> has no extent and is left out",)


def test_inertia() -> None:
    element = """<inertial><origin xyz="0.1 0.2 0.3"/><mass value="2.5"/>
      <inertia ixx="1" iyy="2" izz="3" ixy="0.1" ixz="0.2" iyz="0.3"/></inertial>"""
    inertial = link_data(read_text(chain(0, "", element)).nodes[1]).inertial
    assert inertial is not None
    assert (inertial.mass, inertial.diagonal, inertial.products) == (2.5, (1.0, 2.0, 3.0), (0.1, 0.2, 0.3))
    assert inertial.link_t_inertial[:3, 3].tolist() == [0.1, 0.2, 0.3]
    assert link_data(read_text(chain(0, "")).nodes[1]).inertial is None


def test_materials_by_name_inline_and_unknown() -> None:
    def visual(material: str) -> str:
        return f'<visual><geometry><box size="1 1 1"/></geometry>{material}</visual>'

    red, blue = '<color rgba="1 0 0 1"/>', '<color rgba="0 0 1 0.5"/>'
    shapes = [
        visual('<material name="red"/>'),  # defined by the robot
        visual(f'<material name="red">{blue}</material>'),  # its own colour says more
        visual('<material name="later"/>'),  # defined inside another visual
        visual(f'<material name="later">{blue}</material>'),
        visual(""),
        visual('<material name="nowhere"/>'),
        visual('<material name="wood"><texture filename="wood.png"/></material>'),
    ]
    text = chain(0, "", "".join(shapes)).replace("</robot>", f'<material name="red">{red}</material></robot>')
    model = read_text(text)
    colors = [figure.material and figure.material.color for figure in model.nodes[1].figures]
    assert colors == [(1, 0, 0, 1), (0, 0, 1, 0.5), (0, 0, 1, 0.5), (0, 0, 1, 0.5), None, None, None]
    assert len(model.warnings) == 2
    assert "'nowhere' is defined nowhere" in model.warnings[0] and "texture" in model.warnings[1]


def test_meshes_scaled_and_mirrored() -> None:
    shape = '<visual><geometry><mesh filename="t.stl" scale="2 -1 0.5"/></geometry></visual>'
    model = read_text(chain(0, "", shape), TETRA)
    mesh = model.nodes[1].figures[0].geometry
    assert isinstance(mesh, Mesh) and mesh.scale == (2.0, -1.0, 0.5) and mesh.uri == "t.stl"
    assert model.mesh_count == 1


def test_numbers_after_the_third_are_passed_over_with_a_warning() -> None:
    model = read_text(chain(1, 'type="fixed"><origin xyz="1 2 3 4"/>'))
    assert model.nodes[2].parent_t_node[:3, 3].tolist() == [1.0, 2.0, 3.0]
    (warning,) = model.warnings
    assert "xyz='1 2 3 4' has 4 numbers; the first 3 are taken" in warning


def test_a_material_of_a_texture_alone_is_told_of_once() -> None:
    look = '<material name="{0}"/><geometry><sphere radius="1"/></geometry>'
    shapes = "".join(f"<visual>{look.format(name)}</visual>" for name in ("wood", "wood", "steel", "steel"))
    wood = '<material name="wood"><texture filename="w.png"/></material>'
    first, second = read_text(f'<robot name="r">{wood}<link name="a">{shapes}</link></robot>').warnings
    assert "the texture of a URDF material is not drawn" in first and "'steel' is defined nowhere" in second


@pytest.mark.parametrize("key", ["package://robot_description/meshes/t.stl", "meshes/t.stl", "file:///robots/t.stl"])
def test_uploaded_meshes_are_found_by_the_name_in_the_file(key: str) -> None:
    shape = f'<visual><geometry><mesh filename="{key}"/></geometry></visual>'
    model = read_text(chain(0, "", shape), {key: TETRA["t.stl"]})
    mesh = model.nodes[1].figures[0].geometry
    assert isinstance(mesh, Mesh) and mesh.uri == key


@pytest.mark.parametrize(
    "start", ['<?xml version="0.0" ?>\n', '\n\n<?xml version="1.0" encoding="latin-1"?>', "\ufeff"]
)
def test_declarations_that_real_models_carry_are_passed_over(start: str) -> None:
    assert read_text(start + chain(0, "")).nodes[1].name == "r.l0"


def test_an_uploaded_model_does_not_reach_the_kernels_disk() -> None:
    shape = '<visual><geometry><mesh filename="pyproject.stl"/></geometry></visual>'
    files = uploaded({"model.urdf": chain(0, "", shape).encode()})
    with_disk = Files(files.store, files.uploaded, Resolver())
    with pytest.raises(MissingFileError, match=r"model\.urdf:1: link 'l0': 'pyproject\.stl'"):
        import_model("model.urdf", with_disk, MeshLibrary(files.store))


def test_a_base_joint_of_another_type_is_refused() -> None:
    with pytest.raises(KernelError, match="the base joint cannot be revolute; valid: fixed, floating, planar"):
        read_text('<robot name="r"><link name="a"/></robot>', base_joint=JointType.REVOLUTE)
