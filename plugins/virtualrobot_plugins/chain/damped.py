"""One damped least squares step within limits, compiled into the functions that call it."""

from __future__ import annotations

import math

from virtualrobot_sdk.compiled.cache import inlined
from virtualrobot_sdk.kinematics import Floats


@inlined
def damped_step(jacobian: Floats, error: Floats, damping: float, triangle: Floats, y: Floats, step: Floats) -> None:
    """Write J^T (J J^T + damping I)^-1 error to `step` (k,).

    `triangle` (6, 6) and `y` (6,) are work space: the Cholesky factor, with the reciprocals of its diagonal, and the
    solution of the normal equations.
    """
    k = jacobian.shape[1]
    for row in range(6):
        for column in range(row + 1):
            value = damping if row == column else 0.0
            for i in range(k):
                value += jacobian[row, i] * jacobian[column, i]
            for m in range(column):
                value -= triangle[row, m] * triangle[column, m]
            if row == column:
                # Rounding may eat all of a small damping where the arm is singular.
                triangle[row, column] = 1.0 / math.sqrt(max(value, 1e-300))
            else:
                triangle[row, column] = value * triangle[column, column]
    for row in range(6):
        value = error[row]
        for m in range(row):
            value -= triangle[row, m] * y[m]
        y[row] = value * triangle[row, row]
    for row in range(5, -1, -1):
        value = y[row]
        for m in range(row + 1, 6):
            value -= triangle[m, row] * y[m]
        y[row] = value * triangle[row, row]
    for i in range(k):
        value = 0.0
        for row in range(6):
            value += jacobian[row, i] * y[row]
        step[i] = value


@inlined
def step_within_limits(
    jacobian: Floats,
    error: Floats,
    damping: float,
    q: Floats,
    lower: Floats,
    upper: Floats,
    triangle: Floats,
    y: Floats,
    step: Floats,
) -> None:
    """Write the damped step from q (k,) to `step`, with 0 for coordinates that it would push through their limit.

    Their columns of the Jacobian are set to 0 and the step is computed again until none is left (active set), so that
    the others make up for them.
    """
    k = q.shape[0]
    for _ in range(k + 1):
        damped_step(jacobian, error, damping, triangle, y, step)
        held = False
        for i in range(k):
            if (q[i] >= upper[i] and step[i] > 0.0) or (q[i] <= lower[i] and step[i] < 0.0):
                for row in range(6):
                    jacobian[row, i] = 0.0
                held = True
        if not held:
            return
