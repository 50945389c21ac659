"""Blending: planned steps that zones join become one path with one time law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.apart_path import ApartTcp
from virtualrobot_kernel.motion.blend import Corner, round_corner, rounded
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.brake import nominal_time
from virtualrobot_kernel.motion.limits import TOLERANCE
from virtualrobot_kernel.motion.overlap import Overlap, overlap, overlapped
from virtualrobot_kernel.motion.planned import Plan, Track, planned
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.rates import stretch_needed, tcp_rate_once
from virtualrobot_kernel.motion.superposed import superposed
from virtualrobot_kernel.planning.blend_group import BlendGroup
from virtualrobot_kernel.planning.notes import Note, NoteKind
from virtualrobot_kernel.planning.steps import Column, GoOn, PlannedStep
from virtualrobot_kernel.planning.zones import Room, room_for
from virtualrobot_kernel.world.groups import Group

Floats = NDArray[np.float64]
_LOOKS = 33
"""Number of places of a corner in which tool centre points and joints are checked."""

_SCALE = 30.0
"""Greatest factor between the parameter of a path and the time that its move takes."""

_SMALLER = 0.8 ** np.arange(8.0)
"""Shares of the room that a rounded corner is tried with, in order."""

SLOWEST = 2.0
"""Factor by which moves with parabolas may take longer than with stops, as they do near singular postures."""

_ROUNDING = 1e-6

_UNFIT = "no way through the zone was found that goes together with those beside it"

_POWERS = np.array([1.0, 1.0 / 2.0, 1.0 / 3.0])
"""Exponents by which ratios of velocity, acceleration and jerk to their limits become the stretch in time they need."""


@dataclass(frozen=True, slots=True, eq=False)
class PlannedRun:
    """Move steps that became one plan, at rest at both ends.

    joints: (robot, joint) of each column. steps: nominal times (s) at which steps begin, with their numbers; a step
    after a zone begins in the zone's middle. tool_states: (tool, state) that are true at its end. tail: where a step
    may be joined to its end; None where none may. leads: of signals that are set before their step, when that is (s),
    the step's number, and how long before. zones: nominal times at which zones are entered, with the numbers of the
    steps whose ends they are at.
    """

    joints: tuple[Column, ...]
    plan: Plan
    steps: tuple[tuple[float, int], ...]
    tool_states: tuple[tuple[str, str], ...]
    tail: Tail | None = None
    leads: tuple[tuple[float, int, float], ...] = ()
    zones: tuple[tuple[float, int], ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Tail:
    """Last steps of a run, between which corners are rounded, and where on its path each goes alone.

    reach: how long the whole path of the last step is on the run's parameter.
    """

    steps: tuple[PlannedStep, ...]
    sections: tuple[tuple[float, float], ...]
    reach: float


def join_steps(steps: Sequence[PlannedStep], go_on: GoOn = lambda: None) -> tuple[list[PlannedRun], list[Note]]:
    """Return the plans of consecutive planned steps, one after the other, and what became of their zones.

    Steps that are joined by zones become one plan; where two can't be joined, or would be slower so than with a stop in
    between, the corner is reached exactly and at rest, which a note tells.
    """
    notes = [
        replace(note, step=step.number, step_path=step.name)
        for step in steps
        for one in step.moves
        for note in one.notes
    ]
    runs: list[PlannedRun] = []
    group: list[PlannedStep] = []
    for place, step in enumerate(steps):
        group.append(step)
        if step.zone is not None and not (why := obstacle(steps[place : place + 2])):
            continue
        if step.zone is not None:
            notes.append(dropped(step, why))
        found, told = _group(group, go_on)
        runs, notes, group = [*runs, *found], [*notes, *told], []
    return runs, sorted(notes, key=lambda note: note.step)


def obstacle(pair: Sequence[PlannedStep]) -> str:
    """Return why a step is not joined with the one after it; nothing where it is."""
    if len(pair) < 2:
        return "no moves follow"
    for step in pair:
        if step.obstacle:
            return f"step {step.name} can't be joined: {step.obstacle}"
    before, after = map(_tools, pair)
    if any(before[arm] != after[arm] for arm in before.keys() & after.keys()):
        return f"steps {pair[0].name} and {pair[1].name} have different tools"
    if pair[0].law is not pair[1].law:
        return f"steps {pair[0].name} and {pair[1].name} have different time laws"
    return ""


def _tools(step: PlannedStep) -> dict[tuple[int, Group], tuple[str, str]]:
    """Return the names of the tools by which arms are led, by robot (uid) and group; of a tool of their own none."""
    return {
        (one.robot.uid, one.group): one.tcp.tcp.name if isinstance(one.tcp.tcp, ApartTcp) else ("", "")
        for one in step.moves
        if one.tcp
    }


def dropped(step: PlannedStep, why: str) -> Note:
    """Return the note that the corner after a step is reached at rest."""
    message = f"the corner after step {step.name} is reached exactly and at rest: {why}"
    return Note(NoteKind.ZONE_DROPPED, step.number, step.moves[0].robot.name, size(step), 0.0, message, step.name)


def shrunk(step: PlannedStep, room: Room) -> Note:
    """Return the note that the zone after a step is smaller than it was asked for."""
    assert step.zone is not None
    wanted, unit = size(step), "%" if step.zone.percent else " m"
    message = f"the zone after step {step.name} is {room.kept:.6g}{unit} instead of {wanted:g}{unit}: {room.why}"
    return Note(NoteKind.ZONE_SHRUNK, step.number, step.moves[0].robot.name, wanted, room.kept, message, step.name)


def size(step: PlannedStep) -> float:
    """Return the size of the zone after a step: percent, or meters."""
    assert step.zone is not None
    return step.zone.percent or step.zone.meters


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Steps that are one path with rounded corners, and its law from rest to rest.

    ends: how long the paths of the first and of the last step are on its parameter. sections: where on it each step
    goes alone. begins: when the steps after the first begin, in s; enters: when the zones before them are entered.
    """

    track: Track
    ends: tuple[float, float]
    sections: tuple[tuple[float, float], ...]
    begins: tuple[float, ...] = ()
    enters: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class _Corner:
    """Corner between two steps that can be gone over: its room, and whether the steps are one path through it."""

    room: Room
    through: bool


