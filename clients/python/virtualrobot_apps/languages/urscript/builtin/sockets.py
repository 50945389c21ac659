"""Sockets: a script connects to a server, and sends and reads strings and numbers."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable, Generator
from typing import TYPE_CHECKING

from virtualrobot_apps.languages.urscript.builtin.arithmetic import number, whole
from virtualrobot_apps.languages.urscript.builtin.strings import string
from virtualrobot_apps.languages.urscript.table import function
from virtualrobot_apps.languages.urscript.values import Value, text

if TYPE_CHECKING:
    from virtualrobot_apps.languages.urscript.robot import RobotTask

_OPEN_SECONDS = 2.0
_NAMED = 'socket_name="socket_0"'
_LONGEST = 1023
"""Bytes of the longest string that is read at once."""


@function("socket_open", f"address, port, {_NAMED}", waits=True)
def _socket_open(task: RobotTask, address: Value, port: Value, name: Value) -> Generator[None, None, bool]:
    """Connects to a server; False where it doesn't answer within 2 s."""
    connection = task.connections.connect(
        string(name, "socket_name"), string(address, "address"), whole(port, "port", 1, 65535)
    )
    left = round(_OPEN_SECONDS / task.dt)
    while connection is not None and not connection.open and not connection.ended and left:
        connection.look()
        left -= 1
        yield
    if connection is not None and connection.open:
        return True
    task.connections.drop(name)
    return False


@function("socket_close", _NAMED)
def _socket_close(task: RobotTask, name: Value) -> None:
    """Closes a connection."""
    task.connections.drop(string(name, "socket_name"))


def _send(task: RobotTask, name: Value, data: bytes) -> bool:
    connection = task.connections.get(string(name, "socket_name"))
    return connection is not None and connection.send(data)


@function("socket_send_string", f"str, {_NAMED}")
def _socket_send_string(task: RobotTask, value: Value, name: Value) -> bool:
    """Sends a value as text; False where the connection is not there, as of all that send."""
    return _send(task, name, text(value).encode())


@function("socket_send_line", f"str, {_NAMED}")
def _socket_send_line(task: RobotTask, value: Value, name: Value) -> bool:
    """Sends a value as text, and a newline."""
    return _send(task, name, text(value).encode() + b"\n")


@function("socket_send_byte", f"value, {_NAMED}")
def _socket_send_byte(task: RobotTask, value: Value, name: Value) -> bool:
    """Sends a byte."""
    return _send(task, name, bytes([whole(value, "value", 0, 255)]))


@function("socket_send_int", f"value, {_NAMED}")
def _socket_send_int(task: RobotTask, value: Value, name: Value) -> bool:
    """Sends a whole number as 4 bytes, the highest first."""
    return _send(task, name, struct.pack(">i", whole(value, "value")))


def _read(
    task: RobotTask, name: Value, seconds: Value, whole_length: Callable[[bytearray], int]
) -> Generator[None, None, bytes | None]:
    """Return what a connection has once it is whole: so many bytes as the function says, 0 as long as it is not.

    None where it isn't whole in time, or can't be any more; a time of 0 or less has no end.
    """
    connection = task.connections.get(string(name, "socket_name"))
    left = round(number(seconds, "timeout") / task.dt) if number(seconds, "timeout") > 0.0 else -1
    while connection is not None:
        connection.look()
        if length := whole_length(connection.got):
            found = bytes(connection.got[:length])
            del connection.got[:length]
            return found
        if connection.ended or left == 0:
            return None
        left -= 1
        yield
    return None


def _numbers(
    task: RobotTask, count: Value, name: Value, seconds: Value, form: str
) -> Generator[None, None, list[Value]]:
    layout = struct.Struct(f">{whole(count, 'number', 1, 64)}{form}")
    found = yield from _read(task, name, seconds, lambda got: layout.size if len(got) >= layout.size else 0)
    return [0, *[-1] * count] if found is None else [count, *layout.unpack(found)]


@function("socket_read_binary_integer", f"number, {_NAMED}, timeout=2", waits=True)
def _socket_read_binary_integer(
    task: RobotTask, count: Value, name: Value, seconds: Value
) -> Generator[None, None, list[Value]]:
    """List of how many whole numbers of 4 bytes have come (0 where not all did in time), and of these."""
    return (yield from _numbers(task, count, name, seconds, "i"))


@function("socket_read_byte_list", f"number, {_NAMED}, timeout=2", waits=True)
def _socket_read_byte_list(
    task: RobotTask, count: Value, name: Value, seconds: Value
) -> Generator[None, None, list[Value]]:
    """List of how many bytes have come (0 where not all did in time), and of these."""
    return (yield from _numbers(task, count, name, seconds, "B"))


@function("socket_read_ascii_float", f"number, {_NAMED}, timeout=2", waits=True)
def _socket_read_ascii_float(
    task: RobotTask, count: Value, name: Value, seconds: Value
) -> Generator[None, None, list[Value]]:
    """List of how many numbers have come in parentheses, as (1.5, 2), and of these; 0 and no numbers where none did."""
    wanted = whole(count, "number", 1, 30)
    found = yield from _read(task, name, seconds, lambda got: got.find(b")") + 1)
    words = re.findall(r"[^(),\s]+", (found or b"").partition(b"(")[2].decode(errors="replace"))
    try:
        values = [float(one) for one in words]
    except ValueError:
        values = []
    if len(values) != wanted:
        return [0, *[math.nan] * wanted]
    return [wanted, *values]


@function("socket_read_line", f"{_NAMED}, timeout=2", waits=True)
def _socket_read_line(task: RobotTask, name: Value, seconds: Value) -> Generator[None, None, str]:
    """Line that has come, without its end; empty where none did in time."""
    found = yield from _read(task, name, seconds, lambda got: got.find(b"\n") + 1)
    return (found or b"").decode(errors="replace").rstrip("\r\n")


@function("socket_read_string", f'{_NAMED}, prefix="", suffix="", interpret_escape=False, timeout=2', waits=True)
def _socket_read_string(
    task: RobotTask, name: Value, prefix: Value, suffix: Value, escapes: Value, seconds: Value
) -> Generator[None, None, str]:
    """String that has come between prefix and suffix, or all that has; empty where none did in time."""
    begin, end = string(prefix, "prefix"), string(suffix, "suffix")
    if escapes:
        begin, end = (one.replace("\\n", "\n").replace("\\r", "\r").replace("\\t", "\t") for one in (begin, end))
    first, last = begin.encode(), end.encode()

    def whole_length(got: bytearray) -> int:
        start = got.find(first)
        if start < 0:
            return 0
        if not last:
            return min(len(got), start + len(first) + _LONGEST)
        stop = got.find(last, start + len(first))
        return stop + len(last) if stop >= 0 else 0

    found = yield from _read(task, name, seconds, whole_length)
    if found is None:
        return ""
    inner = found[found.find(first) + len(first) : len(found) - len(last)]
    return inner.decode(errors="replace")
