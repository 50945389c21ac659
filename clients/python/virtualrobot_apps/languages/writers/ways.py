"""Ways through a program that decides: where each leads, and statements that are the same by all of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np
from virtualrobot.geometry import Matrix
from virtualrobot.v1 import motion_pb2

from virtualrobot_apps.languages.writers.statements import Arc, Floats, Goal, Line, PointToPoint, Statement, Zone

MOST_WAYS = 20
"""Most places from which a round of a loop may begin."""
SAME = 1e-6
"""Difference (rad, m, and in rotation matrices) up to which goals are the same."""
_ELSEWHERE = (
    "it goes elsewhere after one decision than after another; give a goal that says where all joints go, by joints "
    "or by pose and configuration"
)
_OTHERWISE = "what is decided before it changes what it does"
_SLOWER = "its speed is that of the slowest of the ways that lead to it"

_BRANCHES = {"if_signal": ("then", "otherwise"), "while_signal": ("steps",)}


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """Step with its place in the text, and the steps of each branch of one that decides."""

    at: str
    message: motion_pb2.ProgramStep
    branches: tuple[list[Step], ...] = ()


def tree_of(messages: Iterable[motion_pb2.ProgramStep], paths: Iterator[str]) -> Iterator[Step]:
    """Return steps with their places, which come in the order of the text."""
    for message in messages:
        at, kind = next(paths), message.WhichOneof("step") or ""
        content: Any = getattr(message, kind) if kind else None
        branches = [getattr(content, name) for name in _BRANCHES.get(kind, ())]
        yield Step(at, message, tuple(list(tree_of(one, paths)) for one in branches))


def all_steps(steps: Iterable[Step]) -> Iterator[Step]:
    """Return steps and those within them."""
    for step in steps:
        yield step
        yield from all_steps(chain.from_iterable(step.branches))


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """Way through a program, and what is so at its end.

    Attributes:
        steps: the steps that are done on it, with their places in the text.
        joints: (n,), rad or m.
        base_t_tcp: 4x4 pose of the tool centre point in the frame of the robot's base.
        tool: the tool and the tool centre point that are chosen.
        share: the part of their speed that moves have.
    """

    steps: tuple[tuple[str, motion_pb2.ProgramStep], ...]
    joints: Floats
    base_t_tcp: Matrix
    tool: tuple[str, str]
    share: float


def distinct(ways: Iterable[Way]) -> list[Way]:
    """Return ways that end differently, the first one of those that end the same."""
    found = list[Way]()
    for way in ways:
        if not any(_ends_same(way, one) for one in found):
            found.append(way)
    return found


def _ends_same(one: Way, other: Way) -> bool:
    if (one.tool, one.share) != (other.tool, other.share):
        return False
    return bool(np.abs(one.joints - other.joints).max() <= SAME)


def merged(one: Statement, other: Statement) -> tuple[Statement | None, str]:
    """Return a statement that is right by two ways, and words about what it is then; None, and why, where none is.

    Joint moves from several places keep to the speed of the slower way.
    """
    if isinstance(one, PointToPoint) and isinstance(other, PointToPoint):
        if not _same_goal(one.goal, other.goal):
            return None, _ELSEWHERE
        if one.share != other.share:
            return None, _OTHERWISE
        speeds = {name: min(getattr(one, name), getattr(other, name)) for name in ("speed", "turning", "leading")}
        slower = any(speeds[name] < (1.0 - SAME) * max(getattr(one, name), getattr(other, name)) for name in speeds)
        acceleration, zone = min(one.acceleration, other.acceleration), _zone(one.zone, other.zone)
        return replace(one, **speeds, acceleration=acceleration, zone=zone), _SLOWER if slower else ""
    if isinstance(one, Line | Arc) and type(one) is type(other):
        assert isinstance(other, Line | Arc)
        same = _same_goal(one.goal, other.goal)
        if isinstance(one, Arc) and isinstance(other, Arc):
            same = same and _same_goal(one.via, other.via)
        if not same:
            return None, _ELSEWHERE
        if (one.speed, one.acceleration) != (other.speed, other.acceleration):
            return None, _OTHERWISE
        return replace(one, zone=_zone(one.zone, other.zone)), ""
    return (one, "") if one == other else (None, _OTHERWISE)


def _same_goal(one: Goal, other: Goal) -> bool:
    if (one.frame, one.branch) != (other.frame, other.branch):
        return False
    pairs = [(one.joints, other.joints), (one.base_t_tcp, other.base_t_tcp)]
    return all(np.abs(np.asarray(a) - np.asarray(b)).max() <= SAME for a, b in pairs)


def _zone(one: Zone | None, other: Zone | None) -> Zone | None:
    """Return the smaller of two zones; the share is of the way's own length."""
    if one is None or other is None:
        return None
    return Zone(min(one.meters, other.meters), min(one.share, other.share))
