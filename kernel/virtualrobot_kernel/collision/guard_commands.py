"""Commands that a guarded world refuses: those that put something into touch with a guarded robot."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.node_pairs import movers, moves, names_of
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.commands import Command, SetToolState
from virtualrobot_kernel.world.state import Snapshot


def check(before: Snapshot, after: Snapshot, batch: Sequence[Command], touching: Iterable[Pair]) -> None:
    """Raise KernelError (COLLISION) when commands have brought one of these pairs (uids) into touch.

    Two nodes that stand to each other as they did, with the same figures, touched before: that is asked only now, as of
    a part that was picked from a table, or is let go. What a tool closes on, it may touch.
    """
    tools = {after.structure.node(one.tool).uid for one in batch if isinstance(one, SetToolState)}
    hands = {robot.uid for tool in tools if (robot := after.structure.robot_of(tool))}
    for pair in sorted(touching):
        if not _stood_so(before, after, pair) and hands.isdisjoint(movers(pair, after.structure)):
            first, second = names_of(pair, after.structure)
            raise KernelError(
                f"{first!r} would touch {second!r}, and a guarded robot may not; put it elsewhere, let the two "
                "touch, or end the guard",
                reason=Reason.COLLISION,
                first=first,
                second=second,
            )


def _stood_so(before: Snapshot, after: Snapshot, pair: Pair) -> bool:
    """Return whether two nodes were there before, with the same figures, and as they are seen from each other."""
    for uid in pair:
        node = before.structure.nodes.get(uid)
        if node is None or node.figures is not after.structure.nodes[uid].figures:
            return False
    return not moves(before, after, pair)
