"""Values of URScript: numbers, strings, truths, lists, poses and structs; their arithmetic, and how they are written.

Lists and poses are values: whoever assigns one, or gives it to a function, gets a copy.
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

from virtualrobot_apps.languages.urscript.faults import ScriptFault

LONGEST = 1 << 20
"""Characters of the longest string."""
ELEMENTS = 10_000
"""Elements of the longest list."""
_WHOLE = 1 << 53
"""Size from which on a product is no whole number any more."""

Value: TypeAlias = Any
"""A number, a string, True or False, a list, a Pose, a Struct, or the handle of a thread."""


class Pose(list[float]):
    """Pose p[x, y, z, rx, ry, rz]: a position (m) and a rotation vector (rad)."""


class Struct(dict[str, Value]):
    """Components by name, in their order."""


def kind_of(value: Value) -> str:
    """Return what a value is, in words."""
    if isinstance(value, bool):
        return "a truth"
    if isinstance(value, int | float):
        return "a number"
    names = {str: "a string", Pose: "a pose", list: "a list", Struct: "a struct"}
    return names.get(type(value), "no value" if value is None else "a thread")


def _count(value: Value) -> int:
    if isinstance(value, list):
        return sum(map(_count, value))
    return sum(map(_count, value.values())) if type(value) is Struct else 1


def copied(value: Value) -> Value:
    """Return a value of its own."""
    if isinstance(value, list) and any(isinstance(one, list | Struct) for one in value) and _count(value) > ELEMENTS:
        raise ScriptFault(f"a list has at most {ELEMENTS} elements, those of the lists in it included")
    return _copied(value)


def _copied(value: Value) -> Value:
    if isinstance(value, list):
        return type(value)(map(_copied, value))
    return Struct((name, _copied(one)) for name, one in value.items()) if type(value) is Struct else value


def is_number(value: Value) -> bool:
    """Return whether a value is a number; True and False are none."""
    return type(value) is float or type(value) is int


def pose(*numbers: Value) -> Pose:
    """Return the pose of six numbers."""
    for one in numbers:
        if not is_number(one):
            raise ScriptFault(f"a pose has numbers alone, and this is {kind_of(one)}: {text(one)}")
    return Pose(numbers)


def _listed(operator: str, left: Value, right: Value) -> Value:
    """Return what an operator makes of lists, element by element, or of a list and a number."""
    compute = OPERATORS[operator]
    if type(left) is list and type(right) is list and operator in "+-":
        if len(left) != len(right):
            raise ScriptFault(f"'{operator}' takes lists of one length, not of {len(left)} and {len(right)}")
        return [compute(a, b) for a, b in zip(left, right, strict=True)]
    if type(left) is list and is_number(right) and operator in "*/":
        return [compute(one, right) for one in left]
    if is_number(left) and type(right) is list and operator == "*":
        return [compute(left, one) for one in right]
    raise ScriptFault(f"'{operator}' can't take {kind_of(left)} and {kind_of(right)}")


def add(left: Value, right: Value) -> Value:
    """Return left + right; strings are joined."""
    if is_number(left) and is_number(right):
        return left + right
    if type(left) is str and type(right) is str:
        return joined(left, right)
    return _listed("+", left, right)


def joined(left: str, right: str) -> str:
    """Return two strings as one."""
    made = left + right
    if len(made) > LONGEST:
        raise ScriptFault(f"a string has at most {LONGEST} characters")
    return made


def subtract(left: Value, right: Value) -> Value:
    """Return left - right."""
    return left - right if is_number(left) and is_number(right) else _listed("-", left, right)


def multiply(left: Value, right: Value) -> Value:
    """Return left * right."""
    if not (is_number(left) and is_number(right)):
        return _listed("*", left, right)
    product = left * right
    return product if -_WHOLE < product < _WHOLE else float(product)


def divide(left: Value, right: Value) -> Value:
    """Return left / right, which is no whole number even where both are."""
    if not (is_number(left) and is_number(right)):
        return _listed("/", left, right)
    if right == 0:
        raise ScriptFault("a division by zero")
    return left / right


def remainder(left: Value, right: Value) -> Value:
    """Return left % right."""
    if not (is_number(left) and is_number(right)):
        return _listed("%", left, right)
    if right == 0:
        raise ScriptFault("a remainder of a division by zero")
    return left % right


OPERATORS = {"+": add, "-": subtract, "*": multiply, "/": divide, "%": remainder}


def negative(value: Value) -> Value:
    """Return -value; of a list, each of its elements so."""
    if type(value) is list:
        return [negative(one) for one in value]
    if not is_number(value):
        raise ScriptFault(f"'-' can't take {kind_of(value)}")
    return -value


def truth(value: Value) -> bool:
    """Return a truth; a number is true unless it is 0."""
    if value is True or value is False:
        return value
    if not is_number(value):
        raise ScriptFault(f"a condition is True or False, not {kind_of(value)}")
    return bool(value)


def order(operator: str, left: Value, right: Value) -> bool:
    """Return whether two numbers compare so."""
    if not (is_number(left) and is_number(right)):
        raise ScriptFault(f"'{operator}' can't take {kind_of(left)} and {kind_of(right)}")
    match operator:
        case "<":
            return left < right
        case "<=":
            return left <= right
        case ">":
            return left > right
    return left >= right


def _place(values: list[Value], index: Value) -> int:
    if not is_number(index) or not math.isfinite(index) or index != math.floor(index):
        raise ScriptFault(f"an index is a whole number, not {text(index)}")
    if not 0 <= index < len(values):
        raise ScriptFault(f"the index {int(index)} is outside 0 to {len(values) - 1}")
    return int(index)


def element(of: Value, *indices: Value) -> Value:
    """Return an element; indices count from 0."""
    for index in indices:
        if not isinstance(of, list):
            raise ScriptFault(f"{kind_of(of)} has no elements")
        of = of[_place(of, index)]
    return of


def put(of: Value, value: Value, *indices: Value) -> None:
    """Set an element."""
    of = element(of, *indices[:-1])
    if not isinstance(of, list):
        raise ScriptFault(f"{kind_of(of)} has no elements")
    if isinstance(of, Pose) and not is_number(value):
        raise ScriptFault(f"a pose has numbers alone, and this is {kind_of(value)}: {text(value)}")
    of[_place(of, indices[-1])] = value


def component(of: Value, name: str) -> Value:
    """Return a component of a struct."""
    if type(of) is not Struct:
        raise ScriptFault(f"{kind_of(of)} has no components")
    if name not in of:
        raise ScriptFault(f"this struct has no component {name!r}; it has {', '.join(of)}")
    return of[name]


def put_component(of: Value, value: Value, name: str) -> None:
    """Set a component of a struct, which it has already."""
    component(of, name)
    of[name] = value


def text(value: Value) -> str:
    """Return a value as the controller writes it; of numbers six significant digits."""
    if value is True or value is False:
        return str(value)
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, list):
        return f"{'p' if isinstance(value, Pose) else ''}[{', '.join(text(one) for one in value)}]"
    if type(value) is Struct:
        return f"struct({', '.join(f'{name}={text(one)}' for name, one in value.items())})"
    return str(value) if isinstance(value, int | str) else kind_of(value)
