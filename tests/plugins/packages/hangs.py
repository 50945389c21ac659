"""A plugin whose component hangs at work, in a process of its own or in the kernel's."""

from __future__ import annotations

import sys

from arm_for_tests import DEFAULTS, Arm, Settings
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult
from virtualrobot_sdk.registration import Isolation

api_version = "1.0"


class Hangs(Arm):
    """Never ends solving."""

    def inverse(self, base_t_tip: Floats, options: InverseOptions = DEFAULTS, /) -> InverseResult:
        """Go round and round."""
        if self.is_wrong():
            print("hangs", file=sys.stderr, flush=True)
        while self.is_wrong():
            pass
        return super().inverse(base_t_tip, options)


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register it with a short deadline, and with none."""
    register("hangs", Hangs, Settings, deadline_seconds=2.0)
    register("hangs_inside", Hangs, Settings, isolation=Isolation.IN_PROCESS)
