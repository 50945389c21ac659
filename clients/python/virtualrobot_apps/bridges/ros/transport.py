"""The interface of transports: what carries a hub's topics, services and actions to others."""

from __future__ import annotations

from abc import ABC, abstractmethod

from virtualrobot_apps.bridges.ros.hub import Hub


class TransportError(Exception):
    """A transport that can't be opened; its text is for people."""


class Transport(ABC):
    """A transport: opened with a hub, whose loop calls all of its methods, and closed once."""

    @abstractmethod
    async def open(self, hub: Hub) -> str:
        """Begin to carry; return in words where others find it.

        Raises:
            TransportError: when it can't, such as a port that is taken.
        """

    @abstractmethod
    async def close(self) -> None:
        """End it; raises nothing."""
