"""Models of every kind through the client: known ones, translated ones, tables, and what is written out again."""

from __future__ import annotations

import logging
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh
import virtualrobot
from virtualrobot import Client, Robot, pose

from tests.api.client.conftest import PANDA

XACRO = """<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="prefix" default=""/>
  <xacro:arg name="with_tip" default="0"/>
  <xacro:include filename="$(find secret_arm)/urdf/link.xacro"/>
  <xacro:include filename="nowhere.xacro" optional="true"/>
  <xacro:property name="limits" value="${xacro.load_yaml('../config/limits.yaml')}"/>
  <xacro:mesh_link name="$(arg prefix)base" mesh="base"/>
  <link name="$(arg prefix)arm"/>
  <joint name="$(arg prefix)joint" type="revolute">
    <parent link="$(arg prefix)base"/><child link="$(arg prefix)arm"/><axis xyz="0 0 1"/>
    <limit lower="${limits['lower']}" upper="${limits['upper']}" velocity="1" effort="1"/>
  </joint>
  <xacro:if value="$(arg with_tip)">
    <xacro:mesh_link name="$(arg prefix)tip" mesh="tip"/>
    <joint name="$(arg prefix)tip_joint" type="fixed">
      <parent link="$(arg prefix)arm"/><child link="$(arg prefix)tip"/>
    </joint>
  </xacro:if>
</robot>
"""
LINK = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:include filename="place.xacro"/>
  <xacro:macro name="mesh_link" params="name mesh">
    <link name="${name}"><visual><geometry><mesh filename="${place}/${mesh}.obj"/></geometry></visual></link>
  </xacro:macro>
</robot>
"""
PLACE = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:property name="place" value="package://secret_arm/meshes"/>
</robot>
"""
SRDF = """<robot name="arm">
  <group name="whole"><chain base_link="left_base" tip_link="left_arm"/></group>
  <group_state name="bent" group="whole"><joint name="left_joint" value="-1.0"/></group_state>
  <disable_collisions link1="left_base" link2="left_arm" reason="Adjacent"/>
</robot>
"""


@pytest.fixture
def secret_arm(tmp_path: Path) -> Path:
    """Return the folder of a package that only the client knows the name of."""
    files = {
        "urdf/arm.urdf.xacro": XACRO,
        "urdf/link.xacro": LINK,
        "urdf/place.xacro": PLACE,
        "config/limits.yaml": "{lower: -1.5, upper: 0.5}\n",
        "arm.srdf": SRDF,
    }
    for mesh in ("base", "tip"):
        files[f"meshes/{mesh}.obj"] = f"mtllib {mesh}.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
        files[f"meshes/{mesh}.mtl"] = "newmtl red\nKd 1 0 0\n"
    for name, text in files.items():
        path = tmp_path / "elsewhere" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path / "elsewhere"


URI = "package://secret_arm/urdf/arm.urdf.xacro"


def test_a_xacro_file_comes_with_all_that_it_names(client: Client, secret_arm: Path) -> None:
    """The kernel cannot resolve the package's name, so all it reads was sent by the client."""
    packages = {"secret_arm": secret_arm}
    robot = client.load_robot(URI, name="arm", packages=packages, settings={"arguments": {"with_tip": "1"}})
    limits = robot.limits["joint"]
    assert (limits.lower, limits.upper) == (-1.5, 0.5)
    meshes = {}
    for link in robot.links:
        for figure in client.scene.node(link)._message.figures:
            meshes[link] = {Path(figure.mesh.uri).name, *(Path(file.uri).name for file in figure.mesh.files)}
    assert meshes == {"arm.base": {"base.obj", "base.mtl"}, "arm.tip": {"tip.obj", "tip.mtl"}}
    # Without the argument no tip is named, so none is sent.
    sent = client.assets.upload_with_references(URI, packages)
    assert {name.rpartition("/")[2] for name in sent.files} == {
        *("arm.urdf.xacro", "link.xacro", "place.xacro", "limits.yaml", "base.obj", "base.mtl"),
    }
    assert [name.rpartition("/")[2] for name in sent.missing] == ["nowhere.xacro"]


def test_a_missing_include_says_where_it_was_sought(client: Client, secret_arm: Path) -> None:
    (secret_arm / "urdf" / "place.xacro").unlink()
    with pytest.raises(virtualrobot.VirtualRobotError, match=r"place\.xacro"):
        client.load_robot(URI, packages={"secret_arm": secret_arm})


