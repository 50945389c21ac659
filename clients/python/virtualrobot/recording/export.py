"""Exports: recordings of what a project folder tells of a run that is over, made by its replay."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Unpack

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.options import check_options
from virtualrobot.clock import ClockState
from virtualrobot.connecting import connect
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.kernel_process import KernelProcess
from virtualrobot.recording.recording import Recorded, Recording
from virtualrobot.recording.start import RecordingOptions, checked_path, start, usual_rate

_TICKS_TOGETHER = 50
"""Number of ticks after which `told` is called."""


@checked
def export_run(
    folder: str | Path,
    path: str | Path,
    *,
    begin: float | None = None,
    end: float | None = None,
    told: Callable[[Recording, float], None] | None = None,
    **options: Unpack[RecordingOptions],
) -> Recorded:
    """Record a run that is over to a file, and return what is in it: each tick, or at most `rate` a second.

    A kernel of its own replays what `virtualrobot serve --data FOLDER` has kept, with its sensors cast anew; the folder
    stays as it is, and may be in use. Ctrl-C leaves a whole file with what was recorded until then, and is raised.

    Args:
        folder: the project folder.
        path: the file; its ending says the format, as of `Client.record`.
        begin: simulation time to begin with (s); by default the first that is kept.
        end: simulation time to end with (s); by default the last one.
        told: called again and again with the recording and how long it will be (s).
        options: those of `Client.record`.

    Raises:
        InvalidArgumentError: when there is no such folder, it tells nothing of such times, or the file cannot be
            written.
        KernelGoneError: when the folder cannot be read; the replay has said why.

    Example:
        >>> from virtualrobot.recording.export import export_run
        >>> export_run("cell", "run.mcap", begin=60.0, end=90.0, rate=50.0)
    """
    check_options(options, RecordingOptions, "a recording")
    checked_path(path, options)  # before a kernel is started for nothing
    if not (Path(folder) / "project.json").is_file():
        raise InvalidArgumentError(f"{folder} is no project folder, it has no project.json")
    rate = options.pop("rate", None) or usual_rate(path)
    with KernelProcess(headless=True, replay=folder) as kernel, connect(kernel.address) as client:
        clock = client.clock.read()
        first, last = _ticks(clock, begin, end)
        if first != clock.stamp.tick:
            client.clock.seek(first * clock.tick_length)
        stride = 1 if rate is None else max(1, round(1.0 / (rate * clock.tick_length)))
        with start(client.services, path, None, options, complete=True) as recording:
            for tick in range(first, last, together := stride * max(1, _TICKS_TOGETHER // stride)):
                recording.step(min(together, last - tick), every=stride)
                if told is not None:
                    told(recording, (last - first) * clock.tick_length)
            return recording.finish()


def _ticks(clock: ClockState, begin: float | None, end: float | None) -> tuple[int, int]:
    """Return the first and the last tick of an export."""
    assert clock.recorded is not None  # it is a replay's
    kept = clock.recorded
    for name, seconds in (("begin", begin), ("end", end)):
        if seconds is not None and not kept[0] - clock.tick_length <= seconds <= kept[1] + clock.tick_length:
            raise InvalidArgumentError(f"{name} is {seconds:g} s; what is kept goes from {kept[0]:g} to {kept[1]:g} s")
    first, last = (round(seconds / clock.tick_length) for seconds in kept)
    first = first if begin is None else max(first, math.floor(begin / clock.tick_length + 0.5))
    last = last if end is None else min(last, math.floor(end / clock.tick_length + 0.5))
    if last < first:
        seconds = first * clock.tick_length, last * clock.tick_length
        raise InvalidArgumentError(
            f"an export ends after it begins: from {seconds[0]:g} to {seconds[1]:g} s is nothing"
        )
    return first, last
