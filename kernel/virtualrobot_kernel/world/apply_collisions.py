"""Commands about collisions: allowed pairs of nodes, and the settings of collision handling."""

from __future__ import annotations

from dataclasses import replace

from virtualrobot_kernel.errors import KernelError, LimitError, Reason
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.collisions import (
    LONGEST_LOOK_AHEAD_SECONDS,
    MOST_PADDING_METERS,
    STOP_AHEAD_SECONDS,
    STOPPING,
    Allowance,
    CollisionMode,
)
from virtualrobot_kernel.world.commands import SetAllowedPairs, SetCollisionSettings
from virtualrobot_kernel.world.structure import Kind, Structure


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
    """Forbid pairs that clients or imports have allowed, then allow others; one that is allowed gets the new reason.

    Raises KernelError (UNKNOWN_NAME) when a pair is to be forbidden that neither has allowed.
    """
    pairs = dict(change.state.allowed_pairs)
    for first, second in command.forbid:
        pair = node_pair(change.structure, first, second)
        if pairs.pop(pair, None) is None:
            raise KernelError(
                f"neither a client nor an import has allowed {first!r} and {second!r} to touch; pairs that are "
                "allowed by rule stay so",
                reason=Reason.UNKNOWN_NAME,
                first=first,
                second=second,
            )
    for of_kind, built in ((command.built, True), (command.allow, False)):
        for first, second, why in of_kind:
            pairs[node_pair(change.structure, first, second)] = Allowance(why, built)
    return replace(change, state=replace(change.state, allowed_pairs=pairs))


def set_collision_settings(change: Change, command: SetCollisionSettings, forward: Forward) -> Change:
    """Change what is done about collisions.

    Raises UnknownNameError for a robot or node that there is not, LimitError for a look-ahead or padding out of range.
    """
    before, structure = change.state.collisions, change.structure
    modes = dict(before.modes)
    paddings = dict(before.paddings)
    for name, mode in command.modes:
        uid = structure.node(name, Kind.ROBOT).uid
        if mode is None:
            modes.pop(uid, None)
        else:
            modes[uid] = mode
    for name, padding in command.paddings:
        uid = structure.node(name).uid
        if not 0.0 <= padding <= MOST_PADDING_METERS:
            raise LimitError(
                f"the padding of {name!r} must be 0 to {MOST_PADDING_METERS:g} m, not {padding:g}",
                node=name,
                value=padding,
                lower=0.0,
                upper=MOST_PADDING_METERS,
            )
        paddings.pop(uid, None)
        if padding:
            paddings[uid] = padding
    mode = command.mode or before.mode
    ahead = before.look_ahead_seconds if command.look_ahead_seconds is None else command.look_ahead_seconds
    if command.look_ahead_seconds is None and not STOPPING & {before.mode, *before.modes.values()}:
        # Nobody was looked ahead for, so it changes nothing for robots that the command does not name.
        ahead = ahead or (STOP_AHEAD_SECONDS if CollisionMode.STOP in (mode, *modes.values()) else 0.0)
    if not 0.0 <= ahead <= LONGEST_LOOK_AHEAD_SECONDS:
        raise LimitError(
            f"look_ahead_seconds must be 0 to {LONGEST_LOOK_AHEAD_SECONDS:g}, not {ahead:g}",
            value=ahead,
            lower=0.0,
            upper=LONGEST_LOOK_AHEAD_SECONDS,
        )
    # The same object where nothing of it changes: collision scenes look whether it is.
    kept = paddings if command.paddings else before.paddings
    settings = replace(before, mode=mode, modes=modes, look_ahead_seconds=ahead, paddings=kept)
    return replace(change, state=replace(change.state, collisions=settings))
