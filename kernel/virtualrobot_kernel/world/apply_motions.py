"""Commands about motions: start a planned one, pause, resume, cancel, stop."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.motion import program_run, tracking_motion
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.world import preconditions
from virtualrobot_kernel.world.actuators import coupled_joints
from virtualrobot_kernel.world.apply_robots import tool_state
from virtualrobot_kernel.world.apply_signals import check_program, named
from virtualrobot_kernel.world.change import (
    Change,
    Forward,
    check_joint_value,
    joint_places,
    place_of,
    refuse_while_moving,
    single_joint,
)
from virtualrobot_kernel.world.commands import (
    AppendMotion,
    CancelMotion,
    FromHere,
    GoOn,
    PauseMotion,
    PickPart,
    PlacePart,
    ResumeMotion,
    SelectTool,
    StartMotion,
    StepMotion,
    StopMotions,
    StopRobots,
)
from virtualrobot_kernel.world.crafts import refuse_base
from virtualrobot_kernel.world.from_here import program_from_here, replaced_by, taken_over
from virtualrobot_kernel.world.history_commands import PlayedTicks, RestartWorld
from virtualrobot_kernel.world.measured import commanded
from virtualrobot_kernel.world.motored import refuse_unmotored
from virtualrobot_kernel.world.state import Cancellation, EndCause, Motion, State

START_TOLERANCE = 1e-6
"""Greatest distance of a joint from its plan's start, in radians or meters."""

SLOWEST = 1e-9
"""Least speed factor of a motion: products of tiny ones would be rounded to zero, which no motion understands."""


def start_motion(change: Change, command: StartMotion, forward: Forward) -> Change:
    """Start a planned motion where the joints are; refused when they move, or when it was planned for another world.

    One `from_here` may take over from motions that are on their way.
    """
    id = f"motion-{change.state.motion_count + 1}"
    if command.from_here is not None:
        change, command = _from_here(change, command, command.from_here, id)
    structure, state, program = change.structure, change.state, command.program
    motion = Motion(
        id=id,
        robots=(),
        joints=(),
        q_index=np.zeros(0, np.int32),
        v_index=np.zeros(0, np.int32),
        running=program_run.start(program, 1.0),
        start_tick=state.tick,
    )
    motion = _taken_on(change, motion, command)
    started = program_run.start(program, override(state, motion))
    if (tracking := command.tracking) is None:
        motion = replace(motion, running=started)
    else:
        tracked_joint = structure.robot(tracking.robot)[0].uid, tracking.joint
        motion = replace(
            motion,
            running=tracking_motion.start(started, tracking.law),
            tracked_joint=tracked_joint,
            tracked_at=place_of(structure, *tracked_joint),
        )
    state = replace(state, motions=(*state.motions, motion), motion_count=state.motion_count + 1)
    return replace(change, state=state, created=(*change.created, id))


def _from_here(change: Change, command: StartMotion, from_here: FromHere, id: str) -> tuple[Change, StartMotion]:
    """Return the world without the motions that this one takes over from, and the start with its plan made anew."""
    structure, state = change.structure, change.state
    joints = tuple((structure.robot(robot)[0].uid, joint) for robot, joint in command.joints)
    in_the_way = taken_over(change, joints) if from_here.replaces else ()
    rate = override_of(state, structure.with_holders(dict.fromkeys(uid for uid, _ in joints)))
    command = replace(command, program=program_from_here(change, command, from_here, rate))
    for motion in in_the_way:
        change = replaced(change, replaced_by(motion, id))
    return change, command


def append_motion(change: Change, command: AppendMotion, forward: Forward) -> Change:
    """Append stages to an open program; refused when it has been closed, is stopping, or is past where they join it."""
    motion = running_motion(change.state, command.id)
    run, later = open_program(motion), None
    if run.program.step_count == command.step_count:
        later = run.append(command.more.program, command.cut)
    if later is None:
        raise KernelError(
            f"{motion.id!r} has gone on, or become longer, since the steps were planned; append them again",
            reason=Reason.PLAN_OUTDATED,
            motion=motion.id,
        )
    return replaced(change, replace(_taken_on(change, motion, command.more), running=later))


