"""The port at which a teacher or a test asks the computed controller for faults: one line a datagram, one answer."""

from __future__ import annotations

import contextlib
import json
import socket
from typing import get_args

from virtualrobot_sdk.drivers import DriverFault

from virtualrobot_plugins.drivers.loopback.controller import Controller
from virtualrobot_plugins.drivers.loopback.settings import Fault, What

_WORDS = (*get_args(What), "mend", "inputs", "state")


class ControlPort:
    """Owns the socket on 127.0.0.1; `serve` answers what has come, at once."""

    def __init__(self, port: int, controller: Controller) -> None:
        """Listen; raises DriverFault where the port is taken."""
        self._controller = controller
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        try:
            self._socket.bind(("127.0.0.1", port))
        except OSError as error:
            self._socket.close()
            raise DriverFault(f"control_port {port} on 127.0.0.1 cannot be used: {error.strerror}") from error

    def serve(self) -> None:
        """Do what was asked for since the last time."""
        with contextlib.suppress(BlockingIOError, ConnectionResetError):
            while True:
                line, sender = self._socket.recvfrom(256)
                self._socket.sendto(self._answer(line.decode("utf-8", "replace")).encode(), sender)

    def close(self) -> None:
        """Listen no longer."""
        self._socket.close()

    def _answer(self, line: str) -> str:
        controller = self._controller
        what, *rest = line.split() or [""]
        if what not in _WORDS:
            return f"error: there is no {what!r}; there is {', '.join(_WORDS)}"
        try:
            if what == "inputs":
                (bits,) = map(int, rest)
                if not 0 <= bits < 2**64:
                    raise ValueError
                controller.inputs = bits
                return "ok"
            values = [float(word) for word in rest]
            if what in ("mend", "state"):
                () = values
                if what == "state":
                    return json.dumps(self._state())
                controller.mend()
            elif what == "slow":
                (share,) = values or [0.5]
                if not 0.0 <= share <= 1.0:
                    raise ValueError
                controller.cause(Fault("slow", controller.cycle, 0, share))
            else:
                joint, value = (*values, *([0.0, None][len(values) :]))
                if joint not in range(controller.settings.joints) or (value is not None and value - value != 0.0):
                    raise ValueError
                controller.cause(Fault(what, controller.cycle, int(joint), value))  # type: ignore[arg-type]
        except ValueError:
            most = controller.settings.joints - 1
            return f"error: {line.strip()!r}; write WHAT [JOINT 0 to {most} [VALUE]], slow [0 to 1] or inputs BITS"
        return "ok"

    def _state(self) -> dict[str, object]:
        controller = self._controller
        return {
            "cycle": controller.cycle,
            "positions": controller.q.tolist(),
            "mode": controller.mode().value,
            "safety": controller.safety().value,
            "outputs": controller.outputs,
            "faults": sorted(controller.active),
        }
