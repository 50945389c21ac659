"""A plugin whose component hangs at work."""

from __future__ import annotations

from arm_for_tests import DEFAULTS, Arm, Settings
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult

api_version = "1.0"


class Hangs(Arm):
    """Never ends solving."""

    def inverse(self, base_t_tip: Floats, options: InverseOptions = DEFAULTS, /) -> InverseResult:
        """Go round and round."""
        while self.is_wrong():
            pass
        return super().inverse(base_t_tip, options)


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register it with a short deadline."""
    register("hangs", Hangs, Settings, deadline_seconds=2.0)
