"""Best cells of studies, and the scenes in which a robot stands where they have it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from virtualrobot.errors import MalformedFileError, UnknownNameError, WrongStateError
from virtualrobot.geometry import pose_from_quaternion
from virtualrobot_apps.studies.best import scene_of
from virtualrobot_apps.studies.command import study as command
from virtualrobot_apps.studies.placement import turned

from tests.apps.studies import done, written

SCENE = """
schema_version: 1
nodes:
- {name: table, object: {}, figures: [{box: {size: {x: 2, y: 2, z: 0.04}}}]}
- name: second
  robot: {flange: "tool0"}
  parent_t_node: {position: {x: 0.1, z: 0.3}, orientation: {x: 1}}
models:
- {uri: "model://ur5e", name: arm}  # a comment
- {uri: "part.stl", name: "yes", scale: {x: 1e-3, y: 1e-3, z: 1e-3}}
"""
STUDY = """
schema_version: 1
function: cells:f
scene: cell.yaml
parameters:
  robot: {list: [arm]}
  x: {grid: {from: -1, to: 1, count: 5}}
  yaw: {list: [0.5]}
results: {far: number, odd: text}
"""
FUNCTION = """
def f(cell):
    x = cell.parameters["x"]
    if x == 1.0:
        raise ValueError("beyond")
    return {"far": abs(x) if x else None, "odd": "a"}
"""


def test_the_best_cells_are_told_and_become_scenes(tmp_path: Path) -> None:
    (tmp_path / "cell.yaml").write_text(SCENE)
    study = written(tmp_path, STUDY, FUNCTION)
    done(study, tmp_path / "study")

    def said(*words: str) -> list[str]:
        answer = CliRunner().invoke(command, ["best", str(study.file), "--by", "far", *words], catch_exceptions=False)
        return answer.output.splitlines()

    assert said("--count", "2") == [
        "cell 0: far 1, robot arm, x -1, yaw 0.5, odd a",
        "cell 1: far 0.5, robot arm, x -0.5, yaw 0.5, odd a",
    ]
    # Those that failed, or have no such result, are none.
    assert [line.partition(":")[0] for line in said("--least")] == ["cell 1", "cell 3", "cell 0"]
    lines = said("--count", "1", "--scenes")
    assert lines[1] == str(tmp_path / "cell-0.yaml")
    scene = yaml.safe_load((tmp_path / "cell-0.yaml").read_text())
    assert scene["models"][0]["parent_t_node"]["position"] == {"x": -1.0, "y": 0.0, "z": 0.0}
    with pytest.raises(UnknownNameError, match="the study has no result 'odd' that is a number; these are far"):
        CliRunner().invoke(command, ["best", str(study.file), "--by", "odd"], catch_exceptions=False)


def pose_of(entry: dict) -> np.ndarray:
    place, turn = entry["parent_t_node"]["position"], entry["parent_t_node"]["orientation"]
    return pose_from_quaternion([place[name] for name in "xyz"], [turn[name] for name in "xyzw"])


def test_all_else_stays_as_it_was(tmp_path: Path) -> None:
    """Keys, texts that look like something else, numbers, and the height of the base; poses as the study has them."""
    file = tmp_path / "cell.yaml"
    file.write_text(SCENE)
    before = yaml.safe_load(SCENE)
    asked = {"robot": "second", "x": 0.7, "yaw": 0.4, "targets": "a, b"}
    after = yaml.safe_load(scene_of(file, asked))
    wanted = turned(0.4) @ pose_from_quaternion([0.1, 0.0, 0.3], [1.0, 0.0, 0.0, 0.0])
    wanted[:2, 3] = 0.7, 0.0
    np.testing.assert_allclose(pose_of(after["nodes"][1]), wanted, atol=1e-12)
    after["nodes"][1]["parent_t_node"] = before["nodes"][1]["parent_t_node"]
    assert after == before
    assert after["models"][1]["name"] == "yes"
    other = yaml.safe_load(scene_of(file, {"robot": "arm", "model": "model://ur10e", "y": -0.2, "yaw": math.pi}))
    assert other["models"][0]["uri"] == "model://ur10e"
    np.testing.assert_allclose(
        pose_of(other["models"][0]), turned(math.pi) + np.eye(4)[:, [1]] * [0, 0, 0, -0.2], atol=1e-12
    )


def test_bad_input_is_told(tmp_path: Path) -> None:
    file = tmp_path / "cell.yaml"
    file.write_text(SCENE)
    with pytest.raises(WrongStateError, match="no scene follows from these cells: they have no 'robot' with model, x"):
        scene_of(file, {"robot": "arm", "z": 1.0})
    with pytest.raises(UnknownNameError, match="has no robot 'legs' among its models and nodes"):
        scene_of(file, {"robot": "legs", "x": 1.0})
    file.write_text("a: [")
    with pytest.raises(MalformedFileError, match="is not YAML"):
        scene_of(file, {"robot": "arm", "x": 1.0})
