"""The equations of motion of a vehicle under water, compiled: one step by one of three integrators.

T. I. Fossen, Guidance and Control of Ocean Vehicles (Wiley, 1994), chapter 2: M v' + C(v) v + D(v) v + g = tau, where v
is the velocity against the water, which flows evenly. C(v) v is written by Kirchhoff's equations, so that it needs the
mass matrix alone and takes no power. Axes of the base are x forward, y left, z up, those of the world z up.

What a vehicle carries, such as an arm, adds its mass matrix to M and the momentum of its own movement to M v. Both
change during a step, so that rows of arrays are those of its start, its middle and its end.

All is reckoned from the pose at the start of the step: where the vehicle is then is the origin, its axes are the axes,
and the water rests. Quaternions are w, x, y, z here.
"""

from __future__ import annotations

import math

import numpy as np
from numba import float64, int32, int64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of
from virtualrobot_sdk.kinematics import Floats, Integers

EULER, RK4, LIE = 0, 1, 2
"""Integrators: Euler's method; Runge and Kutta's of order 4; a midpoint step on the group of motions of order 2, which
keeps the momentum of a body without outer forces (the momentum is carried, not the velocity)."""


@inlined
def _turned(q: Floats, x: float, y: float, z: float, out: Floats, at: int) -> None:
    """Write the vector (x, y, z), turned by q, to out[at:at + 3]."""
    tx = 2.0 * (q[2] * z - q[3] * y)
    ty = 2.0 * (q[3] * x - q[1] * z)
    tz = 2.0 * (q[1] * y - q[2] * x)
    out[at] = x + q[0] * tx + q[2] * tz - q[3] * ty
    out[at + 1] = y + q[0] * ty + q[3] * tx - q[1] * tz
    out[at + 2] = z + q[0] * tz + q[1] * ty - q[2] * tx


@inlined
def _turned_back(q: Floats, x: float, y: float, z: float, out: Floats, at: int) -> None:
    """Write the vector (x, y, z), turned by the inverse of q, to out[at:at + 3]."""
    tx = 2.0 * (q[3] * y - q[2] * z)
    ty = 2.0 * (q[1] * z - q[3] * x)
    tz = 2.0 * (q[2] * x - q[1] * y)
    out[at] = x + q[0] * tx - q[2] * tz + q[3] * ty
    out[at + 1] = y + q[0] * ty - q[3] * tx + q[1] * tz
    out[at + 2] = z + q[0] * tz - q[1] * ty + q[2] * tx


@inlined
def _looked_up(tables: Floats, start: int, end: int, x: float) -> float:
    """Return the value at x of the table in columns start to end: straight between entries, level beyond."""
    if x <= tables[0, start]:
        return tables[1, start]
    if x >= tables[0, end - 1]:
        return tables[1, end - 1]
    low = start
    high = end - 1
    while high - low > 1:
        middle = (low + high) // 2
        if tables[0, middle] <= x:
            low = middle
        else:
            high = middle
    slope = (tables[1, high] - tables[1, low]) / (tables[0, high] - tables[0, low])
    return tables[1, low] + slope * (x - tables[0, low])


@inlined
def _driven(
    v: Floats,
    state: Floats,
    density: float,
    is_fin: Integers,
    drive: Floats,
    start: Integers,
    tables: Floats,
    f: Floats,
) -> None:
    """Add forces and moments (6,) of all drives, in their states, to f, at the velocity v against the water."""
    for j in range(state.shape[0]):
        dx, dy, dz = drive[j, 0], drive[j, 1], drive[j, 2]
        rx, ry, rz = drive[j, 3], drive[j, 4], drive[j, 5]
        # The water comes to the drive as it moves, turning included.
        vx = v[0] + v[4] * rz - v[5] * ry
        vy = v[1] + v[5] * rx - v[3] * rz
        vz = v[2] + v[3] * ry - v[4] * rx
        value = _looked_up(tables, start[2 * j], start[2 * j + 1], state[j])
        if is_fin[j]:
            across = vx * vx + (dy * vy + dz * vz) ** 2
            lift = 0.5 * density * drive[j, 8] * value * across
            # The force is at right angles to the fin, so that a part of it is drag.
            fx = -abs(lift * state[j])
            fy = lift * dy
            fz = lift * dz
            about = 0.0
        else:
            if drive[j, 9] > 0.0 and value > 0.0 and state[j] > 0.0:
                speed = drive[j, 10] * (dx * vx + dy * vy + dz * vz)
                ratio = speed / (state[j] / (2.0 * math.pi) * drive[j, 9])
                value *= _looked_up(tables, start[2 * j + 1], start[2 * j + 2], ratio)
            fx = value * dx
            fy = value * dy
            fz = value * dz
            about = value * drive[j, 7]
        f[0] += fx
        f[1] += fy
        f[2] += fz
        f[3] += ry * fz - rz * fy + about * dx
        f[4] += rz * fx - rx * fz + about * dy
        f[5] += rx * fy - ry * fx + about * dz


