"""Settings and pairs of collisions: messages to commands, and settings to messages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from virtualrobot.v1 import collision_pb2, nodes_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import FINITE, EnumTable, Pair, named
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import SetAllowedPairs, SetCollisionSettings
from virtualrobot_kernel.world.state import Snapshot

V = TypeVar("V")

_MODES = EnumTable(CollisionMode, collision_pb2.CollisionMode)
MODE = Pair(lambda number, what: _MODES.read(number, what) if number else None, _MODES.write)
ROBOTS = named(collision_pb2.RobotCollisionMode, "mode", MODE, key="robot")
PADDINGS = named(collision_pb2.NodePadding, "padding_meters", key="node")


def settings_command(
    message: collision_pb2.SetCollisionSettings | collision_pb2.CollisionSettings,
) -> SetCollisionSettings:
    """Return the command of a message, or of a scene file; raise KernelError for what is not finite or named twice."""
    said = isinstance(message, collision_pb2.CollisionSettings) or message.HasField("look_ahead_seconds")
    return SetCollisionSettings(
        mode=MODE.read(message.mode, "mode"),
        modes=tuple(ROBOTS.read(message.robots, "robots").items()),
        look_ahead_seconds=FINITE.read(message.look_ahead_seconds, "look_ahead_seconds") if said else None,
        paddings=tuple(PADDINGS.read(message.paddings, "paddings").items()),
    )


def pairs_command(message: collision_pb2.SetAllowedPairs) -> SetAllowedPairs:
    """Return the command of a message; raise KernelError where it says nothing to do."""
    if not message.allow and not message.forbid:
        raise KernelError("there is no pair to allow or to forbid", field="allow")
    forbid = tuple((pair.first, pair.second) for pair in _named(message.forbid, "forbid"))
    return replace(allowing(_named(message.allow, "allow")), forbid=forbid)


def pairs_of(pairs: Sequence[nodes_pb2.NodePair]) -> list[tuple[str, str]]:
    """Return the names of pairs that `may_touch`; raise KernelError for one without."""
    return [(pair.first, pair.second) for pair in _named(pairs, "may_touch")]


def allowing(pairs: Iterable[nodes_pb2.NodePair]) -> SetAllowedPairs:
    """Return the command that lets pairs touch, as clients or imports say."""
    pairs = tuple(pairs)
    by_client, built = (
        tuple((pair.first, pair.second, pair.reason) for pair in pairs if pair.built is kind) for kind in (False, True)
    )
    return SetAllowedPairs(by_client, built=built)


def settings_message(snapshot: Snapshot) -> collision_pb2.CollisionSettings:
    """Return what is done about collisions as a message, robots and nodes in the order of the nodes."""
    settings, nodes = snapshot.state.collisions, snapshot.structure.nodes

    def by_name(values: Mapping[int, V]) -> dict[str, V]:
        return {node.name: values[uid] for uid, node in nodes.items() if uid in values}

    return collision_pb2.CollisionSettings(
        mode=MODE.write(settings.mode),
        robots=ROBOTS.write(by_name(settings.modes)),
        look_ahead_seconds=settings.look_ahead_seconds,
        paddings=PADDINGS.write(by_name(settings.paddings)),
    )


def _named(pairs: Sequence[nodes_pb2.NodePair], field: str) -> Sequence[nodes_pb2.NodePair]:
    for row, pair in enumerate(pairs):
        for side in ("first", "second"):
            if not getattr(pair, side):
                raise KernelError(f"{field}[{row}].{side} names no node", field=f"{field}[{row}].{side}")
    return pairs
