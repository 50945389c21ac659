"""Commands about collisions: which nodes may touch each other."""

from __future__ import annotations

from dataclasses import replace

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.commands import SetAllowedPairs
from virtualrobot_kernel.world.structure import Structure


def node_pair(structure: Structure, first: str, second: str) -> tuple[int, int]:
    """Return two nodes (uids, the smaller first); raise UnknownNameError for names that there are not.

    Raises KernelError when both are the same node.
    """
    low, high = sorted(structure.node(name).uid for name in (first, second))
    if low == high:
        raise KernelError(
            f"{first!r} is one node; a pair is two different ones (the figures of a node may always touch each other)",
            node=first,
        )
    return low, high


def set_allowed_pairs(change: Change, command: SetAllowedPairs, forward: Forward) -> Change:
    """Forbid pairs that clients have allowed, then allow others; one that is allowed already gets the new reason.

    Raises KernelError (UNKNOWN_NAME) when a pair is to be forbidden that no client has allowed.
    """
    pairs = dict(change.state.allowed_pairs)
    for first, second in command.forbid:
        pair = node_pair(change.structure, first, second)
        if pairs.pop(pair, None) is None:
            raise KernelError(
                f"no client has allowed {first!r} and {second!r} to touch; pairs that are allowed by rule stay so",
                reason=Reason.UNKNOWN_NAME,
                first=first,
                second=second,
            )
    for first, second, why in command.allow:
        pairs[node_pair(change.structure, first, second)] = why
    return replace(change, state=replace(change.state, allowed_pairs=pairs))
