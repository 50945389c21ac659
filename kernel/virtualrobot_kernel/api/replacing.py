"""Starts that take over from motions on their way (REPLACE), and plans that are started as they were shown."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.planning.moves import JointTrajectory
from virtualrobot_kernel.planning.plan_motion import PlannedMotion
from virtualrobot_kernel.planning.program import MotionSpec
from virtualrobot_kernel.world.actuators import coupled_joints
from virtualrobot_kernel.world.apply_cell import refuse_stopped
from virtualrobot_kernel.world.change import moving_motion


def check_can_replace(
    kernel: KernelServices,
    request: motion_pb2.StartMotionRequest,
    spec: MotionSpec,
    joints: Collection[tuple[int, str]],
) -> None:
    """Raise KernelError for a start that can't take over: joints are those that it moves, (robot uid, name)."""
    move = spec.moves[0] if len(spec.moves) == 1 else None
    if not isinstance(move, JointTrajectory) or not move.segments:
        raise KernelError(
            "only a single joint trajectory of SEGMENTS takes over from a motion that is on its way; start others with "
            "PREEMPT",
            field="busy_policy",
        )
    if request.hold:
        raise KernelError(
            "a motion that takes over from another one can't stand at its start; leave out `hold`", field="hold"
        )
    snapshot = kernel.world.snapshot
    refuse_stopped(snapshot.state)
    moving = moving_motion(snapshot.state, coupled_joints(snapshot.structure, joints))
    if moving and kernel.links.is_executing({uid for uid, _ in joints}):
        raise KernelError(
            f"a real robot plays {moving.id!r}, and only what was checked as a whole, so nothing takes over from it; "
            "start with PREEMPT",
            reason=Reason.WRONG_STATE,
            motion=moving.id,
        )


def replacing(planned: PlannedMotion) -> PlannedMotion:
    """Return a planned motion that takes over from motions in its way."""
    command = planned.command
    assert command.from_here is not None, "it was looked at before"
    return replace(planned, command=replace(command, from_here=replace(command.from_here, replaces=True)))


def as_shown(planned: PlannedMotion) -> PlannedMotion:
    """Return a planned motion that starts with the plan that it has."""
    return replace(planned, command=replace(planned.command, from_here=None))
