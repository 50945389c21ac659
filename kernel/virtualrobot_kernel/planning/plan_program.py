"""From what a motion shall do, and a snapshot, to the command that starts it: programs step by step.

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
from virtualrobot_kernel.planning.blending import PlannedRun, arrived, plan_run, run_together
from virtualrobot_kernel.planning.moves import moved_arms, plan_moves, preconditions_by, search_of
from virtualrobot_kernel.planning.notes import Note, NoteKind
from virtualrobot_kernel.planning.program import (
    MAX_STEPS,
    DwellWish,
    MotionWish,
    MoveStepWish,
    SetSignalWish,
    StepWish,
    WaitSignalWish,
)
from virtualrobot_kernel.planning.robots import SolverOf, world_poses
from virtualrobot_kernel.planning.tracking import tracked
from virtualrobot_kernel.planning.wishes import Move
from virtualrobot_kernel.world.apply_signals import check_condition, checked, named
from virtualrobot_kernel.world.change import single_joint
from virtualrobot_kernel.world.commands import StartMotion
from virtualrobot_kernel.world.measured import as_commanded
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

GivenUp = Callable[[], bool]
"""Whether nobody waits for the plan any more; asked before each step is planned."""

Column = tuple[str, str]
"""Robot and joint."""

Marks = tuple[tuple[float, str, SignalValue], ...]


@dataclass(frozen=True, slots=True, eq=False)
class PlannedMotion:
    """The command that starts a motion, and what the planner made other than it was asked to."""

    command: StartMotion
    notes: tuple[Note, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """A stage before the columns of the whole program are known; `joints` names those of its plan."""

    steps: tuple[tuple[float, int], ...]
    plan: Plan | None = None
    joints: tuple[Column, ...] = ()
    tool_states: tuple[tuple[str, str], ...] = ()
    marks: Marks = ()
    wait: Wait | None = None


def plan_wish(
    snapshot: Snapshot, wish: MotionWish, solver_of: SolverOf, given_up: GivenUp = lambda: False
) -> PlannedMotion:
    """Return the command that starts a motion; raise KernelError with place and reason if it can't be.

    Errors about a program name the step in message and metadata (`step`, from 0). When `given_up`, the planning ends
    with an error at the next step.
    """
    snapshot = as_commanded(snapshot, world_poses)
    if wish.moves and wish.steps:
        raise KernelError("a motion has either moves or steps, not both", field="steps")
    if wish.steps:
        motion = _program(snapshot, wish, solver_of, given_up)
    else:
        planned = plan_moves(snapshot, wish.moves, solver_of)
        notes = tuple(note for one in planned for note in one.notes)
        run = run_together(snapshot, MoveStepWish(wish.moves), planned)
        motion = PlannedMotion(_start(snapshot, wish.moves, run), notes)
    if wish.tracking is None:
        return motion
    command = tracked(
        snapshot, motion.command, wish.tracking, moved_arms(snapshot, wish.every_move), lambda: _go_on(given_up)
    )
    return replace(motion, command=command)


def _start(snapshot: Snapshot, moves: Sequence[Move], run: PlannedRun) -> StartMotion:
    search = search_of(snapshot, moves)
    program = of_plan(run.plan, search.until if search else None)
    tool_states = tuple((0, *pair) for pair in run.tool_states)
    preconditions = preconditions_by(snapshot, moves, run.joints)
    return StartMotion(run.joints, program, tool_states, search.robot if search else "", preconditions)


def _program(snapshot: Snapshot, wish: MotionWish, solver_of: SolverOf, given_up: GivenUp) -> PlannedMotion:
    steps, there = wish.steps, snapshot
    _check(snapshot, steps)

    parts: list[_Part] = []
    notes: list[Note] = []
    place = 0
    while place < len(steps):
        _go_on(given_up)
        step = steps[place]
        if isinstance(step, MoveStepWish):
            members, lonely = _joined(steps, place)
            wishes = [_move_step(steps, member) for member in members]
            wishes[-1] = replace(wishes[-1], zone=None)
            runs, told = plan_run(there, wishes, solver_of, members, lambda: _go_on(given_up))
            for run in runs:
                parts.append(_part(run, steps, members))
                there = arrived(there, run.joints, run.plan.goal)
            notes += [*told, *lonely]
            place = members[-1]
        else:
            parts.append(_standing(step, place))
        place += 1
    notes.sort(key=lambda note: note.step)
    return PlannedMotion(_command(snapshot, wish, parts), tuple(notes))


def _go_on(given_up: GivenUp) -> None:
    if given_up():
        raise KernelError("nobody waits for this plan any more")


def _check(snapshot: Snapshot, steps: Sequence[StepWish]) -> None:
    """Raise KernelError, which names the step, for what needs no planning to be seen as wrong."""
    if len(steps) > MAX_STEPS:
        raise KernelError(f"a program has at most {MAX_STEPS} steps, not {len(steps)}", steps=len(steps))
    for place, step in enumerate(steps):
        with _at(place):
            if isinstance(step, SetSignalWish):
                checked(named(snapshot.state, step.signal), step.value)
            if isinstance(step, WaitSignalWish):
                check_condition(snapshot.state, step.condition)
            if isinstance(step, MoveStepWish):
                if step.searches and place < len(steps) - 1:
                    raise KernelError(f"a program may search in its last step only, which is step {len(steps) - 1}")
                search_of(snapshot, step.moves)


def _joined(steps: Sequence[StepWish], first: int) -> tuple[list[int], list[Note]]:
    """Return the move steps (places) that zones join with the one at `first`, and a note about a zone that joins none.

    Signals may be set between them.
    """
    members = [first]
    while (step := _move_step(steps, members[-1])).zone is not None:
        place = members[-1] + 1
        while place < len(steps) and isinstance(steps[place], SetSignalWish):
            place += 1
        following = steps[place] if place < len(steps) else None
        if isinstance(following, MoveStepWish) and not following.searches:
            members.append(place)
            continue
        why = "no moves follow" if following is None else f"step {place} waits"
        if isinstance(following, MoveStepWish):
            why = f"step {place} searches"
        message = f"the corner after step {members[-1]} is reached exactly and at rest: {why}"
        wanted = step.zone.percent or step.zone.meters
        robot = step.moves[0].robot if step.moves else ""
        return members, [Note(NoteKind.ZONE_DROPPED, members[-1], robot, wanted, 0.0, message)]
    return members, []


def _move_step(steps: Sequence[StepWish], place: int) -> MoveStepWish:
    step = steps[place]
    assert isinstance(step, MoveStepWish)
    return step


def _part(run: PlannedRun, steps: Sequence[StepWish], members: Sequence[int]) -> _Part:
    """Return a run with the signals that are set where one of its steps begins: in the zone's middle, or at rest."""
    marks: list[tuple[float, str, SignalValue]] = []
    for time, number in run.steps:
        place = bisect_left(members, number)
        before = members[place - 1] if place else number
        marks += [
            (time, step.signal, step.value) for step in steps[before + 1 : number] if isinstance(step, SetSignalWish)
        ]
    return _Part(run.steps, run.plan, run.joints, run.tool_states, tuple(marks))


