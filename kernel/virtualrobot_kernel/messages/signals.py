"""Signals: messages to values and back."""

from __future__ import annotations

from virtualrobot.v1 import motion_pb2, signal_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import EnumTable
from virtualrobot_kernel.motion.signals import Comparison, Condition, SignalValue
from virtualrobot_kernel.world.commands import CreateSignal
from virtualrobot_kernel.world.state import Signal, SignalDirection
from virtualrobot_kernel.world.structure import Structure

DIRECTIONS = EnumTable(SignalDirection, signal_pb2.SignalDirection, SignalDirection.INTERNAL)
COMPARISONS = EnumTable(Comparison, motion_pb2.Comparison, Comparison.EQUAL)


def created_signal(message: signal_pb2.Signal) -> CreateSignal:
    """Return the command that adds the signal that a message describes."""
    direction = DIRECTIONS.read(message.direction, "direction")
    value = value_of(message.value, "value") if message.HasField("value") else False
    signal = Signal(message.name, value, message.description, message.unit, direction)
    return CreateSignal(signal, message.owner)


def value_of(message: signal_pb2.SignalValue, what: str) -> SignalValue:
    """Return a signal's value; raise KernelError, which names the field `what`, when it is absent."""
    kind = message.WhichOneof("kind")
    if kind is None:
        kinds = ", ".join(field.name for field in message.DESCRIPTOR.fields)
        raise KernelError(f"{what} is absent; give a value, one of {kinds}", field=what)
    if kind == "group":
        return tuple(message.group.values)
    return getattr(message, kind)


def condition_of(message: motion_pb2.SignalCondition, what: str) -> Condition:
    """Return the condition that a message tells; raise KernelError, which names the field, for what is absent."""
    comparison = COMPARISONS.read(message.comparison, f"{what}.comparison")
    return Condition(named_signal(message.signal, what), value_of(message.value, f"{what}.value"), comparison)


def named_signal(signal: str, what: str) -> str:
    """Return the name of a signal; raise KernelError, which names the field, when it is empty."""
    if not signal:
        raise KernelError(f"{what}.signal is empty: which signal?", field=f"{what}.signal")
    return signal


def value_message(value: SignalValue) -> signal_pb2.SignalValue:
    """Return a signal's value as a message."""
    if isinstance(value, tuple):
        return signal_pb2.SignalValue(group=signal_pb2.BooleanGroup(values=value))
    if isinstance(value, bool):
        return signal_pb2.SignalValue(boolean=value)
    if isinstance(value, int):
        return signal_pb2.SignalValue(integer=value)
    return signal_pb2.SignalValue(number=value) if isinstance(value, float) else signal_pb2.SignalValue(text=value)


def signal_message(structure: Structure, signal: Signal) -> signal_pb2.Signal:
    """Return a signal as a message."""
    return signal_pb2.Signal(
        name=signal.name,
        value=value_message(signal.value),
        description=signal.description,
        unit=signal.unit,
        direction=DIRECTIONS.write(signal.direction),
        owner=structure.nodes[signal.owner].name if signal.owner else "",
    )
