"""A plugin whose component keeps what it should give back."""

from __future__ import annotations

from dataclasses import dataclass

from arm_for_tests import DEFAULTS, LONG, Arm
from arm_for_tests import Settings as Common
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult, SerialChain

api_version = "1.0"


@dataclass(frozen=True)
class Settings(Common):
    """How much it keeps."""

    bytes_a_call: int = 64 << 20


class Leaks(Arm):
    """Remembers every target that it ever solved."""

    def __init__(self, chain: SerialChain, settings: Settings) -> None:
        """Start with an empty memory."""
        super().__init__(chain, settings)
        self._bytes = settings.bytes_a_call
        self._kept: list[bytes] = []

    def inverse(self, base_t_tip: Floats, options: InverseOptions = DEFAULTS, /) -> InverseResult:
        """Keep some memory, then solve."""
        if self.is_wrong():
            self._kept.append(b"x" * self._bytes)
        return super().inverse(base_t_tip, options)


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register it."""
    register("leaks", Leaks, Settings, deadline_seconds=LONG)
