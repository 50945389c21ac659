"""Encoders: where the joints of the robot are, in steps, and their speeds as differences of what was told."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.sensing.motion_content import EncoderContent
from virtualrobot_kernel.sensing.noise import Noise
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.sensing.sampled_motion import three_ticks
from virtualrobot_kernel.world import sensing
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Structure


class EncoderMeter:
    """Measures joints of the robot that a node belongs to."""

    def __init__(self, uid: int, settings: sensing.Encoders, seed: int) -> None:
        """Measure the robot of the node `uid`."""
        self._uid, self._settings, self._seed = uid, settings, seed
        self._joints: tuple[str, ...] = ()
        self._noise = Noise(settings.position, seed, 0, 0)
        self._last: tuple[float, NDArray[np.float64]] | None = None

    def read(self, moment: Moment) -> EncoderContent:
        """Return what encoders tell; before the first reading, they told of the tick before."""
        snapshot = moment.snapshot
        joints, places = measured_joints(snapshot.structure, self._uid, self._settings.joints)
        if joints != self._joints:
            self._joints, self._last = joints, None
            self._noise = Noise(self._settings.position, self._seed, 0, len(joints))
        told = self._told(snapshot, places, moment.rng)
        time = snapshot.simulation_time
        if self._last is None or self._last[0] >= time:
            before = three_ticks(moment)[1]
            if before.structure is snapshot.structure:
                self._last = before.simulation_time, self._told(before, places, moment.rng)
            else:
                self._last = before.simulation_time, told
        velocities = (told - self._last[1]) / (time - self._last[0])
        self._last = time, told
        return EncoderContent(joints, told, velocities)

    def _told(self, snapshot: Snapshot, places: NDArray[np.int64], rng: np.random.Generator) -> NDArray[np.float64]:
        return self._noise.spoiled(snapshot.state.q[places], snapshot.state.tick, snapshot.tick_seconds, rng)


def measured_joints(
    structure: Structure, uid: int, names: tuple[str, ...]
) -> tuple[tuple[str, ...], NDArray[np.int64]]:
    """Return the joints of the robot of a node that have one coordinate, or those named, and their places in q.

    Raises KernelError when the node belongs to no robot, UnknownNameError for a joint that there is not.
    """
    robot = structure.robot_of(uid)
    if robot is None:
        raise KernelError(
            f"the encoders {structure.nodes[uid].name!r} are on no robot; fix them to a robot or something on it",
            reason=Reason.WRONG_STATE,
            node=structure.nodes[uid].name,
        )
    index = structure.robots[robot.uid]
    places = {
        joint.name: place
        for joint, place in zip(index.joints, index.q_start, strict=True)
        if joint.type.coordinate_count == 1
    }
    for name in names:
        if name not in places:
            raise UnknownNameError(f"joint of {robot.name!r} that turns or slides", name, places)
    joints = names or tuple(places)
    return joints, np.array([places[name] for name in joints], np.int64)
