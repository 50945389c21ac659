"""Best cells of a study: by a result, and as scene files in which the robot stands where the cell has it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pyarrow
import yaml
from virtualrobot.errors import MalformedFileError, UnknownNameError, WrongStateError
from virtualrobot.geometry import pose_from_quaternion, quaternion_of

from virtualrobot_apps.studies.placement import elsewhere
from virtualrobot_apps.studies.study_file import NUMBER, Study
from virtualrobot_apps.studies.work import OK

PLACED = ("model", "x", "y", "yaw")
"""Parameters of the ready studies that say what a robot is, and where it stands."""


def best_cells(study: Study, table: pyarrow.Table, result: str, is_least: bool, count: int) -> list[dict[str, Any]]:
    """Return the rows of the cells whose result is greatest, or least, the best one first; fewer where few have it.

    Raises:
        UnknownNameError: when the study has no such result that is a number.
    """
    names = [name for name, kind in study.results if kind == NUMBER]
    if result not in names:
        raise UnknownNameError(f"the study has no result {result!r} that is a number; these are {', '.join(names)}")
    ordered = table.sort_by([(result, "ascending" if is_least else "descending"), ("cell", "ascending")])
    found = [row for row in ordered.to_pylist() if row["status"] == OK and row[result] is not None]
    return found[:count]


def scene_of(scene: Path, parameters: Mapping[str, Any]) -> str:
    """Return the text of a scene file in which a robot stands as in a cell of `virtualrobot_apps.studies.placement`.

    Its `model` is replaced as well, where the cell has one. Comments are lost.

    Raises:
        WrongStateError: when the parameters don't say where a robot stands.
        UnknownNameError: when the scene has no such robot.
        MalformedFileError: when the scene is no YAML.
    """
    if "robot" not in parameters or not any(name in parameters for name in PLACED):
        raise WrongStateError(f"no scene follows from these cells: they have no 'robot' with {', '.join(PLACED)}")
    try:
        root = yaml.compose(scene.read_text("utf-8"), yaml.SafeLoader)
    except yaml.YAMLError as error:
        raise MalformedFileError(f"{scene} is not YAML: {error}") from error
    robot = parameters["robot"]
    for kind in ("models", "nodes"):
        entries = _child(root, kind)
        for entry in entries.value if isinstance(entries, yaml.SequenceNode) else []:
            name = _child(entry, "name")
            if isinstance(name, yaml.ScalarNode) and name.value == robot:
                if "model" in parameters and kind == "models":
                    _set(entry, "uri", _scalar(parameters["model"]))
                _place(entry, parameters)
                return str(yaml.serialize(root, Dumper=yaml.SafeDumper, width=120))
    raise UnknownNameError(f"{scene} has no robot {robot!r} among its models and nodes")


def _place(entry: yaml.Node, parameters: Mapping[str, Any]) -> None:
    """Put a model or node elsewhere on its parent, at the height that it has, and turn it about the parent's z axis."""
    pose = _child(entry, "parent_t_node") or _mapping({})
    position = _numbers(_child(pose, "position"), "xyz", (0.0, 0.0, 0.0))
    orientation = _numbers(_child(pose, "orientation"), "xyzw", (0.0, 0.0, 0.0, 1.0))
    there = elsewhere(pose_from_quaternion(position, orientation), parameters)
    _set(pose, "position", _mapping(dict(zip("xyz", there[:3, 3].tolist(), strict=True))))
    _set(pose, "orientation", _mapping(dict(zip("xyzw", quaternion_of(there).tolist(), strict=True))))
    _set(entry, "parent_t_node", pose)


def _child(node: yaml.Node | None, key: str) -> yaml.Node | None:
    if not isinstance(node, yaml.MappingNode):
        return None
    return next((value for name, value in node.value if name.value == key), None)


def _set(node: yaml.Node, key: str, value: yaml.Node) -> None:
    assert isinstance(node, yaml.MappingNode)
    node.value = [(name, old) for name, old in node.value if name.value != key] + [(_scalar(key), value)]


def _numbers(node: yaml.Node | None, keys: str, without: tuple[float, ...]) -> list[float]:
    """Return numbers of a mapping by their keys, of which those that are left out are 0; `without` a mapping."""
    if node is None:
        return list(without)
    found = [_child(node, key) for key in keys]
    return [float(one.value) if isinstance(one, yaml.ScalarNode) else 0.0 for one in found]


def _mapping(values: Mapping[str, float]) -> yaml.MappingNode:
    pairs = [(_scalar(name), _scalar(float(value))) for name, value in values.items()]
    return yaml.MappingNode("tag:yaml.org,2002:map", pairs, flow_style=True)


def _scalar(value: str | float) -> yaml.ScalarNode:
    if isinstance(value, str):
        return yaml.ScalarNode("tag:yaml.org,2002:str", value)
    return yaml.ScalarNode("tag:yaml.org,2002:float", repr(value))
