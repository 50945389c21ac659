"""Joint path along a Cartesian path: one continuous branch of the inverse kinematics, followed step by step.

The path solves q'(u) = J(q)^+ twist(u) (resolved-rate motion, Whitney 1969; a redundant arm takes the least norm, and
what its objective adds in the null space): a Runge-Kutta step predicts the next sample from the last one, Newton steps
put it on the path, and a quintic Hermite piece with the exact q' and q'' joins the two. Steps shrink until the middle
of each piece, where a Hermite piece deviates most, is on the path. Since each sample comes from its neighbour, the
branch cannot jump.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, replace
from math import ceil

import numpy as np
from virtualrobot_sdk.kinematics import Kinematics, SerialChain

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.cartesian_path import CartesianPath
from virtualrobot_kernel.motion.limits import TOLERANCE, JointLimits
from virtualrobot_kernel.motion.nullspace import NonsmoothObjective, SecondaryObjective, free_motion, projected
from virtualrobot_kernel.motion.nullspace_reference import nullspace_reference
from virtualrobot_kernel.motion.path import quintic_hermite
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.numeric import following

#: Largest deviation in the middle of a piece, in m and rad. A hundred times finer than promised to users: the
#: joint jerk is the third derivative of the pieces, whose errors are this divided by the third power of their length.
DEVIATION = 1e-8
#: A Jacobian whose smallest singular value (linear rows over the largest lever arm) is below this is singular.
SMALLEST_SINGULAR_VALUE = 0.01
#: A farthest path may start with a smaller one, down to this, when it leads away from the singularity: the lever arm of
#: another start is another, and where a path has ended one that leads back begins.
_SMALLEST_TO_LEAVE = 0.001
_LONGEST_STEP = (0.05, 0.2)
_SHORTEST_STEP = 1e-6
#: Differences for curvatures reach no farther than this share of the way from one knot to the next.
_DIFFERENCE = 1e-3
#: Share of a twist that an arm with fewer than six joints may miss, by rounding.
_MISSING = 1e-6
#: Reasons at which a farthest path ends.
_ENDS = (Reason.LIMIT_EXCEEDED, Reason.SINGULARITY, Reason.UNREACHABLE)


@dataclass(frozen=True, eq=False)
class TcpKinematics:
    """Pose and Jacobian of a tool centre point that is fixed at the tip by `tip_t_tcp` (4, 4).

    objective: what the joints are used for that a path leaves free; None: to move as little as possible.
    """

    kinematics: Kinematics
    tip_t_tcp: Array
    objective: SecondaryObjective | None = None

    @property
    def chain(self) -> SerialChain | None:
        """Chain to the tool centre point, of kinematics that tell theirs (`chain`)."""
        chain: SerialChain | None = getattr(self.kinematics, "chain", None)
        return chain and chain._replace(post=chain.post @ self.tip_t_tcp)

    def pose(self, q: Array) -> Array:
        """Return base_t_tcp (4, 4)."""
        return self.kinematics.forward(q)[-1] @ self.tip_t_tcp

    def jacobian(self, q: Array) -> Array:
        """Return the geometric Jacobian (6, k) of the TCP, linear rows first, base frame."""
        jacobian = np.array(self.kinematics.jacobian(q))
        if self.tip_t_tcp[:3, 3].any():
            lever = self.kinematics.forward(q)[-1][:3, :3] @ self.tip_t_tcp[:3, 3]
            jacobian[:3] += np.cross(jacobian[3:], lever, axis=0)
        return jacobian


@dataclass(frozen=True, eq=False)
class _Sample:
    u: float
    q: Array
    rate: Array
    curvature: Array
    singular_value: float
    singular_slope: float


def lever_arm(jacobian: Array) -> float:
    """Return the longest lever arm (m) of a Jacobian (6, k), or 1 where nothing turns the tool centre point about."""
    turning = np.linalg.norm(jacobian[3:], axis=0) > 1e-9
    levers = np.linalg.norm(jacobian[:3], axis=0)[turning]
    return float(levers.max()) if len(levers) and levers.max() > 1e-6 else 1.0


def row_weights(lever: float) -> Array:
    """Return the weights (6,) that make a Jacobian's rows comparable: linear ones are divided by a lever arm (m)."""
    return np.array([1.0 / lever] * 3 + [1.0] * 3)


