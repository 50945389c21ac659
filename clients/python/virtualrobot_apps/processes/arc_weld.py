"""Arc welding: seams on edges of parts or through points, the torch by work and travel angle, and a weave."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client, Program, Robot, ToolPath, pose
from virtualrobot.errors import InvalidArgumentError, UnreachableError, VirtualRobotError

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.way import Way
from virtualrobot_apps.processes.part import part_mesh
from virtualrobot_apps.processes.process import PlannedProcess
from virtualrobot_apps.processes.sources.edges import KINDS, edges, nearest
from virtualrobot_apps.processes.sources.frames import STEEPEST, WAVES, tool_frames, weave
from virtualrobot_apps.processes.sources.offsets import offset
from virtualrobot_apps.processes.sources.picked import spline
from virtualrobot_apps.processes.sources.sampling import CHORD, STEP, sampled

Floats = NDArray[np.float64]

MOST_FRAMES = 1001
"""Frames of a tool path at most (docs/tool-paths.md)."""
_FIELDS = (
    *("schema_version", "process", "robot", "seams", "torch", "tolerance", "speed", "weave", "passes", "arc"),
    *("approach", "chord", "step"),
)


@dataclass(frozen=True, slots=True, eq=False)
class Seam:
    """Seam of a file: an edge of parts, or a spline through points or taught targets.

    Attributes:
        item: where it stands.
        parts: the nodes whose edge it is; points are in the frame of the first one.
        kind: `concave` or `convex`; None for a spline.
        near: (3,) a point (m) that the edge comes nearest to; None where there is only one.
        points: (n, 3) of a spline (m).
        normal: (3,), or (n, 3), out of the part there.
        targets: names of the targets that the points are of, whose z points into the part.
        reverse: goes the other way.
        trim: the lengths (m) that are left out at its beginning and at its end.
    """

    item: Item
    parts: tuple[str, ...]
    kind: str | None = None
    near: Floats | None = None
    points: Floats | None = None
    normal: Floats | None = None
    targets: tuple[str, ...] = ()
    reverse: bool = False
    trim: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class ArcWeld:
    """Arc welding as a file describes it; angles in rad, lengths in m.

    Attributes:
        robot: the arm.
        seams: in their order.
        speed: of the torch along the seam (m/s).
        work: the work angle, as of `tool_frames`; None for the bisector.
        base: (3,) where the face looks that the work angle is from, as of `tool_frames`.
        travel: the travel angle, above 0 pushed.
        standoff: the distance of the tool centre point before the seam.
        tolerance: of the tool path, by axis.
        weave: width, length and shape; None without.
        passes: offsets (across, away) of each pass.
        signal: the signal that is true while the arc burns; None without.
        start_seconds: how long the torch stands at the beginning with the arc on.
        end_seconds: how long it does so at the end, to fill the crater.
        approach: how far before the seam, against z, the torch comes from and goes to.
        chord: as of `sampled`.
        step: as of `sampled`.
    """

    robot: str
    seams: tuple[Seam, ...]
    speed: float
    work: float | None = None
    base: Floats = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    travel: float = 0.0
    standoff: float = 0.0
    tolerance: dict[str, float | tuple[float, float] | str] = field(default_factory=dict)
    weave: tuple[float, float, str] | None = None
    passes: tuple[tuple[float, float], ...] = ((0.0, 0.0),)
    signal: str | None = None
    start_seconds: float = 0.0
    end_seconds: float = 0.0
    approach: float = 0.05
    chord: float = CHORD
    step: float = STEP


def read_weld(item: Item) -> ArcWeld:
    """Return what a file says; raises MalformedFileError, with file and line, for what it says wrong."""
    fields = item.fields(_FIELDS, ("robot", "seams", "speed"))
    found: dict[str, object] = {}
    for name, most in (("approach", 1.0), ("chord", 0.01), ("step", 0.1)):
        if name in fields:
            found[name] = fields[name].number(1e-6, most)
    if "torch" in fields:
        torch = fields["torch"].fields(("work_degrees", "base", "travel_degrees", "standoff"))
        if "work_degrees" in torch:
            found["work"] = np.radians(torch["work_degrees"].number(-89.0, 89.0))
        if "base" in torch:
            found["base"] = _vector(torch["base"])
        steepest = float(np.degrees(STEEPEST))
        if "travel_degrees" in torch:
            found["travel"] = np.radians(torch["travel_degrees"].number(-steepest, steepest))
        if "standoff" in torch:
            found["standoff"] = torch["standoff"].number(0.0, 1.0)
    if "weave" in fields:
        given = fields["weave"].fields(("width", "length", "shape"), ("width", "length"))
        shape = given["shape"].one_of(tuple(WAVES)) if "shape" in given else "sine"
        found["weave"] = (given["width"].number(1e-6, 0.1), given["length"].number(1e-6, 1.0), shape)
    if "arc" in fields:
        arc = fields["arc"].fields(("signal", "start_seconds", "end_seconds"), ("signal",))
        found["signal"] = arc["signal"].text()
        found |= {name: arc[name].number(0.0, 60.0) for name in ("start_seconds", "end_seconds") if name in arc}
    if "passes" in fields:
        found["passes"] = tuple(_pass(one) for one in fields["passes"].items())
        if not found["passes"]:
            raise fields["passes"].error("a pass belongs here: [across, away] in m")
    seams = tuple(_seam(one) for one in fields["seams"].items())
    if not seams:
        raise fields["seams"].error("a seam belongs here")
    return ArcWeld(
        fields["robot"].text(),
        seams,
        fields["speed"].number(1e-5, 10.0),
        tolerance=_tolerance(fields.get("tolerance")),
        **found,  # pyright: ignore[reportArgumentType] each by its name
    )


def _tolerance(item: Item | None) -> dict[str, float | tuple[float, float] | str]:
    """Return the tolerance of a tool path: the torch may turn about itself if nothing else is said."""
    if item is None:
        return {"rotation_z": "free"}
    fields = item.fields(("rotation", "work_degrees", "travel_degrees"))
    found: dict[str, float | tuple[float, float] | str] = {}
    for name, axis in (("work_degrees", "rotation_x"), ("travel_degrees", "rotation_y")):
        if name in fields:
            found[axis] = float(np.radians(fields[name].number(0.0, 45.0)))
    turn = fields["rotation"].scalar() if "rotation" in fields else "free"
    found["rotation_z"] = "free" if turn == "free" else float(np.radians(fields["rotation"].number(0.0, 180.0)))
    return found


def _seam(item: Item) -> Seam:
    fields = item.fields(("part", "edge", "near", "points", "normal", "targets", "reverse", "trim"), ("part",))
    part = fields["part"]
    parts = tuple(one.text() for one in part.items()) if part.is_list else (part.text(),)
    if not parts:
        raise part.error("the name of a part belongs here")
    reverse = "reverse" in fields and fields["reverse"].boolean()
    trim = tuple(one.number(0.0, 10.0) for one in fields["trim"].items()) if "trim" in fields else (0.0, 0.0)
    if len(trim) != 2:
        raise fields["trim"].error("two lengths in m belong here: at the beginning and at the end")
    for one, others in (("targets", ("edge", "near", "points", "normal")), ("points", ("edge", "near"))):
        for other in others:
            if one in fields and other in fields:
                raise fields[other].error("a seam is an edge, or goes through points or targets: give one of them")
    if "targets" in fields:
        names = tuple(one.text() for one in fields["targets"].items())
        return Seam(item, parts, None, targets=names, reverse=reverse, trim=trim)
    if "points" in fields:
        if "normal" not in fields:
            raise item.error("a seam through points needs the normal that the torch points against")
        points = np.array([_vector(one) for one in fields["points"].items()]).reshape(-1, 3)
        return Seam(item, parts, None, None, points, _vector(fields["normal"]), (), reverse, trim)
    if "normal" in fields:
        raise fields["normal"].error("the normal is of a seam through points")
    kind = fields["edge"].one_of(KINDS) if "edge" in fields else "concave"
    near = _vector(fields["near"]) if "near" in fields else None
    return Seam(item, parts, kind, near, reverse=reverse, trim=trim)


def _vector(item: Item) -> Floats:
    values = [one.number() for one in item.items()]
    if len(values) != 3:
        raise item.error(f"three numbers belong here, not {len(values)}")
    return np.array(values)


def _pass(item: Item) -> tuple[float, float]:
    values = [one.number(-1.0, 1.0) for one in item.items()]
    if len(values) != 2:
        raise item.error("two lengths in m belong here: to the left across the seam, and out of it")
    return values[0], values[1]


def seam_way(seam: Seam, ways: list[Way], chord: float, step: float) -> Way:
    """Return the way of a seam, `ways` being the edges of its parts, as dense as asked.

    Raises MalformedFileError, with file and line, where there is no such edge, or more than one, and for a trim that
    leaves nothing.
    """
    if seam.points is not None and seam.normal is not None:
        way = spline(seam.points, seam.normal, chord=chord, step=step)
    else:
        if not ways:
            raise seam.item.error(f"{_named(seam.parts)} no {seam.kind} edge")
        if seam.near is None and len(ways) > 1:
            told = "; ".join(f"{1e3 * one.length:.4g} mm from {_place(one.points[0])}" for one in ways[:8])
            more = f" and {len(ways) - 8} more" if len(ways) > 8 else ""
            raise seam.item.error(
                f"{_named(seam.parts)} {len(ways)} {seam.kind} edges: say by `near: [x, y, z]` in m which one: "
                f"{told}{more}"
            )
        way = sampled(ways[0] if seam.near is None else nearest(ways, seam.near), chord, step)
    if seam.reverse:
        way = way.reversed()
    return way if not any(seam.trim) else _trimmed(seam, way)


def taught(client: Client, seam: Seam) -> Seam:
    """Return a seam through the places of its targets as they are now; raises UnknownNameError for one there is not."""
    if not seam.targets:
        return seam
    part_t_world = np.linalg.inv(client.scene[seam.parts[0]].pose)
    poses = np.array([part_t_world @ client.scene.target(name).pose for name in seam.targets])
    return replace(seam, points=poses[:, :3, 3], normal=-poses[:, :3, 2])


def _trimmed(seam: Seam, way: Way) -> Way:
    """Return a way without lengths at its ends."""
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way.points, axis=0), axis=1))])
    begin, end = seam.trim[0], at[-1] - seam.trim[1]
    if end - begin < 1e-3:
        raise seam.item.error(f"the trim leaves nothing of a seam of {1e3 * at[-1]:.4g} mm")
    inner = at[(at > begin + 1e-6) & (at < end - 1e-6)]
    places = np.concatenate([[begin], inner, [end]])

    def here(values: Floats) -> Floats:
        flat = values.reshape(len(at), -1)
        return np.stack([np.interp(places, at, one) for one in flat.T], axis=1).reshape(-1, *values.shape[1:])

    normals = here(way.normals)
    return Way(here(way.points), normals / np.linalg.norm(normals, axis=2, keepdims=True))


def seam_frames(weld: ArcWeld, way: Way) -> tuple[Floats, float]:
    """Return the frames (n, 4, 4) of the torch along a way, and its speed along them (m/s).

    With a weave it is as much faster as its way is longer, so that the seam is welded at the speed that is wanted.

    Raises InvalidArgumentError for what `tool_frames` and `weave` refuse, and for too many frames.
    """
    frames = tool_frames(way, work=weld.work, base=weld.base, travel=weld.travel, standoff=weld.standoff)
    speed = weld.speed
    if weld.weave is not None:
        straight = _length(frames)
        frames = weave(frames, *weld.weave)
        speed *= _length(frames) / straight
    if len(frames) > MOST_FRAMES:
        raise InvalidArgumentError(
            f"a seam of {1e3 * way.length:.4g} mm has {len(frames)} frames, and a tool path {MOST_FRAMES} at most: "
            + ("make the waves longer or the seam shorter" if weld.weave else "give a greater step or chord")
        )
    return frames, speed


def plan(client: Client, item: Item) -> PlannedProcess:
    """Return the plan of arc welding that a file describes, in the cell as it is. Nothing moves.

    Raises:
        MalformedFileError: for what the file says wrong, with file and line.
        VirtualRobotError: for what can't be done, with the seam where it stands.
    """
    weld = read_weld(item)
    robot = client.robot(weld.robot)
    program, measures = client.program(), list[str]()
    here: dict[str, float] = {}
    meshes: dict[tuple[tuple[str, ...], str], list[Way]] = {}
    burning = 0.0
    for number, seam in enumerate(weld.seams, 1):
        for layer, beside in enumerate(weld.passes, 1):
            name = f"seam {number}" if len(weld.passes) == 1 else f"seam {number}, pass {layer}"
            try:
                if seam.kind is not None and (seam.parts, seam.kind) not in meshes:
                    meshes[seam.parts, seam.kind] = edges(part_mesh(client, seam.parts), seam.kind)
                way = seam_way(
                    taught(client, seam), meshes.get((seam.parts, seam.kind or ""), []), weld.chord, weld.step
                )
                way = offset(way, *beside) if any(beside) else way
                frames, speed = seam_frames(weld, way)
                path = client.paths.find_tool_path(
                    robot, frames, speed, tolerance=weld.tolerance, reference=seam.parts[0]
                )
                here = _weld(client, program, robot, weld, path, name, here)
            except VirtualRobotError as error:
                raise _at(seam.item, name, error) from None
            burning += path.duration + weld.start_seconds + weld.end_seconds
            measures.append(_measure(name, way, path))
    measures.append(f"arc on for {burning:.2f} s")
    return PlannedProcess(program, tuple(measures))


def _weld(
    client: Client, program: Program, robot: Robot, weld: ArcWeld, path: ToolPath, name: str, here: dict[str, float]
) -> dict[str, float]:
    """Add a seam to a program: to before it on a free path, to it, along it with the arc, and away from it.

    `here` are the joints where the last seam has left them; the joints are returned where this one does.
    """
    before, behind = (_before(robot, weld, path, row) for row in (0, -1))
    program.call(client.paths.find(robot, before, start=here).program, f"to {name}")
    program.move(robot.ptp(path.start_joints))
    if weld.signal is not None:
        program.set(weld.signal, True)
    if weld.start_seconds:
        program.dwell(weld.start_seconds)
    program.call(path.program, name)
    if weld.end_seconds:
        program.dwell(weld.end_seconds)
    if weld.signal is not None:
        program.set(weld.signal, False)
    program.move(robot.ptp(behind))
    return behind


def _before(robot: Robot, weld: ArcWeld, path: ToolPath, row: int) -> dict[str, float]:
    """Return the joints at which the torch is before its first or last place on a path, back along its z."""
    here = dict(zip(path.joint_names, path.positions[row].tolist(), strict=True))
    away = robot.solve_forward(here).world_t_tcp @ pose(z=-weld.approach)
    found = robot.solve_inverse(away, seed=here)
    if not found.solved:
        raise UnreachableError(
            f"{robot.name!r} can't be {1e3 * weld.approach:.4g} mm before the seam's {'end' if row else 'beginning'}: "
            f"{found.explanation}; give another `approach`"
        )
    return dict(zip(found.joint_names, found.solutions[0].tolist(), strict=True))


def _at(item: Item, name: str, error: VirtualRobotError) -> VirtualRobotError:
    """Return an error with the place of the seam in the file before it."""
    if error.metadata.get("file") == item.file:
        return error
    metadata = {**error.metadata, "file": item.file, "line": str(item.line)}
    return type(error)(f"{item.file}:{item.line}: {name}: {error.message}", error.reason, metadata, error.code)


def _measure(name: str, way: Way, path: ToolPath) -> str:
    """Return a line about a seam: its length and time, and how far the torch leans from its angles."""
    lean = np.degrees(np.abs(path.freedoms[:, 3:5]).max(axis=0))
    return (
        f"{name}: {1e3 * way.length:.1f} mm in {path.duration:.2f} s, work angle within {lean[0]:.1f} and travel angle "
        f"within {lean[1]:.1f} degrees of what is wanted, {path.searches} searches, {path.checks} checks"
    )


def _length(frames: Floats) -> float:
    return float(np.linalg.norm(np.diff(frames[:, :3, 3], axis=0), axis=1).sum())


def _named(parts: tuple[str, ...]) -> str:
    return f"{parts[0]!r} has" if len(parts) == 1 else f"{', '.join(map(repr, parts))} together have"


def _place(point: Floats) -> str:
    return "[" + ", ".join(f"{one:.4g}" for one in (np.round(point, 6) + 0.0).tolist()) + "]"
