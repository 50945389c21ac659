"""Ghosts of twins: robots that are commanded to be, or were measured to be, elsewhere than the world has them. Pure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.drawing.ghosts import moved_parts
from virtualrobot_kernel.drawing.view import GHOST_COLOR, GHOST_OPACITY, Ghost
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.sensing.picture import Color
from virtualrobot_kernel.world.figures import Figure, Material
from virtualrobot_kernel.world.state import Snapshot

APART = 2e-3
"""Distance (rad, m) of a joint from which on a ghost is seen; nearer it would be one with the robot."""

MEASURED_COLOR: Color = (0.10, 0.70, 0.35)


class GhostKind(Enum):
    """Kind of a twin's ghost; the names equal those of `TwinGhostKind` in the contract."""

    COMMANDED = "commanded"
    MEASURED = "measured"


COLORS = {GhostKind.COMMANDED: GHOST_COLOR, GhostKind.MEASURED: MEASURED_COLOR}


@dataclass(frozen=True, slots=True, eq=False)
class TwinGhost:
    """Ghost of a robot (uid): its coordinates q (nq,), and whether they are commanded or measured."""

    robot: int
    kind: GhostKind
    q: NDArray[np.float64]


def twin_ghosts(snapshot: Snapshot, measured: Mapping[int, NDArray[np.float64]]) -> tuple[TwinGhost, ...]:
    """Return the ghosts of robots that the world has somewhere else, by more than `APART`.

    A robot whose joints are measured is where it was measured, its ghost where motions command it. Of all others
    `measured` says by uid where their real ones are, all coordinates (nq,): there their ghosts are.
    """
    robots, state = snapshot.structure.robots, snapshot.state
    found = [(uid, GhostKind.COMMANDED, values.q) for uid, values in state.commanded.items()]
    found.extend((uid, GhostKind.MEASURED, q) for uid, q in measured.items() if uid not in state.commanded)
    return tuple(
        TwinGhost(uid, kind, q)
        for uid, kind, q in found
        if uid in robots
        and (here := state.q[robots[uid].q_slice]).shape == q.shape
        and np.abs(here - q).max(initial=0.0) > APART
    )


def ghost_poses(snapshot: Snapshot, ghosts: tuple[TwinGhost, ...]) -> NDArray[np.float64]:
    """Return world_t_node (N, 4, 4) with all ghosts in place of their robots, so that one stands on another's."""
    robots = snapshot.structure.robots
    places = [np.arange(robots[one.robot].q_slice.start, robots[one.robot].q_slice.stop) for one in ghosts]
    q_index = np.concatenate([np.zeros(0, np.int64), *places]).astype(np.int32)
    return standing_at(snapshot, q_index, np.concatenate([np.zeros(0), *(one.q for one in ghosts)])).world_t_node


def twin_figures(snapshot: Snapshot, ghosts: tuple[TwinGhost, ...]) -> Iterator[tuple[int, Figure]]:
    """Yield (uid of the node, figure in the node's frame) of what ghosts are made of."""
    for ghost in ghosts:
        material = Material((*COLORS[ghost.kind], GHOST_OPACITY))
        for uid, figure in moved_parts(snapshot, ghost.robot):
            yield uid, replace(figure, material=material, tool_state="")


def as_view_ghosts(ghosts: tuple[TwinGhost, ...]) -> tuple[Ghost, ...]:
    """Return the ghosts as those of a view, for a single picture."""
    return tuple(
        Ghost(f"{one.kind.value} {one.robot}", one.robot, (tuple(one.q.tolist()),), COLORS[one.kind]) for one in ghosts
    )
