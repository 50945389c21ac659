"""The interface of transports: what carries a hub's topics, services and actions to others."""

from __future__ import annotations

import os
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


def no_server(what: str, host: str, port: int, error: OSError) -> TransportError:
    """Return that `what` can't be at an address, with the reason in words."""
    # asyncio has words of its own about an address; a name that is none has a number below 0.
    words = os.strerror(error.errno) if error.errno and error.errno > 0 else error.strerror
    return TransportError(f"{what} at {host}:{port}: {words}")


def in_address(host: str) -> str:
    """Return a host as addresses have it: one of IPv6 in brackets."""
    return f"[{host}]" if ":" in host else host
