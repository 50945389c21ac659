"""Curves over time that pages draw: numbers of any streams, as `virtualrobot topic plot` has them, of the last minute.

Each plot of a page is watched by a thread of its own, which ends when the page asks no more.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from threading import Event, Lock, Thread
from typing import Any

from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError, VirtualRobotError, WrongStateError
from virtualrobot.streams.sample import Sample

from virtualrobot_apps.topic.curves import Curve, chosen, of_samples, streams_of, together

Connect = Callable[[str], Client]
"""Gives a client of the kernel with a token."""

SPAN_SECONDS = 60.0
"""Simulation time (s) for which samples are kept."""
APART_SECONDS = 0.03
"""Samples of a stream are kept that are about so far apart in simulation time: more than a page has pixels for."""
MOST_CURVES = 16
MOST_PLOTS = 8
"""Plots that are watched at a time, of all pages."""
MOST_SAMPLES = 20_000
IDLE_SECONDS = 10.0
"""Time (s) of the wall clock after which a plot ends that nobody has asked for."""

_LOOKED_SECONDS = 0.2


class Plots:
    """The plots of one console. Its methods wait for the kernel, so that they are called in threads."""

    def __init__(self, connect: Connect) -> None:
        """Watch with clients of `connect`."""
        self._connect = connect
        self._lock = Lock()
        self._plots: dict[tuple[str, str], _Plot] = {}

    def streams(self, token: str) -> list[dict[str, Any]]:
        """Return the streams that a kernel tells, with their units."""
        with self._connect(token) as client:
            return [{"name": one.name, "unit": one.unit} for one in client.streams.table() if one.direction != "in"]

    def read(self, token: str, page: str, wanted: Sequence[str]) -> dict[str, Any]:
        """Return curves as they have been since the page first asked for them, for SPAN_SECONDS at most.

        Args:
            token: of who asks.
            page: names the plot of one page.
            wanted: curves as `topic plot` takes them: `STREAM:FIELD`, patterns, and `A - B`.

        Returns:
            `times` (n,) in s of simulation time, the `curves`, each with `name` and `values` (n,), held from one sample
            to the next, and the names of all that may be `known`.

        Raises:
            InvalidArgumentError: too many curves.
            UnknownNameError: there is no such stream, or no such number of it.
            WrongStateError: too many plots are watched.
        """
        with self._lock:
            self._plots = {key: one for key, one in self._plots.items() if not one.is_over}
            plot = self._plots.get((token, page))
            if plot is None or plot.wanted != tuple(wanted):
                if plot is not None:
                    self._plots.pop((token, page)).close()
                if len(self._plots) >= MOST_PLOTS:
                    raise WrongStateError(f"{MOST_PLOTS} plots are drawn already: close one of them, on any page")
                plot = self._plots[token, page] = _Plot(self._connect, token, tuple(wanted))
        return plot.read()

    def close(self) -> None:
        """End all."""
        with self._lock:
            for plot in self._plots.values():
                plot.close()
            self._plots.clear()


class _Plot:
    """Samples of the streams of some curves, taken by a thread until it `is_over`."""

    def __init__(self, connect: Connect, token: str, wanted: tuple[str, ...]) -> None:
        self.wanted = wanted
        self.is_over = False
        self._client = connect(token)
        try:
            self._watch = self._client.streams.watch(*streams_of(wanted))
        except BaseException:
            self._client.close()
            raise
        self._samples: dict[str, deque[Sample]] = {}
        self._lock, self._closing, self._asked = Lock(), Event(), time.monotonic()
        Thread(target=self._run, name="plot", daemon=True).start()

    def read(self) -> dict[str, Any]:
        self._asked = time.monotonic()
        with self._lock:
            samples = sorted((one for of in self._samples.values() for one in of), key=lambda one: one.time)
        curves = of_samples(samples)
        nothing = {"times": [], "curves": [], "known": sorted(curves)}
        found = self._chosen(curves)
        if not found:
            return nothing
        if len(found) > MOST_CURVES:
            raise InvalidArgumentError(f"these are {len(found)} curves; at most {MOST_CURVES} are drawn together")
        times, columns = together(found)
        begin = min(float(one.times[0]) for one in found)
        return {
            **nothing,
            "times": (times + begin).tolist(),
            "curves": [
                # What wasn't told yet is no number, and JSON has none for that.
                {"name": one.name, "values": _from(float(one.times[0]) - begin, times.tolist(), column.tolist())}
                for one, column in zip(found, columns.T, strict=True)
            ],
        }

    def _chosen(self, curves: Mapping[str, Curve]) -> list[Curve]:
        """Return the curves that are wanted, but those of streams that have told nothing yet."""
        silent = {one.name for one in self._watch.streams} - self._samples.keys()
        told = [one for one in self.wanted if not silent.intersection(streams_of([one]))]
        return list({one.name: one for one in chosen(curves, told)}.values()) if curves else []

    def close(self) -> None:
        self._closing.set()
        self._watch.close()

    def _run(self) -> None:
        try:
            while not self._closing.is_set() and time.monotonic() < self._asked + IDLE_SECONDS:
                if (sample := self._watch.next(_LOOKED_SECONDS)) is not None:
                    self._take(sample)
        except VirtualRobotError:
            pass  # a new one, for whoever asks again, is told what is wrong
        finally:
            self.is_over = True
            self._watch.close()
            self._client.close()

    def _take(self, sample: Sample) -> None:
        with self._lock:
            of = self._samples.setdefault(sample.stream, deque(maxlen=MOST_SAMPLES))
            if of and sample.time < of[-1].time:  # another run
                self._samples.clear()
                of = self._samples.setdefault(sample.stream, deque(maxlen=MOST_SAMPLES))
            if len(of) > 1 and sample.time < of[-2].time + APART_SECONDS:
                of.pop()  # the newest is always there
            of.append(sample)
            while len(of) > 1 and of[0].time < sample.time - SPAN_SECONDS:
                of.popleft()


def curves_of(said: object) -> list[str]:
    """Return the curves that a page asks for; raises InvalidArgumentError where they are none."""
    if isinstance(said, list) and 0 < len(said) <= MOST_CURVES and all(isinstance(one, str) and one for one in said):
        return said
    raise InvalidArgumentError(f"'curves' is a list of 1 to {MOST_CURVES} texts such as /robots/arm/tcp:speed")


def _from(first: float, times: Sequence[float], values: Sequence[float]) -> list[float | None]:
    """Return values of which there are none before the time `first`."""
    return [value if time >= first else None for time, value in zip(times, values, strict=True)]
