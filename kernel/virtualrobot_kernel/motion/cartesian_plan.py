"""Planners of LIN, CIRC and splines: one mechanism, whatever the path of the tool centre point is."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot_sdk.kinematics import InverseOptions, InverseStatus, Kinematics

from virtualrobot_kernel.errors import KernelError, LimitError, Reason
from virtualrobot_kernel.motion.bounds import TcpBound, TcpJacobian, TimeLaw
from virtualrobot_kernel.motion.cartesian_path import CartesianPath, ConstantSpeedPath
from virtualrobot_kernel.motion.circle import Center, Via, arc
from virtualrobot_kernel.motion.limits import CartesianLimits, JointLimits, checked_joints, checked_scale
from virtualrobot_kernel.motion.line import line_between
from virtualrobot_kernel.motion.nullspace import SecondaryObjective
from virtualrobot_kernel.motion.path import joint_line
from virtualrobot_kernel.motion.path_law import law_along, path_law
from virtualrobot_kernel.motion.planned import Plan, Track, peaks, planned
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.motion.profile import jerk_limited_profile
from virtualrobot_kernel.motion.rates import Rate, cartesian_rate, joint_rates
from virtualrobot_kernel.motion.resolved_rate import TcpKinematics, joint_path
from virtualrobot_kernel.motion.spline import spline
from virtualrobot_kernel.units import millimetres_question

#: A motion that has to be slowed down for a joint is slowed down by this much more.
_MARGIN = 1.001
#: One that has to be slowed down uniformly by more than this gets a law of its own.
_SLOWED = 1.02
#: Starts of the search that tells a place out of reach from a singularity on the way to a reachable one.
_RESTARTS = 200


def plan_lin(
    kinematics: Kinematics,
    q_start: Sequence[float] | Array,
    base_t_goal: ArrayLike,
    limits: JointLimits,
    cartesian_limits: CartesianLimits | None = None,
    velocity_scale: float = 1.0,
    tip_t_tcp: ArrayLike | None = None,
    time_law: TimeLaw = TimeLaw.JERK_LIMITED,
    objective: SecondaryObjective | None = None,
    gentle: tuple[float, float] = (1.0, 1.0),
) -> Plan:
    """Return the linear motion: the TCP moves on a straight line, its orientation turns about one axis (slerp).

    base_t_goal: (4, 4), where the TCP ends; tip_t_tcp: (4, 4), the TCP at the kinematics' last frame (identity when
    None). The law along the line keeps `cartesian_limits`, with speeds times `velocity_scale` in (0, 1]; where a joint
    cannot follow, the motion is slowed down until every joint keeps its velocity, acceleration and jerk. A time-optimal
    law keeps the velocities and accelerations, of joints and TCP, and no jerk. `objective`: what the joints are used
    for that the line leaves free. `gentle`: shares in (0, 1] of the joints' accelerations and jerks that are used.
    Errors: see `joint_path`; a singularity on the way to a goal out of reach is UNREACHABLE.
    """
    goal = np.array(base_t_goal, dtype=np.float64)
    return _planned(
        "LIN",
        lambda base_t_start: line_between(base_t_start, goal),
        kinematics,
        q_start,
        limits,
        cartesian_limits or CartesianLimits(),
        velocity_scale,
        tip_t_tcp,
        time_law,
        objective,
        gentle,
    )


def plan_circ(
    kinematics: Kinematics,
    q_start: Sequence[float] | Array,
    shape: Via | Center,
    base_t_goal: ArrayLike | None,
    limits: JointLimits,
    cartesian_limits: CartesianLimits | None = None,
    velocity_scale: float = 1.0,
    tip_t_tcp: ArrayLike | None = None,
    with_arc: bool = False,
    time_law: TimeLaw = TimeLaw.JERK_LIMITED,
    objective: SecondaryObjective | None = None,
    gentle: tuple[float, float] = (1.0, 1.0),
) -> Plan:
    """Return the circular motion: the TCP moves on an arc through a point or about a centre.

    base_t_goal: (4, 4), where the TCP ends; None when `shape` has an angle. The orientation turns about one axis,
    evenly with the arc: to the goal's, or by the arc's own angle when `with_arc`. The position keeps the acceleration
    and jerk of `cartesian_limits` in space, centripetal parts included. All else, errors too: as for `plan_lin`; a
    singularity on the way to a via point out of reach is UNREACHABLE. What makes no arc: see `circle.arc`.
    """
    goal = None if base_t_goal is None else np.array(base_t_goal, dtype=np.float64)
    return _planned(
        "CIRC",
        lambda base_t_start: arc(base_t_start, shape, goal, with_arc),
        kinematics,
        q_start,
        limits,
        cartesian_limits or CartesianLimits(),
        velocity_scale,
        tip_t_tcp,
        time_law,
        objective,
        gentle,
    )


def plan_spline(
    kinematics: Kinematics,
    q_start: Sequence[float] | Array,
    base_t_goals: Sequence[Array],
    limits: JointLimits,
    cartesian_limits: CartesianLimits | None = None,
    velocity_scale: float = 1.0,
    tip_t_tcp: ArrayLike | None = None,
    time_law: TimeLaw = TimeLaw.JERK_LIMITED,
    objective: SecondaryObjective | None = None,
    gentle: tuple[float, float] = (1.0, 1.0),
) -> Plan:
    """Return the motion along a smooth curve through poses (4, 4) of the TCP, base frame; it ends at the last one.

    Position and rotation keep `cartesian_limits` in space, speeds times `velocity_scale` in (0, 1], and the joints
    their limits. What makes no spline: see `spline.spline`. Other errors as for `plan_lin`, with the goal that is
    nearest to the place; a singularity on the way to a goal out of reach is UNREACHABLE.
    """
    start, tcp = checked_start("spline", kinematics, q_start, limits, tip_t_tcp, objective)
    tcp_path = spline(tcp.pose(start), base_t_goals)
    path = checked_joint_path("spline", tcp, tcp_path, start, limits)
    slow = (cartesian_limits or CartesianLimits()).scaled(velocity_scale)
    return plan_seen(tcp_path.kind, path, limits, tcp, slow, velocity_scale, time_law, gentle)


def plan_seen(
    kind: str,
    path: PiecewisePolynomial,
    limits: JointLimits,
    tcp: TcpJacobian,
    slow: CartesianLimits,
    velocity_scale: float,
    time_law: TimeLaw,
    gentle: tuple[float, float],
) -> Plan:
    """Return the plan along a joint path on which a tool centre point keeps limits, whatever way it has.

    slow: those limits, to which `velocity_scale` is applied already.
    """
    bound = TcpBound(path.start, path.end, slice(0, path.dimension), tcp, slow)
    law = path_law(path, limits.scaled(velocity_scale, *gentle), (), (bound,), time_law)
    # What speeds up or slows down the motion accelerates the TCP as much as the law itself does, and not more.
    _, acceleration, jerk = np.abs(law.states(np.linspace(0.0, law.end, 2000), 3)[1:, :, 0]).max(axis=1).tolist()
    if time_law is TimeLaw.TIME_OPTIMAL:
        jerk = acceleration * slow.jerk / slow.acceleration
    return planned(kind, path, law, limits, path_limits=(acceleration, jerk))


def _planned(
    name: str,
    tcp_path_from: Callable[[Array], ConstantSpeedPath],
    kinematics: Kinematics,
    q_start: Sequence[float] | Array,
    limits: JointLimits,
    cartesian_limits: CartesianLimits,
    velocity_scale: float,
    tip_t_tcp: ArrayLike | None,
    time_law: TimeLaw,
    objective: SecondaryObjective | None,
    gentle: tuple[float, float],
) -> Plan:
    q_start, tcp = checked_start(name, kinematics, q_start, limits, tip_t_tcp, objective)
    tcp_path = tcp_path_from(tcp.pose(q_start))
    checked_scale(velocity_scale, "velocity scale")
    if not (tcp_path.length or tcp_path.angle):
        return planned(tcp_path.kind, joint_line(q_start, q_start), jerk_limited_profile(0.0, 1.0, 1.0, 1.0), limits)
    path = checked_joint_path(name, tcp, tcp_path, q_start, limits)
    return along(tcp_path, path, limits, cartesian_limits, velocity_scale, time_law, gentle)


def along(
    tcp_path: ConstantSpeedPath,
    path: PiecewisePolynomial,
    limits: JointLimits,
    cartesian_limits: CartesianLimits,
    velocity_scale: float,
    time_law: TimeLaw = TimeLaw.JERK_LIMITED,
    gentle: tuple[float, float] = (1.0, 1.0),
) -> Plan:
    """Return the plan along the joint path of a line, an arc or the like, on [0, 1]; see `plan_lin` for its law."""
    bounds = _bounds(tcp_path, cartesian_limits, velocity_scale)
    slow = limits.scaled(velocity_scale, *gentle)
    if time_law is TimeLaw.TIME_OPTIMAL:
        rate = cartesian_rate(tcp_path, path, cartesian_limits.scaled(velocity_scale))
        law = law_along([*joint_rates(path, slow, ()), rate], time_law)
    else:
        law = _law(path, bounds, slow)
    peak = float(np.abs(2.0 * law.coefficients[:, 2]).max())
    return planned(tcp_path.kind, path, law, limits, path_limits=(max(bounds[1], peak), bounds[2]))


def checked_start(
    name: str,
    kinematics: Kinematics,
    q_start: Sequence[float] | Array,
    limits: JointLimits,
    tip_t_tcp: ArrayLike | None,
    objective: SecondaryObjective | None = None,
) -> tuple[Array, TcpKinematics]:
    """Return the start (k,) of a motion and the TCP that it leads; raise LimitError when it is outside its limits."""
    start = checked_joints(q_start, len(limits.names), f"the start of a {name} motion")
    limits.check(start, f"the start of the {name} motion")
    tip = np.eye(4) if tip_t_tcp is None else np.array(tip_t_tcp, dtype=np.float64)
    return start, TcpKinematics(kinematics, tip, objective)


def checked_joint_path(
    name: str, tcp: TcpKinematics, tcp_path: CartesianPath, q_start: Array, limits: JointLimits
) -> PiecewisePolynomial:
    """Return the joint path along a Cartesian path, as `joint_path` does.

    A singularity on the way to a station that no posture reaches is UNREACHABLE; a joint's limit that is met before is
    told with it. `name` says what the motion is.
    """
    try:
        return joint_path(tcp, tcp_path, q_start, limits)
    except KernelError as error:
        ends = error.reason in (Reason.SINGULARITY, Reason.LIMIT_EXCEEDED)
        out = _out_of_reach(tcp, tcp_path, q_start) if ends else None
        if out is None:
            raise
        place, off = out
        message = (
            f"the {place} of the {name} motion is out of reach{millimetres_question(off)}; on the way there {error}"
        )
        metadata = {**error.metadata, "position_error_meters": off}
        if isinstance(error, LimitError):
            raise LimitError(message, **metadata) from error
        raise KernelError(message, reason=Reason.UNREACHABLE, **metadata) from error


def _law(path: PiecewisePolynomial, bounds: Sequence[float], limits: JointLimits) -> PiecewisePolynomial:
    """Return the faster of the path's own law, slowed down uniformly, and one slowed down where it has to be."""
    own = jerk_limited_profile(1.0, *bounds)
    uniform = slowed_down(path, own, limits)
    if uniform.end <= _SLOWED * own.end:
        return uniform
    tcp_path = PiecewisePolynomial(path.breaks[[0, -1]], np.ones((1, 1, 1)))
    rates = [*joint_rates(path, limits, ()), Rate(tcp_path, 1, np.array(bounds)[:, None])]
    local = law_along(rates, TimeLaw.JERK_LIMITED)
    return min(uniform, local, key=lambda law: law.end)


