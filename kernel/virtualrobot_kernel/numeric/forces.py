"""Parts and robots under physics, once a tick: from an engine's arrays to the world's, and motors; compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64, int32
from virtualrobot_sdk.compiled.cache import array_of, compiled, output_of
from virtualrobot_sdk.compiled.rigid import multiply

OFF, EXERTS, HOLDS, SPRINGS, FOLLOWS = 0, 1, 2, 3, 4
"""Kinds of motors; the first four are the values of an engine's modes."""

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int32]]


@compiled(
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(int32, 2),
    array_of(int32, 2),
    array_of(int32, 2),
    array_of(int32, 2),
    array_of(int32, 2),
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(int32, 1),
    array_of(int32, 1),
    array_of(int32, 1),
    array_of(int32, 1),
    output_of(float64, 1),
    output_of(float64, 1),
)
def bring_robots(
    engine_q: Floats,
    engine_v: Floats,
    now: Floats,
    base_now: Integers,
    base_engine_q: Integers,
    base_engine_v: Integers,
    base_q: Integers,
    base_v: Integers,
    turns: Floats,
    quaternions: Floats,
    origins: Floats,
    joint_engine_q: Integers,
    joint_engine_v: Integers,
    joint_q: Integers,
    joint_v: Integers,
    q: Floats,
    v: Floats,
) -> float:
    """Write the coordinates q (n,) and velocities v (k,) of robots, in meters and radians, from an engine's state.

    Return the greatest of all velocities, whatever its sign.

    Args:
        engine_q: all coordinates of the engine: of free bodies x, y, z and a quaternion x, y, z, w in the world.
        engine_v: all velocities: of free bodies in the axes of the world, and about their own.
        now: (nq,) the world's coordinates, near which quaternions stay: one and its negative are one rotation.
        base_now: (b, 7) places of floating bases in `now`.
        base_engine_q: (b, 7) their places in engine_q.
        base_engine_v: (b, 6) their places in engine_v.
        base_q: (b, 7) their places in q.
        base_v: (b, 6) their places in v.
        turns: (b, 3, 3) rotation of their joints' frames in the world.
        quaternions: (b, 4) the inverse of that, as x, y, z, w.
        origins: (b, 3) origin of these frames in the world.
        joint_engine_q: (m,) places of joints that turn or slide in engine_q.
        joint_engine_v: (m,) in engine_v.
        joint_q: (m,) in q.
        joint_v: (m,) in v.
        q: (n,) the result, written in place.
        v: (k,) the result, written in place.

    Places are trusted, not checked.
    """
    for base in range(base_q.shape[0]):
        x = engine_q[base_engine_q[base, 0]] - origins[base, 0]
        y = engine_q[base_engine_q[base, 1]] - origins[base, 1]
        z = engine_q[base_engine_q[base, 2]] - origins[base, 2]
        vx = engine_v[base_engine_v[base, 0]]
        vy = engine_v[base_engine_v[base, 1]]
        vz = engine_v[base_engine_v[base, 2]]
        for axis in range(3):
            a = turns[base, 0, axis]
            b = turns[base, 1, axis]
            c = turns[base, 2, axis]
            q[base_q[base, axis]] = a * x + b * y + c * z
            v[base_v[base, axis]] = a * vx + b * vy + c * vz
            v[base_v[base, 3 + axis]] = engine_v[base_engine_v[base, 3 + axis]]
        ax = quaternions[base, 0]
        ay = quaternions[base, 1]
        az = quaternions[base, 2]
        aw = quaternions[base, 3]
        bx = engine_q[base_engine_q[base, 3]]
        by = engine_q[base_engine_q[base, 4]]
        bz = engine_q[base_engine_q[base, 5]]
        bw = engine_q[base_engine_q[base, 6]]
        # The product of both rotations: first the engine's, then the inverse of the frame's.
        qx = aw * bx + ax * bw + ay * bz - az * by
        qy = aw * by - ax * bz + ay * bw + az * bx
        qz = aw * bz + ax * by - ay * bx + az * bw
        qw = aw * bw - ax * bx - ay * by - az * bz
        near = (
            qx * now[base_now[base, 3]]
            + qy * now[base_now[base, 4]]
            + qz * now[base_now[base, 5]]
            + qw * now[base_now[base, 6]]
        )
        sign = -1.0 if near < 0.0 else 1.0
        q[base_q[base, 3]] = sign * qx
        q[base_q[base, 4]] = sign * qy
        q[base_q[base, 5]] = sign * qz
        q[base_q[base, 6]] = sign * qw
    for joint in range(joint_q.shape[0]):
        q[joint_q[joint]] = engine_q[joint_engine_q[joint]]
        v[joint_v[joint]] = engine_v[joint_engine_v[joint]]
    fastest = 0.0
    for place in range(v.shape[0]):
        fastest = max(fastest, abs(v[place]))
    return fastest


@compiled(array_of(float64, 1), array_of(int32, 1), array_of(float64, 1))
def are_at(values: Floats, places: Integers, expected: Floats) -> bool:
    """Return whether the values at some places (n,) are those that are expected (n,), to the bit."""
    for at in range(places.shape[0]):
        if values[places[at]] != expected[at]:
            return False
    return True


