"""Notes on a plan: deviations from the request that the planner has chosen, and what its start comes upon."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from virtualrobot_kernel.motion.jog import JogEnd


class NoteKind(Enum):
    """Kind of a note; the names equal those of `PlanNoteKind` in the contract."""

    ZONE_SHRUNK = "ZONE_SHRUNK"
    ZONE_DROPPED = "ZONE_DROPPED"
    JOG_ENDS = "JOG_ENDS"
    UNFORESEEN = "UNFORESEEN"
    DEFERRED = "DEFERRED"
    TOUCHING = "TOUCHING"


@dataclass(frozen=True, slots=True)
class Note:
    """Deviation of a plan from its request: its step (from 0) and robot, the wanted value and the one kept.

    wanted, kept: meters, radians or percent, both in one unit; 0 where no value is meant. message: why, in words.
    step_path: what the step is called in the program's text.
    """

    kind: NoteKind
    step: int
    robot: str
    wanted: float
    kept: float
    message: str
    step_path: str = ""


def jog_notes(robot: str, end: JogEnd | None) -> tuple[Note, ...]:
    """Return the note about a jog that ends early; none for one that doesn't."""
    if end is None:
        return ()
    return (Note(NoteKind.JOG_ENDS, 0, robot, end.wanted, end.kept, f"the jog ends early: {end.reason}"),)