def go_on(change: Change, command: GoOn, forward: Forward) -> Change:
    """Let a motion go on whose orders were done; the world thread alone gives this command."""
    motion = running_motion(change.state, command.id)
    if not motion.running.orders:
        raise KernelError(f"{motion.id!r} waits for no order", reason=Reason.WRONG_STATE, motion=motion.id)
    return replaced(change, replace(motion, running=motion.running.obeyed()))


def open_program(motion: Motion) -> ProgramRun:
    """Return the state of a motion to which steps may be appended; raise KernelError (WRONG_STATE) for another one."""
    run = motion.running
    if isinstance(run, ProgramRun) and run.program.open and run.phase is not Phase.STOPPING:
        return run
    what = "it stops" if run.phase is Phase.STOPPING else "it was not started as an open program, or has been closed"
    raise KernelError(
        f"nothing can be appended to {motion.id!r}: {what}",
        reason=Reason.WRONG_STATE,
        motion=motion.id,
    )


def is_known(motion: Motion) -> bool:
    """Return whether all that a motion may yet do is known: no setpoints, no steps that are planned or come later."""
    run = motion.running
    return isinstance(run, ProgramRun) and not (run.program.open or motion.nodes or motion.searcher)


def _taken_on(change: Change, motion: Motion, command: StartMotion) -> Motion:
    """Return a motion with the joints and all else of a plan; refuse one that was made for another world.

    Joints that are the motion's own already are where its program has them.
    """
    structure, state, program = change.structure, change.state, command.program
    joints = tuple((structure.robot(robot)[0].uid, joint) for robot, joint in command.joints)
    own = len(motion.joints)
    refuse_base(structure, joints[own:])
    refuse_unmotored(structure, state, joints[own:])
    for (robot, name), *ends in zip(command.joints, program.lowest.tolist(), program.highest.tolist(), strict=True):
        # Limits may have changed since the motion was planned.
        joint = single_joint(structure, structure.robot(robot)[0], name)[0]
        for end in ends:
            check_joint_value(robot, joint, end)
    check_program(state, program)
    needed = coupled_joints(structure, joints[own:]) - set(motion.joints)
    for uid in dict.fromkeys(uid for uid, _ in joints[own:]):
        refuse_while_moving(change, structure.nodes[uid], {joint for joint in needed if joint[0] == uid})
    q_index, v_index, rated = joint_places(structure, joints)
    here = commanded(structure, state)[0][q_index]
    off = np.abs(here - program.start)[own:]
    if len(off) and off.max() > START_TOLERANCE:
        worst = own + int(off.argmax())
        robot, joint = command.joints[worst]
        raise KernelError(
            f"the joint {joint!r} of {robot!r} is at {here[worst]:g}, but the motion was planned from "
            f"{program.start[worst]:g}; plan again",
            reason=Reason.PLAN_OUTDATED,
            robot=robot,
            joint=joint,
        )
    preconditions.check(command.preconditions, structure, state)
    tool_states = tuple((at, tool_state(structure, tool, name)[0].uid, name) for at, tool, name in command.tool_states)
    owners = [robot.uid for _, tool, _ in tool_states if (robot := structure.robot_of(tool))]
    owners += [structure.robot(name)[0].uid for name in ordered_robots(program)]
    return replace(
        motion,
        robots=structure.with_holders([*motion.robots, *(uid for uid, _ in joints), *owners]),
        joints=joints,
        q_index=q_index,
        v_index=v_index,
        rated=rated,
        tool_states=(*motion.tool_states, *tool_states),
        step_count=program.step_count,
        signals=motion.signals | program.signals | {named(state, name).name for name in command.signals},
        nodes=motion.nodes | {structure.node(name).uid for name in command.nodes},
        searcher=structure.robot(command.searcher)[0].uid if command.searcher else 0,
        path_tolerances=command.path_tolerances,
    )


def ordered_robots(program: Program) -> list[str]:
    """Return the robots (names) that the orders of a program are for."""
    orders = (order for stage in program.stages for order in stage.orders)
    return list(dict.fromkeys(order.robot for order in orders if isinstance(order, (PickPart, PlacePart, SelectTool))))


def override(state: State, motion: Motion) -> float:
    """Return the speed factor of a motion: that of all, times the least of its robots', at least `SLOWEST`."""
    return override_of(state, motion.robots)


def override_of(state: State, robots: Iterable[int]) -> float:
    """Return the speed factor of a motion of some robots (uids)."""
    factor = state.speed_factor
    if state.speed_factors:
        factor *= min((state.speed_factors.get(uid, 1.0) for uid in robots), default=1.0)
    return max(factor, SLOWEST)


