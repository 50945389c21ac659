"""Postures that follow a frame: checked with the plugin's kinematics, scipy's rotations and NumPy's null space."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation
from virtualrobot_kernel.motion.conveyor_tracking import TrackingArm
from virtualrobot_kernel.numeric.forest import PRISMATIC, REVOLUTE

from tests.unit.plugins.chain.arms import arm, arm_chain


def tracking_arm(name: str, rng: np.random.Generator, frame_type: int) -> tuple[TrackingArm, np.ndarray]:
    """Return an arm that follows a frame, and a tool centre point (4, 4) at its tip."""
    chain = arm_chain(name)
    tool = np.eye(4)
    tool[:3, 3] = rng.uniform(-0.1, 0.1, 3)
    axis = rng.normal(size=3)
    chain = chain._replace(post=np.ascontiguousarray(chain.post @ tool))
    columns = np.arange(len(chain.lower))
    point = rng.uniform(-1.0, 1.0, 3)
    return TrackingArm(columns, chain, 1.3, frame_type, axis / np.linalg.norm(axis), point, -0.5), tool


def moved(one: TrackingArm, displacement: float) -> np.ndarray:
    """Return the motion (4, 4) of the frame."""
    amount = one.ratio * displacement
    result = np.eye(4)
    if one.frame_type == PRISMATIC:
        result[:3, 3] = amount * one.frame_axis
    else:
        result[:3, :3] = Rotation.from_rotvec(amount * one.frame_axis).as_matrix()
        result[:3, 3] = one.frame_point - result[:3, :3] @ one.frame_point
    return result


@pytest.mark.parametrize("name", ["panda", "iiwa", "puma560"])
@pytest.mark.parametrize("frame_type", [PRISMATIC, REVOLUTE])
def test_the_tool_is_where_the_frame_takes_it(name: str, frame_type: int, rng: np.random.Generator) -> None:
    kinematics = arm(name)
    checked = 0
    while checked < 20:
        one, tool = tracking_arm(name, rng, frame_type)
        nominal = rng.uniform(0.7 * kinematics.lower, 0.7 * kinematics.upper)
        (jacobian,) = one.jacobians(nominal[None])
        if np.linalg.svd(jacobian)[1][5] < 0.15:
            continue  # so near to a singularity the next posture may be on another branch
        displacement = float(rng.uniform(-0.03, 0.03))
        (q, other), error = one.postures(
            np.array([nominal, nominal]),
            np.full(2, displacement),
            np.array([nominal, nominal + rng.normal(size=len(nominal)) * 1e-3]),
        )
        assert error.max() < 1e-9
        wanted = moved(one, displacement) @ kinematics.forward(nominal)[-1] @ tool
        assert np.abs(kinematics.forward(q)[-1] @ tool - wanted).max() < 1e-12
        assert np.abs(q - other).max() < 1e-11, "it does not depend on where the search begins"
        tilted = kinematics.jacobian(nominal)
        tilted[:3] += np.cross(tilted[3:], kinematics.forward(nominal)[-1][:3, :3] @ tool[:3, 3], axis=0)
        assert np.abs(null_space(tilted, rcond=1e-9).T @ (q - nominal)).max(initial=0.0) < 1e-11
        checked += 1


def test_where_the_frame_stands_still_so_does_the_arm(rng: np.random.Generator) -> None:
    one, _ = tracking_arm("iiwa", rng, PRISMATIC)
    nominal = rng.uniform(-1.0, 1.0, (50, 7))
    nominal = nominal[np.linalg.svd(one.jacobians(nominal))[1][:, 5] > 0.01][:5]  # at a singularity no step is made
    q, error = one.postures(nominal, np.zeros(5), nominal)
    assert np.abs(q - nominal).max() < 1e-12
    assert error.max() < 1e-12


def test_a_frame_that_jumps_out_of_reach_is_told(rng: np.random.Generator) -> None:
    one, _ = tracking_arm("iiwa", rng, PRISMATIC)
    nominal = rng.uniform(-1.0, 1.0, (3, 7))
    _, error = one.postures(nominal, np.full(3, 10.0), nominal)
    assert not np.any(error < 1e-3)
