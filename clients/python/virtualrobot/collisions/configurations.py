"""Checks of many configurations at once: what is asked, and what comes back."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.messages import Stamp, array_message, array_of, pair_messages, stamp_of
from virtualrobot._wire.showing import shown
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.robots.dynamics import Samples, sample_rows
from virtualrobot.v1 import collision_pb2


@shown
@checked
@dataclass(frozen=True, slots=True, eq=False)
class ConfigurationsCheck:
    """Result of a collision check of n configurations.

    Attributes:
        free: (n,) true where nothing touches.
        touching: (n,) row in `pairs` of one that touches there and may not; -1 where it is free.
        pairs: the names of two nodes each.
        stamp: the instant of the world that was checked.
    """

    free: NDArray[np.bool_]
    touching: NDArray[np.int64]
    pairs: tuple[tuple[str, str], ...]
    stamp: Stamp

    def pair(self, row: int) -> tuple[str, str] | None:
        """Return two nodes that touch in a configuration; None where it is free."""
        return None if self.free[row] else self.pairs[self.touching[row]]


def check_message(
    robots: Mapping[str, tuple[Samples, Sequence[str]]], only: Iterable[str], may_touch: Iterable[tuple[str, str]]
) -> collision_pb2.CheckConfigurationsRequest:
    """Return what to check as a message: positions by robot, each with the joints that the columns are."""
    messages = []
    for robot, (positions, names) in robots.items():
        if isinstance(positions, Mapping):
            if names:
                raise InvalidArgumentError("give positions by joint name, or in order with joint_names")
            names = [str(name) for name in positions]
        rows = sample_rows(positions, list(names), "positions")
        messages.append(
            collision_pb2.RobotConfigurations(robot=robot, joint_names=names, positions=array_message(rows))
        )
    return collision_pb2.CheckConfigurationsRequest(
        configurations=messages, robots=only, may_touch=pair_messages(may_touch)
    )


def gathered(
    responses: Iterable[collision_pb2.CheckConfigurationsResponse],
    count: int,
    progress: Callable[[float], None] | None,
) -> ConfigurationsCheck:
    """Return what all responses tell of `count` configurations."""
    touching = np.full(count, -1, np.int64)
    places: dict[tuple[str, str], int] = {}
    stamp = None
    for response in responses:
        stamp = response.stamp
        mine = array_of(response.touching).astype(np.int64)
        # Each message names its own pairs.
        own = [places.setdefault((pair.first, pair.second), len(places)) for pair in response.pairs]
        touching[response.first_row : response.first_row + len(mine)] = np.array([*own, -1], np.int64)[mine]
        if progress is not None:
            progress(response.progress)
    assert stamp is not None, "a check that begins says so"
    return ConfigurationsCheck(touching < 0, touching, tuple(places), stamp_of(stamp))
