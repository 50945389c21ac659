"""Serial cables whose other end a test has: pseudo terminals under a name that stays when they are replugged."""

from __future__ import annotations

import os
import pty
import select
import threading
import tty
from collections.abc import Callable
from pathlib import Path

Answer = Callable[[bytes], bytes]
"""Function that is given what came, and returns what to send."""


class Cable:
    """A cable: a driver opens `path`, the other end is `end`, a descriptor."""

    def __init__(self, folder: Path) -> None:
        """Plug it in."""
        self.path = folder / "ttyROBOT"
        self._peer: _Peer | None = None
        self.plug()

    def plug(self) -> None:
        """Plug it in (again)."""
        self.end, self._near = pty.openpty()
        tty.setraw(self._near)
        self.path.symlink_to(os.ttyname(self._near))

    def serve(self, answer: Answer) -> None:
        """Have a thread answer what comes, until it is unplugged."""
        self._peer = _Peer(self.end, answer)

    def unplug(self) -> None:
        """Pull it out: whoever has the port open is told so. Raises what went wrong in the thread that answers."""
        if not self.path.is_symlink():
            return
        peer, self._peer = self._peer, None
        self.path.unlink()
        try:
            if peer is not None:
                peer.close()
        finally:
            os.close(self.end)
            os.close(self._near)


class _Peer:
    """A thread that answers what comes to a descriptor."""

    def __init__(self, end: int, answer: Answer) -> None:
        """Begin to answer."""
        self.end, self.answer = end, answer
        self.fault: Exception | None = None
        self._woken, self._wake = os.pipe()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        try:
            while True:
                ready, _, _ = select.select([self.end, self._woken], [], [])
                if self._woken in ready:
                    return
                if said := self.answer(os.read(self.end, 4096)):
                    os.write(self.end, said)
        except Exception as error:
            self.fault = error

    def close(self) -> None:
        """End, and raise what went wrong here."""
        os.write(self._wake, b"x")
        self._thread.join()
        os.close(self._woken)
        os.close(self._wake)
        if self.fault is not None:
            raise self.fault


def by_line(answer: Callable[[str], str | bytes | None]) -> Answer:
    """Return the answer to bytes that has each whole line answered; text gets the end of a line, bytes don't."""
    held = b""

    def answered(data: bytes) -> bytes:
        nonlocal held
        *lines, held = (held + data).split(b"\n")
        said = [answer(line.decode()) for line in lines if line]
        return b"".join(f"{one}\r\n".encode() if isinstance(one, str) else one for one in said if one is not None)

    return answered
