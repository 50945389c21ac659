"""Specifications of motions: from the contract's messages to values of `planning`; notes to messages."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.convert.commands import COMMANDS
from virtualrobot_kernel.api.convert.expansion import (
    NESTED,
    Decision,
    FlatStep,
    Programs,
    Text,
    each_once,
    next_part,
    text_of,
)
from virtualrobot_kernel.api.convert.moves import requested_move
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import EnumTable
from virtualrobot_kernel.messages.signals import condition_of, named_signal, value_of
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.messages.values import finite, not_negative, vector
from virtualrobot_kernel.motion.signals import Condition
from virtualrobot_kernel.planning.notes import Note, NoteKind
from virtualrobot_kernel.planning.program import (
    DecisionStep,
    DwellStep,
    MotionSpec,
    MoveStep,
    OrderStep,
    SetSignalStep,
    SpeedStep,
    Step,
    TrackingSpec,
    WaitPartStep,
    WaitSignalStep,
    Zone,
)
from virtualrobot_kernel.world.apply_robots import REACH_OF_A_PICK
from virtualrobot_kernel.world.awaited_part import AwaitedPart

NOTE = Table(Note, motion_pb2.PlanNote, kind=EnumTable(NoteKind, motion_pb2.PlanNoteKind))
MOST_PERCENT = 50.0
LONGEST_DWELL = 86_400.0
"""Longest time (s) that a step may do nothing: a day. What waits longer waits for a signal."""

ORDERS = {
    "pick": "pick_part",
    "place": "place_part",
    "attach": "attach_node",
    "select_tool": "select_tool",
    "set_allowed_pairs": "set_allowed_pairs",
}
"""Command that a kind of step gives, by its field in `Command`."""


@dataclass(slots=True, eq=False)
class Continuation:
    """Rest of a program's text whose steps are known only when they are reached: from a decision on.

    numbered: the number of the first step that comes. breakpoints: those of the whole text.
    """

    text: Text
    decision: Decision
    numbered: int
    breakpoints: frozenset[str]

    @property
    def condition(self) -> Condition | None:
        """Condition that decides; None where a round is over and the next one follows whatever is."""
        asked = self.decision.condition
        return None if asked is None else condition_of(asked, f"{self.decision.what}.condition")

    def next(self, holds: bool) -> tuple[tuple[Step, ...], Continuation | None]:
        """Return the steps that come, and what is left after them."""
        return _converted(self.text, holds, self.numbered, self.breakpoints, named=True)


@dataclass(frozen=True, slots=True, eq=False)
class ProgramText:
    """Steps of a program's text up to its first decision, and the rest.

    every: each step of the text once. outer_count: the number of steps outside of others.
    """

    steps: tuple[Step, ...]
    rest: Continuation | None
    every: tuple[Step, ...]
    outer_count: int


def motion_spec(message: motion_pb2.MotionSpec, text: ProgramText | None = None) -> MotionSpec:
    """Return the specification of a motion; raise KernelError that names the field, and the step, that is wrong.

    text: what its steps say, where that is known already.
    """
    moves = tuple(requested_move(move, f"moves[{place}]") for place, move in enumerate(message.moves))
    tracking = _tracking(message.tracking) if message.HasField("tracking") else None
    text = text or program_text(message.steps, message.programs)
    each = (*moves, *(move for step in text.steps if isinstance(step, MoveStep) for move in step.moves))
    if tracking and (tool := next((move.fixed_tool for move in each if move.fixed_tool), None)):
        raise KernelError(
            f"the tool {tool!r} stands apart, and the motion goes along with {tracking.node!r}: that can't be yet",
            field="tracking",
        )
    return MotionSpec(moves, text.steps, tracking, text.outer_count, text.every if text.rest else ())


def program_text(
    messages: Sequence[motion_pb2.ProgramStep],
    programs: Programs,
    breakpoints: Iterable[str] = (),
    first: int = 0,
    outer: int = 0,
) -> ProgramText:
    """Return what a program's text says; raise KernelError that names the wrong step.

    The numbers of its steps begin with `first`, and those of the text with `outer`: message and metadata count as the
    program does, not as the request that brings them. Where the two are the same throughout, steps have no paths.
    `breakpoints` are steps before which it pauses.
    """
    named = first != outer or any(step.WhichOneof("step") in NESTED for step in messages)
    stops = frozenset(breakpoints)
    steps, rest = _converted(text_of(messages, programs, outer), None, first, stops, named)
    once = each_once(messages, programs, outer) if rest or stops else []
    if unknown := {_timeless(one) for one in stops} - {_timeless(one.path) for one in once}:
        named_so = ", ".join(map(repr, sorted(unknown)))
        raise KernelError(f"the program has no step {named_so} to pause before", field="breakpoints")
    every = tuple(replace(_step_at(one, first), path=one.path) for one in once) if rest else steps
    return ProgramText(steps, rest, every, len(messages))


def _converted(
    text: Text, holds: bool | None, first: int, breakpoints: frozenset[str], named: bool
) -> tuple[tuple[Step, ...], Continuation | None]:
    """Return the next steps of a text, numbered from `first`, and what is left after them."""
    steps = list[Step]()
    found, decision = next_part(text, holds)
    for number, flat in enumerate(found, first):
        stops = not breakpoints.isdisjoint((flat.path, _timeless(flat.path)))
        steps.append(replace(_step_at(flat, number), path=flat.path if named else "", pauses=stops))
    rest = Continuation(text, decision, first + len(steps), breakpoints) if decision else None
    return tuple(steps), rest


def _timeless(path: str) -> str:
    """Return the path of a step without the numbers of rounds."""
    return re.sub(r"\[\d+\]", "", path)


def _step_at(flat: FlatStep, number: int) -> Step:
    try:
        return _step(flat.message, flat.what)
    except KernelError as error:
        error.metadata["step"], error.metadata["step_path"] = str(number), flat.path
        raise


def _step(message: motion_pb2.ProgramStep, what: str) -> Step:
    kind = message.WhichOneof("step")
    if kind in ORDERS:
        return OrderStep(COMMANDS[ORDERS[kind]](getattr(message, kind)))  # type: ignore[arg-type] by the table
    if kind in ("if_signal", "while_signal"):
        return DecisionStep(condition_of(getattr(message, kind).condition, f"{what}.{kind}.condition"))
    if kind == "set_speed":
        factor = message.set_speed.factor
        if not 0.0 < factor <= 1.0:
            raise KernelError(f"{what}.set_speed.factor must be above 0 and at most 1, not {factor:g}", factor=factor)
        return SpeedStep(message.set_speed.robot, factor)
    if kind == "wait_part":
        return _wait_part(message.wait_part, f"{what}.wait_part")
    if kind == "move":
        return _move_step(message.move, f"{what}.move")
    if kind == "set_signal":
        step, what = message.set_signal, f"{what}.set_signal"
        lead = not_negative(step.lead_seconds, f"{what}.lead_seconds")
        return SetSignalStep(named_signal(step.signal, what), value_of(step.value, f"{what}.value"), lead)
    if kind == "wait_signal":
        wait = message.wait_signal
        condition = condition_of(wait.condition, f"{what}.wait_signal.condition")
        return WaitSignalStep(condition, _timeout(wait.timeout_seconds, f"{what}.wait_signal.timeout_seconds"))
    if kind == "dwell":
        seconds = finite(message.dwell.seconds, f"{what}.dwell.seconds")
        if not 0.0 < seconds <= LONGEST_DWELL:
            raise KernelError(
                f"{what}.dwell.seconds must be above 0 and at most {LONGEST_DWELL:g}, a day, not {seconds:g}",
                seconds=seconds,
                upper=LONGEST_DWELL,
            )
        return DwellStep(seconds)
    names = ", ".join(field.name for field in message.DESCRIPTOR.oneofs_by_name["step"].fields)
    raise KernelError(f"{what} does not say what to do; give one of {names}", field=what)


def _wait_part(message: motion_pb2.WaitPartStep, what: str) -> WaitPartStep:
    distance = not_negative(message.max_distance_meters, f"{what}.max_distance_meters") or REACH_OF_A_PICK
    awaited = AwaitedPart(message.part, message.reference, vector(message.position, f"{what}.position"), distance)
    return WaitPartStep(awaited, _timeout(message.timeout_seconds, f"{what}.timeout_seconds"))


def _timeout(seconds: float, what: str) -> float:
    if finite(seconds, what) < 0.0:
        raise KernelError(f"{what} must be 0 (never) or above, not {seconds:g}", timeout=seconds)
    return seconds


def _move_step(message: motion_pb2.MoveStep, what: str) -> MoveStep:
    if not message.moves:
        raise KernelError(f"{what}.moves is empty: which robot shall move?", field=f"{what}.moves")
    moves = tuple(requested_move(move, f"{what}.moves[{place}]") for place, move in enumerate(message.moves))
    return MoveStep(
        moves, _zone(message, what), not_negative(message.min_duration_seconds, f"{what}.min_duration_seconds")
    )


def _zone(message: motion_pb2.MoveStep, what: str) -> Zone | None:
    kind = message.WhichOneof("zone")
    if kind == "blend_distance_meters":
        meters = finite(message.blend_distance_meters, f"{what}.{kind}")
        if meters <= 0.0:
            raise KernelError(f"{what}.{kind} must be above 0, not {meters:g}; leave it out to stop", zone=meters)
        return Zone(meters=meters)
    if kind == "blend_percent":
        percent = finite(message.blend_percent, f"{what}.{kind}")
        if not 0.0 < percent <= MOST_PERCENT:
            raise KernelError(
                f"{what}.{kind} must be above 0 and at most {MOST_PERCENT:g}, not {percent:g}", zone=percent
            )
        return Zone(percent=percent)
    if kind == "blend_radius":
        meters = finite(message.blend_radius.radius_meters, f"{what}.{kind}.radius_meters")
        if meters <= 0.0:
            raise KernelError(
                f"{what}.{kind}.radius_meters must be above 0, not {meters:g}; leave it out to stop", zone=meters
            )
        extended = not_negative(message.blend_radius.extended_radius_meters, f"{what}.{kind}.extended_radius_meters")
        return Zone(meters=meters, parabola=True, extended=extended)
    return None


def _tracking(message: motion_pb2.Tracking) -> TrackingSpec:
    if not message.node:
        raise KernelError("tracking.node is empty: what shall the motion go along with?", field="tracking.node")
    window = finite(message.window, "tracking.window")
    if window == 0.0:
        raise KernelError(
            "tracking.window must say how far the joint may move, other than 0, with the sign of its direction",
            field="tracking.window",
        )
    velocity = finite(message.max_velocity, "tracking.max_velocity")
    if velocity < 0.0:
        raise KernelError(
            f"tracking.max_velocity must be 0 (the joint's limit) or above, not {velocity:g}",
            field="tracking.max_velocity",
        )
    return TrackingSpec(message.node, window, velocity)
