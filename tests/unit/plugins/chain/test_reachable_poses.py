"""Every pose that an arm reaches is solved: 1,000 poses for each arm and draw, from joints within limits."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_sdk.kinematics import InverseStatus

from tests.tiers import Draws

from ...numeric.urdf_arrays import ARMS
from .arms import arm

POSES = 1000


@pytest.mark.parametrize("draw", range(3))
@pytest.mark.parametrize("name", sorted(ARMS))
def test_every_reachable_pose_is_solved_from_mid_range(name: str, draw: int, seed: int, draws: Draws) -> None:
    # Adding `draw` keeps the three apart when one seed is set from outside.
    rng = np.random.default_rng(seed + draw)
    kinematics = arm(name)
    joints = rng.uniform(kinematics.lower, kinematics.upper, (draws(POSES), len(kinematics.lower)))
    targets = np.array([kinematics.forward(q)[-1] for q in joints])
    results = [kinematics.inverse(target) for target in targets]
    unsolved = [joints[i].tolist() for i, result in enumerate(results) if result.status is not InverseStatus.SOLVED]
    assert unsolved == []
    solutions = np.array([result.solutions[0] for result in results])
    assert (solutions >= kinematics.lower).all()
    assert (solutions <= kinematics.upper).all()
    reached = np.array([kinematics.forward(q)[-1] for q in solutions])
    distances = np.linalg.norm(reached[:, :3, 3] - targets[:, :3, 3], axis=1)
    angles = (Rotation.from_matrix(reached[:, :3, :3]).inv() * Rotation.from_matrix(targets[:, :3, :3])).magnitude()
    # Asked for are 1 mm and 0.1 degrees; the component promises 1e-9.
    assert distances.max() < 1e-8
    assert angles.max() < 1e-7  # as finely as this angle can be told from matrices
