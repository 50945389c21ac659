"""Editor of a page: a language server and a debug adapter in one process, for texts that are on another machine.

Messages on the standard streams are `{"lsp": MESSAGE}` and `{"dap": MESSAGE}`, each way, behind the header of the
protocols. The debug adapter is a new one after each program; both end with the standard input, and the program stops.
"""

from __future__ import annotations

import argparse
import queue
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from virtualrobot.cli.options import Target

from virtualrobot_apps.languages.editor.channel import Channel, ChannelError, serve
from virtualrobot_apps.languages.editor.dap import DebugAdapter
from virtualrobot_apps.languages.editor.launch import Launch, WrongLaunch, launched_from_elsewhere
from virtualrobot_apps.languages.editor.lsp import LanguageServer

LANES = LSP, DAP = "lsp", "dap"
"""Names of the protocols in messages."""


class _Lane:
    """Channel of one protocol."""

    def __init__(self, name: str, whole: Channel) -> None:
        """Send through the channel of both."""
        self._name, self._whole = name, whole
        self.come: queue.SimpleQueue[Any] = queue.SimpleQueue()

    def read(self) -> Any | None:  # noqa: ANN401 JSON
        return self.come.get()

    def send(self, message: dict[str, Any]) -> None:
        self._whole.send({self._name: message})


class PageEditor:
    """Both servers of one page."""

    def __init__(self, channel: Channel, target: Target, refusal: str = "") -> None:
        """Speak by a channel; programs move robots of the kernel `target`, unless a refusal says why they may not."""
        self._channel, self._target, self._refusal = channel, target, refusal
        self._lanes = {name: _Lane(name, channel) for name in LANES}
        self._ended = False

    def run(self) -> int:
        """Serve until the page is gone, and end its program; return the exit code."""
        language = LanguageServer(self._lanes[LSP], reads_files=False)
        serving = [
            threading.Thread(target=work, name=name, daemon=True)
            for name, work in (("language server", language.run), ("debug adapter", self._debug))
        ]
        for one in serving:
            one.start()
        try:
            while (message := self._next()) is not None:
                for name in LANES:
                    if name in message:
                        self._lanes[name].come.put(message[name])
        except (ChannelError, OSError):
            return 1
        finally:
            self._ended = True
            for lane in self._lanes.values():
                lane.come.put(None)
            for one in serving:
                one.join()
        return 0

    def _next(self) -> dict[str, Any] | None:
        while True:
            try:
                message = self._channel.read()
            except ValueError:
                continue  # a text that is no JSON
            if message is None or isinstance(message, dict):
                return message

    def _debug(self) -> None:
        while not self._ended:
            DebugAdapter(self._lanes[DAP], self._target, self._launched).run()

    def _launched(self, given: Mapping[str, Any], target: Target, write: Callable[[str], None]) -> Launch:
        if self._refusal:
            raise WrongLaunch(self._refusal)
        return launched_from_elsewhere(given, target, write)


def main() -> int:
    """Serve the page that the console's server has at the standard streams; its token is VIRTUALROBOT_TOKEN."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--address", required=True)
    parser.add_argument("--certificate", type=Path)
    parser.add_argument("--refusal", default="")
    given = parser.parse_args()
    target = Target(given.address, certificate=given.certificate)
    return serve(lambda channel: PageEditor(channel, target, given.refusal).run(), None)


if __name__ == "__main__":
    raise SystemExit(main())
