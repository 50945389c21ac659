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
    """Measures joints of the robot that a node belongs to.

    A speed is the difference of what is told now and of what was told a period ago, or where that is too long ago, at
    the first tick that is known.
    """

    def __init__(self, uid: int, settings: sensing.Encoders, seed: int, rate_hertz: float) -> None:
        """Measure the robot of the node `uid`."""
        self._uid, self._settings, self._seed = uid, settings, seed
        self._period = 1.0 / rate_hertz
        self._noise = Noise(settings.position, seed, 0, 0)
        self._joints: tuple[str, ...] = ()

    def read(self, moment: Moment) -> EncoderContent:
        """Return what the encoders tell."""
        snapshot = moment.snapshot
        joints, places = measured_joints(snapshot.structure, self._uid, self._settings.joints)
        if joints != self._joints:
            self._joints, self._noise = joints, Noise(self._settings.position, self._seed, 0, len(joints))
        told = self._noise.spoiled(snapshot.state.q[places], moment)
        before = self._before(moment)
        seconds = (snapshot.state.tick - before.snapshot.state.tick) * snapshot.tick_seconds
        last = self._noise.spoiled(self._then(before.snapshot, snapshot, joints, places), before)
        return EncoderContent(joints, told, (told - last) / seconds)

    def _before(self, moment: Moment) -> Moment:
        """Return the reading a period ago, as it was or would have been made."""
        now, ticks = moment.snapshot.state.tick, max(self._period / moment.snapshot.tick_seconds, 1.0)
        earlier = [one for one in moment.history if one.state.tick < now] or [three_ticks(moment)[1]]
        old_enough = [one for one in earlier if one.state.tick <= now - ticks + 1e-6]
        then = old_enough[-1] if old_enough else earlier[0]
        rng = np.random.default_rng((self._seed, moment.number - 1))
        return Moment(then, (), moment.number - 1, rng, max(moment.elapsed - (now - then.state.tick), 0))

    def _then(
        self, then: Snapshot, now: Snapshot, joints: tuple[str, ...], places: NDArray[np.int64]
    ) -> NDArray[np.float64]:
        """Return where the joints were; those that were not there stood as they stand."""
        if then.structure is now.structure:
            return then.state.q[places]
        if self._uid in then.structure.nodes and then.structure.robot_of(self._uid) is not None:
            known = dict(zip(*measured_joints(then.structure, self._uid, ()), strict=True))
            stand = zip(joints, places, strict=True)
            return np.array([then.state.q[known[name]] if name in known else now.state.q[at] for name, at in stand])
        return now.state.q[places]


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
