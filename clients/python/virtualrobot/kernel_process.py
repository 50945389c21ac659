"""A kernel as a child process of this program, which ends with it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

from virtualrobot._wire import interruptions
from virtualrobot._wire.arguments import checked
from virtualrobot.child_process import end_child, start_child
from virtualrobot.errors import KernelGoneError

_READY = "listening on "
_VIEWER = "viewer at "


@checked
class KernelProcess:
    """A kernel that was started on a free port of this machine; a context manager that ends it.

    It is a process of its own, so Ctrl-C reaches this program alone, which ends the kernel when it is done. Should this
    program be killed, the kernel's standard input ends and the kernel with it.

    Attributes:
        address: `host:port`, for `virtualrobot.connect`.
        viewer_url: the address of the picture for a browser; empty when headless.

    Example:
        >>> with KernelProcess() as kernel, virtualrobot.connect(kernel.address) as client:
        ...     print(kernel.viewer_url)
    """

    def __init__(
        self,
        *options: str,
        headless: bool = False,
        say: Callable[[str], object] | None = None,
        replay: str | Path | None = None,
    ) -> None:
        """Start it with more `options` of `virtualrobot serve` and wait until it answers.

        With `replay` it shows what that project folder has recorded, as `virtualrobot replay` does. `say` gets each
        other line that it prints. What it writes to the standard error stays there.

        Raises:
            KernelGoneError: when it ends before it answers.
        """
        does = ["serve"] if replay is None else ["replay", str(replay)]
        command = [*does, "--port", "0", "--end-with-input", *options]
        if headless:
            command.append("--headless")
        self.address = self.viewer_url = ""
        self._headless, self._say = headless, say
        self._ready = threading.Event()
        self._process = start_child(*command)
        threading.Thread(target=self._read, name="kernel output", daemon=True).start()
        try:
            while not self._ready.wait(0.5):  # a wait without limit cannot be interrupted on Windows
                interruptions.check()
        except BaseException:
            self.close()
            raise
        if not self.address:
            code = self.close()
            raise KernelGoneError(
                f"the kernel ended with code {code} before it answered; it has said why above", "NOT_RUNNING"
            )

    def close(self, timeout: float = 20.0) -> int:
        """End the kernel and return its exit code; one that does not end in time (s) is killed."""
        return end_child(self._process, timeout)

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as lines:
            for line in lines:
                text = line.rstrip()
                if text.startswith(_READY):
                    self.address = text.removeprefix(_READY)
                elif text.startswith(_VIEWER):
                    self.viewer_url = text.removeprefix(_VIEWER)
                elif self._say is not None:
                    self._say(text)
                if self.address and (self._headless or self.viewer_url):
                    self._ready.set()
        self._ready.set()

    def __enter__(self) -> KernelProcess:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the kernel."""
        self.close()

    def __repr__(self) -> str:
        """Return a line for people."""
        viewer = f", viewer at {self.viewer_url}" if self.viewer_url else ""
        return f"<KernelProcess {self._process.pid} at {self.address}{viewer}>"
