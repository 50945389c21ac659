"""Records of a change: the values before and after it of all that undo covers.

Undo covers the tree and what people set in it: nodes, names, parents, poses, figures, data, tools that robots work
with, speed factors, allowed pairs, collision settings, and which signals and tools' states there are. It doesn't cover
where joints are, motions, values of signals, and which sensors run.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.world.about import About
from virtualrobot_kernel.world.collisions import Allowance, CollisionMode
from virtualrobot_kernel.world.figures import Figure, Pose
from virtualrobot_kernel.world.state import Selection, Signal
from virtualrobot_kernel.world.structure import Node, NodeData

EVERYWHERE = 0
"""Key in place of a robot's uid for what is set for all robots."""

Key = int | str | tuple[int, int]
"""Thing that a value is of: a node (uid), a signal (name), a pair of nodes (uids)."""


@dataclass(frozen=True, slots=True, eq=False)
class Presence:
    """Node with all that comes and goes with it: its pose, its joint's coordinates, and whether it, a sensor, runs.

    `q` (nq,), radians or meters, is empty for a node that no joint of its own moves.
    """

    node: Node
    parent_t_node: Pose
    q: NDArray[np.float64]
    running: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Values:
    """Values of what undo covers, by what they are of: nodes by uid, signals by name. None: it is not there.

    `nodes` has those that come or go; `names` to `data`, and `about`, have the fields of nodes that stay, where None of
    `about` is nothing said. `speed_factors`, `modes` and `look_ahead_seconds` have what is set for all robots at
    `EVERYWHERE`.
    """

    nodes: Mapping[int, Presence | None] = field(default_factory=dict)
    names: Mapping[int, str] = field(default_factory=dict)
    parents: Mapping[int, int] = field(default_factory=dict)
    hidden: Mapping[int, bool] = field(default_factory=dict)
    figures: Mapping[int, tuple[Figure, ...]] = field(default_factory=dict)
    data: Mapping[int, NodeData] = field(default_factory=dict)
    poses: Mapping[int, Pose] = field(default_factory=dict)
    signals: Mapping[str, Signal | None] = field(default_factory=dict)
    tool_states: Mapping[int, str | None] = field(default_factory=dict)
    selections: Mapping[int, Selection | None] = field(default_factory=dict)
    allowed_pairs: Mapping[tuple[int, int], Allowance | None] = field(default_factory=dict)
    paddings: Mapping[int, float | None] = field(default_factory=dict)
    speed_factors: Mapping[int, float | None] = field(default_factory=dict)
    modes: Mapping[int, CollisionMode | None] = field(default_factory=dict)
    look_ahead_seconds: Mapping[int, float] = field(default_factory=dict)
    about: Mapping[int, About | None] = field(default_factory=dict)

    def items(self) -> Iterator[tuple[str, Key, object]]:
        """Yield each value with its table and what it is of."""
        for table in TABLES:
            for key, value in getattr(self, table).items():
                yield table, key, value


TABLES = tuple(one.name for one in fields(Values))


@dataclass(frozen=True, slots=True, eq=False)
class Difference:
    """Values before and after a change, of the same things."""

    old: Values = field(default_factory=Values)
    new: Values = field(default_factory=Values)

    def __bool__(self) -> bool:
        """Return whether there is any."""
        return any(getattr(self.new, table) for table in TABLES)

    @property
    def keys(self) -> frozenset[tuple[str, Key]]:
        """Tables and what is in them."""
        return frozenset((table, key) for table, key, _ in self.new.items())

    @property
    def inverse(self) -> Difference:
        """Difference of the change that takes this one back."""
        return Difference(self.new, self.old)
