"""A plugin whose components return arrays of a wrong shape."""

from __future__ import annotations

import numpy as np
from arm_for_tests import DEFAULTS, LONG, Arm, Settings
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult
from virtualrobot_sdk.rays import Readings, TrueHits

api_version = "1.0"


class WrongShape(Arm):
    """Returns one solution as a vector, where a matrix of solutions belongs."""

    def inverse(self, base_t_tip: Floats, options: InverseOptions = DEFAULTS, /) -> InverseResult:
        """Return the first solution alone."""
        result = super().inverse(base_t_tip, options)
        return result._replace(solutions=result.solutions[0]) if self.is_wrong() else result


class ReadingOfEachRay:
    """Returns a reading of each ray, where one of each beam belongs."""

    def beam(self) -> Floats:
        """Return two rays."""
        return np.array([[1.0, 0.0, 0.0], [0.8, 0.6, 0.0]])

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        """Return arrays (n, 2)."""
        return Readings(hits.distance.copy(), hits.reflectance.copy(), np.isfinite(hits.distance))


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register it."""
    register("wrong_shape", WrongShape, Settings, deadline_seconds=LONG)


@hookimpl
def virtualrobot_register_sensor_models(register: Register) -> None:
    """Register it."""
    register("wrong_shape", ReadingOfEachRay, deadline_seconds=LONG)
