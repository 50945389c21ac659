"""The controller's ports: dashboard, scripts (primary, secondary, real-time) and RTDE. One thread, by cycles."""

from __future__ import annotations

import socket
import struct
import time
from collections.abc import Callable

from virtualrobot_apps.emulators.ur import dashboard, exchange
from virtualrobot_apps.emulators.ur.controller import Controller
from virtualrobot_apps.emulators.ur.scripts import run_script
from virtualrobot_apps.languages.urscript.pieces import pieces

DASHBOARD, PRIMARY, SECONDARY, REALTIME, RTDE = 29999, 30001, 30002, 30003, 30004
PORTS = (DASHBOARD, PRIMARY, SECONDARY, REALTIME, RTDE)
_SLOW = 1 << 20
"""Bytes that wait for a client at which it is let go: it reads nothing."""
_LATE = 0.1
"""Lateness (s) after which cycles are not made up for: the emulated controller has stood still."""
_LONGEST = 1 << 22
"""Bytes of a script or a line that isn't whole at which its client is let go."""
_MOST_READ = 1 << 20
"""Bytes that are taken of a client in one cycle; more stay for the next."""
_MOST_NEW = 64
"""Connections to a port that are taken in one cycle."""
_STATE_SECONDS = 0.1


class Client:
    """A connection."""

    def __init__(self, connection: socket.socket, port: int, session: exchange.Session | None) -> None:
        """Take an accepted connection."""
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.connection, self.port, self.session = connection, port, session
        self.got, self.waiting, self.ended = bytearray(), bytearray(), False
        self.refused: set[str] = set()
        """Words of what is left out of what it sends, each told once."""
        self.looked = 0
        """Number of bytes of a script that isn't whole yet, as it was looked at."""

    def receive(self) -> None:
        """Take what has come; `ended` where nothing more will."""
        try:
            for _ in range(_MOST_READ // 65536):
                data = self.connection.recv(65536)
                self.got += data
                if not data:
                    self.ended = True
                    return
        except BlockingIOError:
            pass
        except OSError:
            self.ended = True

    def send(self, data: bytes = b"") -> None:
        """Send, or keep what the client doesn't take yet."""
        self.waiting += data
        if not self.waiting:
            return
        try:
            del self.waiting[: self.connection.send(self.waiting)]
        except BlockingIOError:
            pass
        except OSError:
            self.ended = True
        self.ended |= len(self.waiting) > _SLOW

    def close(self) -> None:
        """Give everything back."""
        if self.session is not None:
            self.session.close()
        self.connection.close()


class Server:
    """Listens at the ports of a controller; `cycle` serves all that has come and lets the controller go on."""

    def __init__(
        self, controller: Controller, host: str = "127.0.0.1", tell: Callable[[str], object] = lambda words: None
    ) -> None:
        """Listen at an address; raises OSError where one of the ports is taken. `tell` gets the controller's words."""
        self.controller, self.host, self._tell = controller, host, tell
        controller.attended = True
        self.clients: list[Client] = []
        self._taken: set[str] = set()
        self._listening: dict[int, socket.socket] = {}
        try:
            for port in PORTS:
                listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
                self._listening[port] = listening
                listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                listening.bind((host, port))
                listening.listen(_MOST_NEW)
                listening.setblocking(False)
        except OSError:
            self.close()
            raise

    def cycle(self) -> None:
        """Serve all clients, and let the controller do one cycle."""
        controller = self.controller
        for port, listening in self._listening.items():
            self._accept(port, listening)
        for client in self.clients:
            client.receive()
            if client.port == DASHBOARD:
                self._answer(client)
            elif client.session is not None:
                self._exchange(client, client.session)
            else:
                self._script(client)
        controller.cycle()
        told = None
        words, controller.words = controller.words, []
        for _, _, text in words:
            self._tell(text)
        logged, controller.logged = controller.logged, []
        # A fault ends a script: what the script has said in the same cycle comes before.
        said = b"".join(line(controller.cycles, text) for text in logged)
        said += b"".join(message(controller.cycles, *one) for one in words)
        if controller.cycles % max(1, round(_STATE_SECONDS * controller.rate)) == 0:
            said += state(controller)
        for client in self.clients:
            if client.session is not None:
                if client.session.due():
                    told = told or controller.tell()
                    client.send(client.session.tell(told))
            elif client.port in (PRIMARY, SECONDARY):
                client.send(said)
            client.send()
            if client.ended:
                client.close()
        self.clients = [client for client in self.clients if not client.ended]

    def _accept(self, port: int, listening: socket.socket) -> None:
        controller = self.controller
        for _ in range(_MOST_NEW):
            try:
                connection, _ = listening.accept()
            except OSError:  # nobody waits, is gone again, or this process may have no more of them
                return
            session = exchange.Session(controller.rate, controller.version, self._taken) if port == RTDE else None
            client = Client(connection, port, session)
            if port == DASHBOARD:
                client.send(dashboard.BANNER.encode() + b"\n")
            self.clients.append(client)

    def _answer(self, client: Client) -> None:
        while b"\n" in client.got:
            line, _, rest = client.got.partition(b"\n")
            client.got = rest
            client.send(dashboard.answer(self.controller, line.decode(errors="replace")).encode() + b"\n")
            client.ended |= line.strip().lower() == b"quit"
        client.ended |= len(client.got) > _LONGEST

    def _exchange(self, client: Client, session: exchange.Session) -> None:
        try:
            for kind, body in exchange.packets(client.got):
                try:
                    client.send(session.take(kind, body))
                except exchange.NotFinite as error:
                    if str(error) not in client.refused:
                        client.refused.add(str(error))
                        self._tell(f"RTDE: {error}; packets with it are left out")
        except (ValueError, struct.error):
            client.ended = True
        if session.set:
            taken, session.set = session.set, {}
            self.controller.take(taken)

    def _script(self, client: Client) -> None:
        """Run scripts once they are whole: a definition with its `end`, or lines."""
        if len(client.got) == client.looked and not client.ended:
            return
        whole, rest = pieces(client.got.decode(errors="replace"))
        if client.ended and rest.strip():
            whole, rest = [*whole, rest], ""
        client.got[:] = rest.encode()
        client.looked = len(client.got)
        client.ended |= client.looked > _LONGEST
        for text in whole:
            run_script(self.controller, text)

    def run(self, over: Callable[[], bool]) -> None:
        """Go on in real time until `over`, or the arm is gone."""
        due = time.monotonic()
        while not over() and not self.controller.off:
            due += self.controller.dt
            left = due - time.monotonic()
            if left > 0.0:
                time.sleep(left)
            elif left < -_LATE:
                due = time.monotonic()
            self.cycle()

    def close(self) -> None:
        """Close all connections, and listen no more."""
        for client in self.clients:
            client.close()
        for listening in self._listening.values():
            listening.close()


def message(cycles: int, code: int, argument: int, text: str) -> bytes:
    """Return a message of the primary interface: an error's number and words (robotCommMessage)."""
    body = struct.pack(">QBBiiiII", cycles, 253, 6, code, argument, 3, 0, 0) + text.encode()
    return struct.pack(">iB", len(body) + 5, 20) + body


def line(cycles: int, text: str) -> bytes:
    """Return a line of the log as the primary interface tells it (robotMessageText)."""
    body = struct.pack(">QBB", cycles, 253, 0) + text.encode()
    return struct.pack(">iB", len(body) + 5, 20) + body


def state(controller: Controller) -> bytes:
    """Return the robot's state as the primary interface tells it: the part with modes alone (RobotModeData)."""
    body = struct.pack(
        ">iBQ7?Bb4d",
        *(42 + 5, 0, controller.cycles, True, True, controller.mode >= 4, controller.safety == 7),
        *(controller.safety == 3, controller.playing, controller.paused, controller.mode, 0),
        *(controller.slider, controller.slider, 1.0, 0.0),
    )
    body = struct.pack(">i", len(body)) + body[4:]
    return struct.pack(">iB", len(body) + 5, 16) + body
