"""Settings and pairs of collisions: messages to commands, and settings to messages."""

from __future__ import annotations

from collections.abc import Container, Sequence

from virtualrobot.v1 import collision_pb2, nodes_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.values import check_enum, finite
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import SetAllowedPairs, SetCollisionSettings
from virtualrobot_kernel.world.state import Snapshot

MODES = {getattr(collision_pb2, f"COLLISION_MODE_{mode.name}"): mode for mode in CollisionMode}
NUMBERS = {mode: number for number, mode in MODES.items()}


def settings_command(
    message: collision_pb2.SetCollisionSettings | collision_pb2.CollisionSettings,
) -> SetCollisionSettings:
    """Return the command of a message, or of a scene file; raise KernelError for what is not finite or named twice."""
    check_enum(message, "mode")
    modes: dict[str, CollisionMode | None] = {}
    for row, robot in enumerate(message.robots):
        check_enum(robot, "mode")
        _once(modes, robot.robot, f"robots[{row}].robot")
        modes[robot.robot] = MODES.get(robot.mode)
    paddings: dict[str, float] = {}
    for row, node in enumerate(message.paddings):
        _once(paddings, node.node, f"paddings[{row}].node")
        paddings[node.node] = finite(node.padding_meters, f"paddings[{row}].padding_meters")
    said = isinstance(message, collision_pb2.CollisionSettings) or message.HasField("look_ahead_seconds")
    return SetCollisionSettings(
        mode=MODES.get(message.mode),
        modes=tuple(modes.items()),
        look_ahead_seconds=finite(message.look_ahead_seconds, "look_ahead_seconds") if said else None,
        paddings=tuple(paddings.items()),
    )


def pairs_command(message: collision_pb2.SetAllowedPairs) -> SetAllowedPairs:
    """Return the command of a message; raise KernelError where it says nothing to do."""
    if not message.allow and not message.forbid:
        raise KernelError("there is no pair to allow or to forbid", field="allow")
    return SetAllowedPairs(
        tuple((pair.first, pair.second, pair.reason) for pair in _named(message.allow, "allow")),
        tuple((pair.first, pair.second) for pair in _named(message.forbid, "forbid")),
    )


def settings_message(snapshot: Snapshot) -> collision_pb2.CollisionSettings:
    """Return what is done about collisions as a message, robots and nodes in the order of the nodes."""
    settings, nodes = snapshot.state.collisions, snapshot.structure.nodes
    return collision_pb2.CollisionSettings(
        mode=NUMBERS[settings.mode],
        robots=[
            collision_pb2.RobotCollisionMode(robot=node.name, mode=NUMBERS[settings.modes[uid]])
            for uid, node in nodes.items()
            if uid in settings.modes
        ],
        look_ahead_seconds=settings.look_ahead_seconds,
        paddings=[
            collision_pb2.NodePadding(node=node.name, padding_meters=settings.paddings[uid])
            for uid, node in nodes.items()
            if uid in settings.paddings
        ],
    )


def _once(known: Container[str], name: str, field: str) -> None:
    if name in known:
        raise KernelError(f"{field} names {name!r} again", field=field)


def _named(pairs: Sequence[nodes_pb2.NodePair], field: str) -> Sequence[nodes_pb2.NodePair]:
    for row, pair in enumerate(pairs):
        for side in ("first", "second"):
            if not getattr(pair, side):
                raise KernelError(f"{field}[{row}].{side} names no node", field=f"{field}[{row}].{side}")
    return pairs
