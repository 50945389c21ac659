"""Model of an arm for the compiled code, packed into few arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_plugins.closed_form.geometry import Axes
from virtualrobot_plugins.closed_form.names import Scheme

NAMED, FIXED, PARALLEL, SPHERICAL = 1, 2, 4, 8
"""Bit flags of an arm's geometry: its branches have names; W is fixed to its tip; axes 2, 3, 4 are parallel; E is W."""
NUMBERS = 23
"""Number of scalars before the frames in `Model.numbers`."""


class Model(NamedTuple):
    """Model of an arm for the compiled code; see `Scheme`. Few arrays, since handing over each costs 0.1 µs."""

    numbers: Floats
    """(23 + 16 n + 16,) up, signs of shoulder and wrist, lateral, 1 / reach, places of W and E on their axes, W and h_6
    in the tip's frame, p_1 and u in the base frame, p_2 before and above p_1, lengths from axis 2 to 3 and from there
    to W; then (4, 4) what stands before each joint about z, and after the last."""
    wrist_frame: int
    elbow_frame: int
    kind: int
    """NAMED, FIXED, PARALLEL and SPHERICAL, added."""


def model_of(frames: Floats, axes: Axes, scheme: Scheme, reach: float) -> Model:
    """Return what the compiled code needs of an arm."""
    n = len(axes.direction)
    centre = axes.base_t_tip[:3, 3]
    if scheme.wrist_frame < n:
        centre = axes.point[scheme.wrist_frame] + scheme.wrist_shift * axes.direction[scheme.wrist_frame]
    tip = axes.base_t_tip[:3, :3]
    numbers = np.concatenate(
        [
            [scheme.up, scheme.shoulder_sign, scheme.wrist_sign, scheme.lateral, 1.0 / reach if reach > 0.0 else 1.0],
            [scheme.wrist_shift, scheme.elbow_shift],
            tip.T @ (centre - axes.base_t_tip[:3, 3]),
            tip.T @ axes.direction[-1],
            axes.point[0],
            scheme.up * axes.direction[0],
            _arm_lengths(axes, scheme, centre),
        ]
    )
    fixed = bool(scheme.words) and scheme.wrist_frame >= n - (n == 6)
    is_spherical = n == 6 and fixed and not scheme.is_parallel
    kind = NAMED * bool(scheme.words) + FIXED * fixed + PARALLEL * scheme.is_parallel + SPHERICAL * is_spherical
    packed = np.concatenate([numbers, np.ravel(frames)])
    return Model(packed, scheme.wrist_frame, scheme.elbow_frame, kind)


def _arm_lengths(axes: Axes, scheme: Scheme, centre: Floats) -> Floats:
    """Return p_2 before and above p_1, and the lengths from axis 2 to 3 and from there to W, across axis 2 (m)."""
    if not scheme.words:
        return np.zeros(4)
    h, p = axes.direction, axes.point
    up = scheme.up * h[0]
    base = p[1] - p[0]
    lengths = [float(np.linalg.norm(np.cross(link, h[1]))) for link in (p[2] - p[1], centre - p[2])]
    return np.array([np.cross(up, base) @ h[1], up @ base, *lengths])
