"""Kernels and bare servers in processes of their own, for benchmarks."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path

HERE = Path(__file__).resolve().parent


@contextlib.contextmanager
def process(command: Sequence[str], ready: str) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """Start a process, wait for the line that begins with `ready`, yield what follows, and end the process."""
    # Whatever the shell says, bytecode is kept, as it is in an installation.
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    started = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    assert started.stdout
    reader = threading.Thread(target=started.stdout.read, daemon=True)
    try:
        for line in started.stdout:
            if line.startswith(ready):
                reader.start()
                yield line.removeprefix(ready).strip(), started
                break
        else:
            raise RuntimeError(f"{' '.join(command)} ended before it was ready")
    finally:
        started.terminate()
        started.wait(30)
        if reader.is_alive():
            reader.join()
        started.stdout.close()


def kernel(*options: str) -> contextlib.AbstractContextManager[tuple[str, subprocess.Popen[str]]]:
    """Start a kernel without token on a free port; yields its address (or its viewer's, when it has one)."""
    command = [sys.executable, "-m", "virtualrobot_kernel.serve", "--port", "0", "--no-token", *options]
    return process(command, "listening on ")


def echo() -> contextlib.AbstractContextManager[tuple[str, subprocess.Popen[str]]]:
    """Start the bare grpc.aio server of `echo_server.py`; yields its address."""
    return process([sys.executable, str(HERE / "echo_server.py")], "listening on ")


def forwarder(address: str, stream: str) -> contextlib.AbstractContextManager[tuple[str, subprocess.Popen[str]]]:
    """Start the bare bridge of `forwarder.py` for a stream of a kernel; yields its port."""
    return process([sys.executable, str(HERE / "forwarder.py"), address, stream], "listening on ")
