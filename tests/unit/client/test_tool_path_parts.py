"""Parts of tool paths: the fewest, by brute force; few questions; and stretches that can't be."""

from __future__ import annotations

from functools import cache
from typing import cast

import numpy as np
import pytest
from virtualrobot import ToolPath
from virtualrobot.errors import InvalidArgumentError, LimitError, UnreachableError
from virtualrobot.motions.tool_path_parts import ToolPathPart, parts_of


class Arm:
    """An arm with some postures, each of which leads along some stretches of a path alone."""

    def __init__(self, stretches: list[tuple[int, int]], nearest: int = 0) -> None:
        """Take stretches, from frame to frame; what is refused is told `nearest` frames off."""
        self.stretches, self.nearest, self.asked = stretches, nearest, 0

    def can(self, first: int, last: int) -> bool:
        """Return whether one posture leads along a part."""
        return any(begin <= first and last <= end for begin, end in self.stretches)

    def find(self, first: int, last: int) -> ToolPath:
        """Return something for a part that can be; raise UnreachableError with the frame else."""
        self.asked += 1
        if self.can(first, last):
            return cast("ToolPath", (first, last))
        reached = max((end for begin, end in self.stretches if begin <= first <= end), default=first)
        frame = min(max(reached - first + self.nearest, 0), last - first)
        raise UnreachableError("no posture reaches there", "", {"frame": str(frame)})


def fewest(count: int, arm: Arm) -> float:
    """Return the number of parts that lead along all frames, infinite where none do, of all divisions."""

    @cache
    def rest(first: int) -> float:
        if first == count - 1:
            return 0
        return min((1 + rest(last) for last in range(first + 1, count) if arm.can(first, last)), default=np.inf)

    return rest(0)


@pytest.mark.parametrize("nearest", [-1, 0, 1])
def test_there_are_as_few_parts_as_can_be(seed: int, nearest: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(100):
        begins = rng.integers(0, 40, 8)
        arm = Arm(
            [(0, 6), *((int(b), int(b + n)) for b, n in zip(begins, rng.integers(2, 25, 8), strict=True))], nearest
        )
        found = parts_of(41, arm.find)
        assert [part.first for part in found] == [0, *(part.last for part in found[:-1])] and found[-1].last == 40
        assert all(arm.can(part.first, part.last) == (part.path is not None) for part in found)
        if np.isfinite(fewest(41, arm)):
            assert len(found) == fewest(41, arm)


def test_what_can_be_is_asked_for_once_and_what_cannot_with_few_questions() -> None:
    arm = Arm([(0, 1000)])
    (part,) = parts_of(1001, arm.find)
    assert (part.first, part.last, arm.asked) == (0, 1000, 1) and part.refusal is None
    arm = Arm([(0, 600), (550, 1000)])
    assert [(part.first, part.last) for part in parts_of(1001, arm.find)] == [(0, 600), (600, 1000)]
    assert arm.asked <= 2 + 10 + 1


def test_a_stretch_that_cannot_be_is_one_part_with_its_reason() -> None:
    arm = Arm([(0, 10), (14, 20)])
    parts = parts_of(21, arm.find)
    assert [(part.first, part.last, part.path is None) for part in parts] == [
        (0, 10, False),
        (10, 14, True),
        (14, 20, False),
    ]
    assert isinstance(parts[1].refusal, UnreachableError) and isinstance(parts[1], ToolPathPart)


def test_a_refusal_without_a_frame_halves_and_other_errors_are_raised() -> None:
    def short(first: int, last: int) -> ToolPath:
        if last > 5:
            raise LimitError("too fast", "", {})
        return cast("ToolPath", (first, last))

    assert [(part.first, part.last) for part in parts_of(7, short)] == [(0, 5), (5, 6)]

    def wrong(first: int, last: int) -> ToolPath:
        raise InvalidArgumentError("frames make no sense")

    with pytest.raises(InvalidArgumentError):
        parts_of(7, wrong)
