"""Planning of a whole motion: from its specification and a snapshot to the command that starts it, step by step.

Each step is planned from where the steps before it leave the joints. Nothing else is predicted: other robots are taken
to stay where they are, and signals have no say in what is planned.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.planned import Plan
from virtualrobot_kernel.motion.program import Program, Stage, Wait, of_plan
from virtualrobot_kernel.motion.signals import SignalValue
from virtualrobot_kernel.planning.blending import PlannedRun, alone_run, join_steps
from virtualrobot_kernel.planning.moves import Move
from virtualrobot_kernel.planning.notes import Note, NoteKind
from virtualrobot_kernel.planning.program import (
    MAX_STEPS,
    DwellStep,
    MotionSpec,
    MoveStep,
    SetSignalStep,
    Step,
    WaitSignalStep,
)
from virtualrobot_kernel.planning.redundancy import NearOf
from virtualrobot_kernel.planning.robots import SolverOf, world_poses
from virtualrobot_kernel.planning.steps import Column, plan_step, plan_steps
from virtualrobot_kernel.planning.together import moved_arms, preconditions_by, search_of
from virtualrobot_kernel.planning.tracking import tracked
from virtualrobot_kernel.world.apply_signals import check_condition, checked, named
from virtualrobot_kernel.world.change import single_joint
from virtualrobot_kernel.world.commands import StartMotion
from virtualrobot_kernel.world.measured import as_commanded
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

GivenUp = Callable[[], bool]
"""True once nobody waits for the plan any more; asked before each step is planned."""

Marks = tuple[tuple[float, str, SignalValue], ...]


@dataclass(frozen=True, slots=True, eq=False)
class PlannedMotion:
    """Start command of a planned motion, and notes on what the planner made otherwise."""

    command: StartMotion
    notes: tuple[Note, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """Stage before the columns of the whole program are known; `joints` names those of its plan."""

    steps: tuple[tuple[float, int], ...]
    plan: Plan | None = None
    joints: tuple[Column, ...] = ()
    tool_states: tuple[tuple[str, str], ...] = ()
    marks: Marks = ()
    wait: Wait | None = None


def plan_motion(
    snapshot: Snapshot,
    spec: MotionSpec,
    solver_of: SolverOf,
    given_up: GivenUp = lambda: False,
    near_of: NearOf | None = None,
) -> PlannedMotion:
    """Return the command that starts a motion; raise KernelError with place and reason if it can't be.

    Errors about a program name the step in message and metadata (`step`, from 0). When `given_up`, the planning ends
    with an error at the next step. `near_of` measures distances for arms that prefer them.
    """
    snapshot = as_commanded(snapshot, world_poses)
    if spec.moves and spec.steps:
        raise KernelError("a motion has either moves or steps, not both", field="steps")
    if spec.steps:
        motion = _program(snapshot, spec, solver_of, given_up, near_of)
    else:
        step = plan_step(snapshot, 0, MoveStep(spec.moves), solver_of, near_of)
        notes = tuple(note for one in step.moves for note in one.notes)
        motion = PlannedMotion(_start(snapshot, spec.moves, alone_run(step)), notes)
    if spec.tracking is None:
        return motion
    arms = moved_arms(snapshot, spec.every_move)
    command = tracked(snapshot, motion.command, spec.tracking, arms, lambda: _go_on(given_up))
    return replace(motion, command=command)


def _start(snapshot: Snapshot, moves: Sequence[Move], run: PlannedRun) -> StartMotion:
    search = search_of(snapshot, moves)
    program = of_plan(run.plan, search.search if search else None)
    tool_states = tuple((0, *pair) for pair in run.tool_states)
    preconditions = preconditions_by(snapshot, moves, run.joints)
    return StartMotion(run.joints, program, tool_states, search.robot if search else "", preconditions)


def _program(
    snapshot: Snapshot, spec: MotionSpec, solver_of: SolverOf, given_up: GivenUp, near_of: NearOf | None
) -> PlannedMotion:
    steps, there = spec.steps, snapshot
    _check(snapshot, steps)

    def go_on() -> None:
        _go_on(given_up)

    parts: list[_Part] = []
    notes: list[Note] = []
    place = 0
    while place < len(steps):
        go_on()
        step = steps[place]
        if isinstance(step, MoveStep):
            members, lonely = _joined(steps, place)
            moves = [_move_step(steps, member) for member in members]
            moves[-1] = replace(moves[-1], zone=None)
            planned = plan_steps(there, moves, solver_of, members, go_on, near_of)
            runs, told = join_steps(planned, go_on)
            parts += [_part(run, steps, members) for run in runs]
            there = planned[-1].arrived()
            notes += [*told, *lonely]
            place = members[-1]
        else:
            parts.append(_standing(step, place))
        place += 1
    notes.sort(key=lambda note: note.step)
    return PlannedMotion(_command(snapshot, spec, parts), tuple(notes))


def _go_on(given_up: GivenUp) -> None:
    if given_up():
        raise KernelError("nobody waits for this plan any more")


def _check(snapshot: Snapshot, steps: Sequence[Step]) -> None:
    """Raise KernelError, which names the step, for what needs no planning to be seen as wrong."""
    if len(steps) > MAX_STEPS:
        raise KernelError(f"a program has at most {MAX_STEPS} steps, not {len(steps)}", steps=len(steps))
    for place, step in enumerate(steps):
        with _at(place):
            if isinstance(step, SetSignalStep):
                checked(named(snapshot.state, step.signal), step.value)
            if isinstance(step, WaitSignalStep):
                check_condition(snapshot.state, step.condition)
            if isinstance(step, MoveStep):
                if step.searches and place < len(steps) - 1:
                    raise KernelError(f"a program may search in its last step only, which is step {len(steps) - 1}")
                search_of(snapshot, step.moves)


def _joined(steps: Sequence[Step], first: int) -> tuple[list[int], list[Note]]:
    """Return the move steps (places) that zones join with the one at `first`, and a note about a zone that joins none.

    Signals may be set between them.
    """
    members = [first]
    while (step := _move_step(steps, members[-1])).zone is not None:
        place = members[-1] + 1
        while place < len(steps) and isinstance(steps[place], SetSignalStep):
            place += 1
        following = steps[place] if place < len(steps) else None
        if isinstance(following, MoveStep) and not following.searches:
            members.append(place)
            continue
        why = "no moves follow" if following is None else f"step {place} waits"
        if isinstance(following, MoveStep):
            why = f"step {place} searches"
        message = f"the corner after step {members[-1]} is reached exactly and at rest: {why}"
        wanted = step.zone.percent or step.zone.meters
        robot = step.moves[0].robot if step.moves else ""
        return members, [Note(NoteKind.ZONE_DROPPED, members[-1], robot, wanted, 0.0, message)]
    return members, []


def _move_step(steps: Sequence[Step], place: int) -> MoveStep:
    step = steps[place]
    assert isinstance(step, MoveStep)
    return step


def _part(run: PlannedRun, steps: Sequence[Step], members: Sequence[int]) -> _Part:
    """Return a run with the signals that are set where one of its steps begins: in the zone's middle, or at rest."""
    marks: list[tuple[float, str, SignalValue]] = []
    for time, number in run.steps:
        place = bisect_left(members, number)
        before = members[place - 1] if place else number
        marks += [
            (time, step.signal, step.value) for step in steps[before + 1 : number] if isinstance(step, SetSignalStep)
        ]
    return _Part(run.steps, run.plan, run.joints, run.tool_states, tuple(marks))