def _group(steps: Sequence[PlannedStep], go_on: GoOn) -> tuple[list[PlannedRun], list[Note]]:
    """Return the plans of steps that shall be joined, and what became of their zones."""
    if len(steps) == 1:
        return [alone_run(steps[0])], []
    group = BlendGroup(steps)
    alone = [alone_part(group.track(step)) for step in steps]
    notes: list[Note] = []
    corners: list[_Corner] = []
    runs: list[PlannedRun] = []
    begin = 0
    for place, pair in enumerate(pairwise(steps)):
        go_on()
        corner, why = best_corner(group, pair, alone[place : place + 2])
        if corner:
            corners.append(corner)
            if corner.room.kept < size(steps[place]):
                notes.append(shrunk(steps[place], corner.room))
            continue
        notes.append(dropped(steps[place], why))
        found, told = _joined(group, steps[begin : place + 1], alone[begin : place + 1], corners, go_on)
        runs, notes, corners, begin = [*runs, *found], [*notes, *told], [], place + 1
    found, told = _joined(group, steps[begin:], alone[begin:], corners, go_on)
    stops = {note.step for note in told if note.kind is NoteKind.ZONE_DROPPED}
    return [*runs, *found], [note for note in notes if note.step not in stops] + told


def alone_run(step: PlannedStep) -> PlannedRun:
    """Return a step that is joined with no other; where robots go along with others, all moves have one time law."""
    if any(one.relative_tcp for one in step.moves):
        group = BlendGroup([step])
        return _run(group, [step], [alone_part(group.track(step))], [], [])
    tool_states = tuple(pair for one in step.moves for pair in one.tool_states)
    tail = None
    if len(step.plan.tracks) == 1:
        path = step.plan.tracks[0].path
        tail = Tail((step,), ((path.start, path.end),), path.end - path.start)
    return PlannedRun(tuple(step.columns), step.plan, ((0.0, step.number),), tool_states, tail)


def open_run(run: PlannedRun, step: PlannedStep) -> PlannedRun:
    """Return a run so that more can be joined to its last step: moves that go together get one law."""
    if run.tail is not None or step.obstacle:
        return run
    group = BlendGroup([step])
    return _run(group, [step], [alone_part(group.track(step))], [], [])


def best_corner(group: BlendGroup, pair: Sequence[PlannedStep], alone: Sequence[Part]) -> tuple[_Corner | None, str]:
    """Return the soonest way through the zone between two steps; without one why there is none."""
    zone = pair[0].zone
    assert zone is not None
    first, second = alone
    leds = group.leds(pair) if zone.parabola else {}
    if not leds:  # no tool centre point has a way on both sides whose sum could be asked for
        zone = replace(zone, parabola=False)
    room = room_for(zone, first.track.path, second.track.path, group.positions(pair, leds))
    if not room.kept:
        return None, room.why
    if room.fades:
        room = replace(room, leds=tuple(leds.values()))
        before, after = (part.track.path.onto(0.0, part.track.time_law.end) for part in alone)
        if fitting_corner(group, before, after, room):
            return _Corner(room, True), ""
        return None, "no parabola through the zone keeps every limit"
    stopping = sum(step.plan.duration for step in pair)
    beside = part_overlap(group, pair, first, second, room)
    over = first.track.time_law.end + second.track.time_law.end - beside.saved if beside else inf
    through = _rounded(group, pair, alone, [room])
    if through and through.track.time_law.end < min(over, stopping):
        return _Corner(room, True), ""
    if over < stopping:
        return _Corner(room, False), ""
    return None, "no way through the zone was found that is sooner and keeps every limit"


