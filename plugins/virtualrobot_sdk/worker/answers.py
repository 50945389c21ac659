"""Encoding of answers from a worker to its parent: pickled, but made only of what the parent has already.

A pickle names the classes of what it holds, and reading it imports them: a plugin's own class in a result would bring
the plugin into the kernel. This keeps mistakes out, not malice: a plugin has its user's rights anyway.
"""

from __future__ import annotations

import io
import pickle
from enum import Enum
from typing import Any

from virtualrobot_sdk.errors import ArgumentError, ComponentFault, FaultKind, FilesNeeded, PluginError
from virtualrobot_sdk.worker.frames import NotAFrame

_PLAIN = {("builtins", name) for name in ("complex", "set", "frozenset", "bytearray", "range", "slice", "Ellipsis")} | {
    ("collections", "OrderedDict")
}
_PACKAGES = ("numpy", "virtualrobot_sdk")


class Outcome(Enum):
    """Outcome of a call."""

    RESULT = "result"
    REFUSED = "refused"
    """An ArgumentError: its message and metadata."""
    FILES_NEEDED = "files needed"
    """FilesNeeded: the names."""
    PLUGIN_ERROR = "plugin error"
    """A PluginError: its message."""
    FAULT = "fault"
    """A ComponentFault: its kind, reason and details."""


class ForeignType(pickle.UnpicklingError):
    """An answer holds something of a type that does not belong to Python, NumPy or the SDK."""


class _Pickler(pickle.Pickler):
    def reducer_override(self, value: object, /) -> Any:  # noqa: ANN401  as pickle has it
        """Name members of enums by class and value: early 3.11 names them by `getattr`, which does not travel."""
        return (type(value), (value.value,)) if isinstance(value, Enum) else NotImplemented


class _Unpickler(pickle.Unpickler):
    def find_class(self, module_name: str, global_name: str, /) -> Any:  # noqa: ANN401  it finds any class
        """Return the class or function of this name, if it is one that the parent may import."""
        if module_name.partition(".")[0] in _PACKAGES or (module_name, global_name) in _PLAIN:
            return super().find_class(module_name, global_name)
        raise ForeignType(f"{module_name}.{global_name}")


def pack(outcome: Outcome, *values: object) -> bytes:
    """Return an answer as bytes; raises what pickle raises for values that cannot travel."""
    content = io.BytesIO()
    _Pickler(content, protocol=5).dump((outcome.value, *values))
    return content.getvalue()


def unpack(content: bytes | bytearray, asked: str) -> Any:  # noqa: ANN401  the component says what its method returns
    """Return the result of the call `asked`, or raise what the component raised.

    Raises:
        ArgumentError, FilesNeeded, PluginError: the component or its plugin raised it.
        ComponentFault: the component raised anything else, or the result is made of types that may not travel.
        NotAFrame: this was not made by `pack`.
    """
    try:
        outcome, *values = _Unpickler(io.BytesIO(content)).load()
    except ForeignType as error:
        right = "a result is made of numbers, text, lists, NumPy arrays and the types of virtualrobot_sdk"
        raise ComponentFault(FaultKind.NONSENSE, f"{asked} gave something of the type {error}; {right}") from error
    except Exception as error:  # Bytes that are no pickle may raise anything.
        raise NotAFrame(f"an answer that cannot be read: {error}") from error
    match Outcome(outcome):
        case Outcome.RESULT:
            return values[0]
        case Outcome.REFUSED:
            raise ArgumentError(values[0], **values[1])
        case Outcome.FILES_NEEDED:
            raise FilesNeeded(values[0])
        case Outcome.PLUGIN_ERROR:
            raise PluginError(values[0])
        case Outcome.FAULT:
            raise ComponentFault(*values)
