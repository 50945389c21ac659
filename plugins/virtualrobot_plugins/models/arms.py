"""Arms without a model file: axes as a data sheet's drawing shows them, and simple bodies that are drawn along them.

The figures are cylinders along the links and about the axes, in proportion to the arm: they stand for no measured
shape.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from itertools import combinations
from typing import Annotated, Literal

import msgspec
import numpy as np

Direction = Literal["x", "-x", "y", "-y", "z", "-z"]
Axis = tuple[float, float, float, Direction, float, float, float]
Color = tuple[float, float, float]

THICKNESS = 0.045
"""Radius of the first joint relative to the lengths of all links together; the last one's is half of it."""
METAL: Color = (0.32, 0.34, 0.37)
_HALF_TURN = np.pi / 2.0


@dataclass(frozen=True, slots=True)
class Arm:
    """Geometry of a serial arm in the posture in which its controller shows all joints at zero.

    Attributes:
        joints: for each axis a point on it (x, y, z in mm in the base frame: z up, x forward), its positive direction,
            the least and the greatest position and the greatest speed (degrees and degrees/s; mm where it slides). The
            bodies run from point to point.
        flange: the flange's centre (mm) and the direction that it faces.
        home: the posture `home` (degrees, mm); empty for none.
        sliding: numbers of the joints that slide, from 1.
    """

    joints: Annotated[list[Axis], msgspec.Meta(min_length=1)]
    flange: tuple[float, float, float, Direction]
    home: tuple[float, ...] = ()
    sliding: tuple[int, ...] = ()

    @property
    def axes(self) -> int:
        """Return the number of joints that can be moved by themselves."""
        return len(self.joints)


def arm_scene(name: str, arm: Arm, color: Color) -> str:
    """Return the text of a scene file that holds the arm: links `base_link`, `link_1` and so on, and `flange`."""
    count = len(arm.joints)
    points = np.array([(0.0, 0.0, 0.0), *(joint[:3] for joint in arm.joints), arm.flange[:3]]) / 1000.0
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    radii = THICKNESS * lengths.sum() * np.linspace(1.0, 0.5, count)
    links = [f"{name}.{link}" for link in ("base_link", *(f"link_{i + 1}" for i in range(count)), "flange")]
    nodes: list[dict] = [{"name": name, "robot": _robot(arm, links, lengths, radii)}]
    for i, link in enumerate(links):
        below = {"name": link, "parent": nodes[-1]["name"], "link": {"joint": _joint(arm, i)}}
        if 0 < i:
            below["parent_t_node"] = {"position": _vector(points[i] - points[i - 1])}
        if i > count:
            below["parent_t_node"]["orientation"] = _facing(arm.flange[3])
            below["figures"] = [_disc(radii[-1])]
        elif i:
            start = max(0.0, _foot_height(radii, points) - float(points[1, 2])) if i == 1 else 0.0
            below["figures"] = _bodies(arm.joints[i - 1], points[i + 1] - points[i], float(radii[i - 1]), color, start)
        else:
            below["figures"] = [_foot(float(radii[0]), _foot_height(radii, points))]
        nodes.append(below)
    return json.dumps({"schema_version": 1, "nodes": nodes})


def _robot(arm: Arm, links: list[str], lengths: np.ndarray, radii: np.ndarray) -> dict:
    zero = [min(max(0.0, joint[4]), joint[5]) for joint in arm.joints]
    postures = {"zero": zero} | ({"home": arm.home} if arm.home else {})
    short = [link.rpartition(".")[2] for link in links]
    widths = np.array([1.3 * radii[0], *radii, radii[-1]])
    allowed = [
        {"first": short[i], "second": short[j], "reason": "Adjacent" if j == i + 1 else "Drawn into each other"}
        for i, j in combinations(range(len(links)), 2)
        if j == i + 1 or lengths[i + 1 : j].sum() < 1.5 * (widths[i] + widths[j])
    ]
    named = [
        {"name": name, "joint_positions": {f"joint_{i + 1}": _si(arm, i, at) for i, at in enumerate(posture)}}
        for name, posture in postures.items()
    ]
    return {"flange": links[-1], "postures": named, "allowed_collisions": allowed}