def test_an_srdf_file_gives_groups_postures_and_pairs(client: Client, secret_arm: Path) -> None:
    robot = client.load_robot(
        URI,
        packages={"secret_arm": secret_arm},
        settings={"arguments": {"prefix": "left_"}},
        srdf="package://secret_arm/arm.srdf",
    )
    group = robot.groups["whole"]
    assert (group.joint_names, group.base_link, group.tip_link) == (("left_joint",), "left_base", "left_arm")
    assert robot.postures == {"bent": {"left_joint": -1.0}}
    pairs = {frozenset((pair.first, pair.second)): pair.reason for pair in robot.allowed_collisions}
    assert pairs == {frozenset(("left_base", "left_arm")): "Adjacent"}
    robot.move_to("bent")
    assert robot.positions.tolist() == pytest.approx([-1.0], abs=1e-9)
    with pytest.raises(virtualrobot.MissingFileError, match=r"none\.srdf"):
        client.load_robot(URI, packages={"secret_arm": secret_arm}, srdf=secret_arm / "none.srdf")


def test_what_is_odd_about_a_file_is_logged(client: Client, secret_arm: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "virtualrobot"):
        client.load_robot(URI, packages={"secret_arm": secret_arm}, settings={"arguments": {"prefx": "left_"}})
    assert any("did you mean 'prefix'" in message for message in caplog.messages)
    assert [warning.text for warning in client.scene.warnings] == caplog.messages
    assert {warning.file for warning in client.scene.warnings} == {URI}
    with pytest.raises(virtualrobot.MalformedFileError, match="did you mean 'prefix'"):
        client.load_robot(
            URI, packages={"secret_arm": secret_arm}, settings={"arguments": {"prefx": "left_"}}, strict=True
        )
    assert client.scene.warnings == ()  # none of a load before the one that was refused


def test_settings_that_no_importer_has_are_refused(client: Client, secret_arm: Path) -> None:
    with pytest.raises(virtualrobot.VirtualRobotError, match="argumnets"):
        client.load_robot(URI, packages={"secret_arm": secret_arm}, settings={"argumnets": {"prefix": "left_"}})


def test_known_models_are_listed_and_loaded(client: Client) -> None:
    known = {model.name: model for model in client.models()}
    assert list(known) == sorted(known)
    assert known["iiwa"].installed
    assert known["iiwa"].package == "pybullet"
    assert (known["ur5e"].maker, known["ur5e"].payload, known["ur5e"].uri) == ("Universal Robots", 5.0, "")
    assert [one.name for one in client.models("simple UR10", maker="universal")] == ["ur10", "ur10e"]
    robot = client.load_robot("model://iiwa", name="arm")
    assert len(robot.chain_joint_names) == 7
    with pytest.raises(virtualrobot.UnknownNameError, match="did you mean 'iiwa'"):
        client.load_robot("model://iiw")


def standard(a: float, alpha: float, d: float, theta: float) -> np.ndarray:
    """Rz(theta) Tz(d) Tx(a) Rx(alpha); R. P. Paul, Robot Manipulators, 1981."""
    return pose(yaw=theta) @ pose(z=d) @ pose(x=a) @ pose(roll=alpha)


def modified(a: float, alpha: float, d: float, theta: float) -> np.ndarray:
    """Rx(alpha) Tx(a) Rz(theta) Tz(d); J. J. Craig, Introduction to Robotics, 1986."""
    return pose(roll=alpha) @ pose(x=a) @ pose(yaw=theta) @ pose(z=d)


@pytest.mark.parametrize("convention", [standard, modified])
def test_a_table_is_a_robot(client: Client, rng: np.random.Generator, convention) -> None:  # noqa: ANN001 the two above
    rows = rng.uniform(-1, 1, (5, 4))
    base, flange = pose(*rng.uniform(-1, 1, 6)), pose(*rng.uniform(-1, 1, 6))
    kinds = ["revolute", "prismatic", "continuous", "revolute", "prismatic"]
    table = [
        {**dict(zip(("a", "alpha", "d", "theta"), row, strict=True)), "type": kind, "limits": (-2, 2), "name": f"j{i}"}
        for i, (row, kind) in enumerate(zip(rows.tolist(), kinds, strict=True))
    ]
    del table[2]["limits"]
    robot = client.load_denavit_hartenberg(
        table, convention=convention.__name__, name="table", pose=base, base_t_first=flange, last_t_flange=base
    )
    assert robot.joint_names == [f"j{i}" for i in range(5)]
    assert (robot.limits["j0"].lower, robot.limits["j0"].upper) == (-2, 2)
    assert np.isinf(robot.limits["j2"].upper)
    q = rng.uniform(-2, 2, 5)
    expected = base @ flange
    for (a, alpha, d, theta), kind, value in zip(rows, kinds, q, strict=True):
        turn, slide = (0.0, value) if kind == "prismatic" else (value, 0.0)
        expected = expected @ convention(a, alpha, d + slide, theta + turn)
    np.testing.assert_allclose(robot.solve_forward(q).world_t_tcp, expected @ base, atol=1e-12)
    assert client.load_denavit_hartenberg([(1, 0, 0, 0)], convention="standard").name


