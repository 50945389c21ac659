"""Hash of a tick: eight bytes of all joints, by which a replay is compared with what was, and robots are told apart.

Four bytes are of all joints together. Each of the other four is of every fourth robot, so that a difference says where
it is. It finds what differs by accident; nobody is kept from making two worlds of one hash.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import groupby
from operator import itemgetter
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.world.state import State
from virtualrobot_kernel.world.structure import Structure

LANES = 4
"""Number of parts into which robots are told apart."""

BYTES = 4 + LANES

TICKS_AT_ONCE = 50
"""Number of ticks that are hashed at once."""

# Odd constants of Steele, Lea and Flood, "Fast splittable pseudorandom number generators" (OOPSLA 2014).
_GOLDEN, _MIX = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBF58476D1CE4E5B9)


class Joints(Protocol):
    """Joints of a state."""

    @property
    def q(self) -> NDArray[np.float64]:
        """Coordinates."""
        ...

    @property
    def v(self) -> NDArray[np.float64]:
        """Velocities."""
        ...


def tick_hash(structure: Structure, state: State) -> bytes:
    """Return the hash of all coordinates and velocities of a state, to their last bit."""
    return hashes_of([(structure, state)])


def hashes_of(ticks: Iterable[tuple[Structure, Joints]]) -> bytes:
    """Return the hashes of ticks, one after another; of many it is little more work than of one."""
    groups = groupby(ticks, key=itemgetter(0))
    return b"".join(_hashes(structure, [state for _, state in ticks]) for structure, ticks in groups)


def _hashes(structure: Structure, states: Sequence[Joints]) -> bytes:
    order, starts, lanes, factors = _layout(structure)
    if not len(order):
        return bytes(BYTES * len(states))
    moved: list[Joints] = []  # most ticks of most worlds change no joint
    places: list[int] = []
    for state in states:
        if not moved or moved[-1].q is not state.q or moved[-1].v is not state.v:
            moved.append(state)
        places.append(len(moved) - 1)
    joints = [np.array([one.q for one in moved]), np.array([one.v for one in moved])]
    words = np.concatenate(joints, axis=1).view(np.uint64)[:, order]
    words = (words ^ (words >> np.uint64(32))) * factors
    words = (words ^ (words >> np.uint64(29))) * _MIX
    sums = np.zeros((len(moved), LANES), np.uint64)
    sums[:, lanes] = np.add.reduceat(words ^ (words >> np.uint64(32)), starts, axis=1)
    whole = np.bitwise_xor.reduce(sums * _factors(LANES), axis=1, keepdims=True) * _MIX
    hashes = np.empty((len(moved), BYTES), np.uint8)
    hashes[:, :4] = (whole >> np.uint64(32)).astype("<u4").view(np.uint8)
    hashes[:, 4:] = (sums * _MIX) >> np.uint64(56)
    return hashes[places].tobytes()


def differing_robots(structure: Structure, one: bytes, other: bytes) -> list[int]:
    """Return the robots (uids) that two hashes of a tick may differ by; all where the hashes don't tell."""
    lanes = {lane for lane in range(LANES) if one[4 + lane] != other[4 + lane]}
    robots = sorted(structure.robots)
    return [uid for place, uid in enumerate(robots) if place % LANES in lanes] or robots


@lru_cache(maxsize=8)
def _layout(
    structure: Structure,
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp], NDArray[np.uint64]]:
    """Return the places of q and v by lanes, where each lane begins, which lanes there are, and a factor for each."""
    by_lane: list[list[int]] = [[] for _ in range(LANES)]
    for place, uid in enumerate(sorted(structure.robots)):
        robot, lane = structure.robots[uid], by_lane[place % LANES]
        lane += range(structure.q_count)[robot.q_slice]
        lane += (structure.q_count + at for at in range(structure.v_count)[robot.v_slice])
    lanes = [lane for lane in range(LANES) if by_lane[lane]]
    starts = np.cumsum([0, *(len(by_lane[lane]) for lane in lanes)])[:-1]
    order = np.array([at for lane in lanes for at in by_lane[lane]], np.intp)
    return order, starts, np.array(lanes, np.intp), _factors(len(order))


def _factors(count: int) -> NDArray[np.uint64]:
    return (np.arange(1, count + 1, dtype=np.uint64) * _GOLDEN) | np.uint64(1)
