"""A small reading of URDF files into the arrays of the numeric core, independent of the kernel's own importer."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import NamedTuple

import numpy as np
from virtualrobot_kernel.numeric.forest import forward_forest, topological_order

from tests.pybullet_models import pybullet_data

DATA = Path(pybullet_data.getDataPath())
MODELS = Path(__file__).parents[3] / "plugins" / "virtualrobot_plugins" / "models"
URDFS = {
    "iiwa": DATA / "kuka_iiwa" / "model.urdf",
    "panda": DATA / "franka_panda" / "panda.urdf",
    "xarm6": DATA / "xarm" / "xarm6_robot.urdf",
    "puma560": MODELS / "puma560.urdf",
}
ARMS = {
    "iiwa": ("lbr_iiwa_link_0", "lbr_iiwa_link_7"),
    "panda": ("panda_link0", "panda_link8"),
    "xarm6": ("link_base", "link6"),
    "puma560": ("base_link", "tool0"),
}
"""Base and tip link of each serial arm."""

_TYPES = {"fixed": 0, "revolute": 1, "continuous": 1, "prismatic": 2, "floating": 3, "planar": 4}


class Forest(NamedTuple):
    """Rows are links, in the order of the file; coordinates are the independent scalar joints, in the same order."""

    links: list[str]
    joints: list[str]
    parent: np.ndarray
    joint_type: np.ndarray
    axis: np.ndarray
    q_index: np.ndarray
    multiplier: np.ndarray
    offset: np.ndarray
    parent_t_node: np.ndarray
    lower: np.ndarray
    upper: np.ndarray


def from_roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Return Rz(yaw) Ry(pitch) Rx(roll), as URDF defines rpy."""
    cr, sr, cp, sp, cy, sy = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def _floats(element: ElementTree.Element | None, name: str, default: str) -> list[float]:
    return [float(word) for word in (default if element is None else element.get(name, default)).split()]


def read(path: Path) -> Forest:
    """Read the links and joints of a URDF file whose joints are fixed or scalar."""
    robot = ElementTree.parse(path).getroot()
    links = [link.attrib["name"] for link in robot.findall("link")]
    elements = [joint for joint in robot.findall("joint") if joint.find("child") is not None]
    joints = [j.attrib["name"] for j in elements if j.get("type") != "fixed" and j.find("mimic") is None]
    n = len(links)
    forest = Forest(
        links,
        joints,
        np.full(n, -1, np.int32),
        np.zeros(n, np.int8),
        np.tile([0.0, 0.0, 1.0], (n, 1)),
        np.full(n, -1, np.int32),
        np.ones(n),
        np.zeros(n),
        np.tile(np.eye(4), (n, 1, 1)),
        np.full(len(joints), -np.inf),
        np.full(len(joints), np.inf),
    )
    for joint in elements:
        row = links.index(joint.find("child").attrib["link"])  # pyright: ignore[reportOptionalMemberAccess]  checked above
        parent = joint.find("parent")
        assert parent is not None
        forest.parent[row] = links.index(parent.attrib["link"])
        forest.joint_type[row] = _TYPES[joint.attrib["type"]]
        forest.parent_t_node[row, :3, :3] = from_roll_pitch_yaw(*_floats(joint.find("origin"), "rpy", "0 0 0"))
        forest.parent_t_node[row, :3, 3] = _floats(joint.find("origin"), "xyz", "0 0 0")
        if forest.joint_type[row] == 0:
            continue
        axis = np.array(_floats(joint.find("axis"), "xyz", "1 0 0"))
        forest.axis[row] = axis / np.linalg.norm(axis)
        mimic = joint.find("mimic")
        forest.q_index[row] = joints.index(joint.attrib["name"] if mimic is None else mimic.attrib["joint"])
        if mimic is not None:
            forest.multiplier[row] = float(mimic.get("multiplier", "1"))
            forest.offset[row] = float(mimic.get("offset", "0"))
        elif joint.attrib["type"] != "continuous":
            limit = joint.find("limit")
            assert limit is not None
            forest.lower[forest.q_index[row]] = float(limit.attrib["lower"])
            forest.upper[forest.q_index[row]] = float(limit.attrib["upper"])
    return forest


def world_poses(forest: Forest, q: np.ndarray) -> np.ndarray:
    """Return the world pose of every link."""
    out = np.full((len(forest.links), 4, 4), np.nan)
    forward_forest(
        topological_order(forest.parent),
        forest.parent,
        forest.joint_type,
        forest.axis,
        forest.q_index,
        forest.multiplier,
        forest.offset,
        forest.parent_t_node,
        q,
        out,
    )
    return out
