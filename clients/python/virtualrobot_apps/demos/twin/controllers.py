"""The emulated controllers of the demo, each in a process of its own that ends with this one."""

from __future__ import annotations

import os
import socket
import subprocess
import threading
from collections.abc import Callable, Iterable, Sequence

from virtualrobot.child_process import end_child, start_child
from virtualrobot.errors import DriverFaultError

RATE = 125
"""Cycles a second of both controllers: fewer than an e-Series has, which a laptop keeps beside all else."""

UR_PORTS = (29999, 30001, 30002, 30003, 30004)
UR_HOSTS = tuple(f"127.0.0.{number}" for number in range(1, 100))
"""Addresses of this machine, one for each emulated controller; macOS has the first alone."""


class Controller:
    """Process of `virtualrobot emulate`, which runs from the start of a block to its end.

    Attributes:
        place: where it listens, as it says it; empty where it says nothing of that.
    """

    def __init__(self, options: Sequence[str], ready: str, hear: Callable[[str], object] = len) -> None:
        """Start it, and wait until it says `ready`; `hear` gets each line that it says from then on.

        Raises:
            DriverFaultError: it ends before; its words are told.
        """
        self._process = start_child("emulate", *options, "--until-input-ends", stderr=subprocess.STDOUT)
        assert self._process.stdout is not None
        said = ""
        for line in self._process.stdout:
            said = line.strip()
            if ready in said:
                self.place = said.partition(" at ")[2].partition(";")[0]
                break
        else:
            self.close()
            raise DriverFaultError(f"the emulated controller ends at once: {said}", "DRIVER_FAULT")
        threading.Thread(target=self._listen, args=(hear,), name="words of a controller", daemon=True).start()

    @property
    def pid(self) -> int:
        """Number of its process."""
        return self._process.pid

    def close(self) -> None:
        """End it; one that doesn't end in time is killed."""
        end_child(self._process, 10.0)

    def __enter__(self) -> Controller:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """End it."""
        self.close()

    def _listen(self, hear: Callable[[str], object]) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as lines:
            for line in lines:
                hear(line.rstrip())


def universal_robots(
    hosts: Iterable[str] = UR_HOSTS, options: Sequence[str] = (), hear: Callable[[str], object] = len
) -> tuple[Controller, str]:
    """Return an emulated controller of Universal Robots, with `options`, and its address: the first free one."""
    why = "no address of this machine has the ports 29999 to 30004 free"
    for host in hosts:
        if not all(_is_free(host, port) for port in UR_PORTS):
            continue
        try:
            own = ["ur", *options, "--model", "ur5e", "--host", host, "--rate", str(RATE)]
            return Controller(own, "listens at", hear), host
        except DriverFaultError as error:  # somebody else was faster
            why = str(error)
    raise DriverFaultError(why, "DRIVER_FAULT")


def guided_by(port: int, stands: Sequence[float]) -> Controller:
    """Return an emulated ABB controller that speaks EGM to a port of this machine; its joints stand so, rad."""
    at = ",".join(f"{value:g}" for value in stands)
    return Controller(["egm", "--to", f"127.0.0.1:{port}", "--at", at, "--rate", str(RATE)], "speaks to")


def free_port() -> int:
    """Return a port for datagrams that nobody has."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


def _is_free(host: str, port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as asked:
        if os.name != "nt":
            asked.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            asked.bind((host, port))
        except OSError:
            return False
    return True
