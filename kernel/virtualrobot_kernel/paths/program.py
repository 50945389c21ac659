"""Program of moves along a path: its corners are rounded as far as the rounded motion itself is proven free."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.node_pairs import names_of
from virtualrobot_kernel.collision.swept import SweptContact
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.paths.query import PathQuery
from virtualrobot_kernel.paths.space import PathSpace
from virtualrobot_kernel.planning.moves import PointToPoint
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.program import MotionSpec, MoveStep, Zone
from virtualrobot_kernel.planning.robots import Arm
from virtualrobot_kernel.planning.sampling import steps_at
from virtualrobot_kernel.planning.steps import GoOn
from virtualrobot_kernel.world.change import joint_places
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

Floats = NDArray[np.float64]

SMALLEST = 2.0
"""Zone (percent) below which a corner has none."""


@dataclass(frozen=True, slots=True, eq=False)
class FreeProgram:
    """Moves along a path: their zones in percent (n,), the last 0, and how long they take all together, in s."""

    zones: tuple[float, ...]
    duration: float


def free_program(space: PathSpace, snapshot: Snapshot, query: PathQuery, waypoints: Floats, go_on: GoOn) -> FreeProgram:
    """Return zones with which the moves along free `waypoints` (n, k) touch nothing, as the kernel will plan them.

    Each begins as great as asked for; while the planned motion touches something, the zones next to the first contact
    are halved, and dropped in the end. Without zones the motion is on the path itself.
    """
    zones = [query.blend_percent] * (len(waypoints) - 2) + [0.0]
    while True:
        go_on()
        program, index = planned_program(snapshot, query, waypoints, zones)
        contact = space.meets_program(program, index, waypoints)
        if contact is None:
            return FreeProgram(tuple(zones), program.duration)
        if not _shrink(zones, program, contact):
            _refuse(snapshot, query, contact)


def planned_program(
    snapshot: Snapshot, query: PathQuery, waypoints: Floats, zones: Sequence[float]
) -> tuple[Program, NDArray[np.int32]]:
    """Return the motion that the kernel plans of the moves along waypoints (n, k), and where its columns are in q."""

    def named(goal: Floats) -> dict[str, float]:
        return dict(zip(query.joint_names, goal.tolist(), strict=True))

    steps = tuple(
        MoveStep(
            (PointToPoint(query.robot, named(goal), query.speed_factor, group=query.group),),
            Zone(percent=zone) if zone else None,
        )
        for goal, zone in zip(waypoints[1:], zones, strict=True)
    )
    command = plan_motion(snapshot, MotionSpec(steps=steps), _unsolved).command
    structure = snapshot.structure
    uid = structure.node(query.robot, Kind.ROBOT).uid
    return command.program, joint_places(structure, tuple((uid, name) for _, name in command.joints))[0]


def _shrink(zones: list[float], program: Program, contact: SweptContact) -> bool:
    """Halve the zones at both ends of the step in which the contact is; return whether there was one."""
    step = int(steps_at(program, np.array([contact.time]))[0])
    beside = [place for place in (step - 1, step) if 0 <= place < len(zones) and zones[place]]
    for place in beside:
        zones[place] = zones[place] / 2.0 if zones[place] / 2.0 >= SMALLEST else 0.0
    return bool(beside)


def _refuse(snapshot: Snapshot, query: PathQuery, contact: SweptContact) -> NoReturn:
    first, second = names_of((contact.first, contact.second), snapshot.structure)
    raise KernelError(
        f"the motion of {query.robot!r} along the path that was found would touch: {first!r} meets {second!r}; "
        "give another seed",
        reason=Reason.COLLISION,
        robot=query.robot,
        first=first,
        second=second,
    )


def _unsolved(_: Snapshot, arm: Arm) -> NoReturn:
    raise AssertionError(f"moves of joints need no inverse kinematics, {arm.robot.name!r} was asked for it")
