"""Support of generated code: copies, elements, operators, and the guards of error handlers.

All that generated code calls beside the instructions. Numbers are Python's, in double precision; records and arrays are
lists; a variable that somebody else may change is a list that holds it and an index there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NoReturn

from virtualrobot_apps.languages.rapid.faults import CAUGHT, Jump, ProgramEnded, RapidFault, RapidStopped, as_fault
from virtualrobot_apps.languages.rapid.predefined import ERROR_NUMBERS
from virtualrobot_apps.languages.rapid.types import no_array

RETRY, TRYNEXT = "retry", "trynext"
ROUNDED = 1e-3
"""By how much the sum of an orientation's squares may differ from 1: programs have some with three digits, as 0.707."""


class Skipped:
    """Value of a condition whose error handler says TRYNEXT: the whole statement is left out."""


SKIPPED = Skipped()


def copied(value: Any) -> Any:  # noqa: ANN401 any value of RAPID
    """Return a value of its own."""
    return [copied(one) for one in value] if type(value) is list else value


def not_normalized(rotation: Sequence[float]) -> str:
    """Return what is wrong with the length of an orientation; nothing where it is 1, but for rounding."""
    length = math.hypot(*rotation)
    if abs(length * length - 1.0) <= ROUNDED:
        return ""
    said = ", ".join(f"{one:g}" for one in rotation)
    return f"the orientation [{said}] has the length {length:g} and not 1; use NOrient"


def place(values: list[Any], index: float) -> int:
    """Return where an element is, whose index counts from 1 and is rounded."""
    number = math.floor(index + 0.5)
    if not 1 <= number <= len(values):
        raise RapidFault("ERR_OUTOFBND", f"the index {number} is outside 1 to {len(values)}")
    return number - 1


def given(value: Any, name: str) -> Any:  # noqa: ANN401 any value of RAPID
    """Return an optional argument that is there."""
    if value is None:
        raise RapidFault("ERR_NOTPRES", f"the optional argument {name!r} was left out; ask Present({name}) first")
    return value


def array(sizes: list[float], one: Any) -> Any:  # noqa: ANN401 any value of RAPID
    """Return an array whose elements are copies of one, 1,000,000 at most in all its dimensions together."""
    if not sizes:
        return copied(one)
    if why := no_array(sizes):
        raise RapidFault("ERR_INVDIM", why)
    return [array(sizes[1:], one) for _ in range(math.floor(sizes[0] + 0.5))]


def sync_names(name: str, sizes: list[float]) -> Any:  # noqa: ANN401 a string, or an array of them
    """Return the value of a syncident: its name, and of an array the name of each element."""
    if not sizes:
        return name.lower()
    names = array(sizes, "")
    return [sync_names(f"{name}{{{number}}}", sizes[1:]) for number in range(1, len(names) + 1)]


def joined(left: str, right: str) -> str:
    """Return two strings as one, which has 80 characters at most."""
    text = left + right
    if len(text) > 80:
        raise RapidFault("ERR_STRTOOLNG", f"a string has at most 80 characters, and this has {len(text)}")
    return text


def divided(left: float, right: float) -> float:
    """Return left DIV right, rounded towards zero."""
    return float(math.trunc(left / right))


def remainder(left: float, right: float) -> float:
    """Return left MOD right, with the sign of the left one."""
    if right == 0.0:
        raise ZeroDivisionError
    return math.fmod(left, right)


def vector_sum(left: list[float], right: list[float]) -> list[float]:
    """Return the sum of two positions."""
    return [a + b for a, b in zip(left, right, strict=True)]


def vector_difference(left: list[float], right: list[float]) -> list[float]:
    """Return the difference of two positions."""
    return [a - b for a, b in zip(left, right, strict=True)]


def scaled(vector: list[float], factor: float) -> list[float]:
    """Return a position times a number."""
    return [factor * one for one in vector]


def vector_product(left: list[float], right: list[float]) -> list[float]:
    """Return the cross product of two positions."""
    (a, b, c), (x, y, z) = left, right
    return [b * z - c * y, c * x - a * z, a * y - b * x]


def linked(left: list[float], right: list[float]) -> list[float]:
    """Return the product of two quaternions q1 (real) to q4: the right rotation, in the frame of the left one."""
    a, b, c, d = left
    w, x, y, z = right
    return [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]


def raised(number: float) -> NoReturn:
    """Raise the error of RAISE; its number is 1 to 90 (ABB, RAPID Reference Manual, 8-RAISE-1), or booked."""
    if not 1 <= number <= 90 and not number > max(ERROR_NUMBERS.values()):
        raise RapidFault("ERR_ILLRAISE", f"RAISE takes a number from 1 to 90, or one of BookErrNo, not {number:g}")
    raise RapidFault(float(number), "raised by the program")


def no_value(name: str) -> NoReturn:
    """End a function that has come to its end without RETURN."""
    raise RapidFault("ERR_NORETURN", f"the function {name!r} came to its end without RETURN")


def unhandled(fault: RapidFault) -> NoReturn:
    """End the program, since a handler has come to its end without RETRY, TRYNEXT, RETURN or RAISE."""
    raise RapidStopped(f"{fault}; its error handler came to its end without RETRY, TRYNEXT, RETURN or RAISE") from fault


def exited() -> NoReturn:
    """End the program at EXIT."""
    raise ProgramEnded


def names_of_support() -> dict[str, Any]:
    """Return what generated code calls, by the names that it uses."""
    own = (copied, place, given, array, joined, divided, remainder, vector_sum, vector_difference, scaled)
    more = (vector_product, linked, raised, sync_names, no_value, unhandled, exited, as_fault)
    names = {one.__name__: one for one in (*own, *more)}
    return {**names, "CAUGHT": CAUGHT, "Jump": Jump, "RETRY": RETRY, "TRYNEXT": TRYNEXT, "SKIPPED": SKIPPED}
