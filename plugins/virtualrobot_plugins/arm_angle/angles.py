"""All joint angles of a pose and an arm angle, and the arm angle of a posture; compiled.

M. Shimizu, H. Kakuya, W.-K. Yoon, K. Kitagaki, K. Kosuge, Analytical inverse kinematic computation for 7-DOF redundant
manipulators with joint limits and its application to redundancy resolution, IEEE Trans. Robotics 24(5), 2008; here with
an elbow that may lie beside the line of the upper arm, so that joint 4 follows from the law of cosines about its axis.

The arm angle turns the upper arm about the line from shoulder S to wrist W, by the right hand. It is 0 where joint 3
is at 0 and the elbow on the side of that line to which axis 1 points. Where the elbow is on the line, or W on axis 1,
that says nothing: then it is 0 where joint 3 is at 0 and the arm leads straight to W, or where joint 1 is at 0 too.
"""

from __future__ import annotations

import math

import numpy as np
from numba import float64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of
from virtualrobot_sdk.compiled.rigid import turn
from virtualrobot_sdk.kinematics import Floats

BRANCHES = 8
STRAIGHT = 1e-9
"""Below this sine (or part of the distance from S to W) an angle about a line tells nothing."""
STRETCHED = 2e-7
"""Below this sine of its bend the elbow counts as on the line: the distance from S to W tells no smaller bends."""
TOUCHED = 1e-10
"""A wrist this far (m) out of reach counts as reached: it is so by rounding."""


@inlined
def _dot(a: Floats, i: int, x: float, y: float, z: float) -> float:
    return a[i] * x + a[i + 1] * y + a[i + 2] * z


