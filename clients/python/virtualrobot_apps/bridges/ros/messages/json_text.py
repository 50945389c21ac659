"""Messages as text in JSON, as rosbridge has them: bytes in base64, arrays of numbers as lists.

Dictionaries are not made on the way: for joints they and json's own writer take three times as long.
"""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Callable
from json.encoder import encode_basestring_ascii
from operator import attrgetter
from typing import Any

import numpy as np

from virtualrobot_apps.bridges.ros.messages import types
from virtualrobot_apps.bridges.ros.messages.types import NO_FIELD

_Write = Callable[[Any], str]


class _Writers(dict[type, _Write]):
    """Writers of values by their class, each made when the first value of it comes."""

    def __init__(self, *, null: bool) -> None:
        """Write what is not finite as `null`, or else as Python does: `Infinity`, `NaN`."""
        super().__init__()
        self._null = null

    def __missing__(self, kind: type) -> _Write:
        """Return the writer of a class that has none yet."""
        self[kind] = found = self._writer(kind)
        return found

    def _writer(self, kind: type) -> _Write:
        if issubclass(kind, bool):
            return lambda value: "true" if value else "false"
        if issubclass(kind, np.ndarray):
            return self._array
        if issubclass(kind, float):
            return self._number
        if issubclass(kind, int):
            return int.__repr__
        if issubclass(kind, str):
            return encode_basestring_ascii
        if issubclass(kind, list | tuple):
            return lambda value: f"[{','.join([self[type(one)](one) for one in value])}]"
        if issubclass(kind, np.generic):
            return lambda value: self[type(plain := value.item())](plain)
        if kind is type(None):
            return lambda value: "null"
        return self._message(kind)

    def _message(self, kind: type) -> _Write:
        names = [one for one in types.fields(kind.__dict__["__msgtype__"]) if one != NO_FIELD]
        text = f"{{{','.join(f'{json.dumps(one)}:%s' for one in names)}}}"
        if not names:
            return lambda value: text
        if len(names) == 1:
            only = attrgetter(names[0])
            return lambda value: text % self[type(found := only(value))](found)
        values = attrgetter(*names)
        return lambda value: text % tuple([self[type(one)](one) for one in values(value)])

    def _number(self, value: float) -> str:
        if math.isfinite(value):
            return float.__repr__(value)
        return "null" if self._null else json.dumps(float(value))

    def _array(self, value: np.ndarray) -> str:
        if value.dtype == np.uint8:
            return f'"{base64.b64encode(value.tobytes()).decode()}"'
        if value.dtype == np.bool_:
            return json.dumps(value.tolist(), separators=(",", ":"))
        text = repr(value.tolist())
        if "n" in text:  # nan, inf
            return f"[{','.join(map(self._number, value.tolist()))}]"
        return text.replace(", ", ",")


_NULL, _WORDS = _Writers(null=True), _Writers(null=False)


def to_json(value: object, *, null: bool = True) -> str:
    """Return a message, or any of its parts, in JSON; what is not finite is `null`, or else a word as Python's."""
    return (_NULL if null else _WORDS)[type(value)](value)