def _standing(step: Step, place: int) -> _Part:
    """Return a step in which nothing moves."""
    here = ((0.0, place),)
    if isinstance(step, SetSignalStep):
        return _Part(here, marks=((0.0, step.signal, step.value),))
    if isinstance(step, WaitSignalStep):
        return _Part(here, wait=Wait(step.timeout, step.condition))
    assert isinstance(step, DwellStep)
    return _Part(here, wait=Wait(step.seconds))


def _command(snapshot: Snapshot, spec: MotionSpec, parts: Sequence[_Part]) -> StartMotion:
    joints = tuple(dict.fromkeys(joint for part in parts for joint in part.joints))
    column = {joint: place for place, joint in enumerate(joints)}
    last = spec.steps[-1]
    search = search_of(snapshot, last.moves) if isinstance(last, MoveStep) else None
    stages = [
        Stage(part.plan, tuple(column[joint] for joint in part.joints), part.steps, part.marks, part.wait)
        for part in parts
    ]
    if search is not None:
        stages[-1] = replace(stages[-1], until=search.search)
    structure = snapshot.structure
    start = [
        snapshot.state.q[single_joint(structure, structure.node(robot, Kind.ROBOT), joint)[1]]
        for robot, joint in joints
    ]
    return StartMotion(
        joints,
        Program(tuple(stages), np.array(start, dtype=np.float64), len(spec.steps)),
        tuple((part.steps[-1][1], *pair) for part in parts for pair in part.tool_states),
        search.robot if search else "",
        preconditions_by(snapshot, spec.every_move, joints),
    )


@contextmanager
def _at(place: int) -> Iterator[None]:
    """Name the step in errors."""
    try:
        yield
    except KernelError as error:
        error.metadata["step"] = str(place)
        error.args = (f"step {place}: {error}",)
        raise
