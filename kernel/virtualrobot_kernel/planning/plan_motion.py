"""Planning of a whole motion: from its specification and a snapshot to the command that starts it, step by step.

Each step is planned from where the steps before it leave the joints. Nothing else is predicted: other robots are taken
to stay where they are, and signals have no say in what is planned.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.program import Program, Stage, Wait, of_plan
from virtualrobot_kernel.planning.blending import PlannedRun, alone_run
from virtualrobot_kernel.planning.foreseen import World, after
from virtualrobot_kernel.planning.moves import JointTrajectory, Move
from virtualrobot_kernel.planning.names import named_nodes, named_signals
from virtualrobot_kernel.planning.notes import Note
from virtualrobot_kernel.planning.program import (
    GivenUp,
    MotionSpec,
    MoveStep,
    OrderStep,
    Step,
    WaitPartStep,
    slowed,
    step_name,
)
from virtualrobot_kernel.planning.redundancy import NearOf
from virtualrobot_kernel.planning.robots import SolverOf, world_poses
from virtualrobot_kernel.planning.stages import Part, Tools, check_steps, deferred, plan_parts
from virtualrobot_kernel.planning.steps import Column, plan_step
from virtualrobot_kernel.planning.tcp_speed import kept, slower, slower_moves
from virtualrobot_kernel.planning.together import joints_of, moved_arms, preconditions_by, search_of
from virtualrobot_kernel.planning.tracking import tracked
from virtualrobot_kernel.world.change import single_joint
from virtualrobot_kernel.world.commands import StartMotion
from virtualrobot_kernel.world.measured import as_commanded
from virtualrobot_kernel.world.preconditions import Precondition, Preconditions, holds
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind
from virtualrobot_kernel.world.tcp import refuse_limited
from virtualrobot_kernel.world.tolerances import AwaitedJoints


@dataclass(frozen=True, slots=True, eq=False)
class PlannedMotion:
    """Start command of a planned motion, notes on what the planner made otherwise, and the run that may be extended."""

    command: StartMotion
    notes: tuple[Note, ...]
    end: PlannedRun | None = None


def plan_motion(
    snapshot: Snapshot,
    spec: MotionSpec,
    solver_of: SolverOf,
    given_up: GivenUp = lambda: False,
    near_of: NearOf | None = None,
    *,
    open: bool = False,
) -> PlannedMotion:
    """Return the command that starts a motion; raise KernelError with place and reason if it can't be.

    Errors about a program name the step in message and metadata (`step`, from 0). When `given_up`, the planning ends
    with an error at the next step. `near_of` measures distances for arms that prefer them. To an `open` program more
    may be appended. It is as slow as the speed limits of tool centre points want it.
    """
    snapshot = as_commanded(snapshot, world_poses)
    if spec.tracking is not None:
        refuse_limited(snapshot.structure, snapshot.state, (uid for uid, _ in joints_of(snapshot, spec.every_move)))

    def plan(factor: float) -> PlannedMotion:
        slow = replace(spec, moves=slower_moves(spec.moves, factor), steps=slower(spec.steps, factor))
        return _plan_motion(snapshot, slow, solver_of, given_up, near_of, open=open)

    return kept(snapshot, plan, lambda planned: planned.command)


def _plan_motion(
    snapshot: Snapshot,
    spec: MotionSpec,
    solver_of: SolverOf,
    given_up: GivenUp,
    near_of: NearOf | None,
    *,
    open: bool,
) -> PlannedMotion:
    """Return the command that starts a motion, whose moves are as fast as they say."""
    if spec.moves and spec.steps:
        raise KernelError("a motion has either moves or steps, not both", field="steps")
    if open and (not spec.steps or spec.tracking is not None):
        raise KernelError("only a program of steps that goes along with no frame can be open", field="open")
    go_on = waited_for(given_up)
    check_alone(spec)
    if spec.steps:
        steps, speeds = slowed(spec.steps)
        check_steps(snapshot, steps, open=open)
        parts, notes, end = plan_parts(snapshot, steps, Tools(solver_of, go_on, near_of), open=open)
        frame = Program((), np.zeros(0), len(steps), open, speeds=speeds, outer_count=spec.outer_count or len(steps))
        command = planned_command(snapshot, parts, steps, frame)
        if spec.deferred:
            command = replace(command, nodes=named_nodes(spec.deferred), signals=named_signals(spec.deferred))
            notes.append(deferred(steps[-1], len(steps) - 1))
        motion = PlannedMotion(command, tuple(notes), end)
    else:
        moves = tuple(replace(one, from_motion=True) if isinstance(one, JointTrajectory) else one for one in spec.moves)
        step = plan_step(snapshot, 0, MoveStep(moves), solver_of, near_of)
        notes = tuple(note for one in step.moves for note in one.notes)
        motion = PlannedMotion(_start(snapshot, spec.moves, alone_run(step)), notes)
    if spec.tracking is None:
        return motion
    arms = moved_arms(snapshot, spec.every_move)
    return replace(motion, command=tracked(snapshot, motion.command, spec.tracking, arms, go_on))


def waited_for(given_up: GivenUp) -> Callable[[], None]:
    """Return what raises KernelError once nobody waits for the plan any more."""

    def go_on() -> None:
        if given_up():
            raise KernelError("nobody waits for this plan any more")

    return go_on


def _start(snapshot: Snapshot, moves: Sequence[Move], run: PlannedRun) -> StartMotion:
    search = search_of(snapshot, moves)
    program = of_plan(run.plan, search.search if search else None)
    tool_states = tuple((0, *pair) for pair in run.tool_states)
    preconditions = preconditions_by(snapshot, moves, run.joints)
    command = StartMotion(run.joints, program, tool_states, search.robot if search else "", preconditions)
    first, *others = moves
    if others or not isinstance(first, JointTrajectory):
        return command
    if (goal := first.tolerances.goal) is not None:
        uid = first.node(snapshot).uid
        awaited = AwaitedJoints(tuple((uid, joint) for joint in first.joints), run.plan.goal, goal)
        wait = Wait(first.tolerances.goal_seconds, cause="GOAL_TOLERANCE")
        stage = Stage(None, (), ((0.0, 0),), wait=wait, orders=(awaited,))
        command = replace(command, program=replace(program, stages=(*program.stages, stage)))
    return replace(command, from_here=first.from_here(snapshot), path_tolerances=first.tolerances.path)


def check_alone(spec: MotionSpec) -> None:
    """Raise KernelError for a trajectory that must be the only move of its motion, or of its step, and is not."""
    groups = [(spec.moves, "motion"), *((step.moves, "step") for step in spec.steps if isinstance(step, MoveStep))]
    for moves, whole in groups:
        for move in moves:
            if not isinstance(move, JointTrajectory):
                continue
            if move.alone and (len(moves) > 1 or whole == "step" or spec.tracking is not None):
                raise KernelError(
                    f"a trajectory with {move.alone} is the only move of its motion, which has no steps and goes along "
                    "with no frame",
                    field=move.alone,
                    robot=move.robot,
                )
            if move.segments and (len(moves) > 1 or spec.tracking is not None):
                raise KernelError(
                    f"a trajectory of SEGMENTS keeps its times, so it is the only move of its {whole} and goes along "
                    "with no frame",
                    field="interpolation",
                    robot=move.robot,
                )


def planned_command(
    there: Snapshot,
    parts: Sequence[Part],
    steps: Sequence[Step],
    frame: Program,
    own: Sequence[Column] = (),
    before: Program | None = None,
    now: Snapshot | None = None,
) -> StartMotion:
    """Return the command that starts the parts of these steps in a world, where `own` joints are its first columns.

    frame: all else that the program says. before: the program that they are appended to, and `now` the world in which
    the command will be given, where these are.
    """
    joints = tuple(dict.fromkeys([*own, *(joint for part in parts for joint in part.joints)]))
    columns = {joint: place for place, joint in enumerate(joints)}
    last = steps[-1] if steps else None
    search = search_of(there, last.moves) if isinstance(last, MoveStep) else None
    paths = _paths(parts, steps, frame.step_count - len(steps), before)
    stages = [part.stage(columns, paths) for part in parts]
    if search is not None:
        stages[-1] = replace(stages[-1], until=search.search)
    structure = there.structure
    start = [
        there.state.q[single_joint(structure, structure.node(robot, Kind.ROBOT), joint)[1]] for robot, joint in joints
    ]
    program = replace(frame, stages=tuple(stages), start=np.array(start, dtype=np.float64))
    return StartMotion(
        joints,
        program,
        tuple((part.steps[-1][1], *pair) for part in parts for pair in part.tool_states),
        search.robot if search else "",
        _assumed(now or there, after(there, joints, program), parts, steps),
    )


def _paths(parts: Sequence[Part], steps: Sequence[Step], first: int, before: Program | None) -> dict[int, str]:
    """Return what the program's text calls the steps of parts, by number; nothing where it has no names for them."""
    if not any(step.path for step in steps):
        return {}

    def name(number: int) -> str:
        if number < first:
            return before.path_of(number) if before else ""
        return step_name(steps[number - first], number)

    return {number: name(number) for part in parts for _, number in part.steps}


def _assumed(now: Snapshot, worlds: Sequence[World], parts: Sequence[Part], steps: Sequence[Step]) -> Preconditions:
    """Return what steps assume of the world as it is, where their own orders make `worlds` of it.

    What the orders themselves change is no assumption.
    """
    moved = dict.fromkeys(joint for part in parts for joint in part.joints)
    found: dict[tuple[object, ...], Precondition] = {}
    moves: list[Move] = []
    place = 0
    for step in [*steps, None]:
        if isinstance(step, MoveStep):
            moves += step.moves
        if step is not None and not isinstance(step, (OrderStep, WaitPartStep)):
            continue
        world = worlds[place][1] if place else now
        for fact in preconditions_by(world, moves, moved):
            if not place or holds(fact, now.structure, now.state):
                found.setdefault((fact.uid, fact.aspect, fact.key), fact)
        moves, place = [], place + 1
    return tuple(found.values())
