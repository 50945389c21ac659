"""The demo's scene file is a whole cell by itself: `virtualrobot serve cell.yaml`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot.kernel_process import KernelProcess
from virtualrobot.v1 import nodes_pb2
from virtualrobot_apps.demos.palletizing import cell


@pytest.fixture(scope="module")
def client() -> Iterator[virtualrobot.Client]:
    """Return a client of a kernel that was started with the scene file."""
    with KernelProcess(str(cell.SCENE), headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        yield client


@pytest.mark.long
def test_tools_of_the_file_hang_on_links_of_its_models(client: virtualrobot.Client) -> None:
    assert client.robot("iiwa").tools == ["vacuum-gripper"]
    assert client.robot("panda").tools == ["panda-hand"]
    # Heights of the parts, along the flange's axis: flange of the URDF, adapter, cups; hand to fingertips.
    for robot, link, height in (
        ("iiwa", "iiwa.lbr_iiwa_link_7", 0.045 + 0.03 + 0.08),
        ("panda", "panda.panda_hand", 0.105),
    ):
        expected = client.scene.pose(link) @ virtualrobot.pose(z=height)
        np.testing.assert_allclose(client.robot(robot).tcp, expected, atol=1e-12)


def test_the_arms_stand_ready_and_the_hand_is_open(client: virtualrobot.Client) -> None:
    panda = client.robot("panda")
    assert panda.state.tool_states == {"panda-hand": "open"}
    assert dict(zip(panda.joint_names, panda.positions, strict=True))["panda_finger_joint1"] == 0.04
    for robot in ("iiwa", "panda"):
        assert client.robot(robot).tcp[2, 2] < -0.999, "the tool points down"


def test_drums_turn_as_the_belt_moves(client: virtualrobot.Client) -> None:
    before = client.scene.poses()
    client.robot("conveyor").set_positions({"belt": 0.03})
    after = client.scene.poses()
    np.testing.assert_allclose(after["conveyor.belt"][:3, 3] - before["conveyor.belt"][:3, 3], [0.03, 0, 0], atol=1e-12)
    for drum in ("conveyor.infeed-drum", "conveyor.discharge-drum"):
        turn = after[drum][:3, :3] @ before[drum][:3, :3].T
        # A drum of 50 mm radius turns by 0.03 / 0.05 rad about y, its upper side along x.
        np.testing.assert_allclose(turn, virtualrobot.pose(pitch=0.03 / 0.05)[:3, :3], atol=1e-9)
    client.robot("conveyor").set_positions({"belt": 0.0})


def test_it_has_a_megabyte_as_gltf_for_headsets(client: virtualrobot.Client, tmp_path: Path) -> None:
    """A millimeter off at most."""
    client.scene.export("world", tmp_path / "full.glb")
    client.scene.export("world", tmp_path / "small.glb", tolerance=1e-3)
    full, small = ((tmp_path / name).stat().st_size for name in ("full.glb", "small.glb"))
    assert full > 5e6 and small <= 1e6
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"only \.glb .*not \.usdz"):
        client.scene.export("world", tmp_path / "still.usdz", tolerance=1e-3)


def test_it_is_the_same_after_saving_and_loading(client: virtualrobot.Client, tmp_path: Path) -> None:
    nodes, poses = client.scene._read()
    client.scene.save(tmp_path / "saved.yaml")
    client.scene.load_scene(tmp_path / "saved.yaml")
    nodes_after, poses_after = client.scene._read()
    assert {node.name: rounded(node) for node in nodes} == {node.name: rounded(node) for node in nodes_after}
    order = [[node.name for node in nodes_after].index(node.name) for node in nodes]
    np.testing.assert_allclose(poses_after[order], poses, atol=1e-12)


def rounded(node: nodes_pb2.Node) -> str:
    """Return all that a node says but its number; a quaternion's last digit changes each time it is normalised."""
    node.uid = 0
    return re.sub(r"-?\d+\.\d+(e-?\d+)?", lambda number: f"{float(number[0]) + 0.0:.12f}", str(node))


def test_the_iiwa_gets_the_speeds_of_its_data_sheet(client: virtualrobot.Client) -> None:
    cell.load(client)
    speeds = [limit.velocity for limit in client.robot("iiwa").limits.values()]
    np.testing.assert_allclose(np.degrees(speeds), [98, 98, 100, 130, 140, 180, 180])  # KUKA, LBR iiwa 7 R800


@pytest.mark.long
def test_without_pybullet_the_same_arms_come_from_rtb_data(
    client: virtualrobot.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    cell.load(client)
    places = [client.robot(robot).tcp for robot in ("iiwa", "panda")]
    monkeypatch.setattr(cell, "find_spec", lambda name: None)
    cell.load(client)
    assert client.robot("iiwa").chain_joint_names[0] == "joint_a1"
    np.testing.assert_allclose([client.robot(robot).tcp for robot in ("iiwa", "panda")], places, atol=3e-4)
    assert not client.collisions.check(robots=["iiwa"]).pairs