def pause_motion(change: Change, command: PauseMotion, forward: Forward) -> Change:
    """Slow a motion to standstill; a paused one stays paused."""
    motion = running_motion(change.state, command.id)
    return replaced(change, replace(motion, running=motion.running.pause()))


def resume_motion(change: Change, command: ResumeMotion, forward: Forward) -> Change:
    """Resume a motion that was paused; one that runs stays as it is."""
    motion = running_motion(change.state, command.id)
    return replaced(change, replace(motion, running=motion.running.resume()))


def step_motion(change: Change, command: StepMotion, forward: Forward) -> Change:
    """Let a motion go on to the end of its present step, and pause there."""
    motion = running_motion(change.state, command.id)
    return replaced(change, replace(motion, running=motion.running.step()))


def cancel_motion(change: Change, command: CancelMotion, forward: Forward) -> Change:
    """Slow a motion to standstill and end it."""
    motion = running_motion(change.state, command.id)
    return replaced(change, _cancelled(motion, command.cancellation))


def stop_motions(change: Change, command: StopMotions, forward: Forward) -> Change:
    """Cancel all motions of some robots, or of all."""
    robots = {change.structure.robot(name)[0].uid for name in command.robots}
    cancellation = Cancellation(EndCause.STOP, command.reason)
    return all_cancelled(change, robots or None, cancellation)


def stop_robots(change: Change, command: StopRobots, forward: Forward) -> Change:
    """Cancel all motions of some robots, given by uid."""
    return all_cancelled(change, set(command.robots), command.cancellation)


def note_played(change: Change, command: PlayedTicks, forward: Forward) -> Change:
    """Change nothing: what a real robot has played is kept by the journal alone."""
    return change


def restart_world(change: Change, command: RestartWorld, forward: Forward) -> Change:
    """Abort all motions where the joints are, which are at rest and commanded from now on; the epoch rises."""
    state = change.state
    why = Cancellation(EndCause.KERNEL_RESTARTED, "the kernel was started again")
    aborted = tuple(
        replace(motion, running=motion.running.abort(), cancellation=why, end_tick=state.tick)
        for motion in state.motions
    )
    return replace(
        change,
        state=replace(
            state,
            v=np.zeros_like(state.v),
            commanded={},
            readings={},
            motored={},
            efforts={},
            dynamics=None,
            motions=(),
            ended=(*state.ended, *aborted),
            epoch=state.epoch + 1,
        ),
    )


def all_cancelled(change: Change, robots: set[int] | None, cancellation: Cancellation) -> Change:
    """Cancel every motion that moves one of these robots (None: every motion); motors exert no effort of their own."""
    if efforts := change.state.efforts:
        kept = {uid: one for uid, one in efforts.items() if robots is not None and uid not in robots}
        change = replace(change, state=replace(change.state, efforts=kept))
    for motion in change.state.motions:
        if robots is None or not robots.isdisjoint(motion.robots):
            change = replaced(change, _cancelled(motion, cancellation))
    return change


def _cancelled(motion: Motion, cancellation: Cancellation) -> Motion:
    if motion.running.ended:  # it had no length, and succeeds with the next tick
        return motion
    return replace(motion, running=motion.running.cancel(), cancellation=motion.cancellation or cancellation)


def running_motion(state: State, id: str) -> Motion:
    """Return a motion that has not ended; raise KernelError (WRONG_STATE) for one that has, and for unknown ones."""
    for motion in state.motions:
        if motion.id == id:
            return motion
    for motion in state.ended:
        if motion.id == id:
            raise KernelError(f"the motion {id!r} has ended", reason=Reason.WRONG_STATE, motion=id)
    raise UnknownNameError("running motion", id, (motion.id for motion in state.motions))


def replaced(change: Change, motion: Motion) -> Change:
    """Return the world with a motion in place of the one with its id; one that has ended moves no joint any more."""
    state = change.state
    if motion.running.phase is Phase.CANCELLED:
        motions = tuple(other for other in state.motions if other.id != motion.id)
        ended = (*state.ended, replace(motion, end_tick=state.tick))
        return replace(change, state=replace(state, motions=motions, ended=ended))
    motions = tuple(motion if other.id == motion.id else other for other in state.motions)
    return replace(change, state=replace(state, motions=motions))
