"""Cell of one kernel: the robots that are connected to real ones, and the stop that all of them have in common."""

from __future__ import annotations

import threading
from collections.abc import Mapping

from virtualrobot_sdk.drivers.shared import NEVER, CellBlock

from virtualrobot_kernel.drivers.link import Link


class Cell:
    """Links by robot, and whether somebody has stopped them all; whatever thread asks.

    Attributes:
        links: the links by their robots' uids; replaced as a whole, so that each reader has its own.
        block: the block of shared memory by which hosts are stopped; None while no robot is connected. What it says and
            the world's own stop are made one before each tick (`supervision.py`).
        changing: held while links, block or the kernel's hold on the clock change.
        closed: whether the kernel is ending.
        by: who has stopped them; empty where nobody in the kernel knows.
        reason: why; likewise.
    """

    def __init__(self) -> None:
        """Begin with none."""
        self.links: Mapping[int, Link] = {}
        self.block: CellBlock | None = None
        self.changing = threading.RLock()
        self.closed = False
        self.by, self.reason = "", ""

    @property
    def is_stopped(self) -> bool:
        """True from a stop until it is released."""
        block = self.block
        return block is not None and block.stop_ns != NEVER

    @property
    def stopped(self) -> str:
        """Reason for which the cell is stopped; empty: it is not."""
        return (self.reason or "stopped from outside the kernel") if self.is_stopped else ""

    def stop(self, reason: str, by: str) -> None:
        """Bring all robots to rest together; nothing waits for anything."""
        block = self.block
        if block is not None:
            if not self.is_stopped:
                self.by, self.reason = by, reason
            block.stop()

    def release(self) -> None:
        """End a stop, while no robot is played; in the world thread, where the world's own stop ends with it."""
        if self.block is not None:
            self.by, self.reason = "", ""
            self.block.release()

    def add(self, uid: int, link: Link) -> None:
        """Add the link of a robot, or put it in the place of the one that it had."""
        with self.changing:
            self.links = {**self.links, uid: link}

    def again(self) -> None:
        """Have the links looked at anew by who has seen them: one of them is played from now on."""
        with self.changing:
            self.links = dict(self.links)

    def remove(self, link: Link) -> None:
        """Forget a link."""
        with self.changing:
            self.links = {uid: one for uid, one in self.links.items() if one is not link}
