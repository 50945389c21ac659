"""Scene trees and joint tables as text and HTML, for terminals and notebooks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from virtualrobot._wire.showing import table_html
from virtualrobot.robots.values import RobotState
from virtualrobot.v1 import nodes_pb2

if TYPE_CHECKING:
    from virtualrobot.robots.robot import Robot

_UNITS = {
    "revolute": "rad, rad/s",
    "continuous": "rad, rad/s",
    "prismatic": "m, m/s",
    "planar": "m, rad and a second",
    "floating": "m, quaternion; m/s, rad/s",
}
_COUNTS = {"planar": (3, 3), "floating": (7, 6)}
"""Coordinates and velocities of joints that have more than one."""


def scene_tree(nodes: Sequence[nodes_pb2.Node], links: bool = True) -> str:
    """Return the scene as a drawn tree, a line for each node with its kind.

    Without `links` what hangs there is shown at the robot.
    """
    parent_of = {node.name: node.parent for node in nodes}
    kind_of = {node.name: node.WhichOneof("kind") or "node" for node in nodes}
    shown = [node for node in nodes if links or kind_of[node.name] != "link"]
    children: dict[str, list[nodes_pb2.Node]] = {}
    for node in shown:
        parent = node.parent
        while not links and kind_of.get(parent) == "link":
            parent = parent_of[parent]
        # A node whose parent was not asked for stands at the top.
        children.setdefault(parent if parent in kind_of and parent != node.name else "", []).append(node)

    lines: list[str] = []
    stack = [(node, "", "") for node in reversed(children.get("", []))]
    while stack:
        node, lead, indent = stack.pop()
        hidden = ", hidden" if node.hidden else ""
        lines.append(f"{lead}{node.name} ({kind_of[node.name]}{hidden})")
        below = children.get(node.name, [])
        for number, child in reversed(list(enumerate(below))):
            last = number == len(below) - 1
            stack.append((child, indent + ("└─ " if last else "├─ "), indent + ("   " if last else "│  ")))
    return "\n".join(lines)


def aligned(rows: Sequence[Sequence[str]], left: int = 1) -> list[str]:
    """Return rows as lines with aligned columns: the first `left` columns (names) to the left, the others to the right.

    All rows have as many cells.
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            cell.ljust(width) if place < left else cell.rjust(width)
            for place, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def joint_rows(robot: Robot, state: RobotState, degrees: bool = False) -> list[list[str]]:
    """Return for each joint its name, position, velocity and limits as text, after a row of headings.

    Radians and meters; with `degrees` the values of joints that only turn are in degrees.
    """
    rows = [["joint", "position", "velocity", "lower", "upper"]]
    position, velocity, limits = 0, 0, robot.limits
    for name, kind in robot.joint_types.items():
        unit = 180.0 / math.pi if degrees and kind in ("revolute", "continuous") else 1.0
        coordinates, velocities = _COUNTS.get(kind, (1, 1))
        here = state.positions[position : position + coordinates]
        speed = state.velocities[velocity : velocity + velocities]
        columns = ([*here], [*speed], [limits[name].lower], [limits[name].upper])
        rows.append([name, *(" ".join(f"{unit * value:z.4f}" for value in column) for column in columns)])
        position, velocity = position + coordinates, velocity + velocities
    return rows


def joint_table_html(robot: Robot) -> str:
    """Return a robot's joints as an HTML table, with their units."""
    head, *rows = joint_rows(robot, robot.state)
    units = [_UNITS[kind] for kind in robot.joint_types.values()]
    table = [[*head, "units"], *([*row, unit] for row, unit in zip(rows, units, strict=True))]
    return table_html(robot.name, table)
