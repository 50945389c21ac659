"""Stages of a program from its steps: each is planned from where the steps before it leave the joints."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.planned import Plan
from virtualrobot_kernel.motion.program import Stage, Wait
from virtualrobot_kernel.planning.blending import PlannedRun, join_steps, open_run
from virtualrobot_kernel.planning.foreseen import obeyed
from virtualrobot_kernel.planning.marks import Leads, Marks, ahead, marked, settings
from virtualrobot_kernel.planning.moves import Move
from virtualrobot_kernel.planning.notes import Note, NoteKind
from virtualrobot_kernel.planning.program import (
    MAX_STEPS,
    PASSED,
    DecisionStep,
    DwellStep,
    MoveStep,
    OrderStep,
    SetSignalStep,
    SpeedStep,
    Step,
    WaitPartStep,
    WaitSignalStep,
    step_name,
)
from virtualrobot_kernel.planning.redundancy import NearOf
from virtualrobot_kernel.planning.robots import SolverOf
from virtualrobot_kernel.planning.steps import Column, GoOn, named_error, plan_steps
from virtualrobot_kernel.planning.together import search_of
from virtualrobot_kernel.world.apply_signals import check_condition, checked, named
from virtualrobot_kernel.world.commands import AttachNode, PickPart, PlacePart, SelectTool
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, Structure


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Stage before the columns of the whole program are known; `joints` names those of its plan."""

    steps: tuple[tuple[float, int], ...]
    plan: Plan | None = None
    joints: tuple[Column, ...] = ()
    tool_states: tuple[tuple[str, str], ...] = ()
    marks: Marks = ()
    wait: Wait | None = None
    orders: tuple[object, ...] = ()
    pauses: bool = False
    zones: tuple[tuple[float, int], ...] = ()

    def stage(self, columns: Mapping[Column, int], paths: Mapping[int, str]) -> Stage:
        """Return the stage in a program with these columns, and steps (by number) that are called so."""
        named = tuple(paths[number] for _, number in self.steps) if paths else ()
        places = tuple(columns[joint] for joint in self.joints)
        # Times come of arrays; as plain numbers they are the same wherever they are read again.
        zones = tuple((float(time), number) for time, number in self.zones)
        rest = {"orders": self.orders, "paths": named, "pauses": self.pauses, "zones": zones}
        steps = tuple((float(time), number) for time, number in self.steps)
        marks = tuple(
            sorted(((float(time), name, value) for time, name, value in self.marks), key=lambda mark: mark[0])
        )
        return Stage(self.plan, places, steps, marks, self.wait, **rest)


@dataclass(frozen=True, slots=True, eq=False)
class Tools:
    """Means of planning: solvers of arms, the check that somebody still waits, and the preference of arms."""

    solver_of: SolverOf
    go_on: GoOn
    near_of: NearOf | None = None


def plan_parts(
    there: Snapshot,
    steps: Sequence[Step],
    tools: Tools,
    first: int = 0,
    *,
    open: bool = False,
    before: Part | None = None,
) -> tuple[list[Part], list[Note], PlannedRun | None]:
    """Return the parts of steps that begin in a world, notes, and the run at their end that more may be joined to.

    first: the number of the first step. open: whether more may follow; else the last zone is dropped, as a note tells.
    before: a part that moves, to come first.
    """
    parts: list[Part] = [] if before is None else [before]
    led = len(parts) - 1
    notes: list[Note] = []
    end = None
    place = 0
    while place < len(steps):
        tools.go_on()
        step, end = steps[place], None
        if isinstance(step, MoveStep):
            members, lonely = joined_places(steps, place, first)
            moves = [move_step(steps, member) for member in members]
            zone = moves[-1].zone
            moves[-1] = replace(moves[-1], zone=None)
            numbers = [member + first for member in members]
            planned = plan_steps(there, moves, tools.solver_of, numbers, tools.go_on, tools.near_of)
            runs, told = join_steps(planned, tools.go_on)
            there = planned[-1].arrived()
            place = members[-1]
            if open and zone is not None and place == len(steps) - 1:
                lonely, end = [], zoned(open_run(runs[-1], planned[-1]), moves[-1].moves, zone)
                runs[-1] = end
            for run in runs:
                part, leads = _moving(run, steps, members, first)
                parts.append(part)
                end = replace(end, leads=leads) if end is not None and run is end else end
            led = len(parts) - 1
            notes += [*told, *lonely]
        else:
            part = _standing(step, place + first)
            if isinstance(step, SetSignalStep) and step.lead and led >= 0:
                parts[led], part = _set_early(parts[led], step), replace(part, marks=())
            elif not isinstance(step, PASSED):
                led = -1
            parts.append(part)
            with _at(place + first, step):
                there, amiss = obeyed(there, part.orders)
                if amiss and first == 0 and _lets_go_of_nothing(steps[: place + 1]):
                    raise KernelError(amiss, reason=Reason.WRONG_STATE)
            if amiss:
                notes.append(_unforeseen(step, place + first, amiss))
        place += 1
    notes.sort(key=lambda note: note.step)
    return parts, notes, end


