"""Collisions: what touches and may not, how far things are apart, and which nodes may touch each other."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot.allowed_pairs import AllowedPairs
from virtualrobot.collision_meshes import CollisionMesh, list_meshes, use_hulls
from virtualrobot.collision_values import Collision, collision_of, point_of
from virtualrobot.collision_watch import CollisionReport, watch_collisions
from virtualrobot.configurations import ConfigurationsCheck, check_message, gathered
from virtualrobot.dynamics import Samples
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot.v1 import collision_pb2
from virtualrobot.wire import Stamp, joint_map, stamp_of

Configurations = Mapping[str, Mapping[str, float]]
"""Joint positions (radians or meters) by joint, by robot."""

DETAILS = {
    "first": collision_pb2.COLLISION_DETAIL_FIRST,
    "pairs": collision_pb2.COLLISION_DETAIL_PAIRS,
    "contacts": collision_pb2.COLLISION_DETAIL_CONTACTS,
}

MODES = {
    "off": collision_pb2.COLLISION_MODE_OFF,
    "monitor": collision_pb2.COLLISION_MODE_MONITOR,
    "stop": collision_pb2.COLLISION_MODE_STOP,
    "guard": collision_pb2.COLLISION_MODE_GUARD,
}


@dataclass(frozen=True, slots=True)
class Check:
    """What touches: true where something does.

    Attributes:
        pairs: the pairs that touch and may not.
        seconds: the time that the check took, without the call.
        stamp: when the world was as it was checked.
    """

    pairs: tuple[Collision, ...]
    seconds: float
    stamp: Stamp

    def __bool__(self) -> bool:
        """Return whether anything touches."""
        return bool(self.pairs)


@dataclass(frozen=True, slots=True, eq=False)
class Distance:
    """How far two nodes are apart.

    Attributes:
        first: the name of a node, and `second` that of another one.
        distance: in meters, less the paddings of both; 0 where they touch.
        points: (2, 3) the nearest point of the true surface of each, in the world's frame.
    """

    first: str
    second: str
    distance: float
    points: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class GuardCost:
    """What guarding has cost.

    Attributes:
        ticks: how many were checked.
        mean_seconds: the mean time of one, in s of the wall clock, and `worst_seconds` the longest.
    """

    ticks: int
    mean_seconds: float
    worst_seconds: float


@dataclass(frozen=True, slots=True)
class CollisionSettings:
    """What is done about collisions.

    Attributes:
        mode: for robots without a mode of their own: off, monitor, stop or guard.
        robots: the modes of robots that have one of their own.
        look_ahead_seconds: how far ahead running motions are checked; 0 means not at all.
        paddings: by how much the figures of nodes count as thicker, in meters.
    """

    mode: str
    robots: Mapping[str, str]
    look_ahead_seconds: float
    paddings: Mapping[str, float]


class Collisions:
    """Collisions in the world of one kernel.

    Example:
        >>> if found := client.collisions.check():
        ...     print(found.pairs[0].first, "touches", found.pairs[0].second)
        >>> client.collisions.distance("arm")
    """

    def __init__(self, services: Services) -> None:
        """Handle the collisions of one kernel."""
        self._services = services
        self.allowed = AllowedPairs(services)

    def check(
        self, configurations: Configurations | None = None, *, detail: str = "pairs", robots: Iterable[str] = ()
    ) -> Check:
        """Return what touches and may not, now or if robots stood elsewhere.

        Checked are robots (with what they hold) with themselves, each other and everything else.

        Args:
            configurations: joint positions of robots that stand elsewhere, by joint, by robot.
            detail: `first` ends with the first pair, `pairs` tells all, `contacts` tells where and how deep too.
            robots: only pairs with these robots are checked; none means all.

        Raises:
            UnknownNameError: when there is no such robot or joint.
            LimitError: when a joint cannot be there.
        """
        if detail not in DETAILS:
            raise InvalidArgumentError(f"detail is one of {', '.join(DETAILS)}, not {detail!r}")
        request = collision_pb2.CheckCollisionRequest(
            configurations=_messages(configurations), detail=DETAILS[detail], robots=robots
        )
        response = self._services.collision.CheckCollision(request, timeout=LONG_TIMEOUT_SECONDS)
        return Check(tuple(map(collision_of, response.pairs)), response.check_seconds, stamp_of(response.stamp))

    def check_configurations(
        self,
        robot: str,
        positions: Samples,
        *,
        joint_names: Sequence[str] = (),
        others: Mapping[str, Samples] | None = None,
        robots: Iterable[str] = (),
        progress: Callable[[float], None] | None = None,
    ) -> ConfigurationsCheck:
        """Return which of n configurations are free, in the world as it is now.

        The kernel checks them in processes of their own, some thousands a second.

        Args:
            robot: the robot that stands elsewhere.
            positions: (n, k) radians or meters, a column for each joint, or (n,) by joint name. The other joints stay
                where they are.
            joint_names: what the columns are; without them all joints of one coordinate, in the robot's order.
            others: more robots that stand elsewhere, each with n rows: of all its joints, or (n,) by joint name.
            robots: only pairs with these robots are checked; none means all.
            progress: is called with the part that is done, 0 to 1; what it raises ends the check.

        Raises:
            UnknownNameError: when there is no such robot or joint.
            LimitError: when a joint cannot be there.
            InvalidArgumentError: for arrays of other shapes, or that hold numbers that are not finite.

        Example:
            >>> found = client.collisions.check_configurations("arm", samples)
            >>> print(samples[found.free])
        """
        if others and robot in others:
            raise InvalidArgumentError(f"{robot!r} is among the others too; give its joints once")
        asked = {robot: (positions, joint_names), **{name: (rows, ()) for name, rows in (others or {}).items()}}
        request = check_message(asked, robots)
        with self._services.collision.CheckConfigurations(request) as stream:
            return gathered(stream, request.configurations[0].positions.shape[0], progress)

    def distance(self, *first: str, to: Iterable[str] = (), configurations: Configurations | None = None) -> Distance:
        """Return how far some nodes, such as a robot, are from everything else: the nearest pair that may not touch.

        Args:
            first: nodes, each with all below it.
            to: the other nodes, each with all below it; none means all but the first ones.
            configurations: joint positions of robots that stand elsewhere, by joint, by robot.

        Raises:
            UnknownNameError: when there is no such node.
            InvalidArgumentError: when no node is named, or there is no pair to measure.
        """
        found = self._distances(first, to, 0.0, configurations)
        if not found:
            raise InvalidArgumentError(f"there is nothing from which {', '.join(first)} could keep a distance")
        return found[0]

    def distances(
        self,
        *first: str,
        range_meters: float,
        to: Iterable[str] = (),
        configurations: Configurations | None = None,
    ) -> list[Distance]:
        """Return all pairs of nodes that are at most so far apart and may not touch, the nearest first.

        The arguments are those of `distance`; a range of 0 is refused.
        """
        if not range_meters > 0.0:
            raise InvalidArgumentError(f"range_meters must be above 0, not {range_meters}; `distance` has no range")
        return self._distances(first, to, range_meters, configurations)

    def _distances(
        self, first: Iterable[str], second: Iterable[str], range_meters: float, configurations: Configurations | None
    ) -> list[Distance]:
        request = collision_pb2.MeasureDistancesRequest(
            first=first, second=second, range_meters=range_meters, configurations=_messages(configurations)
        )
        response = self._services.collision.MeasureDistances(request, timeout=LONG_TIMEOUT_SECONDS)
        return [
            Distance(
                pair.first,
                pair.second,
                pair.distance_meters,
                np.array([point_of(pair.first_point), point_of(pair.second_point)]),
            )
            for pair in response.pairs
        ]

    def meshes(self, *nodes: str) -> list[CollisionMesh]:
        """Return what the meshes of nodes and all below them collide as, and what is wrong with them; none means all.

        Raises UnknownNameError when there is no such node.
        """
        return list_meshes(self._services, nodes)

    def use_hulls(self, *nodes: str, vertices: int = 64) -> list[CollisionMesh]:
        """Have the meshes of nodes and of all below them collide as their convex hulls; return what they do then.

        A hull is a solid, quicker than a mesh of many triangles, and closes holes and hollows. One with few corners
        counts as thicker by as much as the mesh reaches out of it, so that nothing is missed. Saved with the scene.

        Args:
            nodes: at least one.
            vertices: the most corners of a hull, 4 to 256; 0 has the meshes collide as their triangles again.

        Raises:
            UnknownNameError: when there is no such node.
            LimitError: for another number of vertices.
        """
        if not nodes:
            raise InvalidArgumentError("name the nodes whose meshes shall collide as hulls")
        use_hulls(self._services, nodes, vertices)
        return self.meshes(*nodes)

    def watch(self) -> Iterator[CollisionReport]:
        """Yield what touches now, of robots whose mode is not off, and then what begins and ends as it happens.

        Whoever reads slowly gets the latest, and the last 1,000 events that he has missed.

        Example:
            >>> for report in client.collisions.watch():
            ...     for event in report.events:
            ...         print(event)
        """
        return watch_collisions(self._services)

    @property
    def settings(self) -> CollisionSettings:
        """What is done about collisions."""
        settings = self._services.collision.GetCollisionSettings(collision_pb2.GetCollisionSettingsRequest()).settings
        return CollisionSettings(
            _mode_name(settings.mode),
            {robot.robot: _mode_name(robot.mode) for robot in settings.robots},
            settings.look_ahead_seconds,
            {node.node: node.padding_meters for node in settings.paddings},
        )

    @property
    def guard_cost(self) -> GuardCost:
        """What guarding has cost since the kernel's start."""
        cost = self._services.collision.GetCollisionSettings(collision_pb2.GetCollisionSettingsRequest()).guard_cost
        return GuardCost(cost.ticks, cost.mean_seconds, cost.worst_seconds)

    def set(
        self,
        mode: str = "",
        *,
        robots: Mapping[str, str] | None = None,
        look_ahead_seconds: float | None = None,
        paddings: Mapping[str, float] | None = None,
    ) -> None:
        """Change what is done about collisions; what is not given stays. Saved with the scene.

        Args:
            mode: for robots without a mode of their own: `off`, `monitor` (they are reported), `stop` (and stop the
                robots) or `guard` (robots brake before they collide).
            robots: robots that get a mode of their own; an empty one takes it away.
            look_ahead_seconds: how far ahead running motions are checked, 0 to 60; 0 means not at all.
            paddings: by how much the figures of nodes count as thicker, 0 to 1 m: two nodes touch where they are nearer
                than the paddings of both together.

        Raises:
            UnknownNameError: when there is no such robot or node.
            LimitError: for a look-ahead or a padding out of range.
        """
        request = collision_pb2.SetCollisionSettingsRequest(
            mode=_mode(mode),
            robots=[
                collision_pb2.RobotCollisionMode(robot=robot, mode=_mode(own)) for robot, own in (robots or {}).items()
            ],
            look_ahead_seconds=look_ahead_seconds,
            paddings=[
                collision_pb2.NodePadding(node=node, padding_meters=padding)
                for node, padding in (paddings or {}).items()
            ],
        )
        self._services.collision.SetCollisionSettings(request)


def _messages(configurations: Configurations | None) -> Iterator[collision_pb2.RobotConfiguration]:
    for robot, positions in (configurations or {}).items():
        yield collision_pb2.RobotConfiguration(robot=robot, joint_positions=joint_map(positions))


def _mode(name: str) -> collision_pb2.CollisionMode:
    if name and name not in MODES:
        raise InvalidArgumentError(f"a collision mode is one of {', '.join(MODES)}, not {name!r}")
    return MODES[name] if name else collision_pb2.COLLISION_MODE_UNSPECIFIED


def _mode_name(mode: collision_pb2.CollisionMode) -> str:
    return next(name for name, number in MODES.items() if number == mode)
