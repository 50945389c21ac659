"""Tools led along the ways of sources, as files describe them: what processes that follow ways have in common."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from scipy.spatial.transform import Rotation
from virtualrobot import Client, Move, Program, Robot, ToolPath, ToolPathPartner, pose
from virtualrobot.errors import InvalidArgumentError, UnreachableError, VirtualRobotError
from virtualrobot.motions.paths import ToolPathOptions
from virtualrobot.motions.tool_paths import PartnerMotion

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.way import Floats, Way
from virtualrobot_apps.processes.process import PlannedProcess
from virtualrobot_apps.processes.source import Density, Source, cell_of, read_source, vector, ways_of
from virtualrobot_apps.processes.sources.corners import looped, parted, rounded
from virtualrobot_apps.processes.sources.frames import STEEPEST, heading_frames, tool_frames
from virtualrobot_apps.processes.switching import Switch

MOST_FRAMES = 1001
"""Frames of a tool path at most (docs/tool-paths.md)."""
TOGETHER_SECONDS = 120.0
"""Longest time of a search for several arms."""
DENSER = "give a greater step or chord"
"""Remedy for a way that has more frames."""
FIELDS = (
    *("schema_version", "process", "robot", "tolerance", "speed", "approach", "chord", "step", "corners", "split"),
    *("external", "may_touch", "flat_degrees"),
)


@dataclass(frozen=True, slots=True, eq=False)
class Leading:
    """Tool that is led along ways; angles in rad, lengths in m.

    Attributes:
        robot: the arm.
        sources: of the ways, in their order.
        speed: along them (m/s).
        work: the work angle, as of `tool_frames`; None for the bisector, or the normal.
        base: (3,) where the face looks that the work angle is from, as of `tool_frames`.
        travel: the travel angle, above 0 pushed.
        heading: (3,) along which the tool's x is, as of `heading_frames`; None for x along the way.
        standoff: the distance of the tool centre point before the way.
        tolerance: of the tool path, by axis.
        approach: how far before a way, against z, the tool comes from and goes to.
        density: of the ways.
        corners: what is gone for a way with corners: ways without, or more of them.
        external: the names of robots that move along, as a rail or a positioner does.
        may_touch: the nodes that the tool may touch from where it comes to each way until it has gone from it.
        slope: how far frames may be from straight down at the most (rad), for which these are chosen; None: any.
        split: whether a way that can't be gone at once is gone in parts.
        straight: whether the tool comes and goes on lines; else joints go evenly, which is nearly that.
    """

    robot: str
    sources: tuple[Source, ...]
    speed: float
    work: float | None = None
    base: Floats = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    travel: float = 0.0
    heading: Floats | None = None
    standoff: float = 0.0
    tolerance: dict[str, float | tuple[float, float] | str] = field(default_factory=dict)
    approach: float = 0.05
    density: Density = field(default_factory=Density)
    corners: Callable[[Way], list[Way]] = field(default=lambda way: [way])
    external: tuple[str, ...] = ()
    may_touch: tuple[str, ...] = ()
    slope: float | None = None
    split: bool = False
    straight: bool = False

    def frames(self, way: Way) -> Floats:
        """Return the frames (n, 4, 4) of the tool along a way; raises InvalidArgumentError for what these refuse."""
        if self.heading is not None:
            return heading_frames(way, self.heading, standoff=self.standoff)
        return tool_frames(way, work=self.work, base=self.base, travel=self.travel, standoff=self.standoff)

    def stretch(self, way: Way, name: str, remedy: str = DENSER) -> tuple[str, Way, Floats, float]:
        """Return a way as the tool goes it: its name, itself, the frames (n, 4, 4), and the speed (m/s).

        Raises InvalidArgumentError as `frames`, and for too many of them; `remedy` says what to do then.
        """
        frames = self.frames(way)
        check_frames(frames, way, remedy)
        return name, way, frames, self.speed


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """Stretch that a tool was led along.

    Attributes:
        parts: the nodes that its way is of; it is in the frame of the first one.
        way: the way.
        frames: (n, 4, 4) where the tool is, in that frame, leaning and shifted within its tolerance as it is, but
            not turned about itself.
        times: (n,) when it is there (s), from 0; without what is between two parts that it is gone in.
    """

    parts: tuple[str, ...]
    way: Way
    frames: Floats
    times: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Led:
    """Plan of a process whose tool is led along ways.

    Attributes:
        program: its motion, from where the robot stands now.
        measures: a line about each way.
        seconds: how long the tool works (s).
        stretches: what it was led along, in this order.
    """

    program: Program
    measures: tuple[str, ...]
    seconds: float
    stretches: tuple[Stretch, ...]

    def with_measures(self, *more: str) -> PlannedProcess:
        """Return the plan with further lines about it."""
        return PlannedProcess(self.program, (*self.measures, *more))

    def by_parts(self) -> dict[tuple[str, ...], list[Stretch]]:
        """Return the stretches by the parts that their ways are of."""
        return {parts: [self.stretches[row] for row in rows] for parts, rows in self.rows_by_parts().items()}

    def rows_by_parts(self) -> dict[tuple[str, ...], list[int]]:
        """Return the places of the stretches by the parts that their ways are of."""
        found: dict[tuple[str, ...], list[int]] = {}
        for row, one in enumerate(self.stretches):
            found.setdefault(one.parts, []).append(row)
        return found


class Process(Protocol):
    """Work of a process along each way."""

    @property
    def what(self) -> str:
        """The name of a way, such as `seam`."""
        ...

    @property
    def switch(self) -> Switch:
        """The signal of its tool."""
        ...

    def stretches(self, way: Way, name: str) -> Iterable[tuple[str, Way, Floats, float]]:
        """Return what the tool goes for one way: each a name, a way, its frames (n, 4, 4), and a speed (m/s)."""
        ...

    def along(self, program: Program, path: ToolPath, name: str) -> float:
        """Add what is done along a tool path to a program, and return how long (s) that takes."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Accompanying:
    """Arm that goes along with another one, its n-th stretch with the other's n-th.

    Attributes:
        leading: how its tool is led.
        process: its work.
        paced: whether its speed is that of its stretches; else it is whichever makes both end together.
    """

    leading: Leading
    process: Process
    paced: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Wanted:
    """Stretch that a tool is to go: a way of a source, or a pass on it.

    Attributes:
        source: where it is from.
        name: what it is called.
        way: the way, in the frame of the source's first part.
        frames: (n, 4, 4) of the tool, in that frame.
        speed: along them (m/s).
    """

    source: Source
    name: str
    way: Way
    frames: Floats
    speed: float