def test_a_robot_is_exported_and_loaded_again(client: Client, tmp_path: Path, rng: np.random.Generator) -> None:
    panda = client.load_robot(PANDA, name="panda")
    (tmp_path / "out").mkdir()
    exported = client.scene.export(panda, tmp_path / "out" / "arm.urdf")
    assert exported.files[-1] == tmp_path / "out" / "arm.urdf"
    assert sorted(exported.files) == sorted(path for path in (tmp_path / "out").rglob("*") if path.is_file())
    named = [mesh.get("filename") for mesh in ElementTree.parse(exported.files[-1]).iterfind(".//mesh")]
    assert named
    assert all((tmp_path / "out" / str(name).removeprefix("./")).is_file() for name in named)
    again = client.load_robot(exported.files[-1], name="again")
    assert again.joint_names == panda.joint_names
    q = {name: rng.uniform(limits.lower, limits.upper) for name, limits in panda.limits.items()}
    expected = panda.solve_forward(q).world_t_link
    for link, world_t_link in again.solve_forward(q).world_t_link.items():
        np.testing.assert_allclose(world_t_link, expected[link.replace("again.", "panda.")], atol=1e-9)


def test_an_export_spares_the_meshes_of_another(client: Client, tmp_path: Path) -> None:
    client.load_robot(PANDA, name="panda")
    meshes = client.scene.export("panda", tmp_path / "panda.urdf").files[:-1]
    client.scene.export("panda", tmp_path / "panda.urdf")  # as often as one likes
    client.scene.export("panda", tmp_path / "same.urdf")  # the same meshes
    meshes[0].write_bytes(b"of another robot")
    with pytest.raises(virtualrobot.InvalidArgumentError, match=f"{meshes[0].name} is there already"):
        client.scene.export("panda", tmp_path / "other.urdf")
    assert meshes[0].read_bytes() == b"of another robot"
    assert not (tmp_path / "other.urdf").exists()


def test_a_part_is_exported_as_it_stands(client: Client, tmp_path: Path, iiwa: Robot) -> None:
    client.scene.add_part("box", virtualrobot.box(0.1, 0.2, 0.3), pose=pose(x=1))
    exported = client.scene.export("box", tmp_path / "box.glb")
    assert exported.files == (tmp_path / "box.glb",)
    mesh = trimesh.load(exported.files[0], force="mesh")
    np.testing.assert_allclose(sorted(mesh.extents), [0.1, 0.2, 0.3], atol=1e-6)  # pyright: ignore[reportAttributeAccessIssue]
    world = client.scene.export("", tmp_path / "world.GLB").files[0]
    assert world.stat().st_size > exported.files[0].stat().st_size
    for node, file, message in (
        ("box", "box.stl", r"'\.stl'; valid: \.glb, \.urdf"),
        ("box", "box", r"valid: \.glb, \.urdf"),
        ("box", "box.urdf", "'box'.* is none; robots: 'iiwa'"),
        ("bxo", "box.glb", "did you mean 'box'"),
    ):
        with pytest.raises(virtualrobot.VirtualRobotError, match=message):
            client.scene.export(node, tmp_path / "none" / file)
    assert not (tmp_path / "none").exists()


def test_two_arms_reach_as_far_as_their_maker_tells(client: Client) -> None:
    """Motoman SDA10: 720 mm to the wrist of an arm, 1,970 mm from wrist to wrist."""
    robot = client.load_robot("model://sda10")

    def place(link: str) -> np.ndarray:
        return np.asarray(client.scene[f"sda10.{link}"].pose)[:3, 3]

    assert np.linalg.norm(place("left_b") - place("right_b")) == pytest.approx(1.97)
    for side in ("left", "right"):
        assert np.linalg.norm(place(f"{side}_b") - place(f"{side}_l")) == pytest.approx(0.72)
        arm = robot.group(f"{side}_arm")
        assert [name.rpartition("_")[2] for name in arm.joint_names] == [*"sleurbt"]
    robot.set_positions(robot.postures["home"])
    for side, sign in (("left", 1.0), ("right", -1.0)):  # the hands look ahead, side by side
        flange = np.asarray(client.scene[f"sda10.{side}_flange"].pose)
        np.testing.assert_allclose(flange[:3, 2], [1.0, 0.0, 0.0], atol=1e-8)
        np.testing.assert_allclose(flange[:3, 3], [0.1925 + 0.72 * np.sqrt(0.5) + 0.175, sign * 0.265, 1.2], atol=1e-8)


def test_the_hook_of_a_crane_hangs_plumb_wherever_its_boom_is(client: Client) -> None:
    robot = client.load_robot("model://pedestal_crane")
    for luffing in (0.0, 0.5, 1.3):
        robot.set_positions({"slewing": 0.7, "luffing": luffing, "hoisting": 5.0})
        hook = np.asarray(client.scene["pedestal_crane.hook"].pose)
        np.testing.assert_allclose(hook[:3, 2], [0.0, 0.0, -1.0], atol=1e-12)
        radius = 1.9 + 30.0 * np.cos(luffing)
        height = 8.2 + 30.0 * np.sin(luffing) - 6.5
        np.testing.assert_allclose(hook[:3, 3], [radius * np.cos(0.7), radius * np.sin(0.7), height], atol=1e-9)
