"""PlanMotion and CheckMotion: the plan of a start, and its violations; nothing moves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.collision import TURN
from virtualrobot_kernel.api.convert.plans import check_message, plan_message
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.motion_calls import find_motion, requested
from virtualrobot_kernel.api.shown_plans import ShownPlan, ShownPlans
from virtualrobot_kernel.collision.clearance import near_by
from virtualrobot_kernel.collision.joint_path import JointPath, of_program
from virtualrobot_kernel.collision.program_sweep import first_of_program
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.collision.swept import RESOLUTION
from virtualrobot_kernel.crafts.carrying import CarriedBases
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.messages.values import expected_revision, not_negative, stamp
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.motion.running_motion import ENDED, Phase
from virtualrobot_kernel.planning.check import FirstContact, check_motion, check_planned
from virtualrobot_kernel.planning.foreseen import after
from virtualrobot_kernel.planning.plan_motion import PlannedMotion, plan_motion
from virtualrobot_kernel.planning.program import GivenUp, MotionSpec
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.planning.sampling import check_size, sample_times, sampled
from virtualrobot_kernel.planning.together import moved_arms
from virtualrobot_kernel.planning.violations import Contact
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.change import joint_places
from virtualrobot_kernel.world.commands import StartMotion
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import check_revision
from virtualrobot_kernel.world.structure import Kind

FINEST, COARSEST = 1e-6, 0.1
"""Least and greatest resolution (m) of a check for collisions."""


async def planned_motion(
    kernel: KernelServices, plans: ShownPlans, request: motion_pb2.PlanMotionRequest
) -> motion_pb2.PlanMotionResponse:
    """Return a motion in samples, planned in a thread on the snapshot of that moment; of one that runs what is left."""
    seconds = _sample_seconds(kernel.world.snapshot, request.sample_seconds)
    if request.motion_id:
        return await kernel.limiter.run_while_wanted((), lambda given_up: _ahead(kernel, request, seconds, given_up))
    shown, said = None, request.spec
    if request.HasField("plan"):
        shown = found_plan(plans, request)
        spec, robots = shown.spec, shown.robots
    else:
        spec, _, asked = await requested(kernel, said)
        robots = frozenset(asked)

    def work(given_up: GivenUp) -> motion_pb2.PlanMotionResponse:
        snapshot = _snapshot(kernel, request)
        if shown is None:
            planned = plan_motion(snapshot, spec, kernel.solvers.of, given_up, near_by(kernel.collisions))
        else:
            snapshot, planned = shown.seen, shown.planned
        program, joints = planned.command.program, planned.command.joints
        arms = moved_arms(snapshot, spec.every_move)
        bases = following(kernel, given_up)(snapshot, program, joints)
        columns = len(joints) + (0 if bases is None else len(bases.places))
        check_size(program.duration, seconds, columns, len({robot for robot, _ in joints}))
        samples = sampled(snapshot, program, joints, sample_times(program.duration, seconds), given_up, arms, bases)
        message = plan_message(samples, planned.notes)
        message.stamp.CopyFrom(stamp(snapshot))
        if kept := shown or plans.keep(snapshot, said, spec, planned, robots, None):
            message.plan.CopyFrom(kept.message)
        return message

    return await kernel.limiter.run_while_wanted(robots, work)


def _ahead(
    kernel: KernelServices, request: motion_pb2.PlanMotionRequest, seconds: float, given_up: GivenUp
) -> motion_pb2.PlanMotionResponse:
    """Return what is planned of a motion that runs, in samples from where it is on its path on."""
    for field in ("spec", "plan"):
        if request.HasField(field):
            raise KernelError(f"say either a motion that runs, `motion_id`, or `{field}`, not both", field="motion_id")
    snapshot = _snapshot(kernel, request)
    motion, structure = find_motion(snapshot, request.motion_id), snapshot.structure
    run = motion.running
    if not isinstance(run, ProgramRun) or run.phase in (*ENDED, Phase.STOPPING) or not run.program.stages:
        phase = motion.phase.value
        raise KernelError(
            f"the motion {motion.id!r} is {phase}, and nothing is planned of it that could be told"
            if isinstance(run, ProgramRun)
            else f"where the motion {motion.id!r} goes is decided as it goes: nothing of it is planned",
            reason=Reason.WRONG_STATE,
            phase=phase,
        )
    now, program = run.left
    joints = [(structure.nodes[robot].name, joint) for robot, joint in motion.joints]
    check_size(program.duration - now, seconds, len(joints), len(motion.robots))
    times = now + sample_times(program.duration - now, seconds)
    samples = sampled(snapshot, program, joints, times, given_up)
    message = plan_message(replace(samples, times=times - now), ())
    message.stamp.CopyFrom(stamp(snapshot))
    return message


async def checked_motion(
    kernel: KernelServices, plans: ShownPlans, request: motion_pb2.CheckMotionRequest
) -> motion_pb2.CheckMotionResponse:
    """Return the check of a motion, or of a plan that was shown, made in a thread on the snapshot of that moment."""
    margin = not_negative(request.min_singular_value, "min_singular_value")
    resolution = _resolution(request.resolution_meters)
    shown, said = None, request.spec
    if request.HasField("plan"):
        shown = found_plan(plans, request)
        said, spec, robots = shown.said, shown.spec, shown.robots
    else:
        spec, _, asked = await requested(kernel, said)
        robots = frozenset(asked)
    turns: set[int | str] = {*robots} if request.ignore_collisions else {*robots, TURN}

    def work(given_up: GivenUp) -> motion_pb2.CheckMotionResponse:
        snapshot = _snapshot(kernel, request)
        follow = following(kernel, given_up)
        looked_for = None if request.ignore_collisions else contact_finder(kernel, resolution, given_up, follow)
        if shown is None:
            near_of = near_by(kernel.collisions)
            checked = check_motion(snapshot, spec, kernel.solvers.of, margin, given_up, looked_for, near_of, follow)
        else:
            check_startable(shown, snapshot)
            checked = check_planned(snapshot, spec, shown.planned, margin, given_up, looked_for, follow)
        message = check_message(checked)
        message.stamp.CopyFrom(stamp(snapshot))
        if checked.first_violation is None and checked.planned is not None:
            exact = None if request.ignore_collisions else resolution
            kept = plans.keep(snapshot, said, spec, checked.planned, robots, exact)
            if kept is not None:
                message.plan.CopyFrom(kept.message)
        return message

    return await kernel.limiter.run_while_wanted(turns, work)


def found_plan(
    plans: ShownPlans,
    request: motion_pb2.StartMotionRequest | motion_pb2.PlanMotionRequest | motion_pb2.CheckMotionRequest,
) -> ShownPlan:
    """Return the plan that a request names; raise KernelError where it says a motion, too."""
    if request.HasField("spec"):
        raise KernelError("say either a motion, `spec`, or a plan, `plan`, not both", field="plan")
    return plans.find(request.plan)


def check_startable(shown: ShownPlan, snapshot: Snapshot) -> None:
    """Raise the error that a start of a plan would be refused with in a world, whatever else stands there."""
    shown.check_path(snapshot)
    apply(snapshot.structure, snapshot.state, [shown.planned.command], world_poses)


async def checked_again(kernel: KernelServices, shown: ShownPlan) -> ShownPlan:
    """Return a plan as one that was checked in the world as it is.

    Raise KernelError (PLAN_OUTDATED) where its path would be another one there, or where it violates something.
    """
    shown.check_path(kernel.world.snapshot)
    if shown.is_surrounded_in(kernel.world.snapshot):
        return shown

    def work(given_up: GivenUp) -> ShownPlan:
        snapshot = kernel.world.snapshot
        check_startable(shown, snapshot)
        differences = [] if shown.surroundings is None else shown.surroundings.differences(snapshot)
        follow = following(kernel, given_up)
        finder = contact_finder(kernel, shown.resolution, given_up, follow)
        found = check_planned(snapshot, shown.spec, shown.planned, 0.0, given_up, finder, follow).first_violation
        if found is not None and differences:
            raise shown.outdated(differences, found)
        return shown.checked_in(snapshot, shown.resolution)

    return await kernel.limiter.run_while_wanted({*shown.robots, TURN}, work)


def contact_finder(kernel: KernelServices, resolution: float, given_up: GivenUp, follow: Follow) -> FirstContact:
    """Return what finds the first contact of a motion, with the bases that it moves."""

    def first_contact(snapshot: Snapshot, command: StartMotion, until: float) -> Contact | None:
        bases = follow(snapshot, command.program, command.joints)
        with kernel.collisions.scene() as scene:
            return contact_of(scene, snapshot, command, until, resolution, given_up, bases)

    return first_contact


def check_for_real_robot(
    kernel: KernelServices, snapshot: Snapshot, spec: MotionSpec, planned: PlannedMotion, given_up: GivenUp
) -> None:
    """Check a planned motion as a whole that a real robot will play; raise KernelError with its first violation."""
    follow = following(kernel, given_up)
    finder = contact_finder(kernel, RESOLUTION, given_up, follow)
    found = check_planned(snapshot, spec, planned, 0.0, given_up, finder, follow).first_violation
    if found is None:
        return
    first, second = ("", "") if found.contact is None else (name for name, _ in found.contact)
    raise KernelError(
        f"a real robot would play this, and nothing was sent: {found.message}",
        reason=Reason.LIMIT_EXCEEDED if found.contact is None else Reason.COLLISION,
        **({} if found.contact is None else {"first": first, "second": second}),
        robot=found.robot,
        step=found.step,
    )


def contact_of(
    scene: CollisionScene,
    snapshot: Snapshot,
    command: StartMotion,
    until: float,
    resolution: float,
    given_up: GivenUp,
    bases: CarriedBases | None = None,
) -> Contact | None:
    """Return the first contact of a motion that starts in a snapshot, before a time of it (s); None: there is none.

    `bases` has the bases that its drives move.
    """
    structure = snapshot.structure
    joints = tuple((structure.node(robot, Kind.ROBOT).uid, joint) for robot, joint in command.joints)
    q_index = joint_places(structure, joints)[0]
    tool_states = [(step, structure.node(tool).uid, state) for step, tool, state in command.tool_states]
    worlds = after(snapshot, command.joints, command.program)
    path = None
    if bases is not None:
        path = JointPath(0.0, command.program.duration, bases.at, bases.travel, bases.wobble)
    found = first_of_program(scene, worlds, command.program, q_index, tool_states, until, resolution, given_up, path)
    if found is None:
        return None
    return Contact(found.time, found.first, found.second, found.distance, resolution, found.points)


Follow = Callable[[Snapshot, Program, Sequence[tuple[str, str]]], CarriedBases | None]
"""Function that tells where a program takes the bases of crafts (`planning/carried_bases.py`)."""


def following(kernel: KernelServices, given_up: GivenUp) -> Follow:
    """Return what tells where a program takes the bases of crafts (`planning/carried_bases.py`), each found once."""
    found: dict[int, tuple[Program, CarriedBases | None]] = {}

    def follow(snapshot: Snapshot, program: Program, joints: Sequence[tuple[str, str]]) -> CarriedBases | None:
        if id(program) not in found:
            structure = snapshot.structure
            named = tuple((structure.node(robot, Kind.ROBOT).uid, joint) for robot, joint in joints)
            path = of_program(snapshot.state.q, joint_places(structure, named)[0], program)
            carried = kernel.crafts.carried(structure, path.at, path.travel, program.begins, given_up)
            found[id(program)] = program, carried
        return found[id(program)][1]

    return follow


def _resolution(meters: float) -> float:
    """Return the resolution (m) that is asked for; raise KernelError for one that makes no sense."""
    if meters != 0.0 and not FINEST <= meters <= COARSEST:
        raise KernelError(
            f"resolution_meters must be 0, which means {RESOLUTION:g}, or {FINEST:g} to {COARSEST:g}, not {meters:g}",
            field="resolution_meters",
        )
    return meters or RESOLUTION


def _snapshot(
    kernel: KernelServices, request: motion_pb2.PlanMotionRequest | motion_pb2.CheckMotionRequest
) -> Snapshot:
    """Return the world as it is; raise KernelError when the request is meant for another one."""
    snapshot = kernel.world.snapshot
    check_revision(snapshot.structure, expected_revision(request))
    return snapshot


def _sample_seconds(snapshot: Snapshot, seconds: float) -> float:
    """Return the time between samples in s; raise KernelError for less than a tick."""
    tick = snapshot.tick_seconds
    if not_negative(seconds, "sample_seconds") and seconds < tick * (1.0 - 1e-9):
        raise KernelError(
            f"sample_seconds must be 0 (a tick) or at least a tick, {tick:g} s, not {seconds:g}", field="sample_seconds"
        )
    return seconds or tick