def read_leading(fields: dict[str, Item], sources: Item, tool: Item | None) -> Leading:
    """Return what a file says; raises MalformedFileError, with file and line, for what it says wrong."""
    found: dict[str, object] = {}
    density: dict[str, float] = {}
    for name, most in (("approach", 1.0), ("chord", 0.01), ("step", 0.1)):
        if name in fields:
            (found if name == "approach" else density)[name] = fields[name].number(1e-6, most)
    if tool is not None:
        found |= _tool(tool)
    if "corners" in fields:
        found["corners"] = _corners(fields["corners"])
    read = tuple(read_source(one) for one in sources.items())
    if not read:
        raise sources.error("a source of ways belongs here")
    return Leading(
        fields["robot"].text(),
        read,
        fields["speed"].number(1e-5, 10.0),
        tolerance=_tolerance(fields.get("tolerance")),
        density=Density(**density),
        external=_names(fields.get("external")),
        may_touch=_names(fields.get("may_touch")),
        slope=float(np.radians(fields["flat_degrees"].number(0.1, 180.0))) if "flat_degrees" in fields else None,
        split="split" in fields and fields["split"].boolean(),
        **found,  # pyright: ignore[reportArgumentType] each by its name
    )


def _names(item: Item | None) -> tuple[str, ...]:
    return () if item is None else tuple(one.text() for one in item.items())


def _corners(item: Item) -> Callable[[Way], list[Way]]:
    given = item.fields(("round", "loop", "lift"))
    if len(given) != 1:
        raise item.error("one of `round` (m), `loop` (m) and `lift: true` belongs here")
    if "lift" in given:
        return parted if given["lift"].boolean() else lambda way: [way]
    if "loop" in given:
        radius = given["loop"].number(1e-4, 1.0)
        return lambda way: [looped(way, radius)]
    most = given["round"].number(1e-6, 0.1)
    return lambda way: [rounded(way, most)]


