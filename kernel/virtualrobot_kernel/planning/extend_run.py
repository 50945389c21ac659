"""Extension of a run by one more step, while it may be moving already.

The extended run is the same function of nominal time as the run before it, up to the *cut*: so whoever is not past the
cut goes on without noticing. From the cut on, the corner to the new step is rounded and the time law of the steps that
are left is made anew, from the speed that the run has there; or the new step begins while the last one still brakes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.blend import Rounded, rounded
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.brake import nominal_time
from virtualrobot_kernel.motion.overlap import overlapped, raised, shifted
from virtualrobot_kernel.motion.planned import Track, planned
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial, joined
from virtualrobot_kernel.planning.blend_group import BlendGroup
from virtualrobot_kernel.planning.blending import (
    SLOWEST,
    Part,
    PlannedRun,
    Tail,
    alone_part,
    best_corner,
    fitting_corner,
    obstacle,
    part_overlap,
    shrunk,
    size,
    stretch_through,
)
from virtualrobot_kernel.planning.notes import Note
from virtualrobot_kernel.planning.steps import PlannedStep
from virtualrobot_kernel.planning.zones import Room

Floats = NDArray[np.float64]

_LEVEL = 1e-6
"""Share of the greatest acceleration of a law below which it counts as none."""

_LEVELS, _GRID, _STEPS = 3, 32, 16
"""Number of level moments that are tried, of other moments to choose from, and of steps whose law may be made anew."""

_BEHIND = 0.05
"""Nominal time (s) behind the present one that a run keeps of its past."""

_SHARES, _ROUNDING = (1.0, 0.97, 0.9), 1e-6
"""Shares of the limits that an overlap is tried with, and excess that is none."""


@dataclass(frozen=True, slots=True, eq=False)
class Extension:
    """Run with one more step, the nominal time (s) up to which it is the run before, and what became of the zone."""

    run: PlannedRun
    cut: float
    notes: tuple[Note, ...]


def extended(run: PlannedRun, step: PlannedStep, now: float, reached: float) -> Extension | str:
    """Return a run with a step joined to its end, by a cut after nominal time `now` (s); or why there is none.

    reached: the nominal time (s) at which it is already; what lies behind is left out.
    """
    tail = run.tail
    if tail is None:
        return "it has been planned as an end"
    pair = (tail.steps[-1], step)
    if why := obstacle(pair):
        return why
    group = BlendGroup([*tail.steps, step], run.joints)
    alone = [alone_part(group.track(one)) for one in pair]
    corner, why = best_corner(group, pair, alone)
    if corner is None:
        return why
    track = _widened(_kept(run.plan.tracks[0], reached - _BEHIND), group, step)
    found = _through(group, run, tail, track, step, alone[1], corner.room, now) if corner.through else None
    if found is None and not corner.room.fades:
        found = _overlapping(group, run, tail, track, step, alone[1], corner.room, now)
    if found is None:
        return f"the motion is too near to the end of step {pair[0].name} to go through its zone"
    longer = found.run.plan.duration - run.plan.duration
    if corner.room.fades and longer > SLOWEST * sum(one.plan.duration for one in pair):
        return f"the parabola would take {longer:.3g} s longer"
    notes = (shrunk(pair[0], corner.room),) if corner.room.kept < size(pair[0]) else ()
    return replace(found, notes=notes)


def _kept(track: Track, begin: float) -> Track:
    """Return what a track does from a nominal time on, at that time."""
    law = track.time_law
    if not law.start < begin < law.end:
        return track
    u = law.scalar_state(begin)[0]
    if not track.path.start < u < track.path.end:
        return track
    return Track(track.path.between(u, track.path.end), law.between(begin, law.end))


def _widened(track: Track, group: BlendGroup, step: PlannedStep) -> Track:
    """Return a track for all columns of a group: those that it has not stand where the step finds them."""
    path = track.path
    still = step.snapshot.state.q[group.q_index[path.dimension :]]
    coefficients = np.zeros((*path.coefficients.shape[:2], len(still)))
    coefficients[:, 0] = still
    return Track(PiecewisePolynomial(path.breaks, np.concatenate([path.coefficients, coefficients], axis=2)),
                 track.time_law)  # fmt: skip


def _level_times(law: PiecewisePolynomial) -> Floats:
    """Return the nominal times (m,), in order, at which a law gets neither faster nor slower, but for its end."""
    slope, jerk = 2.0 * law.coefficients[:, 2, 0], 6.0 * law.coefficients[:, 3, 0]
    seconds = np.diff(law.breaks)
    small = _LEVEL * max(float(np.abs(slope).max()), float(np.abs(slope + jerk * seconds).max()))
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = -slope / jerk
    inside = (crossing > 0.0) & (crossing < seconds) & (np.abs(slope) > small)
    times = np.concatenate([law.breaks[:-1][np.abs(slope) <= small], law.breaks[:-1][inside] + crossing[inside]])
    return np.sort(times[times < law.end - _LEVEL * (law.end - law.start)])


def _levelled(law: PiecewisePolynomial, cut: float) -> PiecewisePolynomial:
    """Return a law up to a cut, and on until it gets neither faster nor slower, with the most jerk that it has."""
    if cut <= law.start:
        return PiecewisePolynomial(np.array([cut, cut]), law.coefficients[:1, :1])
    u, speed, slope = law.scalar_state(cut)
    jerk = math.copysign(6.0 * float(np.abs(law.coefficients[:, 3, 0]).max()), -slope)
    parts = [law.between(law.start, cut)]
    if abs(slope) > _LEVEL * abs(jerk):
        piece = np.array([[[u], [speed], [0.5 * slope], [jerk / 6.0]]])
        parts.append(PiecewisePolynomial(np.array([cut, cut - slope / jerk]), piece))
    return joined(parts)


def _through(
    group: BlendGroup, run: PlannedRun, tail: Tail, track: Track, step: PlannedStep, after: Part, room: Room, now: float
) -> Extension | None:
    """Return the run with a rounded corner to a step, its law made anew from a cut after `now`.

    Best is the earliest moment at which the law is level: then nothing is lost. Where it is too late for that, the law
    is left as late as can be.
    """
    law = track.time_law

    def by(cut: float) -> Extension | None:
        return _rounded_from(group, run, tail, Track(track.path, _levelled(law, cut)), step, after, room, cut)

    if step.law is TimeLaw.TIME_OPTIMAL:  # which begins at rest only
        return by(law.start) if now <= law.start else None
    if law.coefficients.shape[1] != 4:
        return None
    level = _level_times(law)
    for cut in level[level >= now][:_LEVELS].tolist():
        if found := by(cut):
            return found
    begin = max(now, law.start)
    found, low, high = None, 0, _GRID if begin < law.end else 0
    while low < high:
        middle = (low + high) // 2
        later = by(begin + (law.end - begin) * middle / _GRID)
        found, low, high = (later, middle + 1, high) if later else (found, low, middle)
    return found


def _rounded_from(
    group: BlendGroup,
    run: PlannedRun,
    tail: Tail,
    track: Track,
    step: PlannedStep,
    after: Part,
    room: Room,
    cut: float,
) -> Extension | None:
    """Return the run made anew from where a track has got to by its law, which is the run's up to a cut."""
    path, law, begin = track.path, track.time_law, track.time_law.end
    u, speed, _ = law.scalar_state(begin)
    tolerance = 1e-9 * (path.end - path.start)
    places = [k for k, (first, end) in enumerate(tail.sections) if first - tolerance <= u < end - tolerance]
    if not places or speed < 0.0:
        return None
    place = places[0]
    if begin > cut and not group.keeps_limits(tail.steps[place], path, law, cut):
        return None
    rest = path.between(u, path.end).onto(0.0, path.end - u)
    steps = [*tail.steps[place:], step]
    sections = [(max(first, u) - u, end - u) for first, end in tail.sections[place:]]
    last = after.track.path.onto(0.0, after.track.time_law.end)
    found = fitting_corner(group, rest, last, room, tail.reach, sections[-1][1] - sections[-1][0])
    if found is None:
        return None
    corner, last = found
    whole = rounded([rest, last], [corner])
    moves = (*sections[:-1], (sections[-1][0], whole.moves[0][1]), whole.moves[1])
    corners = tuple((before[1], following[0]) for before, following in pairwise(moves))
    whole = Rounded(whole.path, moves, corners)
    try:
        anew = group.track_through(steps, whole, speed).time_law
    except KernelError:
        return None
    path_now, law_now = shifted(whole.path, u), shifted(raised(anew, u), begin)
    if begin > law.start:
        path_now, law_now = joined([path.between(path.start, u), path_now]), joined([law, law_now])
    begins = [begin + nominal_time(anew, 0.5 * sum(corner), 0.0) for corner in corners]
    first = tail.steps[place].number
    kept = tuple(one for one in run.steps if one[1] <= first)
    entered = tuple(
        (begin + nominal_time(anew, corner[0], 0.0), one.number) for corner, one in zip(corners, steps, strict=False)
    )
    zones = (*(one for one in run.zones if one[1] < first), *entered)
    times = (*kept, *((time, one.number) for time, one in zip(begins, steps[1:], strict=True)))
    ends = Tail(tuple(steps), tuple((first + u, end + u) for first, end in moves), last.end)
    return _extension(group, run, Track(path_now, law_now), (times, zones), ends, cut)


