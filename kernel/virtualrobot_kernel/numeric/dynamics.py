"""Inverse dynamics of a tree of rigid bodies on a standing base: the recursive Newton-Euler algorithm, compiled.

Body 0 is the base; every other body hangs by one joint on a body before it. A body's mass is told by its mass, its
first moment (mass times centre of mass) and its inertia about the origin of its frame, which are sums over whatever is
fixed to the body.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float64, int8, int32
from virtualrobot_sdk.compiled.cache import array_of, compiled, output_of
from virtualrobot_sdk.compiled.rigid import copy, shift, turn

from virtualrobot_kernel.numeric.forest import REVOLUTE

Integers = np.ndarray[Any, np.dtype[np.int32]]
Codes = np.ndarray[Any, np.dtype[np.int8]]
Floats = np.ndarray[Any, np.dtype[np.float64]]


@compiled(
    array_of(int32, 1),
    array_of(int8, 1),
    array_of(float64, 2),
    array_of(int32, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 3),
    array_of(float64, 1),
    array_of(float64, 2),
    array_of(float64, 3),
    array_of(float64, 1),
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(float64, 2),
    output_of(float64, 2),
    output_of(float64, 2),
)
def inverse_dynamics(
    parent: Integers,
    joint_type: Codes,
    axis: Floats,
    joint_index: Integers,
    multiplier: Floats,
    offset: Floats,
    parent_t_body: Floats,
    mass: Floats,
    moment: Floats,
    inertia: Floats,
    gravity: Floats,
    q: Floats,
    v: Floats,
    a: Floats,
    effort: Floats,
    wrench: Floats,
) -> None:
    """Write the efforts that move a tree as told, and the wrench that holds its base, for n samples of k joints.

    J. Luh, M. Walker and R. Paul, On-line computational scheme for mechanical manipulators, J. Dyn. Sys., Meas.,
    Control 102, 1980 (B. Siciliano et al., Robotics, 2009, section 7.5; the same recursion in spatial vectors:
    R. Featherstone, Rigid Body Dynamics Algorithms, 2008, table 5.1). Motion goes outward from the base, which
    accelerates by -gravity so that no body needs its weight; force comes inward. Everything is told in each body's own
    frame and about its origin.

    Args:
        parent: (b,) each body's parent, a smaller number; that of body 0 is not read.
        joint_type: (b,) REVOLUTE or PRISMATIC; that of body 0 is not read.
        axis: (b, 3) unit axis in the joint's own frame.
        joint_index: (b,) which of the k joints moves the body; bodies that follow a joint have its index too.
        multiplier: (b,) factor on the joint's position, velocity, acceleration and effort; 1 except for a mimic joint.
        offset: (b,) added to the position; 0 except for a mimic joint.
        parent_t_body: (b, 4, 4) pose of the joint's frame in its parent's at zero.
        mass: (b,) kg.
        moment: (b, 3) mass times centre of mass, kg m.
        inertia: (b, 3, 3) about the origin of the body's frame, kg m^2.
        gravity: (3,) m/s^2 in the frame of body 0.
        q: (n, k) positions, radians or meters.
        v: (n, k) velocities.
        a: (n, k) accelerations.
        effort: (n, k) the result: N m for turning joints, N for sliding ones.
        wrench: (n, 6) the result: force (N) and moment about the origin (N m) that hold body 0, in its frame.

    Indices are trusted, not checked.
    """
    bodies = parent.shape[0]
    pose = np.empty((bodies, 4, 4))  # body in parent
    w = np.empty((bodies, 3))  # angular velocity
    dw = np.empty((bodies, 3))  # angular acceleration
    dv = np.empty((bodies, 3))  # acceleration of the origin, less gravity
    f = np.empty((bodies, 3))
    m = np.empty((bodies, 3))
    for x in range(3):
        w[0, x] = 0.0
        dw[0, x] = 0.0
        dv[0, x] = -gravity[x]
    for sample in range(q.shape[0]):
        for body in range(bodies):
            if body > 0:
                above = parent[body]
                joint = joint_index[body]
                factor = multiplier[body]
                position = factor * q[sample, joint] + offset[body]
                speed = factor * v[sample, joint]
                slope = factor * a[sample, joint]
                sx = axis[body, 0]
                sy = axis[body, 1]
                sz = axis[body, 2]
                copy(parent_t_body, body, pose, body)
                turning = joint_type[body] == REVOLUTE
                if turning:
                    turn(pose, body, sx, sy, sz, position)
                else:
                    shift(pose, body, sx * position, sy * position, sz * position)
                wx = w[above, 0]
                wy = w[above, 1]
                wz = w[above, 2]
                dx = dw[above, 0]
                dy = dw[above, 1]
                dz = dw[above, 2]
                px = pose[body, 0, 3]
                py = pose[body, 1, 3]
                pz = pose[body, 2, 3]
                # w x p, then dv + dw x p + w x (w x p)
                cx = wy * pz - wz * py
                cy = wz * px - wx * pz
                cz = wx * py - wy * px
                ax = dv[above, 0] + dy * pz - dz * py + wy * cz - wz * cy
                ay = dv[above, 1] + dz * px - dx * pz + wz * cx - wx * cz
                az = dv[above, 2] + dx * py - dy * px + wx * cy - wy * cx
                for x in range(3):
                    r0 = pose[body, 0, x]
                    r1 = pose[body, 1, x]
                    r2 = pose[body, 2, x]
                    w[body, x] = r0 * wx + r1 * wy + r2 * wz
                    dw[body, x] = r0 * dx + r1 * dy + r2 * dz
                    dv[body, x] = r0 * ax + r1 * ay + r2 * az
                # w x (axis * speed), w still without the joint's own turn
                cx = (w[body, 1] * sz - w[body, 2] * sy) * speed
                cy = (w[body, 2] * sx - w[body, 0] * sz) * speed
                cz = (w[body, 0] * sy - w[body, 1] * sx) * speed
                if turning:
                    dw[body, 0] += sx * slope + cx
                    dw[body, 1] += sy * slope + cy
                    dw[body, 2] += sz * slope + cz
                    w[body, 0] += sx * speed
                    w[body, 1] += sy * speed
                    w[body, 2] += sz * speed
                else:
                    dv[body, 0] += sx * slope + 2.0 * cx
                    dv[body, 1] += sy * slope + 2.0 * cy
                    dv[body, 2] += sz * slope + 2.0 * cz
            wx = w[body, 0]
            wy = w[body, 1]
            wz = w[body, 2]
            dx = dw[body, 0]
            dy = dw[body, 1]
            dz = dw[body, 2]
            ax = dv[body, 0]
            ay = dv[body, 1]
            az = dv[body, 2]
            hx = moment[body, 0]
            hy = moment[body, 1]
            hz = moment[body, 2]
            # f = mass dv + dw x h + w x (w x h)
            cx = wy * hz - wz * hy
            cy = wz * hx - wx * hz
            cz = wx * hy - wy * hx
            f[body, 0] = mass[body] * ax + dy * hz - dz * hy + wy * cz - wz * cy
            f[body, 1] = mass[body] * ay + dz * hx - dx * hz + wz * cx - wx * cz
            f[body, 2] = mass[body] * az + dx * hy - dy * hx + wx * cy - wy * cx
            # m = inertia dw + w x (inertia w) + h x dv
            ix = inertia[body, 0, 0] * wx + inertia[body, 0, 1] * wy + inertia[body, 0, 2] * wz
            iy = inertia[body, 1, 0] * wx + inertia[body, 1, 1] * wy + inertia[body, 1, 2] * wz
            iz = inertia[body, 2, 0] * wx + inertia[body, 2, 1] * wy + inertia[body, 2, 2] * wz
            mx = inertia[body, 0, 0] * dx + inertia[body, 0, 1] * dy + inertia[body, 0, 2] * dz
            my = inertia[body, 1, 0] * dx + inertia[body, 1, 1] * dy + inertia[body, 1, 2] * dz
            mz = inertia[body, 2, 0] * dx + inertia[body, 2, 1] * dy + inertia[body, 2, 2] * dz
            m[body, 0] = mx + wy * iz - wz * iy + hy * az - hz * ay
            m[body, 1] = my + wz * ix - wx * iz + hz * ax - hx * az
            m[body, 2] = mz + wx * iy - wy * ix + hx * ay - hy * ax
        for joint in range(effort.shape[1]):
            effort[sample, joint] = 0.0
        for body in range(bodies - 1, 0, -1):
            along = f if joint_type[body] != REVOLUTE else m
            sum_along = axis[body, 0] * along[body, 0] + axis[body, 1] * along[body, 1] + axis[body, 2] * along[body, 2]
            effort[sample, joint_index[body]] += multiplier[body] * sum_along
            above = parent[body]
            fx = pose[body, 0, 0] * f[body, 0] + pose[body, 0, 1] * f[body, 1] + pose[body, 0, 2] * f[body, 2]
            fy = pose[body, 1, 0] * f[body, 0] + pose[body, 1, 1] * f[body, 1] + pose[body, 1, 2] * f[body, 2]
            fz = pose[body, 2, 0] * f[body, 0] + pose[body, 2, 1] * f[body, 1] + pose[body, 2, 2] * f[body, 2]
            f[above, 0] += fx
            f[above, 1] += fy
            f[above, 2] += fz
            px = pose[body, 0, 3]
            py = pose[body, 1, 3]
            pz = pose[body, 2, 3]
            turned = pose[body, 0, 0] * m[body, 0] + pose[body, 0, 1] * m[body, 1] + pose[body, 0, 2] * m[body, 2]
            m[above, 0] += turned + py * fz - pz * fy
            turned = pose[body, 1, 0] * m[body, 0] + pose[body, 1, 1] * m[body, 1] + pose[body, 1, 2] * m[body, 2]
            m[above, 1] += turned + pz * fx - px * fz
            turned = pose[body, 2, 0] * m[body, 0] + pose[body, 2, 1] * m[body, 1] + pose[body, 2, 2] * m[body, 2]
            m[above, 2] += turned + px * fy - py * fx
        for x in range(3):
            wrench[sample, x] = f[0, x]
            wrench[sample, 3 + x] = m[0, x]
