"""First contact on the way of a program: tools look on each part of it as the program has left them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.joint_path import Indices, JointPath, of_program
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.collision.swept import RESOLUTION, SweptContact, first_contact
from virtualrobot_kernel.motion.program import Program
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
    snapshot: Snapshot,
    program: Program,
    q_index: Indices,
    tool_states: Sequence[tuple[int, int, str]],
    until: float,
    resolution: float = RESOLUTION,
    given_up: Callable[[], bool] | None = None,
) -> SweptContact | None:
    """Return the first contact of a program that starts in a snapshot, up to a nominal time; None: there is none.

    Args:
        scene: is used for it.
        snapshot: the world in which it starts; other robots stand as they do there.
        program: the program, for coordinates `q_index` (n,) of the world.
        q_index: where its columns are in all coordinates.
        tool_states: (step, tool (a uid), state): the state that a tool has when the step is done.
        until: the nominal time (s) up to which it is looked at.
        resolution: what comes nearer than this (m) may be told as a contact.
        given_up: whether nobody waits for it any more.
    """
    path = of_program(snapshot.state.q, q_index, program)
    return first_along(
        scene,
        snapshot,
        replace(path, end=min(path.end, until)),
        program_switches(program, tool_states),
        resolution=resolution,
        given_up=given_up,
    )
