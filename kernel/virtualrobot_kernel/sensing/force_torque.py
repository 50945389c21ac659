"""A force and torque sensor: what hangs on it puts on it, by its weight, its motion, and what touches it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.planning.bodies import inertia_tensor, inertial_of
from virtualrobot_kernel.sensing.motion_content import WrenchContent
from virtualrobot_kernel.sensing.noise import Noise
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.sensing.sampled_motion import SampledMotion, poses_of, sampled_motion, three_ticks
from virtualrobot_kernel.world import sensing
from virtualrobot_kernel.world.state import BodyContacts
from virtualrobot_kernel.world.structure import Inertial, Node, Structure

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Load:
    """All nodes that hang on a sensor (uids), and the n of them that are bodies: their nodes, and their masses in kg.

    node_t_body (n, 4, 4): their inertial frames; inertia (n, 3, 3) about the centre of mass in these, kg m^2.
    """

    nodes: frozenset[int]
    uids: tuple[int, ...]
    mass: Floats
    node_t_body: Floats
    inertia: Floats


def load_of(structure: Structure, sensor: int, include_parent: bool = False) -> Load:
    """Return what hangs below a sensor (a uid); where nothing with mass or figures does, what hangs below its parent.

    The parent itself is load only where that is said; else a sensor on a flange measures the tools and parts there.
    Unknown masses count as none.
    """
    parent = structure.nodes[sensor].parent
    nodes = [] if include_parent else [node for node in structure.below(sensor) if node.uid != sensor]
    if not any(node.figures or _mass(node) for node in nodes):
        nodes = [node for node in structure.below(parent) if include_parent or node.uid != parent]
    found = [(node.uid, inertial) for node in nodes if (inertial := _mass(node)) is not None]
    return Load(
        frozenset(node.uid for node in nodes),
        tuple(uid for uid, _ in found),
        np.array([one.mass for _, one in found]),
        np.array([one.link_t_inertial for _, one in found]).reshape(-1, 4, 4),
        np.array([inertia_tensor(one) for _, one in found]).reshape(-1, 3, 3),
    )


def _mass(node: Node) -> Inertial | None:
    inertial = inertial_of(node)
    return inertial if inertial is not None and inertial.mass > 0.0 else None


def wrench_of(load: Load, motion: SampledMotion, origin: Floats, gravity: Floats) -> tuple[Floats, Floats]:
    """Return force (3,) and torque (3,) about `origin` (3,) that a load puts on what holds it, in the world's frame.

    `motion` is that of the bodies' inertial frames, `gravity` (3,) in m/s^2. Newton's and Euler's equations of each
    body, with the sign of the reaction: m (g - a), and -(I dw + w x I w) about the centre of mass.
    """
    turn, w, dw = motion.pose[:, :3, :3], motion.angular_velocity, motion.angular_acceleration
    force = load.mass[:, None] * (gravity - motion.acceleration)
    spin = np.einsum("nij,nj->ni", load.inertia, dw) + np.cross(w, np.einsum("nij,nj->ni", load.inertia, w))
    torque = np.cross(motion.pose[:, :3, 3] - origin, force) - np.einsum("nij,nj->ni", turn, spin)
    return force.sum(axis=0), torque.sum(axis=0)


def touched(load: Load, contacts: BodyContacts | None, origin: Floats) -> tuple[Floats, Floats]:
    """Return force (3,) and torque (3,) about `origin` (3,) by which all else touches a load, in the world's frame.

    What touches within the load are forces of its own, which its motion has already.
    """
    if contacts is None:
        return np.zeros(3), np.zeros(3)
    first, second = np.isin(contacts.nodes, list(load.nodes)).T
    forces = (second.astype(float) - first)[:, None] * contacts.forces
    return forces.sum(axis=0), np.cross(contacts.positions - origin, forces).sum(axis=0)


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
        state, origin = ticks[1].state, world_t_sensor[:3, 3]
        wrenches = (
            wrench_of(load, motion, origin, np.array(state.physics_settings.gravity)),
            touched(load, state.contacts, origin),
        )
        force, torque = (sum(parts) for parts in zip(*wrenches, strict=True))
        return WrenchContent(
            self._force.spoiled(node_t_world @ force, moment), self._torque.spoiled(node_t_world @ torque, moment)
        )