def zoned(run: PlannedRun, moves: Sequence[Move], zone: object) -> PlannedRun:
    """Return a run whose last step has its zone again."""
    if run.tail is None:
        return run
    *before, last = run.tail.steps
    return replace(run, tail=replace(run.tail, steps=(*before, replace(last, zone=zone))))


def check_steps(snapshot: Snapshot, steps: Sequence[Step], first: int = 0, *, open: bool = False) -> None:
    """Raise KernelError, which names the step, for what needs no planning to be seen as wrong."""
    if len(steps) > MAX_STEPS:
        raise KernelError(f"a program has at most {MAX_STEPS} steps, not {len(steps)}", steps=len(steps))
    for place, step in enumerate(steps):
        with _at(place + first, step):
            if isinstance(step, SetSignalStep):
                checked(named(snapshot.state, step.signal), step.value)
            if isinstance(step, (WaitSignalStep, DecisionStep)):
                check_condition(snapshot.state, step.condition)
            if isinstance(step, WaitPartStep):
                step.awaited.check(snapshot.structure)
            if isinstance(step, OrderStep):
                _check_names(snapshot.structure, step)
            if isinstance(step, SpeedStep) and step.robot:
                snapshot.structure.node(step.robot, Kind.ROBOT)
            if isinstance(step, MoveStep):
                if step.searches and (open or place < len(steps) - 1):
                    last = (
                        "the one that closes it"
                        if open
                        else f"which is step {step_name(steps[-1], len(steps) - 1 + first)}"
                    )
                    raise KernelError(f"a program may search in its last step only, {last}")
                search_of(snapshot, step.moves)
                for name in (name for move in step.moves for name in move.frames):
                    snapshot.structure.node(name)


def joined_places(steps: Sequence[Step], begin: int, first: int) -> tuple[list[int], list[Note]]:
    """Return the move steps (places) that zones join with the one at `begin`, and a note about a zone that joins none.

    Signals may be set between them.
    """
    members = [begin]
    while (step := move_step(steps, members[-1])).zone is not None:
        place = members[-1] + 1
        while place < len(steps) and isinstance(steps[place], PASSED) and not steps[place].pauses:
            place += 1
        following = steps[place] if place < len(steps) else None
        if isinstance(following, MoveStep) and not following.searches and not following.pauses:
            members.append(place)
            continue
        why = "no moves follow" if following is None else obstacle_of(following, place + first)
        number = members[-1] + first
        message = f"the corner after step {step_name(step, number)} is reached exactly and at rest: {why}"
        wanted = step.zone.percent or step.zone.meters
        robot = step.moves[0].robot if step.moves else ""
        note = Note(NoteKind.ZONE_DROPPED, number, robot, wanted, 0.0, message, step_name(step, number))
        return members, [note]
    return members, []


