"""Crafts: robots whose base is a planar or floating joint, with a turning mast; and pinocchio's view of them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio  # pyright: ignore[reportMissingImports]  a path file makes it importable
from virtualrobot_kernel.planning.moves import Move, PointToPoint
from virtualrobot_kernel.planning.plan_motion import PlannedMotion, plan_motion
from virtualrobot_kernel.planning.program import MotionSpec, MoveStep
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import CreateNodes, SetJointPositions
from virtualrobot_kernel.world.figures import Box, Figure, Pose
from virtualrobot_kernel.world.structure import Joint, JointLimits, JointType, Kind, LinkData, NodeSpec, RobotData

from tests.unit.planning.cell import chain, pictured
from tests.unit.world.builders import LIMITS, Z, after, empty, shifted, ticked

PLANAR, FLOATING = JointType.PLANAR, JointType.FLOATING
SPEED, ACCELERATION, JERK = 1.0, 2.0, 20.0
AXES = {PLANAR: ("x", "y", "theta"), FLOATING: ("x", "y", "z", "qx", "qy", "qz", "qw")}


def craft(kind: JointType, axis: tuple[float, float, float] = Z, pose: Pose | None = None) -> CreateNodes:
    """Return the robot `craft`: a box of 0.4 m on its joint `base`, on it the joint `mast` with a tip 0.5 m out."""
    base = Joint("base", kind, axis, JointLimits(velocity=SPEED, acceleration=ACCELERATION, jerk=JERK))
    box = (Figure(Box((0.4, 0.4, 0.4))),)
    return CreateNodes(
        (
            NodeSpec("craft", Kind.ROBOT, "world", shifted() if pose is None else pose, data=RobotData(flange="tip")),
            NodeSpec("craft.body", Kind.LINK, "craft", shifted(), figures=box, data=LinkData(base)),
            NodeSpec(
                "craft.mast",
                Kind.LINK,
                "craft.body",
                shifted(z=0.3),
                data=LinkData(Joint("mast", JointType.REVOLUTE, (0.0, 0.6, 0.8), LIMITS)),
            ),
            NodeSpec("craft.tip", Kind.LINK, "craft.mast", shifted(x=0.5), data=LinkData(Joint("tip"))),
        )
    )


def at(kind: JointType, coordinates: np.ndarray, prefix: str = "base") -> dict[str, float]:
    """Return the coordinates of a base by name."""
    return {f"{prefix}/{axis}": float(value) for axis, value in zip(AXES[kind], coordinates, strict=True)}


def anywhere(kind: JointType, rng: np.random.Generator) -> np.ndarray:
    """Return random coordinates of a base within 2 m."""
    if kind is PLANAR:
        return rng.uniform([-2.0, -2.0, -3.0], [2.0, 2.0, 3.0])
    quaternion = rng.normal(size=4)
    return np.concatenate([rng.uniform(-2.0, 2.0, 3), quaternion / np.linalg.norm(quaternion)])


def standing(kind: JointType, rng: np.random.Generator, **options: object) -> Change:
    """Return a world with a craft somewhere."""
    world = after(empty(), craft(kind, **options))  # pyright: ignore[reportArgumentType]
    return after(world, SetJointPositions("craft", at(kind, anywhere(kind, rng))))


def planned(world: Change, *moves: Move, steps: tuple[MoveStep, ...] = ()) -> PlannedMotion:
    """Return the plan of moves that go together, or of steps."""
    return plan_motion(pictured(world), MotionSpec(moves, steps), chain)


def moving(world: Change, goal: Mapping[str, float], speed_factor: float = 1.0) -> Change:
    """Return the world in which a craft has begun to go to a goal."""
    return after(world, planned(world, PointToPoint("craft", goal, speed_factor)).command)


def run(world: Change) -> tuple[Change, np.ndarray, np.ndarray]:
    """Return the world when all stands, and q (n, nq) and v (n, nv) of each tick from now on."""
    q, v = [world.state.q], [world.state.v]
    while world.state.motions:
        world = ticked(world)
        q.append(world.state.q)
        v.append(world.state.v)
    return world, np.array(q), np.array(v)


def pinocchio_q(kind: JointType, base: np.ndarray) -> np.ndarray:
    """Return the coordinates of a base as pinocchio's planar or free-flyer joint has them."""
    return base if kind is FLOATING else np.array([*base[:2], np.cos(base[2]), np.sin(base[2])])


def pinocchio_v(kind: JointType, base: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return velocities of a base as pinocchio has them, whose linear part is in the axes of the moved body."""
    model = model_of(kind)
    data = model.createData()
    pinocchio.forwardKinematics(model, data, pinocchio_q(kind, base))
    rotation = data.oMi[1].rotation
    if kind is FLOATING:
        return np.concatenate([rotation.T @ v[:3], v[3:]])
    return np.array([*(rotation[:2, :2].T @ v[:2]), v[2]])


def model_of(kind: JointType) -> pinocchio.Model:
    """Return pinocchio's model of nothing but the base."""
    model = pinocchio.Model()
    joint = pinocchio.JointModelFreeFlyer() if kind is FLOATING else pinocchio.JointModelPlanar()
    model.addJoint(0, joint, pinocchio.SE3.Identity(), "base")
    return model
