"""Signals: messages to values and back."""

from __future__ import annotations

from virtualrobot.v1 import signal_pb2

from virtualrobot_kernel.world.state import Signal


def signal_value(message: signal_pb2.Signal) -> Signal:
    """Return the signal that a message describes."""
    return Signal(message.name, message.value, message.description)


def signal_message(signal: Signal) -> signal_pb2.Signal:
    """Return a signal as a message."""
    return signal_pb2.Signal(name=signal.name, value=signal.value, description=signal.description)
