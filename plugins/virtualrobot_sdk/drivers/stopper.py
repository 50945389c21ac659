"""Stopper of a cell: a tiny process that does nothing but set the stop in shared memory when it is told to.

It shares no lock and no interpreter with the kernel, so it stops robots where the kernel hangs or is frozen. Who has
the key sends it in a datagram to the address, and gets `stopped` back. Processes of the same user need not ask:
`virtualrobot_sdk.drivers.shared.stop_cell` sets the stop by the file alone. It is no safety function.
"""

from __future__ import annotations

import os
import secrets
import shutil
import socket
import subprocess
import sys
import threading
from pathlib import Path

from virtualrobot_sdk.drivers import realtime
from virtualrobot_sdk.drivers.shared import CellBlock
from virtualrobot_sdk.worker import boot

ANSWER = b"stopped"
"""Content of the datagram that says that the stop is set."""

_HOST = "127.0.0.1"
_LONGEST = 512
_END_SECONDS = 5.0


class Stopper:
    """Owns the process that stops one cell; it ends with the program that started it.

    Attributes:
        address: where it listens, `host:port`, on this machine alone.
        key: what a datagram to it must be.
        pid: number of the process.
    """

    def __init__(self, cell: Path) -> None:
        """Start the process for the cell whose block is the file `cell`; raises OSError where it can't be started."""
        self.key = secrets.token_hex(16)
        self._process = subprocess.Popen(
            boot.command("virtualrobot_sdk.drivers.stopper", str(cell)),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            # What ends the kernel from a terminal shall not end this first.
            process_group=None if sys.platform == "win32" else 0,
        )
        self.pid = self._process.pid
        assert self._process.stdin is not None and self._process.stdout is not None
        # By the pipe: arguments of processes are there for all to read.
        self._process.stdin.write(self.key.encode() + b"\n")
        self._process.stdin.flush()
        port = self._process.stdout.readline().strip()
        if not port:
            self.close()
            raise OSError("the process that stops the cell has ended as it began")
        self.address = f"{_HOST}:{int(port)}"

    def close(self) -> None:
        """End the process; harmless more than once."""
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.close()
        try:
            self._process.wait(_END_SECONDS)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()


def main() -> None:
    """Stop the cell of the command line's file for each datagram with the key, which standard input begins with."""
    cell, key = CellBlock.attach(Path(sys.argv[1])), sys.stdin.buffer.readline().strip()
    threading.Thread(target=_end_with_kernel, args=(cell.path.parent,), daemon=True).start()
    realtime.calm()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listening:
        listening.bind((_HOST, 0))
        sys.stdout.write(f"{listening.getsockname()[1]}\n")
        sys.stdout.flush()
        while True:
            content, sender = listening.recvfrom(_LONGEST)
            if secrets.compare_digest(content.strip(), key):
                cell.stop()
                listening.sendto(ANSWER, sender)


def _end_with_kernel(folder: Path) -> None:
    """End this process as the kernel's does, and take away the files of one that was killed.

    Hosts have them mapped and brake on; a kernel that is gone stops its robots by that.
    """
    sys.stdin.buffer.read()
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(0)
