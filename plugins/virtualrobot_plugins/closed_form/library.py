"""The library EAIK: angles of all branches of a pose, by subproblems that have closed forms.

D. Ostermeier, J. Kuelz, M. Althoff, Automatic geometric decomposition for analytical inverse kinematics, IEEE Robotics
and Automation Letters, 2025.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_plugins.closed_form.geometry import Axes

Angles = Callable[[Floats], Floats]
"""Angles (n, branches) of a pose (4, 4), least-squares attempts included; contiguous."""


def solver_of(axes: Axes) -> Angles:
    """Return what gives the angles of poses of an arm.

    Raises ArgumentError when the library is not installed or knows no closed form for this geometry.
    """
    try:
        # The class below the library's own: its Python wrappers import a URDF parser that we have no use for.
        from eaik.pybindings.EAIK import Robot
    except ImportError as error:
        raise ArgumentError(
            f"the library EAIK is not installed ({error}): pip install 'virtualrobot[closed-form]'"
        ) from error
    n = len(axes.direction)
    offsets = np.diff(np.vstack([np.zeros(3), axes.point, axes.base_t_tip[:3, 3]]), axis=0)
    robot = Robot(axes.direction.T, offsets.T, axes.base_t_tip[:3, :3], [], True)
    if not robot.has_known_decomposition():
        family = robot.get_kinematic_family()
        raise ArgumentError(
            f"the library EAIK knows no closed form for this geometry ({family}): it needs three axes in a row that "
            "meet in a point or are parallel",
            family=family,
        )
    calculate = robot.calculate_IK
    empty = np.empty((n, 0))

    def angles(base_t_tip: Floats) -> Floats:
        found = calculate(base_t_tip).Q
        # The library keeps rows in columns, so that this is contiguous; without a branch it has no columns.
        return found.T if found.size else empty

    return angles
