"""A plugin whose component runs in the kernel's own process, and raises there."""

from __future__ import annotations

from arm_for_tests import DEFAULTS, Arm, Settings
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult
from virtualrobot_sdk.registration import Isolation

api_version = "1.0"


class InProcess(Arm):
    """In the kernel's own process."""

    def inverse(self, base_t_tip: Floats, options: InverseOptions = DEFAULTS, /) -> InverseResult:
        """Divide by zero."""
        if self.is_wrong():
            raise ZeroDivisionError("1 / (s1 - s1)")
        return super().inverse(base_t_tip, options)


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register it."""
    register("in_process", InProcess, Settings, isolation=Isolation.IN_PROCESS)
