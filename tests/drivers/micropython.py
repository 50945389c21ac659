"""A microcontroller under CPython: `python micropython.py BOARD.py READY`; its cable is standard input and output.

The descriptor READY is closed when the program begins.

Stand-ins have what the program may use of MicroPython's `machine`, `time` and `sys`, and nothing else of it.
"""

from __future__ import annotations

import os
import runpy
import sys
import time
from types import ModuleType


class Pin:
    """A pin: an input reads 1, which is what a pull-up gives."""

    IN, OUT, PULL_UP = 0, 1, 1

    def __init__(self, number: int, mode: int = OUT, pull: int | None = None) -> None:
        """Be the pin with a number."""
        self.level = 1

    def value(self, level: int | None = None) -> int | None:
        """Return the level, or set it."""
        if level is None:
            return self.level
        self.level = level
        return None


class PWM:
    """A pin with pulses."""

    def __init__(self, pin: Pin, freq: int) -> None:
        """Pulse `freq` times a second."""
        self.freq = freq

    def duty_ns(self, length: int) -> None:
        """Set the length of the pulses (ns), which is shorter than their period."""
        assert isinstance(length, int) and 0 <= length < 1_000_000_000 // self.freq, length


class Input:
    """Standard input as MicroPython has it: what `select` says can be read can be read."""

    def fileno(self) -> int:
        """Return the descriptor."""
        return 0

    def read(self, count: int) -> str:
        """Return so many letters."""
        return os.read(0, count).decode("latin-1")


if __name__ == "__main__":
    machine = ModuleType("machine")
    machine.__dict__.update(PWM=PWM, Pin=Pin)
    sys.modules["machine"] = machine
    start = time.monotonic()
    # Its clock starts at 0 again, as on the board after twelve days, half a second after the program has begun.
    period = 2**30
    time.__dict__["ticks_ms"] = lambda: (int((time.monotonic() - start) * 1000) + period - 500) % period
    time.__dict__["ticks_diff"] = lambda a, b: (a - b + period // 2) % period - period // 2
    sys.stdin = Input()  # pyright: ignore[reportAttributeAccessIssue]
    sys.stdout = open(1, "w", buffering=1, newline="\r\n")
    os.close(int(sys.argv[2]))
    runpy.run_path(sys.argv[1], run_name="__main__")