class _Follower:
    """Constants of one path: kinematics, tcp_path and the length (m) that makes the Jacobian's rows comparable."""

    def __init__(self, tcp: TcpKinematics, tcp_path: CartesianPath, q_start: Array) -> None:
        self.tcp, self.tcp_path = tcp, tcp_path
        self.weights = row_weights(lever_arm(tcp.jacobian(q_start)))
        self.reference = None
        if isinstance(tcp.objective, NonsmoothObjective):
            self.reference = nullspace_reference(tcp.pose, tcp.jacobian, self.weights, tcp_path, q_start, tcp.objective)
        self.longest_difference = _DIFFERENCE * float(np.diff([0.0, *tcp_path.knots, 1.0]).min())

    def twist(self, u: float) -> Array:
        return self.tcp_path.twist(u) * self.weights

    def rate(self, u: float, q: Array) -> Array:
        return self.rate_by(self.tcp.jacobian(q), u, q)

    def rate_by(self, jacobian: Array, u: float, q: Array) -> Array:
        rate = self.solve(jacobian, self.twist(u))
        if self.tcp.objective is None:
            return rate
        weighted = jacobian * self.weights[:, None]
        if self.reference is not None:
            return rate + projected(weighted, self.reference(u))
        return rate + free_motion(weighted, rate, self.tcp.objective, q)

    def solve(self, jacobian: Array, weighted: Array) -> Array:
        solution = np.linalg.lstsq(jacobian * self.weights[:, None], weighted, rcond=1e-12)[0]
        return np.asarray(solution, dtype=np.float64)

    def difference(self, rate: Array) -> float:
        """Return half the difference in u for a curvature: about 1e-4 rad, by which its error is below 1e-7 of it."""
        return min(1e-4 / max(float(np.abs(rate).max()), 1e-4), self.longest_difference)

    def sample(self, u: float, q: Array) -> _Sample:
        left, values, right = np.linalg.svd(self.tcp.jacobian(q) * self.weights[:, None], full_matrices=False)
        twist = self.twist(u)
        projected = left.T @ twist
        rate = right.T @ (projected / np.maximum(values, 1e-12))
        if len(q) < 6 and np.linalg.norm(left @ projected - twist) > _MISSING * np.linalg.norm(twist):
            where, metadata = self.tcp_path.place(u)
            joints = f"{len(q)} joints" if len(q) > 1 else "one joint"
            raise KernelError(
                f"the arm cannot follow the {self.tcp_path.noun} {where}: with {joints} it cannot move and turn so",
                reason=Reason.UNREACHABLE,
                **metadata,
            )
        step = self.difference(rate)
        if self.tcp.objective is not None:
            rate = self.rate(u, q)
        before, after = (self.tcp.jacobian(q + sign * step * rate) for sign in (-1.0, 1.0))
        curvature = self.rate_by(after, u + step, q + step * rate) - self.rate_by(before, u - step, q - step * rate)
        curvature /= 2.0 * step
        slope = float(left[:, -1] @ ((after - before) * self.weights[:, None]) @ right[-1]) / (2.0 * step)
        return _Sample(u, q, rate, curvature, float(values[-1]), slope)

    def step(self, start: _Sample, u: float) -> Array | None:
        """Return the joints at `u` on the branch of `start`, or None when the step is too long for that."""
        h = u - start.u
        middle = start.u + 0.5 * h
        k2 = self.rate(middle, start.q + 0.5 * h * start.rate)
        k3 = self.rate(middle, start.q + 0.5 * h * k2)
        k4 = self.rate(u, start.q + h * k3)
        predicted = start.q + h / 6.0 * (start.rate + 2.0 * k2 + 2.0 * k3 + k4)
        q = predicted
        for _ in range(6):
            error = self.tcp_path.deviation(u, self.tcp.pose(q))
            if np.abs(error).max() < 1e-12:
                break
            q = q + self.solve(self.tcp.jacobian(q), error * self.weights)
            # A correction as long as the step itself would be another branch.
            farthest = 0.1 * np.abs(predicted - start.q).max() + 1e-9
            if not np.all(np.isfinite(q)) or np.abs(q - predicted).max() > farthest:
                return None
        return q if np.abs(self.tcp_path.deviation(u, self.tcp.pose(q))).max() < 1e-10 else None

    def advanced(self, start: _Sample, u: float, limits: JointLimits, tolerance: float) -> _Sample | None:
        """Return the sample at `u`, or None when the step is too long; raise KernelError when the arm can't do it."""
        q = self.step(start, u)
        if q is None:
            return None
        new = self.sample(u, q)
        ends = (start.q, start.rate, start.curvature, new.q, new.rate, new.curvature)
        middle = np.empty_like(q)
        inside = following.write_middle(u - start.u, *ends, limits.lower - tolerance, limits.upper + tolerance, middle)
        if self.distance(0.5 * (start.u + u), middle) >= DEVIATION:
            return None
        if not inside:
            _check_limits(self.tcp_path, _piece([start, new]), limits, tolerance)
        _check_singularity(self.tcp_path, new, min(SMALLEST_SINGULAR_VALUE, start.singular_value))
        return new

    def distance(self, u: float, q: Array) -> float:
        """Return how far the tool centre point is at q from the path's pose at `u`, in m or rad."""
        return float(np.abs(self.tcp_path.deviation(u, self.tcp.pose(q))).max())


