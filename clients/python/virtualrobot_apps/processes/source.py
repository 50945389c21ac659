"""Sources of ways as files describe them: edges, splines, sections and rasters of parts, G-code, CAD files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import trimesh
from virtualrobot import Client
from virtualrobot.errors import MissingFileError

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.fitting import ways as curve_ways
from virtualrobot_apps.curves.reading import read_curves
from virtualrobot_apps.curves.way import Floats, Way, units
from virtualrobot_apps.processes.part import part_mesh
from virtualrobot_apps.processes.sources.edges import KINDS, edges, nearest
from virtualrobot_apps.processes.sources.fairing import FAIR, fair
from virtualrobot_apps.processes.sources.gcode import read_gcode
from virtualrobot_apps.processes.sources.picked import spline
from virtualrobot_apps.processes.sources.raster import raster
from virtualrobot_apps.processes.sources.sampling import CHORD, STEP, sampled
from virtualrobot_apps.processes.sources.sections import section
from virtualrobot_apps.processes.sources.spots import shortest_order, spots

_SOURCES = ("edge", "points", "targets", "section", "raster", "gcode", "curves", "spots")
_FIELDS = ("part", *_SOURCES, "near", "normal", "reverse", "trim")
_NORMAL = ("points", "gcode", "curves")


@dataclass(frozen=True, slots=True)
class Cell:
    """Meshes and places of a cell, as sources ask for them.

    Attributes:
        mesh: the mesh (m) of parts, in the frame of the first one.
        pose: the pose (4, 4) of a target in the frame of a part.
    """

    mesh: Callable[[tuple[str, ...]], trimesh.Trimesh]
    pose: Callable[[str, str], Floats]


def cell_of(client: Client) -> Cell:
    """Return the cell of a client as it is now; each mesh is made once."""

    def mesh(parts: tuple[str, ...]) -> trimesh.Trimesh:
        return part_mesh(client, parts)

    def pose(target: str, part: str) -> Floats:
        return np.linalg.inv(client.scene[part].pose) @ client.scene.target(target).pose

    return Cell(cache(mesh), pose)


@dataclass(frozen=True, slots=True, eq=False)
class Density:
    """Density of ways: `chord` and `step` (m) as of `sampled`."""

    chord: float = CHORD
    step: float = STEP


Make = Callable[[Cell, Density], list[Way]]
"""The ways of a source, in the frame of its first part."""


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """Source of ways in a file.

    Attributes:
        item: where it stands.
        parts: the nodes that it is of; its ways are in the frame of the first one.
        make: its ways.
        near: (3,) a point (m) that the only way that is meant comes nearest to; None for all of them.
        reverse: goes the other way.
        trim: the lengths (m) that are left out at the beginning and at the end of each way.
    """

    item: Item
    parts: tuple[str, ...]
    make: Make
    near: Floats | None = None
    reverse: bool = False
    trim: tuple[float, float] = (0.0, 0.0)


def read_source(item: Item) -> Source:
    """Return what a file says of a source; raises MalformedFileError, with file and line, for what it says wrong."""
    fields = item.fields(_FIELDS, ("part",))
    part = fields["part"]
    parts = tuple(one.text() for one in part.items()) if part.is_list else (part.text(),)
    if not parts:
        raise part.error("the name of a part belongs here")
    given = [name for name in _SOURCES if name in fields]
    if len(given) > 1:
        raise fields[given[1]].error(f"one source belongs here, and {given[0]!r} is given, too")
    kind = given[0] if given else "edge"
    if "normal" in fields and kind not in _NORMAL:
        raise fields["normal"].error(f"the normal is of {', '.join(_NORMAL)}; {kind} has its own")
    if "near" in fields and kind in ("points", "targets"):
        raise fields["near"].error(f"near chooses one way of several, and {kind} are one")
    trim = tuple(one.number(0.0, 10.0) for one in fields["trim"].items()) if "trim" in fields else (0.0, 0.0)
    if len(trim) != 2:
        raise fields["trim"].error("two lengths in m belong here: at the beginning and at the end")
    near = vector(fields["near"]) if "near" in fields else None
    reverse = "reverse" in fields and fields["reverse"].boolean()
    return Source(item, parts, _READERS[kind](item, fields, parts), near, reverse, trim)


def ways_of(source: Source, cell: Cell, density: Density) -> list[Way]:
    """Return the ways of a source, as dense as asked.

    Raises MalformedFileError, with file and line, where there is no such edge, or more than one, and for a trim that
    leaves nothing; and what its source refuses.
    """
    found = source.make(cell, density)
    if source.near is not None:
        found = [nearest(found, source.near)]
    found = [sampled(way, density.chord, density.step) for way in found]
    if source.reverse:
        found = [way.reversed() for way in reversed(found)]
    return [_trimmed(source, way) if any(source.trim) else way for way in found]


def vector(item: Item) -> Floats:
    """Return three numbers."""
    values = [one.number() for one in item.items()]
    if len(values) != 3:
        raise item.error(f"three numbers belong here, not {len(values)}")
    return np.array(values)


def _edge(item: Item, fields: dict[str, Item], parts: tuple[str, ...]) -> Make:
    kind = fields["edge"].one_of(KINDS) if "edge" in fields else "concave"
    one = "near" not in fields

    def make(cell: Cell, _: Density) -> list[Way]:
        found = edges(cell.mesh(parts), kind)
        if not found:
            raise item.error(f"{_named(parts)} no {kind} edge")
        if one and len(found) > 1:
            told = "; ".join(f"{1e3 * way.length:.4g} mm from {_place(way.points[0])}" for way in found[:8])
            more = f" and {len(found) - 8} more" if len(found) > 8 else ""
            raise item.error(
                f"{_named(parts)} {len(found)} {kind} edges: say by `near: [x, y, z]` in m which one: {told}{more}"
            )
        return found

    return make


def _points(item: Item, fields: dict[str, Item], _: tuple[str, ...]) -> Make:
    if "normal" not in fields:
        raise item.error("a way through points needs the normal that the tool points against")
    points = np.array([vector(one) for one in fields["points"].items()]).reshape(-1, 3)
    normal = vector(fields["normal"])
    return lambda _, density: [spline(points, normal, chord=density.chord, step=density.step)]


def _targets(_: Item, fields: dict[str, Item], parts: tuple[str, ...]) -> Make:
    names = tuple(one.text() for one in fields["targets"].items())

    def make(cell: Cell, density: Density) -> list[Way]:
        poses = np.array([cell.pose(name, parts[0]) for name in names]).reshape(-1, 4, 4)
        return [spline(poses[:, :3, 3], -poses[:, :3, 2], chord=density.chord, step=density.step)]

    return make


def _spots(item: Item, fields: dict[str, Item], parts: tuple[str, ...]) -> Make:
    given = fields["spots"].fields(("points", "normal", "targets", "depth", "clear", "pecks", "order"))
    if ("points" in given) == ("targets" in given):
        raise item.error("spots are at `points` with a `normal`, or at `targets`")
    if ("normal" in given) != ("points" in given):
        raise fields["spots"].error("points have a `normal` that the tool points against; targets have their own")
    names = tuple(one.text() for one in given["targets"].items()) if "targets" in given else ()
    points = np.array([vector(one) for one in given["points"].items()]).reshape(-1, 3) if "points" in given else None
    normal = vector(given["normal"]) if "normal" in given else None
    lengths = {name: given[name].number(0.0, 1.0) for name in ("depth", "clear") if name in given}
    pecks = given["pecks"].whole(1, 100) if "pecks" in given else 1
    order = given["order"].one_of(("given", "shortest")) if "order" in given else "given"

    def make(cell: Cell, _: Density) -> list[Way]:
        if points is None or normal is None:
            poses = np.array([cell.pose(name, parts[0]) for name in names]).reshape(-1, 4, 4)
            places, normals = poses[:, :3, 3], -poses[:, :3, 2]
        else:
            places, normals = points, np.tile(normal, (len(points), 1))
        if order == "shortest" and len(places):
            rows = shortest_order(places)
            places, normals = places[rows], normals[rows]
        return spots(places, normals, pecks=pecks, **lengths)

    return make


def _section(_: Item, fields: dict[str, Item], parts: tuple[str, ...]) -> Make:
    plane = fields["section"].fields(("origin", "normal"), ("origin", "normal"))
    origin, normal = vector(plane["origin"]), vector(plane["normal"])

    def make(cell: Cell, density: Density) -> list[Way]:
        found = [sampled(way, density.chord, density.step) for way in section(cell.mesh(parts), origin, normal)]
        return [fair(way, FAIR * density.chord, density.step) for way in found]

    return make


def _raster(_: Item, fields: dict[str, Item], parts: tuple[str, ...]) -> Make:
    known = ("step_over", "direction", "axis", "facing_degrees", "lead_in", "lead_out", "back_and_forth")
    given = fields["raster"].fields(known, ("step_over", "direction"))
    step_over, direction = given["step_over"].number(1e-5, 10.0), vector(given["direction"])
    axis = vector(given["axis"]) if "axis" in given else None
    facing = np.radians(given["facing_degrees"].number(1.0, 89.0) if "facing_degrees" in given else 75.0)
    leads = {name: given[name].number(0.0, 1.0) for name in ("lead_in", "lead_out") if name in given}
    both = given["back_and_forth"].boolean() if "back_and_forth" in given else True
    return lambda cell, density: raster(
        cell.mesh(parts),
        step_over,
        direction,
        axis=axis,
        facing=float(facing),
        back_and_forth=both,
        chord=density.chord,
        step=density.step,
        **leads,
    )


def _gcode(item: Item, fields: dict[str, Item], _: tuple[str, ...]) -> Make:
    file = beside(item, fields["gcode"].text())
    normal = vector(fields["normal"]) if "normal" in fields else np.array([0.0, 0.0, 1.0])

    def make(_: Cell, density: Density) -> list[Way]:
        try:
            text = file.read_text("utf-8", errors="replace")
        except OSError as error:
            raise MissingFileError(f"{file} can't be read: {error.strerror}", metadata={"file": str(file)}) from None
        return [cut.way for cut in read_gcode(text, file=str(file), normal=normal, chord=density.chord)]

    return make


def _curves(item: Item, fields: dict[str, Item], _: tuple[str, ...]) -> Make:
    given = fields["curves"].fields(("file", "names"), ("file",))
    file = beside(item, given["file"].text())
    names = tuple(one.text() for one in given["names"].items()) if "names" in given else ()
    axis = -vector(fields["normal"]) if "normal" in fields else None

    def make(_: Cell, density: Density) -> list[Way]:
        found = curve_ways(read_curves(file, names), density.chord, arcs=False)
        return found if axis is None else [way.facing(axis) for way in found]

    return make


_READERS: dict[str, Callable[[Item, dict[str, Item], tuple[str, ...]], Make]] = {
    "edge": _edge,
    "points": _points,
    "targets": _targets,
    "section": _section,
    "raster": _raster,
    "gcode": _gcode,
    "curves": _curves,
    "spots": _spots,
}


def beside(item: Item, name: str) -> Path:
    """Return a file whose name is beside the one that names it."""
    return Path(item.file).parent / name


def _trimmed(source: Source, way: Way) -> Way:
    """Return a way without lengths at its ends."""
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way.points, axis=0), axis=1))])
    begin, end = source.trim[0], at[-1] - source.trim[1]
    if end - begin < 1e-3:
        raise source.item.error(f"the trim leaves nothing of a way of {1e3 * at[-1]:.4g} mm")
    inner = at[(at > begin + 1e-6) & (at < end - 1e-6)]
    places = np.concatenate([[begin], inner, [end]])

    def here(values: Floats) -> Floats:
        flat = values.reshape(len(at), -1)
        columns = np.array([np.interp(places, at, one) for one in flat.T]).reshape(-1, len(places))
        return columns.T.reshape(len(places), *values.shape[1:])

    return Way(here(way.points), units(here(way.normals)))


def _named(parts: tuple[str, ...]) -> str:
    return f"{parts[0]!r} has" if len(parts) == 1 else f"{', '.join(map(repr, parts))} together have"


def _place(point: Floats) -> str:
    return "[" + ", ".join(f"{one:.4g}" for one in (np.round(point, 6) + 0.0).tolist()) + "]"
