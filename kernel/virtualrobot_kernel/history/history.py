"""History of a kernel: its folder, its store, and the threads that write it; what the world begins from."""

from __future__ import annotations

import logging
import re
from dataclasses import replace

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.history.checkpoints import Checkpoints
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.history.folder import JOURNAL, LAST_TICK, Folder
from virtualrobot_kernel.history.journal import Journal, Told
from virtualrobot_kernel.history.last_tick import LastTick
from virtualrobot_kernel.history.recorder import Recorder
from virtualrobot_kernel.history.recovery import recovered
from virtualrobot_kernel.history.rows import Row
from virtualrobot_kernel.history.steps import Steps
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.history.stored_steps import StoredSteps
from virtualrobot_kernel.history.tail import Tail, tail_rows
from virtualrobot_kernel.history.upkeep import MEBIBYTE, Rules, Upkeep
from virtualrobot_kernel.world.change import Forward

IN_MEMORY = Rules(bytes=8 * MEBIBYTE, most_bytes=64 * MEBIBYTE)
"""Rules of a history that is in memory alone."""

_UNITS = {"mb": 1e6, "gb": 1e9, "tb": 1e12, "h": 3600.0, "d": 86400.0}
_LEAST_BYTES = 10_000_000

log = logging.getLogger(__name__)


def rules_of(text: str | None, in_folder: bool) -> Rules:
    """Return how much is kept: `500MB`, `4GB`, `12h`, `30d`, or a size and an age with a comma; None: the usual.

    Raises KernelError for what says something else, and for less than 10 MB.
    """
    rules = Rules() if in_folder else IN_MEMORY
    for part in text.split(",") if text else ():
        found = re.fullmatch(r"([0-9]+(?:\.[0-9]+)?)\s*([a-z]+)", part.strip().lower())
        amount = float(found[1]) * _UNITS.get(found[2], 0.0) if found else 0.0
        if found and found[2] in ("h", "d") and amount:
            rules = replace(rules, most_seconds=amount)
        elif amount >= _LEAST_BYTES:
            most = round(amount)
            rules = replace(rules, most_bytes=most, bytes=min(rules.bytes, most // 8))
        else:
            raise KernelError(
                f"what is kept of the history is a size of at least 10 MB, an age, or both, such as 500MB, 4GB, 12h, "
                f"30d or 4GB,30d; not {text!r}",
                keep_history=text,
            )
    return rules


class History:
    """History in a project folder, or without one in memory, where it is as complete until the kernel ends.

    Attributes:
        codec: how it is written.
        store: what is kept.
        journal: what the world tells.
        steps: what people see of it, undo and redo.
        checkpoints: those that people know by their names.
        upkeep: makes checkpoints.
        begin: the moment that the world begins from.
        goes_on: whether there was something to go on from.
    """

    def __init__(
        self,
        folder: Folder | None,
        tick_seconds: float,
        forward: Forward,
        rules: Rules | None = None,
        power: bool = False,
    ) -> None:
        """Read what a folder has (None: nothing is kept in files); nothing is written before `start`.

        Args:
            folder: the project, which `close` closes.
            tick_seconds: the length of a tick.
            forward: the forward pass.
            rules: what is kept how long; None: the usual.
            power: whether an answer is safe from a loss of power.

        Raises KernelError when what the world was can't be read.
        """
        self.codec = codec = world_codec()
        self._folder = folder
        self._last_tick: LastTick | None = None
        tail: Tail | None = None
        rows: list[Row] = []
        damage: list[str] = []
        if folder is None:
            self.store = Store()
        else:
            self.store = Store(folder.path / JOURNAL, folder.project.seed, power)
            self.store.note_tick(folder.project.tick_nanoseconds)
            self._last_tick = LastTick(folder.path / LAST_TICK, folder.project.seed)
            rows, damage = tail_rows(folder.path, folder.project.seed, self.store.life, self.store.last_seq)
            tail = Tail(folder.path, folder.project.seed, power)
        left: list[Told] = []
        last_tick = self._last_tick.read() if self._last_tick else 0
        self.begin, warnings = recovered(self.store, codec, last_tick, tick_seconds, forward, rows, left.append)
        for warning in (*self.store.warnings, *damage, *warnings, *self._other_versions()):
            log.warning("%s", warning)
        self.goes_on = self.begin.number > 0 or self.begin.state.tick > 0
        rules = rules or rules_of(None, folder is not None)
        self.upkeep = Upkeep(self.store, codec, rules, self.begin, self._last_tick, self.settle)
        kept = StoredSteps(self.store, codec)
        self.steps = Steps(kept)
        self.checkpoints = Checkpoints(self.store, codec, self.upkeep)
        recorder = Recorder(self.store, codec, kept, self.upkeep)
        self.journal = Journal(
            (self.steps, recorder, self.checkpoints),
            self.begin,
            self.upkeep.ticked,
            tail,
            codec.encode,
            self.store.note_life,
            power and folder is not None,
            left,
            self.upkeep.hurry,
            lambda: self.steps.is_watched,
            self.upkeep.settled,
        )

    def start(self) -> None:
        """Start the threads."""
        self.journal.start()
        self.upkeep.start()

    def settle(self) -> None:
        """Have all that was told so far in the store, the steps and the checkpoints.

        Nothing in the history does so when it is read: whoever asks it from outside does, and the upkeep. Locks of the
        history are taken while it settles, so that nobody may call this who holds one.
        """
        self.journal.settle()

    def close(self) -> None:
        """Write what is left, and a checkpoint where the next kernel may begin; let others use the folder."""
        self.upkeep.close(checkpoint=self._folder is not None)
        self.journal.close()
        self.close_files()

    def close_files(self) -> None:
        """Close what is open, of a history that was not started."""
        self.store.close()
        if self._last_tick is not None:
            self._last_tick.close()
        if self._folder is not None:
            self._folder.close()

    def _other_versions(self) -> list[str]:
        changed = self._folder.changed_versions() if self._folder else ""
        where = self._folder and self._folder.path
        return [f"{where} was written with {changed}: what is replayed may differ in the last bits"] if changed else []
