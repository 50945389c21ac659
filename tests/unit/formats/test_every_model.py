"""Every robot of pybullet_data and rtb-data loads whole; only files that name what is in neither package are refused.

What a file holds is counted in the text that the library xacro makes of it by itself, with a table of packages that is
written here.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin  # pyright: ignore[reportMissingImports]  its wheel has a folder of its own
import pytest
import rtbdata
import xacro
from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]  compiled, and has no types
from virtualrobot.v1 import scene_pb2
from virtualrobot_kernel.errors import MissingFileError
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import ImportedModel
from virtualrobot_kernel.scenes.models import read_model
from virtualrobot_kernel.world.figures import Mesh
from virtualrobot_kernel.world.structure import JointType, Kind, LinkData
from xacro import substitution_args

from tests.pybullet_models import pybullet
from tests.tiers import every_fifth
from tests.unit.formats.models import DATA, XacroAndSdf, disk, forward, imported, structure_of
from tests.unit.formats.test_robots import joint_values

RTB = Path(rtbdata.__file__).parent / "xacro"
KUKA = RTB / "kuka_description"

PACKAGES = {
    "abb_irb140": RTB / "abb_irb140_description",
    "kuka_resources": KUKA / "kuka_resources",
    "ridgeback_description": RTB / "clearpath_ridgeback_description",
    "qut_frankie_description": RTB / "qut_frankie_description",
    "trossen_descriptions": RTB / "trossen_descriptions",
    "kuka_lbr_iiwa_support": KUKA / "kuka_lbr_iiwa",
    **{f"kuka_kr{size}_support": KUKA / f"kuka_kr{size}" for size in (3, 5, 6, 10, 16, 120, 150, 210)},
}
"""Where `$(find ...)` leads; the folders of rtb-data are named otherwise."""

FOLDERS = ("kuka_iiwa", "franka_panda", "xarm", "a1", "laikago", "husky", "racecar", "gripper")
"""Folders of pybullet_data whose robots the project promises; all URDF and SDF files in them are loaded."""

MISSING = {
    "kuka_iiwa/model_for_sdf.urdf": "meshes/coarse/link_0.stl",
    "kuka_iiwa/model2.sdf": "meshes/coarse/link_0.stl",
    "kuka_iiwa/kuka_world.sdf": "meshes/coarse/link_0.stl",
    "clearpath_ridgeback_description/urdf/accessories/sick_lms1xx_mount.urdf.xacro": "urdf/sick_lms1xx.urdf.xacro",
    "clearpath_ridgeback_description/urdf/accessories/sick_s300_mount.urdf.xacro": "urdf/sick_lms1xx.urdf.xacro",
}
"""Files that are refused, with what they name and what is in neither package."""

OLD_XACRO = "kuka_description/kuka_kr210/urdf/kr210l150.xacro"
"""Its `<property>` has no prefix, which the library does not read: its text is made by hand."""


def label(file: Path) -> str:
    return file.relative_to(RTB if RTB in file.parents else DATA).as_posix()


def all_files() -> list[Path]:
    own = [file for folder in FOLDERS for file in (DATA / folder).rglob("*.urdf")]
    return [*sorted([*RTB.rglob("*.xacro"), *RTB.rglob("*.urdf")]), *sorted(own), DATA / "r2d2.urdf"]


@cache
def expanded(file: Path) -> str:
    """Return the URDF text of a file as the library xacro makes it."""
    finder, substitution_args._eval_find = substitution_args._eval_find, lambda name: str(PACKAGES[name])
    try:
        if label(file) == OLD_XACRO:
            macro = (file.parent / "kr210l150_macro.xacro").read_text().replace("<property", "<xacro:property")
            call = file.read_text().partition("<xacro:include")[2].partition("/>")[2]
            body = macro.partition("<robot")[2].partition(">")[2].rpartition("</robot>")[0]
            document: Any = xacro.parse(f'<robot name="r" xmlns:xacro="http://wiki.ros.org/xacro">{body}{call}')
            xacro.process_doc(document)
            return document.toprettyxml()
        document = xacro.process_file(str(file))
        return document.toprettyxml()
    finally:
        substitution_args._eval_find = finder


@cache
def tree(file: Path) -> Any:  # noqa: ANN401  an element of lxml
    return etree.fromstring(expanded(file).encode())


STORE = AssetStore()
LIBRARY = MeshLibrary(STORE, XacroAndSdf())


@cache
def loaded(file: Path) -> ImportedModel:
    return imported(str(file), disk(STORE), LIBRARY, name="it")


# Files of macros alone make no robot: what is in them is told by those that include them.
ROBOTS = [file for file in all_files() if label(file) not in MISSING and len(tree(file).findall("link"))]
by_name = pytest.mark.parametrize("file", every_fifth(ROBOTS), ids=label)


def test_nothing_is_left_out() -> None:
    names = [label(file) for file in ROBOTS]
    for word in (
        *("puma560_robot.urdf.xacro", "irb140.xacro", "kr3r540.xacro", "kr5_arc.xacro", "kr6r700sixx.xacro"),
        *("kr6r900sixx.xacro", "kr10r1100sixx.xacro", "kr16_2.xacro", "kr120r2500pro.xacro", "kr150_2.xacro"),
        *("kr210l150.xacro", "lbr_iiwa_14_r820.xacro", "ridgeback.urdf.xacro", "al5d_robot.urdf", "panda.urdf"),
        *("xarm6_robot.urdf", "a1.urdf", "laikago.urdf", "husky.urdf", "r2d2.urdf", "racecar.urdf", "model.urdf"),
        *("wsg50_one_motor_gripper_left_finger.urdf", "racecar_differential.urdf"),
    ):
        assert any(name.endswith(f"/{word}") or name == word for name in names), word
    arms = {path.name for path in (RTB / "trossen_descriptions/urdf").iterdir()}
    assert arms <= {name.rpartition("/")[2] for name in names} and len(arms) == 15


@by_name
def test_meshes_links_and_joints_are_those_of_the_file(file: Path) -> None:
    model, root = loaded(file), tree(file)
    figures = [figure for node in model.nodes for figure in node.figures]
    meshes = [figure.geometry for figure in figures if isinstance(figure.geometry, Mesh)]
    wanted = [mesh.get("filename") for mesh in root.iterfind("link//geometry/mesh")]
    assert model.mesh_count == len(meshes) == len(wanted)
    # Each is the file of that name: what follows the package, or the relative path, is the end of its path.
    ends = [name.partition("://")[2].partition("/")[2] if "://" in name else name for name in wanted]
    found = sorted(mesh.uri for mesh in meshes)
    assert all(any(uri.endswith(f"/{end.lstrip('./')}") for uri in found) for end in ends)
    assert all(STORE.get(mesh.sha256) == Path(mesh.uri).read_bytes() for mesh in set(meshes))
    joints = [node.data.joint for node in model.nodes[2:] if isinstance(node.data, LinkData)]
    assert [joint.name for joint in joints] != [] or len(root.findall("joint")) == 0
    assert sorted(joint.name for joint in joints) == sorted(joint.get("name") for joint in root.findall("joint"))
    assert {joint.name: joint.type.value[0] for joint in joints} == {
        joint.get("name"): joint.get("type") for joint in root.findall("joint")
    }


@pytest.mark.parametrize("name", MISSING)
def test_a_refusal_is_for_a_file_that_is_in_neither_package(name: str) -> None:
    file = next(folder / name for folder in (RTB, DATA) if (folder / name).is_file())
    with pytest.raises(MissingFileError) as refused:
        read_model(LIBRARY, scene_pb2.ModelSource(uri=str(file)), disk(STORE), ())
    assert MISSING[name].rpartition("/")[2] in str(refused.value) and "tried" in str(refused.value)
    everywhere = [*RTB.parent.rglob(Path(MISSING[name]).name), *DATA.rglob(Path(MISSING[name]).name)]
    assert not [path for path in everywhere if path.as_posix().endswith(f"/{MISSING[name]}")]


@pytest.mark.parametrize(
    "file",
    [f for folder in FOLDERS for f in sorted((DATA / folder).glob("*.sdf")) if label(f) not in MISSING],
    ids=label,
)
def test_sdf_models_have_the_meshes_of_their_files(file: Path) -> None:
    model = read_model(LIBRARY, scene_pb2.ModelSource(uri=str(file)), disk(STORE), ())
    root = etree.fromstring(file.read_bytes().lstrip())
    assert model.mesh_count == len(list(root.iter("mesh"))) > 0
    assert sum(node.kind is Kind.LINK for node in model.nodes) >= len(list(root.iter("joint")))


def bare(file: Path) -> str:
    """Return the expanded text without shapes, which other engines look for in places of their own."""
    root = etree.fromstring(expanded(file).encode())
    for shape in [*root.iter("visual"), *root.iter("collision")]:
        shape.getparent().remove(shape)
    return etree.tostring(root).decode()  # a tag a line: PyBullet cannot read long ones


@by_name
def test_links_are_where_pinocchio_puts_them(file: Path, rng: np.random.Generator) -> None:
    nodes = loaded(file).nodes
    structure, parent_t_node = structure_of(nodes)
    model = pin.buildModelFromXML(bare(file))
    data = model.createData()
    _, robot = structure.robot("it")
    for _ in range(5):
        values = joint_values(nodes, rng)
        theirs = pin.neutral(model)
        for name, value in values.items():
            joint = model.joints[model.getJointId(name)]
            theirs[joint.idx_q : joint.idx_q + joint.nq] = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
        pin.framesForwardKinematics(model, data, theirs)
        world_t_node = forward(structure, parent_t_node, np.array([values[name] for name in robot.joint_names]))
        for node in (node for node in nodes if node.kind is Kind.LINK):
            frame = model.getFrameId(node.name.removeprefix("it."), pin.FrameType.BODY)
            assert np.abs(world_t_node[node.name] - data.oMf[frame].homogeneous).max() < 1e-9, node.name


@by_name
def test_joints_and_masses_are_those_that_pybullet_reads(file: Path, tmp_path: Path) -> None:
    urdf = tmp_path / "bare.urdf"
    urdf.write_text(bare(file))
    nodes = [node for node in loaded(file).nodes if node.kind is Kind.LINK]
    links = {node.name.removeprefix("it."): node.data for node in nodes if isinstance(node.data, LinkData)}
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(str(urdf), physicsClientId=client)
        count = pybullet.getNumJoints(body, physicsClientId=client)
        assert count == len(links) - 1
        kinds = {pybullet.JOINT_REVOLUTE: "turns", pybullet.JOINT_PRISMATIC: "slides", pybullet.JOINT_FIXED: "fixed"}
        ours = {JointType.REVOLUTE: "turns", JointType.CONTINUOUS: "turns", JointType.PRISMATIC: "slides"}
        for index in range(count):
            info = pybullet.getJointInfo(body, index, physicsClientId=client)
            link = links[info[12].decode()]
            assert info[1].decode() == link.joint.name
            assert kinds[info[2]] == ours.get(link.joint.type, "fixed")
            if link.inertial is not None:  # PyBullet gives 1 kg to a link that tells none
                assert pybullet.getDynamicsInfo(body, index, physicsClientId=client)[0] == link.inertial.mass
    finally:
        pybullet.disconnect(client)
