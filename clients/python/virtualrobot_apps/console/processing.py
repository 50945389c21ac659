"""Processes for pages: their files as texts, edges that were clicked, a look along their ways, and their plans."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError, VirtualRobotError

from virtualrobot_apps.cell_io.yaml_file import Item, parse
from virtualrobot_apps.cell_io.yaml_text import with_item, with_value
from virtualrobot_apps.console.numbers import numbers
from virtualrobot_apps.processes.command import EXAMPLES
from virtualrobot_apps.processes.process import check_packages, known, look_file, plan_file

NAME = "process.yaml"
"""Name of a text that has none."""
FIELDS = {
    "speed": ("speed",),
    "rotation": ("tolerance", "rotation"),
    "work": ("tolerance", "work_degrees"),
    "travel": ("tolerance", "travel_degrees"),
}
"""Fields that pages change by themselves: speed in m/s, and how far the tool may turn and lean, in degrees."""
_FILES = ("gcode", "file")
_BODIES = ("part", "object")
_NO_EDGES = ("spots", "gcode")
_MOST_LETTERS = 2_000_000

Said = Mapping[str, Any]


def names() -> list[str]:
    """Return the names of processes that there are."""
    return known()


def new(said: Said) -> dict[str, Any]:
    """Return an example of a process for a robot; of a process of somebody else that has none its first lines."""
    process, robot = _text(said, "process"), _text(said, "robot")
    if process not in known():
        raise InvalidArgumentError(f"{process!r} is no process; there are {', '.join(known())}")
    file = EXAMPLES / f"{process}.yaml"
    text = file.read_text("utf-8") if file.is_file() else f"schema_version: 1\nprocess: {process}\n"
    return read({"text": with_value(text, ["robot"], robot) if robot else text})


def read(said: Said) -> dict[str, Any]:
    """Return a text, its process, and its fields as far as it has them; raises MalformedFileError for no such file."""
    text = _text(said, "text")
    item = parse(text, _text(said, "name") or NAME)
    return {
        "text": text,
        "process": _said(item, ("process",)),
        **{name: _said(item, at) for name, at in FIELDS.items()},
    }


def change(said: Said) -> dict[str, Any]:
    """Return a text in which one of its fields has another value: a number, or `free`."""
    field, value = _text(said, "field"), said.get("value")
    if field not in FIELDS:
        raise InvalidArgumentError(f"a field is one of {', '.join(FIELDS)}, not {field!r}")
    if value != "free":
        (number,) = numbers([value], field, 1)
        value = f"{number:.6g}"
    return read({**said, "text": with_value(_text(said, "text"), FIELDS[field], value)})


def edge(client: Client, said: Said) -> dict[str, Any]:
    """Return a text that goes along the edge of a part nearest to a point of a node, and the points of that edge.

    The part is the outermost object above the node, so that bodies which hang together are joined. `add` has it go
    along that edge, too; else it goes along that one alone.
    """
    check_packages()
    from virtualrobot_apps.processes.part import part_mesh
    from virtualrobot_apps.processes.sources.edges import KINDS, edges, nearest

    part = _outermost(client, _text(said, "node"))
    world_t_part = client.scene[part].pose
    world_t_node = client.scene[_text(said, "node")].pose
    point = (np.linalg.inv(world_t_part) @ world_t_node @ [*numbers(said.get("point"), "point", 3), 1.0])[:3]
    mesh = part_mesh(client, [part])
    found = {one: kind for kind in KINDS for one in edges(mesh, kind)}
    if not found:
        raise InvalidArgumentError(f"{part!r} has no edge: its faces go over into each other")
    way = nearest(list(found), point)
    middle = way.points[len(way.points) // 2] if len(way.points) > 2 else way.points.mean(axis=0)
    near = ", ".join(f"{one:.4g}" for one in (np.round(middle, 4) + 0.0).tolist())
    name = part if part.isidentifier() else f'"{part}"'
    text = _text(said, "text")
    source = f"{{part: {name}, edge: {found[way]}, near: [{near}]}}"
    text = with_item(text, [_field_of_ways(parse(text, NAME))], source, add=bool(said.get("add")), file=NAME)
    points = way.points @ world_t_part[:3, :3].T + world_t_part[:3, 3]
    told = f"{found[way]} edge of {part}, {1e3 * way.length:.1f} mm"
    return {**read({"text": text}), "told": told, "points": points.tolist()}


def look(client: Client, said: Said) -> list[dict[str, Any]]:
    """Return how it is along the ways of a process, as `virtualrobot process look` tells."""
    with _file_of(said) as file:
        return [
            {
                "name": one.name,
                "points": one.points.tolist(),
                "at": one.at.tolist(),
                "states": one.states,
                "lines": one.lines(),
            }
            for one in look_file(client, file)
        ]


def plan(client: Client, said: Said) -> dict[str, Any]:
    """Return what a process comes to, as `virtualrobot process plan` tells, and its program as a text."""
    with _file_of(said) as file:
        made = plan_file(client, file)
        found = made.program.check()
    fault = "" if found.first_violation is None else found.first_violation.message
    return {"measures": made.measures, "fault": fault, "seconds": found.duration, "program": made.program.text}


@contextmanager
def _file_of(said: Said) -> Iterator[Path]:
    """Give the file of a text, with the files that came with it beside; errors are told without their folder."""
    name, files = _text(said, "name") or NAME, said.get("files") or {}
    texts = {**files, name: _text(said, "text")} if isinstance(files, dict) else {}
    if not texts or not all(isinstance(text, str) for text in texts.values()):
        raise InvalidArgumentError("'files' are texts by their names")
    for one in texts:
        if not one or os.path.basename(one) != one or one in (".", ".."):
            raise InvalidArgumentError(f"{one!r} is no name of a file: it has no folder")
    if sum(map(len, texts.values())) > _MOST_LETTERS:
        raise InvalidArgumentError(f"these files have more than {_MOST_LETTERS} letters together")
    _check_files(parse(texts[name], name), texts)
    with TemporaryDirectory(prefix="virtualrobot-process-") as folder:
        for one, text in texts.items():
            Path(folder, one).write_text(text, "utf-8")
        try:
            yield Path(folder, name)
        except VirtualRobotError as error:
            here = f"{folder}{os.sep}"
            metadata = {key: value.replace(here, "") for key, value in error.metadata.items()}
            raise type(error)(error.message.replace(here, ""), error.reason, metadata, error.code) from None


def _check_files(item: Item, texts: Mapping[str, str]) -> None:
    """Raise MalformedFileError where a text names a file that has not come with it: none of this machine is read."""
    if item.is_list:
        for one in item.items():
            _check_files(one, texts)
    elif item.is_mapping:
        for name, one in item.mapping().items():
            if name in _FILES and not (one.is_list or one.is_mapping) and one.text() not in texts:
                raise one.error(f"{one.text()!r} has not come with it: open both files together")
            _check_files(one, texts)


def _field_of_ways(item: Item) -> str:
    """Return the field that has the ways of a process; raises InvalidArgumentError where they can't be edges."""
    for name, ways in item.mapping().items():
        if ways.is_list and all(one.is_mapping and "part" in one.mapping() for one in ways.items()):
            for one in ways.items():
                if other := [kind for kind in _NO_EDGES if kind in one.mapping()]:
                    raise InvalidArgumentError(
                        f"{name!r} are {other[0]} in this process, and no edges: write them into the text"
                    )
            return name
    raise InvalidArgumentError("this process has no list of ways, each with the `part` that it is of")


def _outermost(client: Client, node: str) -> str:
    """Return the outermost part or object that a node is below, or itself; raises InvalidArgumentError for others."""
    if client.scene[node].kind not in _BODIES:
        raise InvalidArgumentError(f"{node!r} is a {client.scene[node].kind}, and edges are those of parts and objects")
    found = node
    while True:
        parent = client.scene[found].parent
        if not parent or parent == "world" or client.scene[parent].kind not in _BODIES:
            return found
        found = parent


def _said(item: Item, path: tuple[str, ...]) -> str | float | None:
    """Return what a text says in one place; None where it says nothing there."""
    for name in path:
        if not item.is_mapping or name not in (fields := item.mapping()):
            return None
        item = fields[name]
    if item.is_list or item.is_mapping:
        return None
    value = item.scalar()
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else str(value)


def _text(said: Said, field: str) -> str:
    value = said.get(field, "")
    if not isinstance(value, str):
        raise InvalidArgumentError(f"{field!r} is a text, not {value!r:.60}")
    return value
