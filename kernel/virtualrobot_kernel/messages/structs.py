"""Settings of components: plain values as JSON has them, and the message that holds them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from google.protobuf.struct_pb2 import Struct, Value

from virtualrobot_kernel.messages.values import finite


def settings(message: Struct, what: str) -> dict[str, Any]:
    """Return the plain values of a component's settings, names sorted; raise KernelError for a number not finite."""
    # Sorted, since the order of a map's entries differs between processes.
    return {name: _plain(message.fields[name], f"{what}.{name}") for name in sorted(message.fields)}


def settings_message(settings: Mapping[str, Any]) -> Struct:
    """Return the settings of a component."""
    message = Struct()
    message.update(settings)
    return message


def _plain(value: Value, what: str) -> Any:  # noqa: ANN401  whatever JSON can say
    kind = value.WhichOneof("kind")
    if kind == "struct_value":
        return settings(value.struct_value, what)
    if kind == "list_value":
        return [_plain(entry, f"{what}[{place}]") for place, entry in enumerate(value.list_value.values)]
    if kind == "number_value":
        return finite(value.number_value, what)
    return None if kind in (None, "null_value") else getattr(value, kind)
