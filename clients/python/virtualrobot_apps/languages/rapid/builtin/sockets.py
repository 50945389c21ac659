"""Sockets: connections by TCP, in which RAPID is the server or the client, and datagrams. Listening needs leave."""

from __future__ import annotations

import errno
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from virtualrobot_apps.languages.core import sockets
from virtualrobot_apps.languages.rapid.builtin.rawbytes import MOST
from virtualrobot_apps.languages.rapid.faults import RapidFault, RapidStopped
from virtualrobot_apps.languages.rapid.predefined import SOCKET_STATES
from virtualrobot_apps.languages.rapid.table import function, instruction
from virtualrobot_apps.languages.rapid.values import SocketDevice

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask

SECONDS = 60.0
"""Time (s of the wall clock) that is waited where none is given; WAIT_MAX waits for ever."""
LONGEST_TEXT = 80


def _seconds(time: float | None) -> float | None:
    seconds = SECONDS if time is None else time
    return None if seconds >= 9e9 else seconds


@contextmanager
def _socket_faults() -> Iterator[None]:
    """Raise RAPID's errors for a time that is over and a connection that has ended."""
    try:
        yield
    except sockets.SocketTimeout as error:
        raise RapidFault("ERR_SOCK_TIMEOUT", str(error)) from error
    except sockets.SocketClosed as error:
        raise RapidFault("ERR_SOCK_CLOSED", str(error)) from error


def _open(device: SocketDevice) -> socket.socket:
    if device.socket is None:
        raise RapidFault("ERR_SOCK_CLOSED", "the socket is closed; SocketCreate it first")
    return device.socket


def _connected(device: SocketDevice) -> socket.socket:
    found = _open(device)
    if device.state != "SOCKET_CONNECTED":
        raise RapidFault("ERR_SOCK_NOTCON", "the socket is not connected")
    return found


@instruction("SocketCreate", r"var socketdev Socket \switch UDP")
def _socket_create(task: RapidTask, holder: list[SocketDevice], index: int, datagrams: bool | None) -> None:
    """Makes a socket for TCP, or for datagrams (UDP)."""
    device = holder[index]
    if device.socket is not None:
        raise RapidFault("ERR_SOCK_ISCON", "the socket is there already; SocketClose it first")
    kind = socket.SOCK_DGRAM if datagrams else socket.SOCK_STREAM
    device.socket, device.state = socket.socket(type=kind), "SOCKET_CREATED"
    device.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    task.sockets.add(device)


@instruction("SocketBind", "var socketdev Socket, string LocalAddress, num LocalPort")
def _socket_bind(task: RapidTask, holder: list[SocketDevice], index: int, address: str, port: float) -> None:
    """Gives a socket its port. The address is that which listening was allowed at, whatever the program says."""
    if task.listen_at is None:
        raise RapidStopped(
            f"the program wants to listen at port {port:g}: whoever connects moves the robot. Allow it by --listen, "
            "at 127.0.0.1, or by --listen ADDRESS"
        )
    if not 1 <= port <= 65535:
        raise RapidFault("ERR_ARGVALERR", f"a port is 1 to 65535, not {port:g}")
    try:
        _open(holder[index]).bind((task.listen_at, int(port)))
    except OSError as error:
        name = "ERR_SOCK_ADDR_INUSE" if error.errno == errno.EADDRINUSE else "ERR_ARGVALERR"
        raise RapidFault(name, f"{task.listen_at}:{port:g}: {error.strerror}") from error
    holder[index].state = "SOCKET_BOUND"


@instruction("SocketListen", "var socketdev Socket")
def _socket_listen(task: RapidTask, holder: list[SocketDevice], index: int) -> None:
    """Lets others connect to a socket that has its port."""
    if holder[index].state != "SOCKET_BOUND":
        raise RapidFault("ERR_SOCK_NOTCON", "the socket has no port; SocketBind it first")
    _for_connections(holder[index]).listen(1)
    holder[index].state = "SOCKET_LISTENING"


