"""What a planner made other than it was asked to."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class NoteKind(Enum):
    """What was made otherwise; the names equal those of `PlanNoteKind` in the contract."""

    ZONE_SHRUNK = "ZONE_SHRUNK"
    ZONE_DROPPED = "ZONE_DROPPED"
    JOG_ENDS = "JOG_ENDS"


@dataclass(frozen=True, slots=True)
class Note:
    """Something made otherwise: in which step (from 0), of which robot, what was wanted and what was kept of it.

    wanted, kept: meters, radians or percent, both in one unit. message: why, in words.
    """

    kind: NoteKind
    step: int
    robot: str
    wanted: float
    kept: float
    message: str
