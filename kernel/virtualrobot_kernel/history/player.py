"""Player of a replay: one moment of it that goes on or elsewhere, while moments are kept in the background."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence

from virtualrobot_kernel.background import give_way
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.history.checkpoints import Checkpoints
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.history.past import PastFolder
from virtualrobot_kernel.history.replay import Cursor
from virtualrobot_kernel.history.steps import Steps
from virtualrobot_kernel.history.stored_steps import StoredSteps
from virtualrobot_kernel.history.upkeep import KERNEL, Rules, Upkeep
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.past_world import is_past
from virtualrobot_kernel.world.structure import Structure

log = logging.getLogger(__name__)


class _NoUpkeep(Upkeep):
    """Upkeep of what was: nothing is added, and nothing removed."""

    def checkpoint(self, name: str = "", author: str = KERNEL) -> int:
        """Refuse it."""
        raise is_past()

    def remove_checkpoints(self, ids: Sequence[int]) -> None:
        """Refuse it."""
        raise is_past()


class Player:
    """Moment of a replay, for the world thread, and the thread that makes every moment near.

    Attributes:
        steps: what was done, as it was kept.
        checkpoints: those that there were; there come no others.
        ready: is set once every moment is near.
    """

    def __init__(
        self, past: PastFolder, forward: Forward, look: Callable[[Structure], None] = lambda structure: None
    ) -> None:
        """Be at the first moment of a past, which `close` closes; raise KernelError when it can't be replayed.

        `look` is given the structure of the last moment once that is near; the KernelError that it raises is logged.
        """
        self._past, self._look = past, look
        self._replay = replay = past.replay(forward)
        self._cursor: Cursor = replay.at(replay.first_tick)
        codec, store = world_codec(), past.store
        self.steps = Steps(StoredSteps(store, codec))
        self.checkpoints = Checkpoints(store, codec, _NoUpkeep(store, codec, Rules(), self._cursor.moment))
        self._ended = threading.Event()
        self.ready = threading.Event()
        self._thread = threading.Thread(target=self._keep_moments, name="replay", daemon=True)

    @property
    def newest(self) -> Structure:
        """Structure of the last moment that is at hand."""
        return self._replay.newest

    @property
    def first_tick(self) -> int:
        """First tick that is recorded."""
        return self._replay.first_tick

    @property
    def last_tick(self) -> int:
        """Last tick that is recorded."""
        return self._replay.last_tick

    def start(self) -> None:
        """Begin to keep moments."""
        self._thread.start()

    def settle(self) -> None:
        """Do nothing: the past is told."""

    def close(self) -> None:
        """End the thread."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join(10.0)
        self._past.close()

    def later(self) -> Change:
        """Go on by a tick; return the world with all that was done in it."""
        self._cursor.step()
        return self._now()

    def at(self, tick: int) -> Change:
        """Go to a tick; return the world with all that was done in it."""
        self._cursor = self._replay.at(tick)
        return self._now()

    def _now(self) -> Change:
        return Change(self._cursor.structure, self._cursor.state)

    def _keep_moments(self) -> None:
        give_way()
        try:
            self._replay.keep_moments(lambda: not self._ended.is_set())
            if not self._ended.is_set():
                self._look(self._replay.at(self.last_tick).structure)
        except KernelError as error:
            log.warning("%s: %s", self._past.path, error)
        for warning in self._replay.warnings.values():
            log.warning("%s", warning)
        self.ready.set()
