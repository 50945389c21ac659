"""The places of a scene's instances, kept up to date by compiled code without the GIL."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import boolean, float32, float64, uint64

from virtualrobot_sdk.compiled.cache import array_of, compiled, output_of
from virtualrobot_sdk.embree.foreign import call
from virtualrobot_sdk.embree.library import FLOAT3X4

Array = np.ndarray[Any, np.dtype[Any]]


@compiled(
    *(uint64, uint64, array_of(uint64, 1), array_of(boolean, 1), array_of(float64, 3)),
    *(output_of(float64, 3), output_of(float32, 2)),
)
def pose_instances(
    set_transform: int, commit: int, geometries: Array, is_new: Array, poses: Array, kept: Array, rotations: Array
) -> int:
    """Pose the instances that moved or are new, and return how many they were.

    Args:
        set_transform: address of rtcSetGeometryTransform.
        commit: address of rtcCommitGeometry.
        geometries: (e,) the instances.
        is_new: (e,) true where an instance has no pose yet, or another shape.
        poses: (e, 4, 4) their poses.
        kept: (e, 4, 4) their poses before; overwritten.
        rotations: (e, 9) row by row; overwritten.
    """
    transform = np.empty(12, np.float32)
    moved = 0
    for i in range(len(geometries)):
        is_moved = is_new[i]
        for row in range(3):
            for column in range(4):
                if poses[i, row, column] != kept[i, row, column]:
                    is_moved = True
        if not is_moved:
            continue
        moved += 1
        for row in range(3):
            for column in range(4):
                kept[i, row, column] = poses[i, row, column]
                transform[4 * row + column] = poses[i, row, column]
                if column < 3:
                    rotations[i, 3 * row + column] = poses[i, row, column]
        call(set_transform, geometries[i], np.uint64(0), np.uint64(FLOAT3X4), np.uint64(transform.ctypes.data))
        call(commit, geometries[i])
    return moved
