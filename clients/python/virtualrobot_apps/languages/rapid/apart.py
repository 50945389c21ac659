"""Tools that stand apart, with work objects that the robot holds: where they are, by RAPID's data and in the kernel.

A stationary tool (robhold FALSE) stands at its tframe in RAPID's world frame; a work object that the robot holds
(robhold TRUE) is at its user and object frame on the flange. The kernel has a node for each while such moves are made.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from virtualrobot.geometry import Matrix

from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.frames import matrix_of


@dataclass(frozen=True, slots=True)
class Apart:
    """Stationary tool of the moves that are made now.

    Attributes:
        tool: the kernel's node where it stands.
        held: the kernel's node of the work object, which is the robot's tool there, and its tool centre point.
        pose: where the tool stands in RAPID's world frame, 4x4.
    """

    tool: str
    held: str
    pose: Matrix

    def seen(self, place: Matrix) -> Matrix:
        """Return where the tool is in the work object, where that is at a place, or the other way round."""
        return np.linalg.inv(place) @ self.pose

    def placed(self, target: Matrix) -> Matrix:
        """Return where the work object is, where the tool is at a place in it."""
        return self.pose @ np.linalg.inv(target)


def stands(tool: list[Any], wobj: list[Any] | None) -> bool:
    """Return whether a tool stands apart; raise the fault of one that goes not together with its work object."""
    holds = wobj is not None and bool(wobj[0])
    if bool(tool[0]) and holds:
        raise RapidFault(
            "ERR_ARGVALERR",
            "a work object that the robot holds (robhold TRUE) needs a stationary tool (robhold FALSE)",
        )
    if not tool[0] and not holds:
        raise RapidFault(
            "ERR_ARGVALERR", "a stationary tool (robhold FALSE) needs a work object that the robot holds (robhold TRUE)"
        )
    return not tool[0]


def on_flange(wobj: list[Any]) -> Matrix:
    """Return where a work object that the robot holds is on the flange, 4x4."""
    return matrix_of(wobj[3]) @ matrix_of(wobj[4])