class _ChainFollower(_Follower):
    """Follower of a chain whose free joints serve nothing else: the same steps, compiled."""

    def __init__(self, tcp: TcpKinematics, tcp_path: CartesianPath, q_start: Array, chain: SerialChain) -> None:
        super().__init__(tcp, tcp_path, q_start)
        self.chain = (*chain[:6], chain.post[None], float(self.weights[0]))

    def sample(self, u: float, q: Array) -> _Sample:
        rate, curvature, left, right = np.empty_like(q), np.empty_like(q), np.empty(6), np.empty_like(q)
        smallest, missing = following.rate_along(*self.chain, q, self.tcp_path.twist(u), rate, left, right)
        if not (smallest >= SMALLEST_SINGULAR_VALUE and missing <= _MISSING):
            # What is refused is told by LAPACK's numbers, as that of other arms is.
            return super().sample(u, q)
        step = self.difference(rate)
        twists = self.tcp_path.twist(u - step), self.tcp_path.twist(u + step)
        slope = following.bend_along(*self.chain, q, rate, step, *twists, left, right, curvature)
        return _Sample(u, q, rate, curvature, smallest, slope)

    def step(self, start: _Sample, u: float) -> Array | None:
        path, h, q = self.tcp_path, u - start.u, np.empty_like(start.q)
        places = path.twist(start.u + 0.5 * h), path.twist(u), path.pose(u)
        return q if following.step_along(*self.chain, start.q, start.rate, h, *places, q) else None

    def distance(self, u: float, q: Array) -> float:
        return following.distance_from(*self.chain, q, self.tcp_path.pose(u))


def _follower(tcp: TcpKinematics, tcp_path: CartesianPath, q_start: Array) -> _Follower:
    chain = tcp.chain if tcp.objective is None else None
    return _Follower(tcp, tcp_path, q_start) if chain is None else _ChainFollower(tcp, tcp_path, q_start, chain)


def joint_path(tcp: TcpKinematics, tcp_path: CartesianPath, q_start: Array, limits: JointLimits) -> PiecewisePolynomial:
    """Return the joint path q(u), u in [0, 1], whose TCP follows `tcp_path` to 1e-6 m and 1e-6 rad from `q_start` (k,).

    Raises LimitError, or KernelError with reason SINGULARITY or UNREACHABLE, that names the place on the path, and the
    joint with its value and limits, or the smallest singular value.
    """
    return _piece(_followed(tcp, tcp_path, q_start, limits, None)[0])


def farthest_joint_path(
    tcp: TcpKinematics, tcp_path: CartesianPath, q_start: Array, limits: JointLimits, resolution: float
) -> tuple[PiecewisePolynomial | None, KernelError | None]:
    """Return the joint path along `tcp_path` as far as the arm can go, and what ends it; None where it can't go at all.

    It ends less than `resolution`, a part of the Cartesian path, before what `joint_path` would refuse; no joint is
    beyond its limits, unless it is at the start. Raises KernelError when the start is in a singularity, or near one
    into which the path leads.
    """
    here = replace(limits, lower=np.minimum(limits.lower, q_start), upper=np.maximum(limits.upper, q_start))
    samples, end = _followed(tcp, tcp_path, q_start, here, resolution)
    return _piece(samples) if len(samples) > 1 else None, end


