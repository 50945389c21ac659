"""Robots under physics: coordinates against rotations as matrices, and what motors are told against its formulas."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.numeric.forces import (
    EXERTS,
    FOLLOWS,
    HOLDS,
    OFF,
    SPRINGS,
    are_at,
    bring_parts,
    bring_robots,
    tell_motors,
)
from virtualrobot_sdk.poses import from_quaternion, quaternion, rotation_matrix


def integers(values: object) -> np.ndarray:
    return np.array(values, np.int32)


def test_a_base_is_told_in_the_frame_of_its_joint(rng: np.random.Generator) -> None:
    """The joint's frame is turned and shifted in the world; the base comes behind a box of the engine, a joint last."""
    frame, body = (rotation_matrix(rng.normal(size=3)) for _ in range(2))
    origin, place, velocity, spin = rng.normal(size=(4, 3))
    angle, rate = rng.normal(size=2)
    engine_q = np.concatenate([np.zeros(7), place, quaternion(body), [angle]])
    engine_v = np.concatenate([np.zeros(6), velocity, spin, [rate]])
    inverse = np.array(quaternion(frame)) * [-1.0, -1.0, -1.0, 1.0]
    joint_frame = frame[None].copy(), inverse[None].copy(), origin[None].copy()
    for sign in (1.0, -1.0):
        # Of both quaternions that are one rotation, that is told which is near the one of before.
        now = np.concatenate([[0.0, 0.0, 0.0], sign * np.array(quaternion(frame.T @ body)), [0.0]])
        q, v = np.full(8, np.nan), np.full(7, np.nan)
        fastest = bring_robots(
            *(engine_q, engine_v, now, integers([range(7)]), integers([range(7, 14)]), integers([range(6, 12)])),
            *(integers([range(7)]), integers([range(6)]), *joint_frame),
            *(integers([14]), integers([12]), integers([7]), integers([6]), q, v),
        )
        np.testing.assert_allclose(q[:3], frame.T @ (place - origin), atol=1e-12)
        np.testing.assert_allclose(from_quaternion(q[3:7]), frame.T @ body, atol=1e-12)
        assert q[3:7] @ now[3:7] > 0.0
        np.testing.assert_allclose(v[:6], [*(frame.T @ velocity), *spin], atol=1e-12)
        assert (q[7], v[6]) == (angle, rate)
        assert fastest == np.abs(v).max()


def test_parts_are_told_in_what_they_hang_on(rng: np.random.Generator) -> None:
    """Two of them, behind another body of the engine; the second has not moved."""
    turns, places = [rotation_matrix(rng.normal(size=3)) for _ in range(2)], rng.normal(size=(2, 3))
    twists = rng.normal(size=(2, 6))
    poses = ([*place, *quaternion(turn)] for place, turn in zip(places, turns, strict=True))
    engine_q = np.concatenate([np.zeros(7), *poses])
    world, parents = np.tile(np.eye(4), (4, 1, 1)), np.tile(np.eye(4), (2, 1, 1))
    wanted = np.tile(np.eye(4), (2, 1, 1))
    for part in range(2):
        wanted[part, :3, :3], wanted[part, :3, 3] = turns[part], places[part]
        parents[part, :3, :3], parents[part, :3, 3] = rotation_matrix(rng.normal(size=3)), rng.normal(size=3)
    world[1] = wanted[1]
    told = np.empty((2, 4, 4)), np.empty((2, 6)), np.empty((2, 2)), np.empty(2)
    bring_parts(
        *(engine_q, np.concatenate([np.zeros(6), *twists])),
        *(integers([range(7, 14), range(14, 21)]), integers([range(6, 12), range(12, 18)]), integers([3, 1])),
        *(parents, world, *told),
    )
    np.testing.assert_allclose(told[0], parents @ wanted, atol=1e-12)
    assert told[1].tolist() == twists.tolist()
    np.testing.assert_allclose(told[2], np.linalg.norm(twists.reshape(2, 2, 3), axis=2), rtol=1e-12)
    np.testing.assert_allclose(told[3], [np.abs(wanted[0] - np.eye(4)).max(), 0.0], atol=1e-12)


def test_one_value_that_differs_is_seen() -> None:
    values = np.array([1.0, 2.0, 3.0, 4.0])
    assert are_at(values, integers([3, 0]), np.array([4.0, 1.0]))
    assert not are_at(values, integers([3, 0]), np.array([4.0, np.nextafter(1.0, 2.0)]))
    assert not are_at(np.array([np.nan]), integers([0]), np.array([np.nan]))
    assert are_at(values, integers([]), np.zeros(0))


def test_motors_are_told_what_their_kind_wants() -> None:
    """A tick of 4 ms; the joint that follows is 0.03 rad behind where it was to be as the tick began."""
    kinds = integers([OFF, EXERTS, HOLDS, SPRINGS, FOLLOWS])
    place, rate = np.array([1.0, 2.0, 3.0, 4.0, 5.0]), np.array([0.1, 0.2, 0.3, 0.4, 0.5])
    stiffness, damping = np.array([0.0, 0.0, 0.0, 50.0, 0.0]), np.array([0.0, 0.0, 0.0, 2.0, 0.0])
    now = np.array([9.0, 9.0, 9.0, 9.0, 9.0, 5.0 - 0.5 * 0.004 - 0.03])
    target = np.full(5, np.nan)
    tell_motors(kinds, stiffness, damping, place, rate, now, integers(range(1, 6)), 0.004, 0.02, target)
    # A spring's damping holds back by 2 N m s/rad * 0.4 rad/s, which 50 N m/rad make up for with 0.016 rad.
    assert target == pytest.approx([0.0, 2.0, 0.3, 4.0 + 0.016, 0.5 + 0.03 / 0.02])
