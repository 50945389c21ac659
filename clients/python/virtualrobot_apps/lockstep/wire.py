"""Lines to a controller and back: to a program that is started, by its pipes, or to one that connects over TCP."""

from __future__ import annotations

import queue
import socket
import subprocess
import threading
from collections.abc import Sequence
from typing import IO, Protocol

from virtualrobot.errors import CallTimeoutError, InvalidArgumentError, WrongStateError

LONGEST_LINE = 1_000_000
"""Greatest length of a line that a controller may send (characters)."""

_END_SECONDS = 5.0


class Wire(Protocol):
    """Way to a controller."""

    def send(self, line: str) -> None:
        """Send a line; what can't be sent the next `receive` tells."""
        ...

    def receive(self, seconds: float) -> str | None:
        """Return the next line, without its end; None where the controller has ended.

        Raises CallTimeoutError after so many seconds without one, WrongStateError where the controller has failed.
        """
        ...

    def close(self) -> None:
        """End it, and the program that was started."""
        ...


class _Lines:
    """Lines of a file as they come, read by a thread, so that waiting for one can end."""

    def __init__(self, file: IO[str]) -> None:
        self._waiting: queue.Queue[str | None] = queue.Queue()
        self._file = file
        self._thread = threading.Thread(target=self._read, name="controller", daemon=True)
        self._thread.start()

    def _read(self) -> None:
        try:
            while line := self._file.readline(LONGEST_LINE):
                self._waiting.put(line)
        except (OSError, ValueError):  # it was closed
            pass
        self._waiting.put(None)

    def next(self, seconds: float) -> str | None:
        try:
            line = self._waiting.get(timeout=seconds)
        except queue.Empty:
            raise CallTimeoutError(f"the controller has not answered for {seconds:g} s") from None
        if line is None:
            self._waiting.put(None)  # it stays ended
        return None if line is None else line.rstrip("\r\n")

    def close(self) -> None:
        """Close the file once whoever writes it has ended."""
        self._thread.join(_END_SECONDS)
        self._file.close()


class ProgramWire:
    """A controller that is started as a program: it reads states from its input, and writes commands to its output."""

    def __init__(self, arguments: Sequence[str]) -> None:
        """Start it; raise InvalidArgumentError when that can't be."""
        try:
            self._process = subprocess.Popen(
                list(arguments),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
                encoding="utf-8",
                errors="backslashreplace",  # what is no text is told as no command
                bufsize=1,
            )
        except OSError as error:
            raise InvalidArgumentError(f"{arguments[0]!r} cannot be started: {error.strerror or error}") from error
        assert self._process.stdin is not None and self._process.stdout is not None
        self._input = self._process.stdin
        self._lines = _Lines(self._process.stdout)

    def send(self, line: str) -> None:
        """Send a line."""
        try:
            self._input.write(f"{line}\n")
            self._input.flush()
        except OSError:  # it has ended, as the next line says
            pass

    def receive(self, seconds: float) -> str | None:
        """Return the next line; raise WrongStateError for a program that has ended with an exit code but 0.

        And for one that has closed its output and runs on.
        """
        line = self._lines.next(seconds)
        if line is None and (code := self._ended()) != 0:
            if code is None:
                raise WrongStateError("the controller has closed its output, and runs on")
            how = f"exit code {code}" if code > 0 else f"signal {-code}"
            raise WrongStateError(f"the controller has ended with {how}")
        return line

    def close(self) -> None:
        """Close its input; end it where that doesn't."""
        try:
            self._input.close()
        except OSError:
            pass
        if self._ended() is None:
            self._process.kill()
            self._process.wait()
        self._lines.close()

    def _ended(self) -> int | None:
        """Return the exit code once the program has ended; None where it doesn't."""
        try:
            return self._process.wait(_END_SECONDS)
        except subprocess.TimeoutExpired:
            return None


class SocketWire:
    """A controller that connects to a port of this machine."""

    def __init__(self, server: socket.socket, seconds: float) -> None:
        """Wait so long for it; raise CallTimeoutError when nobody comes."""
        server.settimeout(seconds)
        try:
            self._socket, _ = server.accept()
        except TimeoutError:
            port = server.getsockname()[1]
            raise CallTimeoutError(f"no controller has connected to port {port} for {seconds:g} s") from None
        self._socket.settimeout(None)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._file = self._socket.makefile("r", encoding="utf-8", errors="backslashreplace", newline="\n")
        self._lines = _Lines(self._file)

    def send(self, line: str) -> None:
        """Send a line."""
        try:
            self._socket.sendall(f"{line}\n".encode())
        except OSError:  # it has gone, as the next line says
            pass

    def receive(self, seconds: float) -> str | None:
        """Return the next line."""
        return self._lines.next(seconds)

    def close(self) -> None:
        """Close the connection."""
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._lines.close()
        self._socket.close()


def listen(port: int) -> socket.socket:
    """Return a socket that listens at a port of this machine alone (0: a free one)."""
    server = socket.socket()
    if hasattr(socket, "SO_EXCLUSIVEADDRUSE"):
        server.setsockopt(socket.SOL_SOCKET, getattr(socket, "SO_EXCLUSIVEADDRUSE"), 1)  # noqa: B009 of Windows alone
    else:
        server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        server.bind(("127.0.0.1", port))
    except OSError as error:
        server.close()
        raise InvalidArgumentError(f"port {port} cannot be used: {error.strerror or error}") from error
    server.listen(1)
    return server