@compiled(
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(int32, 2),
    array_of(int32, 2),
    array_of(int32, 1),
    array_of(float64, 3),
    array_of(float64, 3),
    output_of(float64, 3),
    output_of(float64, 2),
    output_of(float64, 2),
    output_of(float64, 1),
)
def bring_parts(
    engine_q: Floats,
    engine_v: Floats,
    part_q: Integers,
    part_v: Integers,
    rows: Integers,
    parents: Floats,
    world_t_node: Floats,
    parent_t_part: Floats,
    twists: Floats,
    speeds: Floats,
    off: Floats,
) -> None:
    """Write where k free parts are, and how fast, from an engine's state, in meters and radians.

    Args:
        engine_q: all coordinates of the engine: of free bodies x, y, z and a quaternion x, y, z, w in the world.
        engine_v: all velocities: of free bodies in the axes of the world, and about their own.
        part_q: (k, 7) places of the parts in engine_q.
        part_v: (k, 6) places of the parts in engine_v.
        rows: (k,) rows of the parts in `world_t_node`.
        parents: (k, 4, 4) parent_t_world of what they hang on.
        world_t_node: (n, 4, 4) where all nodes are in the world as the tick begins.
        parent_t_part: (k, 4, 4) the result, written in place: their poses in what they hang on.
        twists: (k, 6) the result: their velocities.
        speeds: (k, 2) the result: the lengths of both halves of these.
        off: (k,) the result: by how much an entry of their poses in the world has changed at most.

    Places are trusted, not checked.
    """
    pose = np.zeros((1, 4, 4))
    pose[0, 3, 3] = 1.0
    for part in range(part_q.shape[0]):
        for axis in range(6):
            twists[part, axis] = engine_v[part_v[part, axis]]
        for half in range(2):
            a = twists[part, 3 * half]
            b = twists[part, 3 * half + 1]
            c = twists[part, 3 * half + 2]
            speeds[part, half] = math.sqrt(a * a + b * b + c * c)
        for axis in range(3):
            pose[0, axis, 3] = engine_q[part_q[part, axis]]
        x = engine_q[part_q[part, 3]]
        y = engine_q[part_q[part, 4]]
        z = engine_q[part_q[part, 5]]
        w = engine_q[part_q[part, 6]]
        pose[0, 0, 0] = 1.0 - 2.0 * (y * y + z * z)
        pose[0, 0, 1] = 2.0 * (x * y - z * w)
        pose[0, 0, 2] = 2.0 * (x * z + y * w)
        pose[0, 1, 0] = 2.0 * (x * y + z * w)
        pose[0, 1, 1] = 1.0 - 2.0 * (x * x + z * z)
        pose[0, 1, 2] = 2.0 * (y * z - x * w)
        pose[0, 2, 0] = 2.0 * (x * z - y * w)
        pose[0, 2, 1] = 2.0 * (y * z + x * w)
        pose[0, 2, 2] = 1.0 - 2.0 * (x * x + y * y)
        most = 0.0
        for row in range(3):
            for column in range(4):
                most = max(most, abs(pose[0, row, column] - world_t_node[rows[part], row, column]))
        off[part] = most
        multiply(parents, part, pose, 0, parent_t_part, part)


@compiled(
    array_of(int32, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(int32, 1),
    float64,
    float64,
    output_of(float64, 1),
)
def tell_motors(
    kinds: Integers,
    stiffness: Floats,
    damping: Floats,
    place: Floats,
    rate: Floats,
    now: Floats,
    joints: Integers,
    seconds: float,
    time_constant: float,
    target: Floats,
) -> None:
    """Write the targets (m,) of motors for a tick of some seconds; SI units.

    One that holds a velocity is told that; one that follows, the velocity by which it comes to the commanded place
    within the time constant; a spring, the place, ahead by what its damping holds back; one that exerts an effort, what
    stands in place of its place.

    Args:
        kinds: (m,) OFF, EXERTS, HOLDS, SPRINGS or FOLLOWS.
        stiffness: (m,) of springs.
        damping: (m,) of springs.
        place: (m,) commanded by the end of the tick, or the effort.
        rate: (m,) commanded velocity.
        now: (nq,) where all joints are as the tick begins.
        joints: (m,) places of these joints in `now`.
        seconds: length of the tick.
        time_constant: in which one that follows comes to its place.
        target: (m,) the result, written in place.
    """
    for motor in range(target.shape[0]):
        kind = kinds[motor]
        if kind == FOLLOWS:
            off = place[motor] - rate[motor] * seconds - now[joints[motor]]
            target[motor] = rate[motor] + off / time_constant
        elif kind == HOLDS:
            target[motor] = rate[motor]
        elif kind == SPRINGS:
            target[motor] = place[motor] + damping[motor] * rate[motor] / stiffness[motor]
        elif kind == EXERTS:
            target[motor] = place[motor]
        else:
            target[motor] = 0.0
