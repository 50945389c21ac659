"""Linear motions of real arms: on the line, within all limits; refused with the place where that is impossible."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp
from virtualrobot_kernel.errors import KernelError, LimitError, Reason
from virtualrobot_kernel.motion.plan import Plan, plan_lin
from virtualrobot_kernel.motion.resolved_rate import TcpKinematics
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.poses import rotation_matrix, rotation_vector

from .motions import FINE, arm_limits, kinematics, random_line

NAMES = ("iiwa", "panda", "xarm6", "puma560")
#: A posture of the iiwa away from limits and singularities, its flange pointing down.
IIWA_READY = np.array([0.0, 0.5, 0.0, -1.4, 0.0, 1.2, 0.0])
PUMA_READY = np.array([0.1, -0.7, -0.5, 0.2, 0.9, 0.3])


def deviations(chain: ChainKinematics, plan: Plan, goal: np.ndarray, tool: np.ndarray) -> tuple[float, float]:
    """Return the largest distance from the line (m) and angle from the slerp (rad), by forward kinematics alone.

    The pose is compared with the line at the same share of the length (of the angle, where there is no length).
    """
    times = np.append(np.arange(0.0, plan.duration, FINE * 10), plan.duration)
    poses = np.array([chain.forward(q)[-1] @ tool for q in plan.derivatives(times)[0]])
    start = poses[0]
    ends = Rotation.from_matrix([start[:3, :3], goal[:3, :3]])
    translation = goal[:3, 3] - start[:3, 3]
    length = np.linalg.norm(translation)
    if length > 1e-9:
        shares = (poses[:, :3, 3] - start[:3, 3]) @ translation / length**2
    else:
        turned = (ends[0].inv() * Rotation.from_matrix(poses[:, :3, :3])).magnitude()
        shares = turned / (ends[0].inv() * ends[1]).magnitude()
    assert np.all(np.diff(shares) > -1e-9)
    distance = np.linalg.norm(poses[:, :3, 3] - start[:3, 3] - shares[:, None] * translation, axis=1)
    wanted = Slerp([0.0, 1.0], ends)(np.clip(shares, 0.0, 1.0))
    angle = (wanted.inv() * Rotation.from_matrix(poses[:, :3, :3])).magnitude()
    return float(distance.max()), float(angle.max())


@pytest.mark.parametrize("name", NAMES)
def test_the_tip_stays_on_the_line_and_the_joints_within_their_limits(name: str, rng: np.random.Generator) -> None:
    chain, limits = kinematics(name), arm_limits(name)
    for _ in range(4):
        plan, start, goal, cartesian = random_line(rng, name)
        distance, angle = deviations(chain, plan, goal, np.eye(4))
        assert distance < 1e-5
        assert angle < 1e-5
        tau = np.concatenate([np.arange(0.0, plan.duration, FINE), rng.uniform(0.0, plan.duration, 2000)])
        q, v, a, j = plan.derivatives(tau)
        assert np.all((q >= limits.lower - 1e-6) & (q <= limits.upper + 1e-6))
        for values, limit in ((v, limits.velocity), (a, limits.acceleration), (j, limits.jerk)):
            assert np.all(np.abs(values) <= limit)
        np.testing.assert_array_equal(plan.start, start)
        np.testing.assert_allclose(chain.forward(plan.goal)[-1], goal, atol=1e-9)
        # The twist of the tip, from joint velocities, keeps the Cartesian speed limits.
        tau = np.linspace(0.0, plan.duration, 200)
        twists = [chain.jacobian(p) @ w for p, w in zip(*plan.derivatives(tau)[:2], strict=True)]
        speed, turn = np.linalg.norm(np.array(twists).reshape(-1, 2, 3), axis=2).T
        assert speed.max() <= cartesian.velocity * (1 + 1e-4)
        assert turn.max() <= cartesian.rotation_velocity * (1 + 1e-4)


@pytest.mark.parametrize("name", NAMES)
def test_the_line_is_that_of_the_tool_centre_point(name: str, rng: np.random.Generator) -> None:
    chain, limits = kinematics(name), arm_limits(name)
    tool = np.eye(4)
    tool[:3, 3] = 0.05, -0.03, 0.12
    tool[:3, :3] = rotation_matrix(np.array([0.3, -0.2, 0.5]))
    for _ in range(100):
        q = rng.uniform(0.8 * chain.lower + 0.2 * chain.upper, 0.2 * chain.lower + 0.8 * chain.upper)
        goal = chain.forward(q)[-1] @ tool
        goal[:3, :3] = rotation_matrix(np.array([0.1, 0.25, -0.2])) @ goal[:3, :3]
        goal[:3, 3] += 0.05, -0.02, 0.03
        try:
            plan = plan_lin(chain, q, goal, limits, tip_t_tcp=tool)
        except KernelError:
            continue
        distance, angle = deviations(chain, plan, goal, tool)
        assert distance < 1e-5
        assert angle < 1e-5
        return
    raise AssertionError("no line of 100 could be planned")


def test_the_jacobian_of_the_tool_centre_point_is_that_of_its_pose(rng: np.random.Generator) -> None:
    tool = np.eye(4)
    tool[:3, 3] = rng.uniform(-0.2, 0.2, 3)
    tcp = TcpKinematics(kinematics("panda"), tool)
    q = rng.uniform(kinematics("panda").lower, kinematics("panda").upper)
    for joint in range(7):
        step = np.eye(7)[joint] * 1e-6
        before, after = tcp.pose(q - step), tcp.pose(q + step)
        turn = rotation_vector(after[:3, :3] @ before[:3, :3].T)
        difference = np.concatenate([after[:3, 3] - before[:3, 3], turn]) / 2e-6
        np.testing.assert_allclose(tcp.jacobian(q)[:, joint], difference, atol=1e-8)


def test_a_pure_turn_and_a_pure_translation_are_lines() -> None:
    chain, limits = kinematics("iiwa"), arm_limits("iiwa")
    turned = chain.forward(IIWA_READY)[-1].copy()
    turned[:3, :3] = rotation_matrix(np.array([0.2, 0.3, -0.4])) @ turned[:3, :3]
    shifted = chain.forward(IIWA_READY)[-1].copy()
    shifted[:3, 3] += 0.0, 0.2, -0.1
    for goal in (turned, shifted):
        assert max(deviations(chain, plan_lin(chain, IIWA_READY, goal, limits), goal, np.eye(4))) < 1e-5
    stay = plan_lin(chain, IIWA_READY, chain.forward(IIWA_READY)[-1], limits)
    assert stay.duration == 0.0
    np.testing.assert_array_equal(stay.goal, IIWA_READY)


def test_a_line_through_a_joint_limit_is_refused_with_the_place() -> None:
    chain = kinematics("iiwa")
    limits = arm_limits("iiwa")
    goal = chain.forward(IIWA_READY)[-1].copy()
    goal[:3, 3] += 0.0, 0.3, 0.0
    free = plan_lin(chain, IIWA_READY, goal, limits)
    # The same line with a bound on joint 1 that it crosses half-way of that joint's travel.
    upper = limits.upper.copy()
    upper[0] = 0.5 * free.goal[0]
    narrow = replace(limits, upper=upper)
    with pytest.raises(LimitError, match=r"% of the line .* joint 'lbr_iiwa_joint_1' would be at") as refusal:
        plan_lin(chain, IIWA_READY, goal, narrow)
    metadata = refusal.value.metadata
    path = free.tracks[0].path
    u = float(metadata["fraction"])
    assert path.evaluate(u)[0] == pytest.approx(upper[0], abs=1e-4)
    assert float(metadata["millimeters"]) == pytest.approx(300.0 * u, abs=0.01)
    place = chain.forward(path.evaluate(u))[-1][:3, 3]
    np.testing.assert_allclose([float(x) for x in metadata["position"].split(",")], place, atol=1e-5)
    assert metadata["joint"] == "lbr_iiwa_joint_1"
    assert float(metadata["upper"]) == upper[0]
    assert float(metadata["value"]) > upper[0]


def test_a_line_through_a_singularity_is_refused_with_the_place() -> None:
    # The Puma's wrist is singular where joint 5 is 0. Start and goal are mirrored at such a pose, so that the line
    # passes it in the middle.
    chain = kinematics("puma560")
    limits = arm_limits("puma560")
    middle = PUMA_READY.copy()
    middle[4] = 0.0
    centre = chain.forward(middle)[-1]
    start = PUMA_READY.copy()
    start[4] = 0.4
    base_t_start = chain.forward(start)[-1]
    goal = centre.copy()
    goal[:3, 3] += centre[:3, 3] - base_t_start[:3, 3]
    goal[:3, :3] = rotation_matrix(rotation_vector(centre[:3, :3] @ base_t_start[:3, :3].T)) @ centre[:3, :3]
    with pytest.raises(KernelError, match=r"meets a singularity at 4[0-9]\.\d% .* smallest singular value") as refusal:
        plan_lin(chain, start, goal, limits)
    assert refusal.value.reason is Reason.SINGULARITY
    assert 0.0 <= float(refusal.value.metadata["singular_value"]) < 0.01
    assert 0.4 < float(refusal.value.metadata["fraction"]) < 0.5


def test_a_line_that_starts_in_a_singularity_is_refused() -> None:
    chain = kinematics("iiwa")
    goal = chain.forward(np.zeros(7))[-1].copy()
    goal[0, 3] += 0.1
    goal[2, 3] -= 0.2
    with pytest.raises(KernelError, match=r"singularity at 0\.0% of the line") as refusal:
        plan_lin(chain, np.zeros(7), goal, arm_limits("iiwa"))
    assert refusal.value.reason is Reason.SINGULARITY


def test_a_line_that_leaves_the_workspace_is_unreachable() -> None:
    chain, limits = kinematics("iiwa"), arm_limits("iiwa")
    # Without position limits, which this line would meet first.
    endless = replace(limits, lower=np.full(7, -np.inf), upper=np.full(7, np.inf))
    goal = chain.forward(IIWA_READY)[-1].copy()
    goal[2, 3] += 2.0
    with pytest.raises(KernelError, match=r"out of reach; .* of the line") as refusal:
        plan_lin(chain, IIWA_READY, goal, endless)
    assert refusal.value.reason is Reason.UNREACHABLE
    # The arm is stretched where the line leaves the sphere of its reach, 0.42 + 0.4 + 0.126 m around the shoulder.
    shoulder = np.array([0.0, 0.0, 0.36])
    place = np.array([float(x) for x in refusal.value.metadata["position"].split(",")])
    assert 0.7 < np.linalg.norm(place - shoulder) < 0.95


def test_a_goal_that_is_no_pose_is_refused() -> None:
    chain = kinematics("iiwa")
    for bad in (np.eye(3), np.full((4, 4), np.nan), np.diag([1.0, 1.0, -1.0, 1.0]), 2.0 * np.eye(4)):
        with pytest.raises(KernelError, match="goal of a LIN motion must be a"):
            plan_lin(chain, IIWA_READY, bad, arm_limits("iiwa"))
