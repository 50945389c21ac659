"""Chains of random geometry for tests of laws that hold for any chain."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation
from virtualrobot_sdk.kinematics import PRISMATIC, REVOLUTE, SerialChain


def random_pose(rng: np.random.Generator, size: float = 0.3) -> np.ndarray:
    """Return a pose with any rotation and a translation of about `size` metres."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    pose[:3, 3] = rng.normal(size=3) * size
    return pose


def random_chain(rng: np.random.Generator, kinds: list[int], q_index: list[int] | None = None) -> SerialChain:
    """Return a chain of joints of these kinds; joints that share a coordinate are mimics with random factors."""
    n = len(kinds)
    index = np.arange(n) if q_index is None else np.array(q_index)
    k = int(index.max()) + 1
    axis = rng.normal(size=(n, 3))
    shared = np.array([np.count_nonzero(index == i) > 1 for i in index])
    half = np.array([0.3 if (np.array(kinds)[index == i] == PRISMATIC).any() else 2.0 for i in range(k)])
    return SerialChain(
        pre=np.array([random_pose(rng) for _ in range(n)]),
        axis=axis / np.linalg.norm(axis, axis=1, keepdims=True),
        joint_type=np.array(kinds, np.int8),
        q_index=index.astype(np.int32),
        multiplier=np.where(shared, rng.uniform(0.5, 1.5, n), 1.0),
        offset=np.where(shared, rng.uniform(-0.2, 0.2, n), 0.0),
        post=random_pose(rng),
        lower=-half,
        upper=half,
        joint_names=tuple(f"joint_{i + 1}" for i in range(k)),
    )


R, P = REVOLUTE, PRISMATIC
MIXED = [R, P, R, R, P, R, R]
