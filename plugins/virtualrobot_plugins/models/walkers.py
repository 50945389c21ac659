"""Walking machines without a model file: a body, and legs as robots of their own that are attached to it.

A leg is a Denavit-Hartenberg table (standard), its last frame the middle of a ball that is the foot. The bodies are
capsules along the links and stand for no measured shape.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import msgspec
import numpy as np

from virtualrobot_plugins.models.arms import METAL, Color, material
from virtualrobot_plugins.models.grippers import Box, Size

RADIUS = 0.011
"""Radius (m) of a link's capsule."""
SHANK = 0.007
"""Greatest radius (m) of the last link's capsule; it is thinner than the foot, which touches the ground before it."""
HIP = 0.018
"""Radius (m) of the ball that a leg begins with."""
RUBBER: Color = (0.1, 0.1, 0.11)


@dataclass(frozen=True, slots=True)
class Row:
    """Row of a leg's table, and the link that its joint moves.

    Attributes:
        name: of the joint and the link.
        a: length (mm).
        alpha: twist (degrees).
        d: offset (mm).
        lower: least position (degrees).
        upper: greatest position (degrees).
        speed: greatest speed (degrees/s).
        torque: greatest torque (N m).
        mass: of the link (kg), spread along it.
    """

    name: Annotated[str, msgspec.Meta(min_length=1)]
    a: float
    lower: float
    upper: float
    speed: Size
    torque: Size
    mass: Size
    alpha: float = 0.0
    d: float = 0.0


@dataclass(frozen=True, slots=True)
class Walker:
    """Geometry of a walking machine whose legs are all alike.

    Attributes:
        body: extents of the body (mm), its frame in the middle, x forward.
        mass: of the body (kg).
        hips: x, y (mm) and direction outward (degrees from x to the left) of each leg's first axis, by the leg's name.
        rows: the table of a leg.
        foot: radius of the ball (mm).
        home: the posture `home` of a leg (degrees).
    """

    body: Box
    mass: Size
    hips: Mapping[str, tuple[float, float, float]]
    rows: Annotated[list[Row], msgspec.Meta(min_length=1)]
    foot: Size
    home: tuple[float, ...]

    @property
    def axes(self) -> int:
        """Return the number of joints of all legs."""
        return len(self.hips) * len(self.rows)


def walker_scene(name: str, walker: Walker, color: Color) -> str:
    """Return the text of a scene file that holds body and legs: robots `body`, `body.left_front` and so on."""
    body = f"{name}.body"
    x, y, z = (extent / 1000.0 for extent in walker.body)
    squares = {"x": y * y + z * z, "y": x * x + z * z, "z": x * x + y * y}
    inertial = {
        "mass_kilograms": walker.mass,
        "diagonal": {axis: walker.mass * square / 12.0 for axis, square in squares.items()},
    }
    figures: list[dict] = [{"box": {"size": {"x": x, "y": y, "z": z}}, **material(color)}]
    figures += [_capsule(np.zeros(3), _place(hip), color, 0.8, seen_only=True) for hip in walker.hips.values()]
    base = {"joint": {"name": "base", "type": "JOINT_TYPE_FIXED"}}
    nodes: list[dict] = [
        {"name": name, "robot": {"flange": body}},
        {"name": body, "parent": name, "figures": figures, "link": {**base, "inertial": inertial}},
    ]
    for leg, hip in walker.hips.items():
        nodes += _leg(f"{name}.{leg}", body, hip, walker, color)
    return json.dumps({"schema_version": 1, "nodes": nodes})


