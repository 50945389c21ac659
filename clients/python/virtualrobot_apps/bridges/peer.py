"""Interface of the other side of a bridge, whatever it speaks."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping

from virtualrobot_apps.bridges.mapping import Entry
from virtualrobot_apps.bridges.words import Raw


class PeerError(Exception):
    """The other side refuses, is silent or gone; its own words."""


class Peer(ABC):
    """Other side of a bridge: opened, read and written at the same time, closed, and opened again after an error.

    Each method raises PeerError within the mapping's timeout when the other side does not answer.
    """

    name: str
    """Its address, for people."""

    @abstractmethod
    async def open(self) -> None:
        """Connect, or begin to serve."""

    @abstractmethod
    async def read(self) -> Mapping[Entry, object]:
        """Wait for the next values that come in; at least each of the first ones, then any that may have changed."""

    @abstractmethod
    async def write(self, values: Mapping[Entry, Raw]) -> None:
        """Give values that go out."""

    @abstractmethod
    async def close(self) -> None:
        """Disconnect; raises nothing."""
