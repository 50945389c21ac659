"""Values of signals: to messages and back, and the commands and conditions that hold them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import Text
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.v1 import motion_pb2, scene_pb2, signal_pb2

SignalValue = bool | int | float | Text | tuple[bool, ...]
"""On or off, a whole number, a number, words, or a group of booleans; the type says which."""

GivenValue = Annotated[
    SignalValue | Sequence[bool] | np.generic | NDArray[Any],
    "True or False, a whole number, a number, a text or a list of True and False, or NumPy's of these",
]
"""Value of a signal as a program gives it."""

COMPARISONS = {
    "==": motion_pb2.COMPARISON_EQUAL,
    "!=": motion_pb2.COMPARISON_NOT_EQUAL,
    "<": motion_pb2.COMPARISON_LESS,
    "<=": motion_pb2.COMPARISON_AT_MOST,
    ">": motion_pb2.COMPARISON_GREATER,
    ">=": motion_pb2.COMPARISON_AT_LEAST,
}


def value_message(value: GivenValue) -> signal_pb2.SignalValue:
    """Return a value as a message; raise InvalidArgumentError for one that no signal has."""
    if isinstance(value, np.generic | np.ndarray):
        return value_message(value.tolist())
    if isinstance(value, bool):
        return signal_pb2.SignalValue(boolean=value)
    if isinstance(value, str):
        return signal_pb2.SignalValue(text=value)
    if isinstance(value, int) and -(2**63) <= value < 2**63:
        return signal_pb2.SignalValue(integer=value)
    if isinstance(value, float):
        return signal_pb2.SignalValue(number=value)
    if isinstance(value, Sequence) and all(isinstance(one, bool | np.bool_) for one in value):
        return signal_pb2.SignalValue(group=signal_pb2.BooleanGroup(values=map(bool, value)))
    raise InvalidArgumentError(
        f"a signal's value is a bool, an int of 64 bits, a float, a str or a sequence of bools, not {value!r:.60}"
    )


def value_of(message: signal_pb2.SignalValue) -> SignalValue:
    """Return the value that a message tells."""
    kind = message.WhichOneof("kind")
    if kind == "group":
        return tuple(message.group.values)
    return getattr(message, kind) if kind else False


def set_command(name: str, value: GivenValue) -> scene_pb2.Command:
    """Return the command that sets a signal."""
    return scene_pb2.Command(set_signal=scene_pb2.SetSignal(name=name, value=value_message(value)))


def condition(signal: str, value: GivenValue, comparison: str = "==") -> motion_pb2.SignalCondition:
    """Return a condition as a message; raise InvalidArgumentError for an unknown comparison."""
    if comparison not in COMPARISONS:
        raise InvalidArgumentError(f"a comparison is one of {', '.join(COMPARISONS)}, not {comparison!r}")
    return motion_pb2.SignalCondition(signal=signal, value=value_message(value), comparison=COMPARISONS[comparison])