def _standing(step: StepWish, place: int) -> _Part:
    """Return a step in which nothing moves."""
    here = ((0.0, place),)
    if isinstance(step, SetSignalWish):
        return _Part(here, marks=((0.0, step.signal, step.value),))
    if isinstance(step, WaitSignalWish):
        return _Part(here, wait=Wait(step.timeout, step.condition))
    assert isinstance(step, DwellWish)
    return _Part(here, wait=Wait(step.seconds))


def _command(snapshot: Snapshot, wish: MotionWish, parts: Sequence[_Part]) -> StartMotion:
    joints = tuple(dict.fromkeys(joint for part in parts for joint in part.joints))
    column = {joint: place for place, joint in enumerate(joints)}
    last = wish.steps[-1]
    search = search_of(snapshot, last.moves) if isinstance(last, MoveStepWish) else None
    stages = [
        Stage(part.plan, tuple(column[joint] for joint in part.joints), part.steps, part.marks, part.wait)
        for part in parts
    ]
    if search is not None:
        stages[-1] = replace(stages[-1], until=search.until)
    structure = snapshot.structure
    start = [
        snapshot.state.q[single_joint(structure, structure.node(robot, Kind.ROBOT), joint)[1]]
        for robot, joint in joints
    ]
    return StartMotion(
        joints,
        Program(tuple(stages), np.array(start, dtype=np.float64), len(wish.steps)),
        tuple((part.steps[-1][1], *pair) for part in parts for pair in part.tool_states),
        search.robot if search else "",
        preconditions_by(snapshot, wish.every_move, joints),
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