def _joint(arm: Arm, link: int) -> dict:
    """Return the joint above a link: fixed for base and flange."""
    if not 0 < link <= len(arm.joints):
        return {"name": "to_flange" if link else "base", "type": "JOINT_TYPE_FIXED"}
    *_, direction, lower, upper, speed = arm.joints[link - 1]
    slides = link in arm.sliding
    limits = zip(("lower", "upper", "velocity"), (lower, upper, speed), strict=True)
    return {
        "name": f"joint_{link}",
        "type": "JOINT_TYPE_PRISMATIC" if slides else "JOINT_TYPE_REVOLUTE",
        "axis": _vector(_unit(direction)),
        "limits": {key: _si(arm, link - 1, value) for key, value in limits},
    }


def _si(arm: Arm, joint: int, value: float) -> float:
    return value / 1000.0 if joint + 1 in arm.sliding else float(np.radians(value))


def _bodies(joint: Axis, beyond: np.ndarray, radius: float, color: Color, clear: float) -> list[dict]:
    """Return the figures of a link: a rod along its own axis, or a housing there, and a rod across to the next one.

    The rod along the axis begins `clear` meters from the joint, so that it does not turn on what the arm stands on.
    """
    axis = _unit(joint[3])
    along = (beyond @ axis) * axis
    across = beyond - along
    length = float(np.linalg.norm(along))
    first = along * (min(clear, 0.5 * length) / length) if length > 1e-6 else along
    rods = [(start, rod) for start, rod in ((first, along - first), (along, across)) if np.linalg.norm(rod) > 1e-6]
    figures = []
    for start, rod in rods:
        placed = {"position": _vector(start + rod / 2.0), "orientation": _along(rod)}
        figures.append({**cylinder(0.8 * radius, float(np.linalg.norm(rod)), color), "node_t_figure": placed})
    if len(rods) == 2:
        figures.append(
            {
                **material(color),
                "sphere": {"radius_meters": 0.8 * radius},
                "node_t_figure": {"position": _vector(along)},
            }
        )
    elif not along.any():
        figures.append({**cylinder(radius, 2.2 * radius, METAL), "node_t_figure": {"orientation": _along(axis)}})
    return figures


def _foot_height(radii: np.ndarray, points: np.ndarray) -> float:
    return float(max(points[1, 2], 0.2 * radii[0]))


def _foot(radius: float, height: float) -> dict:
    return {**cylinder(1.3 * radius, height, METAL), "node_t_figure": {"position": {"z": height / 2.0}}}


def _disc(radius: float) -> dict:
    return {**cylinder(float(radius), 0.2 * float(radius), METAL), "node_t_figure": {"position": {"z": -0.1 * radius}}}


def cylinder(radius: float, length: float, color: Color) -> dict:
    """Return a figure: a cylinder about z (m) in this colour."""
    return {"cylinder": {"radius_meters": radius, "length_meters": length}, **material(color)}


def material(color: Color) -> dict:
    """Return the part of a figure that says its colour."""
    return {"material": {"color": dict(zip(("red", "green", "blue"), color, strict=True))}}


def _unit(direction: Direction) -> np.ndarray:
    unit = np.zeros(3)
    unit["xyz".index(direction[-1])] = -1.0 if direction[0] == "-" else 1.0
    return unit


def _facing(direction: Direction) -> dict:
    """Return the orientation of a flange: z out of it, by the one turn about x or y that brings z there."""
    if direction[-1] == "z":
        return {"x": 1.0} if direction == "-z" else {"w": 1.0}
    sign = {"x": 1.0, "-x": -1.0, "y": -1.0, "-y": 1.0}[direction]
    return {"y" if direction[-1] == "x" else "x": sign * np.sin(_HALF_TURN / 2), "w": np.cos(_HALF_TURN / 2)}


def _along(direction: np.ndarray) -> dict:
    """Return an orientation (unit quaternion) whose z points along `direction`, of any length but 0."""
    x, y, z = direction / np.linalg.norm(direction)
    if z < -0.999999:
        return {"x": 1.0}
    turn = np.array([-y, x, 0.0, 1.0 + z])  # half way between z and the direction
    return dict(zip("xyzw", (turn / np.linalg.norm(turn)).tolist(), strict=True))


def _vector(values: np.ndarray) -> dict:
    return dict(zip("xyz", np.round(values, 9).tolist(), strict=True))
