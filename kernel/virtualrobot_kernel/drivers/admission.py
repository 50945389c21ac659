"""Commands that a world refuses while real robots play what their twins in it do. Pure."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence

import numpy as np

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.affected_robots import robots_of_records
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.history_commands import RestartWorld, RestoreRecords, RestoreWorld
from virtualrobot_kernel.world.state import Snapshot, unchanged

MOVED = 1e-9
"""Distance (rad, m) and part of a rotation beyond which something stands elsewhere."""


def check(
    before: Snapshot, after: Snapshot, batch: Sequence[Command], robots: Collection[int], ready: Collection[int]
) -> None:
    """Raise KernelError (WRONG_STATE) when commands put the twin of a connected robot elsewhere, or end its guard.

    Args:
        before: the world without the commands.
        after: the world with them.
        batch: what they are.
        robots: the uids of those whose robots play what they do.
        ready: those of them that may begin to move.
    """
    for uid in robots:
        name = before.structure.nodes[uid].name
        refuse = _refusal(name)
        if any(isinstance(one, RestoreWorld | RestartWorld) for one in batch):
            raise refuse("the world cannot be put back to another state")
        if uid not in after.structure.robots:
            raise refuse("it cannot be removed")
        for one in batch:
            if isinstance(one, RestoreRecords) and uid in robots_of_records(before.structure, before.state, one):
                raise refuse("what was changed of it cannot be taken back")
        if after.structure is not before.structure and _described(after, uid) != _described(before, uid):
            raise refuse("its joints cannot be changed")
        if not np.array_equal(after.state.q[_places(after, uid)], before.state.q[_places(before, uid)]):
            raise refuse("its joints cannot be put elsewhere; move them by a motion")
        if np.abs(after.world_t(uid) - before.world_t(uid)).max() > MOVED:
            raise refuse("it cannot be put elsewhere")
        if uid in after.state.commanded and uid not in before.state.commanded:
            raise refuse("its joints cannot be measured by anybody else")
        if after.state.collisions is not before.state.collisions and not is_guarded(after, uid):
            raise refuse("the collision guard must stay on for it")
    _check_started(before, after, set(robots).difference(ready))


def check_orders(before: Snapshot, after: Snapshot, refusals: Mapping[int, KernelError]) -> None:
    """Raise the error of a robot (uid) that has one, where a motion begins to move it."""
    for uid in _started(before, after):
        if uid in refusals:
            raise refusals[uid]


def is_guarded(snapshot: Snapshot, uid: int) -> bool:
    """Return whether the collision guard is on for a robot."""
    return snapshot.state.collisions.modes_of(snapshot.structure)[uid] is CollisionMode.GUARD


def _check_started(before: Snapshot, after: Snapshot, unready: Collection[int]) -> None:
    """Raise KernelError for a motion that begins to move a robot which is not ready."""
    for uid in _started(before, after):
        if uid in unready:
            raise _refusal(before.structure.nodes[uid].name)("it begins or ends to execute; wait until it has")


def _started(before: Snapshot, after: Snapshot) -> Iterator[int]:
    """Yield the robots (uids) that motions begin to move."""
    if unchanged(before.state.motions, after.state.motions):
        return
    known = {motion.id for motion in before.state.motions}
    for motion in after.state.motions:
        if motion.id not in known:
            yield from motion.robots


def _refusal(name: str) -> Callable[[str], KernelError]:
    def refuse(what: str) -> KernelError:
        return KernelError(
            f"a real robot is connected to {name!r} and does what it does: {what}, or set its mode to SIMULATED first",
            reason=Reason.WRONG_STATE,
            robot=name,
            aspect="driver",
        )

    return refuse


def _places(snapshot: Snapshot, uid: int) -> slice:
    return snapshot.structure.robots[uid].q_slice


def _described(snapshot: Snapshot, uid: int) -> tuple[object, ...]:
    """Return what a driver has been told of a robot's joints."""
    return snapshot.structure.robots[uid].joints
