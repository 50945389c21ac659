"""Plots of pages: which streams curves are of, and which samples of them are kept."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any, cast

import pytest
from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError, WrongStateError
from virtualrobot.streams.sample import Sample
from virtualrobot_apps.console.plots import APART_SECONDS, MOST_PLOTS, SPAN_SECONDS, Plots, curves_of
from virtualrobot_apps.topic.curves import streams_of

from tests.waiting import until

TICK_SECONDS = 0.004
A, B = "/robots/a/tcp", "/signals/b"


class Scripted:
    """A kernel whose streams tell what the test has them tell."""

    def __init__(self) -> None:
        """Tell nothing to begin with."""
        self.waiting: queue.Queue[Sample] = queue.Queue()
        self.open = 0
        self.streams = SimpleNamespace(watch=self._watch, table=list)

    def connect(self, token: str) -> Client:
        self.open += 1
        return cast(Client, self)

    def close(self) -> None:
        self.open -= 1

    def tell(self, stream: str, time: float, **values: float) -> None:
        self.waiting.put(Sample(stream, round(time / TICK_SECONDS), time, 0.0, values, 0))

    def _watch(self, *names: str) -> Any:  # noqa: ANN401  as much of a StreamWatch as is used
        def following(timeout: float) -> Sample | None:
            try:
                return self.waiting.get(timeout=0.01)
            except queue.Empty:
                return None

        rows = [SimpleNamespace(name=name) for name in names]
        return SimpleNamespace(streams=rows, next=following, close=lambda: None)


@contextmanager
def plots() -> Iterator[tuple[Scripted, Plots]]:
    kernel = Scripted()
    drawn = Plots(kernel.connect)
    try:
        yield kernel, drawn
    finally:
        drawn.close()
        until(lambda: kernel.open == 0)


def test_curves_name_their_streams() -> None:
    assert streams_of([f"{A}:x - {A}:y", B, "/nodes/*/pose:z"]) == [A, B, "/nodes/*/pose"]
    for said in ([], ["", "a"], "a", None, ["a"] * 17, [1]):
        with pytest.raises(InvalidArgumentError, match="1 to 16 texts"):
            curves_of(said)


def test_samples_are_thinned_and_held_and_the_newest_is_there() -> None:
    with plots() as (kernel, drawn):
        wanted = [f"{A}:x", B]
        assert drawn.read("", "page", wanted) == {"times": [], "curves": [], "known": []}
        count = 1000
        for number in range(count):
            kernel.tell(A, number * TICK_SECONDS, x=float(number))
        last = (count - 1) * TICK_SECONDS
        until(lambda: drawn.read("", "page", wanted)["times"][-1:] == [pytest.approx(last)])
        said = drawn.read("", "page", wanted)
        (curve,) = said["curves"]  # the signal has told nothing yet
        assert curve["values"][0] == 0.0 and curve["values"][-1] == count - 1.0
        assert len(said["times"]) <= last / (APART_SECONDS - TICK_SECONDS) + 2
        for time, value in zip(said["times"], curve["values"], strict=True):
            assert value == pytest.approx(time / TICK_SECONDS)

        # What is told seldom is held from then on, and is no number before.
        kernel.tell(B, 2.0, value=7.0)
        until(lambda: len(drawn.read("", "page", wanted)["curves"]) == 2)
        said = drawn.read("", "page", wanted)
        held = said["curves"][1]
        assert held["name"] == f"{B}:value"
        for time, value in zip(said["times"], held["values"], strict=True):
            assert value == (7.0 if time >= 2.0 else None)

        # The past beyond the span is forgotten, and all of it where time goes back: that is another run.
        later = last + SPAN_SECONDS + 1.0
        kernel.tell(A, later, x=0.0)
        until(lambda: drawn.read("", "page", [*wanted])["times"][-1] == pytest.approx(later))
        assert len(drawn.read("", "page", wanted)["curves"][0]["values"]) <= 3
        kernel.tell(A, 1.0, x=5.0)
        until(lambda: drawn.read("", "page", wanted)["times"] == [1.0])


def test_each_page_has_its_own_and_there_are_not_too_many() -> None:
    with plots() as (kernel, drawn):
        for number in range(MOST_PLOTS):
            drawn.read("", str(number), [A])
        drawn.read("", "0", [B])  # in place of what it drew before
        until(lambda: kernel.open == MOST_PLOTS)
        with pytest.raises(WrongStateError, match="8 plots are drawn already"):
            drawn.read("", "one more", [A])
