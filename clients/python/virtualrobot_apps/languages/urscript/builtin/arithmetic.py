"""Arithmetic: functions of numbers and of lists of numbers. Angles are radians."""

from __future__ import annotations

import math
import random
from collections.abc import Callable

from virtualrobot_apps.languages.urscript.faults import ScriptFault
from virtualrobot_apps.languages.urscript.table import function
from virtualrobot_apps.languages.urscript.values import Value, copied, is_number, kind_of, text


def number(value: Value, name: str) -> float:
    """Return a number; `name` is what it is called."""
    if not is_number(value):
        raise ScriptFault(f"{name} is a number, not {kind_of(value)}")
    if not math.isfinite(value):
        raise ScriptFault(f"{name} is a finite number, not {text(value)}")
    return value


def whole(value: Value, name: str, least: int = -(2**31), most: int = 2**31 - 1) -> int:
    """Return a whole number from `least` to `most`."""
    if not is_number(value) or not math.isfinite(value) or value != math.floor(value) or not least <= value <= most:
        raise ScriptFault(f"{name} is a whole number from {least} to {most}, not {text(value)}")
    return int(value)


def numbers(values: Value, name: str, count: int | None = None) -> list[float]:
    """Return a list or pose of numbers, of so many where that is said."""
    fit = isinstance(values, list) and all(is_number(one) and math.isfinite(one) for one in values)
    if not fit or count not in (None, len(values)):
        said = "finite numbers" if count is None else f"{count} finite numbers"
        raise ScriptFault(f"{name} has {said}, and this is {text(values)}")
    return values


def _of_one(name: str, compute: Callable[[float], float], told: str, parameter: str = "f") -> None:
    def run(task: object, value: Value) -> float:
        return compute(number(value, parameter))

    run.__doc__, run.__module__ = told, __name__
    function(name, parameter)(run)


_of_one("sin", math.sin, "Sine of an angle.")
_of_one("cos", math.cos, "Cosine of an angle.")
_of_one("tan", math.tan, "Tangent of an angle.")
_of_one("asin", math.asin, "Angle whose sine is given.")
_of_one("acos", math.acos, "Angle whose cosine is given.")
_of_one("atan", math.atan, "Angle whose tangent is given.")
_of_one("sqrt", math.sqrt, "Square root.")
_of_one("ceil", math.ceil, "Least whole number that is not below a number.")
_of_one("floor", math.floor, "Greatest whole number that is not above a number.")
_of_one("d2r", math.radians, "Radians of an angle in degrees.", "d")
_of_one("r2d", math.degrees, "Degrees of an angle in radians.", "r")


@function("atan2", "x, y")
def _atan2(task: object, x: Value, y: Value) -> float:
    """Angle whose tangent is x / y, in the quadrant that the signs of both say; the manual calls the first one x."""
    return math.atan2(number(x, "x"), number(y, "y"))


@function("log", "b, f")
def _log(task: object, base: Value, value: Value) -> float:
    """Logarithm of f to the base b."""
    return math.log(number(value, "f"), number(base, "b"))


@function("pow", "base, exponent")
def _pow(task: object, base: Value, exponent: Value) -> float:
    """Base to the power of the exponent."""
    return math.pow(number(base, "base"), number(exponent, "exponent"))


@function("norm", "a")
def _norm(task: object, value: Value) -> float:
    """Absolute value of a number, or length of a list of numbers as a vector."""
    return abs(value) if is_number(value) else math.hypot(*numbers(value, "a"))


@function("normalize", "v")
def _normalize(task: object, vector: Value) -> list[float]:
    """Vector of the same direction and of length 1."""
    length = math.hypot(*numbers(vector, "v"))
    if length == 0.0:
        raise ScriptFault("a vector of length 0 has no direction")
    return [one / length for one in vector]


@function("random")
def _random(task: object) -> float:
    """Random number from 0 to 1."""
    return random.random()


@function("get_list_length", "v")
def _get_list_length(task: object, values: Value) -> int:
    """Number of elements of a list."""
    return len(_list(values))


@function("size", "v")
def _size(task: object, values: Value) -> Value:
    """Number of elements of a list; of a matrix, numbers of its rows and of its columns."""
    matrix = _list(values) and isinstance(values[0], list)
    return [len(values), len(values[0])] if matrix else len(values)


@function("make_list", "length, initial_value=0, capacity=none")
def _make_list(task: object, length: Value, initial: Value, capacity: Value) -> list[Value]:
    """List of so many elements of one value; all lists have the capacity that they need."""
    return [copied(initial) for _ in range(whole(length, "length", 0, 10_000))]


def _list(values: Value) -> list[Value]:
    if not isinstance(values, list):
        raise ScriptFault(f"this is a list, not {kind_of(values)}")
    return values


@function("integer_to_binary_list", "x")
def _integer_to_binary_list(task: object, value: Value) -> list[bool]:
    """Bits of a whole number as a list of 32 truths, the lowest first."""
    bits = whole(value, "x") & 0xFFFFFFFF
    return [bool(bits >> place & 1) for place in range(32)]


@function("binary_list_to_integer", "l")
def _binary_list_to_integer(task: object, bits: Value) -> int:
    """Whole number of a list of up to 32 truths, the lowest bit first."""
    values = _list(bits)
    if len(values) > 32:
        raise ScriptFault(f"a whole number has 32 bits, and these are {len(values)}")
    value = sum(1 << place for place, bit in enumerate(values) if bit)
    return value - 2**32 if value >= 2**31 else value
