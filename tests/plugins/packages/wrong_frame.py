"""A plugin whose component has the robot's base elsewhere; its forward and inverse agree with each other."""

from __future__ import annotations

import numpy as np
from arm_for_tests import DEFAULTS, LONG, Arm, Settings
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult

api_version = "1.0"

HEIGHT = 0.1
"""Where it has the base, in meters above the floor."""


class WrongFrame(Arm):
    """Counts heights from the floor and not from the robot's base."""

    def forward(self, q: Floats, /) -> Floats:
        """Return frames that are too high."""
        frames = super().forward(q)
        if self.is_wrong():
            frames[:, 2, 3] += HEIGHT
        return frames

    def inverse(self, base_t_tip: Floats, options: InverseOptions = DEFAULTS, /) -> InverseResult:
        """Solve for a pose that is too low."""
        target = np.array(base_t_tip)
        if self.is_wrong() and target.shape == (4, 4):
            target[2, 3] -= HEIGHT
        return super().inverse(target, options)


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register it."""
    register("wrong_frame", WrongFrame, Settings, deadline_seconds=LONG)
