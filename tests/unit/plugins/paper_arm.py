"""The arm of the augmented-reality paper: its Table 1, its matrix, and its closed form as printed and as corrected.

"Development of Augmented Reality Application for Teaching Mechanism and Robotics in ROS", section 2. Sines and cosines
may be floats or fractions: with fractions of rational points on the circle, equality is exact.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeVar

import numpy as np

Number = TypeVar("Number", float, Fraction)
Matrix = list[list[Number]]

TWIST_DEGREES = (90, 0, 90, -90, 90, 0)
"""Table 1, alpha; the paper writes no unit."""
ENTRIES = [f"{column}_{row}" for column in "noap" for row in "xyz"]


@dataclass(frozen=True)
class Lengths:
    """The lengths of Table 1; every other a and d is 0 there."""

    a_1: float | Fraction
    a_2: float | Fraction
    d_1: float | Fraction
    d_4: float | Fraction
    d_6: float | Fraction

    def rows(self) -> list[tuple]:
        """Return (a, d) of each row."""
        return [(self.a_1, self.d_1), (self.a_2, 0), (0, 0), (0, self.d_4), (0, 0), (0, self.d_6)]


def row_matrix(sine: Number, cosine: Number, twist: tuple, a: Number, d: Number) -> Matrix:
    """Return T_i^{i-1} as section 2.1 prints it; `twist` is (sine, cosine) of alpha."""
    sa, ca = twist
    return [
        [cosine, -ca * sine, sa * sine, a * cosine],
        [sine, ca * cosine, -sa * cosine, a * sine],
        [0, sa, ca, d],
        [0, 0, 0, 1],
    ]


def product(sines: Sequence[Number], cosines: Sequence[Number], twists: Sequence[tuple], lengths: Lengths) -> dict:
    """Return the twelve entries of T_6^0, the product of the six matrices of the table."""
    total: Matrix = [[int(i == j) for j in range(4)] for i in range(4)]
    for s, c, twist, (a, d) in zip(sines, cosines, twists, lengths.rows(), strict=True):
        row = row_matrix(s, c, twist, a, d)
        total = [[sum(total[i][k] * row[k][j] for k in range(4)) for j in range(4)] for i in range(4)]
    return {f"{column}_{row}": total[i][j] for j, column in enumerate("noap") for i, row in enumerate("xyz")}


def printed(sines: Sequence[Number], cosines: Sequence[Number], lengths: Lengths) -> dict:
    """Return the twelve entries of T_6^0 by the formulas of section 2.2, as printed."""
    s1, s2, s3, s4, s5, s6 = sines
    c1, c2, c3, c4, c5, c6 = cosines
    s23, c23 = s2 * c3 + c2 * s3, c2 * c3 - s2 * s3
    a_1, a_2, d_1, d_4, d_6 = lengths.a_1, lengths.a_2, lengths.d_1, lengths.d_4, lengths.d_6
    return {
        "n_x": s6 * (c4 * s1 - s4 * c1 * c23) + c6 * (c5 * (s1 * s4 + c4 * c1 * c23) - s5 * c1 * s23),
        "n_y": -s6 * (c1 * c4 + s4 * s1 * c23) - c6 * (c5 * (c1 * s4 - c4 * s1 * c23) + s5 * s1 * s23),
        "n_z": c6 * (s5 * c23 + c4 * c5 * s23) - s4 * s6 * s23,
        "o_x": c6 * (c4 * s1 - s4 * c1 * c23) - s6 * (c5 * (s1 * s4 + c4 * c1 * c23) - s5 * c1 * s23),
        "o_y": s6 * (c5 * (c1 * s4 + c4 * s1 * c23) + s5 * s1 * s23) - c6 * (c1 * c4 + s4 * s1 * c23),
        "o_z": -s6 * (s5 * c23 + c4 * c5 * s23) - c6 * s4 * s23,
        "a_x": s5 * (s1 * s4 + c4 * c1 * c23) + c5 * c1 * s23,
        "a_y": c5 * (s1 * s23) - s5 * (c1 * s4 - c4 * s1 * c23),
        "a_z": c4 * s5 * s23 - c5 * c23,
        "p_x": d_6 * (s5 * (s1 * s4 + c4 * c1 * c23) + c5 * c1 * s23) + d_4 * c1 * s23 + a_1 * c1 + a_2 * c1 * c2,
        "p_y": d_4 * s1 * c23 - d_6 * (s5 * (c1 * s4 - c4 * s1 * c23) - c5 * s1 * s23) + a_1 * s1 + a_2 * c2 * s1,
        "p_z": d_1 - d_4 * c23 + a_2 * s2 - d_6 * (c5 * c23 - c4 * s5 * s23),
    }


def corrected(sines: Sequence[Number], cosines: Sequence[Number], lengths: Lengths) -> dict:
    """Return the twelve entries of T_6^0, the two wrong ones put right."""
    s1, s2, s3, s4, s5, s6 = sines
    c1, c2, c3, c4, c5, c6 = cosines
    s23, c23 = s2 * c3 + c2 * s3, c2 * c3 - s2 * s3
    return {
        **printed(sines, cosines, lengths),
        "o_y": s6 * (c5 * (c1 * s4 - c4 * s1 * c23) + s5 * s1 * s23) - c6 * (c1 * c4 + s4 * s1 * c23),
        "p_y": lengths.d_4 * s1 * s23
        - lengths.d_6 * (s5 * (c1 * s4 - c4 * s1 * c23) - c5 * s1 * s23)
        + lengths.a_1 * s1
        + lengths.a_2 * c2 * s1,
    }


def pose(entries: Mapping[str, float]) -> np.ndarray:
    """Return the twelve entries as (4, 4)."""
    result = np.eye(4)
    for j, column in enumerate("noap"):
        for i, row in enumerate("xyz"):
            result[i, j] = entries[f"{column}_{row}"]
    return result


def closed_form(q: np.ndarray, lengths: Lengths, form: Callable[..., dict] = corrected) -> np.ndarray:
    """Return T_6^0 (4, 4) at the joint angles q (6,) by the corrected formulas, or another form."""
    return pose(form(np.sin(q).tolist(), np.cos(q).tolist(), lengths))
