"""Sockets of programs, TCP and UDP: on this machine alone unless somebody allows more, given up at a stop."""

from __future__ import annotations

import select
import socket
import time

from virtualrobot_apps.languages.core.task import Task

SLICE_SECONDS = 0.02
"""Time (s) from one look at the task to the next while a program waits for a socket."""


class SocketTimeout(Exception):
    """Nothing came in time."""


class SocketClosed(Exception):
    """The other side, or this one, has closed the connection."""


def accept(task: Task, listening: socket.socket, seconds: float | None) -> tuple[socket.socket, str]:
    """Return the next connection, and the address of who made it; raises SocketTimeout after `seconds`."""
    _ready(task, listening, seconds)
    connected, (host, *_) = listening.accept()
    connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return connected, host


def receive(task: Task, connected: socket.socket, most: int, seconds: float | None) -> bytes:
    """Return what has come, `most` bytes of it; raises SocketTimeout after `seconds`, or SocketClosed."""
    _ready(task, connected, seconds)
    try:
        data = connected.recv(most)
    except OSError as error:
        raise SocketClosed(str(error)) from error
    if not data:
        raise SocketClosed("the other side has closed the connection")
    return data


def waiting(connected: socket.socket, most: int) -> int:
    """Return how many bytes have come, `most` at most; raises SocketClosed."""
    if not select.select([connected], [], [], 0.0)[0]:
        return 0
    try:
        found = len(connected.recv(most, socket.MSG_PEEK))
    except OSError as error:
        raise SocketClosed(str(error)) from error
    if not found:
        raise SocketClosed("the other side has closed the connection")
    return found


def receive_from(task: Task, waited: socket.socket, most: int, seconds: float | None) -> tuple[bytes, tuple[str, int]]:
    """Return the next datagram, `most` bytes of it, with host and port of who sent it; raises SocketTimeout."""
    _ready(task, waited, seconds)
    data, (host, port, *_) = waited.recvfrom(most)
    return data, (host, port)


def send(connected: socket.socket, data: bytes) -> None:
    """Send all of it; raises SocketClosed."""
    try:
        connected.sendall(data)
    except OSError as error:
        raise SocketClosed(str(error)) from error


def _ready(task: Task, waited: socket.socket, seconds: float | None) -> None:
    """Wait until there is something to read, and do meanwhile what the task is asked for."""
    end = None if seconds is None else time.monotonic() + seconds
    while True:
        if task.flags:
            task.poll()
        left = SLICE_SECONDS if end is None else min(SLICE_SECONDS, end - time.monotonic())
        if left <= 0:
            raise SocketTimeout(f"nothing came within {seconds:g} s")
        if select.select([waited], [], [], left)[0]:
            return