def _tool(item: Item) -> dict[str, object]:
    given = item.fields(("work_degrees", "base", "travel_degrees", "heading", "standoff"))
    found: dict[str, object] = {}
    if "heading" in given:
        found["heading"] = vector(given["heading"])
        for name in ("work_degrees", "base", "travel_degrees"):
            if name in given:
                raise given[name].error("a tool with a heading is against the normal: leave one of both out")
    if "work_degrees" in given:
        found["work"] = np.radians(given["work_degrees"].number(-89.0, 89.0))
    if "base" in given:
        found["base"] = vector(given["base"])
    steepest = float(np.degrees(STEEPEST))
    if "travel_degrees" in given:
        found["travel"] = np.radians(given["travel_degrees"].number(-steepest, steepest))
    if "standoff" in given:
        found["standoff"] = given["standoff"].number(0.0, 1.0)
    return found


def _tolerance(item: Item | None) -> dict[str, float | tuple[float, float] | str]:
    """Return the tolerance of a tool path: the tool may turn about itself if nothing else is said."""
    if item is None:
        return {"rotation_z": "free"}
    fields = item.fields(("rotation", "work_degrees", "travel_degrees", "x", "y", "z"))
    found: dict[str, float | tuple[float, float] | str] = {}
    for name, axis in (("work_degrees", "rotation_x"), ("travel_degrees", "rotation_y")):
        if name in fields:
            found[axis] = float(np.radians(fields[name].number(0.0, 45.0)))
    found |= {name: fields[name].number(0.0, 0.1) for name in ("x", "y", "z") if name in fields}
    turn = fields["rotation"].scalar() if "rotation" in fields else "free"
    found["rotation_z"] = "free" if turn == "free" else float(np.radians(fields["rotation"].number(0.0, 180.0)))
    return found


def lead(client: Client, leading: Leading, process: Process, partners: Sequence[Accompanying] = ()) -> Led:
    """Return the plan of a process in the cell as it is, for an arm and its partners. Nothing moves.

    Between ways the arm goes on free paths; where others move along all go by joints.

    Raises:
        MalformedFileError: for what the file says wrong, with file and line.
        VirtualRobotError: for what can't be done, with the source where it stands.
    """
    touched = [pair for one in (leading, *(one.leading for one in partners)) for pair in touched_by(client, one)]
    program, measures = client.program(), list[str]()
    here: dict[str, float] = {}
    working, gone = 0.0, list[Stretch]()
    for one, *others in _beside(client, leading, process, partners):
        name = one.name
        try:
            paths = _paths(client, leading, one, [*zip(partners, others, strict=True)], touched)
            gone.append(Stretch(one.source.parts, one.way, *_gone(one.frames, [path for _, path in paths])))
            for name, path in paths:
                arms = _arms(client, leading, partners, path)
                before, behind = ([arm.away(end) for arm in arms] for end in (0, -1))
                if path.external or partners:
                    # A free path is looked for where all else stands as it does now.
                    program.move(*_by_joints(arms, before), *_external(client, path))
                else:
                    program.call(client.paths.find(arms[0].robot, before[0], start=here).program, f"to {name}")
                if touched:
                    program.allow((*pair, "it works there") for pair in touched)
                program.move(*(arm.straight(client, arm.path.start_joints) for arm in arms))
                working += process.along(program, path, name)
                program.move(*(arm.straight(client, joints) for arm, joints in zip(arms, behind, strict=True)))
                if touched:
                    program.allow(forbid=touched)
                here = behind[0]
                length = one.way.length if name == one.name else path.length
                measures.append(_measure(name, length, path.duration, path.freedoms, path))
            for partner, other in zip(partners, others, strict=True):
                moved = paths[0][1].partners[partner.leading.robot]
                gone.append(Stretch(other.source.parts, other.way, *_gone(other.frames, [moved])))
                told = f"{partner.leading.robot}, {other.name}"
                measures.append(_measure(told, other.way.length, float(moved.times[-1]), moved.freedoms))
        except VirtualRobotError as error:
            raise at_line(one.source.item, name, error) from None
    return Led(program, tuple(measures), working, tuple(gone))


