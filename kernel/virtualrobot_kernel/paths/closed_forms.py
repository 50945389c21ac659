"""Closed forms by which a ladder's postures are found: of arms with a spherical wrist, and with three parallel axes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from virtualrobot_sdk.compiled.closed import BRANCHES, inverse_many, spherical_wrist
from virtualrobot_sdk.kinematics import Floats, SerialChain
from virtualrobot_sdk.parallel_axes import ParallelAxes, has_parallel_axes

Postures = Callable[[Floats], tuple[Floats, Floats]]
"""Postures (m, 8, 6) of poses (m, 4, 4) of an arm's tip, NaN for none; and (m, 8), 0 where they are singular."""


def closed_form(chain: SerialChain) -> Postures:
    """Return the closed form of an arm; raises ArgumentError with what it lacks."""
    if has_parallel_axes(chain):
        return ParallelAxes(chain).postures
    arm = spherical_wrist(chain)

    def postures(tips: Floats) -> tuple[Floats, Floats]:
        q, wrist = np.empty((len(tips), BRANCHES, 6)), np.empty((len(tips), BRANCHES))
        inverse_many(arm, np.ascontiguousarray(tips), q, wrist)
        return q, wrist

    return postures
