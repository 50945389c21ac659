"""The book of layout exercises: what each begins with earns few points, its solution all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from virtualrobot_apps.studies.marking import Exercise
from virtualrobot_apps.studies.worlds import World, open_world

BOOK = Path(__file__).resolve().parents[2] / "docs" / "exercises"
EXERCISES = sorted(file for file in BOOK.glob("*.yaml") if not file.stem.endswith(("-cell", "-solution")))


class Kept:
    """World that stays open when whoever marks has done with it."""

    def __init__(self, world: World) -> None:
        """Take a world."""
        self.world = world
        self.pose, self.postures, self.contacts = world.pose, world.postures, world.contacts
        self.joint_limits = world.joint_limits

    def close(self) -> None:
        """Leave it open."""


@pytest.mark.long
@pytest.mark.parametrize("file", EXERCISES, ids=[file.stem for file in EXERCISES])
def test_its_solution_earns_all_and_what_is_given_does_not(file: Path, opened: dict[Path, Kept]) -> None:
    def opening(scene: Path) -> Kept:
        if scene not in opened:
            opened[scene] = Kept(open_world(scene))
        return opened[scene]

    exercise = Exercise(file)
    for ending, is_solved in (("-cell", False), ("-solution", True)):
        marks = exercise.marks(file.with_name(f"{file.stem}{ending}.yaml"), opening)  # pyright: ignore[reportArgumentType]  as far as it is used
        assert sum(one.points for one in marks) == 10.0
        assert (sum(one.earned for one in marks) == 10.0) == is_solved, marks


@pytest.fixture
def opened() -> Iterator[dict[Path, Kept]]:
    """Return the worlds that were opened, which end with the test."""
    with ExitStack() as ends:
        found: dict[Path, Kept] = {}
        ends.callback(lambda: [one.world.close() for one in found.values()])
        yield found


def test_there_are_ten() -> None:
    assert [file.stem[:2] for file in EXERCISES] == [f"{number:02d}" for number in range(1, 11)]
