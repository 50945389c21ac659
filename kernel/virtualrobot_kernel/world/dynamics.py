"""Dynamics: coordinates that nobody commands joint by joint, of crafts and of bodies under physics. Pure.

They are computed outside the world's step, once a tick, and enter it as one command. So a replay needs nobody who
computes them.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.arrays import is_finite

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world import motored
from virtualrobot_kernel.world.change import Change, Forward, frozen
from virtualrobot_kernel.world.physics_commands import SetDynamics
from virtualrobot_kernel.world.state import Dynamics, State
from virtualrobot_kernel.world.structure import JointType, Structure

UNIT_TOLERANCE = 1e-6
"""Tolerance of the length of a quaternion."""

Values = tuple[NDArray[np.int32], NDArray[np.float64]]


def set_dynamics(change: Change, command: SetDynamics, forward: Forward) -> Change:
    """Keep coordinates and velocities for the next tick, with those that are kept for it already.

    Raises KernelError for places that are none or do not rise, for values that are not finite, and for a quaternion
    that has not length 1.
    """
    structure, state = change.structure, change.state
    q = _values("coordinates", command.q_index, command.q, structure.q_count)
    v = _values("velocities", command.v_index, command.v, structure.v_count)
    if (kept := state.dynamics) is not None:
        q, v = _merged((kept.q_index, kept.q), q), _merged((kept.v_index, kept.v), v)
    dynamics = Dynamics(*q, *v)
    _check_quaternions(structure, state.q, q)
    if command.motored:
        state = motored.enter(structure, state, command.motored)
    return replace(change, state=state.but(dynamics=dynamics))


def arrived(structure: Structure, state: State) -> State:
    """Return the state in which what was kept for this tick has become true."""
    if (kept := state.dynamics) is None:
        return state
    q, v = state.q.copy(), state.v.copy()
    q[kept.q_index], v[kept.v_index] = kept.q, kept.v
    told = motored.followed(structure, state.motored, q)
    return state.but(q=frozen(q), v=frozen(v), dynamics=None, motored=told)


def _values(what: str, index: NDArray[np.int32], values: NDArray[np.float64], count: int) -> Values:
    """Return where values go and what they are, neither of which anybody can write to."""
    index, values = np.array(index, np.int32), np.array(values, float)
    if index.ndim != 1 or values.shape != index.shape:
        raise KernelError(f"{what} need a place each, not {values.shape} for {index.shape}")
    if len(index) and not (index[0] >= 0 and index[-1] < count and (index[1:] > index[:-1]).all()):
        raise KernelError(f"places of {what} must rise, from 0 or above to below {count}, not {index.tolist()}")
    if not is_finite(values):
        at = int(np.flatnonzero(~np.isfinite(values))[0])
        raise KernelError(f"{what} must be finite; the one of place {index[at]} is {values[at]}")
    index.setflags(write=False)
    return index, frozen(values)


def _merged(kept: Values, more: Values) -> Values:
    """Return values of both; where both have one, that of `more`."""
    if np.array_equal(kept[0], more[0]):
        return more
    rest = ~np.isin(kept[0], more[0])
    index = np.concatenate([kept[0][rest], more[0]])
    order = np.argsort(index)
    index, values = index[order], np.concatenate([kept[1][rest], more[1]])[order]
    index.setflags(write=False)
    return index, frozen(values)


def _check_quaternions(structure: Structure, q: NDArray[np.float64], values: Values) -> None:
    places = _quaternions(structure)
    if not len(places):
        return
    later = q.copy()
    later[values[0]] = values[1]
    parts = later[places]
    lengths = np.sqrt(np.einsum("kj,kj->k", parts, parts))
    if np.abs(lengths - 1.0).max() > UNIT_TOLERANCE:
        wrong = int(np.flatnonzero(np.abs(lengths - 1.0) > UNIT_TOLERANCE)[0])
        at = places[wrong]
        raise KernelError(f"the quaternion at the places {at[0]} to {at[3]} must have length 1, not {lengths[wrong]:g}")


@lru_cache(maxsize=4)
def _quaternions(structure: Structure) -> NDArray[np.int32]:
    """Return the places (k, 4) of all quaternions in q."""
    forest = structure.forest
    starts = forest.q_index[forest.joint_type == JointType.FLOATING.code]
    return np.unique(starts)[:, None] + np.arange(3, 7, dtype=np.int32)
