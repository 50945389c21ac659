"""Planning of steps that are appended to a program: from where it will end, joined to its last step if possible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.program import Program, Stage
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.planning.blending import PlannedRun, dropped
from virtualrobot_kernel.planning.extend_run import extended
from virtualrobot_kernel.planning.foreseen import after
from virtualrobot_kernel.planning.marks import marked, moved, settings
from virtualrobot_kernel.planning.notes import Note
from virtualrobot_kernel.planning.plan_motion import planned_command, waited_for
from virtualrobot_kernel.planning.program import MAX_STEPS, PASSED, GivenUp, MoveStep, Step, slowed
from virtualrobot_kernel.planning.redundancy import NearOf
from virtualrobot_kernel.planning.robots import SolverOf, world_poses
from virtualrobot_kernel.planning.stages import (
    Part,
    Tools,
    check_steps,
    joined_places,
    move_step,
    obstacle_of,
    plan_parts,
)
from virtualrobot_kernel.planning.steps import Column, PlannedStep, arrived, plan_steps
from virtualrobot_kernel.planning.tcp_speed import kept, slower
from virtualrobot_kernel.world.apply_motions import open_program
from virtualrobot_kernel.world.commands import AppendMotion
from virtualrobot_kernel.world.measured import as_commanded
from virtualrobot_kernel.world.state import Motion, Snapshot, unchanged


@dataclass(frozen=True, slots=True, eq=False)
class PlannedAppend:
    """Command that appends planned steps, notes on what became of them, and the run that may be extended next."""

    command: AppendMotion
    notes: tuple[Note, ...]
    end: PlannedRun | None


@dataclass(frozen=True, slots=True, eq=False)
class _Join:
    """Steps that were joined to the last stage: how many, the stage's part then, its run and the cut (s)."""

    count: int
    part: Part
    run: PlannedRun
    cut: float


def plan_append(
    snapshot: Snapshot,
    motion: Motion,
    steps: Sequence[Step],
    end: PlannedRun | None,
    margin: float,
    solver_of: SolverOf,
    given_up: GivenUp = lambda: False,
    near_of: NearOf | None = None,
    *,
    last: bool = False,
    outer_count: int | None = None,
) -> PlannedAppend:
    """Return the command that appends steps to a program that is open; raise KernelError that names the step.

    end: the run at its end, None where nothing may be joined to it. margin: how much nominal time (s) passes until the
    command is applied. last: whether it closes the program. outer_count: the number of steps of its text outside of
    others; None: as many as steps. Notes tell where a zone before a step has become a stop. It is as slow as the speed
    limits of tool centre points want it.
    """
    run = open_program(motion)
    first = run.program.step_count
    if not steps and not last:
        raise KernelError("there is nothing to append; give steps, or close the program", field="steps")
    if first + len(steps) - run.steps_done > MAX_STEPS:
        raise KernelError(f"a program has at most {MAX_STEPS} steps that are not done", steps=first + len(steps))
    snapshot = as_commanded(snapshot, world_poses)
    check_steps(snapshot, steps, first, open=not last)
    nodes = snapshot.structure.nodes
    own = [(nodes[robot].name, joint) for robot, joint in motion.joints]
    there = arrived(after(snapshot, own, run.program, run.at)[-1][1], own, run.program.goal)
    tools = Tools(solver_of, waited_for(given_up), near_of)
    outer = run.program.outer_count + (len(steps) if outer_count is None else outer_count)

    def plan(factor: float) -> PlannedAppend:
        slow, speeds = slowed(slower(steps, factor), run.program.speeds)
        join, notes = _joined(there, run, own, slow, first, end, margin, tools)
        count = join.count if join else 0
        begin = there
        if join is not None:
            assert join.part.plan is not None
            begin = arrived(there, join.part.joints, join.part.plan.goal)
        before = join.part if join else None
        parts, told, following = plan_parts(begin, slow[count:], tools, first + count, open=not last, before=before)
        if join is not None:
            following = join.run if count == len(steps) and not last and _zoned_end(join.run) else following
        final = join.run if join is not None and count == len(steps) else end if not steps else None
        if last and final is not None and (zoned := _zoned_end(final)):
            notes.append(dropped(zoned, "no moves follow"))
        frame = Program((), np.zeros(0), first + len(steps), not last, speeds=speeds, outer_count=outer)
        command = planned_command(there, parts, slow, frame, own, run.program, snapshot)
        append = AppendMotion(motion.id, first, command, join.cut if join else None)
        return PlannedAppend(append, tuple(sorted([*notes, *told], key=lambda note: note.step)), following)

    return kept(there, plan, lambda planned: planned.command.more)


def _zoned_end(run: PlannedRun) -> PlannedStep | None:
    """Return the last step of a run where it has a zone, through which more may be joined; else None."""
    last = run.tail.steps[-1] if run.tail is not None else None
    return last if last is not None and last.zone is not None else None


def _joined(
    there: Snapshot,
    run: ProgramRun,
    own: Sequence[Column],
    steps: Sequence[Step],
    first: int,
    end: PlannedRun | None,
    margin: float,
    tools: Tools,
) -> tuple[_Join | None, list[Note]]:
    """Return what of the first steps was joined to the last stage, and notes on the zones between them."""
    place = next((at for at, step in enumerate(steps) if step.pauses or not isinstance(step, PASSED)), len(steps))
    if end is None or end.tail is None or place == len(steps):
        return None, []
    before, following = end.tail.steps[-1], steps[place]
    if not isinstance(following, MoveStep) or following.searches or following.pauses:
        return None, [dropped(before, obstacle_of(following, place + first))]
    stage, now, reached = _last_stage(run, margin)
    if stage is None:
        return None, [dropped(before, "the motion stands there already")]
    if stage.plan is not end.plan:
        return None, [dropped(before, "it has been planned as an end")]
    facts = [(one.structure, one.state.parent_t_node, one.state.selections) for one in (before.snapshot, there)]
    if not unchanged(*facts):
        return None, [dropped(before, "the world has changed since it was planned")]
    members, _ = joined_places(steps, place, first)
    numbers = [member + first for member in members]
    moves = [move_step(steps, member) for member in members]
    notes: list[Note] = []
    whole, cut, count, values = end, inf, 0, {}
    planned = plan_steps(there, moves, tools.solver_of, numbers, tools.go_on, tools.near_of)
    for member, step in zip(members, planned, strict=True):
        tools.go_on()
        found = extended(whole, step, now, reached)
        if isinstance(found, str):
            assert whole.tail is not None
            notes.append(dropped(whole.tail.steps[-1], found))
            break
        notes += [replace(note, step=step.number, step_path=step.name) for one in step.moves for note in one.notes]
        notes += found.notes
        values[step.number] = settings(steps[count:member])
        whole, cut, count = found.run, min(cut, found.cut), member + 1
    if not count:
        return None, notes
    (old, old_leads), (new, new_leads) = moved(stage.marks, end, whole, cut), marked(whole, values)
    whole = replace(whole, leads=(*old_leads, *new_leads))
    part = Part(whole.steps, whole.plan, whole.joints, (), (*old, *new), zones=whole.zones)
    return _Join(count, part, whole, cut), notes


def _last_stage(run: ProgramRun, margin: float) -> tuple[Stage | None, float, float]:
    """Return the last stage, from which nominal time (s) on it may become another one, and where it is; None: done."""
    stages = run.program.stages
    if run.at == len(stages):
        return None, 0.0, 0.0
    if run.at < len(stages) - 1 or run.running is None:
        return stages[-1], -inf, -inf
    return stages[-1], run.running.settled + margin, run.running.tau
