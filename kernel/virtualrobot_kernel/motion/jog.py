"""Jogs, motions by hand: one joint, or the tool centre point in one direction, for a distance or until an end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot_sdk.kinematics import Kinematics

from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.motion.cartesian_plan import along, checked_start
from virtualrobot_kernel.motion.limits import TOLERANCE, CartesianLimits, JointLimits, checked_joints, checked_scale
from virtualrobot_kernel.motion.line import Line
from virtualrobot_kernel.motion.nullspace import SecondaryObjective
from virtualrobot_kernel.motion.path import joint_line
from virtualrobot_kernel.motion.planned import Plan, planned
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.profile import jerk_limited_profile
from virtualrobot_kernel.motion.resolved_rate import farthest_joint_path
from virtualrobot_kernel.units import speed_question

#: A jog that could only go less than this is refused, in m or rad; so near to what ends it one of the TCP ends.
SMALLEST_JOG = 1e-5


@dataclass(frozen=True, slots=True)
class JogEnd:
    """Early end of a jog: its `wanted` distance and the distance `kept`, in m or rad, and the reason as a text."""

    wanted: float
    kept: float
    reason: str


class _Jog(Line):
    kind: ClassVar[str] = "jog"
    noun: ClassVar[str] = "jog"


def plan_joint_jog(
    q_start: float, velocity: float, distance: float, limits: JointLimits, velocity_scale: float = 1.0
) -> tuple[Plan, JogEnd | None]:
    """Return the motion of one joint, the only one of `limits`, by `distance` or until its limit, and which it is.

    velocity: other than 0, rad/s or m/s; its sign says which way, and times `velocity_scale` in (0, 1] it is the
    joint's speed. distance: above 0 in rad or m; infinite: until the limit. Raises LimitError when the velocity is
    above the joint's limit, or the joint is at its end that way; KernelError when nothing would end the motion.
    """
    (q,) = checked_joints([q_start], 1, "the start of a joint jog")
    (name,), (lower, upper, greatest) = limits.names, (limits.lower[0], limits.upper[0], limits.velocity[0])
    if not 0.0 < abs(velocity) <= greatest:
        raise LimitError(
            f"a jog of joint {name!r} has a velocity other than 0, of at most its limit {greatest:.6g} per second, "
            f"not {velocity:.6g}{speed_question(velocity, float(greatest))}",
            joint=name,
            value=velocity,
            limit=greatest,
        )
    if not distance > 0.0:
        raise KernelError(f"the distance of a jog is above 0, not {distance:.6g}", joint=name, value=distance)
    limit = upper if velocity > 0.0 else lower
    room = float(abs(limit - q)) if (limit - q) * velocity > 0.0 else 0.0
    if room <= TOLERANCE:
        raise limits.error(0, float(q + np.copysign(SMALLEST_JOG, velocity)), "the jog cannot move, it is at its end")
    if min(distance, room) == inf:
        raise KernelError(f"joint {name!r} has no limit that way, so its jog needs a distance", joint=name)
    goal = limit if distance >= room else q + np.copysign(distance, velocity)
    travel = float(abs(goal - q))
    speed = abs(velocity) * checked_scale(velocity_scale, "velocity scale")
    law = jerk_limited_profile(1.0, *(value / travel for value in (speed, limits.acceleration[0], limits.jerk[0])))
    end = np.array([goal])
    plan = planned("jog", joint_line(np.array([q]), end), law, limits, end)
    if distance == inf or distance <= room:
        return plan, None
    side = "upper" if velocity > 0.0 else "lower"
    return plan, JogEnd(distance, travel, f"joint {name!r} reaches its {side} limit {limit:.6g}")


def plan_cartesian_jog(
    kinematics: Kinematics,
    q_start: Sequence[float] | Array,
    translation: Array,
    rotation: Array,
    limits: JointLimits,
    cartesian_limits: CartesianLimits,
    velocity_scale: float = 1.0,
    tip_t_tcp: ArrayLike | None = None,
    objective: SecondaryObjective | None = None,
) -> tuple[Plan, JogEnd | None]:
    """Return the motion of the TCP along `translation` or about `rotation` as far as the arm can go, and what ends it.

    translation, rotation (3,): m and rad (a rotation vector, of any number of turns), base frame; one of them is 0.
    It ends before a joint's limit, a singularity, or where no posture leads on. All else as for `plan_lin`; raises what
    that would raise when the TCP can't move that way at all.
    """
    start, tcp = checked_start("jog", kinematics, q_start, limits, tip_t_tcp, objective)
    tcp_path = _Jog(tcp.pose(start), rotation, translation)
    wanted = max(tcp_path.length, tcp_path.angle)
    path, error = farthest_joint_path(tcp, tcp_path, start, limits, SMALLEST_JOG / wanted)
    if error is None and path is not None:
        return along(tcp_path, path, limits, cartesian_limits, velocity_scale), None
    kept = path.end * wanted if path is not None else 0.0
    if path is None or kept < SMALLEST_JOG:
        error = error or KernelError("it has no length")
        raise type(error)(f"the jog cannot move: {error}", reason=error.reason, **error.metadata)
    shorter = _Jog(tcp_path.base_t_start, path.end * rotation, path.end * translation)
    plan = along(shorter, path.stretched(1.0), limits, cartesian_limits, velocity_scale)
    return plan, JogEnd(wanted, kept, str(error))