@inlined
def _forces(
    q: Floats,
    way: Floats,
    v: Floats,
    state: Floats,
    up: Floats,
    height: float,
    water: Floats,
    damping: Floats,
    hull: Floats,
    wet: Floats,
    is_fin: Integers,
    drive: Floats,
    start: Integers,
    tables: Floats,
    here: Floats,
    f: Floats,
) -> None:
    """Write tau - D(v) v - g (6,) to f: all but the inertial forces, along the axes of the body.

    `wet` (4,) is the mass of what it carries, and its first moment, less that of the water in its place.

    `up` is the vertical in the axes at the start, `height` that of the start, which has gone with the water by now.
    """
    surge = abs(v[0])
    for i in range(6):
        against = 0.0
        for j in range(6):
            against += (damping[0, i, j] + damping[1, i, j] * abs(v[j]) + damping[2, i, j] * surge) * v[j]
        f[i] = -against
    _turned_back(q, up[0], up[1], up[2], here, 0)
    risen = height + up[0] * way[0] + up[1] * way[1] + up[2] * way[2]
    risen += here[0] * hull[5] + here[1] * hull[6] + here[2] * hull[7]
    immersed = min(1.0, max(0.0, 0.5 + (water[4] - risen) / hull[8]))
    weight = hull[0] * water[5]
    buoyancy = water[3] * hull[1] * water[5] * immersed
    mx = buoyancy * hull[5] - weight * hull[2] - water[5] * wet[1]
    my = buoyancy * hull[6] - weight * hull[3] - water[5] * wet[2]
    mz = buoyancy * hull[7] - weight * hull[4] - water[5] * wet[3]
    weight += water[5] * wet[0]
    for i in range(3):
        f[i] += (buoyancy - weight) * here[i]
    f[3] += my * here[2] - mz * here[1]
    f[4] += mz * here[0] - mx * here[2]
    f[5] += mx * here[1] - my * here[0]
    _driven(v, state, water[3], is_fin, drive, start, tables, f)


@inlined
def _accelerated(
    mass: Floats,
    inverse: Floats,
    carried: Floats,
    change: Floats,
    v: Floats,
    f: Floats,
    h: Floats,
    out: Floats,
    at: int,
) -> None:
    """Write M^-1 (f - C(v) v) to out[at:at + 6], with what is carried.

    `carried` (6,) is the momentum of its own movement; `change` (6, 7) are the rates of its mass matrix and of that.
    """
    for i in range(6):
        h[i] = carried[i]
        for j in range(6):
            h[i] += mass[i, j] * v[j]
    g0 = f[0] + h[1] * v[5] - h[2] * v[4]
    g1 = f[1] + h[2] * v[3] - h[0] * v[5]
    g2 = f[2] + h[0] * v[4] - h[1] * v[3]
    g3 = f[3] + h[4] * v[5] - h[5] * v[4] + h[1] * v[2] - h[2] * v[1]
    g4 = f[4] + h[5] * v[3] - h[3] * v[5] + h[2] * v[0] - h[0] * v[2]
    g5 = f[5] + h[3] * v[4] - h[4] * v[3] + h[0] * v[1] - h[1] * v[0]
    for j in range(6):
        g0 -= change[0, j] * v[j]
        g1 -= change[1, j] * v[j]
        g2 -= change[2, j] * v[j]
        g3 -= change[3, j] * v[j]
        g4 -= change[4, j] * v[j]
        g5 -= change[5, j] * v[j]
    g0 -= change[0, 6]
    g1 -= change[1, 6]
    g2 -= change[2, 6]
    g3 -= change[3, 6]
    g4 -= change[4, 6]
    g5 -= change[5, 6]
    for i in range(6):
        out[at + i] = (
            inverse[i, 0] * g0
            + inverse[i, 1] * g1
            + inverse[i, 2] * g2
            + inverse[i, 3] * g3
            + inverse[i, 4] * g4
            + inverse[i, 5] * g5
        )


