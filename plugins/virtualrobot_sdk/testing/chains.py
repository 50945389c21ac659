"""The chains that the test kit tries components on, from published tables; and chains from one's own table."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from virtualrobot_sdk.denavit_hartenberg import Row, Table, serial_arrays
from virtualrobot_sdk.kinematics import Floats, SerialChain

QUARTER = np.pi / 2


def chain_of(
    table: Table, limits: Sequence[tuple[float, float]], joint_names: Sequence[str] | None = None
) -> SerialChain:
    """Return the chain of a Denavit-Hartenberg table.

    Args:
        table: a row for each joint.
        limits: lowest and highest position of each joint (rad or m); -inf and inf where there is none.
        joint_names: of each joint; None: `joint_1` and so on.
    """
    n = len(table.rows)
    arrays = serial_arrays(table)
    lower, upper = np.array(limits, dtype=np.float64).reshape(n, 2).T
    return SerialChain(
        pre=arrays.pre,
        axis=arrays.axis,
        joint_type=arrays.joint_type,
        q_index=np.arange(n, dtype=np.int32),
        multiplier=np.ones(n),
        offset=np.zeros(n),
        post=arrays.post,
        lower=lower.copy(),
        upper=upper.copy(),
        joint_names=tuple(joint_names or (f"joint_{i + 1}" for i in range(n))),
    )


PUMA560 = Table(
    "standard",
    (
        Row(alpha_radians=QUARTER),
        Row(a_meters=0.4318),
        Row(d_meters=0.15005, a_meters=0.0203, alpha_radians=-QUARTER),
        Row(d_meters=0.4318, alpha_radians=QUARTER),
        Row(alpha_radians=-QUARTER),
        Row(),
    ),
)
"""P. Corke and B. Armstrong-Helouvry, A search for consensus among model parameters reported for the PUMA 560 robot,
ICRA 1994."""


def puma560() -> SerialChain:
    """Return the Unimation Puma 560, six turning joints with a spherical wrist: up to 8 solutions.

    Limits from L.-C. Wang and C. Chen, IEEE Trans. Robotics and Automation 7(4), 1991.
    """
    return chain_of(PUMA560, _degrees((-160, 160), (-45, 225), (-225, 45), (-110, 170), (-100, 100), (-266, 266)))


def iiwa() -> SerialChain:
    """Return the KUKA LBR iiwa 7 R800, seven turning joints: endlessly many solutions.

    C. Faria, F. Ferreira, W. Erlhagen, S. Monteiro, E. Bicho, Position-based kinematics for 7-DoF serial manipulators,
    Mechanism and Machine Theory 121, 2018, table 1.
    """
    lengths = (0.34, 0.0, 0.4, 0.0, 0.4, 0.0, 0.126)
    twists = (-QUARTER, QUARTER, QUARTER, -QUARTER, -QUARTER, QUARTER, 0.0)
    rows = tuple(Row(d_meters=d, alpha_radians=alpha) for d, alpha in zip(lengths, twists, strict=True))
    limits = _degrees(*((-limit, limit) for limit in (170, 120, 170, 120, 170, 120, 175)))
    return chain_of(Table("standard", rows), limits)


def stanford() -> SerialChain:
    """Return the Stanford arm, whose third joint slides.

    R. Paul, Modelling, trajectory calculation and servoing of a computer controlled arm, Stanford AIM-177, 1972; with
    its numbers as in the model `mdl_stanford` of P. Corke's Robotics Toolbox.
    """
    rows = (
        Row(d_meters=0.412, alpha_radians=-QUARTER),
        Row(d_meters=0.154, alpha_radians=QUARTER),
        Row("prismatic", theta_radians=-QUARTER),
        Row(alpha_radians=-QUARTER),
        Row(alpha_radians=QUARTER),
        Row(d_meters=0.263),
    )
    limits = _degrees((-170, 170), (-170, 170), (0, 0), (-170, 170), (-90, 90), (-170, 170))
    limits[2] = (0.3048, 1.27)
    return chain_of(Table("standard", rows), limits)


def ur5(limit: float = 2.0 * np.pi) -> SerialChain:
    """Return the Universal Robots UR5, whose joints turn by `limit` (rad) to both sides: a whole turn on the real one.

    Universal Robots, DH parameters for calculations of kinematics and dynamics (support article 15310).
    """
    rows = (
        Row(d_meters=0.089159, alpha_radians=QUARTER),
        Row(a_meters=-0.425),
        Row(a_meters=-0.39225),
        Row(d_meters=0.10915, alpha_radians=QUARTER),
        Row(d_meters=0.09465, alpha_radians=-QUARTER),
        Row(d_meters=0.0823),
    )
    return chain_of(Table("standard", rows), [(-limit, limit)] * 6)


def scara() -> SerialChain:
    """Return a SCARA: two turning joints, one that slides and one that turns, all about or along upright axes."""
    rows = (Row(d_meters=0.4, a_meters=0.425), Row(a_meters=0.375), Row("prismatic"), Row())
    limits = _degrees((-150, 150), (-147, 147), (0, 0), (-270, 270))
    limits[2] = (-0.2, 0.0)
    return chain_of(Table("standard", rows), limits)


PALLETIZER = Table(
    "modified",
    (
        Row(d_meters=0.8),
        Row(a_meters=0.25, alpha_radians=-QUARTER),
        Row(a_meters=0.8),
        Row(a_meters=0.8),
        Row(),
        Row(a_meters=0.1, alpha_radians=QUARTER),
    ),
    last_t_flange=(0.0, 0.0, -0.2, 1.0, 0.0, 0.0, 0.0),
)
"""Lengths of no maker's."""


