"""A pose sensor: where its node is in the world, as a satellite receiver or a tracker tells it."""

from __future__ import annotations

import numpy as np
from virtualrobot_sdk.poses import rotation_matrix, rotation_vector

from virtualrobot_kernel.sensing.motion_content import PoseContent
from virtualrobot_kernel.sensing.noise import Noise
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.sensing.sampled_motion import poses_of, sampled_motion, three_ticks
from virtualrobot_kernel.world import sensing


class PoseMeter:
    """Measures where a node is; its velocity is told as it is."""

    def __init__(self, uid: int, settings: sensing.PoseSensor, seed: int) -> None:
        """Measure the node `uid`."""
        self._uid = uid
        self._position = Noise(settings.position, seed, 0, 3)
        self._orientation = Noise(settings.orientation, seed, 1, 3)
        self._stepped = settings.orientation.resolution > 0.0 or settings.orientation.range > 0.0

    def read(self, moment: Moment) -> PoseContent:
        """Return what the sensor tells."""
        ticks = three_ticks(moment)
        poses = poses_of(ticks, [self._uid])
        told = poses[2, 0].copy()
        told[:3, 3] = self._position.spoiled(told[:3, 3], moment)
        error = self._orientation.error(moment.elapsed, moment.snapshot.tick_seconds, moment.rng)
        if error.any():
            told[:3, :3] = told[:3, :3] @ rotation_matrix(error)
        if self._stepped:
            told[:3, :3] = rotation_matrix(self._orientation.told(rotation_vector(told[:3, :3])))
        return PoseContent(told, np.array(sampled_motion(ticks, poses).velocity[0]))
