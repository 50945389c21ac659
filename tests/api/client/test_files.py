"""Models, meshes and scene files of the client's machine: sent with all that they name, saved and loaded again."""

from __future__ import annotations

import hashlib
import shutil
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, pose

from tests.api.client.conftest import MODELS, PANDA


def moved_model(tmp_path: Path, package: str) -> Path:
    """Copy the Panda to a folder that the kernel is not told of; only its client knows the package's name."""
    folder = tmp_path / "elsewhere"
    shutil.copytree(MODELS / "franka_panda", folder)
    text = (folder / "panda.urdf").read_text().replace("package://meshes/", f"package://{package}/meshes/")
    (folder / "panda.urdf").write_text(text)
    return folder


def test_a_kernel_that_cannot_see_the_files_loads_them(client: Client, tmp_path: Path) -> None:
    """The kernel cannot resolve the package's name, so all it reads was sent by the client."""
    folder = moved_model(tmp_path, "secret_of_the_client")
    uri = "package://secret_of_the_client/panda.urdf"
    with pytest.raises(virtualrobot.MissingFileError):
        client.scene.load(uri)  # neither side knows the package
    robot = client.load_robot(uri, name="panda", packages={"secret_of_the_client": folder})
    meshes = [
        figure.mesh
        for link in robot.links
        for figure in client.scene.node(link)._message.figures
        if figure.WhichOneof("geometry") == "mesh"
    ]
    assert len(meshes) == (folder / "panda.urdf").read_text().count("<mesh ")
    sent = {mesh.sha256 for mesh in meshes} | {file.sha256 for mesh in meshes for file in mesh.files}
    assert client.assets.find(sent) == sent


def test_a_mesh_that_is_loaded_sends_no_other_files_of_the_clients_disk(client: Client, tmp_path: Path) -> None:
    secrets = [tmp_path / "secret.mtl", tmp_path / "home" / "secret.mtl"]
    folder = tmp_path / "home" / "downloads"
    folder.mkdir(parents=True)
    for number, secret in enumerate(secrets):
        secret.write_text(f"newmtl secret {number} of the client")
    (folder / "link.mtl").symlink_to(secrets[0])
    names = ["link.mtl", "../secret.mtl", *map(str, secrets), "package://home/secret.mtl", "/etc/hostname"]
    (folder / "x.obj").write_text(
        "".join(f"mtllib {name}\n" for name in names) + "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    )
    sent = client.assets.upload_with_references(folder / "x.obj")
    assert set(sent.files) == {str(folder / "x.obj")}
    assert set(sent.missing) == set(names)
    assert client.assets.find(hashlib.sha256(secret.read_bytes()).hexdigest() for secret in secrets) == set()


def test_a_model_is_loaded_from_a_text(client: Client, tmp_path: Path) -> None:
    """Its file is nowhere; what the text names is looked for beside the name that it has."""
    text = (MODELS / "kuka_iiwa" / "model.urdf").read_text()
    arm = client.load_robot(MODELS / "kuka_iiwa" / "of_a_text.urdf", name="arm", text=text)
    assert len(arm.positions) == 7
    alone = '<robot name="alone"><link name="base"/></robot>'
    assert client.load_robot(tmp_path / "alone.urdf", text=alone).name == "alone"
    with pytest.raises(virtualrobot.MalformedFileError, match=r"bad\.urdf"):
        client.load_robot(tmp_path / "bad.urdf", text="<robot")
    with pytest.raises(virtualrobot.MissingFileError, match=r"model\.urdf|meshes"):
        client.load_robot(tmp_path / "model.urdf", text=text)


def test_the_same_arm_by_path_and_by_uri(client: Client) -> None:
    by_path = client.load_robot(MODELS / "franka_panda/panda.urdf")
    by_uri = client.load_robot(PANDA)
    assert by_path.name != by_uri.name
    assert by_path.joint_names == by_uri.joint_names
    np.testing.assert_array_equal(by_path.tcp, by_uri.tcp)


def test_a_missing_file_says_where_it_was_sought(client: Client, tmp_path: Path) -> None:
    with pytest.raises(virtualrobot.MissingFileError, match=r"none\.urdf") as refused:
        client.scene.load(tmp_path / "none.urdf")
    assert isinstance(refused.value, FileNotFoundError)
    urdf = '<robot name="r"><link name="a"><visual><geometry><mesh filename="{}"/></geometry></visual></link></robot>'
    (tmp_path / "r.urdf").write_text(urdf.format("package://nobody/none.stl"))
    with pytest.raises(virtualrobot.MissingFileError, match=str(tmp_path / "none.stl")):
        client.scene.load(tmp_path / "r.urdf")
    (tmp_path / "broken.urdf").write_text("<robot>")
    with pytest.raises(virtualrobot.MalformedFileError):
        client.scene.load(tmp_path / "broken.urdf")
    with pytest.raises(virtualrobot.WrongStateError, match="is no robot"):
        client.load_robot(MODELS / "duck.obj")


def test_a_mesh_is_an_object_a_part_or_a_figure(client: Client) -> None:
    part = client.scene.load(MODELS / "duck.obj", name="duck", as_part=True, scale=0.1, pose=pose(x=1))
    assert part.kind == "part"
    assert part._message.figures[0].mesh.scale.x == 0.1
    figure = client.assets.mesh(MODELS / "duck.obj", scale=(1, -1, 1))
    # The duck names its material and this its texture.
    assert {Path(file.uri).name for file in figure._message.mesh.files} == {"duck.mtl", "duckCM.png"}
    mirrored = client.scene.add_object("mirrored duck", figure)
    assert mirrored._message.figures[0].mesh.scale.y == -1
    assert mirrored._message.figures[0].mesh.sha256 == part._message.figures[0].mesh.sha256


def test_a_mesh_is_made_of_arrays(client: Client, tmp_path: Path) -> None:
    """A ramp that rises by 0.2 for 1 m, felt by rays, saved with its file and loaded again."""
    corners = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.2), (1.0, 1.0, 0.2), (0.0, 1.0, 0.0)])
    ramp = client.assets.triangles(corners, [(0, 1, 2), (0, 2, 3)], color="green", pose=pose(x=2.0))

    def height(x: float) -> float:
        return 1.0 - client.rays.cast([x, 0.3, 1.0], [(0.0, 0.0, -1.0)]).distances[0]

    client.scene.add_object("ramp", ramp)
    assert height(2.25) == pytest.approx(0.05, abs=1e-6) and height(2.9) == pytest.approx(0.18, abs=1e-6)
    client.scene.save(tmp_path / "ramp.yaml", bundle=True)
    client.scene.load_scene(tmp_path / "ramp.yaml")
    assert height(2.5) == pytest.approx(0.1, abs=1e-6)
    for places, numbers, said in (
        ([(0.0, 0.0)], [(0, 0, 0)], "corners are finite numbers of shape"),
        (np.full((3, 3), np.nan), [(0, 1, 2)], "corners are finite"),
        (corners, np.zeros((0, 3), int), "triangles are whole numbers of shape"),
        (corners, [(0.0, 1.0, 2.0)], "triangles are whole numbers"),
        (corners, [(0, 1, 2), (0, 2, 4)], r"triangle 1 has the corners \[0, 2, 4\] of 4"),
    ):
        with pytest.raises(virtualrobot.InvalidArgumentError, match=said):
            client.assets.triangles(places, numbers)


