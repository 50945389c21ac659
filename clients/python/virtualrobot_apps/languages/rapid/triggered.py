"""Moves on whose way something is done: made in pieces, whose joints have zones so small that the tool doesn't slow.

What is done at a place is done in the middle of such a zone, which the kernel passes at the tick.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from virtualrobot.geometry import Matrix, pose_between

from virtualrobot_apps.languages.core.zones import Zone
from virtualrobot_apps.languages.rapid.arcs import Arc
from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.frames import matrix_of
from virtualrobot_apps.languages.rapid.world import corner

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask

ZONE = 1e-3
"""Radius (m) of the zone between two pieces, where these are long enough."""
FLAT = 2e-5
"""Distance (m) of an arc's middle from its chord below which it is made as a line; the kernel refuses half of it."""
SAME = 1e-4
"""Distance (m) of places that are one."""
PLACES = 16
"""Number of pieces in which the way of a joint move is measured."""


@dataclass(frozen=True, slots=True)
class Trigger:
    """Something that is done on a way.

    Attributes:
        distance: where, before the end of the way or behind its start (mm).
        from_start: whether it counts from the start.
        lead: how much earlier (s); where it is below 0 later, at the programmed speed.
        delay: how much later (s) by the clock.
        signal: the signal that is set; None: an interrupt comes.
        value: the value that it gets, or the number of the interrupt.
        inhibit: list and index of the flag that, when the place is passed, makes the value 0, or no interrupt come.
    """

    distance: float
    from_start: bool
    lead: float
    delay: float
    signal: str | None
    value: float
    inhibit: tuple[list[Any], int] | None = None


def _places(triggers: list[Trigger], length: float, speed: float) -> list[tuple[float, list[Trigger]]]:
    """Return the places (m from the start) of a way of a length, in their order, with what is done there."""
    found: list[tuple[float, list[Trigger]]] = []
    for one in triggers:
        place = one.distance / 1000.0 if one.from_start else length - one.distance / 1000.0
        place = min(length, max(0.0, place + max(0.0, -one.lead) * speed))
        near = next((others for other, others in found if abs(other - place) < SAME), None)
        if near is None:
            found.append((place, [one]))
        else:
            near.append(one)
    return sorted(found, key=lambda one: one[0])


def _do(task: RapidTask, triggers: list[Trigger]) -> None:
    world = task.world
    for one in triggers:
        lead = max(0.0, one.lead)
        if one.signal is None or one.delay > 0.0 or one.inhibit is not None:
            world.queue.call_at(partial(_passed, task, one), lead)
        else:
            world.set_signal(one.signal, one.value, lead)


def _passed(task: RapidTask, one: Trigger) -> None:
    """Do what a trigger describes, unless its flag inhibits it now."""
    inhibited = one.inhibit is not None and one.inhibit[0][one.inhibit[1]]
    if one.signal is not None:
        task.world.start_later([(one.delay, one.signal, 0.0 if inhibited else one.value)])
    elif not inhibited:
        task.interrupts.order(one.value)


def _go(
    task: RapidTask, triggers: list[Trigger], length: float, speed: float, last: Zone, piece: Callable[..., None]
) -> None:
    """Make a way in pieces: `piece` gets the shares at which one begins and ends and its zone."""
    at = 0.0
    places = _places(triggers, length, speed)
    inner = [(place, what) for place, what in places if SAME < place < length - SAME]
    _do(task, [one for place, what in places if place <= SAME for one in what])
    ends = [place for place, _ in inner]
    room = min((b - a for a, b in pairwise([0.0, *ends, length])), default=length)
    with task.world.together():
        for place, what in inner:
            piece(at / length, place / length, min(ZONE, room / 3.0))
            _do(task, what)
            at = place
        piece(at / length if length > 0.0 else 0.0, 1.0, last)
        _do(task, [one for place, what in places if place > SAME and place >= length - SAME for one in what])


def line(
    task: RapidTask,
    target: list[Any],
    speed: list[float],
    triggers: list[Trigger],
    zone: list[Any],
    wobj: list[Any] | None,
) -> None:
    """Move along a line."""
    world = task.world
    world.keep_axes(target)
    start, end = world.place_now(), world.frame(wobj) @ matrix_of(target)
    velocity = world.velocity(end, speed, None)
    length = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))

    def piece(_: float, share: float, radius: Zone) -> None:
        world.add_line(end if share >= 1.0 else pose_between(start, end, share), velocity, radius)

    _go(task, triggers, length, velocity, corner(zone, velocity), piece)
    world.arrived(end, target)


def arc(
    task: RapidTask,
    via: list[Any],
    target: list[Any],
    speed: list[float],
    triggers: list[Trigger],
    zone: list[Any],
    wobj: list[Any] | None,
) -> None:
    """Move along an arc."""
    world = task.world
    world.keep_axes(target)
    start, end = world.place_now(), world.frame(wobj) @ matrix_of(target)
    point = (world.frame(wobj) @ matrix_of(via))[:3, 3]
    velocity = world.velocity(end, speed, point)
    try:
        way = Arc(start[:3, 3], point, end[:3, 3])
    except ValueError as error:
        raise RapidFault("ERR_ROBLIMIT", str(error)) from error

    def pose(share: float) -> Matrix:
        if share >= 1.0:
            return end
        found = pose_between(start, end, share)
        found[:3, 3] = way.point(share)
        return found

    def piece(begin: float, share: float, radius: Zone) -> None:
        first, middle, last = pose(begin), way.point((begin + share) / 2.0), pose(share)
        if np.linalg.norm(middle - (first[:3, 3] + last[:3, 3]) / 2.0) < FLAT:
            world.add_line(last, velocity, radius)
        else:
            world.add_arc(first, middle, last, velocity, radius)

    _go(task, triggers, way.length, velocity, corner(zone, velocity), piece)
    world.arrived(end, target)


def joints(
    task: RapidTask,
    target: list[Any],
    speed: list[float],
    triggers: list[Trigger],
    zone: list[Any],
    wobj: list[Any] | None,
) -> None:
    """Move all joints evenly; places are those of the tool centre point on its way, measured in pieces."""
    world = task.world
    world.keep_axes(target)
    start, goal = world.joints_planned(), world.goal_of(target, wobj)
    factor = world.joint_factor(start, goal, speed)
    shares = np.linspace(0.0, 1.0, PLACES + 1)
    places = [world.place_at(start + share * (goal - start)) for share in shares]
    ways = np.concatenate(([0.0], np.cumsum([np.linalg.norm(b - a) for a, b in pairwise(places)])))
    length = float(ways[-1])

    def piece(_: float, share: float, radius: Zone) -> None:
        part = 1.0 if share >= 1.0 else float(np.interp(share * length, ways, shares))
        world.add_joints(start + part * (goal - start), factor, radius)

    _go(task, triggers, length, speed[0] / 1000.0, corner(zone, speed[0] / 1000.0), piece)
    world.went(goal, world.frame(wobj) @ matrix_of(target))
