"""Extension of a run by one more step, while it may be moving already.

The extended run is the same function of nominal time as the run before it, up to the *cut*: so whoever is not past the
cut goes on without noticing. From the cut on, the corner to the new step is rounded and the time law of the steps that
are left is made anew, from the speed that the run has there; or the new step begins while the last one still brakes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.blend import Rounded, rounded
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.brake import nominal_time
from virtualrobot_kernel.motion.overlap import overlapped, raised, shifted
from virtualrobot_kernel.motion.planned import Track, planned
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial, joined
from virtualrobot_kernel.planning.blend_group import BlendGroup
from virtualrobot_kernel.planning.blending import (
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

_LEVEL = 1e-6
"""Share of the greatest acceleration of a law below which it counts as none."""

_CUTS, _STEPS = 3, 16
"""Number of cuts that are tried, and of the last steps whose law may be made anew."""

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
    found = found or _overlapping(group, run, tail, track, step, alone[1], corner.room, now)
    if found is None:
        return f"the motion is too near to the end of step {pair[0].number} to go through its zone"
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


def _level_times(law: PiecewisePolynomial) -> np.ndarray:
    """Return the nominal times (m,), in order, at which a law neither gets faster nor slower."""
    slope, jerk = 2.0 * law.coefficients[:, 2, 0], 6.0 * law.coefficients[:, 3, 0]
    seconds = np.diff(law.breaks)
    most = max(float(np.abs(slope).max()), float(np.abs(slope + jerk * seconds).max()))
    at_breaks = law.breaks[:-1][np.abs(slope) <= _LEVEL * most]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = -slope / jerk
    inside = (crossing > 0.0) & (crossing < seconds) & (np.abs(slope) > _LEVEL * most)
    return np.sort(np.concatenate([at_breaks, law.breaks[:-1][inside] + crossing[inside]]))


def _through(
    group: BlendGroup, run: PlannedRun, tail: Tail, track: Track, step: PlannedStep, after: Part, room: Room, now: float
) -> Extension | None:
    """Return the run with a rounded corner to a step, its law made anew from the earliest cut that can be."""
    law, path = track.time_law, track.path
    if law.coefficients.shape[1] != 4:
        return None
    tolerance = 1e-9 * (path.end - path.start)
    tried = 0
    for cut in _level_times(law):
        u, speed, _ = law.scalar_state(float(cut))
        places = [k for k, (begin, end) in enumerate(tail.sections) if begin - tolerance <= u < end - tolerance]
        if cut < now or not places or (speed > 0.0 and step.law is TimeLaw.TIME_OPTIMAL):
            continue
        found = _rounded_from(group, run, tail, track, step, after, room, places[0], (float(cut), u, speed))
        tried += 1
        if found is not None or tried == _CUTS:
            return found
    return None


def _rounded_from(
    group: BlendGroup,
    run: PlannedRun,
    tail: Tail,
    track: Track,
    step: PlannedStep,
    after: Part,
    room: Room,
    place: int,
    state: tuple[float, float, float],
) -> Extension | None:
    """Return the run made anew from a cut (nominal time, path parameter, its rate) in the section at `place`."""
    cut, u, speed = state
    path, law = track.path, track.time_law
    rest = path.between(u, path.end).onto(0.0, path.end - u)
    steps = [*tail.steps[place:], step]
    sections = [(max(begin, u) - u, end - u) for begin, end in tail.sections[place:]]
    last = after.track.path.onto(0.0, after.track.time_law.end)
    found = fitting_corner(group, rest, last, room, tail.reach, sections[-1][1] - sections[-1][0])
    if found is None:
        return None
    corner, last = found
    whole = rounded([rest, last], [corner])
    moves = (*sections[:-1], (sections[-1][0], whole.moves[0][1]), whole.moves[1])
    corners = tuple((before[1], after[0]) for before, after in pairwise(moves))
    whole = Rounded(whole.path, moves, corners)
    try:
        anew = group.track_through(steps, whole, speed).time_law
    except KernelError:
        return None
    path_now, law_now = shifted(whole.path, u), shifted(raised(anew, u), cut)
    if cut > law.start:
        path_now, law_now = joined([path.between(path.start, u), path_now]), joined([law.between(law.start, cut), law_now])
    begins = [cut + nominal_time(anew, 0.5 * (begin + end), 0.0) for begin, end in corners]
    first = tail.steps[place].number
    times = (*(one for one in run.steps if one[1] <= first),
             *((time, one.number) for time, one in zip(begins, steps[1:], strict=True)))  # fmt: skip
    ends = Tail(tuple(steps), tuple((begin + u, end + u) for begin, end in moves), last.end)
    return _extension(group, run, Track(path_now, law_now), times, ends, cut)


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
        whole = Track(whole.path, shifted(whole.time_law, law.start))
        return _extension(group, run, whole, times, ends, law.end - one.leave)
    return None


def _extension(
    group: BlendGroup, run: PlannedRun, track: Track, times: Sequence[tuple[float, int]], tail: Tail, cut: float
) -> Extension:
    last = tail.steps[-1]
    goal = last.arrived().state.q[group.q_index]
    tool_states = (*run.tool_states, *(pair for one in last.moves for pair in one.tool_states))
    plan = planned("blend", track.path, track.time_law, group.limits, goal)
    tail = Tail(tail.steps[-_STEPS:], tail.sections[-_STEPS:], tail.reach)
    return Extension(PlannedRun(tuple(group.columns), plan, tuple(times), tool_states, tail), cut, ())
