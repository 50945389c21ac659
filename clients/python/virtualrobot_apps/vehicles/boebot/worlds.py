"""Worlds of the Boe-Bot as scene files: a floor with a line, and a maze of walls.

`python -m virtualrobot_apps.vehicles.boebot.worlds FOLDER` writes the two that come with the package.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from virtualrobot_apps.vehicles.boebot.maze import Maze, generated
from virtualrobot_apps.vehicles.boebot.track import WIDTH, Track

ROBOT = "boebot"
CAN_RADIUS, CAN_HEIGHT = 0.033, 0.115
"""Of a can of 0.33 l (m)."""
WALL = 0.5
"""Height and thickness of the maze's walls (m): those of the document."""
FLOOR = "#d6dce0"
BENDING = math.radians(10.0)
"""Angle by which the line turns within one of its boxes, at most (rad)."""

Document = dict[str, Any]


class _Line(dict[str, Any]):
    """A mapping that is written on one line."""


yaml.SafeDumper.add_representer(
    _Line, lambda dumper, line: dumper.represent_mapping("tag:yaml.org,2002:map", line, True)
)


def line_world(track: Track, can_way: float | None = None, start_way: float = 0.0) -> str:
    """Return the scene file of a floor with a black line, the robot on it, and a can on it where `can_way` (m) says."""
    low, high = track.places.min(axis=0) - 0.5, track.places.max(axis=0) + 0.5
    center, size = 0.5 * (low + high), high - low
    nodes = [
        _object("floor", [_box((*size, 0.02), (*center, -0.01), FLOOR)]),
        _object("line", [_line_box(track, first, last) for first, last in _stretches(track)]),
    ]
    if can_way is not None:
        x, y, _ = track.pose(can_way)
        can = _Line({"cylinder": {"radius_meters": CAN_RADIUS, "length_meters": CAN_HEIGHT}, **_material("#2a7a3a")})
        nodes.append(
            {
                "name": "can",
                "parent_t_node": {"position": _vector(x, y, 0.5 * CAN_HEIGHT)},
                "figures": [can],
                "part": {"mass_kilograms": 0.35},
            }
        )
    return _text("A black line to follow, and a can on it.", [*nodes, _daylight()], track.pose(start_way))


def maze_world(maze: Maze) -> str:
    """Return the scene file of a maze, the robot in its first square."""
    rows, columns = maze.walls.shape
    size = WALL * np.array([columns, rows])
    walls = [
        _box(
            (WALL * (right - left), WALL * (top - bottom), WALL),
            (WALL * 0.5 * (left + right), WALL * 0.5 * (bottom + top), 0.5 * WALL),
            "#b98d62",
        )
        for bottom, top, left, right in maze.blocks()
    ]
    floor = _box((*(size + 1.0), 0.02), (*(0.5 * size), -0.01), FLOOR)
    nodes = [_object("floor", [floor]), _object("walls", walls), _daylight()]
    x, y = center_of(maze.start)
    title = f"A maze of {maze.size} x {maze.size} cells, seed {maze.seed}: each square of its map is {WALL:g} m."
    return _text(title, nodes, (x, y, 0.0))


def center_of(square: Sequence[int]) -> tuple[float, float]:
    """Return the middle (m) of a square (row, column) of a maze's map."""
    return WALL * (square[1] + 0.5), WALL * (square[0] + 0.5)


def _text(title: str, nodes: Sequence[Document], pose: tuple[float, float, float]) -> str:
    x, y, heading = pose
    turned = {"z": round(math.sin(0.5 * heading), 9), "w": round(math.cos(0.5 * heading), 9)}
    robot = {
        "uri": f"model://{ROBOT}",
        "name": ROBOT,
        "base_joint": "JOINT_TYPE_PLANAR",
        "parent_t_node": {"position": _vector(x, y), "orientation": turned},
    }
    # A robot that touches something stops; the floor, on which it stands, is nothing to stop for.
    standing = [f"{ROBOT}.{part}" for part in ("base", "left_wheel", "right_wheel")]
    document = {
        "schema_version": 1,
        "nodes": list(nodes),
        "models": [robot],
        "allowed_pairs": [_Line({"first": "floor", "second": part, "reason": "it stands there"}) for part in standing],
        "collision_settings": {"mode": "COLLISION_MODE_STOP"},
    }
    return f"# {title}\n" + yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=1000)


def _stretches(track: Track) -> list[tuple[int, int]]:
    """Return first and last place of stretches that are straight, but for BENDING."""
    found, first = [], 0
    bends = np.abs(np.diff(track.headings)) > 1e-9
    for last in range(1, len(track.places)):
        end = last == len(track.places) - 1
        turned = abs(track.headings[min(last + 1, len(track.headings) - 1)] - track.headings[first])
        if end or bends[last] != bends[last - 1] or turned > BENDING + 1e-9:
            found.append((first, last))
            first = last
    return found


def _line_box(track: Track, first: int, last: int) -> Document:
    begin, end = track.places[first], track.places[last]
    angle = math.atan2(end[1] - begin[1], end[0] - begin[0])
    # Boxes of a bend overlap, so that its outer side has no gaps.
    length = float(np.linalg.norm(end - begin)) + WIDTH * math.tan(0.5 * BENDING)
    box = _box((length, WIDTH, 0.0006), (*(0.5 * (begin + end)), 0.0003), "#0c0c0c")
    box["node_t_figure"]["orientation"] = {"z": round(math.sin(0.5 * angle), 9), "w": round(math.cos(0.5 * angle), 9)}
    box["roles"] = ["FIGURE_ROLE_VISUAL"]
    return box


def _object(name: str, figures: Sequence[Document]) -> Document:
    return {"name": name, "figures": list(figures), "object": {}}


def _daylight() -> Document:
    """Return light from above; without shadows, as of a hall with many lamps."""
    down = {"orientation": {"x": 1.0, "w": 0.0}, "position": _vector(0.0, 0.0, 3.0)}
    light = {"kind": "LIGHT_KIND_DIRECTIONAL", "intensity": 0.75, "shadowless": True}
    return {"name": "daylight", "parent_t_node": down, "light": light}


def _box(size: Sequence[float], place: Sequence[float], color: str) -> Document:
    return _Line({"node_t_figure": {"position": _vector(*place)}, "box": {"size": _vector(*size)}, **_material(color)})


def _material(color: str) -> Document:
    red, green, blue = (round(int(color[at : at + 2], 16) / 255.0, 3) for at in (1, 3, 5))
    return {"material": {"color": {"red": red, "green": green, "blue": blue}}}


def _vector(x: float, y: float, z: float = 0.0) -> Mapping[str, float]:
    return {axis: round(float(value), 6) for axis, value in zip("xyz", (x, y, z), strict=True)}


BUNDLED = {
    "line.yaml": lambda: line_world(Track.of(), can_way=2.7),
    "maze.yaml": lambda: maze_world(generated(4, seed=1)),
}
"""The files of the package, and what makes them."""


if __name__ == "__main__":
    for name, made in BUNDLED.items():
        Path(sys.argv[1], name).write_text(made(), "utf-8")
