"""Commands about signals: create, remove and set one; and the check of values and conditions against its type."""

from __future__ import annotations

import math
from dataclasses import replace

from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.motion.signals import ORDERED, Condition, SignalValue
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.commands import CreateSignal, RemoveSignal, SetSignal
from virtualrobot_kernel.world.state import Signal, State

MOST_CHARACTERS = 4096
MOST_BOOLEANS = 1024


def create_signal(change: Change, command: CreateSignal, forward: Forward) -> Change:
    """Add a signal, with the type of its value."""
    signal, signals = command.signal, change.state.signals
    if not signal.name:
        raise KernelError("a signal's name may not be empty", name=signal.name)
    if signal.name in signals:
        raise KernelError(
            f"the name {signal.name!r} is taken by another signal; choose another one",
            reason=Reason.NAME_TAKEN,
            name=signal.name,
        )
    owner = change.structure.node(command.owner).uid if command.owner else 0
    signal = replace(signal, value=checked(signal, signal.value), owner=owner)
    return replace(change, state=replace(change.state, signals={**signals, signal.name: signal}))


def remove_signal(change: Change, command: RemoveSignal, forward: Forward) -> Change:
    """Take a signal away; refused while a program runs that names it."""
    named(change.state, command.name)
    refuse_while_signal_named(change.state, command.name)
    signals = {name: signal for name, signal in change.state.signals.items() if name != command.name}
    return replace(change, state=replace(change.state, signals=signals))


def refuse_while_signal_named(state: State, name: str) -> None:
    """Raise KernelError (WRONG_STATE) for a signal that a running program names."""
    for motion in state.motions:
        if name in motion.signals:
            raise KernelError(
                f"the program {motion.id!r} names the signal {name!r}; wait for its end or cancel it",
                reason=Reason.WRONG_STATE,
                signal=name,
                motion=motion.id,
            )


def set_signal(change: Change, command: SetSignal, forward: Forward) -> Change:
    """Set a signal."""
    signal = named(change.state, command.name)
    signals = {**change.state.signals, command.name: replace(signal, value=checked(signal, command.value))}
    return replace(change, state=replace(change.state, signals=signals))


def named(state: State, name: str) -> Signal:
    """Return a signal by name; raise UnknownNameError."""
    if name not in state.signals:
        raise UnknownNameError("signal", name, state.signals)
    return state.signals[name]


def type_of(value: SignalValue) -> str:
    """Return the type of a value, for people."""
    if isinstance(value, tuple):
        return f"group of {len(value)} booleans"
    return {bool: "boolean", int: "integer", float: "number", str: "text"}[type(value)]


def _a(noun: str) -> str:
    """Return a noun with its article."""
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def checked(signal: Signal, value: SignalValue) -> SignalValue:
    """Return a value as the signal has it, an integer as a number where that is its type.

    Raises KernelError, which names the signal, its type and what came, when the types differ, for a number that is not
    finite, and for texts and groups that are too long.
    """
    about = {"signal": signal.name, "type": type_of(signal.value), "value": value}
    if type(value) is int and type(signal.value) is float:
        value = float(value)
    if type_of(value) != type_of(signal.value):
        raise KernelError(
            f"the signal {signal.name!r} is {_a(type_of(signal.value))} and takes no {type_of(value)} ({value!r:.40})",
            **about,
        )
    if isinstance(value, float) and not math.isfinite(value):
        raise KernelError(f"the signal {signal.name!r} takes finite numbers only, not {value}", **about)
    if isinstance(value, str) and len(value) > MOST_CHARACTERS:
        raise KernelError(
            f"the signal {signal.name!r} takes at most {MOST_CHARACTERS} characters, not {len(value)}",
            reason=Reason.TOO_LARGE,
            signal=signal.name,
        )
    if isinstance(value, tuple) and not 1 <= len(value) <= MOST_BOOLEANS:
        raise KernelError(
            f"the signal {signal.name!r} is a group of 1 to {MOST_BOOLEANS} booleans, not {len(value)}",
            signal=signal.name,
        )
    return value


def check_condition(state: State, condition: Condition) -> None:
    """Raise KernelError when a condition is about an unknown signal, or compares one with what its type hasn't."""
    signal = named(state, condition.signal)
    checked(signal, condition.value)
    if condition.comparison in ORDERED and type(signal.value) not in (int, float):
        raise KernelError(
            f"the signal {signal.name!r} is {_a(type_of(signal.value))}, which {condition.comparison.value!r} cannot "
            "compare; ask whether it is equal or not",
            signal=signal.name,
            comparison=condition.comparison.name,
        )


def check_program(state: State, program: Program) -> None:
    """Raise KernelError when a program names a signal that is unknown, or gives or asks what its type hasn't."""
    for stage in program.stages:
        for _, name, value in stage.marks:
            checked(named(state, name), value)
        for condition in (stage.until, stage.wait and stage.wait.condition):
            if condition is not None:
                check_condition(state, condition)
