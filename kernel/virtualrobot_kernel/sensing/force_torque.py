"""A force and torque sensor: what the masses that hang on it put on it, by their weight and their motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.planning.bodies import inertia_tensor, inertial_of
from virtualrobot_kernel.planning.dynamics import GRAVITY
from virtualrobot_kernel.sensing.motion_content import WrenchContent
from virtualrobot_kernel.sensing.noise import Noise
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.sensing.sampled_motion import SampledMotion, poses_of, sampled_motion, three_ticks
from virtualrobot_kernel.world import sensing
from virtualrobot_kernel.world.structure import Inertial, Structure

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Load:
    """The n bodies that hang on a sensor: their nodes, and their masses in kg.

    node_t_body (n, 4, 4): their inertial frames; inertia (n, 3, 3) about the centre of mass in these, kg m^2.
    """

    uids: tuple[int, ...]
    mass: Floats
    node_t_body: Floats
    inertia: Floats


def load_of(structure: Structure, sensor: int, include_parent: bool = False) -> Load:
    """Return what hangs below a sensor (a uid); where nothing with a mass does, what hangs below its parent.

    The parent itself is load only where that is said; else a sensor on a flange measures the tools and parts there.
    Unknown masses count as none.
    """
    parent = structure.nodes[sensor].parent
    found = [] if include_parent else list(_bodies(structure, sensor))
    found = found or [one for one in _bodies(structure, parent) if include_parent or one[0] != parent]
    return Load(
        tuple(uid for uid, _ in found),
        np.array([one.mass for _, one in found]),
        np.array([one.link_t_inertial for _, one in found]).reshape(-1, 4, 4),
        np.array([inertia_tensor(one) for _, one in found]).reshape(-1, 3, 3),
    )


def _bodies(structure: Structure, above: int) -> Iterator[tuple[int, Inertial]]:
    for node in structure.below(above):
        inertial = inertial_of(node)
        if inertial is not None and inertial.mass > 0.0:
            yield node.uid, inertial


def wrench_of(load: Load, motion: SampledMotion, origin: Floats) -> tuple[Floats, Floats]:
    """Return force (3,) and torque (3,) about `origin` (3,) that a load puts on what holds it, in the world's frame.

    `motion` is that of the bodies' inertial frames. Newton's and Euler's equations of each body, with the sign of the
    reaction: m (g - a), and -(I dw + w x I w) about the centre of mass.
    """
    turn, w, dw = motion.pose[:, :3, :3], motion.angular_velocity, motion.angular_acceleration
    force = load.mass[:, None] * (np.array(GRAVITY) - motion.acceleration)
    spin = np.einsum("nij,nj->ni", load.inertia, dw) + np.cross(w, np.einsum("nij,nj->ni", load.inertia, w))
    torque = np.cross(motion.pose[:, :3, 3] - origin, force) - np.einsum("nij,nj->ni", turn, spin)
    return force.sum(axis=0), torque.sum(axis=0)


class ForceTorqueMeter:
    """Measures force and torque at a node; what it tells is of one tick before the reading's."""

    def __init__(self, uid: int, settings: sensing.ForceTorqueSensor, seed: int) -> None:
        """Measure at the node `uid`."""
        self._uid = uid
        self._force, self._torque = Noise(settings.force, seed, 0, 3), Noise(settings.torque, seed, 1, 3)
        self._include_parent = settings.include_parent
        self._load: tuple[Structure, Load] | None = None

    def read(self, moment: Moment) -> WrenchContent:
        """Return what the sensor tells."""
        ticks, structure = three_ticks(moment), moment.snapshot.structure
        if self._load is None or self._load[0] is not structure:
            self._load = structure, load_of(structure, self._uid, self._include_parent)
        load = self._load[1]
        poses = poses_of(ticks, (self._uid, *load.uids))
        world_t_sensor = poses[1, 0]
        motion = sampled_motion(ticks, poses[:, 1:] @ load.node_t_body)
        node_t_world = world_t_sensor[:3, :3].T
        force, torque = wrench_of(load, motion, world_t_sensor[:3, 3])
        return WrenchContent(
            self._force.spoiled(node_t_world @ force, moment), self._torque.spoiled(node_t_world @ torque, moment)
        )
