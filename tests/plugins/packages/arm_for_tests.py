"""What the plugins of the tests have in common: the bundled chain's kinematics, right until they go wrong."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.kinematics import InverseOptions, SerialChain

DEFAULTS = InverseOptions()
LONG = 30.0
"""A deadline (s) of components that go wrong otherwise: a busy machine shall not find them hanging before that."""


@dataclass(frozen=True)
class Settings:
    """When a component goes wrong."""

    trigger: str = ""
    """A file: it goes wrong as soon as that is there; empty: at once."""


class ReadyChain(ChainKinematics):
    """Any chain; its compiled code is loaded when it is made, where there is time for it, and not in the first call."""

    def __init__(self, chain: SerialChain) -> None:
        """Call everything once."""
        super().__init__(chain)
        target = ChainKinematics.forward(self, self.middle)[-1]
        ChainKinematics.jacobian(self, self.middle)
        ChainKinematics.inverse(self, target)


class Arm(ReadyChain):
    """Right until it goes wrong."""

    def __init__(self, chain: SerialChain, settings: Settings) -> None:
        """Keep the chain and the trigger."""
        super().__init__(chain)
        self._trigger = settings.trigger

    def is_wrong(self) -> bool:
        """Return whether it goes wrong now."""
        return not self._trigger or Path(self._trigger).exists()
