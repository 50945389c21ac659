"""Tridiagonal systems of many right sides; compiled.

Source: L. H. Thomas's elimination, as in Golub, Van Loan, Matrix Computations (4th ed.), section 4.3.6.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float64
from virtualrobot_sdk.compiled.cache import array_of, compiled, output_of

Floats = np.ndarray[Any, np.dtype[np.float64]]
_ONE = array_of(float64, 1)


@compiled(_ONE, _ONE, _ONE, array_of(float64, 2), output_of(float64, 2))
def eliminate(below: Floats, diagonal: Floats, above: Floats, right: Floats, solution: Floats) -> None:
    """Write the solutions (m, k) of a diagonally dominant system (m,) for right sides (m, k).

    Args:
        below: (m - 1,).
        diagonal: (m,).
        above: (m - 1,).
        right: (m, k).
        solution: (m, k) what is written.
    """
    m, k = right.shape
    pivot = np.empty(m)
    for i in range(m):
        pivot[i] = diagonal[i]
        factor = 0.0
        if i > 0:
            factor = below[i - 1] / pivot[i - 1]
            pivot[i] -= factor * above[i - 1]
        for j in range(k):
            solution[i, j] = right[i, j] - (factor * solution[i - 1, j] if i > 0 else 0.0)
    for i in range(m - 1, -1, -1):
        for j in range(k):
            rest = above[i] * solution[i + 1, j] if i < m - 1 else 0.0
            solution[i, j] = (solution[i, j] - rest) / pivot[i]
