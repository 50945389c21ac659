"""Kinematics of Universal Robots' arms: tables of the data sheets, poses as the controller writes them.

A pose is (x, y, z, rx, ry, rz): position (m) and rotation vector (rad) of the TCP in the controller's base frame.
Source of the tables: Universal Robots, "DH Parameters for calculations of kinematics and dynamics"; standard
Denavit-Hartenberg parameters, alpha = (pi/2, 0, 0, pi/2, -pi/2, 0).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from virtualrobot.geometry import rotation_from_vector, rotation_vector_of

Floats: TypeAlias = NDArray[np.float64]

_ALPHA = (np.pi / 2, 0.0, 0.0, np.pi / 2, -np.pi / 2, 0.0)
_STEP = 0.3
"""Longest step (rad, m) of one iteration of the inverse."""


@dataclass(frozen=True, slots=True)
class Model:
    """An arm: what its controller calls it, and its lengths (m).

    Attributes:
        type: the word that the dashboard has for it; those of the e-Series have the one of their elder.
        d: offsets along the joints' axes (6,).
        a: lengths of the links (6,).
    """

    type: str
    d: tuple[float, ...]
    a: tuple[float, ...]


def _model(kind: str, d1: float, a2: float, a3: float, d4: float, d5: float, d6: float) -> Model:
    return Model(kind, (d1, 0.0, 0.0, d4, d5, d6), (0.0, -a2, -a3, 0.0, 0.0, 0.0))


MODELS = {
    "ur3": _model("UR3", 0.1519, 0.24365, 0.21325, 0.11235, 0.08535, 0.0819),
    "ur5": _model("UR5", 0.089159, 0.425, 0.39225, 0.10915, 0.09465, 0.0823),
    "ur10": _model("UR10", 0.1273, 0.612, 0.5723, 0.163941, 0.1157, 0.0922),
    "ur3e": _model("UR3", 0.15185, 0.24355, 0.2132, 0.13105, 0.08535, 0.0921),
    "ur5e": _model("UR5", 0.1625, 0.425, 0.3922, 0.1333, 0.0997, 0.0996),
    "ur10e": _model("UR10", 0.1807, 0.6127, 0.57155, 0.17415, 0.11985, 0.11655),
    "ur16e": _model("UR16", 0.1807, 0.4784, 0.36, 0.17415, 0.11985, 0.11655),
}


class NoPosture(ValueError):
    """No posture has the pose that was asked for."""


def matrix_of(pose: Floats) -> Floats:
    """Return the matrix (4, 4) of a pose (6,)."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation_from_vector(pose[3:]), pose[:3]
    return matrix


def pose_of(matrix: Floats) -> Floats:
    """Return the pose (6,) of a matrix (4, 4)."""
    return np.concatenate([matrix[:3, 3], rotation_vector_of(matrix[:3, :3])])


def _frames(model: Model, positions: Floats) -> list[Floats]:
    """Return the base frame and that after each joint, (4, 4) each."""
    frames = [np.eye(4)]
    for theta, d, a, alpha in zip(positions, model.d, model.a, _ALPHA, strict=True):
        c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
        step = np.array(
            [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0.0, sa, ca, d], [0.0, 0.0, 0.0, 1.0]]
        )
        frames.append(frames[-1] @ step)
    return frames


def forward(model: Model, positions: Floats, tcp: Floats | None = None) -> Floats:
    """Return the matrix (4, 4) of the TCP at joint positions (6,); `tcp` (4, 4) is the TCP in the flange's frame."""
    flange = _frames(model, positions)[-1]
    return flange if tcp is None else flange @ tcp


def jacobian(model: Model, positions: Floats, tcp: Floats | None = None) -> Floats:
    """Return the Jacobian (6, 6) of the TCP's linear and angular velocity in the base frame."""
    frames = _frames(model, positions)
    tip = (frames[-1] if tcp is None else frames[-1] @ tcp)[:3, 3]
    columns = [np.concatenate([np.cross(frame[:3, 2], tip - frame[:3, 3]), frame[:3, 2]]) for frame in frames[:-1]]
    return np.array(columns).T


def inverse(model: Model, pose: Floats, near: Floats, tcp: Floats | None = None) -> Floats:
    """Return joint positions (6,) at which the TCP has `pose` (4, 4), reached from `near` by damped Newton steps.

    Raises NoPosture where none is found.
    """
    positions = np.array(near, dtype=np.float64)
    for _ in range(100):
        here = forward(model, positions, tcp)
        error = np.concatenate([pose[:3, 3] - here[:3, 3], rotation_vector_of(pose[:3, :3] @ here[:3, :3].T)])
        if np.abs(error).max() < 1e-9:
            return positions
        error *= min(1.0, _STEP / np.abs(error).max())
        slope = jacobian(model, positions, tcp)
        damping = 1e-6 * np.eye(6)
        step = slope.T @ np.linalg.solve(slope @ slope.T + damping, error)
        positions += step * min(1.0, _STEP / max(np.abs(step).max(), 1e-12))
    raise NoPosture(f"no posture near {np.round(near, 4).tolist()} has the pose {np.round(pose_of(pose), 4).tolist()}")