@instruction("SocketAccept", r"var socketdev Socket, var socketdev ClientSocket \inout string ClientAddress \num Time")
def _socket_accept(
    task: RapidTask,
    holder: list[SocketDevice],
    index: int,
    client: list[SocketDevice],
    client_index: int,
    address: list[str] | None,
    address_index: int,
    time: float | None,
) -> None:
    """Waits for somebody who connects, Time seconds or 60; then it is ERR_SOCK_TIMEOUT."""
    task.settle()
    if holder[index].state != "SOCKET_LISTENING":
        raise RapidFault("ERR_SOCK_NOTCON", "the socket does not listen; SocketListen it first")
    if client[client_index].socket is not None:
        raise RapidFault("ERR_SOCK_ISCON", "the client's socket is connected already; SocketClose it first")
    with _socket_faults():
        connected, host = sockets.accept(task, _open(holder[index]), _seconds(time))
    client[client_index].socket, client[client_index].state = connected, "SOCKET_CONNECTED"
    task.sockets.add(client[client_index])
    if address is not None:
        address[address_index] = host


@instruction("SocketConnect", r"var socketdev Socket, string Address, num Port \num Time")
def _socket_connect(
    task: RapidTask, holder: list[SocketDevice], index: int, address: str, port: float, time: float | None
) -> None:
    """Connects to a server, within Time seconds or 60."""
    task.settle()
    device = holder[index]
    if device.state == "SOCKET_CONNECTED":
        raise RapidFault("ERR_SOCK_ISCON", "the socket is connected already")
    _for_connections(device).close()
    try:
        device.socket = socket.create_connection((address, int(port)), _seconds(time))
    except TimeoutError as error:
        raise RapidFault("ERR_SOCK_TIMEOUT", f"{address}:{port:g} did not answer in time") from error
    except (OSError, OverflowError) as error:
        raise RapidFault("ERR_SOCK_CONNREF", f"{address}:{port:g}: {error}") from error
    device.socket.settimeout(None)
    device.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    device.state = "SOCKET_CONNECTED"


@instruction("SocketSend", r"var socketdev Socket \string Str | rawbytes RawData | num Data{*} \num NoOfBytes")
def _socket_send(
    task: RapidTask,
    holder: list[SocketDevice],
    index: int,
    text: str | None,
    raw: bytes | None,
    data: list[float] | None,
    count: float | None,
) -> None:
    """Sends a string or bytes."""
    task.settle()
    sent = _bytes_of(text, raw, data, count)
    with _socket_faults():
        sockets.send(_connected(holder[index]), sent)


@instruction(
    "SocketReceive",
    r"var socketdev Socket \inout string Str | inout rawbytes RawData | inout num Data{*} \num ReadNoOfBytes "
    r"\inout num NoRecBytes \num Time",
)
def _socket_receive(
    task: RapidTask,
    holder: list[SocketDevice],
    index: int,
    text: list[str] | None,
    text_index: int,
    raw: list[bytes] | None,
    raw_index: int,
    data: list[Any] | None,
    data_index: int,
    count: float | None,
    received: list[float] | None,
    received_index: int,
    time: float | None,
) -> None:
    """Waits for a string of 80 characters at most, or for bytes, Time seconds or 60; what is more comes next time."""
    task.settle()
    if text is None and raw is None and data is None:
        raise RapidFault("ERR_ARGVALERR", r"SocketReceive needs \Str, \RawData or \Data")
    most = len(data[data_index]) if data is not None else LONGEST_TEXT if raw is None else MOST
    with _socket_faults():
        connected = _connected(holder[index])
        got = sockets.receive(task, connected, min(most, int(count)) if count else most, _seconds(time))
        while count and len(got) < min(most, int(count)):
            got += sockets.receive(task, connected, min(most, int(count)) - len(got), _seconds(time))
    _keep(got, text, text_index, raw, raw_index, data, data_index)
    if received is not None:
        received[received_index] = float(len(got))


def _bytes_of(text: str | None, raw: bytes | None, data: list[float] | None, count: float | None) -> bytes:
    """Return the bytes of the one that is given, `count` of them at most."""
    try:
        given = raw if raw is not None else (text or "").encode("latin-1")
        sent = given if data is None else bytes(int(one) for one in data)
    except (UnicodeEncodeError, ValueError) as error:
        raise RapidFault("ERR_ARGVALERR", "a byte is 0 to 255, and a character one of ISO 8859-1") from error
    return sent if count is None else sent[: int(count)]


