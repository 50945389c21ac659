"""Tool paths in parts, where no posture leads along the whole: as few as there can be, and what is impossible."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from virtualrobot._wire.showing import shown
from virtualrobot.errors import CollisionError, LimitError, SingularityError, UnreachableError, VirtualRobotError
from virtualrobot.motions.tool_paths import ToolPath

REFUSALS = (CollisionError, LimitError, SingularityError, UnreachableError)
"""Refusals that are about a place of a path: before it there may be a part that can be."""


@shown
@dataclass(frozen=True, slots=True, eq=False)
class ToolPathPart:
    """Part of a tool path, from one of its frames to another.

    Attributes:
        first: the number of the frame that it begins at, from 0.
        last: the number of the frame that it ends at; the next part begins there.
        path: the way along it; None where there is none.
        refusal: why there is none; None where there is one.
    """

    first: int
    last: int
    path: ToolPath | None
    refusal: VirtualRobotError | None = None


def parts_of(count: int, find: Callable[[int, int], ToolPath]) -> tuple[ToolPathPart, ...]:
    """Return the parts of a path of `count` frames, the fewest that there are; stretches that can't be are one, too.

    `find` returns the way from one frame to another, or raises one of `REFUSALS`. A part that can be is as long as can
    be, which makes the fewest, since what leads along a path leads along its beginning, too.
    """
    found, first = list[ToolPathPart](), 0
    while first < count - 1:
        part = _longest(first, count - 1, find)
        before = found[-1] if found else None
        if part.path is None and before is not None and before.path is None:
            found[-1] = ToolPathPart(before.first, part.last, None, before.refusal)
        else:
            found.append(part)
        first = part.last
    return tuple(found)


def _longest(first: int, last: int, find: Callable[[int, int], ToolPath]) -> ToolPathPart:
    """Return the longest part from one frame, to another one at the most; of two frames where there is none."""
    longest, beyond, asked = None, last + 1, last
    refusal: VirtualRobotError | None = None
    while True:
        try:
            longest = ToolPathPart(first, asked, find(first, asked))
            told = beyond
        except REFUSALS as error:
            refusal, beyond = error, asked
            told = first + int(error.metadata["frame"]) if "frame" in error.metadata else beyond
        reached = longest.last if longest is not None else first
        if beyond - reached <= 1:
            return longest or ToolPathPart(first, first + 1, None, refusal)
        # What is refused is told with the nearest frame; else the middle halves what is left.
        asked = told if reached < told < beyond else (reached + beyond) // 2
