"""Ticks in the rings of robots that real ones play, in compiled code.

A tick of k joints is kept as `virtualrobot_sdk.drivers.shared` has it: a sequence number that is odd while it is
written, the CRC-32 of all that follows, the tick, when it is played (ns), outputs, the rows of its brake; then q (k,),
v (k,) and the brake (rows, k).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from virtualrobot_sdk.compiled.cache import inlined

from virtualrobot_kernel.numeric.checksum import crc32_of
from virtualrobot_kernel.numeric.memory import fence, floats_at, integers_at

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]

ROBOT = range(11)
MEMORY, SLOT_WORDS, SLOTS, ROBOT_JOINTS, PLACES, OUTPUTS, LEAD, MOST_ROWS, GOES, WAY, WAY_ROWS = ROBOT
"""Columns of a robot's addresses and counts, in the table that `brakes_ahead` takes."""

STANDS_STILL, BY_ROWS = -1, -2
"""Marks of robots that go the way of no motion in the table: they stand, or go the rows at an address."""

_CHECKED, _JOINTS = 2, 6
"""Words before those that are in the checksum, and before the joints."""


@inlined
def write_tick(
    robot: Integers,
    places: Integers,
    q: Floats,
    v: Floats,
    tick: int,
    due: int,
    way: Floats,
    length: int,
    rows: int,
) -> None:
    """Write a tick of a robot, with so many rows of its brake: those of its way, the last of them again and again.

    way (length * k,): rows of its joints; empty where it stands. The rest is told in `brakes_ahead`.
    """
    count = robot[ROBOT_JOINTS]
    begin = robot[PLACES]
    address = robot[MEMORY] + 8 * robot[SLOT_WORDS] * (tick % robot[SLOTS])
    size = _JOINTS + (2 + rows) * count
    words = integers_at(address, size)
    joints = floats_at(address + 8 * _JOINTS, (2 + rows) * count)
    words[0] = 2 * tick + 1
    fence()
    words[2] = tick
    words[3] = due + robot[LEAD]
    words[4] = robot[OUTPUTS]
    words[5] = rows
    for joint in range(count):
        joints[joint] = q[places[begin + joint]]
        joints[count + joint] = v[places[begin + count + joint]]
    known = min(rows, length) if way.shape[0] > 0 else 0
    last = (known - 1) * count
    for place in range(known * count):
        joints[2 * count + place] = way[place]
    for row in range(known, rows):
        for joint in range(count):
            joints[(2 + row) * count + joint] = way[last + joint] if known > 0 else joints[joint]
    words[1] = crc32_of(words[_CHECKED:])
    fence()
    words[0] = 2 * tick + 2
