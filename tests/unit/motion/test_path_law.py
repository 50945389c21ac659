"""Time laws along paths: every limit of joints and tool centre points is kept, at ticks and at ten points between."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.motion.bounds import JointBound, TcpBound, TimeLaw
from virtualrobot_kernel.motion.cartesian_path import TcpKinematics
from virtualrobot_kernel.motion.path import smooth_path
from virtualrobot_kernel.motion.path_law import path_law
from virtualrobot_kernel.motion.planned import Track

from .motions import FINE, arm_limits, kinematics, random_line


@pytest.mark.parametrize("name", ["iiwa", "xarm6", "puma560"])
def test_joints_and_tool_centre_point_keep_their_limits(name: str, rng: np.random.Generator) -> None:
    plan, _, _, cartesian = random_line(rng, name)
    chain, limits, path = kinematics(name), arm_limits(name), plan.tracks[0].path
    slow = JointBound(0.3, 0.5, np.full(path.dimension, 0.4))
    tcp = TcpKinematics(chain, np.eye(4))
    bound = TcpBound(0.6, 1.0, slice(0, path.dimension), tcp, cartesian)
    track = Track(path, path_law(path, limits, [slow], [bound], TimeLaw.JERK_LIMITED))
    taus = np.arange(0.0, track.time_law.end, FINE)
    q, v, a, j = track.derivatives(taus)
    assert np.all(np.abs(v) <= limits.velocity)
    assert np.all(np.abs(a) <= limits.acceleration)
    assert np.all(np.abs(j) <= limits.jerk)
    u, u1, _, _ = track.time_law.states(taus, 3)[:, :, 0]
    assert np.all(u1 >= -1e-9)
    slowly = (u >= 0.3) & (u <= 0.5)
    assert np.all(np.abs(v[slowly]) <= 0.4 * limits.velocity)
    at = np.flatnonzero(u >= 0.6)
    twists = np.array([tcp.jacobian(q[i]) @ v[i] for i in at]).reshape(-1, 2, 3)
    speed, turn = np.linalg.norm(twists, axis=2).T
    assert speed.max() <= cartesian.velocity
    assert turn.max() <= cartesian.rotation_velocity


def test_a_law_is_at_rest_at_both_ends_and_covers_the_whole_path(rng: np.random.Generator) -> None:
    times, positions = np.cumsum(rng.uniform(0.2, 0.8, 6)), rng.uniform(-1.0, 1.0, (6, 7))
    law = path_law(smooth_path(times, positions, None), arm_limits("iiwa"), [], [], TimeLaw.JERK_LIMITED)
    assert law.coefficients.shape[1] == 4
    np.testing.assert_allclose(law.state(0.0, 2)[:, 0], [times[0], 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(law.state(law.end, 2)[:, 0], [times[-1], 0.0, 0.0], atol=1e-9)
