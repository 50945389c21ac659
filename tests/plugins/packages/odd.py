"""A plugin whose components go wrong at the stage that their settings name, in the kernel's process or in their own."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from pathlib import Path

from arm_for_tests import DEFAULTS, ReadyChain
from virtualrobot_sdk.errors import ArgumentError, FilesNeeded, PluginError
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult, SerialChain
from virtualrobot_sdk.registration import Isolation

api_version = "1.0"

ERRORS = {
    "exit": SystemExit("licence missing"),
    "files": FilesNeeded(["a.stl"]),
    "plugin": PluginError("write it otherwise"),
    "surrogate": ValueError("odd \udcff text"),
    "refusal": ArgumentError("too far", reason="reach", kind="pose"),
    "long": ArgumentError("\N{SNOWMAN}" * 100_000, **{f"key {i}": "value " * 200 for i in range(100)}),
}


@dataclass(frozen=True)
class Settings:
    """What goes wrong, and when."""

    make: str = ""
    """An error, or `hang`."""
    inverse: str = ""
    """An error, `hang`, or the answer that is wrong."""
    trigger: str = ""
    """A file: `inverse` goes wrong as soon as that is there; empty: at once."""


class Odd(ReadyChain):
    """Right but for its settings."""

    def __init__(self, chain: SerialChain, settings: Settings) -> None:
        """Keep the settings."""
        _go_wrong(settings.make)
        super().__init__(chain)
        self._settings = settings

    def inverse(self, base_t_tip: Floats, options: InverseOptions = DEFAULTS, /) -> InverseResult:
        """Go wrong, or solve."""
        wrong, trigger = self._settings.inverse, self._settings.trigger
        result = super().inverse(base_t_tip, options)
        if trigger and not Path(trigger).exists():
            return result
        _go_wrong(wrong)
        values = {"configurations": [1], "position_error": "large", "reason": 5, "status": "SOLVED"}
        return result._replace(**{wrong: values[wrong]} if wrong in values else {})


def _go_wrong(how: str) -> None:
    if how == "hang":
        print("hangs", file=sys.stderr, flush=True)
        time.sleep(3600.0)
    if how in ERRORS:
        raise ERRORS[how]


@hookimpl
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register it twice; the deadline is longer than any test."""
    register("odd_inside", Odd, Settings, isolation=Isolation.IN_PROCESS)
    register("odd", Odd, Settings, deadline_seconds=300.0)
