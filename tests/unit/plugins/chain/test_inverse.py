"""Laws of the search: any geometry, any size, near half turns, full turns, mimics, and its random numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_plugins.chain.inverse import next_random, search, search_space, unwind
from virtualrobot_plugins.chain.serial import SerialChain, chain_frames
from virtualrobot_sdk.compiled.pose_error import rotation_vector

from .chains import MIXED, R, random_chain


def solve(chain: SerialChain, target: np.ndarray, seed: np.ndarray, tolerance: float = 1e-9) -> np.ndarray:
    outcome, q = search(chain, search_space(chain), target, seed, 2000, tolerance, tolerance, 0)
    assert outcome.solved, outcome
    assert (q >= chain.lower).all()
    assert (q <= chain.upper).all()
    return q


@pytest.mark.parametrize("q_index", [None, [0, 1, 2, 2, 3, 4, 5]], ids=["independent", "mimic"])
@pytest.mark.parametrize("kinds", [MIXED, [R] * 7], ids=["mixed", "revolute"])
def test_chains_of_any_geometry_are_solved(
    kinds: list[int], q_index: list[int] | None, rng: np.random.Generator
) -> None:
    for _ in range(20):
        chain = random_chain(rng, kinds, q_index)
        target = chain_frames(chain, rng.uniform(chain.lower, chain.upper))[-1]
        q = solve(chain, target, np.zeros(len(chain.lower)))
        np.testing.assert_allclose(chain_frames(chain, q)[-1], target, atol=1e-8)


@pytest.mark.parametrize("joints", [1, 2, 3, 4, 5])
def test_short_chains_are_solved_though_their_jacobian_has_no_full_rank(joints: int, rng: np.random.Generator) -> None:
    for _ in range(20):
        chain = random_chain(rng, [R] * joints)
        target = chain_frames(chain, rng.uniform(chain.lower, chain.upper))[-1]
        q = solve(chain, target, np.zeros(joints))
        np.testing.assert_allclose(chain_frames(chain, q)[-1], target, atol=1e-8)


@pytest.mark.parametrize("size", [0.001, 1000.0])
def test_size_does_not_matter(size: float, rng: np.random.Generator) -> None:
    for _ in range(20):
        chain = random_chain(rng, [R] * 6)
        chain.pre[:, :3, 3] *= size
        chain.post[:3, 3] *= size
        target = chain_frames(chain, rng.uniform(chain.lower, chain.upper))[-1]
        q = solve(chain, target, np.zeros(6), 1e-9 * max(size, 1.0))
        np.testing.assert_allclose(chain_frames(chain, q)[-1], target, atol=1e-8 * max(size, 1.0))


def test_a_straight_arm_is_reached_though_it_is_singular() -> None:
    chain = random_chain(np.random.default_rng(0), [R] * 3)
    chain.axis[:] = [0, 0, 1]
    for pose in (*chain.pre, chain.post):
        pose[:] = np.eye(4)
        pose[0, 3] = 0.5
    target = chain_frames(chain, np.zeros(3))[-1]
    q = solve(chain, target, np.array([0.5, -1.0, 0.7]))
    np.testing.assert_allclose(q, 0.0, atol=1e-4)  # the tip moves with the square of the angles


def test_a_free_joint_ends_nearest_to_the_seed(rng: np.random.Generator) -> None:
    chain = random_chain(rng, [R] * 6)
    free = chain._replace(lower=np.full(6, -np.inf), upper=np.full(6, np.inf))
    for _ in range(50):
        seed = rng.uniform(-30, 30, 6)
        target = chain_frames(free, rng.uniform(-np.pi, np.pi, 6))[-1]
        q = solve(free, target, seed)
        assert (np.abs(q - seed) <= np.pi + 1e-9).all()


def test_full_turns_stay_within_limits() -> None:
    lower, upper = np.array([-6.0, -6, -6, 1.0, -6]), np.array([6.0, 3, 6, 7.0, 6])
    q = np.array([-3.0, -2.0, -2.0, 1.5, -2.0])
    unwind(q, np.array([5.0, 5.0, 5.0, -50.0, 50.0]), lower, upper, np.array([1, 1, 0, 1, 1], np.int8))
    # One turn fits; one would break the limit; turns change the pose; already the lowest; one is all that fits.
    np.testing.assert_allclose(q, [-3.0 + 2 * math.pi, -2.0, -2.0, 1.5, -2.0 + 2 * math.pi])


def test_rotation_vectors_are_right_at_every_angle(rng: np.random.Generator) -> None:
    for angle in (0.0, 1e-12, 1e-6, 1.0, np.pi / 2, 3.0, np.pi - 1e-6, np.pi - 1e-12, np.pi):
        for axis in (*rng.normal(size=(20, 3)), *np.eye(3)):
            expected = axis / np.linalg.norm(axis) * angle
            found = np.array(rotation_vector(*Rotation.from_rotvec(expected).as_matrix().ravel()))
            # At pi both signs of the axis are the same rotation.
            off = min(np.linalg.norm(found - expected), np.linalg.norm(found + expected) if angle > 3.1 else np.inf)
            assert off < 1e-9 if np.pi - angle < 1e-9 else off < 1e-12 + 1e-15 / max(np.pi - angle, 1e-9)


def test_random_numbers_are_uniform() -> None:
    state = np.array([0x9E3779B97F4A7C15], np.uint64)
    draws = np.array([next_random(state) for _ in range(20000)])
    assert ((draws >= 0) & (draws < 1)).all()
    # Twenty bins of 1,000 each: chi-square with 19 degrees of freedom is above 52 for one seed in 20,000; this one is
    # fixed.
    bins = np.histogram(draws, 20, (0, 1))[0]
    assert ((bins - 1000) ** 2 / 1000).sum() < 52


def test_random_numbers_are_those_of_the_paper() -> None:
    # xorshift64* in whole numbers of Python, as in the paper's listing (shifts 12, 25, 27).
    x = 123456789
    state = np.array([x], np.uint64)
    for _ in range(100):
        x ^= x >> 12
        x ^= (x << 25) % 2**64
        x ^= x >> 27
        assert next_random(state) == ((x * 2685821657736338717) % 2**64 >> 11) / 2**53