def _followed(
    tcp: TcpKinematics, tcp_path: CartesianPath, q_start: Array, limits: JointLimits, resolution: float | None
) -> tuple[list[_Sample], KernelError | None]:
    """Return samples along the path and, with a resolution, what ended them before its end; else that is raised."""
    follower = _follower(tcp, tcp_path, q_start)
    tolerance = TOLERANCE if resolution is None else 0.0
    longest = 1.0 / max(4, ceil(tcp_path.length / _LONGEST_STEP[0]), ceil(tcp_path.angle / _LONGEST_STEP[1]))
    samples = [follower.sample(0.0, q_start)]
    first = samples[0]
    leaves = resolution is not None and first.singular_slope > 0.0
    _check_singularity(tcp_path, first, _SMALLEST_TO_LEAVE if leaves else SMALLEST_SINGULAR_VALUE)
    knots = [*tcp_path.knots, 1.0]
    step, blocked, end = longest, 2.0, None
    while samples[-1].u < 1.0:
        last = samples[-1]
        if last.singular_slope < 0.0:
            # Never step over a singularity: at most half the way to where the singular value would vanish.
            step = min(step, max(-0.5 * last.singular_value / last.singular_slope, 10.0 * _SHORTEST_STEP))
        if end is not None and resolution is not None:
            step = min(step, 0.5 * (blocked - last.u))
            if step < resolution:
                return samples, end
        # Steps up to the next knot are equally long, so that none is a sliver.
        knot = knots[bisect_right(knots, last.u + 1e-12)]
        count = ceil((knot - last.u) / step - 1e-6)
        u = knot if count <= 1 else last.u + (knot - last.u) / count
        try:
            new = follower.advanced(last, u, limits, tolerance)
        except KernelError as error:
            if resolution is None or error.reason not in _ENDS:
                raise
            blocked, end = u, error
            continue
        if new is not None:
            samples.append(new)
            step = min(longest, 1.5 * step)
            continue
        step = 0.5 * min(step, u - last.u)
        if step < _SHORTEST_STEP:
            where, metadata = tcp_path.place(last.u)
            lost = KernelError(
                f"the arm cannot follow the {tcp_path.noun} beyond {where}: the next pose has no solution near this "
                f"one; the smallest singular value of the Jacobian is {last.singular_value:.3g}",
                reason=Reason.UNREACHABLE,
                singular_value=last.singular_value,
                **metadata,
            )
            if resolution is None:
                raise lost
            return samples, lost
    return samples, None


def _piece(samples: list[_Sample]) -> PiecewisePolynomial:
    return quintic_hermite(
        np.array([sample.u for sample in samples]),
        np.array([sample.q for sample in samples]),
        np.array([sample.rate for sample in samples]),
        np.array([sample.curvature for sample in samples]),
    )


def _check_limits(tcp_path: CartesianPath, piece: PiecewisePolynomial, limits: JointLimits, tolerance: float) -> None:
    excursion = piece.first_excursion(limits.lower, limits.upper, tolerance)
    if excursion is not None:
        where, metadata = tcp_path.place(excursion.entered)
        raise limits.error(
            excursion.component,
            excursion.value,
            f"the {tcp_path.noun} meets a joint limit {where} and beyond",
            **metadata,
        )


def _check_singularity(tcp_path: CartesianPath, sample: _Sample, smallest: float) -> None:
    if sample.singular_value < smallest:
        where, metadata = tcp_path.place(sample.u)
        raise KernelError(
            f"the {tcp_path.noun} meets a singularity {where}: the smallest singular value of the Jacobian is "
            f"{sample.singular_value:.3g}, it must be at least {SMALLEST_SINGULAR_VALUE}; move there by joints "
            "(point to point), or begin in another posture",
            reason=Reason.SINGULARITY,
            singular_value=sample.singular_value,
            **metadata,
        )