@inlined
def _exponential(x: float, y: float, z: float, q: Floats) -> None:
    """Write the rotation by the vector (x, y, z) to q."""
    half = 0.5 * math.sqrt(x * x + y * y + z * z)
    scale = 0.5 * (1.0 - half * half / 6.0) if half < 1e-4 else 0.5 * math.sin(half) / half
    q[0] = math.cos(half)
    q[1] = x * scale
    q[2] = y * scale
    q[3] = z * scale


@compiled(
    int64,
    output_of(float64, 2),
    output_of(float64, 1),
    output_of(float64, 1),
    array_of(float64, 1),
    float64,
    int64,
    array_of(float64, 1),
    array_of(float64, 3),
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(float64, 3),
    array_of(float64, 1),
    array_of(int32, 1),
    array_of(float64, 2),
    array_of(int32, 1),
    array_of(float64, 2),
)
def advance(
    method: int,
    pose: Floats,
    twist: Floats,
    state: Floats,
    commands: Floats,
    seconds: float,
    steps: int,
    water: Floats,
    mass: Floats,
    inverse: Floats,
    carried: Floats,
    change: Floats,
    damping: Floats,
    hull: Floats,
    is_fin: Integers,
    drive: Floats,
    start: Integers,
    tables: Floats,
) -> None:
    """Advance pose (4, 4), twist (6,) and states of drives (m,) in place by `seconds` in equal steps.

    `water` (6,) is the current (3, m/s), density (kg/m^3), height of the surface (m) and gravity (m/s^2). `mass` and
    `inverse` (r, 6, 6) are those of all that moves, `carried` (r, 10) the momentum by its own movement of what is
    carried, and its `wet` of `_forces`; `change` (6, 7) says how that mass matrix and that momentum change (1/s). r is
    1 where nothing changes, else twice the steps and 1. The rest is what `Parameters` says. Drives are evaluated where
    a step starts, at its middle and at its end: were they held, the method would be of order 1.
    """
    dt = seconds / steps
    m = state.shape[0]
    middle = np.empty(m)
    end = np.empty(m)
    f = np.empty(6)
    h = np.empty(6)
    here = np.empty(3)
    up = np.empty(3)
    v = np.empty(6)
    # Of the step so far: way through the water (3), quaternion (4), velocity against the water (6), and rates of these.
    y = np.empty(13)
    stage = np.empty(13)
    rates = np.empty((4, 13))
    momentum = np.empty(6)
    q = np.empty(4)
    for step in range(steps):
        first = 0 if mass.shape[0] == 1 else 2 * step
        ahead = 0 if mass.shape[0] == 1 else 1
        for i in range(3):
            up[i] = pose[2, i]
            along = pose[0, i] * water[0] + pose[1, i] * water[1] + pose[2, i] * water[2]
            v[i] = twist[i] - along
            v[3 + i] = twist[3 + i]
        for j in range(m):
            decay = math.exp(-0.5 * dt / drive[j, 6]) if drive[j, 6] > 0.0 else 0.0
            middle[j] = commands[j] + (state[j] - commands[j]) * decay
            end[j] = commands[j] + (middle[j] - commands[j]) * decay
        for i in range(13):
            y[i] = 0.0
        y[3] = 1.0
        for i in range(6):
            y[7 + i] = v[i]
        if method == LIE:
            for i in range(6):
                momentum[i] = carried[first, i]
                for j in range(6):
                    momentum[i] += mass[first, i, j] * v[j]
            # The velocity at the middle by fixed-point steps, each of which takes a factor of dt off the error.
            for i in range(13):
                stage[i] = y[i]
            for round_ in range(4):
                _exponential(0.5 * dt * stage[10], 0.5 * dt * stage[11], 0.5 * dt * stage[12], q)
                for i in range(4):
                    stage[3 + i] = q[i]
                _turned(q, stage[7], stage[8], stage[9], here, 0)
                for i in range(3):
                    stage[i] = 0.5 * dt * here[i]
                _forces(
                    q,
                    stage[:3],
                    stage[7:13],
                    middle,
                    up,
                    pose[2, 3] + 0.5 * dt * water[2],
                    water,
                    damping,
                    hull,
                    carried[first + ahead, 6:10],
                    is_fin,
                    drive,
                    start,
                    tables,
                    here,
                    f,
                )
                if round_ < 3:
                    row = first + ahead
                    _accelerated(mass[row], inverse[row], carried[row], change, stage[7:13], f, h, rates[0], 7)
                    for i in range(7, 13):
                        stage[i] = y[i] + 0.5 * dt * rates[0, i]
            # Momentum about the place at the start, to which the force at the middle adds; half of the way is its arm.
            _turned(q, f[0], f[1], f[2], h, 0)
            _turned(q, f[3], f[4], f[5], h, 3)
            for i in range(3):
                momentum[i] += dt * h[i]
            wx, wy, wz = stage[0], stage[1], stage[2]
            momentum[3] += dt * (h[3] + wy * h[2] - wz * h[1])
            momentum[4] += dt * (h[4] + wz * h[0] - wx * h[2])
            momentum[5] += dt * (h[5] + wx * h[1] - wy * h[0])
            # About the place at the end, along the axes at the end.
            momentum[3] -= 2.0 * (wy * momentum[2] - wz * momentum[1])
            momentum[4] -= 2.0 * (wz * momentum[0] - wx * momentum[2])
            momentum[5] -= 2.0 * (wx * momentum[1] - wy * momentum[0])
            _exponential(dt * stage[10], dt * stage[11], dt * stage[12], q)
            _turned_back(q, momentum[0], momentum[1], momentum[2], h, 0)
            _turned_back(q, momentum[3], momentum[4], momentum[5], h, 3)
            for i in range(3):
                y[i] = 2.0 * stage[i]
            for i in range(4):
                y[3 + i] = q[i]
            for i in range(6):
                y[7 + i] = 0.0
                for j in range(6):
                    y[7 + i] += inverse[first + 2 * ahead, i, j] * (h[j] - carried[first + 2 * ahead, j])
        else:
            last = 1 if method == EULER else 4
            for k in range(last):
                part = 0.0 if k == 0 else (dt if k == 3 else 0.5 * dt)
                row = first if k == 0 else (first + 2 * ahead if k == 3 else first + ahead)
                for i in range(13):
                    stage[i] = y[i] if k == 0 else y[i] + part * rates[k - 1, i]
                _forces(
                    stage[3:7],
                    stage[:3],
                    stage[7:13],
                    state if k == 0 else (end if k == 3 else middle),
                    up,
                    pose[2, 3] + part * water[2],
                    water,
                    damping,
                    hull,
                    carried[row, 6:10],
                    is_fin,
                    drive,
                    start,
                    tables,
                    here,
                    f,
                )
                _accelerated(mass[row], inverse[row], carried[row], change, stage[7:13], f, h, rates[k], 7)
                _turned(stage[3:7], stage[7], stage[8], stage[9], rates[k], 0)
                w, x, b, z = stage[3], stage[4], stage[5], stage[6]
                p, r, s = stage[10], stage[11], stage[12]
                rates[k, 3] = 0.5 * (-x * p - b * r - z * s)
                rates[k, 4] = 0.5 * (w * p + b * s - z * r)
                rates[k, 5] = 0.5 * (w * r + z * p - x * s)
                rates[k, 6] = 0.5 * (w * s + x * r - b * p)
            for i in range(13):
                if last == 1:
                    y[i] += dt * rates[0, i]
                else:
                    y[i] += dt / 6.0 * (rates[0, i] + 2.0 * rates[1, i] + 2.0 * rates[2, i] + rates[3, i])
        length = math.sqrt(y[3] ** 2 + y[4] ** 2 + y[5] ** 2 + y[6] ** 2)
        w, x, b, z = y[3] / length, y[4] / length, y[5] / length, y[6] / length
        for i in range(3):
            pose[i, 3] += pose[i, 0] * y[0] + pose[i, 1] * y[1] + pose[i, 2] * y[2] + dt * water[i]
            c0, c1, c2 = pose[i, 0], pose[i, 1], pose[i, 2]
            pose[i, 0] = c0 * (1 - 2 * (b * b + z * z)) + c1 * 2 * (x * b + z * w) + c2 * 2 * (x * z - b * w)
            pose[i, 1] = c0 * 2 * (x * b - z * w) + c1 * (1 - 2 * (x * x + z * z)) + c2 * 2 * (b * z + x * w)
            pose[i, 2] = c0 * 2 * (x * z + b * w) + c1 * 2 * (b * z - x * w) + c2 * (1 - 2 * (x * x + b * b))
        for i in range(3):
            along = pose[0, i] * water[0] + pose[1, i] * water[1] + pose[2, i] * water[2]
            twist[i] = y[7 + i] + along
            twist[3 + i] = y[10 + i]
        for j in range(m):
            state[j] = end[j]