def touched_by(client: Client, leading: Leading) -> list[tuple[str, str]]:
    """Return the pairs of a tool and what it may touch that may not touch anyway.

    Raises WrongStateError where the robot has no tool, and UnknownNameError for a node that there is not.
    """
    if not leading.may_touch:
        return []
    tool, allowed = client.robot(leading.robot).tool().name, client.collisions.allowed
    anyway = {frozenset((pair.first, pair.second)) for pair in allowed.list(tool)}
    pairs = [(tool, client.scene[node].name) for node in leading.may_touch]
    return [pair for pair in pairs if frozenset(pair) not in anyway]


@dataclass(frozen=True, slots=True, eq=False)
class _Arm:
    """Arm on a path: how it is led, and its motion."""

    robot: Robot
    leading: Leading
    path: ToolPath | PartnerMotion

    def away(self, row: int) -> dict[str, float]:
        """Return the joints at which the tool is before its first or last place, back along its z."""
        robot, path, approach = self.robot, self.path, self.leading.approach
        here = dict(zip(path.joint_names, path.positions[row].tolist(), strict=True))
        away = robot.solve_forward(here).world_t_tcp @ pose(z=-approach)
        found = robot.solve_inverse(away, seed=here)
        if not found.solved:
            raise UnreachableError(
                f"{robot.name!r} can't be {1e3 * approach:.4g} mm before the way's {'end' if row else 'beginning'}: "
                f"{found.explanation}; give another `approach`"
            )
        return dict(zip(found.joint_names, found.solutions[0].tolist(), strict=True))

    def straight(self, client: Client, joints: dict[str, float]) -> Move:
        """Return the move to a posture by which the tool comes or goes; a line is in the frame of the robot."""
        robot = self.robot
        if not self.leading.straight:
            return robot.ptp(joints)
        world_t_robot = client.scene[robot.name].pose
        goal = np.linalg.inv(world_t_robot) @ robot.solve_forward(joints).world_t_tcp
        return robot.linear(goal, reference=robot.name)


def _arms(client: Client, leading: Leading, partners: Sequence[Accompanying], path: ToolPath) -> list[_Arm]:
    """Return the arm that leads, and its partners, on a path."""
    others = [(one.leading, path.partners[one.leading.robot]) for one in partners]
    return [_Arm(client.robot(led.robot), led, motion) for led, motion in [(leading, path), *others]]


def _by_joints(arms: Sequence[_Arm], joints: Sequence[dict[str, float]]) -> list[Move]:
    return [arm.robot.ptp(there) for arm, there in zip(arms, joints, strict=True)]


def _beside(
    client: Client, leading: Leading, process: Process, partners: Sequence[Accompanying]
) -> Iterator[tuple[Wanted, ...]]:
    """Yield what is to be gone at once: by the arm that leads, and by its partners."""
    own = wanted(client, leading, process)
    if not partners:
        yield from ((one,) for one in own)
        return
    every = [list(own), *(list(wanted(client, one.leading, one.process)) for one in partners)]
    for partner, found in zip(partners, every[1:], strict=True):
        if len(found) != len(every[0]):
            raise partner.leading.sources[0].item.error(
                f"{partner.leading.robot!r} has {len(found)} of what {leading.robot!r} has {len(every[0])}: each "
                f"{process.what} of one goes with that of the other"
            )
    yield from zip(*every, strict=True)


def wanted(client: Client, leading: Leading, process: Process) -> Iterator[Wanted]:
    """Yield what the tool of a process is to go, one after the other; raises as `lead` does for the ways."""
    cell = cell_of(client)
    for number, source in enumerate(leading.sources, 1):
        name = f"{process.what} {number}"
        try:
            found = ways_of(source, cell, leading.density)
            ways = [way for one in found for way in leading.corners(one)]
            for row, way in enumerate(ways, 1):
                name = f"{process.what} {number}" if len(ways) == 1 else f"{process.what} {number}.{row}"
                for told, there, frames, speed in process.stretches(way, name):
                    yield Wanted(source, told, there, frames, speed)
        except VirtualRobotError as error:
            raise at_line(source.item, name, error) from None