def _joined(
    group: BlendGroup, steps: Sequence[PlannedStep], alone: Sequence[Part], corners: Sequence[_Corner], go_on: GoOn
) -> tuple[list[PlannedRun], list[Note]]:
    """Return the plans of steps with a way through each corner; where these don't go together one is left out."""
    go_on()
    if len(steps) == 1:
        return [alone_run(steps[0])], []
    cuts = [place + 1 for place, corner in enumerate(corners) if not corner.through]
    rooms = [corner.room for corner in corners]
    parts: list[Part] = []
    overlaps: list[Overlap] = []
    unfit = None
    for begin, end in pairwise([0, *cuts, len(steps)]):
        part = _rounded(group, steps[begin:end], alone[begin:end], rooms[begin : end - 1])
        if part is None:
            unfit = end - 2
            break
        if parts:
            beside = part_overlap(group, steps[begin - 1 : begin + 1], parts[-1], part, rooms[begin - 1])
            if beside is None:
                unfit = begin - 1
                break
            overlaps.append(beside)
        parts.append(part)
    if unfit is None:
        run = _run(group, steps, parts, overlaps, cuts)
        stopping = sum(step.plan.duration for step in steps)
        if run.plan.duration < stopping * (SLOWEST if any(room.fades for room in rooms) else 1.0):
            return [run], []
        unfit = len(corners) // 2
    first, told = _joined(group, steps[: unfit + 1], alone[: unfit + 1], corners[:unfit], go_on)
    second, more = _joined(group, steps[unfit + 1 :], alone[unfit + 1 :], corners[unfit + 1 :], go_on)
    return [*first, *second], [*told, dropped(steps[unfit], _UNFIT), *more]


def alone_part(track: Track) -> Part:
    """Return the part that is one step."""
    length = track.path.end - track.path.start
    return Part(track, (length, length), ((track.path.start, track.path.end),))


def _rounded(
    group: BlendGroup, steps: Sequence[PlannedStep], alone: Sequence[Part], rooms: Sequence[Room]
) -> Part | None:
    """Return steps as one path with rounded corners; None when a corner finds no way or no law does."""
    if len(steps) == 1:
        return alone[0]
    paths = [alone[0].track.path.onto(0.0, alone[0].track.time_law.end)]
    corners: list[Corner] = []
    for part, room in zip(alone[1:], rooms, strict=True):
        found = fitting_corner(group, paths[-1], part.track.path.onto(0.0, part.track.time_law.end), room)
        if found is None:
            return None
        corners.append(found[0])
        paths.append(found[1])
    whole = rounded(paths, corners)
    try:
        track = group.track_through(steps, whole)
    except KernelError:
        return None
    begins = tuple(nominal_time(track.time_law, 0.5 * (begin + end), 0.0) for begin, end in whole.corners)
    enters = tuple(nominal_time(track.time_law, begin, 0.0) for begin, _ in whole.corners)
    return Part(track, (paths[0].end, paths[-1].end), whole.moves, begins, enters)


def fitting_corner(
    group: BlendGroup,
    before: PiecewisePolynomial,
    after: PiecewisePolynomial,
    room: Room,
    length: float | None = None,
    most: float = inf,
) -> tuple[Corner, PiecewisePolynomial] | None:
    """Return a rounded corner that fits, and the path after it with a parameter that suits it.

    length: how long the path of the step before the corner is, where `before` is more, or less; most: how much of its
    end may be taken.

    What the zone takes of both paths gets the same length: so the tool centre point enters and leaves a distance's zone
    at the same speed, whatever the moves' own speeds are; the parameter changes at most by `_SCALE`.
    """
    if room.fades:
        return _parabola(group, before, after, room, length or before.end, most)
    for smaller in _SMALLER:
        left, share = smaller * room.shares[0] * (length or before.end), smaller * room.shares[1]
        if left >= most:
            continue
        seconds = float(np.clip(left / share, after.end / _SCALE, after.end * _SCALE))
        changed = after.onto(0.0, seconds)
        corner = round_corner(before, changed, left, share * seconds)
        if _stays(group, corner.piece, room):
            return corner, changed
    return None


