"""Commands about what forces move: what an engine has computed by the end of a tick, and how it computes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.world.state import BodyContacts


@dataclass(frozen=True, slots=True, eq=False)
class SetDynamics:
    """Command to set coordinates of any robots by the end of this tick: what moves without being commanded.

    q_index (k,), q (k,): places among all coordinates, rising, and the values, rad or m (of floating joints x, y, z and
    a unit quaternion x, y, z, w). v_index (m,), v (m,): the same of velocities, per second (of floating joints the
    rates of x, y, z and the angular velocity about the axes of what they move). What is not named stays as it is; a
    later command of the same tick counts where both name a place. motored: robots (uids) whose motions command motors
    from now on, in place of joints.
    """

    q_index: NDArray[np.int32]
    q: NDArray[np.float64]
    v_index: NDArray[np.int32]
    v: NDArray[np.float64]
    motored: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class SetJointEfforts:
    """Command to set what motors of the mode EFFORT exert from now on, by joint: N m or N."""

    robot: str
    efforts: Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class SetParts:
    """Command to put parts elsewhere by the end of this tick: those that forces move.

    parts (k,): uids, rising. parent_t_part (k, 4, 4): poses in their parents. twists (k, 6): velocities of their
    origins in the axes of the world (m/s) and about their own axes (rad/s). A later command of the same tick counts
    in place of an earlier one.
    """

    parts: NDArray[np.int64]
    parent_t_part: NDArray[np.float64]
    twists: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class SetContacts:
    """Command to tell where what sensors feel touches under physics by the end of this tick, and by which force."""

    contacts: BodyContacts


@dataclass(frozen=True, slots=True)
class SetPhysics:
    """Command to change how forces move what is dynamic; None leaves a setting as it is.

    An empty engine means that nothing moves by forces. Gravity is in the world (m/s^2).
    """

    engine: str | None = None
    engine_settings: Mapping[str, Any] | None = None
    gravity: tuple[float, float, float] | None = None
    substeps: int | None = None
