"""Brakes of robots that are played, in each tick: where each of them goes if all that moves brakes now.

They are those of `braking_of`, to the last bit, without the rest of the world: its coordinates are many, and most ticks
move each robot by one motion of its own.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.drivers.twin import Columns, Floats
from virtualrobot_kernel.world.apply_motions import override
from virtualrobot_kernel.world.braking import LONGEST_BRAKE_TICKS, brakes_alone, braking_of, way_of
from virtualrobot_kernel.world.change import Forward
from virtualrobot_kernel.world.state import State
from virtualrobot_kernel.world.structure import Structure


class Brakes:
    """Brakes of a cell's robots; it keeps which motions move just what a robot plays."""

    def __init__(self, forward: Forward) -> None:
        """Know nothing yet."""
        self._forward = forward
        self._known: dict[int, tuple[NDArray[np.int32], Columns, bool]] = {}

    def of(
        self, places: Mapping[int, Columns], structure: Structure, state: State, tick_seconds: float
    ) -> Mapping[int, Floats] | None:
        """Return where robots (uids) go, at their places in q, if all brakes now (m, k), a tick apart.

        m is the same for all of them; None where that takes too long.
        """
        found: dict[int, Floats] = {}
        for motion in state.motions:
            for uid in motion.robots:
                if uid not in places:
                    continue
                if len(motion.robots) > 1 or uid in found or not brakes_alone(motion):
                    return self._of_all(places, structure, state, tick_seconds)
                if not self._are_same(uid, motion.q_index, places[uid]):
                    return self._of_all(places, structure, state, tick_seconds)
                found[uid] = way_of(motion, override(state, motion), tick_seconds).positions
        count = max(map(len, found.values()), default=1)
        if count > LONGEST_BRAKE_TICKS:
            return None
        for uid, columns in places.items():
            own = found.get(uid)
            if own is None:
                found[uid] = np.repeat(state.q[columns][None], count, axis=0)
            elif len(own) < count:
                found[uid] = np.concatenate([own, np.repeat(own[-1:], count - len(own), axis=0)])
        return found

    def _of_all(
        self, places: Mapping[int, Columns], structure: Structure, state: State, tick_seconds: float
    ) -> Mapping[int, Floats] | None:
        """Return the same from the way of the world."""
        way = braking_of(places.keys(), structure, state, tick_seconds, self._forward)
        return {uid: way.positions[:, columns] for uid, columns in places.items()} if way.ends else None

    def _are_same(self, uid: int, moved: NDArray[np.int32], columns: Columns) -> bool:
        """Return whether a motion moves just a robot's places in q, in its order; looked at once for each."""
        known = self._known.get(uid)
        if known is not None and known[0] is moved and known[1] is columns:
            return known[2]
        own = np.arange(columns.start, columns.stop) if isinstance(columns, slice) else columns
        same = np.array_equal(moved, own)
        self._known[uid] = moved, columns, same
        return same
