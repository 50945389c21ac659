"""Collision settings: modes of robots, look-ahead, paddings; and the time that guarding costs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypedDict, Unpack

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.options import check_options
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import shown, told
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.v1 import collision_pb2, scene_pb2

MODES = {
    "off": collision_pb2.COLLISION_MODE_OFF,
    "monitor": collision_pb2.COLLISION_MODE_MONITOR,
    "stop": collision_pb2.COLLISION_MODE_STOP,
    "guard": collision_pb2.COLLISION_MODE_GUARD,
}


@dataclass(frozen=True, slots=True)
class GuardCost:
    """Time that guarding has cost.

    Attributes:
        ticks: number of ticks that were checked.
        mean_time: the mean time of a check, in s of the wall clock, and `worst_time` the longest.
    """

    ticks: int
    mean_time: float
    worst_time: float


@shown
@dataclass(frozen=True, slots=True)
class CollisionSettings:
    """Collision settings of a world.

    Attributes:
        mode: for robots without a mode of their own: off, monitor, stop or guard.
        robots: the modes of robots that have one of their own.
        look_ahead: time (s) by which running motions are checked ahead; 0 means not at all.
        paddings: additional thickness of the figures of nodes, in meters, by node.
    """

    mode: str
    robots: Mapping[str, str]
    look_ahead: float
    paddings: Mapping[str, float]


class CollisionOptions(TypedDict, total=False):
    """Options of collision settings; what is not given stays.

    Attributes:
        robots: robots that get a mode of their own; None takes it away.
        look_ahead: time (s) by which running motions are checked ahead, 0 to 60; 0 means not at all. Where it is 0 and
            not given, and the first robot is set to `stop`, it becomes 1 s.
        paddings: by how much the figures of nodes count as thicker, 0 to 1 m: two nodes touch where they are nearer
            than the paddings of both together.
    """

    robots: Mapping[str, str | None] | None
    look_ahead: float | None
    paddings: Mapping[str, float] | None


@checked
class CollisionRules:
    """Handle of the collision settings of one kernel."""

    def __init__(self, services: Services) -> None:
        """Handle the collision settings of one kernel."""
        self._services = services

    @property
    def settings(self) -> CollisionSettings:
        """The collision settings now."""
        settings = self._services.collision.GetCollisionSettings(collision_pb2.GetCollisionSettingsRequest()).settings
        return CollisionSettings(
            _mode_name(settings.mode),
            {robot.robot: _mode_name(robot.mode) for robot in settings.robots},
            settings.look_ahead_seconds,
            {node.node: node.padding_meters for node in settings.paddings},
        )

    @property
    def guard_cost(self) -> GuardCost:
        """Time that guarding has cost since the kernel's start."""
        cost = self._services.collision.GetCollisionSettings(collision_pb2.GetCollisionSettingsRequest()).guard_cost
        return GuardCost(cost.ticks, cost.mean_seconds, cost.worst_seconds)

    def set(self, mode: str | None = None, **options: Unpack[CollisionOptions]) -> None:
        """Change what is done about collisions; what is not given stays. Saved with the scene.

        `mode` is for robots without a mode of their own: `off`, `monitor` (they are reported), `stop` (and stop the
        robots) or `guard` (robots brake before they collide).

        Raises:
            UnknownNameError: when there is no such robot or node.
            LimitError: for a look-ahead or a padding out of range.
        """
        self._services.apply([collision_command(mode, options)])

    def __repr__(self) -> str:
        """Return a line for people."""

        def say() -> str:
            now = self.settings
            own = "".join(f", {robot!r} {mode}" for robot, mode in now.robots.items())
            ahead = f", looks {now.look_ahead:g} s ahead" if now.look_ahead else ""
            return f"mode {now.mode}{own}{ahead}"

        return told(type(self).__name__, say)


def collision_command(mode: str | None, options: CollisionOptions) -> scene_pb2.Command:
    """Return the command that changes what is done about collisions."""
    check_options(options, CollisionOptions, "a setting of collisions")
    command = collision_pb2.SetCollisionSettings(
        mode=_mode(mode),
        robots=[
            collision_pb2.RobotCollisionMode(robot=robot, mode=_mode(own))
            for robot, own in (options.get("robots") or {}).items()
        ],
        look_ahead_seconds=options.get("look_ahead"),
        paddings=[
            collision_pb2.NodePadding(node=node, padding_meters=padding)
            for node, padding in (options.get("paddings") or {}).items()
        ],
    )
    return scene_pb2.Command(set_collision_settings=command)


def _mode(name: str | None) -> collision_pb2.CollisionMode:
    if name is None:
        return collision_pb2.COLLISION_MODE_UNSPECIFIED
    if name not in MODES:
        raise InvalidArgumentError(f"a collision mode is one of {', '.join(MODES)}, not {name!r}")
    return MODES[name]


def _mode_name(mode: collision_pb2.CollisionMode) -> str:
    return next(name for name, number in MODES.items() if number == mode)