def test_bytes_come_back(client: Client, rng: np.random.Generator) -> None:
    for size in (0, 1, 1024 * 1024, 3 * 1024 * 1024 + 1):
        data = rng.bytes(size)
        sha256 = client.assets.upload(data)
        assert client.assets.upload(data) == sha256
        assert client.assets.download(sha256) == data
    with pytest.raises(virtualrobot.AssetError):
        client.assets.download("0" * 64)


@pytest.mark.parametrize("bundle", [False, True])
def test_a_saved_scene_is_the_same_when_loaded(client: Client, tmp_path: Path, bundle: bool) -> None:
    robot = client.load_robot(PANDA, name="panda", pose=pose(0.1, 0.2, 0.3, 0.4, 0.5, 0.6))
    client.scene.add_part("box", virtualrobot.box(0.1, 0.1, 0.1, color="red"), pose=pose(x=0.5), mass=1.5)
    client.signals.create("ready", True, description="the cell is ready")
    robot.set_positions({"panda_joint4": -1.5})
    (tmp_path / "cells").mkdir()
    written = client.scene.save(tmp_path / "cells" / "cell.yaml", bundle=bundle)
    assert written[-1] == tmp_path / "cells" / "cell.yaml"
    assert (len(written) > 1) == bundle
    names = [path.relative_to(tmp_path / "cells") for path in written]
    poses, positions = client.scene.poses(), robot.positions

    # Somewhere else and with more in the world, to show that it is replaced.
    shutil.move(tmp_path / "cells", tmp_path / "moved")
    client.scene.add_object("of no concern")
    client.scene.load_scene(tmp_path / "moved" / "cell.yaml")
    again = client.scene.poses()
    assert set(again) == set(poses)
    for name, world_t_node in poses.items():
        # Rotations are saved as quaternions, which costs a rounding or two.
        np.testing.assert_allclose(again[name], world_t_node, atol=1e-15)
    np.testing.assert_array_equal(client.robot("panda").positions, positions)
    assert client.signals["ready"] is True
    (tmp_path / "again").mkdir()
    saved_again = client.scene.save(tmp_path / "again" / "cell.yaml", bundle=bundle)
    assert [path.relative_to(tmp_path / "again") for path in saved_again] == names


def test_a_scene_is_added(client: Client, tmp_path: Path) -> None:
    client.scene.add_object("a")
    (tmp_path / "b.yaml").write_text("schema_version: 1\nnodes:\n- name: b\n  object: {}\n")
    assert client.scene.load_scene(tmp_path / "b.yaml", add=True) == ["b"]
    assert {node.name for node in client.scene.nodes()} == {"world", "a", "b"}
    (tmp_path / "bad.yaml").write_text("schema_version: 1\nnoodles: []\n")
    with pytest.raises(virtualrobot.MalformedFileError, match="nodes"):
        client.scene.load_scene(tmp_path / "bad.yaml")
