"""Arms that work at the same time, as files describe them: what a partner does not say is as for the first arm."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from virtualrobot_apps.cell_io.yaml_file import Item

ALONE = ("schema_version", "process", "external", "split", "together")
"""Fields that a process has once, however many arms there are."""

Work = TypeVar("Work")


@dataclass(frozen=True, slots=True, eq=False)
class Together(Generic[Work]):
    """Work of an arm that goes along with another one.

    Attributes:
        work: what it does.
        paced: whether its speed is told; else it is whichever makes both end together.
    """

    work: Work
    paced: bool


def read_together(item: Item, ways: str, read: Callable[[Item], Work]) -> tuple[Together[Work], ...]:
    """Return what a file says of arms that go along; `ways` is the field that each has its own of, beside its robot.

    Raises MalformedFileError, with file and line, for what it says wrong.
    """
    fields = item.mapping("fields")
    found = list[Together[Work]]()
    for one in fields["together"].items() if "together" in fields else ():
        given = one.mapping("fields")
        for name in ("robot", ways):
            if name not in given:
                raise one.error(f"the field {name!r} is missing: each arm has its own")
        for name in ALONE:
            if name in given:
                raise given[name].error(f"{name!r} is one for all arms: it belongs to the process")
        found.append(Together(read(one.beside(item, "together")), "speed" in given))
    if "together" in fields and "split" in fields:
        raise fields["split"].error("arms that go together can't go in parts: leave `split` or `together` out")
    return tuple(found)
