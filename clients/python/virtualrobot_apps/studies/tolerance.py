"""Tolerances: how far a tool centre point misses its target when base, joints and part are a little off, by chance.

For a study file: `function: virtualrobot_apps.studies.tolerance:hit`,
`setup: virtualrobot_apps.studies.worlds:open_world`, and `draws`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from virtualrobot.geometry import rotation_from_vector, turn_between

from virtualrobot_apps.studies.parameters import Floats, check_deviations
from virtualrobot_apps.studies.placement import margins
from virtualrobot_apps.studies.work import Cell
from virtualrobot_apps.studies.worlds import World


def hit(cell: Cell) -> dict[str, float]:
    """Return how far a robot misses a target that it was told for a world in which nothing is off.

    Its parameters: `robot` and `target`, names of nodes; the standard deviations of what is off, without which it is
    not: `joints` (rad, or m where they slide), `base` and `part` (m, in each direction of their own frames),
    `base_angle` and `part_angle` (rad, about each axis); and `tolerance` (m) and `tolerance_angle` (rad; without it,
    any) up to which it is a hit. The posture is the free one whose joints are farthest from their limits.

    Its results: `off` (m) and `turned` (rad), of the tool centre point from the target; `hit`, whether both are within
    their tolerances; `free`, whether the arm touches nothing there.

    Raises:
        ValueError: when no posture for the target is free, or a deviation is below 0.
    """
    world, parameters = cell.shared, cell.parameters
    check_deviations(parameters, "joints", "base", "part", "base_angle", "part_angle", "tolerance", "tolerance_angle")
    world.restore()
    robot, target = parameters["robot"], parameters["target"]
    told = _told(world, robot, target)
    base = displacement(cell.rng, parameters.get("base", 0.0), parameters.get("base_angle", 0.0))
    part = displacement(cell.rng, parameters.get("part", 0.0), parameters.get("part_angle", 0.0))
    joints = told.joints + cell.rng.normal(size=len(told.joints)) * parameters.get("joints", 0.0)
    stood = world.pose(robot)
    world.place(robot, world.parent_pose(robot) @ base)
    moved = world.pose(robot) @ np.linalg.inv(stood)
    world.place(target, world.parent_pose(target) @ part)
    # A target that hangs on the robot's base has moved with it.
    world_t_tcp = moved @ told.world_t_base @ world.kinematic_errors(robot).poses(told.no_errors, joints[None])[0]
    world_t_target = world.pose(target)
    off, turned = math.dist(world_t_tcp[:3, 3], world_t_target[:3, 3]), turn_between(world_t_tcp, world_t_target)
    found = world.postures(robot, world_t_tcp[None])
    near = np.abs(found.positions - joints).max(axis=1, initial=0.0)
    return {
        "off": off,
        "turned": turned,
        "hit": off <= parameters["tolerance"] and turned <= parameters.get("tolerance_angle", math.pi),
        "free": bool(len(near)) and bool(found.free[near.argmin()]) and not world.contacts(robot),
    }


class _Told(NamedTuple):
    """Posture (k,) for a target in a world as it is thought to be, the arm's base there, and errors that are none."""

    joints: Floats
    world_t_base: Floats
    no_errors: Floats


def _told(world: World, robot: str, target: str) -> _Told:
    pose = world.pose(target)
    found = world.postures(robot, pose[None])
    if not found.free.any():
        raise ValueError(f"no posture of {robot!r} for {target!r} is free, even where nothing is off")
    joints = found.positions[np.where(found.free, margins(found, world.joint_limits(robot)), -np.inf).argmax()]
    chain = world.kinematic_errors(robot)
    no_errors = np.zeros(chain.count)
    return _Told(joints, pose @ np.linalg.inv(chain.poses(no_errors, joints[None])[0]), no_errors)


def displacement(rng: np.random.Generator, length: float, angle: float) -> Floats:
    """Return a pose (4, 4) that is off by normal laws: `length` (m) each way, `angle` (rad) about each axis."""
    pose = np.eye(4)
    pose[:3, :3] = rotation_from_vector(rng.normal(size=3) * angle)
    pose[:3, 3] = rng.normal(size=3) * length
    return pose
