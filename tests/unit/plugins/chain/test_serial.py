"""Frames of a chain against the forest's forward pass, and its Jacobian by finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_kernel.numeric.forest import FIXED, forward_forest
from virtualrobot_plugins.chain.serial import chain_frames, chain_jacobian, reach_bound

from .chains import MIXED, P, R, random_chain


def test_frames_are_those_of_the_forest(rng: np.random.Generator) -> None:
    chain = random_chain(rng, MIXED, [0, 1, 2, 2, 1, 3, 4])
    n = len(MIXED)
    q = rng.uniform(chain.lower, chain.upper)
    expected = np.empty((n + 1, 4, 4))
    forward_forest(
        np.arange(n + 1, dtype=np.int32),
        np.arange(-1, n, dtype=np.int32),
        np.append(chain.joint_type, np.int8(FIXED)),
        np.vstack([chain.axis, np.zeros(3)]),
        np.append(chain.q_index, np.int32(-1)),
        np.append(chain.multiplier, 1.0),
        np.append(chain.offset, 0.0),
        np.concatenate([chain.pre, chain.post[None]]),
        q,
        expected,
    )
    np.testing.assert_allclose(chain_frames(chain, q), expected, atol=1e-14)


@pytest.mark.parametrize("q_index", [None, [0, 1, 2, 2, 1, 3, 4]], ids=["independent", "mimic"])
def test_jacobian_is_the_derivative_of_the_tip_pose(q_index: list[int] | None, rng: np.random.Generator) -> None:
    chain = random_chain(rng, MIXED, q_index)
    q = rng.uniform(chain.lower, chain.upper)
    jacobian = chain_jacobian(chain, q)
    h = 1e-6
    for i in range(len(q)):
        ahead, behind = (chain_frames(chain, q + sign * h * np.eye(len(q))[i])[-1] for sign in (1, -1))
        np.testing.assert_allclose(jacobian[:3, i], (ahead - behind)[:3, 3] / (2 * h), atol=1e-8)
        turned = Rotation.from_matrix(ahead[:3, :3] @ behind[:3, :3].T).as_rotvec() / (2 * h)
        np.testing.assert_allclose(jacobian[3:, i], turned, atol=1e-8)


def test_no_posture_leaves_the_reach_bound(rng: np.random.Generator) -> None:
    for kinds in (MIXED, [R] * 6, [P] * 3):
        chain = random_chain(rng, kinds)
        centre, radius = reach_bound(chain)
        for q in rng.uniform(chain.lower, chain.upper, (200, len(kinds))):
            assert np.linalg.norm(chain_frames(chain, q)[-1][:3, 3] - centre) <= radius + 1e-12


def test_a_straight_arm_touches_the_reach_bound() -> None:
    chain = random_chain(np.random.default_rng(0), [R] * 3)
    for pose in (*chain.pre, chain.post):
        pose[:] = np.eye(4)
        pose[0, 3] = 0.5
    centre, radius = reach_bound(chain)
    np.testing.assert_array_equal(centre, [0.5, 0, 0])
    assert radius == pytest.approx(1.5)
    assert chain_frames(chain, np.zeros(3))[-1][0, 3] == pytest.approx(0.5 + radius)
