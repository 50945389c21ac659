"""Every pose that an arm reaches is solved: 1,000 poses for each arm and draw, from joints within limits."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.kinematics import PRISMATIC, REVOLUTE, InverseOptions, InverseStatus

from tests.tiers import Draws

from ...numeric.urdf_arrays import ARMS
from .arms import arm, arm_chain

POSES = 1000
FAR = 999999.0
"""Limit of the bases of both Frankies in their files (rad, m)."""


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


def on_a_base(turns_last: bool) -> ChainKinematics:
    """Return a Panda on a base that turns and drives, and turns again: QUT's Frankie and Frankie Omni."""
    chain, kinds = arm_chain("panda"), [REVOLUTE, PRISMATIC, REVOLUTE][: 3 if turns_last else 2]
    wheels, k = len(kinds), len(chain.lower)
    pre = np.tile(np.eye(4), (wheels, 1, 1))
    first = chain.pre[:1].copy()
    first[0, :3, 3] += (0.15, 0.0, 0.38)
    axes = [[1.0, 0.0, 0.0] if kind == PRISMATIC else [0.0, 0.0, 1.0] for kind in kinds]
    return ChainKinematics(
        chain._replace(
            pre=np.concatenate([pre, first, chain.pre[1:]]),
            axis=np.concatenate([axes, chain.axis]),
            joint_type=np.concatenate([kinds, chain.joint_type]).astype(np.int8),
            q_index=np.concatenate([np.arange(wheels), chain.q_index + wheels]).astype(np.int32),
            multiplier=np.ones(wheels + k),
            offset=np.zeros(wheels + k),
            lower=np.concatenate([np.full(wheels, -FAR), chain.lower]),
            upper=np.concatenate([np.full(wheels, FAR), chain.upper]),
            joint_names=(*(f"base_{i}" for i in range(wheels)), *chain.joint_names),
        )
    )


@pytest.mark.parametrize("turns_last", [False, True], ids=["frankie", "frankie_omni"])
def test_every_pose_near_a_mobile_manipulator_is_solved_wherever_it_is(
    turns_last: bool, rng: np.random.Generator, draws: Draws
) -> None:
    """Up to 70 m from the origin, poses within 3 m: those of places of the base and joints within limits."""
    kinematics = on_a_base(turns_last)
    wheels = 3 if turns_last else 2
    unsolved, done = [], 0
    while done < draws(POSES):
        stand = rng.uniform(-50.0, 50.0, 2)
        q, goal = (
            np.concatenate([_driven(place, wheels, rng), rng.uniform(kinematics.lower, kinematics.upper)[wheels:]])
            for place in (stand, stand + rng.uniform(-3.0, 3.0, 2))
        )
        here, there = kinematics.forward(q)[-1], kinematics.forward(goal)[-1]
        if np.linalg.norm(there[:3, 3] - here[:3, 3]) > 3.0:
            continue
        done += 1
        result = kinematics.inverse(there, InverseOptions(seed=q))
        if result.status is not InverseStatus.SOLVED:
            unsolved.append((q.tolist(), result.reason))
            continue
        np.testing.assert_allclose(kinematics.forward(result.solutions[0])[-1], there, atol=1e-8)
    assert unsolved == []


def _driven(place: np.ndarray, wheels: int, rng: np.random.Generator) -> np.ndarray:
    """Return the coordinates of a base that stands at a place (2,), forwards or backwards, and turned anyhow."""
    back = rng.integers(2)
    turn = np.arctan2(place[1], place[0]) + np.pi * back
    way = np.linalg.norm(place) * (-1.0 if back else 1.0)
    return np.array([turn, way, rng.uniform(-np.pi, np.pi)])[:wheels]
