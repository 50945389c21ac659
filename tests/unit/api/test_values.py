"""Quaternions and matrices: laws of the way there and back."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot.v1 import geometry_pb2
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.values import array, pose, pose_message, snapped
from virtualrobot_sdk.poses import from_quaternion, quaternion


def many(rng: np.random.Generator) -> np.ndarray:
    """Return random quaternions, those of quarter and half turns, and some with tiny or equal components."""
    angles = (0.0, np.pi / 2, -np.pi / 2, np.pi, 1.5707963, 1e-9, 0.3)
    turns = Rotation.from_euler("xyz", list(itertools.product(angles, repeat=3))).as_quat()
    signs = np.array([s for s in itertools.product((-1.0, 0.0, 1.0), repeat=4) if any(s)])
    return np.concatenate([rng.normal(size=(2000, 4)), turns, signs, rng.normal(size=(200, 4)) * [1e-8, 1, 1e-8, 1]])


def test_a_snapped_quaternion_survives_matrix_and_back_to_the_last_bit(rng: np.random.Generator) -> None:
    for xyzw in many(rng):
        there = snapped(xyzw, "q")
        back = snapped(np.array(quaternion(from_quaternion(there))), "q")
        assert there.tobytes() == back.tobytes(), xyzw


def test_snapping_turns_by_less_than_anyone_can_measure(rng: np.random.Generator) -> None:
    given = many(rng)
    turned = Rotation.from_quat(np.array([snapped(xyzw, "q") for xyzw in given]))
    assert (turned * Rotation.from_quat(given).inv()).magnitude().max() < 1e-13


def test_poses_come_back_as_they_went(rng: np.random.Generator) -> None:
    for xyzw in many(rng):
        x, y, z, w = xyzw
        px, py, pz = rng.uniform(-2, 2, 3)
        message = geometry_pb2.Pose(
            position=geometry_pb2.Vector3(x=px, y=py, z=pz),
            orientation=geometry_pb2.Quaternion(x=x, y=y, z=z, w=w),
        )
        matrix = pose(message)
        assert matrix.tobytes() == pose(pose_message(matrix)).tobytes()


@pytest.mark.parametrize("bad", [(0, 0, 0, 0), (np.nan, 0, 0, 1), (np.inf, 0, 0, 1)])
def test_impossible_quaternions_are_refused(bad: tuple[float, ...]) -> None:
    with pytest.raises(KernelError, match="orientation must be a quaternion of a length above 0"):
        pose(geometry_pb2.Pose(orientation=geometry_pb2.Quaternion(**dict(zip("xyzw", bad, strict=True)))))


FLOAT64 = geometry_pb2.NUMERIC_TYPE_FLOAT64
NAN = np.array([1.0, np.nan, 3.0])


@pytest.mark.parametrize(
    ("fields", "match"),
    [
        ({"shape": [2, 3], "data": bytes(48)}, "must say how the numbers are stored"),
        (
            {"type": FLOAT64, "shape": [2, 2], "data": bytes(32)},
            r"must have the shape \(n, 3\)",
        ),
        ({"type": FLOAT64, "shape": [2, 3], "data": bytes(47)}, "needs 48 bytes, not 47"),
        ({"type": FLOAT64, "shape": [1] * 65, "data": bytes(8)}, "may have 8 dimensions, not 65"),
        ({"type": FLOAT64, "shape": [2**31, 3]}, "needs 51539607552 bytes, not 0"),
        (
            {
                "type": geometry_pb2.NUMERIC_TYPE_FLOAT32,
                "shape": [1, 3],
                "data": np.array([1, np.nan, 3], np.float32).tobytes(),
            },
            "not finite",
        ),
    ],
)
def test_impossible_arrays_are_refused(fields: dict, match: str) -> None:
    with pytest.raises(KernelError, match=match):
        array(geometry_pb2.NumericArray(**fields), (None, 3), "points")
