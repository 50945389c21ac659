"""The arms of the tests of arm angles, and what is known of them by vector algebra alone."""

from __future__ import annotations

from functools import cache

import numpy as np
from virtualrobot_plugins.arm_angle.component import ArmAngleKinematics
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.denavit_hartenberg import Row, Table
from virtualrobot_sdk.kinematics import SerialChain
from virtualrobot_sdk.testing.chains import chain_of
from virtualrobot_sdk.testing.chains import iiwa as iiwa_by_table

from ..closed_form import arms

NAMES = ("iiwa", "iiwa7", "wam")
STRAIGHT = {"iiwa": 0.0, "iiwa7": 0.0, "wam": np.arctan2(0.045, 0.55) + np.arctan2(0.045, 0.3)}
"""Where joint 4 stretches the arm."""
QUARTER = np.pi / 2


@cache
def chain_of_arm(name: str) -> SerialChain:
    """Return the iiwa 14 of the model table, the iiwa 7 by its table, or the WAM, whose elbow has an offset of 45 mm.

    Barrett Technology, WAM User's Manual, 7-DOF Denavit-Hartenberg table: a_3 = 0.045, a_4 = -0.045, d_3 = 0.55,
    d_5 = 0.3, d_7 = 0.06 m.
    """
    if name == "iiwa":
        return arms.arm_chain("iiwa")
    if name == "iiwa7":
        return iiwa_by_table()
    rows = (
        Row(alpha_radians=-QUARTER),
        Row(alpha_radians=QUARTER),
        Row(a_meters=0.045, alpha_radians=-QUARTER, d_meters=0.55),
        Row(a_meters=-0.045, alpha_radians=QUARTER),
        Row(alpha_radians=-QUARTER, d_meters=0.3),
        Row(alpha_radians=QUARTER),
        Row(d_meters=0.06),
    )
    limits = [(-2.6, 2.6), (-2.0, 2.0), (-2.8, 2.8), (-0.9, 3.1), (-4.76, 1.24), (-1.6, 1.6), (-3.0, 3.0)]
    return chain_of(Table("standard", rows), limits)


@cache
def arm(name: str) -> ArmAngleKinematics:
    """Return an arm as the component."""
    return ArmAngleKinematics(chain_of_arm(name))


@cache
def numeric(name: str) -> ChainKinematics:
    """Return an arm as the component `chain`, which knows nothing of arm angles."""
    return ChainKinematics(chain_of_arm(name))


def axes(name: str, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return direction and a point of each axis (7, 3) at q, by the forward pass of `chain`."""
    frames = numeric(name).forward(q)
    return np.einsum("nij,nj->ni", frames[:-1, :3, :3], chain_of_arm(name).axis), frames[:-1, :3, 3]


def meeting(h: np.ndarray, p: np.ndarray, i: int, j: int) -> np.ndarray:
    """Return where axis i meets axis j."""
    across = np.cross(h[i], h[j])
    return p[i] + h[i] * (np.cross(p[j] - p[i], h[j]) @ across) / (across @ across)


def elbow_angle(name: str, q: np.ndarray) -> float:
    """Return the angle of the elbow about the line from shoulder to wrist, from the side to which axis 1 points."""
    h, p = axes(name, q)
    shoulder, wrist = meeting(h, p, 0, 1), meeting(h, p, 5, 6)
    # The elbow: where axis 4 crosses the plane through the shoulder across it.
    elbow = p[3] + ((shoulder - p[3]) @ h[3]) * h[3]
    line = (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
    up, out = h[0] - (h[0] @ line) * line, (elbow - shoulder) - ((elbow - shoulder) @ line) * line
    return float(np.arctan2(np.cross(up, out) @ line, up @ out))


def between(a: float, b: float) -> float:
    """Return how far two angles are apart."""
    return abs((a - b + np.pi) % (2.0 * np.pi) - np.pi)
