"""Strings: their parts, numbers in them, and values as text. Places in a string count from 1."""

from __future__ import annotations

import operator
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


@function("StrOrder", "string Str1, string Str2, string Order", "bool")
def _str_order(task: object, first: str, second: str, order: str) -> bool:
    """TRUE where a string comes before another one or is the same, by an order of the characters; others come last."""

    def places(text: str) -> list[tuple[int, str]]:
        return [(order.find(one) if one in order else len(order), one) for one in text]

    return places(first) <= places(second)


@function("StrFormat", r"string Fmt \string Arg1 \string Arg2 \string Arg3 \string Arg4", "string")
def _str_format(task: object, form: str, *values: str | None) -> str:
    """Text with up to four words in the places {1} to {4}."""
    for number, value in enumerate(values, 1):
        form = form if value is None else form.replace(f"{{{number}}}", value)
    return _cut(form)


@function("DecToHex", "string Str", "string")
def _dec_to_hex(task: object, text: str) -> str:
    """Whole number of decimal digits as one of hexadecimal digits."""
    return _cut(f"{_whole(text, 10):X}")


@function("HexToDec", "string Str", "string")
def _hex_to_dec(task: object, text: str) -> str:
    """Whole number of hexadecimal digits as one of decimal digits."""
    return _cut(str(_whole(text, 16)))


def _whole(text: str, base: int) -> int:
    try:
        value = int(text, base)
    except ValueError as error:
        raise RapidFault("ERR_ARGVALERR", f"{text!r} is no whole number of base {base}") from error
    if not 0 <= value < 2**63:
        raise RapidFault("ERR_ARGVALERR", f"{text} is outside 0 to {2**63 - 1}")
    return value


@function("StrDigCmp", "string StrDig1, opnum Relation, string StrDig2", "bool")
def _str_dig_cmp(task: object, first: str, relation: float, second: str) -> bool:
    """TRUE where whole numbers of digits compare so: LT, LTEQ, EQ, NOTEQ, GTEQ or GT."""
    compare = _RELATIONS.get(int(relation))
    if compare is None:
        raise RapidFault("ERR_ARGVALERR", f"a relation is LT to GT, 1 to 6, not {relation:g}")
    return compare(_whole(first, 10), _whole(second, 10))


_RELATIONS = {1: operator.lt, 2: operator.le, 3: operator.eq, 4: operator.ne, 5: operator.ge, 6: operator.gt}


@function("NumToDnum", "num Value", "dnum")
def _num_to_dnum(task: object, value: float) -> float:
    """Number as a dnum."""
    return value


@function("DnumToNum", r"dnum Value \switch Integer", "num")
def _dnum_to_num(task: object, value: float, whole: bool | None) -> float:
    """Number as a num; with Integer it must be a whole one up to 8,388,608."""
    if whole and not (value == int(value) and abs(value) <= 8_388_608):
        raise RapidFault("ERR_ARGVALERR", f"{value!r} is no whole number from -8,388,608 to 8,388,608")
    return value


@function("DnumToStr", r"dnum Val, num Dec \switch Exp", "string")
def _dnum_to_str(task: object, value: float, decimals: float, exponent: bool | None) -> str:
    """Number as text with so many decimals."""
    return _cut(_num_to_str(task, value, decimals, exponent))
