"""Principal axes of bodies, as engines take moments of inertia."""

from __future__ import annotations

import numpy as np
from virtualrobot_sdk.physics import Body
from virtualrobot_sdk.poses import quaternion

Quaternion = tuple[float, float, float, float]


def principal(body: Body) -> tuple[Quaternion, tuple[float, float, float]]:
    """Return the rotation (x, y, z, w) of a body's principal axes in its own, and its moments about them (kg m^2).

    None is above the sum of the others, as rounding may make that of a thin plate.
    """
    inertia = np.asarray(body.inertia, float)
    if np.allclose(inertia, np.diag(np.diag(inertia)), rtol=0.0, atol=1e-15):
        moments, axes = np.diag(inertia).copy(), np.eye(3)
    else:
        moments, axes = np.linalg.eigh(inertia)
        if np.linalg.det(axes) < 0.0:
            axes[:, 0] *= -1.0
    greatest = int(np.argmax(moments))
    others = np.delete(moments, greatest)
    moments[greatest] = min(moments[greatest], others[0] + others[1])
    x, y, z = moments.tolist()
    return quaternion(axes), (x, y, z)
