"""Random limits and plans for the tests of motions, and a walk through a running one in steps finer than the tick."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.brake import nominal_time
from virtualrobot_kernel.motion.circle import Center, Via
from virtualrobot_kernel.motion.limits import CartesianLimits, JointLimits
from virtualrobot_kernel.motion.plan import (
    Plan,
    plan_circ,
    plan_lin,
    plan_ptp,
    plan_spline,
    plan_together,
    plan_trajectory,
)
from virtualrobot_kernel.motion.plan_execution import PlanExecution
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.poses import rotation_matrix
from virtualrobot_sdk.testing.chains import ur5

from ..plugins.chain.arms import arm

TICK = 0.004
#: A tick and ten points between two ticks.
FINE = TICK / 11


@cache
def kinematics(name: str) -> ChainKinematics:
    """Return the kinematics of one of the test arms."""
    return ChainKinematics(ur5(np.pi)) if name == "ur5" else arm(name)


def random_limits(rng: np.random.Generator, joints: int) -> JointLimits:
    """Return limits of the order of real arms': 1 to 3 rad/s, reached in 0.1 to 0.4 s, jerk up in 0.05 to 0.15 s."""
    velocity = rng.uniform(1.0, 3.0, joints)
    acceleration = velocity / rng.uniform(0.1, 0.4, joints)
    return JointLimits(
        tuple(f"joint_{i}" for i in range(joints)),
        rng.uniform(-3.0, -2.0, joints),
        rng.uniform(2.0, 3.0, joints),
        velocity,
        acceleration,
        acceleration / rng.uniform(0.05, 0.15, joints),
    )


def arm_limits(name: str) -> JointLimits:
    """Return an arm's own position limits with 2 rad/s, 10 rad/s², 100 rad/s³."""
    chain = kinematics(name)
    count = len(chain.lower)
    rates = (np.full(count, value) for value in (2.0, 10.0, 100.0))
    return JointLimits(chain.joint_names, chain.lower, chain.upper, *rates)


def random_ptp(rng: np.random.Generator, joints: int = 7) -> Plan:
    """Return a point-to-point motion between joints drawn uniformly within random limits."""
    limits = random_limits(rng, joints)
    start, goal = rng.uniform(limits.lower, limits.upper, (2, joints))
    return plan_ptp(start, goal, limits)


def random_line(rng: np.random.Generator, name: str) -> tuple[Plan, np.ndarray, np.ndarray, CartesianLimits]:
    """Return a linear motion that could be planned, its start joints, goal pose and Cartesian limits."""
    chain = kinematics(name)
    limits = arm_limits(name)
    cartesian = CartesianLimits(*rng.uniform(0.5, 2.0, 6) * (0.25, 1.0, 10.0, 1.0, 5.0, 50.0))
    for _ in range(200):
        q = rng.uniform(0.8 * chain.lower + 0.2 * chain.upper, 0.2 * chain.lower + 0.8 * chain.upper)
        goal = chain.forward(q)[-1].copy()
        goal[:3, 3] += rng.uniform(-0.15, 0.15, 3)
        goal[:3, :3] = rotation_matrix(rng.normal(size=3) * 0.3) @ goal[:3, :3]
        try:
            return plan_lin(chain, q, goal, limits, cartesian), q, goal, cartesian
        except KernelError:
            continue
    raise AssertionError(f"no line of 200 could be planned for {name}")


class RandomArc(NamedTuple):
    """A circular motion that could be planned, with what it was planned from."""

    plan: Plan
    start: np.ndarray
    shape: Via | Center
    goal: np.ndarray
    cartesian: CartesianLimits
    tool: np.ndarray


def random_arc(rng: np.random.Generator, name: str) -> RandomArc:
    """Return a circular motion through a point, or about a centre for up to one and a half turns, with a tool."""
    chain = kinematics(name)
    limits = arm_limits(name)
    cartesian = CartesianLimits(*rng.uniform(0.5, 2.0, 6) * (0.25, 1.0, 10.0, 1.0, 5.0, 50.0))
    through = rng.random() < 0.5
    tool = np.eye(4)
    tool[:3, 3] = rng.uniform(-0.1, 0.1, 3)
    for _ in range(400):
        q = rng.uniform(0.8 * chain.lower + 0.2 * chain.upper, 0.2 * chain.lower + 0.8 * chain.upper)
        start = chain.forward(q)[-1] @ tool
        goal = start.copy()
        goal[:3, :3] = rotation_matrix(rng.normal(size=3) * 0.3) @ goal[:3, :3]
        if through:
            goal[:3, 3] += rng.uniform(-0.1, 0.1, 3)
            shape = Via(start[:3, 3] + rng.uniform(-0.1, 0.1, 3))
        else:
            axis, radial = rng.normal(size=3), rng.normal(size=3) * 0.05
            center, angle = start[:3, 3] + np.cross(axis, radial), float(rng.uniform(0.05, 3.0) * np.pi)
            angle *= float(rng.choice([-1.0, 1.0]))  # on an arc of micrometres nobody tells shares from positions
            turn = rotation_matrix(angle * axis / np.linalg.norm(axis))
            goal[:3, 3] = center + turn @ (start[:3, 3] - center)
            shape = Center(center, axis, angle)
        try:
            plan = plan_circ(chain, q, shape, goal, limits, cartesian, tip_t_tcp=tool)
        except KernelError:
            continue
        return RandomArc(plan, q, shape, goal, cartesian, tool)
    raise AssertionError(f"no arc of 400 could be planned for {name}")


