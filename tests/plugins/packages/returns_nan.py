"""A plugin whose component returns values that are not finite."""

from __future__ import annotations

import numpy as np
from arm_for_tests import DEFAULTS, LONG, Arm, Settings
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult

api_version = "1.0"


class ReturnsNan(Arm):
    """Has a solution with an arc cosine of more than 1."""

    def inverse(self, base_t_tip: Floats, options: InverseOptions = DEFAULTS, /) -> InverseResult:
        """Return NaN for the last joint."""
        result = super().inverse(base_t_tip, options)
        if self.is_wrong():
            result.solutions[:, -1] = np.nan
        return result


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register it."""
    register("returns_nan", ReturnsNan, Settings, deadline_seconds=LONG)
