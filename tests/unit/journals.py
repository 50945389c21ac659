"""Journals of worlds that tests make."""

from __future__ import annotations

from collections.abc import Sequence

from virtualrobot_kernel.world.journal import Entry, MemoryJournal
from virtualrobot_kernel.world.store import World


def entries_of(world: World) -> Sequence[Entry]:
    """Return the entries of a world that was made with a MemoryJournal, oldest first."""
    assert isinstance(world.journal, MemoryJournal)
    return world.journal.entries()
