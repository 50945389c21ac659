"""Values of messages as plain ones (JSON, CBOR) and back: what comes in is checked field by field."""

from __future__ import annotations

import base64
import binascii
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from virtualrobot_apps.bridges.ros.messages import types
from virtualrobot_apps.bridges.ros.messages.types import ARRAY, BASE, MESSAGE, NO_FIELD, Description

DTYPES = {
    name: np.dtype({"byte": "int8", "char": "uint8"}.get(name, name))  # rosbags takes a byte as signed
    for name in (
        *("bool", "byte", "char", "float32", "float64"),
        *("int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"),
    )
}
"""Arrays of numbers by the name of their base type."""

_BYTES = ("uint8", "byte", "char")
_TEXTS = ("string", "wstring")
_TIMES = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")
_OLD_TIME = {"secs": "sec", "nsecs": "nanosec"}


class FieldError(ValueError):
    """A value that does not fit its field; the text names the field, what is wrong and what would be right."""


def default(name: str, store: Any = types.STORE) -> Any:  # noqa: ANN401 each type is a class of its own
    """Return a message of zeros and empty texts; a store of rosbags says which one a name means."""
    return store.types[name](**{key: default_of(one, store) for key, one in store.fielddefs[name][1]})


def default_of(one: Description, store: Any = types.STORE) -> object:  # noqa: ANN401
    """Return the value of a field that nobody has set."""
    kind, detail = int(one[0]), one[1]
    if kind == BASE:
        base = detail[0]
        if base in _TEXTS:
            return ""
        return False if base == "bool" else 0.0 if base.startswith("float") else 0
    if kind == MESSAGE:
        return default(detail, store)
    inner, size = detail[0], detail[1] if kind == ARRAY else 0
    if int(inner[0]) == BASE and inner[1][0] in DTYPES:
        return np.zeros(size, DTYPES[inner[1][0]])
    return [default_of(inner, store) for _ in range(size)]


def refusal(type: str, words: str) -> Any:  # noqa: ANN401 each type is a class of its own
    """Return the response of a service that has failed: zeros, and the words where it has a `message`."""
    response = default(f"{type}_Response")
    if "message" in types.fields(f"{type}_Response"):
        response.message = words
    return response


def from_plain(name: str, value: object, path: str = "") -> Any:  # noqa: ANN401 each type is a class of its own
    """Return a message for plain values; fields that are absent are zero, and the seconds of ROS 1 are understood.

    Raises:
        FieldError: for a field that the type hasn't, and a value of another type or out of range.
    """
    if not isinstance(value, Mapping):
        raise FieldError(f"{path or name}: an object belongs here, not {_shown(value)}")
    known = types.fields(name)
    if name in _TIMES:
        value = {_OLD_TIME.get(str(key), key): one for key, one in value.items()}
    for key in value:
        if key not in known and not (name == "std_msgs/msg/Header" and key == "seq"):  # a header of ROS 1 has it
            names = [one for one in known if one != NO_FIELD]
            raise FieldError(f"{path or name} has no field {str(key)[:40]!r}; it has {', '.join(names) or 'none'}")
    beginning = f"{path}." if path else ""
    made = {
        key: _from(one, value[key], beginning + key) if key in value else default_of(one) for key, one in known.items()
    }
    return types.make(name, **made)


def _from(one: Description, value: object, path: str) -> object:
    kind, detail = int(one[0]), one[1]
    if kind == MESSAGE:
        return from_plain(detail, value, path)
    if kind == BASE:
        return _scalar(detail[0], value, path)
    inner, size = detail
    base = inner[1][0] if int(inner[0]) == BASE else ""
    if isinstance(value, str) and base in _BYTES:
        try:
            value = base64.b64decode(value, validate=True)
        except (binascii.Error, ValueError) as error:
            raise FieldError(f"{path}: bytes belong here, as a list or in base64: {error}") from error
    if isinstance(value, bytes | bytearray) and base in DTYPES:
        if len(value) % DTYPES[base].itemsize:
            raise FieldError(f"{path}: {len(value)} bytes are no list of {base}")
        value = np.frombuffer(value, DTYPES[base])
    if isinstance(value, np.ndarray) and value.ndim == 1 and base in DTYPES:
        found: Any = value if value.dtype == DTYPES[base] else _numbers(base, value.tolist(), path)
    elif not isinstance(value, list | tuple):
        raise FieldError(f"{path}: a list of {base or 'objects'} belongs here, not {_shown(value)}")
    elif base in DTYPES:
        found = _numbers(base, value, path)
    else:
        found = [_from(inner, item, f"{path}[{place}]") for place, item in enumerate(value)]
    if kind == ARRAY and len(found) != size:
        raise FieldError(f"{path}: {size} values belong here, not {len(found)}")
    return found


def _numbers(base: str, values: list[Any] | tuple[Any, ...], path: str) -> np.ndarray:
    return np.array([_scalar(base, one, f"{path}[{place}]") for place, one in enumerate(values)], DTYPES[base])


def _scalar(base: str, value: object, path: str) -> Any:  # noqa: ANN401 a number or a text
    if base in _TEXTS:
        if isinstance(value, str) and "\0" not in value and not any("\ud800" <= one <= "\udfff" for one in value):
            return value
    elif base == "bool":
        if isinstance(value, bool | np.bool_):
            return bool(value)
    elif isinstance(value, bool):
        pass
    elif base.startswith("float"):
        if value is None:  # JSON has no NaN: rosbridge writes null
            return math.nan
        if isinstance(value, int | float) and not _overflows(value, base):
            return float(value)
    elif isinstance(value, int) or (isinstance(value, float) and value.is_integer()):
        known = np.iinfo(DTYPES[base])
        if known.min <= value <= known.max:
            return int(value)
    raise FieldError(f"{path}: {base} belongs here, not {_shown(value)}")


def _overflows(value: int | float, base: str) -> bool:
    """Return whether a finite number is beyond a type of floating point; comparing takes integers of any length."""
    most = float(np.finfo(DTYPES[base]).max)
    finite = isinstance(value, int) or math.isfinite(value)
    return finite and not -most <= value <= most


def _shown(value: object) -> str:
    if isinstance(value, list | tuple | Mapping):
        return "a list" if isinstance(value, list | tuple) else "an object"
    if isinstance(value, int) and not -(10**18) < value < 10**18:
        return "so large a number"
    return repr(value)[:60]


def to_plain(value: Any, *, arrays: bool = False) -> Any:  # noqa: ANN401 a message or any of its parts
    """Return a message as dictionaries and lists, as rosbridge has it: NaN and infinity are None, bytes base64.

    With `arrays`, for CBOR, arrays of numbers stay arrays, and numbers are what they are.
    """
    if isinstance(value, np.ndarray):
        if arrays and value.dtype != np.bool_:
            return value
        if value.dtype == np.uint8:
            return base64.b64encode(value.tobytes()).decode()
        if value.dtype.kind == "f" and not np.isfinite(value).all():
            return [one if math.isfinite(one) else None for one in value.tolist()]
        return value.tolist()
    if isinstance(value, float):
        return value if arrays or math.isfinite(value) else None
    if isinstance(value, str | bool | int) or value is None:
        return value
    if isinstance(value, np.generic):
        return to_plain(value.item(), arrays=arrays)
    if isinstance(value, list | tuple):
        return [to_plain(one, arrays=arrays) for one in value]
    names = types.fields(value.__msgtype__)
    return {key: to_plain(getattr(value, key), arrays=arrays) for key in names if key != NO_FIELD}
