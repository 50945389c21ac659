"""G-code of milling machines and plotters as ways: lines and arcs (RS274/NGC: G0 to G3)."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot.errors import MalformedFileError

from virtualrobot_apps.curves.way import Floats, Way, above_zero, checked_way
from virtualrobot_apps.processes.sources.sampling import CHORD

INCH = 0.0254
MOVES = ("G0", "G1", "G2", "G3")
PLANES = {"G17": (0, 1, 2), "G18": (2, 0, 1), "G19": (1, 2, 0)}
"""The axes of a plane, and the one across it."""
IDLE = {
    *("G4", "G40", "G43", "G49", "G54", "G55", "G56", "G57", "G58", "G59", "G61", "G64", "G80", "G94", "G98", "G99"),
    *("M0", "M1", "M2", "M3", "M4", "M5", "M6", "M7", "M8", "M9", "M30", "M48", "M49"),
}
"""Words that change nothing of where the tool goes: coordinate systems are one, spindle and coolant are the user's."""
ARC_MATCH = 5e-4
"""Difference of the radii at both ends of an arc, in parts of them, that is let pass; 5 um always is."""
MOST_LINES = 2_000_000
_WORD = re.compile(r"([A-Z])\s*([+-]?(?:\d+(?:\.\d*)?|\.\d+))")
_COMMENT = re.compile(r"\([^()]*\)|;.*")


@dataclass(frozen=True, slots=True, eq=False)
class Cut:
    """Moves of one G-code between two rapid ones.

    Attributes:
        way: where the tool goes.
        feeds: (n - 1,) the speed (m/s) of each of its lines; nan where none was given.
        line: the line of the text in which it begins, from 1.
    """

    way: Way
    feeds: Floats
    line: int


@dataclass(slots=True)
class _State:
    """Settings that words have made: modal groups, and where the tool is (m)."""

    file: str
    line: int = 0
    move: str | None = None
    plane: tuple[int, int, int] = PLANES["G17"]
    unit: float = 1e-3
    absolute: bool = True
    centres_absolute: bool = False
    feed: float = math.nan
    place: Floats = field(default_factory=lambda: np.zeros(3))

    def error(self, text: str) -> MalformedFileError:
        line = str(max(1, self.line))
        return MalformedFileError(f"{self.file}:{line}: {text}", metadata={"file": self.file, "line": line})


def read_gcode(
    text: str, *, file: str = "G-code", normal: ArrayLike = (0.0, 0.0, 1.0), chord: float = CHORD
) -> list[Cut]:
    """Return the cuts of a G-code: what it goes by G1, G2 and G3 between rapid moves, in m.

    Read are G0 to G3, planes (G17 to G19), inches and mm (G20, G21; mm at the beginning), absolute and relative places
    (G90, G91) and centres of arcs (G90.1, G91.1), F, and words that move nothing. The tool begins at 0, 0, 0.

    Args:
        text: the G-code.
        file: what it is called in errors.
        normal: (3,) out of the surface, against the tool.
        chord: how far an arc may be beside the lines between its points (m).

    Raises:
        MalformedFileError: for what isn't read, with file and line, for arcs whose ends don't have one radius, and
            where nothing is cut.
        InvalidArgumentError: for a chord that is not above 0, and a normal without length.
    """
    above_zero("chord", chord)
    state, cuts = _State(file), list[Cut]()
    points, feeds, begun = [state.place], list[float](), 0

    def end() -> None:
        nonlocal points, feeds
        if feeds:
            cuts.append(Cut(checked_way(np.array(points), normal), np.array(feeds), begun))
        points, feeds = [state.place], []

    for words in _blocks(state, text):
        goal = _set(state, words)
        if goal is None:
            continue
        if state.move == "G0":
            state.place = goal
            end()
            continue
        on = [goal] if state.move == "G1" else _arc(state, goal, words, chord)
        for point in on:
            if not np.array_equal(point, points[-1]):
                begun = begun if feeds else state.line
                points.append(point)
                feeds.append(state.feed)
        state.place = points[-1]
    end()
    if not cuts:
        raise state.error("there is no cut: no G1, G2 or G3 goes anywhere")
    return cuts


def _blocks(state: _State, text: str) -> Iterator[list[tuple[str, float]]]:
    """Yield the words of each line, letter and number, until the program ends (M2, M30)."""
    lines = text.splitlines()
    if len(lines) > MOST_LINES:
        raise state.error(f"there are {len(lines):,} lines; {MOST_LINES:,} are read")
    for state.line, line in enumerate(lines, 1):
        left = _COMMENT.sub(" ", line.upper()).strip()
        # A slash is a line that a switch of the machine leaves out; it is off here.
        left = left.lstrip("/ ")
        if not left or left.startswith("%"):
            continue
        words = [(letter, float(number)) for letter, number in _WORD.findall(left)]
        if strange := _WORD.sub("", left).strip():
            raise state.error(f"{strange!r} is not read; words are a letter and a number, such as X12.5")
        yield words
        if ("M", 2.0) in words or ("M", 30.0) in words:
            return


