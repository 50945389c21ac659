"""An inertial unit: turning rate, specific force and magnetic field in the frame of its node."""

from __future__ import annotations

import numpy as np

from virtualrobot_kernel.sensing.motion_content import ImuContent
from virtualrobot_kernel.sensing.noise import Noise
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.sensing.sampled_motion import poses_of, sampled_motion, three_ticks
from virtualrobot_kernel.world import sensing

EARTH_FIELD = (0.0, 2e-5, -4.4e-5)
"""Tesla in the world's frame, y north: about that of central Europe (World Magnetic Model 2020)."""


class ImuMeter:
    """Measures how a node turns and accelerates; what it tells is of one tick before the reading's."""

    def __init__(self, uid: int, settings: sensing.Imu, seed: int) -> None:
        """Measure the node `uid`."""
        self._uid = uid
        self._field = np.array(settings.magnetic_field or EARTH_FIELD)
        models = (settings.gyroscope, settings.accelerometer, settings.magnetometer)
        self._noises = [Noise(model, seed, channel, 3) for channel, model in enumerate(models)]

    def read(self, moment: Moment) -> ImuContent:
        """Return what the unit tells."""
        ticks = three_ticks(moment)
        motion = sampled_motion(ticks, poses_of(ticks, [self._uid]))
        node_t_world = motion.pose[0, :3, :3].T
        true = (
            motion.angular_velocity[0],
            node_t_world @ (motion.acceleration[0] - ticks[1].state.physics_settings.gravity),
            node_t_world @ self._field,
        )
        return ImuContent(*(noise.spoiled(one, moment) for noise, one in zip(self._noises, true, strict=True)))
