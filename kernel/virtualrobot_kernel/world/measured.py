"""Measured joints: positions that a robot's real joints have, beside those that motions command. Pure.

The state's q and v are where joints are. Of a robot that nobody measures, they are what motions command; of one that is
measured, they are the newest reading, and what motions command is kept apart (`State.commanded`). So it is of one whose
joints are moved by motors under physics (`State.motored`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.change import Change, Forward, check_coordinates, frozen, refuse_while_moving
from virtualrobot_kernel.world.commands import SetMeasuredJoints
from virtualrobot_kernel.world.state import JointValues, Snapshot, State
from virtualrobot_kernel.world.structure import Structure

Floats = NDArray[np.float64]


def set_measured_joints(change: Change, command: SetMeasuredJoints, forward: Forward) -> Change:
    """Keep a reading for the next tick; without one, let a robot's commanded joints be where it was measured."""
    structure, state = change.structure, change.state
    robot = structure.robots.get(command.robot)
    if robot is None:
        raise KernelError(f"no robot has the uid {command.robot} any more", reason=Reason.WRONG_STATE)
    node = structure.nodes[command.robot]
    if command.positions is None:
        refuse_while_moving(change, node, {(node.uid, name) for name in robot.coordinates})
        commanded, readings = dict(state.commanded), dict(state.readings)
        commanded.pop(node.uid, None)
        readings.pop(node.uid, None)
        return replace(change, state=replace(state, commanded=commanded, readings=readings))
    places, rates = robot.q_slice, robot.v_slice
    q = check_coordinates(node, robot.joints, np.asarray(command.positions, float), limited=False)
    v = np.zeros(rates.stop - rates.start) if command.velocities is None else np.asarray(command.velocities, float)
    if v.shape != (rates.stop - rates.start,) or not np.isfinite(v).all():
        raise KernelError(
            f"the measured velocities of {node.name!r} must be {rates.stop - rates.start} finite numbers, "
            f"not {v.tolist()}",
            robot=node.name,
        )
    state = replace(state, readings={**state.readings, node.uid: JointValues(frozen(q), frozen(v.copy()))})
    if node.uid not in state.commanded:
        now = JointValues(state.q[places], state.v[rates])
        state = replace(state, commanded={**state.commanded, node.uid: now})
    return replace(change, state=state)


def commanded(structure: Structure, state: State) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return all coordinates q (nq,) and velocities v (nv,) as motions command them; the state's own where they can."""
    if not (state.commanded or state.motored):
        return state.q, state.v
    q, v = state.q.copy(), state.v.copy()
    for uid, values in _apart(state).items():
        q[structure.robots[uid].q_slice], v[structure.robots[uid].v_slice] = values.q, values.v
    return q, v


def as_commanded(snapshot: Snapshot, forward: Forward) -> Snapshot:
    """Return the world with each joint where motions command it: what the next motion is planned from."""
    state = snapshot.state
    if not (state.commanded or state.motored):
        return snapshot
    q, v = commanded(snapshot.structure, state)
    state = replace(state, q=q, v=v, commanded={}, readings={}, motored={})
    return replace(snapshot, state=state, world_t_node=forward(snapshot.structure, state))


def arrived(structure: Structure, state: State) -> State:
    """Return the state whose readings have become the joints of their robots."""
    if not state.readings:
        return state
    q, v = state.q.copy(), state.v.copy()
    for uid, values in state.readings.items():
        q[structure.robots[uid].q_slice], v[structure.robots[uid].v_slice] = values.q, values.v
    return state.but(q=frozen(q), v=frozen(v), readings={})


def parted(structure: Structure, state: State, q: Floats, v: Floats) -> dict[str, Any]:
    """Return a state's fields after its joints have moved: what is commanded of measured and motored robots is apart.

    `q` (nq,) and `v` (nv,) are what motions command, and are written to; where joints are stays as it was.
    """
    kept: dict[int, JointValues] = {}
    for uid in _apart(state):
        places, rates = structure.robots[uid].q_slice, structure.robots[uid].v_slice
        kept[uid] = JointValues(frozen(q[places].copy()), frozen(v[rates].copy()))
        q[places], v[rates] = state.q[places], state.v[rates]
    return {
        "q": frozen(q),
        "v": frozen(v),
        "commanded": {uid: kept[uid] for uid in state.commanded} if state.commanded else state.commanded,
        "motored": {uid: kept[uid] for uid in state.motored} if state.motored else state.motored,
    }


def _apart(state: State) -> Mapping[int, JointValues]:
    """Return what motions command of the robots whose joints may be elsewhere; who measures one knows best."""
    return {**state.motored, **state.commanded}