def _paths(
    client: Client,
    leading: Leading,
    one: Wanted,
    partners: Sequence[tuple[Accompanying, Wanted]],
    touched: Sequence[tuple[str, str]],
) -> list[tuple[str, ToolPath]]:
    """Return the tool paths along what is wanted, by their names: one, or the fewest where they may be split.

    touched: the pairs that may touch there.
    """
    name, where = one.name, one.source.parts[0]
    led: ToolPathOptions = {
        "tolerance": leading.tolerance,
        "reference": where,
        "external": leading.external,
        "slope": leading.slope,
        "may_touch": touched,
        "partners": [
            ToolPathPartner(
                partner.leading.robot,
                other.frames,
                other.speed if partner.paced else None,
                partner.leading.tolerance,
                other.source.parts[0],
                slope=partner.leading.slope,
            )
            for partner, other in partners
        ],
    }
    if partners:
        # Several arms are searched one within the other.
        led["time_limit"] = TOGETHER_SECONDS
    if not leading.split:
        return [(name, client.paths.find_tool_path(leading.robot, one.frames, one.speed, **led))]
    parts = client.paths.find_tool_path_parts(leading.robot, one.frames, one.speed, **led)
    for part in parts:
        if part.refusal is not None:
            raise part.refusal
    whole = len(parts) == 1
    return [
        (name if whole else f"{name}, part {number}", part.path)
        for number, part in enumerate(parts, 1)
        if part.path is not None
    ]


def _gone(frames: Floats, paths: Sequence[ToolPath | PartnerMotion]) -> tuple[Floats, Floats]:
    """Return where a tool is (n, 4, 4) that has freedom at frames, and when (s), on paths that follow each other.

    Each begins at the frame where the one before ends. What it turns about itself is left out.
    """
    freedoms, times = paths[0].freedoms[:1], np.zeros(1)
    for path in paths:
        freedoms = np.concatenate([freedoms, path.freedoms[1:]])
        times = np.concatenate([times, times[-1] + (path.times - path.times[0])[1:]])
    frame_t_tool = np.tile(np.eye(4), (len(frames), 1, 1))
    frame_t_tool[:, :3, :3] = Rotation.from_euler("XY", freedoms[:, 3:5]).as_matrix()
    frame_t_tool[:, :3, 3] = freedoms[:, :3]
    return frames @ frame_t_tool, times


def check_frames(frames: Floats, way: Way, remedy: str) -> None:
    """Raise InvalidArgumentError where there are more frames than a tool path has; `remedy` says what to do then."""
    if len(frames) > MOST_FRAMES:
        raise InvalidArgumentError(
            f"a way of {1e3 * way.length:.4g} mm has {len(frames)} frames, and a tool path {MOST_FRAMES} at most: "
            f"{remedy}"
        )


def _external(client: Client, path: ToolPath) -> list[Move]:
    """Return the moves of robots that move along to where a path begins."""
    return [client.robot(name).ptp(motion.start_joints) for name, motion in path.external.items()]


def at_line(item: Item, name: str, error: VirtualRobotError) -> VirtualRobotError:
    """Return an error with the place of the source in the file before it."""
    if error.metadata.get("file") == item.file:
        return error
    metadata = {**error.metadata, "file": item.file, "line": str(item.line)}
    return type(error)(f"{item.file}:{item.line}: {name}: {error.message}", error.reason, metadata, error.code)


def _measure(name: str, length: float, seconds: float, freedoms: Floats, path: ToolPath | None = None) -> str:
    """Return a line about a way: its length and time, how far the tool leans from its angles, and how it was found."""
    lean = np.degrees(np.abs(freedoms[:, 3:5]).max(axis=0))
    found = f", {path.searches} searches, {path.checks} checks" if path is not None else ""
    return (
        f"{name}: {1e3 * length:.1f} mm in {seconds:.2f} s, work angle within {lean[0]:.1f} and travel angle "
        f"within {lean[1]:.1f} degrees of what is wanted{found}"
    )