def _overlapping(
    group: BlendGroup, run: PlannedRun, tail: Tail, track: Track, step: PlannedStep, after: Part, room: Room, now: float
) -> Extension | None:
    """Return the run with a step that begins while the run still brakes."""
    law, pair = track.time_law, (tail.steps[-1], step)
    before = Part(track, (tail.reach, tail.reach), ())
    for share in _SHARES:
        one = part_overlap(group, pair, before, after, room, law.end - max(now, law.start), share)
        if one is None:
            continue
        whole, ((begin, end),) = overlapped([track, after.track], [one])
        if stretch_through(group, whole, pair, (begin, end)) > 1.0 + _ROUNDING:
            continue
        first = whole.time_law.scalar_state(end)[0]
        ends = Tail((step,), ((first, whole.path.end),), after.track.time_law.end)
        times = (*run.steps, (law.start + 0.5 * (begin + end), step.number))
        zones = (*run.zones, (law.start + begin, pair[0].number))
        whole = Track(whole.path, shifted(whole.time_law, law.start))
        return _extension(group, run, whole, (times, zones), ends, law.end - one.leave)
    return None


def _extension(
    group: BlendGroup,
    run: PlannedRun,
    track: Track,
    times: tuple[tuple[tuple[float, int], ...], tuple[tuple[float, int], ...]],
    tail: Tail,
    cut: float,
) -> Extension:
    """Return the longer run; `times` are those of its steps and of its zones."""
    last = tail.steps[-1]
    goal = last.arrived().state.q[group.q_index]
    tool_states = (*run.tool_states, *(pair for one in last.moves for pair in one.tool_states))
    plan = planned("blend", track.path, track.time_law, group.limits, goal)
    tail = Tail(tail.steps[-_STEPS:], tail.sections[-_STEPS:], tail.reach)
    steps, zones = times
    return Extension(PlannedRun(tuple(group.columns), plan, steps, tool_states, tail, zones=zones), cut, ())