def palletizer() -> SerialChain:
    """Return an arm with four coordinates whose hand stays level: two joints of its wrist mimic shoulder and elbow."""
    limits = np.array(_degrees((-170, 170), (-130, 0), (10, 150), (-300, 300)))
    return chain_of(PALLETIZER, [(0.0, 0.0)] * 6)._replace(
        q_index=np.array([0, 1, 2, 1, 2, 3], dtype=np.int32),
        multiplier=np.array([1.0, 1.0, 1.0, -1.0, -1.0, 1.0]),
        lower=limits[:, 0].copy(),
        upper=limits[:, 1].copy(),
        joint_names=("base", "shoulder", "elbow", "hand"),
    )


def mounted(chain: SerialChain, world_t_base: Floats, flange_t_tool: Floats) -> SerialChain:
    """Return a chain on another base and with a tool; both are poses (4, 4)."""
    return chain._replace(
        pre=np.concatenate([[world_t_base @ chain.pre[0]], chain.pre[1:]]), post=chain.post @ flange_t_tool
    )


def _pose(x: float, y: float, z: float, roll: float = 0.0, yaw: float = 0.0) -> Floats:
    """Return a shift (m) and a turn about x, then about z (rad)."""
    (sin_r, cos_r), (sin_y, cos_y) = ((np.sin(angle), np.cos(angle)) for angle in (roll, yaw))
    return np.array(
        [
            [cos_y, -sin_y * cos_r, sin_y * sin_r, x],
            [sin_y, cos_y * cos_r, -cos_y * sin_r, y],
            [0.0, sin_r, cos_r, z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def kit_chains() -> dict[str, SerialChain]:
    """Return the chains that components are tried on, by name."""
    return {
        "puma560": puma560(),
        "puma560_mounted": mounted(puma560(), _pose(0.3, -0.2, 0.5, 2.1, 0.7), _pose(0.02, 0.05, 0.13, 0.4, -1.1)),
        "iiwa": iiwa(),
        "stanford": stanford(),
        "ur5": ur5(),
        "ur5_without_limits": ur5(np.inf),
        "scara": scara(),
        "scara_mounted": mounted(scara(), _pose(0.12, 0.0, 0.3), _pose(0.0, 0.0, -0.07)),
        "palletizer": palletizer(),
    }


def _degrees(*limits: tuple[float, float]) -> list[tuple[float, float]]:
    return [(float(np.radians(lower)), float(np.radians(upper))) for lower, upper in limits]
