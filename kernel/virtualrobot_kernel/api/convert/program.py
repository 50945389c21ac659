"""Specifications of motions: from the contract's messages to values of `planning`; notes to messages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.convert.commands import COMMANDS
from virtualrobot_kernel.api.convert.expansion import NESTED, Programs, expanded
from virtualrobot_kernel.api.convert.moves import requested_move
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import EnumTable
from virtualrobot_kernel.messages.signals import condition_of, named_signal, value_of
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.messages.values import finite, not_negative, vector
from virtualrobot_kernel.planning.notes import Note, NoteKind
from virtualrobot_kernel.planning.program import (
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


def motion_spec(message: motion_pb2.MotionSpec) -> MotionSpec:
    """Return the specification of a motion; raise KernelError that names the field, and the step, that is wrong."""
    moves = tuple(requested_move(move, f"moves[{place}]") for place, move in enumerate(message.moves))
    tracking = _tracking(message.tracking) if message.HasField("tracking") else None
    return MotionSpec(moves, program_steps(message.steps, message.programs), tracking, len(message.steps))


def program_steps(
    messages: Sequence[motion_pb2.ProgramStep], programs: Programs, first: int = 0, outer: int = 0
) -> tuple[Step, ...]:
    """Return the steps that a program's text stands for; raise KernelError that names the wrong one.

    Their numbers begin with `first`, and those of the text with `outer`: message and metadata count as the program
    does, not as the request that brings them. Where the two are the same throughout, steps have no paths.
    """
    steps = list[Step]()
    found = expanded(messages, programs, outer)
    plain = first == outer and not any(step.WhichOneof("step") in NESTED for step in messages)
    for number, flat in enumerate(found, first):
        try:
            step = _step(flat.message, flat.what)
        except KernelError as error:
            error.metadata["step"], error.metadata["step_path"] = str(number), flat.path
            raise
        steps.append(step if plain else replace(step, path=flat.path))
    return tuple(steps)


def _step(message: motion_pb2.ProgramStep, what: str) -> Step:
    kind = message.WhichOneof("step")
    if kind in ORDERS:
        return OrderStep(COMMANDS[ORDERS[kind]](getattr(message, kind)))  # type: ignore[arg-type] by the table
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
        return SetSignalStep(named_signal(step.signal, what), value_of(step.value, f"{what}.value"))
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
    return MoveStep(moves, _zone(message, what))


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
