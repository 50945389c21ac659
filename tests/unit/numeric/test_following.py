"""Compiled steps along paths: rates and singular values are LAPACK's, and a slope is the finite difference."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.numeric import following
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.kinematics import PRISMATIC, REVOLUTE, SerialChain
from virtualrobot_sdk.poses import rotation_matrix

WEIGHT = 1.7


def random_chain(rng: np.random.Generator, joints: int) -> SerialChain:
    """Return a chain whose joints lie anywhere, one of them prismatic where there are several."""
    pre = np.tile(np.eye(4), (joints, 1, 1))
    for pose in pre:
        pose[:3, :3], pose[:3, 3] = rotation_matrix(rng.normal(size=3)), rng.uniform(-0.5, 0.5, 3)
    axis = rng.normal(size=(joints, 3))
    types = np.full(joints, REVOLUTE, np.int8)
    types[1:2] = PRISMATIC
    names = tuple(f"joint_{i}" for i in range(joints))
    order, ones, span = np.arange(joints, dtype=np.int32), np.ones(joints), np.full(joints, 3.0)
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    return SerialChain(pre, axis, types, order, ones, np.zeros(joints), np.eye(4), -span, span, names)


def weighted(chain: SerialChain, q: np.ndarray) -> np.ndarray:
    """Return the Jacobian (6, k) with linear rows times the weight."""
    return ChainKinematics(chain).jacobian(q) * np.array([WEIGHT] * 3 + [1.0] * 3)[:, None]


@pytest.mark.parametrize("joints", range(1, 10))
def test_rates_are_the_least_ones(joints: int, rng: np.random.Generator) -> None:
    for _ in range(20):
        chain, q = random_chain(rng, joints), rng.uniform(-2.0, 2.0, joints)
        arrays = (*chain[:6], chain.post[None], WEIGHT)
        jacobian = weighted(chain, q)
        twist = rng.normal(size=6)
        scaled = twist * np.array([WEIGHT] * 3 + [1.0] * 3)
        rate, left, right = np.empty(joints), np.empty(6), np.empty(joints)
        smallest, missing = following.rate_along(*arrays, q, twist, rate, left, right)
        values = np.linalg.svd(jacobian, compute_uv=False)
        expected = np.linalg.lstsq(jacobian, scaled, rcond=1e-12)[0]
        np.testing.assert_allclose(smallest, values[-1], rtol=0.0, atol=1e-13 * values[0])
        np.testing.assert_allclose(rate, expected, rtol=0.0, atol=1e-11 / values[-1])
        off = np.linalg.norm(jacobian @ expected - scaled) / np.linalg.norm(scaled)
        assert missing == pytest.approx(off, abs=1e-11 / values[-1])
        np.testing.assert_allclose(jacobian @ right, smallest * left, rtol=0.0, atol=1e-12)
        # The rate's derivative and the value's, by differences of NumPy's.
        step, curvature = 1e-4, np.empty(joints)
        slope = following.bend_along(*arrays, q, rate, step, twist, twist, left, right, curvature)
        after, before = (weighted(chain, q + sign * step * rate) for sign in (1.0, -1.0))
        bend = [np.linalg.lstsq(one, scaled, rcond=1e-12)[0] for one in (after, before)]
        np.testing.assert_allclose(
            curvature, (bend[0] - bend[1]) / (2.0 * step), rtol=1e-6, atol=1e-6 / values[-1] ** 2
        )
        least = [np.linalg.svd(one, compute_uv=False)[-1] for one in (after, before)]
        bound = 1e-3 * max(1.0, float(np.abs(rate).max())) ** 3 / values[-1]
        assert slope == pytest.approx((least[0] - least[1]) / (2.0 * step), abs=bound)


def test_a_singular_arm_moves_as_far_as_it_can(rng: np.random.Generator) -> None:
    chain = random_chain(rng, 3)
    axis, pre = np.tile([0.0, 0.0, 1.0], (3, 1)), np.tile(np.eye(4), (3, 1, 1))
    pre[1:, 0, 3] = 0.5
    post = np.eye(4)
    post[0, 3] = 0.5
    chain = chain._replace(pre=pre, axis=axis, post=post, joint_type=np.full(3, REVOLUTE, np.int8))
    rate, left, right = np.empty(3), np.empty(6), np.empty(3)
    arrays = (*chain[:6], chain.post[None], 1.0)
    twist = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    smallest, missing = following.rate_along(*arrays, np.zeros(3), twist, rate, left, right)
    assert smallest < 1e-8, "a straight arm in the plane has rank 2"
    assert missing == pytest.approx(1.0)
    np.testing.assert_allclose(rate, 0.0, atol=1e-12)


def test_the_middle_is_that_of_the_polynomial(rng: np.random.Generator) -> None:
    polynomial = [np.polynomial.Polynomial(rng.normal(size=6)) for _ in range(4)]
    width = 0.7
    ends = [np.array([one.deriv(order)(u) for one in polynomial]) for u in (0.0, width) for order in (0, 1, 2)]
    middle = np.empty(4)
    places = np.linspace(0.0, width, 500)
    values = np.array([one(places) for one in polynomial])
    wide = following.write_middle(width, *ends, values.min(axis=1) - 9.0, values.max(axis=1) + 9.0, middle)
    assert wide
    np.testing.assert_allclose(middle, [one(width / 2.0) for one in polynomial], atol=1e-12)
    assert not following.write_middle(width, *ends, values.min(axis=1) + 1e-3, values.max(axis=1), middle)


@pytest.mark.parametrize("joints", [3, 6, 7])
def test_what_comes_on_the_way_is_what_the_singular_value_decomposition_says(
    joints: int, rng: np.random.Generator
) -> None:
    step, floor = 1e-3, 0.3  # some values are above the floor, some below it
    for _ in range(20):
        chain, q = random_chain(rng, joints), rng.uniform(-2.0, 2.0, joints)
        direction = rng.normal(size=6)
        rates, smallest, slopes = np.empty((4, joints)), np.empty(4), np.empty(4)
        following.look_along(*chain[:6], chain.post[None], WEIGHT, q, direction, step, floor, rates, smallest, slopes)
        jacobians, sides, place = [], [], q
        for number in range(4):
            jacobians.append(weighted(chain, place))
            left, values, right = np.linalg.svd(jacobians[-1], full_matrices=False)
            inverses = np.where(values >= floor, 1.0 / values, values / floor**2)
            np.testing.assert_allclose(rates[number], right.T @ (inverses * (left.T @ direction)), atol=1e-9)
            assert smallest[number] == pytest.approx(values[-1], abs=1e-12)
            sides.append((left[:, -1], right[-1]))
            place = place + step * rates[number]
        for number, (left, right) in enumerate(sides):
            later = min(number, 2)
            slope = left @ (jacobians[later + 1] - jacobians[later]) @ right / step
            assert slopes[number] == pytest.approx(slope, abs=1e-6 / max(smallest[number], 1e-3))
