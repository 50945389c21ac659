"""Helpers of calls about motions: find one, understand what is asked for, make way for it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.author import person
from virtualrobot_kernel.api.convert.program import ProgramText, motion_spec, program_text
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.collision.node_pairs import coordinates_between, movers
from virtualrobot_kernel.collision.report import Report
from virtualrobot_kernel.collision.transitions import watched
from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.planning.notes import Note, NoteKind
from virtualrobot_kernel.planning.program import MotionSpec, MoveStep, Step
from virtualrobot_kernel.planning.stages import check_steps
from virtualrobot_kernel.planning.steps import named_error
from virtualrobot_kernel.planning.together import joints_of, moved_arms, solved_robots
from virtualrobot_kernel.planning.tracking import arms_joints
from virtualrobot_kernel.world.actuators import coupled_joints
from virtualrobot_kernel.world.apply_cell import refuse_stopped
from virtualrobot_kernel.world.change import moving_motion
from virtualrobot_kernel.world.clock import Mode
from virtualrobot_kernel.world.collisions import STOPPING
from virtualrobot_kernel.world.commands import CancelMotion
from virtualrobot_kernel.world.state import Cancellation, EndCause, Motion, Snapshot

PATIENCE_SECONDS = 5.0
"""Timeout (s of the wall clock) of a start with PREEMPT that waits for the next step of a stepped clock."""


def find_motion(snapshot: Snapshot, id: str) -> Motion:
    """Return a motion that runs or has ended lately; raise UnknownNameError."""
    motions = (*snapshot.state.motions, *snapshot.state.ended)
    for motion in motions:
        if motion.id == id:
            return motion
    raise UnknownNameError("motion", id, (motion.id for motion in motions))


def touching_notes(report: Report, snapshot: Snapshot, motion: Motion) -> list[Note]:
    """Return a note on each pair that touches as a motion starts, which moves it and which would else be stopped."""
    structure, modes, leads = snapshot.structure, watched(snapshot), set(motion.q_index.tolist())
    notes = []
    for touch in report.touching:
        pair = touch.pair.first, touch.pair.second
        if not all(uid in structure.nodes for uid in pair) or leads.isdisjoint(coordinates_between(pair, structure)):
            continue
        robot = next((uid for uid in movers(pair, structure) if modes.get(uid) in STOPPING), None)
        if robot is not None:
            first, second = touch.names
            told = f"{first!r} and {second!r} touch already, so their touch stops nobody until they are apart"
            notes.append(Note(NoteKind.TOUCHING, 0, structure.nodes[robot].name, 0.0, 0.0, told))
    return notes


async def make_way(
    kernel: KernelServices, needed: Callable[[Snapshot], set[tuple[int, str]]], policy: int, context: object
) -> None:
    """Refuse, or cancel and wait for standstill, when joints that are `needed` (robot uid, joint name) move already.

    What a stopped cell would refuse is refused before it is planned.
    """
    world = kernel.world
    snapshot = world.snapshot
    refuse_stopped(snapshot.state)
    while motion := moving_motion(snapshot.state, coupled_joints(snapshot.structure, needed(snapshot))):
        if policy != motion_pb2.BUSY_POLICY_PREEMPT:
            names = ", ".join(repr(snapshot.structure.nodes[uid].name) for uid in motion.robots)
            raise KernelError(
                f"{names} moves in {motion.id!r}; wait for its end, or cancel it",
                reason=Reason.ROBOT_BUSY,
                motion=motion.id,
            )
        if not motion.cancellation:
            cancellation = Cancellation(EndCause.PREEMPTED, f"preempted by {person(context)}")
            try:
                cancel = kernel.submit([CancelMotion(motion.id, cancellation)], context)
                snapshot = (await asyncio.wrap_future(cancel)).snapshot
            except KernelError as error:
                if error.reason not in (Reason.WRONG_STATE, Reason.UNKNOWN_NAME):
                    raise
                snapshot = world.snapshot  # it has just ended by itself
        else:
            snapshot = await _later(kernel, snapshot, motion)


async def _later(kernel: KernelServices, seen: Snapshot, braking: Motion) -> Snapshot:
    """Return the world some time later; raise KernelError when time stands still: who waits here may be who steps."""
    stepped = kernel.world.clock.mode is Mode.STEPPED
    try:
        return await asyncio.wait_for(kernel.publications.newer_than(seen), PATIENCE_SECONDS if stepped else None)
    except TimeoutError as error:
        raise KernelError(
            f"{braking.id!r} brakes to make way, but time has stood still for {PATIENCE_SECONDS:g} s; step the clock "
            "until it has ended, then start again",
            reason=Reason.WRONG_STATE,
            motion=braking.id,
        ) from error


async def requested(
    kernel: KernelServices, message: motion_pb2.MotionSpec, text: ProgramText | None = None
) -> tuple[MotionSpec, set[tuple[int, str]], set[int]]:
    """Return a motion's spec, the joints (robot uid, name) that it needs, and the robots (uids) to be solved.

    text: what its steps say, where that is known already. Of a text with decisions it is the part before the first one;
    what the others name is looked up.
    """

    def work() -> tuple[MotionSpec, set[tuple[int, str]], set[int]]:
        said = text or program_text(message.steps, message.programs)
        snapshot, spec = kernel.world.snapshot, motion_spec(message, said)
        if said.rest is not None:
            check_steps(snapshot, said.every, open=True)
            _joints_of(snapshot, said.every)
        joints = joints_of(snapshot, spec.moves) | _joints_of(snapshot, spec.steps)
        if spec.tracking is not None:
            joints = arms_joints(joints, moved_arms(snapshot, spec.every_move))
        return spec, joints, solved_robots(snapshot, spec.every_move)

    if not message.steps:
        return work()
    # Thousands of steps would hold up every other call.
    return await kernel.in_worker(work)


def _joints_of(snapshot: Snapshot, steps: Sequence[Step]) -> set[tuple[int, str]]:
    """Return the joints (robot uid, name) that steps move; raise KernelError that names the step."""
    found: set[tuple[int, str]] = set()
    for number, step in enumerate(steps):
        if isinstance(step, MoveStep):
            try:
                found |= joints_of(snapshot, step.moves)
            except KernelError as error:
                named_error(error, number, step)
                raise
    return found
