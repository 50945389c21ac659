"""Allowed collisions: pairs of nodes of one kernel that may touch each other, and the reasons."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.messages import count_or_none, pair_messages, seed_of
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import told
from virtualrobot.v1 import collision_pb2, nodes_pb2, scene_pb2


@dataclass(frozen=True, slots=True)
class AllowedPair:
    """Two nodes that may touch.

    Attributes:
        first: the name of a node, and `second` that of another one.
        cause: rigid, adjacent, mounted, held, file, client, or built: an import has found them to touch as built.
        reason: why, in the words of the file, the client or the import.
    """

    first: str
    second: str
    cause: str
    reason: str


@dataclass(frozen=True, slots=True)
class SampledPair:
    """Two nodes of a robot that may not touch, and the number of the configurations tried in which they did."""

    first: str
    second: str
    touched: int
    samples: int

    @property
    def always(self) -> bool:
        """True where they touched in each of the configurations."""
        return self.touched == self.samples

    @property
    def never(self) -> bool:
        """True where they touched in none of the configurations."""
        return self.touched == 0


@checked
class AllowedPairs:
    """Allowed collisions: pairs of nodes of one kernel that may touch each other.

    Example:
        >>> client.collisions.allowed.add("arm.link_0", "table", "stands on it")
    """

    def __init__(self, services: Services) -> None:
        """Handle the pairs of one kernel."""
        self._services = services

    def __iter__(self) -> Iterator[AllowedPair]:
        """Yield all pairs that may touch, in the order of the nodes."""
        return iter(self.list())

    def list(self, *nodes: str) -> list[AllowedPair]:
        """Return the pairs that may touch, all or those with one of these nodes or what hangs below them."""
        response = self._services.collision.ListAllowedPairs(collision_pb2.ListAllowedPairsRequest(nodes=nodes))
        names = collision_pb2.AllowedCause.Name
        return [
            AllowedPair(pair.first, pair.second, names(pair.cause).removeprefix("ALLOWED_CAUSE_").lower(), pair.reason)
            for pair in response.pairs
        ]

    def add(self, first: str, second: str, reason: str = "") -> None:
        """Let two nodes touch each other; saved with the scene."""
        self.change(allow=[(first, second, reason)])

    def remove(self, first: str, second: str) -> None:
        """Let two nodes touch no more; raises UnknownNameError when neither a client nor an import had."""
        self.change(forbid=[(first, second)])

    def forbid_built(self, *nodes: str) -> list[AllowedPair]:
        """Let pairs touch no more that imports have found to touch as built; return them.

        All of them, or those with one of these nodes or what hangs below them.

        Example:
            >>> client.collisions.allowed.forbid_built("arm")
        """
        found = [pair for pair in self.list(*nodes) if pair.cause == "built"]
        self.change(forbid=[(pair.first, pair.second) for pair in found])
        return found

    def change(self, allow: Iterable[tuple[str, str, str]] = (), forbid: Iterable[tuple[str, str]] = ()) -> None:
        """Let pairs touch no more, then let others (name, name, why) touch, as one change."""
        allow, forbid = tuple(allow), tuple(forbid)
        if not allow and not forbid:
            return
        self._services.apply([pairs_command(allow, forbid)])

    def find(
        self, robot: str, *, samples: int | None = None, seed: int = 0, progress: Callable[[float], None] | None = None
    ) -> Sequence[SampledPair]:
        """Return how often nodes of a robot touch in random configurations, those that do most often first.

        Nothing is changed. To allow what always touches, give these pairs to `change`.

        Args:
            robot: the robot.
            samples: number of configurations, 1,000 by default.
            seed: the seed that they are drawn with.
            progress: is called with the part that is done, 0 to 1; what it raises ends the search.

        Raises:
            UnknownNameError: when there is no such robot.
            LimitError: for more than 100,000 samples.
        """
        request = collision_pb2.FindAllowedPairsRequest(
            robot=robot, samples=count_or_none(samples, "samples"), seed=seed_of(seed)
        )
        found: Sequence[SampledPair] = ()
        with self._services.collision.FindAllowedPairs(request) as stream:
            for response in stream:
                if progress is not None:
                    progress(response.progress)
                tried = response.samples
                found = [SampledPair(pair.first, pair.second, pair.touched, tried) for pair in response.pairs]
        return found

    def __repr__(self) -> str:
        """Return a line for people."""
        return told("AllowedPairs", lambda: f"{len(self.list())} pairs may touch")


def built_pairs(messages: Iterable[nodes_pb2.NodePair]) -> tuple[AllowedPair, ...]:
    """Return the pairs that an import has found to touch as built."""
    return tuple(AllowedPair(pair.first, pair.second, "built", pair.reason) for pair in messages)


def pairs_command(allow: Iterable[tuple[str, str, str]], forbid: Iterable[tuple[str, str]]) -> scene_pb2.Command:
    """Return the command that lets pairs touch no more, then others (name, name, why) touch."""
    command = collision_pb2.SetAllowedPairs(
        allow=[nodes_pb2.NodePair(first=first, second=second, reason=why) for first, second, why in allow],
        forbid=pair_messages(forbid),
    )
    return scene_pb2.Command(set_allowed_pairs=command)
