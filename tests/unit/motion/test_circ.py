"""Circular motions of real arms: on the circle, within all limits; refused with the place where that is impossible."""

from __future__ import annotations

from dataclasses import replace
from math import tau as whole_turn

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp
from virtualrobot_kernel.errors import KernelError, LimitError, Reason
from virtualrobot_kernel.motion.circle import Center, Via
from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.motion.plan import Plan, plan_circ, plan_lin
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.kinematics import InverseOptions
from virtualrobot_sdk.poses import rotation_matrix, rotation_vector

from .motions import (
    FINE,
    arm_limits,
    circle_of,
    distances_from_circle,
    kinematics,
    random_arc,
)

NAMES = ("iiwa", "panda", "xarm6", "puma560")
#: Postures away from limits and singularities; the iiwa's flange points down.
IIWA_READY = np.array([0.0, 0.5, 0.0, -1.4, 0.0, 1.2, 0.0])
PUMA_READY = np.array([0.1, -0.7, -0.5, 0.2, 0.9, 0.3])
X, Y, Z = np.eye(3)


def poses(chain: ChainKinematics, plan: Plan, times: np.ndarray, tool: np.ndarray) -> np.ndarray:
    return np.array([chain.forward(q)[-1] @ tool for q in plan.derivatives(times)[0]])


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_the_tcp_stays_on_the_circle_and_all_limits_are_kept(name: str, rng: np.random.Generator) -> None:
    """At each tick and ten points between two. 0.01 mm is what is promised; slerp and the arc's share are scipy's."""
    chain, limits = kinematics(name), arm_limits(name)
    for _ in range(3):
        arc = random_arc(rng, name)
        plan, tool = arc.plan, arc.tool
        assert plan.kind == "circ"
        tau = np.append(np.arange(0.0, plan.duration, FINE), plan.duration)
        q, v, a, j = plan.derivatives(tau)
        assert np.all((q >= limits.lower - 1e-6) & (q <= limits.upper + 1e-6))
        for values, limit in ((v, limits.velocity), (a, limits.acceleration), (j, limits.jerk)):
            assert np.all(np.abs(values) <= limit)
        tcp = np.array([chain.forward(row)[-1] @ tool for row in q[:: 1 + len(q) // 3000]])
        start = chain.forward(arc.start)[-1] @ tool
        circle = circle_of(arc, start)
        assert distances_from_circle(tcp[:, :3, 3], circle).max() < 1e-5
        # The share of the arc, from the angle about its axis, never runs back.
        center, _, normal = circle
        first, second = start[:3, 3] - center, np.cross(normal, start[:3, 3] - center)
        turned = np.unwrap(np.arctan2((tcp[:, :3, 3] - center) @ second, (tcp[:, :3, 3] - center) @ first))
        way = turned[-1]
        if isinstance(arc.shape, Center):
            assert way == pytest.approx(arc.shape.angle, abs=1e-6)
        else:
            assert 0.0 < way < whole_turn
        shares = turned / way
        assert np.all(np.diff(shares) > -1e-9)
        slerp = Slerp([0.0, 1.0], Rotation.from_matrix([start[:3, :3], arc.goal[:3, :3]]))
        even = slerp(np.clip(shares, 0.0, 1.0))
        assert (even.inv() * Rotation.from_matrix(tcp[:, :3, :3])).magnitude().max() < 1e-4
        np.testing.assert_array_equal(plan.start, arc.start)
        np.testing.assert_allclose(chain.forward(plan.goal)[-1] @ tool, arc.goal, atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_the_via_point_is_passed(name: str, rng: np.random.Generator) -> None:
    chain = kinematics(name)
    while not isinstance((arc := random_arc(rng, name)).shape, Via):
        continue
    path = arc.plan.tracks[0].path
    fractions = np.linspace(0.0, 1.0, 20001)
    tcp = np.array([(chain.forward(q)[-1] @ arc.tool)[:3, 3] for q in path.evaluate(fractions)])
    nearest = np.linalg.norm(tcp - arc.shape.point, axis=1).min()
    # Half the distance of two of the points, and what is promised of the path.
    assert nearest < 0.5 * np.linalg.norm(np.diff(tcp, axis=0), axis=1).max() + 1e-5


@pytest.mark.parametrize("name", ["iiwa", "puma560"])
def test_the_position_keeps_its_limits_in_space(name: str, rng: np.random.Generator) -> None:
    """By differences of the TCP's positions, centripetal acceleration included."""
    chain = kinematics(name)
    for _ in range(2):
        arc = random_arc(rng, name)
        h = 1e-3
        times = np.arange(0.0, arc.plan.duration + h, h)
        position = poses(chain, arc.plan, times, arc.tool)[:, :3, 3]
        speed = np.linalg.norm(np.diff(position, axis=0), axis=1) / h
        acceleration = np.linalg.norm(np.diff(position, 2, axis=0), axis=1) / h**2
        assert speed.max() <= arc.cartesian.velocity * (1.0 + 1e-4)
        # The path is exact to 1e-8 m, twice that by h² is noise.
        assert acceleration.max() <= arc.cartesian.acceleration * (1.0 + 1e-3) + 0.04


def test_a_whole_turn_at_its_speed_comes_back_and_takes_as_long_as_the_formula_says() -> None:
    """T = s/v + v/a + a/j for a law that reaches v and a, here those along the arc."""
    chain, limits = kinematics("iiwa"), arm_limits("iiwa")
    start = chain.forward(IIWA_READY)[-1]
    v, acceleration, jerk, r = 0.05, 0.5, 5.0, 0.1
    cartesian = CartesianLimits(v, acceleration, jerk)
    about = Center(start[:3, 3] - r * X, Z, whole_turn)
    plan = plan_circ(chain, IIWA_READY, about, None, limits, cartesian)
    along = np.sqrt(acceleration**2 - (v * v / r) ** 2)
    along_jerk = np.sqrt(jerk**2 - (3.0 * v * along / r) ** 2) - v**3 / r**2
    assert plan.duration == pytest.approx(whole_turn * r / v + v / along + along / along_jerk, rel=1e-6)
    np.testing.assert_allclose(chain.forward(plan.goal)[-1], start, atol=1e-9)
    half = chain.forward(plan.derivatives(np.array([0.5 * plan.duration]))[0][0])[-1]
    np.testing.assert_allclose(half[:3, 3], start[:3, 3] - 2.0 * r * X, atol=1e-8)
    np.testing.assert_allclose(half[:3, :3], start[:3, :3], atol=1e-8)


def test_a_tool_that_turns_with_the_arc_is_held_by_a_disc() -> None:
    chain, limits = kinematics("iiwa"), arm_limits("iiwa")
    start = chain.forward(IIWA_READY)[-1]
    center = start[:3, 3] + 0.1 * Y
    plan = plan_circ(chain, IIWA_READY, Center(center, Z, 1.5), None, limits, with_arc=True)
    disc_t_tcp = start.copy()
    disc_t_tcp[:3, 3] -= center
    for pose in poses(chain, plan, np.linspace(0.0, plan.duration, 200), np.eye(4)):
        turn = Rotation.from_matrix(pose[:3, :3] @ start[:3, :3].T).as_rotvec()
        np.testing.assert_allclose(turn[:2], 0.0, atol=1e-7)
        held = np.eye(4)
        held[:3, :3], held[:3, 3] = rotation_matrix(turn), center
        np.testing.assert_allclose(held @ disc_t_tcp, pose, atol=1e-6)


def test_a_flat_arc_is_planned_like_the_line() -> None:
    chain, limits = kinematics("iiwa"), arm_limits("iiwa")
    start = chain.forward(IIWA_READY)[-1]
    goal = start.copy()
    goal[:3, 3] += 0.0, 0.2, -0.1
    via = 0.5 * (start[:3, 3] + goal[:3, 3]) + 3e-5 * X
    line, arc = (plan_lin(chain, IIWA_READY, goal, limits), plan_circ(chain, IIWA_READY, Via(via), goal, limits))
    assert arc.duration == pytest.approx(line.duration, rel=1e-3)
    np.testing.assert_allclose(arc.goal, line.goal, atol=1e-4)


def test_an_arc_through_a_joint_limit_is_refused_with_the_place() -> None:
    chain, limits = kinematics("iiwa"), arm_limits("iiwa")
    start = chain.forward(IIWA_READY)[-1]
    about = Center(start[:3, 3] + 0.1 * Y, Z, whole_turn)
    free = plan_circ(chain, IIWA_READY, about, None, limits)
    travel = free.tracks[0].path.evaluate(np.linspace(0.0, 1.0, 1001))[:, 0]
    # The same circle with a bound on joint 1 half-way up its travel, which both ends keep.
    upper = limits.upper.copy()
    upper[0] = 0.5 * travel.max()
    with pytest.raises(
        LimitError, match=r"the arc meets a joint limit at .*% of the arc .* 'lbr_iiwa_joint_1'"
    ) as told:
        plan_circ(chain, IIWA_READY, about, None, replace(limits, upper=upper))
    u = float(told.value.metadata["fraction"])
    assert free.tracks[0].path.evaluate(u)[0] == pytest.approx(upper[0], abs=1e-4)
    assert float(told.value.metadata["millimeters"]) == pytest.approx(200.0 * np.pi * u, abs=0.01)
    place = np.array([float(x) for x in told.value.metadata["position"].split(",")])
    np.testing.assert_allclose(place, chain.forward(free.tracks[0].path.evaluate(u))[-1][:3, 3], atol=1e-5)


def test_an_arc_through_a_singularity_is_refused_with_the_place() -> None:
    # The Puma's wrist is singular where joint 5 is 0. The place of such a pose is the via point, in the middle of half
    # a circle; start and goal are turned by opposite angles from its orientation, so that the arc passes the very pose.
    chain, limits = kinematics("puma560"), arm_limits("puma560")
    straight = PUMA_READY.copy()
    straight[4] = 0.0
    singular, start = chain.forward(straight)[-1], chain.forward(PUMA_READY)[-1]
    goal = singular.copy()
    goal[:3, :3] = rotation_matrix(rotation_vector(singular[:3, :3] @ start[:3, :3].T)) @ singular[:3, :3]
    start[:3, 3] = singular[:3, 3] + 0.02 * X + 0.02 * Y
    goal[:3, 3] = singular[:3, 3] + 0.02 * X - 0.02 * Y
    q_start = chain.inverse(start, InverseOptions(seed=PUMA_READY)).solutions[0]
    assert abs(q_start[4]) > 0.2
    with pytest.raises(KernelError) as refusal:
        plan_circ(chain, q_start, Via(singular[:3, 3]), goal, limits)
    assert refusal.value.reason is Reason.SINGULARITY
    assert "the arc meets a singularity at" in str(refusal.value)
    assert 0.0 <= float(refusal.value.metadata["singular_value"]) < 0.01
    assert 0.4 < float(refusal.value.metadata["fraction"]) < 0.5


def test_a_via_point_out_of_reach_is_named() -> None:
    chain, limits = kinematics("iiwa"), arm_limits("iiwa")
    endless = replace(limits, lower=np.full(7, -np.inf), upper=np.full(7, np.inf))
    start = chain.forward(IIWA_READY)[-1]
    goal = start.copy()
    goal[1, 3] += 0.3
    via = 0.5 * (start[:3, 3] + goal[:3, 3]) + 0.9 * X
    with pytest.raises(KernelError, match="the via point of the CIRC motion is out of reach; on the way") as refusal:
        plan_circ(chain, IIWA_READY, Via(via), goal, endless)
    assert refusal.value.reason is Reason.UNREACHABLE
    assert "of the arc" in str(refusal.value)
    ready = np.array(IIWA_READY)
    narrow = replace(limits, lower=ready - 0.1, upper=ready + 0.1)  # so that a joint's limit is met long before
    with pytest.raises(
        LimitError, match=r"via point of the CIRC motion is out of reach; on the .* joint limit at"
    ) as told:
        plan_circ(chain, IIWA_READY, Via(start[:3, 3] + 5.0 * X), goal, narrow)
    assert float(told.value.metadata["position_error_meters"]) > 3.0
    assert told.value.metadata["joint"] in str(told.value)
    about = Center(start[:3, 3] + 0.5 * X, Z, whole_turn)
    with pytest.raises(KernelError, match=r"the place at (25|50|75)% of the CIRC motion is out of reach") as refusal:
        plan_circ(chain, IIWA_READY, about, None, endless)
    assert refusal.value.reason is Reason.UNREACHABLE


def test_the_start_and_the_tool_are_checked_as_for_lines() -> None:
    chain, limits = kinematics("iiwa"), arm_limits("iiwa")
    with pytest.raises(LimitError, match="start of the CIRC motion"):
        plan_circ(chain, np.full(7, 3.0), Via(X), np.eye(4), limits)
    with pytest.raises(KernelError, match="start of a CIRC motion needs 7 joint values"):
        plan_circ(chain, np.zeros(6), Via(X), np.eye(4), limits)
    with pytest.raises(KernelError, match="velocity scale"):
        start = chain.forward(IIWA_READY)[-1]
        plan_circ(chain, IIWA_READY, Center(start[:3, 3] + 0.1 * Y, Z, 1.0), None, limits, velocity_scale=1.5)