@inlined
def _turned(a: Floats, i: int, angle: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return (x, y, z) turned about the unit vector a[i : i + 3] (Rodrigues' formula)."""
    sine, cosine = math.sin(angle), math.cos(angle)
    rest = (1.0 - cosine) * _dot(a, i, x, y, z)
    return (
        x * cosine + (a[i + 1] * z - a[i + 2] * y) * sine + a[i] * rest,
        y * cosine + (a[i + 2] * x - a[i] * z) * sine + a[i + 1] * rest,
        z * cosine + (a[i] * y - a[i + 1] * x) * sine + a[i + 2] * rest,
    )


@inlined
def _plane(arm: Floats, i: int, x: float, y: float, z: float) -> tuple[float, float]:
    """Return the parts of a vector across axis i in the plane at a right angle to axis i + 1, and along axis i."""
    h, g = 3 * i, 3 * i + 3
    ex = arm[g + 1] * arm[h + 2] - arm[g + 2] * arm[h + 1]
    ey = arm[g + 2] * arm[h] - arm[g] * arm[h + 2]
    ez = arm[g] * arm[h + 1] - arm[g + 1] * arm[h]
    return ex * x + ey * y + ez * z, _dot(arm, h, x, y, z)


@inlined
def _bending(arm: Floats) -> tuple[float, float]:
    """Return a . b and a . (h_4 x b), with a from S to E and b from E to W at position 0.

    They are the factors of cos(q_4) and sin(q_4) in a . e_4 b, with which the distance from S to W grows.
    """
    ax, ay, az, bx, by, bz = arm[24], arm[25], arm[26], arm[27], arm[28], arm[29]
    odd = ax * (arm[10] * bz - arm[11] * by) + ay * (arm[11] * bx - arm[9] * bz) + az * (arm[9] * by - arm[10] * bx)
    return ax * bx + ay * by + az * bz, odd


@inlined
def _reference(arm: Floats, q4: float, wx: float, wy: float, wz: float) -> tuple[float, float]:
    """Return joints 1 and 2 that bring the wrist to S + w with joint 3 at 0, the elbow on the upper side."""
    vx, vy, vz = _turned(arm, 9, q4, arm[27], arm[28], arm[29])
    across, along = _plane(arm, 0, arm[24] + vx, arm[25] + vy, arm[26] + vz)
    wrist = math.atan2(across, along)
    across, along = _plane(arm, 0, arm[24], arm[25], arm[26])
    elbow = math.atan2(across, along)
    even, odd = _bending(arm)
    is_bent = abs(math.sin(q4 - math.atan2(odd, even))) > STRETCHED
    x, z = _plane(arm, 0, wx, wy, wz)
    y = _dot(arm, 3, wx, wy, wz)
    radius = math.sqrt(x * x + y * y)
    polar = math.atan2(radius, z)
    azimuth = 0.0
    if radius > STRAIGHT * (radius + abs(z)):
        azimuth = math.atan2(y, x)
    if is_bent and math.sin(elbow - wrist) > 0.0:
        return azimuth + math.pi, -polar - wrist
    return azimuth, polar - wrist


@inlined
def _three(arm: Floats, i: int, m: Floats, k: int, seed: Floats, q: Floats, column: int, second: bool) -> None:
    """Write joints i to i + 2 that turn as m[k] (4, 4), the one or the other of two ways, to a column of q."""
    h = 3 * i
    hx, hy, hz = arm[h + 6], arm[h + 7], arm[h + 8]
    dx = m[k, 0, 0] * hx + m[k, 0, 1] * hy + m[k, 0, 2] * hz
    dy = m[k, 1, 0] * hx + m[k, 1, 1] * hy + m[k, 1, 2] * hz
    dz = m[k, 2, 0] * hx + m[k, 2, 1] * hy + m[k, 2, 2] * hz
    x, z = _plane(arm, i, dx, dy, dz)
    y = _dot(arm, h + 3, dx, dy, dz)
    across, along = _plane(arm, i, hx, hy, hz)
    straight = math.atan2(across, along)
    radius = math.sqrt(x * x + y * y)
    polar = math.atan2(radius, z)
    if second:
        first, middle = math.atan2(-y, -x), -polar - straight
    else:
        first, middle = math.atan2(y, x), polar - straight
    if radius < STRAIGHT:
        # Joints i and i + 2 turn about one line: the former stays, the latter does it all.
        first = seed[i]
    gx, gy, gz = arm[h + 3], arm[h + 4], arm[h + 5]
    rx = m[k, 0, 0] * gx + m[k, 0, 1] * gy + m[k, 0, 2] * gz
    ry = m[k, 1, 0] * gx + m[k, 1, 1] * gy + m[k, 1, 2] * gz
    rz = m[k, 2, 0] * gx + m[k, 2, 1] * gy + m[k, 2, 2] * gz
    rx, ry, rz = _turned(arm, h, -first, rx, ry, rz)
    rx, ry, rz = _turned(arm, h + 3, -middle, rx, ry, rz)
    cross = (hy * gz - hz * gy) * rx + (hz * gx - hx * gz) * ry + (hx * gy - hy * gx) * rz
    q[i, column] = first
    q[i + 1, column] = middle
    q[i + 2, column] = math.atan2(cross, gx * rx + gy * ry + gz * rz)


@inlined
def _identity(m: Floats, k: int) -> None:
    for row in range(3):
        for column in range(3):
            m[k, row, column] = 1.0 if row == column else 0.0


@compiled(
    array_of(float64, 1),
    array_of(float64, 2),
    float64,
    array_of(float64, 1),
    output_of(float64, 3),
    output_of(float64, 2),
)
def _solve(arm: Floats, target: Floats, arm_angle: float, seed: Floats, turned: Floats, q: Floats) -> float:
    """Write the angles (7, 8) and the turns of upper arm and forearm (4, 4, 4); return how far W is out of reach."""
    cx, cy, cz = arm[30], arm[31], arm[32]
    wx = target[0, 3] + target[0, 0] * cx + target[0, 1] * cy + target[0, 2] * cz - arm[21]
    wy = target[1, 3] + target[1, 0] * cx + target[1, 1] * cy + target[1, 2] * cz - arm[22]
    wz = target[2, 3] + target[2, 0] * cx + target[2, 1] * cy + target[2, 2] * cz - arm[23]
    distance = math.sqrt(wx * wx + wy * wy + wz * wz)
    squares = _dot(arm, 24, arm[24], arm[25], arm[26]) + _dot(arm, 27, arm[27], arm[28], arm[29])
    even, odd = _bending(arm)
    longest = math.sqrt(even * even + odd * odd)
    cosine = (distance * distance - squares) / (2.0 * longest)
    if abs(cosine) > 1.0:
        nearest = math.sqrt(max(squares + math.copysign(2.0 * longest, cosine), 0.0))
        if abs(distance - nearest) > TOUCHED:
            return abs(distance - nearest)
        cosine = math.copysign(1.0, cosine)
    bend = math.acos(cosine)
    if math.sin(bend) < STRETCHED:
        bend = 0.0 if cosine > 0.0 else math.pi
    if distance > STRAIGHT:
        wx, wy, wz = wx / distance, wy / distance, wz / distance
    for side in range(2):
        q4 = math.atan2(odd, even) + (bend if side == 0 else -bend)
        first, second = _reference(arm, q4, wx, wy, wz)
        upper, fore = 2 * side, 2 * side + 1
        _identity(turned, upper)
        turn(turned, upper, wx, wy, wz, arm_angle)
        turn(turned, upper, arm[0], arm[1], arm[2], first)
        turn(turned, upper, arm[3], arm[4], arm[5], second)
        # What the wrist has to turn: (M e_4)^T R, with R = target R_0^T.
        for row in range(3):
            for column in range(3):
                turned[fore, row, column] = turned[upper, row, column]
        turn(turned, fore, arm[9], arm[10], arm[11], q4)
        m = np.empty((3, 3))
        for row in range(3):
            for column in range(3):
                value = 0.0
                for i in range(3):
                    other = 0.0
                    for j in range(3):
                        other += target[i, j] * arm[33 + 3 * j + column]
                    value += turned[fore, i, row] * other
                m[row, column] = value
        for row in range(3):
            for column in range(3):
                turned[fore, row, column] = m[row, column]
        for branch in range(4):
            column = 4 * side + branch
            _three(arm, 0, turned, upper, seed, q, column, branch >= 2)
            q[3, column] = q4
            _three(arm, 4, turned, fore, seed, q, column, branch % 2 == 1)
    return 0.0


@compiled(array_of(float64, 1), array_of(float64, 1), output_of(float64, 3))
def _arm_angle(arm: Floats, q: Floats, turned: Floats) -> float:
    """Return the arm angle of a posture (7,); `turned` (1, 4, 4) is work space."""
    _identity(turned, 0)
    for i in range(3):
        turn(turned, 0, arm[3 * i], arm[3 * i + 1], arm[3 * i + 2], q[i])
    vx, vy, vz = _turned(arm, 9, q[3], arm[27], arm[28], arm[29])
    vx, vy, vz = vx + arm[24], vy + arm[25], vz + arm[26]
    wx = turned[0, 0, 0] * vx + turned[0, 0, 1] * vy + turned[0, 0, 2] * vz
    wy = turned[0, 1, 0] * vx + turned[0, 1, 1] * vy + turned[0, 1, 2] * vz
    wz = turned[0, 2, 0] * vx + turned[0, 2, 1] * vy + turned[0, 2, 2] * vz
    distance = math.sqrt(wx * wx + wy * wy + wz * wz)
    if distance > STRAIGHT:
        wx, wy, wz = wx / distance, wy / distance, wz / distance
    first, _ = _reference(arm, q[3], wx, wy, wz)
    # Axis 2 is at a right angle to w in the reference, and turned about w by the arm angle in the posture.
    gx, gy, gz = arm[3], arm[4], arm[5]
    rx = turned[0, 0, 0] * gx + turned[0, 0, 1] * gy + turned[0, 0, 2] * gz
    ry = turned[0, 1, 0] * gx + turned[0, 1, 1] * gy + turned[0, 1, 2] * gz
    rz = turned[0, 2, 0] * gx + turned[0, 2, 1] * gy + turned[0, 2, 2] * gz
    ux, uy, uz = _turned(arm, 0, first, gx, gy, gz)
    sine = (wy * uz - wz * uy) * rx + (wz * ux - wx * uz) * ry + (wx * uy - wy * ux) * rz
    return math.atan2(sine, ux * rx + uy * ry + uz * rz)


def all_branches(arm: Floats, target: Floats, arm_angle: float, seed: Floats) -> tuple[Floats, Floats, float]:
    """Return the angles (7, 8) of a pose (4, 4) at an arm angle (rad), and how far the wrist is out of reach (m).

    Also how upper arm and forearm turn (4, 4, 4): for both bends of the elbow the turn of joints 1 to 3 and of joints 5
    to 7, in the upper left (3, 3). Where joints 1 and 3, or 5 and 7, turn about one line, 1 or 5 is as in the seed
    (7,). Nothing is written where the wrist is out of reach.
    """
    turned, q = np.empty((4, 4, 4)), np.empty((7, BRANCHES))
    return q, turned, _solve(arm, target, arm_angle, seed, turned, q)


def arm_angle_of(arm: Floats, q: Floats) -> float:
    """Return the arm angle of a posture (7,) in -pi .. pi."""
    return _arm_angle(arm, q, np.empty((1, 4, 4)))
