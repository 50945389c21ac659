"""Robots for tests of dynamics: real ones as pinocchio reads them, and trees drawn at random."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio  # pyright: ignore[reportMissingImports]  a path file makes it importable
import rtbdata
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.state import Snapshot, State
from virtualrobot_kernel.world.structure import (
    Inertial,
    Joint,
    JointType,
    Kind,
    LinkData,
    Mimic,
    NodeSpec,
    Structure,
)

from tests.unit.formats.models import ROBOTS, load, structure_of
from tests.unit.numeric.urdf_arrays import MODELS
from tests.unit.world.builders import random_pose

RTB = Path(rtbdata.__file__).parent / "xacro"
FILES = {
    **{name: ROBOTS[name] for name in ("iiwa", "panda", "a1", "r2d2")},
    "kr16": RTB / "kuka_description/kuka_kr16/urdf/kr16_2.urdf",
    "puma560": MODELS / "puma560.urdf",
}
"""The Puma's file tells no masses."""


def snapshot_of(nodes: Sequence[NodeSpec], q: np.ndarray | None = None) -> Snapshot:
    """Return a world that holds these nodes, its joints at zero or at q (nq,)."""
    structure, poses = structure_of(tuple(nodes))
    q = np.zeros(structure.q_count) if q is None else q
    state = State(0, q, np.zeros(structure.v_count), poses)
    return Snapshot(structure, state, world_poses(structure, state), 1, 0.0, 0.004)


def random_inertial(rng: np.random.Generator, mass: float = 0.0) -> Inertial:
    """Return the mass of a few random points: so it can exist."""
    points = rng.uniform(-0.1, 0.1, (5, 3))
    points -= points.mean(axis=0)
    mass = mass or float(rng.uniform(0.5, 5.0))
    tensor = sum(mass / 5 * (p @ p * np.eye(3) - np.outer(p, p)) for p in points)
    assert isinstance(tensor, np.ndarray)
    xx, yy, zz = np.diag(tensor).tolist()
    return Inertial(mass, random_pose(rng), (xx, yy, zz), (tensor[0, 1], tensor[0, 2], tensor[1, 2]))


def pin_inertia(inertial: Inertial, joint_t_node: Pose) -> tuple[Any, Any]:
    """Return a mass as pinocchio has it, and where its frame is in the joint's."""
    (xx, yy, zz), (xy, xz, yz) = inertial.diagonal, inertial.products
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    place = joint_t_node @ inertial.link_t_inertial
    return pinocchio.Inertia(inertial.mass, np.zeros(3), tensor), pinocchio.SE3(place[:3, :3], place[:3, 3])


@dataclass(frozen=True)
class Reference:
    """A robot as pinocchio has it, on a standing base that is turned as `world_t_base` says."""

    structure: Structure
    model: Any
    data: Any
    joints: tuple[str, ...]
    mimics: dict[str, Mimic]

    @staticmethod
    def of(structure: Structure, model: Any, world_t_base: Pose) -> Reference:  # noqa: ANN401  pinocchio has no types
        model.gravity.linear = world_t_base[:3, :3].T @ [0.0, 0.0, -9.81]
        joints = [node.data.joint for node in structure.nodes.values() if isinstance(node.data, LinkData)]
        moving = tuple(joint.name for joint in joints if joint.mimic is None and joint.type is not JointType.FIXED)
        mimics = {joint.name: joint.mimic for joint in joints if joint.mimic}
        return Reference(structure, model, model.createData(), moving, mimics)

    def efforts(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Return the efforts (k,) at one sample: mimic joints follow, and their effort counts at their source."""
        values = dict(zip(self.joints, zip(q, v, a, strict=True), strict=True))
        factor = dict.fromkeys(self.joints, 1.0)
        source = {name: name for name in self.joints}
        for name, mimic in self.mimics.items():
            position, speed, slope = values[mimic.joint]
            m = mimic.multiplier
            values[name] = (m * position + mimic.offset, m * speed, m * slope)
            factor[name], source[name] = m, mimic.joint
        theirs = pinocchio.neutral(self.model), np.zeros(self.model.nv), np.zeros(self.model.nv)
        for name, (position, speed, slope) in values.items():
            joint = self.model.joints[self.model.getJointId(name)]
            turned = [np.cos(position), np.sin(position)] if joint.nq == 2 else [position]
            theirs[0][joint.idx_q : joint.idx_q + joint.nq] = turned
            theirs[1][joint.idx_v], theirs[2][joint.idx_v] = speed, slope
        torque = pinocchio.rnea(self.model, self.data, *theirs)
        result = dict.fromkeys(self.joints, 0.0)
        for name in values:
            result[source[name]] += factor[name] * torque[self.model.joints[self.model.getJointId(name)].idx_v]
        return np.array([result[name] for name in self.joints])


def robot_and_reference(name: str, world_t_base: Pose) -> tuple[tuple[NodeSpec, ...], Reference]:
    """Return a robot's nodes as our reader makes them, called `arm`, and what pinocchio makes of the same file."""
    model, _ = load(FILES[name], name="arm", parent_t_node=world_t_base)
    theirs = pinocchio.buildModelFromUrdf(str(FILES[name]))
    structure, _ = structure_of(model.nodes)
    return model.nodes, Reference.of(structure, theirs, world_t_base)


def with_masses(
    nodes: Sequence[NodeSpec], reference: Reference, rng: np.random.Generator
) -> tuple[tuple[NodeSpec, ...], Reference]:
    """Return a robot with a random mass more on each link, in our nodes and in pinocchio's model."""
    weighty = []
    for spec in nodes:
        if isinstance(spec.data, LinkData):
            inertial = random_inertial(rng)
            frame = reference.model.frames[reference.model.getFrameId(spec.name.partition(".")[2])]
            body = pin_inertia(inertial, frame.placement.homogeneous)
            reference.model.appendBodyToJoint(frame.parentJoint, *body)
            spec = replace(spec, data=replace(spec.data, inertial=inertial))
        weighty.append(spec)
    return tuple(weighty), replace(reference, data=reference.model.createData())


def random_tree(rng: np.random.Generator, links: int = 8) -> tuple[NodeSpec, ...]:
    """Return a robot whose links hang on random links before them by joints of random type and axis; one mimics."""
    nodes = [NodeSpec("tree", Kind.ROBOT, parent_t_node=random_pose(rng))]
    for i in range(links):
        axis = rng.normal(size=3)
        x, y, z = (axis / np.linalg.norm(axis)).tolist()
        kind = JointType.PRISMATIC if i % 3 == 1 else JointType.CONTINUOUS
        mimic = Mimic("joint_2", -0.7, 0.2) if i == links - 1 else None
        parent = nodes[int(rng.integers(0, len(nodes)))].name
        data = LinkData(Joint(f"joint_{i}", kind, (x, y, z), mimic=mimic), random_inertial(rng))
        nodes.append(NodeSpec(f"tree.{i}", Kind.LINK, parent, random_pose(rng), data=data))
    return tuple(nodes)
