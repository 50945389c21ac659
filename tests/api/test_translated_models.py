"""Model files that an importer translates to a scene (SDFormat): several nodes come in under free names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from virtualrobot.v1 import nodes_pb2, robot_pb2, scene_pb2

from tests.api.asking import load, refusal
from tests.api.reading import pose, scene, unchanged
from tests.kernels import Stubs

CELL = """<?xml version="1.0"?>
<sdf version="1.7"><world name="cell">
  <model name="my.crane">
    <link name="base"/>
    <link name="arm"><pose>0 0 1 0 0 0</pose></link>
    <joint name="lift" type="prismatic">
      <parent>base</parent><child>arm</child>
      <axis><xyz>0 0 1</xyz><limit><lower>0</lower><upper>2</upper></limit></axis>
    </joint>
  </model>
  <model name="table"><static>true</static><pose>2 0 0 0 0 0</pose>
    <link name="top"><visual name="v"><geometry><box><size>1 1 1</size></box></geometry></visual></link>
  </model>
</world></sdf>"""


@pytest.fixture
def cell(tmp_path: Path) -> str:
    path = tmp_path / "cell.sdf"
    path.write_text(CELL)
    return str(path)


def names(response: scene_pb2.ImportModelResponse) -> list[str]:
    return [node.name for node in response.created]


def test_a_second_time_everything_gets_a_free_name(stubs: Stubs, cell: str) -> None:
    first, second = names(load(stubs, cell)), names(load(stubs, cell))
    assert first[0] == "my.crane" and "my.crane.arm" in first and "table" in first
    assert second[0] == "my.crane_2" and "my.crane_2.arm" in second and "table_2" in second
    assert not set(first) & set(second)
    told = stubs.robot.GetRobot(robot_pb2.GetRobotRequest(name="my.crane_2"))
    assert [joint.name for joint in told.joints] == ["lift"]
    assert all(link.startswith("my.crane_2.") for link in told.links)


def test_parent_and_pose_are_those_of_the_request(stubs: Stubs, cell: str) -> None:
    load(stubs, cell)
    place = np.eye(4)
    place[:3, 3] = (0.5, 1.0, 0.25)
    load(stubs, cell, parent="table", parent_t_node=pose(place))
    found = scene(stubs, "table", "table_2", "my.crane_2")
    np.testing.assert_allclose(found["table"][:3, 3], (2.0, 0.0, 0.0))
    np.testing.assert_allclose(found["table_2"][:3, 3], (2.0 + 0.5 + 2.0, 1.0, 0.25))
    np.testing.assert_allclose(found["my.crane_2"][:3, 3], (2.0 + 0.5, 1.0, 0.25))


def test_a_scene_has_no_base_joint_to_choose(stubs: Stubs, cell: str) -> None:
    error = refusal(lambda: load(stubs, cell, base_joint=nodes_pb2.JOINT_TYPE_FLOATING))
    assert error.reason == "INVALID_ARGUMENT"
    assert "base joint" in error.message


def test_a_broken_file_changes_nothing(stubs: Stubs, cell: str) -> None:
    Path(cell).write_text(CELL.replace("<child>arm</child>", "<child>arms</child>"))
    with unchanged(stubs):
        error = refusal(lambda: load(stubs, cell))
    assert error.reason == "MALFORMED_FILE"
    assert "arms" in error.message and "cell.sdf" in error.message
