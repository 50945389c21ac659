"""Trajectories that begin wherever their joints are as they start, also while these move: their plans. Pure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.motion.segments import JointMotion, plan_points
from virtualrobot_kernel.world.actuators import coupled_joints
from virtualrobot_kernel.world.change import Change, joint_places
from virtualrobot_kernel.world.commands import FromHere, StartMotion
from virtualrobot_kernel.world.measured import commanded
from virtualrobot_kernel.world.state import Cancellation, EndCause, Motion, State
from virtualrobot_kernel.world.structure import Structure
from virtualrobot_kernel.world.tcp import refuse_limited

Joints = tuple[tuple[int, str], ...]

GIVES_WAY = (EndCause.CALL, EndCause.PREEMPTED)
"""Causes of a stop that a motion which takes over may end."""


def joint_motion(structure: Structure, state: State, joints: Joints) -> JointMotion:
    """Return where motions command joints (robot uid, name) to be, how fast, and how accelerated."""
    q_index, v_index, _ = joint_places(structure, joints)
    there = commanded(structure, state)
    q, v, a = there[0][q_index], there[1][v_index], np.zeros(len(joints))
    columns = {joint: place for place, joint in enumerate(joints)}
    for motion in state.motions:
        own = [(columns[joint], place) for place, joint in enumerate(motion.joints) if joint in columns]
        if own and motion.rated is ...:
            mine, theirs = map(list, zip(*own, strict=True))
            q[mine], v[mine], a[mine] = (values[theirs] for values in motion.running.sample())
    return JointMotion(q, v, a)


def taken_over(change: Change, joints: Joints) -> tuple[Motion, ...]:
    """Return the motions in the way of one that takes over; raise KernelError where it can't.

    Joints: those that it moves, (robot uid, name).
    """
    structure, state = change.structure, change.state
    needed = coupled_joints(structure, joints)
    found = tuple(motion for motion in state.motions if not needed.isdisjoint(motion.joints))
    for motion in found:
        if others := [joint for joint in motion.joints if joint not in joints]:
            names = ", ".join(f"{name!r} of {structure.nodes[uid].name!r}" for uid, name in others)
            raise KernelError(
                f"{motion.id!r} moves {names}, too; a trajectory that takes over from it must move all of its joints",
                reason=Reason.ROBOT_BUSY,
                motion=motion.id,
            )
        if (why := motion.cancellation) is not None and why.cause not in GIVES_WAY:
            raise KernelError(
                f"{motion.id!r} is being stopped ({why.reason}), and nothing takes over from it; start when it stands",
                reason=Reason.WRONG_STATE,
                motion=motion.id,
            )
    if found:
        refuse_limited(structure, state, dict.fromkeys(uid for uid, _ in joints))
    return found


def program_from_here(change: Change, command: StartMotion, from_here: FromHere, rate: float) -> Program:
    """Return the program of a start with its plan made anew for joints as they are, on which it goes at a rate."""
    structure, state = change.structure, change.state
    joints = tuple((structure.robot(robot)[0].uid, joint) for robot, joint in command.joints)
    here = joint_motion(structure, state, joints)
    here = replace(here, velocities=here.velocities / rate, accelerations=here.accelerations / rate**2)
    begin = state.tick if from_here.begin is None else from_here.begin
    plan = plan_points(from_here.points, here, (state.tick - begin) * from_here.tick_seconds, from_here.limits)
    first, *others = command.program.stages
    return replace(command.program, stages=(replace(first, plan=plan), *others), start=plan.start)


def replaced_by(motion: Motion, id: str) -> Motion:
    """Return a motion that ends where it is, since another one has taken over."""
    why = motion.cancellation or Cancellation(EndCause.PREEMPTED, f"{id!r} has taken over")
    return replace(motion, running=motion.running.abort(), cancellation=why)
