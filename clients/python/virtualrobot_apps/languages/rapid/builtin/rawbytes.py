"""Raw bytes: values as the bytes that devices take, 1024 at most, little-endian but for Network; places from 1 on."""

from __future__ import annotations

import struct
from typing import Any

from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.table import function, instruction
from virtualrobot_apps.languages.rapid.values import value_text

MOST = 1024
_INTEGERS = {1: "B", 2: "H", 4: "I", 8: "Q", -1: "b", -2: "h", -4: "i", -8: "q"}
"""Codes of struct of the integers, by the values of `inttypes`."""


def _begin(place: float, most: int) -> int:
    if not 1 <= int(place) <= most:
        raise RapidFault("ERR_ARGVALERR", f"a place in raw bytes is 1 to {most} here, not {place:g}")
    return int(place) - 1


def _joined(data: bytes, at: int, more: bytes) -> bytes:
    """Return bytes with others at a place, of which those before it are 0 where there were none."""
    whole = data[:at].ljust(at, b"\0") + more + data[at + len(more) :]
    if len(whole) > MOST:
        raise RapidFault("ERR_ARGVALERR", f"raw bytes are {MOST} at most, and these were {len(whole)}")
    return whole


def _whole(value: float) -> int:
    if value != int(value):
        raise ValueError(value)
    return int(value)


def _form(network: bool | None, integer: float | None, real: bool | None) -> str:
    order = ">" if network else "<"
    if real:
        return f"{order}f"
    code = _INTEGERS.get(int(integer or 0))
    if code is None:
        raise RapidFault("ERR_ARGVALERR", f"\\IntX is one of USINT to LINT, not {integer:g}")
    return order + code


@function("RawBytesLen", "rawbytes RawData", "num")
def _raw_bytes_len(task: object, data: bytes) -> float:
    """Number of bytes that are set."""
    return float(len(data))


@instruction("ClearRawBytes", r"inout rawbytes RawData \num FromIndex")
def _clear_raw_bytes(task: object, holder: list[bytes], index: int, first: float | None) -> None:
    """Forgets all bytes, or those from a place on."""
    holder[index] = holder[index][: _begin(first, MOST)] if first is not None else b""


@instruction(
    "CopyRawBytes",
    r"rawbytes FromRawData, num FromIndex, inout rawbytes ToRawData, num ToIndex \num NoOfBytes",
)
def _copy_raw_bytes(
    task: object, data: bytes, first: float, holder: list[bytes], index: int, to: float, count: float | None
) -> None:
    """Copies bytes from one place to another, all that follow or so many."""
    at = _begin(first, max(1, len(data)))
    more = data[at:] if count is None else data[at : at + int(count)]
    holder[index] = _joined(holder[index], _begin(to, MOST), more)


@instruction(
    "PackRawBytes",
    r"any Value, inout rawbytes RawData \switch Network, num StartIndex "
    r"\switch Hex1 | inttypes IntX | switch Float4 | switch ASCII",
)
def _pack_raw_bytes(
    task: object,
    value: Any,  # noqa: ANN401 a num, byte or string
    holder: list[bytes],
    index: int,
    network: bool | None,
    start: float,
    hexadecimal: bool | None,
    integer: float | None,
    real: bool | None,
    text: bool | None,
) -> None:
    """Puts a number or a string at a place: as a byte, an integer of a size, a float of four bytes, or characters."""
    at = _begin(start, MOST)
    try:
        if isinstance(value, str):
            if not text:
                raise RapidFault("ERR_ARGVALERR", r"a string is packed by \ASCII")
            more = value.encode("latin-1")
        elif hexadecimal or text:
            more = struct.pack("B", _whole(value))
        elif integer is not None:
            more = struct.pack(_form(network, integer, None), _whole(value))
        elif real:
            more = struct.pack(_form(network, None, True), value)
        else:
            raise RapidFault("ERR_ARGVALERR", r"PackRawBytes needs \Hex1, \IntX, \Float4 or \ASCII")
    except (struct.error, ValueError, TypeError) as error:
        said = "any" if not isinstance(value, str | float | bool) else value_text(value)
        raise RapidFault("ERR_ARGVALERR", f"{said} does not go into what it is packed as") from error
    holder[index] = _joined(holder[index], at, more)


@instruction(
    "UnpackRawBytes",
    r"rawbytes RawData \switch Network, num StartIndex, inout any Value "
    r"\switch Hex1 | inttypes IntX | switch Float4 | num ASCII",
)
def _unpack_raw_bytes(
    task: object,
    data: bytes,
    network: bool | None,
    start: float,
    holder: list[Any],
    index: int,
    hexadecimal: bool | None,
    integer: float | None,
    real: bool | None,
    letters: float | None,
) -> None:
    """Takes a number or a string from a place, as PackRawBytes puts it; of characters as many as ASCII says."""
    at = _begin(start, max(1, len(data)))
    if letters is not None:
        if not 1 <= int(letters) <= 80:
            raise RapidFault("ERR_ARGVALERR", f"\\ASCII takes 1 to 80 characters, not {letters:g}")
        value, size = data[at : at + int(letters)].decode("latin-1"), int(letters)
    elif hexadecimal:
        value, size = float(data[at]) if data else 0.0, 1
    elif integer is not None or real:
        form = _form(network, integer, real)
        size = struct.calcsize(form)
        value = float(struct.unpack(form, data[at : at + size].ljust(size, b"\0"))[0])
    else:
        raise RapidFault("ERR_ARGVALERR", r"UnpackRawBytes needs \Hex1, \IntX, \Float4 or \ASCII")
    if at + size > len(data):
        raise RapidFault("ERR_ARGVALERR", f"{size} bytes from {start:g} on are more than the {len(data)} that are set")
    if isinstance(value, str) is not isinstance(holder[index], str):
        raise RapidFault("ERR_ARGVALERR", r"\ASCII is for a string, and the others are for numbers")
    holder[index] = value
