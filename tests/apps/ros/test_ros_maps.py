"""Octrees as `octomap_msgs/Octomap` with pyoctomap, and the disparity of a camera with two eyes, told to roslibpy."""

from __future__ import annotations

import base64
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client
from virtualrobot.errors import MalformedFileError, MissingFileError
from virtualrobot_apps.bridges.ros.bridge import RosBridge
from virtualrobot_apps.bridges.ros.messages.ros1 import md5_of

from tests.apps.ros.bridges import Heard, bridge, roslibpy_client

pytestmark = pytest.mark.long

OCTOMAP: Any = import_module("pyoctomap")
POINTS = [[0.5, 0.2, 0.3], [1.0, -0.4, 0.1], [-0.7, 0.0, 1.2]]
WALL = 2.0
"""Distance (m) of a wall from a camera that looks at it."""


def test_an_octree_and_a_disparity_cross(client: Client, tmp_path: Path) -> None:
    tree = OCTOMAP.OcTree(0.1)
    for point in POINTS:
        tree.updateNode(point, True)
    tree.updateNode([0.0, 0.0, 0.0], False)
    file = tmp_path / "cell.bt"
    assert tree.writeBinary(str(file))
    pair = virtualrobot.camera(32, 24, images=["depth"], stereo_baseline=0.1, rate=10.0)
    client.scene.add_camera("eyes", pair)  # along z
    client.scene.add_object("wall", virtualrobot.box(20.0, 20.0, 0.2), pose=virtualrobot.pose(z=WALL + 0.1))
    assert any(one.startswith("/octomap_binary ") for one in RosBridge(client, [], floor=file).check())
    with bridge(client, floor=file) as (url, _), roslibpy_client(url) as ros:
        told = Heard(ros, "/octomap_binary", "octomap_msgs/Octomap").next()
        seen = Heard(ros, "/eyes/disparity", "stereo_msgs/DisparityImage").next()
    assert (told["header"]["frame_id"], told["binary"], told["id"]) == ("world", True, "OcTree")
    # As octomap_msgs' own reader does: the tree's data behind a head of OctoMap's file.
    head = f"# Octomap OcTree binary file\nid OcTree\nsize {tree.size()}\nres {told['resolution']}\ndata\n"
    again = tmp_path / "again.bt"
    again.write_bytes(head.encode() + np.array(told["data"], np.int8).tobytes())
    read = OCTOMAP.OcTree(0.1)
    assert read.readBinary(str(again))
    for point in POINTS:
        assert read.isNodeOccupied(read.search(point))
    assert not read.isNodeOccupied(read.search([0.0, 0.0, 0.0]))
    pixels = np.frombuffer(base64.b64decode(seen["image"]["data"]), "<f4")
    assert len(pixels) == 32 * 24 and seen["t"] == pytest.approx(0.1)
    assert pixels == pytest.approx(np.full(32 * 24, seen["f"] * 0.1 / WALL), rel=1e-5)  # d = f b / Z
    assert seen["min_disparity"] <= pixels.min() and pixels.max() <= seen["max_disparity"]


def test_what_is_no_octree_is_refused(client: Client, tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match="there is no map"):
        RosBridge(client, [], floor=tmp_path / "none.bt").check()
    for text in (
        "",
        "# Octomap OcTree file\nid OcTree\nsize 1\nres 0.1\ndata\n",
        "# Octomap OcTree binary file\nres x",
    ):
        (tmp_path / "odd.bt").write_text(text, "utf-8")
        with pytest.raises(MalformedFileError, match="no octree of OctoMap"):
            RosBridge(client, [], floor=tmp_path / "odd.bt").check()


def test_the_type_is_octomaps() -> None:
    # Source: octomap_msgs 0.3 of ROS 1 Noetic.
    assert md5_of("octomap_msgs/msg/Octomap") == "9a45536b45c5e409cd49f04bb2d9999f"
