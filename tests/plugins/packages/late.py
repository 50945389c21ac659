"""A plugin whose physics engine and mobile kinematics answer only once a file is gone, and an engine that is wrong."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from virtualrobot_plugins.mobile.differential import Differential, DifferentialSettings
from virtualrobot_plugins.physics.mujoco.component import MujocoPhysics, MujocoSettings
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.physics import Driven, Motors, Stepped
from virtualrobot_sdk.registration import Isolation

api_version = "1.0"

LONG = 120.0
"""A deadline (s) that is longer than any test waits."""

Floats = np.ndarray


@dataclass(frozen=True)
class LateSettings:
    """Settings of what hangs."""

    while_there: str
    """A file: as long as it is there nothing is answered."""


@dataclass(frozen=True)
class LateDifferentialSettings(DifferentialSettings):
    """Those of the bundled component, and when it hangs."""

    while_there: str = ""
    """A file: as long as it is there nothing is answered."""


class LatePhysics(MujocoPhysics):
    """MuJoCo, late."""

    def __init__(self, settings: LateSettings) -> None:
        """Keep the settings."""
        super().__init__(MujocoSettings())
        self._file = Path(settings.while_there)

    def step(self, driven: Driven, motors: Motors, wrenches: Floats | None, substeps: int, /) -> Stepped:
        """Step, late."""
        _wait(self._file)
        return super().step(driven, motors, wrenches, substeps)


@dataclass(frozen=True)
class WrongSettings:
    """Settings of what is wrong."""

    wrong: str = "object"
    """`object` or `nan`."""


class WrongPhysics(MujocoPhysics):
    """MuJoCo, whose answers make no sense."""

    def __init__(self, settings: WrongSettings) -> None:
        """Keep the settings."""
        super().__init__(MujocoSettings())
        self._wrong = settings.wrong

    def step(self, driven: Driven, motors: Motors, wrenches: Floats | None, substeps: int, /) -> Stepped:
        """Step, and say something else."""
        found = super().step(driven, motors, wrenches, substeps)
        q = found.q.astype(object) if self._wrong == "object" else np.full_like(found.q, np.nan)
        return replace(found, q=q)


class LateDifferential(Differential):
    """Two driven wheels, late."""

    def __init__(self, settings: LateDifferentialSettings) -> None:
        """Keep the settings."""
        super().__init__(settings)
        self._file = Path(settings.while_there)

    def step(
        self, world_t_base: Floats, drive_states: Floats, commands: Floats, seconds: float, /
    ) -> tuple[Floats, Floats]:
        """Step, late."""
        _wait(self._file)
        return super().step(world_t_base, drive_states, commands, seconds)


def _wait(file: Path) -> None:
    if file.exists():
        print("hangs", file=sys.stderr, flush=True)
        while file.exists():
            time.sleep(0.002)


@hookimpl
def virtualrobot_register_physics_engines(register: Register) -> None:
    """Register the late engine twice, and the other one."""
    register("wrong", WrongPhysics, WrongSettings)
    register("late", LatePhysics, LateSettings, deadline_seconds=LONG)
    register("late_inside", LatePhysics, LateSettings, isolation=Isolation.IN_PROCESS)


@hookimpl
def virtualrobot_register_mobile_kinematics(register: Register) -> None:
    """Register it."""
    register("late_differential", LateDifferential, LateDifferentialSettings, deadline_seconds=LONG)
