"""Poses and rotations against scipy's."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation
from virtualrobot_sdk.poses import from_quaternion, quaternion, rotation_matrix, rotation_vector


def test_quaternions_and_rotation_vectors_are_scipys(rng: np.random.Generator) -> None:
    halves = [np.diag(signs) for signs in ((1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0))]
    for rotation in (*halves, *Rotation.random(200, rng=rng).as_matrix()):
        turn = np.array(quaternion(rotation))
        np.testing.assert_allclose(Rotation.from_quat(turn).as_matrix(), rotation, atol=1e-14)
        np.testing.assert_allclose(from_quaternion(turn), rotation, atol=1e-14)
        np.testing.assert_allclose(rotation_matrix(rotation_vector(rotation)), rotation, atol=1e-14)
