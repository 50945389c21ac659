"""A plugin that is as it should be: the bundled chain again, in a process of its own, with settings."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Annotated

import msgspec
from arm_for_tests import LONG, ReadyChain
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult, SerialChain

api_version = "1.0"

DEFAULTS = InverseOptions()


@dataclass(frozen=True)
class Settings:
    """How it solves."""

    restarts: Annotated[int, msgspec.Meta(ge=0, description="Most random starts after the seed.")] = 2000
    joints: Annotated[int, msgspec.Meta(description="The only number of joints that it takes; 0: any.")] = 0


class Good(ReadyChain):
    """Any chain, in a process of its own."""

    def __init__(self, chain: SerialChain, settings: Settings) -> None:
        """Keep the chain and how often to start."""
        if settings.joints not in (0, len(chain.joint_names)):
            raise ArgumentError(f"it is made for {settings.joints} joints; this robot has {len(chain.joint_names)}")
        super().__init__(chain)
        self._restarts = settings.restarts

    def inverse(self, base_t_tip: Floats, options: InverseOptions = DEFAULTS, /) -> InverseResult:
        """Solve with the number of starts from the settings."""
        return super().inverse(base_t_tip, dataclasses.replace(options, max_restarts=self._restarts))


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register it."""
    register("good", Good, Settings, deadline_seconds=LONG)
