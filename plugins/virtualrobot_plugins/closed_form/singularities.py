"""Singularities that a posture or a target is at, and the branch between them that a posture is on; compiled."""

from __future__ import annotations

import math

from virtualrobot_sdk.compiled.cache import inlined
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_plugins.closed_form.model import PARALLEL, SPHERICAL

SINGULAR = 2e-5
"""Bound (of 1, or of the arm's reach) below which shoulder, elbow or wrist are singular, and are looked at again."""
SINGULAR_OF_SEVEN = 1e-4
"""The same bound for seven axes, which may be near two singularities at once and whose posture they blur more."""
SHOULDER, ELBOW, WRIST, LOOSE = 1, 2, 4, 8
"""Bit flags of an answer: at the singularity of that name, or with angles that need polish."""


@inlined
def target_flags(target: Floats, numbers: Floats, kind: int) -> tuple[int, int]:
    """Return which singularities the target itself is at, and how many branches reach it as far as that is known.

    EAIK finds no angles where a wrist is straight, and may find none where an arm is.
    """
    flags = 0
    expected = 0
    wx = target[0, 3] + target[0, 0] * numbers[7] + target[0, 1] * numbers[8] + target[0, 2] * numbers[9] - numbers[13]
    wy = target[1, 3] + target[1, 0] * numbers[7] + target[1, 1] * numbers[8] + target[1, 2] * numbers[9] - numbers[14]
    wz = target[2, 3] + target[2, 0] * numbers[7] + target[2, 1] * numbers[8] + target[2, 2] * numbers[9] - numbers[15]
    ux, uy, uz = numbers[16], numbers[17], numbers[18]
    along = wx * ux + wy * uy + wz * uz
    wx, wy, wz = wx - along * ux, wy - along * uy, wz - along * uz
    lateral = numbers[3]
    square = wx * wx + wy * wy + wz * wz
    forward = square - lateral * lateral
    if abs(forward) * numbers[4] * numbers[4] < SINGULAR * SINGULAR:
        flags |= SHOULDER
    if kind & PARALLEL != 0 and forward > 0.0 and square > 0.0:
        zx = target[0, 0] * numbers[10] + target[0, 1] * numbers[11] + target[0, 2] * numbers[12]
        zy = target[1, 0] * numbers[10] + target[1, 1] * numbers[11] + target[1, 2] * numbers[12]
        zz = target[2, 0] * numbers[10] + target[2, 1] * numbers[11] + target[2, 2] * numbers[12]
        # Axis 2 of both shoulders: its part along W's radius is lateral / radius.
        first = lateral / square
        second = math.sqrt(forward) / square
        vx, vy, vz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
        for sign in (-1.0, 1.0):
            hx = first * wx + sign * second * vx
            hy = first * wy + sign * second * vy
            hz = first * wz + sign * second * vz
            cosine = hx * zx + hy * zy + hz * zz
            if 1.0 - cosine * cosine < SINGULAR * SINGULAR:
                flags |= WRIST
    if kind & SPHERICAL != 0 and forward > 0.0:
        for sign in (-1.0, 1.0):
            before = sign * math.sqrt(forward) - numbers[19]
            above = along - numbers[20]
            # The law of cosines: the elbow's cosine is beyond 1 where the arm is too long or too short.
            double = 2.0 * numbers[21] * numbers[22]
            cosine = (before * before + above * above - numbers[21] ** 2 - numbers[22] ** 2) / double
            if abs(abs(cosine) - 1.0) < SINGULAR * SINGULAR:
                flags |= ELBOW
            if abs(cosine) < 1.0:
                expected += 4
    return flags, expected


@inlined
def branch_of(f: Floats, numbers: Floats, w: int, e: int) -> tuple[int, int]:
    """Return the branch's number and the singularities that it is at, from the joints' frames."""
    n = f.shape[0] - 1
    scale = numbers[4]
    wx = f[w, 0, 3] + numbers[5] * f[w, 0, 2]
    wy = f[w, 1, 3] + numbers[5] * f[w, 1, 2]
    wz = f[w, 2, 3] + numbers[5] * f[w, 2, 2]
    ex = f[e, 0, 3] + numbers[6] * f[e, 0, 2] - f[2, 0, 3]
    ey = f[e, 1, 3] + numbers[6] * f[e, 1, 2] - f[2, 1, 3]
    ez = f[e, 2, 3] + numbers[6] * f[e, 2, 2] - f[2, 2, 3]
    wx, wy, wz = wx - numbers[13], wy - numbers[14], wz - numbers[15]
    ux, uy, uz = numbers[16], numbers[17], numbers[18]
    hx, hy, hz = f[1, 0, 2], f[1, 1, 2], f[1, 2, 2]
    s = (uy * wz - uz * wy) * hx + (uz * wx - ux * wz) * hy + (ux * wy - uy * wx) * hz
    ax, ay, az = f[2, 0, 3] - f[1, 0, 3], f[2, 1, 3] - f[1, 1, 3], f[2, 2, 3] - f[1, 2, 3]
    bend = (ay * ez - az * ey) * hx + (az * ex - ax * ez) * hy + (ax * ey - ay * ex) * hz
    product = (ax * ax + ay * ay + az * az) * (ex * ex + ey * ey + ez * ez)
    number = 0
    flags = 0
    if s * numbers[1] < 0.0:
        number = 1
    if abs(s) * scale < SINGULAR:
        flags |= SHOULDER
    number *= 2
    if bend * s < 0.0:
        number += 1
    if bend * bend < SINGULAR * SINGULAR * product:
        flags |= ELBOW
    if n == 6:
        gx = f[3, 1, 2] * f[4, 2, 2] - f[3, 2, 2] * f[4, 1, 2]
        gy = f[3, 2, 2] * f[4, 0, 2] - f[3, 0, 2] * f[4, 2, 2]
        gz = f[3, 0, 2] * f[4, 1, 2] - f[3, 1, 2] * f[4, 0, 2]
        bent = gx * f[5, 0, 2] + gy * f[5, 1, 2] + gz * f[5, 2, 2]
        number *= 2
        if bent * numbers[2] < 0.0:
            number += 1
        if abs(bent) < SINGULAR:
            flags |= WRIST
    return number, flags


@inlined
def signed_branch_of(q: Floats, numbers: Floats) -> tuple[int, int]:
    """Return the branch's number and singularities of an arm of seven axes, from joints 2, 4 and 6."""
    shoulder = math.sin(q[1] - numbers[0])
    elbow = math.sin(q[3] - numbers[1])
    wrist = math.sin(q[5] - numbers[2])
    number = (4 if shoulder < 0.0 else 0) + (2 if elbow < 0.0 else 0) + (1 if wrist < 0.0 else 0)
    flags = 0
    if abs(shoulder) < SINGULAR_OF_SEVEN:
        flags |= SHOULDER
    if abs(elbow) < SINGULAR_OF_SEVEN:
        flags |= ELBOW
    if abs(wrist) < SINGULAR_OF_SEVEN:
        flags |= WRIST
    return number, flags