def _leg(name: str, body: str, hip: tuple[float, float, float], walker: Walker, color: Color) -> list[dict]:
    """Return the nodes of a leg: a robot on the body, the links of its rows, and the foot."""
    links = [f"{name}.{link}" for link in ("hip", *(row.name for row in walker.rows), "foot")]
    half = np.radians(hip[2]) / 2.0
    outward = {"position": _vector(_place(hip)), "orientation": {"z": np.sin(half), "w": np.cos(half)}}
    postures = [
        {"name": key, "joint_positions": {row.name: at for row, at in zip(walker.rows, posture, strict=True)}}
        for key, posture in {"home": np.radians(walker.home).tolist()}.items()
    ]
    short = [link.rpartition(".")[2] for link in links]
    # Hip and femur: the coxa is short.
    pairs = [(0, 2), *((i, i + 1) for i in range(len(links) - 1))]
    allowed = [{"first": short[i], "second": short[j], "reason": "Drawn into each other"} for i, j in pairs]
    ball = {"sphere": {"radius_meters": HIP}, **material(METAL)}
    fixed = {"joint": {"name": "base", "type": "JOINT_TYPE_FIXED"}}
    nodes: list[dict] = [
        {
            "name": name,
            "parent": body,
            "parent_t_node": outward,
            "robot": {"flange": links[-1], "postures": postures, "allowed_collisions": allowed},
        },
        {"name": links[0], "parent": name, "figures": [ball], "link": fixed},
    ]
    before = {"position": {}}
    for row, link in zip(walker.rows, links[1:], strict=False):
        end = np.array([row.a, 0.0, row.d]) / 1000.0
        last = row is walker.rows[-1]
        radius = min(SHANK, 0.875 * walker.foot / 1000.0) if last else RADIUS
        limits = {
            "lower": np.radians(row.lower),
            "upper": np.radians(row.upper),
            "velocity": np.radians(row.speed),
            "effort": row.torque,
        }
        joint = {"name": row.name, "type": "JOINT_TYPE_REVOLUTE", "axis": {"z": 1.0}, "limits": limits}
        nodes.append(
            {
                "name": link,
                "parent": nodes[-1]["name"],
                "parent_t_node": before,
                "figures": [_capsule(np.zeros(3), end, METAL if last else color, radius=radius)],
                "link": {"joint": joint, "inertial": _rod(end, row.mass, radius)},
            }
        )
        half = np.radians(row.alpha) / 2.0
        before = {"position": _vector(end), "orientation": {"x": np.sin(half), "w": np.cos(half)}}
    sole = {"sphere": {"radius_meters": walker.foot / 1000.0}, **material(RUBBER)}
    sole["material"]["friction"] = 0.8
    joint = {"name": "foot", "type": "JOINT_TYPE_FIXED"}
    nodes.append(
        {
            "name": links[-1],
            "parent": nodes[-1]["name"],
            "parent_t_node": before,
            "figures": [sole],
            "link": {"joint": joint},
        }
    )
    return nodes


def _capsule(
    start: np.ndarray,
    end: np.ndarray,
    color: Color,
    part: float = 1.0,
    seen_only: bool = False,
    radius: float = RADIUS,
) -> dict:
    """Return a capsule from one point to another, in the first `part` of the way between them."""
    way = (end - start) * part
    length = float(np.linalg.norm(way))
    x, y, z = way / length
    turn = np.array([-y, x, 0.0, 1.0 + z])  # half way between z and the direction
    placed = {
        "position": _vector(start + way / 2.0),
        "orientation": dict(zip("xyzw", (turn / np.linalg.norm(turn)).tolist(), strict=True)),
    }
    # It ends before the joint, so that neighbours of neighbours are clear of each other.
    shape = {"capsule": {"radius_meters": radius, "length_meters": max(length - radius, 1e-3)}}
    figure = {"node_t_figure": placed, **shape, **material(color)}
    return {**figure, "roles": ["FIGURE_ROLE_VISUAL"]} if seen_only else figure


def _rod(end: np.ndarray, mass: float, radius: float) -> dict:
    """Return mass and moments of inertia of a rod from the origin to `end` (along x, or x and z)."""
    length = float(np.linalg.norm(end))
    along, across = mass * radius**2 / 2.0, mass * (radius**2 / 4.0 + length**2 / 12.0)
    direction = end / length
    moments = across * np.eye(3) + (along - across) * np.outer(direction, direction)
    return {
        "mass_kilograms": mass,
        "link_t_inertial": {"position": _vector(end / 2.0)},
        "diagonal": dict(zip("xyz", np.diag(moments).tolist(), strict=True)),
        "products": {"x": float(moments[0, 1]), "y": float(moments[0, 2]), "z": float(moments[1, 2])},
    }


def _place(hip: tuple[float, float, float]) -> np.ndarray:
    return np.array([hip[0], hip[1], 0.0]) / 1000.0


def _vector(values: np.ndarray) -> dict:
    return dict(zip("xyz", np.round(values, 9).tolist(), strict=True))
