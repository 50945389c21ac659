"""Ghosts of twins in the browser, which go wherever their robots are commanded or measured."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import viser
from numpy.typing import NDArray

from virtualrobot_kernel.drawing.batches import BatchLayer
from virtualrobot_kernel.drawing.inventory import BatchKey, Inventory, figures_only
from virtualrobot_kernel.drawing.library import ShapeLibrary
from virtualrobot_kernel.drawing.twin_ghosts import GhostKind, TwinGhost, ghost_poses, twin_figures
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Structure


class TwinLayer:
    """Owns the handles of ghosts; while there are none, drawing costs nothing."""

    def __init__(self, server: viser.ViserServer, library: ShapeLibrary) -> None:
        """Draw on `server` what `library` makes."""
        self._batches = BatchLayer(server, library, "twin")
        self._used: frozenset[BatchKey] = frozenset()
        self._shown: tuple[tuple[int, GhostKind], ...] = ()
        self._of: tuple[Structure, Mapping[int, str]] | None = None
        self._drawn: tuple[NDArray[np.float64], tuple[bytes, ...]] | None = None

    def draw(self, snapshot: Snapshot, ghosts: tuple[TwinGhost, ...]) -> None:
        """Show these ghosts and no others."""
        shown = tuple((one.robot, one.kind) for one in ghosts)
        states = snapshot.state.tool_states
        arranged = shown != self._shown or bool(
            shown and (self._of is None or self._of[0] is not snapshot.structure or self._of[1] != states)
        )
        if arranged:
            inventory = figures_only(snapshot.structure, twin_figures(snapshot, ghosts))
            # What a robot's ghost is made of stays in the browser for the next time that it is elsewhere.
            same = self._of is not None and self._of[0] is snapshot.structure
            self._used = inventory.used | (self._used if same else frozenset())
            self._batches.arrange(Inventory({}, {}, (), inventory.batches, self._used))
            self._shown, self._of = shown, (snapshot.structure, states)
        places = snapshot.world_t_node, tuple(one.q.tobytes() for one in ghosts)
        if ghosts and (arranged or self._drawn is None or not _same(self._drawn, places)):
            self._batches.pose(ghost_poses(snapshot, ghosts))
        self._drawn = places


def _same(
    before: tuple[NDArray[np.float64], tuple[bytes, ...]], now: tuple[NDArray[np.float64], tuple[bytes, ...]]
) -> bool:
    return before[0] is now[0] and before[1] == now[1]