def _parabola(
    group: BlendGroup,
    before: PiecewisePolynomial,
    after: PiecewisePolynomial,
    room: Room,
    length: float,
    most: float,
) -> tuple[Corner, PiecewisePolynomial] | None:
    """Return what `fitting_corner` does for a parabola, which has one size and is one curve at any scale."""
    assert room.fades is not None
    left = room.shares[0] * length
    if left >= most:
        return None
    changed = after.onto(0.0, left / room.shares[1])
    if not room.made:
        scale = left / max(fade.reach for fade in room.fades)
        place, turn = (fade.scaled(scale) for fade in room.fades)
        piece = superposed(before, changed, left, place, turn, room.leds)
        room.made.append(piece if piece is not None and _stays(group, piece, room) else None)
    (found,) = room.made
    return (Corner(left, left, found.onto(0.0, 2.0 * left)), changed) if found else None


def _stays(group: BlendGroup, piece: PiecewisePolynomial, room: Room) -> bool:
    """Return True if joints, actuators and tool centre points keep limits and zone on a corner's piece."""
    if piece.first_excursion(group.limits.lower, group.limits.upper, TOLERANCE) is not None:
        return False
    if not group.keeps_actuators(piece):
        return False
    return room.holds(piece.evaluate(np.linspace(piece.start, piece.end, _LOOKS)))


def part_overlap(
    group: BlendGroup,
    pair: Sequence[PlannedStep],
    before: Part,
    after: Part,
    room: Room,
    most: float = inf,
    used: float = 1.0,
) -> Overlap | None:
    """Return the overlap of a part's last step and the first of the next one within a zone; None without one.

    most: how long before its end (s) the part may be left; used: the share of the joints' limits that is used.
    """
    path, law = before.track.path, before.track.time_law
    leave = min(most, law.end - nominal_time(law, path.end - room.shares[0] * before.ends[1], law.start))
    if leave <= 0.0:
        return None
    path, law = after.track.path, after.track.time_law
    join = nominal_time(law, path.start + room.shares[1] * after.ends[0], 0.0)
    led, optimal = group.cartesian_through(pair), pair[0].law is TimeLaw.TIME_OPTIMAL

    def fits(quintic: PiecewisePolynomial) -> bool:
        if not _stays(group, quintic, room):
            return False
        # The parameter of a quintic is time: its law is the identity.
        law = PiecewisePolynomial(np.array([0.0, quintic.end]), np.array([[[0.0], [1.0]]]))
        rates = [tcp_rate_once(quintic, replace(bound, begin=0.0, end=quintic.end)) for bound in led]
        needed = stretch_needed(rates, law, np.linspace(0.0, quintic.end, _LOOKS))
        return bool(np.all((needed[:2] if optimal else needed) <= 1.0 + _ROUNDING))

    return overlap(before.track, after.track, leave, join, used * group.corner_limits(pair), fits)


def _run(
    group: BlendGroup,
    steps: Sequence[PlannedStep],
    parts: Sequence[Part],
    overlaps: Sequence[Overlap],
    cuts: Sequence[int],
) -> PlannedRun:
    """Return steps as one plan, whose parts, cut before the steps `cuts`, overlap.

    A step begins in the middle of its corner or overlap.
    """
    track, windows = overlapped([part.track for part in parts], overlaps)
    need = 1.0
    for cut, window in zip(cuts, windows, strict=True):
        need = max(need, stretch_through(group, track, steps[cut - 1 : cut + 1], window))
    times, enters = [0.0, *parts[0].begins], [*parts[0].enters]
    for part, one, (begin, end) in zip(parts[1:], overlaps, windows, strict=True):
        times += [0.5 * (begin + end), *(end - one.join + time for time in part.begins)]
        enters += [begin, *(end - one.join + time for time in part.enters)]
    arrival = steps[-1].arrived()
    law = track.time_law.stretched(need * track.time_law.end)
    plan = planned("blend", track.path, law, group.limits, arrival.state.q[group.q_index])
    numbered = tuple((need * time, step.number) for time, step in zip(times, steps, strict=True))
    zones = tuple((need * time, step.number) for time, step in zip(enters, steps, strict=False))
    tool_states = tuple(pair for step in steps for one in step.moves for pair in one.tool_states)
    last, path = parts[-1], track.path
    scale = last.track.time_law.end / (last.track.path.end - last.track.path.start)
    since = track.time_law.scalar_state(windows[-1][1])[0] if windows else path.start
    places = [[max(since, path.end - scale * (last.track.path.end - u)) for u in one] for one in last.sections]
    tail = Tail(tuple(steps[-len(places) :]), tuple((begin, end) for begin, end in places), scale * last.ends[1])
    return PlannedRun(tuple(group.columns), plan, numbered, tool_states, tail, zones=zones)


def stretch_through(group: BlendGroup, track: Track, pair: Sequence[PlannedStep], window: tuple[float, float]) -> float:
    """Return by what factor in time a track has to be slower to keep the limits between two steps in a window (s)."""
    peaks = np.abs(track.derivatives(np.linspace(*window, 12 * _LOOKS))[1:]).max(axis=1)
    return float(((peaks / group.corner_limits(pair)).max(axis=1) ** _POWERS).max())
