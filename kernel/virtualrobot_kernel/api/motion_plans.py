"""PlanMotion and CheckMotion: what a start would do, and whether it can; nothing moves."""

from __future__ import annotations

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.convert.plans import check_message, plan_message
from virtualrobot_kernel.api.convert.values import not_negative, stamp
from virtualrobot_kernel.api.motion_calls import wished
from virtualrobot_kernel.api.rooms import Rooms
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.planning.check import check_motion
from virtualrobot_kernel.planning.plan_program import GivenUp, plan_wish
from virtualrobot_kernel.planning.sampling import check_size, sample_times, sampled
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import check_revision


async def planned_motion(rooms: Rooms, request: motion_pb2.PlanMotionRequest) -> motion_pb2.PlanMotionResponse:
    """Return a motion in samples, planned in a thread on the snapshot of that moment."""
    seconds = _sample_seconds(rooms.world.snapshot, request.sample_seconds)
    wish, _, robots = await wished(rooms, request.motion)

    def work(given_up: GivenUp) -> motion_pb2.PlanMotionResponse:
        snapshot = _snapshot(rooms, request.motion)
        planned = plan_wish(snapshot, wish, rooms.solvers.of, given_up)
        program, joints = planned.command.program, planned.command.joints
        check_size(program.duration, seconds, len(joints), len({robot for robot, _ in joints}))
        samples = sampled(snapshot, program, joints, sample_times(program.duration, seconds), given_up)
        message = plan_message(samples, planned.notes)
        message.stamp.CopyFrom(stamp(snapshot))
        return message

    return await rooms.turns.run_while_wanted(robots, work)


async def checked_motion(rooms: Rooms, request: motion_pb2.CheckMotionRequest) -> motion_pb2.CheckMotionResponse:
    """Return what a motion violates first, looked for in a thread on the snapshot of that moment."""
    margin = not_negative(request.min_singular_value, "min_singular_value")
    wish, _, robots = await wished(rooms, request.motion)

    def work(given_up: GivenUp) -> motion_pb2.CheckMotionResponse:
        snapshot = _snapshot(rooms, request.motion)
        message = check_message(check_motion(snapshot, wish, rooms.solvers.of, margin, given_up))
        message.stamp.CopyFrom(stamp(snapshot))
        return message

    return await rooms.turns.run_while_wanted(robots, work)


def _snapshot(rooms: Rooms, motion: motion_pb2.StartMotionRequest) -> Snapshot:
    """Return the world as it is; raise KernelError when the motion is meant for another one."""
    snapshot = rooms.world.snapshot
    check_revision(snapshot.structure, motion.expected_revision or None)
    return snapshot


def _sample_seconds(snapshot: Snapshot, seconds: float) -> float:
    """Return the time between samples in s; raise KernelError for less than a tick."""
    tick = snapshot.tick_seconds
    if not_negative(seconds, "sample_seconds") and seconds < tick * (1.0 - 1e-9):
        raise KernelError(
            f"sample_seconds must be 0 (a tick) or at least a tick, {tick:g} s, not {seconds:g}", field="sample_seconds"
        )
    return seconds or tick
