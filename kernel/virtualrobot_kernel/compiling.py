"""Compiles before a first start what is not compiled yet: by several processes, since numba keeps to one core."""

from __future__ import annotations

import contextlib
import importlib
import os
import pkgutil
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from virtualrobot_sdk.compiled import cache

from virtualrobot_kernel import numeric

MOST_PROCESSES = 4
"""Most processes that compile at once: each takes some 300 MB, and one function alone a tenth of the whole time."""

Progress = Callable[[int, int, str], None]
"""Called before each function that is compiled, with the number of those before it, that of all, and its name."""


def compile_code() -> None:
    """Compile what the kernel and the plugins that are imported need; on the first start say how far that is."""
    for module in pkgutil.iter_modules(numeric.__path__):  # so that it is among what is compiled
        importlib.import_module(f"{numeric.__name__}.{module.name}")

    def progress(done: int, total: int, name: str) -> None:
        print(f"compiling (first start only) {done + 1}/{total}: {name}", file=sys.stderr, flush=True)

    compile_side_by_side(progress)


def compile_side_by_side(progress: Progress) -> None:
    """Compile every function imported so far that is not in the cache, on several cores where there are some.

    What the others could not put into the cache, since this process alone sees its folder or its modules, is compiled
    here.
    """
    missing = [function for function in cache._compiled_functions if not function.is_cached()]
    processes = min(MOST_PROCESSES, os.cpu_count() or 1, len(missing))
    if processes > 1:
        _compile_by(processes, missing, progress)
    cache.compile_missing(progress)


def _compile_by(
    processes: int, missing: list[cache.CompiledFunction | cache.CompiledCallback], progress: Progress
) -> None:
    """Have processes fill the cache, each taking the next function when it has done one."""
    left = queue.SimpleQueue[tuple[int, cache.CompiledFunction | cache.CompiledCallback]]()
    for numbered in enumerate(missing):
        left.put(numbered)
    telling = threading.Lock()

    def feed(process: subprocess.Popen[str]) -> None:
        assert process.stdin and process.stdout
        with contextlib.suppress(queue.Empty, OSError):  # nothing is left; or the process has died
            while True:
                with telling:
                    done, function = left.get_nowait()
                    progress(done, len(missing), function.name)
                print(function.function.__module__, function.function.__name__, file=process.stdin, flush=True)
                if not process.stdout.readline() or not function.is_cached():
                    return

    command = [sys.executable, "-m", __name__]
    with contextlib.ExitStack() as ended:
        started = []
        for _ in range(processes):
            process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
            ended.enter_context(process)
            ended.callback(process.kill)
            started.append(process)
        with ThreadPoolExecutor(processes) as threads:
            try:
                list(threads.map(feed, started))
            except BaseException:
                for process in started:
                    process.kill()
                raise


def _compile_what_is_named() -> None:
    """Compile the functions that lines of the standard input name by module and name, and answer each with a line."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    for line in sys.stdin:
        module, name = line.split()
        with contextlib.suppress(Exception):  # who asked compiles it then, and tells what is wrong
            getattr(importlib.import_module(module), name).compile()
        print(flush=True)


if __name__ == "__main__":
    _compile_what_is_named()
