"""Collisions: what touches and may not, how far things are apart, and which nodes may touch each other."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.messages import Stamp, count_or_default, joint_map, stamp_of
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.showing import shown
from virtualrobot.collisions.allowed_pairs import AllowedPairs
from virtualrobot.collisions.configurations import ConfigurationsCheck, check_message, gathered
from virtualrobot.collisions.meshes import CollisionMesh, list_meshes, use_hulls
from virtualrobot.collisions.settings import CollisionRules
from virtualrobot.collisions.values import Collision, collision_of, point_of
from virtualrobot.collisions.watch import CollisionReport, watch_collisions
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.motions.steps import Named, NodeNamed, name_of
from virtualrobot.robots.dynamics import Samples
from virtualrobot.v1 import collision_pb2

Configurations = Mapping[str, Mapping[str, float]]
"""Joint positions (radians or meters) by joint, by robot."""

DETAILS = {
    "first": collision_pb2.COLLISION_DETAIL_FIRST,
    "pairs": collision_pb2.COLLISION_DETAIL_PAIRS,
    "contacts": collision_pb2.COLLISION_DETAIL_CONTACTS,
}


@shown
@dataclass(frozen=True, slots=True)
class Check:
    """Result of a collision check: true where something touches.

    Attributes:
        pairs: the pairs that touch and may not.
        check_time: the time that the check took, without the call.
        stamp: the instant of the world that was checked.
    """

    pairs: tuple[Collision, ...]
    check_time: float
    stamp: Stamp

    def __bool__(self) -> bool:
        """Return whether anything touches."""
        return bool(self.pairs)


@shown
@dataclass(frozen=True, slots=True, eq=False)
class Distance:
    """Distance between two nodes.

    Attributes:
        first: the name of a node, and `second` that of another one.
        distance: in meters, less the paddings of both; 0 where they touch.
        points: (2, 3) the nearest point of the true surface of each, in the world's frame.
    """

    first: str
    second: str
    distance: float
    points: NDArray[np.float64]


@checked
class Collisions(CollisionRules):
    """Collisions in the world of one kernel.

    Example:
        >>> if found := client.collisions.check():
        ...     print(found.pairs[0].first, "touches", found.pairs[0].second)
        >>> client.collisions.distance("arm")
    """

    def __init__(self, services: Services) -> None:
        """Handle the collisions of one kernel."""
        super().__init__(services)
        self.allowed = AllowedPairs(services)

    def check(
        self, configurations: Configurations | None = None, *, detail: str = "pairs", robots: Iterable[Named] = ()
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
            configurations=_messages(configurations), detail=DETAILS[detail], robots=map(name_of, robots)
        )
        response = self._services.collision.CheckCollision(request, timeout=LONG_TIMEOUT_SECONDS)
        return Check(tuple(map(collision_of, response.pairs)), response.check_seconds, stamp_of(response.stamp))

    def check_configurations(
        self,
        robot: Named,
        positions: Samples,
        *,
        joint_names: Sequence[str] = (),
        others: Mapping[str, Samples] | None = None,
        robots: Iterable[Named] = (),
        may_touch: Iterable[tuple[str, str]] = (),
        progress: Callable[[float], None] | None = None,
    ) -> ConfigurationsCheck:
        """Return which of n configurations are free, in the world as it is now.

        The kernel checks them in processes of their own, some thousands a second.

        Args:
            robot: the robot that stands elsewhere.
            positions: (n, k) radians or meters, a column for each joint, or (n,) by joint name. The other joints stay
                where they are.
            joint_names: the joints of the columns; without them all joints of one coordinate, in the robot's order.
            others: more robots that stand elsewhere, each with n rows: of all its joints, or (n,) by joint name.
            robots: only pairs with these robots are checked; none means all.
            may_touch: pairs of nodes that may touch besides those that may anyway.
            progress: is called with the part that is done, 0 to 1; what it raises ends the check.

        Raises:
            UnknownNameError: when there is no such robot or joint.
            LimitError: when a joint cannot be there.
            InvalidArgumentError: for arrays of other shapes, or that hold numbers that are not finite.

        Example:
            >>> found = client.collisions.check_configurations("arm", samples)
            >>> print(samples[found.free])
        """
        robot = name_of(robot)
        if others and robot in others:
            raise InvalidArgumentError(f"{robot!r} is among the others too; give its joints once")
        asked = {robot: (positions, joint_names), **{name: (rows, ()) for name, rows in (others or {}).items()}}
        request = check_message(asked, map(name_of, robots), may_touch)
        with self._services.collision.CheckConfigurations(request) as stream:
            return gathered(stream, request.configurations[0].positions.shape[0], progress)

    def distance(
        self, *first: NodeNamed, to: Iterable[NodeNamed] = (), configurations: Configurations | None = None
    ) -> Distance:
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
            raise InvalidArgumentError(
                f"there is nothing from which {', '.join(map(name_of, first))} could keep a distance"
            )
        return found[0]

    def distances(
        self,
        *first: NodeNamed,
        max_distance: float,
        to: Iterable[NodeNamed] = (),
        configurations: Configurations | None = None,
    ) -> list[Distance]:
        """Return all pairs of nodes that are at most so far apart and may not touch, the nearest first.

        `max_distance` is in m, above 0; the other arguments are those of `distance`.
        """
        if not max_distance > 0.0:
            raise InvalidArgumentError(f"max_distance must be above 0, not {max_distance}; `distance` has none")
        return self._distances(first, to, max_distance, configurations)

    def _distances(
        self,
        first: Iterable[NodeNamed],
        second: Iterable[NodeNamed],
        max_distance: float,
        configurations: Configurations | None,
    ) -> list[Distance]:
        request = collision_pb2.MeasureDistancesRequest(
            first=map(name_of, first),
            second=map(name_of, second),
            range_meters=max_distance,
            configurations=_messages(configurations),
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
            vertices: the most corners of a hull, 4 to 256.

        Raises:
            UnknownNameError: when there is no such node.
            LimitError: for another number of vertices.
        """
        if not nodes:
            raise InvalidArgumentError("name the nodes whose meshes shall collide as hulls")
        use_hulls(self._services, nodes, count_or_default(vertices, "the count of vertices"))
        return self.meshes(*nodes)

    def use_triangles(self, *nodes: str) -> list[CollisionMesh]:
        """Have the meshes of nodes and of all below them collide as their triangles again; see `use_hulls`."""
        use_hulls(self._services, nodes, 0)
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


def _messages(configurations: Configurations | None) -> Iterator[collision_pb2.RobotConfiguration]:
    for robot, positions in (configurations or {}).items():
        yield collision_pb2.RobotConfiguration(robot=robot, joint_positions=joint_map(positions))
