"""Grippers without a model file: jaws that slide by one motor, and cups or magnets on a plate.

The mounting surface is the xy plane and z looks to the parts. Jaws open along y. The bodies are boxes and cylinders of
about the right size and stand for no measured shape.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Annotated

import msgspec

from virtualrobot_plugins.models.arms import METAL, Color, cylinder, material

Size = Annotated[float, msgspec.Meta(gt=0.0)]
Box = tuple[Size, Size, Size]
STEEL: Color = (0.75, 0.76, 0.78)


@dataclass(frozen=True, slots=True)
class Jaws:
    """Two fingers that one motor opens and closes by equal ways; the right one follows the left one.

    Attributes:
        body: extents of the body (mm).
        finger: extents of a finger (mm), which stands on the body.
        stroke: the distance between the fingers when open (mm).
        speed: greatest speed of a finger (mm/s).
        force: greatest force of a finger (N).
        mass: of the whole gripper (kg).
        tcp: height of the tool centre point above the mounting surface (mm).
    """

    body: Box
    finger: Box
    stroke: Size
    speed: Size
    force: Size
    mass: Size
    tcp: Size

    @property
    def axes(self) -> int:
        """Return the number of joints that can be moved by themselves."""
        return 1


@dataclass(frozen=True, slots=True)
class Cups:
    """Suction cups or magnets on a plate: a tool without joints, that is on or off.

    Attributes:
        plate: extents of the body (mm).
        cups: x, y and radius of each cup (mm).
        height: of the cups (mm): parts touch at the end of the plate and the cups.
        mass: of the whole tool (kg).
    """

    plate: Box
    cups: Annotated[list[tuple[float, float, Size]], msgspec.Meta(min_length=1)]
    height: Size
    mass: Size

    @property
    def axes(self) -> int:
        """Return the number of joints that can be moved by themselves."""
        return 0


def jaws_scene(name: str, jaws: Jaws, color: Color) -> str:
    """Return the text of a scene file that holds the gripper, and at its body a tool that opens and closes."""
    half, (_, width, height) = jaws.stroke / 2000.0, jaws.finger
    finger = jaws.mass * 0.1
    body, left, right = (f"{name}.{link}" for link in ("body", "left_finger", "right_finger"))
    place = {"z": jaws.body[2] / 2000.0}
    limits = {"lower": 0.0, "upper": half, "velocity": jaws.speed / 1000.0, "effort": jaws.force}
    pair = {"first": "left_finger", "second": "right_finger", "reason": "the fingers close on each other"}
    states = {"open": half, "closed": 0.0}
    nodes = [
        {
            "name": name,
            "robot": {
                "flange": body,
                "allowed_collisions": [pair],
                "postures": [{"name": key, "joint_positions": {"finger": at}} for key, at in states.items()],
            },
        },
        {
            "name": body,
            "parent": name,
            "figures": [_box(jaws.body, color, place)],
            "link": {
                "joint": {"name": "base", "type": "JOINT_TYPE_FIXED"},
                "inertial": _block(jaws.body, 0.8 * jaws.mass),
            },
        },
    ]
    for link, sign in ((left, 1.0), (right, -1.0)):
        joint = {"name": "finger", "type": "JOINT_TYPE_PRISMATIC", "axis": {"y": sign}, "limits": limits}
        if link == right:
            joint |= {"name": "right_finger", "mimic": {"joint": "finger"}}
        middle = {"y": sign * width / 2000.0, "z": height / 2000.0}
        nodes.append(
            {
                "name": link,
                "parent": body,
                "parent_t_node": {"position": {"z": jaws.body[2] / 1000.0}},
                "figures": [_box(jaws.finger, STEEL, middle)],
                "link": {"joint": joint, "inertial": _block(jaws.finger, finger, middle)},
            }
        )
    points = [{"name": "tcp", "tool_t_tcp": {"position": {"z": jaws.tcp / 1000.0}}}]
    tool = {
        "tool_center_points": points,
        "states": [{"name": key, "joint_positions": {"finger": at}} for key, at in states.items()],
        "widths": [{"width_meters": 2.0 * at, "joint_positions": {"finger": at}} for at in sorted(states.values())],
    }
    nodes.append({"name": f"{name}.tool", "parent": body, "tool": tool})
    return json.dumps({"schema_version": 1, "nodes": nodes})


def cups_scene(name: str, cups: Cups, color: Color) -> str:
    """Return the text of a scene file that holds the tool, with the states off and on and a point for each cup."""
    top, end = cups.plate[2] / 1000.0, (cups.plate[2] + cups.height) / 1000.0
    figures = [_box(cups.plate, color, {"z": top / 2.0})]
    points = [{"name": "tcp", "tool_t_tcp": {"position": {"z": end}}}]
    for i, (x, y, radius) in enumerate(cups.cups):
        at = {"x": x / 1000.0, "y": y / 1000.0}
        figure = cylinder(radius / 1000.0, end - top, METAL)
        figures.append({**figure, "node_t_figure": {"position": {**at, "z": (top + end) / 2.0}}})
        if len(cups.cups) > 1:
            points.append({"name": f"cup_{i + 1}", "tool_t_tcp": {"position": {**at, "z": end}}})
    tool = {
        "tool_center_points": points,
        "states": [{"name": "off"}, {"name": "on"}],
        "inertial": _block(cups.plate, cups.mass, {"z": top / 2.0}),
    }
    return json.dumps({"schema_version": 1, "nodes": [{"name": name, "figures": figures, "tool": tool}]})


def _box(size: Box, color: Color, place: dict) -> dict:
    return {
        **material(color),
        "node_t_figure": {"position": place},
        "box": {"size": {axis: extent / 1000.0 for axis, extent in zip("xyz", size, strict=True)}},
    }


def _block(size: Box, mass: float, place: dict | None = None) -> dict:
    """Return the mass of a block of even density, its middle at `place`; of none above the mounting surface."""
    x, y, z = (extent / 1000.0 for extent in size)
    moments = {"x": y * y + z * z, "y": x * x + z * z, "z": x * x + y * y}
    return {
        "mass_kilograms": mass,
        "link_t_inertial": {"position": place or {"z": z / 2.0}},
        "diagonal": {axis: mass * squares / 12.0 for axis, squares in moments.items()},
    }
