"""Strings: their parts, and values as strings. Places in a string count from 0."""

from __future__ import annotations

from virtualrobot_apps.languages.urscript.builtin.arithmetic import whole
from virtualrobot_apps.languages.urscript.faults import ScriptFault
from virtualrobot_apps.languages.urscript.lexer import number_value
from virtualrobot_apps.languages.urscript.table import function
from virtualrobot_apps.languages.urscript.values import Value, joined, kind_of, text


def string(value: Value, name: str) -> str:
    """Return a string; `name` is what it is called."""
    if not isinstance(value, str):
        raise ScriptFault(f"{name} is a string, not {kind_of(value)}")
    return value


@function("str_cat", "op1, op2")
def _str_cat(task: object, first: Value, second: Value) -> str:
    """Two values as one string."""
    return joined(text(first), text(second))


@function("str_len", "str")
def _str_len(task: object, value: Value) -> int:
    """Number of characters."""
    return len(string(value, "str"))


@function("str_empty", "str")
def _str_empty(task: object, value: Value) -> bool:
    """True where a string has no characters."""
    return not string(value, "str")


@function("str_at", "src, index")
def _str_at(task: object, value: Value, index: Value) -> str:
    """Character at a place."""
    return string(value, "src")[whole(index, "index", 0, len(value) - 1)]


@function("str_sub", "src, index, len=none")
def _str_sub(task: object, value: Value, index: Value, count: Value) -> str:
    """Part of a string from a place on, so long or to its end."""
    begin = whole(index, "index", 0, len(string(value, "src")))
    return value[begin:] if count is None else value[begin : begin + whole(count, "len", 0)]


@function("str_find", "src, target, start_from=0")
def _str_find(task: object, value: Value, target: Value, begin: Value) -> int:
    """Place of a string within another one, from a place on; -1 where it is not there."""
    return string(value, "src").find(string(target, "target"), whole(begin, "start_from", 0))


@function("to_str", "val")
def _to_str(task: object, value: Value) -> str:
    """Value as a string."""
    return text(value)


@function("to_num", "str")
def _to_num(task: object, value: Value) -> int | float:
    """Number that a string says: whole unless it has a point or an exponent."""
    said = string(value, "str").strip()
    sign, digits = (-1, said[1:]) if said.startswith("-") else (1, said)
    try:
        return sign * number_value(digits)
    except ValueError:
        raise ScriptFault(f"{said!r} is no number") from None
