"""First contact on the way of a program: tools look on each part of it as the program has left them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.joint_path import Indices, JointPath, of_program
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.collision.swept import RESOLUTION, SweptContact, first_contact
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.world.state import Snapshot

Switch = tuple[float, int, str]
"""From when on a tool (a uid) has a state."""


def first_along(
    scene: CollisionScene,
    snapshot: Snapshot,
    path: JointPath,
    switches: Sequence[Switch] = (),
    *,
    robots: Collection[int] | None = None,
    tolerated: Collection[Pair] = (),
    resolution: float = RESOLUTION,
    given_up: Callable[[], bool] | None = None,
) -> SweptContact | None:
    """Return the first contact on a way on which tools get other states; None: there is none.

    A switch before the way's begin has been made, one at its end or later is not. The others are as in `first_contact`.
    """
    times = sorted({time for time, _, _ in switches if path.begin < time < path.end})
    made = snapshot
    for begin, end in zip([path.begin, *times], [*times, path.end], strict=True):
        states = {**snapshot.state.tool_states, **{tool: name for time, tool, name in switches if time <= begin}}
        if states != made.state.tool_states:
            made = replace(snapshot, state=replace(snapshot.state, tool_states=states))
        found = first_contact(
            scene,
            made,
            replace(path, begin=begin, end=end),
            robots=robots,
            tolerated=tolerated,
            resolution=resolution,
            given_up=given_up,
        )
        if found is not None:
            return found
    return None


def program_switches(program: Program, tool_states: Sequence[tuple[int, int, str]]) -> list[Switch]:
    """Return from which nominal times (s) on the tools of a program have its states, given as (step, tool, state)."""
    return [(program.done_at(step), tool, name) for step, tool, name in sorted(tool_states)]


def first_of_program(
    scene: CollisionScene,
    worlds: Sequence[tuple[float, Snapshot]],
    program: Program,
    q_index: Indices,
    tool_states: Sequence[tuple[int, int, str]],
    until: float,
    resolution: float = RESOLUTION,
    given_up: Callable[[], bool] | None = None,
    path: JointPath | None = None,
) -> SweptContact | None:
    """Return the first contact of a program that starts in a world, up to a nominal time; None: there is none.

    What touches when the program changes the world, such as the table and the part that is picked from it, may touch
    until the end of the stage after that.

    Args:
        scene: is used for it.
        worlds: the world in which it starts, from 0 on, and those that its own steps make of it, from their times (s)
            on; other robots stand as they do there.
        program: the program, for coordinates `q_index` (n,) of the world.
        q_index: where its columns are in all coordinates.
        tool_states: (step, tool (a uid), state): the state that a tool has when the step is done.
        until: the nominal time (s) up to which it is looked at.
        resolution: what comes nearer than this (m) may be told as a contact.
        given_up: whether nobody waits for it any more.
        path: its way with the bases that drives move; None: it moves none.
    """
    path = path or of_program(worlds[0][1].state.q, q_index, program)
    switches = program_switches(program, tool_states)
    ends = [*(begin for begin, _ in worlds[1:]), path.end]
    for place, ((begin, world), end) in enumerate(zip(worlds, ends, strict=True)):
        parts: list[tuple[float, float, Collection[Pair]]] = [(begin, end, ())]
        if place:
            apart = min(end, next((one for one in program.begins if one > begin), end))
            scene.place(_standing(world, path.at(begin), switches, begin))
            parts = [(begin, apart, scene.touching()), (apart, end, ())]
        for first, last, tolerated in parts:
            if first > until or (first == last and len(worlds) > 1):
                continue
            found = first_along(
                scene,
                world,
                replace(path, begin=first, end=min(last, until)),
                switches,
                tolerated=tolerated,
                resolution=resolution,
                given_up=given_up,
            )
            if found is not None:
                return found
    return None


def _standing(world: Snapshot, q: NDArray[np.float64], switches: Sequence[Switch], time: float) -> Snapshot:
    """Return a world with all joints at q (nq,), and tools as switches have made them by a time (s)."""
    states = {**world.state.tool_states, **{tool: name for when, tool, name in switches if when <= time}}
    standing = standing_at(world, ..., q)
    return replace(standing, state=replace(standing.state, tool_states=states))
