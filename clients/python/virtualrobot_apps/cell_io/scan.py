"""Cyclic programs, as a PLC runs them: read all inputs, compute, write all outputs, each cycle of the world's time."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping

from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError

Value = bool | int | float | str | tuple[bool, ...]

Program = Callable[[Mapping[str, Value], float], Mapping[str, Value]]
"""One scan: from the signals and the time since the beginning (s of simulation time), which signals become what."""


class ScanCycle:
    """A program that is run again and again, each time on one image of all signals.

    All of its outputs change at one instant. In stepped time it makes the ticks itself, by `step` where others go
    along, so that equal runs are equal to the tick. In real time it waits for the world; cycles that it comes too late
    for are left out and counted.

    Example:
        >>> ScanCycle(client, lambda signals, now: {"lamp": not signals["door closed"]}, cycle=0.02).run(cycles=50)
    """

    def __init__(
        self, client: Client, program: Program, cycle: float = 0.02, step: Callable[[int], object] | None = None
    ) -> None:
        """Prepare a program; it is not run yet.

        Args:
            client: the kernel's.
            program: one scan. It keeps what it has to remember, or signals do.
            cycle: time between two scans (s of simulation time), rounded to ticks.
            step: what makes ticks in stepped time, such as `Connections.step`; `client.clock.step` by default.

        Raises:
            InvalidArgumentError: when the cycle is shorter than a tick.
        """
        clock = client.clock.read()
        self._client, self._program = client, program
        self._step = step or client.clock.step
        self._tick_length = clock.tick_length
        self._ticks = round(cycle / clock.tick_length) if math.isfinite(cycle) else 0
        if self._ticks < 1:
            raise InvalidArgumentError(f"a cycle is at least a tick of {clock.tick_length:g} s long, not {cycle:g} s")
        self._begin = self._next = clock.stamp.tick
        self.left_out = 0
        """Number of cycles that it came too late for."""

    def run(self, cycles: int | None = None) -> None:
        """Run so many scans, each followed by its cycle; without a number until it is interrupted.

        Raises:
            UnknownNameError: when the program sets a signal that is not there.
            KernelGoneError: when the kernel ends.
        """
        done = 0
        while cycles is None or done < cycles:
            self._scan()
            done += 1
            self._next += self._ticks
            clock = self._client.clock.read()
            if clock.mode == "stepped":
                self._step(self._ticks)
                self._next = clock.stamp.tick + self._ticks
                continue
            while (missing := self._next - clock.stamp.tick) > 0:
                time.sleep(missing * clock.tick_length / clock.speed_factor)
                clock = self._client.clock.read()
            late = -missing // self._ticks
            self.left_out += late
            self._next += late * self._ticks

    def _scan(self) -> None:
        image = {one.name: one.value for one in self._client.signals.read()}
        outputs = self._program(image, (self._next - self._begin) * self._tick_length)
        if changed := {name: value for name, value in outputs.items() if name not in image or value != image[name]}:
            self._client.signals.set(changed)
