"""World as a program's own steps will have changed it: what is held, what is chosen. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.planning.robots import standing_at, with_state, world_poses
from virtualrobot_kernel.planning.steps import Column
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.awaited_part import AwaitedPart
from virtualrobot_kernel.world.change import joint_places
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind
from virtualrobot_kernel.world.tolerances import AwaitedJoints

World = tuple[float, Snapshot]
"""World from a nominal time (s) of a program on, which is right but for what the program's joints do."""


def obeyed(snapshot: Snapshot, orders: Sequence[object]) -> tuple[Snapshot, str]:
    """Return the world after orders, and why they can't be done in it; then it is as it was.

    Raises KernelError for what no other world would allow either, such as unknown names.
    """
    commands = [one for one in orders if not isinstance(one, AwaitedPart | AwaitedJoints)]
    if not commands:
        return snapshot, ""
    try:
        change = apply(snapshot.structure, snapshot.state, cast("list[Command]", commands), world_poses)
    except KernelError as error:
        if error.reason is not Reason.WRONG_STATE:
            raise
        return snapshot, str(error)
    return with_state(snapshot, change.state, change.structure), ""


def after(snapshot: Snapshot, joints: Sequence[Column], program: Program, first: int = 0) -> list[World]:
    """Return the worlds after the orders of each stage of a program, from the stage `first` on; before them `snapshot`.

    joints: robot and joint of each of its columns. There is one for each stage with orders, done or not.
    """
    structure = snapshot.structure
    named = tuple((structure.node(robot, Kind.ROBOT).uid, joint) for robot, joint in joints)
    q_index, q = joint_places(structure, named)[0], np.array(program.start)
    worlds = [(0.0, snapshot)]
    for place, (stage, begin) in enumerate(zip(program.stages, program.begins, strict=False)):
        if stage.plan is not None:
            q[list(stage.columns)] = stage.plan.goal
        if stage.orders and place >= first:
            now, _ = obeyed(standing_at(worlds[-1][1], q_index, q), stage.orders)
            worlds.append((begin, now))
    return worlds


def at(worlds: Sequence[World], time: float) -> Snapshot:
    """Return the world at a time of a program."""
    return next(world for begin, world in reversed(worlds) if begin <= time or begin == 0.0)