def circle_of(arc: RandomArc, start: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Return centre, radius and unit normal, by a linear system; `start` (4, 4) is where the TCP starts."""
    a = start[:3, 3]
    if isinstance(arc.shape, Center):
        assert arc.shape.axis is not None
        center, normal = arc.shape.point, arc.shape.axis
    else:
        b, c = arc.shape.point, arc.goal[:3, 3]
        normal = np.cross(b - a, c - a)
        right = np.array([b @ b - a @ a, c @ c - a @ a, 2.0 * normal @ a]) / 2.0
        center = np.linalg.solve(np.array([b - a, c - a, normal]), right)
    return center, float(np.linalg.norm(a - center)), normal / np.linalg.norm(normal)


def distances_from_circle(positions: np.ndarray, circle: tuple[np.ndarray, float, np.ndarray]) -> np.ndarray:
    """Return how far positions (m, 3) are from a circle, in its plane and out of it."""
    center, radius, normal = circle
    height = (positions - center) @ normal
    return np.hypot(np.linalg.norm(positions - center - height[:, None] * normal, axis=1) - radius, height)


class RandomSpline(NamedTuple):
    """A motion along a spline that could be planned, with what it was planned from."""

    plan: Plan
    start: np.ndarray
    goals: list[np.ndarray]
    cartesian: CartesianLimits
    tool: np.ndarray


def random_spline(rng: np.random.Generator, name: str, count: int = 5) -> RandomSpline:
    """Return a motion along a spline through poses within 15 cm of its start, with a tool."""
    chain = kinematics(name)
    cartesian = CartesianLimits(*rng.uniform(0.5, 2.0, 6) * (0.25, 1.0, 10.0, 1.0, 5.0, 50.0))
    tool = np.eye(4)
    tool[:3, 3] = rng.uniform(-0.1, 0.1, 3)
    for _ in range(400):
        q = rng.uniform(0.8 * chain.lower + 0.2 * chain.upper, 0.2 * chain.lower + 0.8 * chain.upper)
        start, goals = chain.forward(q)[-1] @ tool, []
        for _ in range(count):
            goal = start.copy()
            goal[:3, 3] += rng.uniform(-0.15, 0.15, 3)
            goal[:3, :3] = rotation_matrix(rng.normal(size=3) * 0.2) @ goal[:3, :3]
            goals.append(goal)
        try:
            plan = plan_spline(chain, q, goals, arm_limits(name), cartesian, tip_t_tcp=tool)
        except KernelError:
            continue
        return RandomSpline(plan, q, goals, cartesian, tool)
    raise AssertionError(f"no spline of 400 could be planned for {name}")


def random_trajectory(rng: np.random.Generator, joints: int = 4) -> tuple[Plan, np.ndarray, np.ndarray]:
    """Return a timed trajectory through random positions, its times and positions; velocity limits made to fit."""
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 0.8, 6))])
    positions = rng.uniform(-1.0, 1.0, (7, joints))
    wide = np.full(joints, 50.0)
    names = tuple(f"joint_{i}" for i in range(joints))
    limits = JointLimits(names, -wide, wide, wide, wide, 10.0 * wide)
    return plan_trajectory(positions[0], times, positions, None, limits), times, positions


def random_group(rng: np.random.Generator) -> Plan:
    """Return two robots' motions that start and end together."""
    return plan_together([random_ptp(rng, 6), random_line(rng, "panda")[0]])


def nominal_times(motion: PlanExecution) -> list[float]:
    """Return the nominal time at which each track passes where it is now; they differ when a group brakes."""
    if not motion.brakes:
        return [motion.tau] * len(motion.plan.tracks)
    tracks = zip(motion.plan.tracks, motion.path_states, strict=True)
    return [nominal_time(track.time_law, state[0], 0.0) for track, state in tracks]


def fine_steps(after: PlanExecution) -> Iterator[PlanExecution]:
    """Yield the motion at ten points within the tick that led to `after`, and at its end."""
    for k in range(1, 11):
        if after.brakes:
            step = replace(after, elapsed=after.elapsed - TICK + k * FINE, tau=0.0)
            yield replace(step, tau=min(nominal_times(step)))
            continue
        rate, slope, _, gone = after.ramp.state(after.elapsed - TICK + k * FINE)
        tau = min(after.ramp_tau + gone, after.plan.duration)
        yield replace(after, tau=tau, rate=rate, rate_slope=slope)
    yield after