def slowed_down(path: PiecewisePolynomial, law: PiecewisePolynomial, limits: JointLimits) -> PiecewisePolynomial:
    """Return `law` stretched uniformly until every joint of the path keeps its velocity, acceleration and jerk.

    A stretch by c divides velocities by c, accelerations by c², jerks by c³, so that the largest of
    max |v| / limit, sqrt(max |a| / limit), cbrt(max |j| / limit) is the stretch that is needed.
    """
    bounds = np.stack([limits.velocity, limits.acceleration, limits.jerk])
    powers = np.array([1.0, 1.0 / 2.0, 1.0 / 3.0])
    # The second, finer grid verifies the first.
    for points in (2000, 7001):
        need = float(((peaks(Track(path, law), points) / bounds).max(axis=1) ** powers).max())
        if need > 1.0:
            law = law.stretched(law.end * need * _MARGIN)
    return law


def _out_of_reach(tcp: TcpKinematics, tcp_path: CartesianPath, q_start: Array) -> tuple[str, float] | None:
    """Return the first place of the path that no posture reaches, with or without limits, and by how many m."""
    options = InverseOptions(seed=q_start, respect_limits=False, max_restarts=_RESTARTS)
    for u, name in tcp_path.stations:
        base_t_tip = tcp_path.pose(u) @ np.linalg.inv(tcp.tip_t_tcp)
        result = tcp.kinematics.inverse(base_t_tip, options)
        if result.status is InverseStatus.UNREACHABLE:
            return name, result.position_error
    return None


def _bounds(tcp_path: ConstantSpeedPath, limits: CartesianLimits, velocity_scale: float) -> list[float]:
    """Return velocity, acceleration and jerk limits of the fraction u of the path, which has a length or an angle."""
    rotation = (limits.rotation_velocity, limits.rotation_acceleration, limits.rotation_jerk)
    rows = []
    if (length := tcp_path.length) > 0.0:
        rows.append([value / length for value in tcp_path.tangential(limits, velocity_scale)])
    if (angle := tcp_path.angle) > 0.0:
        rows.append([value / angle for value in rotation])
    velocity, acceleration, jerk = (min(column) for column in zip(*rows, strict=True))
    return [velocity * velocity_scale, acceleration, jerk]
