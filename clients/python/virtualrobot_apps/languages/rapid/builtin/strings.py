"""Strings: their parts, numbers in them, and values as text. Places in a string count from 1."""

from __future__ import annotations

from typing import Any

from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.table import function
from virtualrobot_apps.languages.rapid.values import read_value, value_text


def _cut(text: str) -> str:
    if len(text) > 80:
        raise RapidFault("ERR_STRTOOLNG", f"a string has at most 80 characters, and this has {len(text)}")
    return text


def _begin(text: str, place: float) -> int:
    """Return the index of a place, which may be one behind the end."""
    number = int(place)
    if not 1 <= number <= len(text) + 1:
        raise RapidFault("ERR_ARGVALERR", f"the place {place:g} is outside 1 to {len(text) + 1}")
    return number - 1


@function("StrLen", "string Str", "num")
def _str_len(task: object, text: str) -> float:
    """Number of characters."""
    return float(len(text))


@function("StrPart", "string Str, num ChPos, num Len", "string")
def _str_part(task: object, text: str, place: float, length: float) -> str:
    """Part of a string, from a place on and so long."""
    begin = _begin(text, place)
    if length < 0 or begin + int(length) > len(text):
        raise RapidFault("ERR_ARGVALERR", f"{length:g} characters from {place:g} on are more than the string has")
    return text[begin : begin + int(length)]


@function("StrFind", r"string Str, num ChPos, string Set \switch NotInSet", "num")
def _str_find(task: object, text: str, place: float, letters: str, other: bool | None) -> float:
    """Place of the first character of a set, with NotInSet of none; one behind the end where there is none."""
    for index in range(_begin(text, place), len(text)):
        if (text[index] in letters) != bool(other):
            return index + 1.0
    return len(text) + 1.0


@function("StrMatch", "string Str, num ChPos, string Pattern", "num")
def _str_match(task: object, text: str, place: float, pattern: str) -> float:
    """Place of a string within another one; one behind the end where it is not there."""
    found = text.find(pattern, _begin(text, place))
    return float(found + 1 if found >= 0 else len(text) + 1)


@function("StrMemb", "string Str, num ChPos, string Set", "bool")
def _str_memb(task: object, text: str, place: float, letters: str) -> bool:
    """TRUE where the character at a place is of a set."""
    return text[_begin(text, place)] in letters if _begin(text, place) < len(text) else False


@function("StrMap", "string Str, string FromMap, string ToMap", "string")
def _str_map(task: object, text: str, letters: str, others: str) -> str:
    """String with some characters in place of others."""
    if len(letters) != len(others):
        raise RapidFault("ERR_ARGVALERR", "FromMap and ToMap have different lengths")
    return text.translate(str.maketrans(letters, others))


@function("StrToVal", "string Str, inout any Val", "bool")
def _str_to_val(task: object, text: str, holder: list[Any], index: int) -> bool:
    """Gives a variable the value that a string says; FALSE where it says none of the variable's type."""
    try:
        value = read_value(text, holder[index])
    except ValueError:
        return False
    if isinstance(value, list):
        holder[index][:] = value
    else:
        holder[index] = value
    return True


@function("ValToStr", "any Val", "string")
def _val_to_str(task: object, value: Any) -> str:  # noqa: ANN401 any value of RAPID
    """Value as text, numbers with six digits."""
    return _cut(value_text(value))


@function("NumToStr", r"num Val, num Dec \switch Exp", "string")
def _num_to_str(task: object, value: float, decimals: float, exponent: bool | None) -> str:
    """Number as text with so many decimals."""
    text = f"{value:.{max(0, int(decimals))}{'E' if exponent else 'f'}}"
    return "-0" if text == "-0" else text
