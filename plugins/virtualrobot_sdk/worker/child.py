"""The worker process: reads what is asked from its standard input, answers, and ends when the input ends."""

from __future__ import annotations

import faulthandler
import gc
import io
import os
import select
import signal
import sys
import threading
import time

from virtualrobot_sdk.worker.answers import Outcome, pack
from virtualrobot_sdk.worker.frames import read_frame, write_frame
from virtualrobot_sdk.worker.host import Host, pack_error
from virtualrobot_sdk.worker.kept import Kept

ORPHAN_SECONDS = 2.0
"""Time after the end of its parent (s) for which the process may go on with what it does, before it is ended."""
FUSE_SECONDS = 60.0
"""Time after a call's deadline (s) at which the process ends itself; the parent kills it long before, if it lives."""


def main() -> None:
    """Serve the parent until it closes the pipe."""
    requests, answers = _take_pipes()
    # What modules make as they are loaded stays: to look for garbage among it takes time, now and as the process ends.
    gc.disable()
    # Ctrl-C in a terminal reaches all its processes; the parent decides when this one ends.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    faulthandler.enable(all_threads=False)
    if sys.platform != "win32":
        # The parent asks where a call hangs, before it kills.
        faulthandler.register(signal.SIGUSR1, all_threads=True)
        threading.Thread(target=_end_with_parent, args=(requests,), name="orphan-guard", daemon=True).start()
    write_frame(answers, 0, pack(Outcome.RESULT, None))
    host, kept, starting = Host(), Kept(), True
    while (frame := read_frame(requests)) is not None:
        number, content = frame
        try:
            operation, seconds, arguments = kept.unpack(content)
        except Exception as error:
            # An argument of a type that this process cannot import.
            write_frame(answers, number, pack_error(error, ""))
            continue
        _light_fuse(seconds + FUSE_SECONDS)
        answer = host.answer(operation, arguments)
        if starting:
            gc.freeze()
            gc.enable()
            starting = False
        _put_out_fuse()
        write_frame(answers, number, answer)


def _take_pipes() -> tuple[io.FileIO, io.FileIO]:
    """Return the pipes from and to the parent; leave an empty input and the error output to the plugin's code.

    So nothing that a plugin or a C library prints gets between the answers, and nothing that it reads is a question.
    """
    requests, answers = io.FileIO(os.dup(0), "rb"), io.FileIO(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # A block buffer would lose what was printed before a crash.
            stream.reconfigure(encoding="utf-8", errors="backslashreplace", line_buffering=True)
    if hasattr(os, "register_at_fork"):
        # A process that the plugin forks must neither answer nor keep the pipes open when this one is gone.
        os.register_at_fork(after_in_child=lambda: (requests.close(), answers.close()))
    return requests, answers


def _end_with_parent(requests: io.FileIO) -> None:
    """End this process soon after its parent, also in the middle of a call that waits for something."""
    poll = select.poll()
    poll.register(requests, 0)  # The end of the other side is told without being asked for.
    poll.poll()
    time.sleep(ORPHAN_SECONDS)
    os._exit(1)


if sys.platform == "win32":

    def _light_fuse(seconds: float) -> None:
        faulthandler.dump_traceback_later(seconds, exit=True)

    def _put_out_fuse() -> None:
        faulthandler.cancel_dump_traceback_later()

else:

    def _light_fuse(seconds: float) -> None:
        """End this process in `seconds` whatever it does: native code that never lets a thread run stops no alarm."""
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_REAL, seconds)

    def _put_out_fuse() -> None:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