def _set(state: _State, words: list[tuple[str, float]]) -> Floats | None:
    """Take the words that set something, and return where a move goes to, or None where nothing moves."""
    places: dict[str, float] = {}
    for letter, number in words:
        code = f"{letter}{number:g}"
        if letter in "GM":
            _take(state, code)
        elif letter in "XYZIJKR":
            if letter in places:
                raise state.error(f"{letter} stands twice in the line")
            places[letter] = number
        elif letter not in "FNSTDHPO":
            raise state.error(f"the axis or word {letter} is not read; known are X Y Z I J K R F, and G and M codes")
    # Codes of a line count for all of it, wherever they stand: the unit of F may come after it.
    for letter, number in words:
        if letter == "F":
            if number <= 0.0:
                raise state.error(f"the feed is {number:g}; it must be above 0")
            state.feed = number * state.unit / 60.0
    if not set(places) & set("XYZIJKR"):
        return None
    if state.move is None:
        raise state.error("no move is set: G0, G1, G2 or G3 goes before the first place")
    if set(places) & set("IJKR") and state.move in ("G0", "G1"):
        raise state.error(f"I, J, K and R are of arcs, and {state.move} is set")
    goal = state.place.copy()
    for axis, letter in enumerate("XYZ"):
        if letter in places:
            goal[axis] = places[letter] * state.unit + (0.0 if state.absolute else state.place[axis])
    return goal


def _take(state: _State, code: str) -> None:
    """Take a G or M code."""
    if code in MOVES:
        state.move = code
    elif code in PLANES:
        state.plane = PLANES[code]
    elif code in ("G20", "G21"):
        state.unit = INCH if code == "G20" else 1e-3
    elif code in ("G90", "G91"):
        state.absolute = code == "G90"
    elif code in ("G90.1", "G91.1"):
        state.centres_absolute = code == "G90.1"
    elif code not in IDLE:
        raise state.error(f"{code} is not read; moves are {', '.join(MOVES)}")


def _arc(state: _State, goal: Floats, words: list[tuple[str, float]], chord: float) -> list[Floats]:
    """Return the points of an arc, or of a helix, after its first one."""
    values = {letter: number * state.unit for letter, number in words if letter in "IJKR"}
    if any(letter == "P" for letter, _ in words):
        raise state.error("P, the number of turns of an arc, is not read: write each turn")
    a, b, across = state.plane
    start, end = state.place[[a, b]], goal[[a, b]]
    # Seen against the third axis, G2 goes clockwise.
    sense = -1.0 if state.move == "G2" else 1.0
    if "R" in values:
        centre = _centre(state, start, end, values["R"], sense)
    else:
        given = ["IJK"[a], "IJK"[b]]
        if not set(given) & set(values):
            raise state.error(f"an arc in this plane has a centre ({given[0]}, {given[1]}) or a radius (R)")
        centre = np.array([values.get(one, 0.0) for one in given])
        centre = centre if state.centres_absolute else start + centre
    radius, last = (float(np.linalg.norm(one - centre)) for one in (start, end))
    if not radius or abs(radius - last) > max(5e-6, ARC_MATCH * radius):
        raise state.error(
            f"the ends of the arc are {1e3 * radius:.6g} and {1e3 * last:.6g} mm from its centre; they must be the same"
        )
    begin = math.atan2(*(start - centre)[::-1])
    turn = sense * (math.atan2(*(end - centre)[::-1]) - begin) % (2.0 * math.pi)
    if turn < 1e-9 or np.array_equal(start, end):
        turn = 2.0 * math.pi
    count = max(2, math.ceil(turn / (2.0 * math.acos(max(0.0, 1.0 - chord / radius))) - 1e-9))
    points = []
    for part in np.arange(1, count + 1) / count:
        angle, point = begin + sense * part * turn, np.empty(3)
        point[[a, b]] = centre + radius * np.array([math.cos(angle), math.sin(angle)])
        point[across] = state.place[across] + part * (goal[across] - state.place[across])
        points.append(point)
    points[-1] = goal
    return points


def _centre(state: _State, start: Floats, end: Floats, radius: float, sense: float) -> Floats:
    """Return the centre (2,) of an arc by its radius, below 0 for the one of more than half a turn."""
    half = 0.5 * (end - start)
    size = float(np.linalg.norm(half))
    if not size:
        raise state.error("an arc by its radius needs another end than its beginning; give a whole turn by its centre")
    if size > abs(radius) * (1.0 + ARC_MATCH):
        raise state.error(
            f"the ends of the arc are {2e3 * size:.6g} mm apart, more than twice its radius, {1e3 * abs(radius):.6g} mm"
        )
    rise = math.sqrt(max(0.0, radius * radius - size * size)) / size
    return start + half + sense * math.copysign(rise, radius) * np.array([-half[1], half[0]])
