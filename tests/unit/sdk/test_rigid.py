"""The check and repair of a single rigid transform."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_sdk.compiled.rigid import orthonormalise


def test_orthonormalise_measures_and_repairs(rng: np.random.Generator) -> None:
    pose = np.eye(4)
    pose[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    pose[:3, 0] *= np.sign(np.linalg.det(pose[:3, :3]))
    pose[:3, :3] += rng.uniform(-1e-5, 1e-5, (3, 3))
    # The nearest rotation, by singular values.
    left, _, right = np.linalg.svd(pose[:3, :3])
    off = orthonormalise(pose.copy())
    assert off == pytest.approx(np.abs(pose[:3, :3].T @ pose[:3, :3] - np.eye(3)).max(), rel=1e-9)
    orthonormalise(pose)
    np.testing.assert_allclose(pose[:3, :3], left @ right, atol=1e-15)
    assert orthonormalise(np.diag([1.0, 1.0, -1.0, 1.0])) == np.inf
    assert orthonormalise(np.full((4, 4), np.nan)) == np.inf
