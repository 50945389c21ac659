"""A plugin whose component crashes its process at work."""

from __future__ import annotations

import ctypes

from arm_for_tests import DEFAULTS, LONG, Arm, Settings
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult

api_version = "1.0"


class Crashes(Arm):
    """Reads where there is nothing, as C++ would by a wrong index."""

    def inverse(self, base_t_tip: Floats, options: InverseOptions = DEFAULTS, /) -> InverseResult:
        """Read address 0: a segmentation fault."""
        if self.is_wrong():
            ctypes.string_at(0)
        return super().inverse(base_t_tip, options)


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register it."""
    register("crashes", Crashes, Settings, deadline_seconds=LONG)
