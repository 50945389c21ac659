"""A plugin whose component returns arrays of a wrong shape."""

from __future__ import annotations

import dataclasses

from arm_for_tests import DEFAULTS, Arm, Settings
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult

api_version = "1.0"


class WrongShape(Arm):
    """Returns one solution as a vector, where a matrix of solutions belongs."""

    def inverse(self, base_t_tip: Floats, options: InverseOptions = DEFAULTS, /) -> InverseResult:
        """Return the first solution alone."""
        result = super().inverse(base_t_tip, options)
        return dataclasses.replace(result, solutions=result.solutions[0]) if self.is_wrong() else result


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register it."""
    register("wrong_shape", WrongShape, Settings)