def _keep(
    got: bytes,
    text: list[str] | None,
    text_index: int,
    raw: list[bytes] | None,
    raw_index: int,
    data: list[Any] | None,
    data_index: int,
) -> None:
    """Give what has come to the variable that is there."""
    if text is not None:
        text[text_index] = got.decode("latin-1")
    elif raw is not None:
        raw[raw_index] = got
    elif data is not None:
        data[data_index][: len(got)] = map(float, got)


def _for_connections(device: SocketDevice) -> socket.socket:
    found = _open(device)
    if found.type != socket.SOCK_STREAM:
        raise RapidFault("ERR_SOCK_NOTCON", r"the socket is for datagrams; SocketCreate it without \UDP for TCP")
    return found


def _for_datagrams(device: SocketDevice) -> socket.socket:
    found = _open(device)
    if found.type != socket.SOCK_DGRAM:
        raise RapidFault("ERR_SOCK_NOTCON", r"the socket is for TCP; SocketCreate it with \UDP for datagrams")
    return found


@instruction(
    "SocketSendTo",
    r"var socketdev Socket, string RemoteAddress, num RemotePort \string Str | rawbytes RawData | num Data{*} "
    r"\num NoOfBytes",
)
def _socket_send_to(
    task: RapidTask,
    holder: list[SocketDevice],
    index: int,
    address: str,
    port: float,
    text: str | None,
    raw: bytes | None,
    data: list[float] | None,
    count: float | None,
) -> None:
    """Sends a string or bytes as one datagram."""
    task.settle()
    sent = _bytes_of(text, raw, data, count)
    try:
        _for_datagrams(holder[index]).sendto(sent, (address, int(port)))
    except (OSError, OverflowError) as error:
        raise RapidFault("ERR_ARGVALERR", f"{address}:{port:g}: {error}") from error


@instruction(
    "SocketReceiveFrom",
    r"var socketdev Socket \inout string Str | inout rawbytes RawData | inout num Data{*} \inout num NoRecBytes, "
    r"inout string RemoteAddress, inout num RemotePort \num Time",
)
def _socket_receive_from(
    task: RapidTask,
    holder: list[SocketDevice],
    index: int,
    text: list[str] | None,
    text_index: int,
    raw: list[bytes] | None,
    raw_index: int,
    data: list[Any] | None,
    data_index: int,
    received: list[float] | None,
    received_index: int,
    address: list[str],
    address_index: int,
    port: list[float],
    port_index: int,
    time: float | None,
) -> None:
    """Waits for a datagram, Time seconds or 60, and tells who sent it; what it has too much is lost."""
    task.settle()
    if text is None and raw is None and data is None:
        raise RapidFault("ERR_ARGVALERR", r"SocketReceiveFrom needs \Str, \RawData or \Data")
    most = len(data[data_index]) if data is not None else LONGEST_TEXT if raw is None else MOST
    device = holder[index]
    waited = _for_datagrams(device)
    if device.state != "SOCKET_BOUND":
        raise RapidFault("ERR_SOCK_NOTCON", "the socket has no port; SocketBind it first")
    with _socket_faults():
        got, (address[address_index], sender) = sockets.receive_from(task, waited, most, _seconds(time))
    port[port_index] = float(sender)
    _keep(got, text, text_index, raw, raw_index, data, data_index)
    if received is not None:
        received[received_index] = float(len(got))


@instruction("SocketClose", "var socketdev Socket")
def _socket_close(task: RapidTask, holder: list[SocketDevice], index: int) -> None:
    """Closes a socket; one that is closed stays so."""
    task.settle()
    holder[index].close()
    task.sockets.discard(holder[index])


@function("SocketPeek", "var socketdev Socket", "num")
def _socket_peek(task: RapidTask, holder: list[SocketDevice], index: int) -> float:
    """Number of bytes that have come, and that a receive would give at once."""
    task.settle()
    if holder[index].state != "SOCKET_CONNECTED":
        raise RapidFault("ERR_SOCK_NOTCON", "the socket is connected with nobody")
    with _socket_faults():
        return float(sockets.waiting(_open(holder[index]), MOST))


@function("SocketGetStatus", "var socketdev Socket", "socketstatus")
def _socket_get_status(task: RapidTask, holder: list[SocketDevice], index: int) -> float:
    """State of a socket, one of SOCKET_CREATED, SOCKET_CONNECTED, SOCKET_BOUND, SOCKET_LISTENING, SOCKET_CLOSED."""
    return 1.0 + SOCKET_STATES.index(holder[index].state)
