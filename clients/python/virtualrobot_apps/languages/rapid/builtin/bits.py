"""Bits of bytes, and bytes as text. Bits count from 1, the lowest."""

from __future__ import annotations

import operator

from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.table import function, instruction


def _byte(value: float) -> int:
    if value != int(value) or not 0 <= value <= 255:
        raise RapidFault("ERR_ARGVALERR", f"a byte is a whole number from 0 to 255, not {value:g}")
    return int(value)


def _mask(position: float) -> int:
    if position not in range(1, 9):
        raise RapidFault("ERR_ARGVALERR", f"a bit of a byte is 1 to 8, not {position:g}")
    return 1 << (int(position) - 1)


@function("BitAnd", "byte BitData1, byte BitData2", "byte")
def _bit_and(task: object, first: float, second: float) -> float:
    """Bits that both bytes have."""
    return float(operator.and_(_byte(first), _byte(second)))


@function("BitOr", "byte BitData1, byte BitData2", "byte")
def _bit_or(task: object, first: float, second: float) -> float:
    """Bits that one of the bytes has, or both."""
    return float(operator.or_(_byte(first), _byte(second)))


@function("BitXOr", "byte BitData1, byte BitData2", "byte")
def _bit_xor(task: object, first: float, second: float) -> float:
    """Bits that only one of the bytes has."""
    return float(operator.xor(_byte(first), _byte(second)))


@function("BitNeg", "byte BitData", "byte")
def _bit_neg(task: object, data: float) -> float:
    """Bits that a byte has not."""
    return float(255 - _byte(data))


@function("BitLSh", "byte BitData, num ShiftSteps", "byte")
def _bit_l_sh(task: object, data: float, steps: float) -> float:
    """Byte whose bits are moved up."""
    return float(_byte(data) << _byte(steps) & 255)


@function("BitRSh", "byte BitData, num ShiftSteps", "byte")
def _bit_r_sh(task: object, data: float, steps: float) -> float:
    """Byte whose bits are moved down."""
    return float(_byte(data) >> _byte(steps))


@function("BitCheck", "byte BitData, num BitPos", "bool")
def _bit_check(task: object, data: float, position: float) -> bool:
    """TRUE where a byte has a bit."""
    return bool(_byte(data) & _mask(position))


@instruction("BitSet", "inout byte BitData, num BitPos")
def _bit_set(task: object, holder: list[float], index: int, position: float) -> None:
    """Gives a byte a bit."""
    holder[index] = float(_byte(holder[index]) | _mask(position))


@instruction("BitClear", "inout byte BitData, num BitPos")
def _bit_clear(task: object, holder: list[float], index: int, position: float) -> None:
    """Takes a bit from a byte."""
    holder[index] = float(_byte(holder[index]) & ~_mask(position))


_FORMS = {"hex": "02X", "okt": "03o", "bin": "08b"}
_BASES = {"hex": 16, "okt": 8, "bin": 2}


def _form(hexadecimal: bool | None, octal: bool | None, binary: bool | None) -> str:
    return "hex" if hexadecimal else "okt" if octal else "bin" if binary else ""


@function("ByteToStr", r"byte BitData \switch Hex | switch Okt | switch Bin | switch Char", "string")
def _byte_to_str(
    task: object, data: float, hexadecimal: bool | None, octal: bool | None, binary: bool | None, letter: bool | None
) -> str:
    """Byte as text: decimal, hexadecimal, octal, binary, or the character of that code."""
    form = _form(hexadecimal, octal, binary)
    return chr(_byte(data)) if letter else format(_byte(data), _FORMS.get(form, "d"))


@function("StrToByte", r"string ConStr \switch Hex | switch Okt | switch Bin | switch Char", "byte")
def _str_to_byte(
    task: object, text: str, hexadecimal: bool | None, octal: bool | None, binary: bool | None, letter: bool | None
) -> float:
    """Byte that a text says: decimal, hexadecimal, octal, binary, or the code of its character."""
    try:
        if letter:
            return float(_byte(float(ord(text))))
        return float(_byte(float(int(text, _BASES.get(_form(hexadecimal, octal, binary), 10)))))
    except (TypeError, ValueError) as error:
        raise RapidFault("ERR_ARGVALERR", f"{text!r} is no byte") from error