def obstacle_of(step: Step, number: int) -> str:
    """Return why no zone leads to a step, in words."""
    if step.pauses:
        return f"the program pauses before step {step_name(step, number)}"
    what = "searches" if isinstance(step, MoveStep) else "changes the world" if isinstance(step, OrderStep) else "waits"
    return f"step {step_name(step, number)} {what}"


def move_step(steps: Sequence[Step], place: int) -> MoveStep:
    """Return the step at a place, which is one that moves."""
    step = steps[place]
    assert isinstance(step, MoveStep)
    return step


def _moving(run: PlannedRun, steps: Sequence[Step], members: Sequence[int], first: int) -> tuple[Part, Leads]:
    """Return a run with the signals that are set where one of its steps begins, in a zone's middle or at rest."""
    values = dict[int, list[SetSignalStep]]()
    for _, number in run.steps:
        index = bisect_left(members, number - first)
        before = members[index - 1] if index else number - first
        values[number] = settings(steps[before + 1 : number - first])
    marks, leads = marked(run, values)
    pauses = steps[run.steps[0][1] - first].pauses
    return Part(run.steps, run.plan, run.joints, run.tool_states, marks, pauses=pauses, zones=run.zones), leads


def _set_early(part: Part, step: SetSignalStep) -> Part:
    """Return a part that moves with a signal that is set before its end."""
    assert part.plan is not None
    return replace(part, marks=(*part.marks, (ahead(part.plan.duration, step.lead), step.signal, step.value)))


def _standing(step: Step, number: int) -> Part:
    """Return a step in which nothing moves."""
    part = Part(((0.0, number),), pauses=step.pauses)
    if isinstance(step, SetSignalStep):
        return replace(part, marks=((0.0, step.signal, step.value),))
    if isinstance(step, WaitSignalStep):
        return replace(part, wait=Wait(step.timeout, step.condition))
    if isinstance(step, WaitPartStep):
        return replace(part, wait=Wait(step.timeout), orders=(step.awaited,))
    if isinstance(step, OrderStep):
        return replace(part, orders=(step.order,))
    if isinstance(step, (SpeedStep, DecisionStep)):
        return part
    assert isinstance(step, DwellStep)
    return replace(part, wait=Wait(step.seconds))


def _check_names(structure: Structure, step: OrderStep) -> None:
    """Raise UnknownNameError for a robot or node that an order names and that is not there."""
    order = step.order
    if isinstance(order, (PickPart, PlacePart, SelectTool)):
        structure.robot(order.robot)
    if isinstance(order, (PickPart, PlacePart)) and order.part:
        structure.node(order.part, Kind.PART)
    if isinstance(order, (PlacePart, AttachNode)):
        structure.node(order.parent)
    if isinstance(order, AttachNode):
        structure.node(order.name)


def _lets_go_of_nothing(steps: Sequence[Step]) -> bool:
    """Return whether the last of a program's first steps places, and nothing before it picks, or waits for others.

    What such a step can't do as the program starts it can't do later.
    """
    *before, last = steps
    places = isinstance(last, OrderStep) and isinstance(last.order, PlacePart)
    return places and all(isinstance(one, (MoveStep, *PASSED)) and not one.pauses for one in before)


def _unforeseen(step: Step, number: int, why: str) -> Note:
    """Return the note that a step can't be done in the world as it is foreseen."""
    assert isinstance(step, OrderStep)
    words = f"step {step_name(step, number)} can't be done in the world as it is foreseen there: {why}"
    robot = getattr(step.order, "robot", "")
    return Note(NoteKind.UNFORESEEN, number, robot, 0.0, 0.0, words, step_name(step, number))


def deferred(step: Step, number: int) -> Note:
    """Return the note that nobody knows yet what comes after a step."""
    name = step_name(step, number)
    return Note(NoteKind.DEFERRED, number, "", 0.0, 0.0, f"what comes after step {name} is planned then", name)


@contextmanager
def _at(number: int, step: Step) -> Iterator[None]:
    """Name the step in errors."""
    try:
        yield
    except KernelError as error:
        named_error(error, number, step)
        raise
