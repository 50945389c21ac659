"""Exported robots in PyBullet and Pinocchio: they load, and every link is where the kernel has it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio  # pyright: ignore[reportMissingImports]  a path file makes it importable
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.world.figures import Capsule, Cone, Figure
from virtualrobot_kernel.world.structure import (
    Joint,
    JointLimits,
    JointType,
    Kind,
    LinkData,
    Mimic,
    NodeSpec,
    RobotData,
    Structure,
)

from tests.pybullet_models import pybullet
from tests.unit.formats.export.worlds import drawn, snapshot_of, written
from tests.unit.formats.models import ROBOTS, forward, load, structure_of


def coned(rng: np.random.Generator) -> tuple[tuple[NodeSpec, ...], MeshLibrary]:
    """Return a robot that is made of cones, turned any way, with all joints that both engines know."""
    nodes = [
        NodeSpec("arm", Kind.ROBOT, data=RobotData()),
        NodeSpec("arm.0", Kind.LINK, "arm", data=LinkData(Joint("0"))),
    ]
    kinds = [JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC, JointType.FIXED, JointType.REVOLUTE]
    for place, kind in enumerate(kinds, 1):
        axis = rng.normal(size=3)
        axis = tuple((axis / np.linalg.norm(axis)).tolist())
        pose = np.eye(4)
        pose[:3, :3] = Rotation.random(rng=rng).as_matrix()
        pose[:3, 3] = rng.uniform(-1.0, 1.0, 3)
        limits = JointLimits() if kind is JointType.CONTINUOUS else JointLimits(-1.0, 2.0)
        mimic = Mimic("j1", -0.5, 0.25) if place == 5 else None
        joint = Joint(f"j{place}", kind, axis, limits, mimic)
        figures = (Figure(Cone(0.1, 0.3), pose), Figure(Capsule(0.1, 0.2)))
        nodes.append(
            NodeSpec(f"arm.{place}", Kind.LINK, f"arm.{place - 1}", pose, figures=figures, data=LinkData(joint))
        )
    return tuple(nodes), MeshLibrary(AssetStore())


def robot(name: str, rng: np.random.Generator) -> tuple[tuple[NodeSpec, ...], MeshLibrary]:
    if name == "cones":
        return coned(rng)
    model, library = load(ROBOTS[name], name="arm")
    return model.nodes, library


def joint_values(structure: Structure, q: np.ndarray) -> dict[str, float]:
    """Return the position of each joint that moves, followers too."""
    (index,) = structure.robots.values()
    own = dict(zip(index.joint_names, q[list(index.q_start)].tolist(), strict=True))
    values = {}
    for uid in index.links:
        data = structure.nodes[uid].data
        assert isinstance(data, LinkData)
        mimic = data.joint.mimic
        if mimic:
            values[data.joint.name] = mimic.multiplier * own[mimic.joint] + mimic.offset
        elif data.joint.type is not JointType.FIXED:
            values[data.joint.name] = own[data.joint.name]
    return values


NAMES = ["iiwa", "panda", "r2d2", "cones"]


@pytest.mark.parametrize("name", NAMES)
def test_pinocchio_agrees(name: str, tmp_path: Path, rng: np.random.Generator) -> None:
    nodes, library = robot(name, rng)
    structure, poses = structure_of(nodes)
    file, _ = written(snapshot_of(nodes), library, "arm", ".urdf", tmp_path)
    model = pinocchio.buildModelFromUrdf(str(file))
    data = model.createData()
    figures = [figure for node in nodes for figure in node.figures]
    for kind, count in (
        (pinocchio.GeometryType.VISUAL, sum(figure.visual for figure in figures)),
        (pinocchio.GeometryType.COLLISION, sum(figure.collision for figure in figures)),
    ):
        shapes = pinocchio.buildGeomFromUrdf(model, str(file), kind, package_dirs=[str(tmp_path)]).geometryObjects
        assert len(shapes) == count > 0
    for _ in range(5):
        q = drawn(structure, rng)
        theirs = pinocchio.neutral(model)
        for joint, value in joint_values(structure, q).items():
            at = model.joints[model.getJointId(joint)]
            # A continuous joint has cosine and sine as coordinates.
            theirs[at.idx_q : at.idx_q + at.nq] = value if at.nq == 1 else (np.cos(value), np.sin(value))
        pinocchio.framesForwardKinematics(model, data, theirs)
        ours = forward(structure, poses, q)
        for link, pose in ours.items():
            if link not in ("world", "arm"):
                frame = data.oMf[model.getFrameId(link.removeprefix("arm."), pinocchio.FrameType.BODY)]
                assert np.abs(frame.homogeneous - pose).max() < 1e-12, link


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_pybullet_agrees_and_loads_every_shape(name: str, tmp_path: Path, rng: np.random.Generator) -> None:
    nodes, library = robot(name, rng)
    structure, poses = structure_of(nodes)
    file, exported = written(snapshot_of(nodes), library, "arm", ".urdf", tmp_path)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(str(file), useFixedBase=True, physicsClientId=client)
        count = pybullet.getNumJoints(body, physicsClientId=client)
        infos = [pybullet.getJointInfo(body, place, physicsClientId=client) for place in range(count)]
        places = {info[1].decode(): info[0] for info in infos}
        for _ in range(5):
            q = drawn(structure, rng)
            for joint, value in joint_values(structure, q).items():
                pybullet.resetJointState(body, places[joint], value, physicsClientId=client)
            ours = forward(structure, poses, q)
            root = next(link for link in ours if link not in ("world", "arm"))
            for info in infos:
                state = pybullet.getLinkState(body, info[0], computeForwardKinematics=True, physicsClientId=client)
                pose = ours[f"arm.{info[12].decode()}"]
                # PyBullet counts in floats.
                assert np.array(state[4]) == pytest.approx(pose[:3, 3], abs=1e-5)
                assert Rotation.from_quat(state[5]).as_matrix() == pytest.approx(pose[:3, :3], abs=1e-5)
            assert ours[root] == pytest.approx(np.eye(4))
        seen = pybullet.getVisualShapeData(body, physicsClientId=client)
        figures = [figure for node in nodes for figure in node.figures if figure.visual]
        assert len(seen) >= len(figures), "a mesh of several materials counts as several"
        loaded = {Path(shape[4].decode()).name for shape in seen if shape[2] == pybullet.GEOM_MESH}
        meshes = {Path(path).name for path, _ in exported.files if path.endswith((".stl", ".obj"))}
        assert loaded and loaded <= meshes
    finally:
        pybullet.disconnect(client)
