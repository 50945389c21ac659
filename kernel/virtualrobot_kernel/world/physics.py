"""Physics in the world: parts that forces have moved, and the settings of what moves them. Pure.

Forces are computed outside the world's step, once a tick, and what they lead to enters as one command. So a replay
needs no engine.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.arrays import is_finite

from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.world import motored
from virtualrobot_kernel.world.change import Change, Forward, frozen
from virtualrobot_kernel.world.physics_commands import SetContacts, SetParts, SetPhysics
from virtualrobot_kernel.world.state import BodyContacts, MovedParts, State
from virtualrobot_kernel.world.structure import Kind, Structure

MOST_SUBSTEPS = 1000


def set_parts(change: Change, command: SetParts, forward: Forward) -> Change:
    """Keep where parts are with the next tick.

    Raises KernelError for what is no part, and for values that are not finite or of other shapes.
    """
    count, nodes = len(command.parts), change.structure.nodes
    for uid in command.parts.tolist():
        if uid not in nodes or nodes[uid].kind is not Kind.PART:
            raise KernelError(f"no part has the uid {uid}")
    for name, values, shape in (
        ("poses", command.parent_t_part, (count, 4, 4)),
        ("velocities", command.twists, (count, 6)),
    ):
        if values.shape != shape or not is_finite(values):
            raise KernelError(f"{name} of {count} parts must be finite and of shape {shape}, not {values.shape}")
    moved = MovedParts(_read_only(command.parts), _read_only(command.parent_t_part), _read_only(command.twists))
    return replace(change, state=change.state.but(moved_parts=moved))


def set_contacts(change: Change, command: SetContacts, forward: Forward) -> Change:
    """Keep where nodes touch by the end of this tick.

    Raises KernelError for values that are not finite or of other shapes.
    """
    told = command.contacts
    if told.nodes.ndim != 2 or told.nodes.shape[1] != 2:
        raise KernelError(f"the nodes of contacts must be of shape (c, 2), not {told.nodes.shape}")
    shape = (len(told.nodes), 3)
    for name in ("positions", "normals", "forces"):
        values = getattr(told, name)
        if values.shape != shape or not is_finite(values):
            raise KernelError(f"{name} of {shape[0]} contacts must be finite and of shape {shape}, not {values.shape}")
    kept = BodyContacts(*map(_read_only, (told.nodes, told.positions, told.normals, told.forces)))
    return replace(change, state=change.state.but(told_contacts=kept))


def set_physics(change: Change, command: SetPhysics, forward: Forward) -> Change:
    """Change how forces move what is dynamic; without an engine it rests.

    Raises KernelError for gravity that is not finite, and (ROBOT_BUSY) where a robot moves that would be without an
    engine; LimitError for substeps out of range.
    """
    changes = {
        name: value
        for name in ("engine", "engine_settings", "gravity", "substeps")
        if (value := getattr(command, name)) is not None
    }
    if command.gravity is not None and not np.isfinite(command.gravity).all():
        raise KernelError(f"gravity must be finite, not {command.gravity}")
    if command.substeps is not None and not 1 <= command.substeps <= MOST_SUBSTEPS:
        raise LimitError(
            f"substeps must be 1 to {MOST_SUBSTEPS}, not {command.substeps}",
            value=command.substeps,
            lower=1,
            upper=MOST_SUBSTEPS,
        )
    if command.engine is not None and command.engine != change.state.physics_settings.engine:
        # Settings are those of one engine.
        changes.setdefault("engine_settings", {})
    settings = replace(change.state.physics_settings, **changes)
    twists = change.state.twists if settings.engine else {}
    change = change if settings.engine else motored.left(change, change.state.motored)
    contacts = change.state.contacts if settings.engine else None
    return replace(change, state=replace(change.state, physics=settings, twists=twists, contacts=contacts))


def arrived(structure: Structure, state: State) -> State:
    """Return the state in which parts are where forces have moved them since the tick before, and touch as they do."""
    if (told := state.told_contacts) is not None:
        state = state.but(contacts=told if len(told.nodes) else None, told_contacts=None)
    if (moved := state.moved_parts) is None:
        return state
    # One that is gone by now, or hangs on something else, stays as it is.
    uids, placed, rates = moved.parts.tolist(), moved.parent_t_part, moved.twists
    rows = [structure.rows.get(uid, -1) for uid in uids]
    if -1 in rows:
        there = [at for at, row in enumerate(rows) if row >= 0]
        uids, rows = [uids[at] for at in there], [rows[at] for at in there]
        placed, rates = placed[there], rates[there]
    poses = state.parent_t_node.copy()
    poses[rows] = placed
    told = dict(zip(uids, frozen(rates), strict=True))
    for at in np.flatnonzero((rates == 0.0).all(axis=1)).tolist():
        del told[uids[at]]
    if state.twists.keys() - told.keys():
        # What is not told goes on as it did; what is told to rest has no velocity.
        rests = set(uids) - told.keys()
        told = {uid: rate for uid, rate in sorted({**state.twists, **told}.items()) if uid not in rests}
    return state.but(parent_t_node=frozen(poses), twists=told, moved_parts=None)


def _read_only(values: NDArray) -> NDArray:
    values = values.copy()
    values.setflags(write=False)
    return values
