"""Fields of protobuf messages, in the words that every supported release of protobuf knows."""

from __future__ import annotations

from typing import Any, TypeAlias

STRUCT = "google.protobuf.Struct"
"""The message that holds plain values, as JSON has them; its text form is those values."""

Field: TypeAlias = Any
"""A field's descriptor: protobuf has two classes for it, one in Python and one compiled, without a common base."""


def is_map(field: Field) -> bool:
    """Return whether the field maps names to values."""
    return field.message_type is not None and field.message_type.GetOptions().map_entry


def is_repeated(field: Field) -> bool:
    """Return whether the field is a list (or a map)."""
    # The label is deprecated where is_repeated is known.
    return field.is_repeated if hasattr(field, "is_repeated") else field.label == field.LABEL_REPEATED


def map_value(field: Field) -> Field:
    """Return what the values of a map are."""
    return field.message_type.fields_by_name["value"]
