"""A plugin whose component raises at work."""

from __future__ import annotations

from arm_for_tests import DEFAULTS, LONG, Arm, Settings
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult

api_version = "1.0"


class RaisesAtWork(Arm):
    """Raises when it solves."""

    def inverse(self, base_t_tip: Floats, options: InverseOptions = DEFAULTS, /) -> InverseResult:
        """Look up what is not there."""
        if self.is_wrong():
            return {}["elbow up"]
        return super().inverse(base_t_tip, options)


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register it."""
    register("raises_at_work", RaisesAtWork, Settings, deadline_seconds=LONG)
