"""An emulated ABB controller for tests, served over TCP, and programs of its clients."""

from __future__ import annotations

import asyncio
import select
import socket
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import virtualrobot
from abb_robot_client.rws import RWS
from virtualrobot_apps.emulators.abb.controller import Controller
from virtualrobot_apps.emulators.abb.server import Server, made

from tests.waiting import until

USER, PASSWORD = "Default User", "robotics"


class Served:
    """A controller with its server.

    Attributes:
        controller: the controller.
        port: where it listens.
        application: its server, as ASGI has it.
        written: lines that its programs have written.
    """

    def __init__(
        self,
        client: virtualrobot.Client,
        robots: Sequence[str],
        files: Path,
        certificate: tuple[Path, Path] | None = None,
        **more: Any,  # noqa: ANN401
    ) -> None:
        """Serve it, in a thread: by 2.0 where there are certificate and key; `more` is for the controller."""
        self.written: list[str] = []
        self.controller = Controller(client, robots, files, create_signals=True, write=self.written.append, **more)
        listening = socket.create_server(("127.0.0.1", 0))
        self.port = listening.getsockname()[1]
        second = certificate is not None
        self.url = f"http{'s' * second}://127.0.0.1:{self.port}"
        self.application = Server(self.controller, {USER: PASSWORD}, second=second)
        self._server = made(self.application, certificate)
        self._thread = threading.Thread(target=lambda: asyncio.run(self._server.serve([listening])))
        self._thread.start()
        self._clients: list[RWS] = []

    def client(self) -> Any:  # noqa: ANN401 the types that it declares are not those that it returns
        """Return another RWS, as a program makes it."""
        made = RWS(self.url)
        self._clients.append(made)
        return made

    def raw(self, data: bytes) -> bytes:
        """Return what comes back for bytes that need not be a request; one that isn't whole is given up soon."""
        answer = b""
        with socket.create_connection(("127.0.0.1", self.port), 60.0) as connection, suppress(ConnectionError):
            connection.sendall(data)
            select.select([connection], [], [], 0.1)
            connection.shutdown(socket.SHUT_WR)  # nothing more comes, also where it would be kept open
            while piece := connection.recv(65536):
                answer += piece
        return answer

    def close(self) -> None:
        """End it."""
        for one in self._clients:
            one.close()
        self._server.should_exit = True
        self._thread.join()
        self.controller.close()


@contextmanager
def served(
    client: virtualrobot.Client,
    robots: Sequence[str],
    files: Path,
    certificate: tuple[Path, Path] | None = None,
    **more: Any,  # noqa: ANN401
) -> Iterator[Served]:
    """Give a controller that is served."""
    one = Served(client, robots, files, certificate, **more)
    try:
        yield one
    finally:
        one.close()


def load(client: RWS, text: str, task: str = "T_ROB1", **more: str) -> None:
    """Load a module, as programs do: upload its file, and tell the controller to load it."""
    client.upload_file("$HOME/tried.mod", text.encode())
    client._do_post(f"rw/rapid/tasks/{task}?action=loadmod", {"modulepath": "$HOME/tried.mod", **more})


def stands(client: RWS) -> Callable[[], bool]:
    """Return what tells whether no program runs."""
    return lambda: client.get_execution_state().ctrlexecstate == "stopped"


def run(client: RWS, text: str, **more: Any) -> None:  # noqa: ANN401 arguments of start
    """Load a module, and run its main once, to the end."""
    load(client, text, replace="true")
    client.resetpp()
    client.start(cycle="once", **more)
    until(stands(client))
