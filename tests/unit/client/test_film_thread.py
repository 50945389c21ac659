"""The last picture of a film: it is waited for wherever the film began, though times of ticks are rounded."""

from __future__ import annotations

from collections.abc import Iterator
from threading import Event
from types import SimpleNamespace

import pytest
from virtualrobot.view.film import FilmThread

TICK, RATE, BETWEEN, PICTURES = 0.004, 25.0, 10, 12
"""Seconds of a tick, pictures a second, ticks between two of them, and how many there are."""


class File:
    """File that counts its pictures."""

    def __init__(self) -> None:
        """Begin without a picture."""
        self.rate, self.count = RATE, 0

    def add(self, pixels: object) -> None:
        del pixels
        self.count += 1

    def __enter__(self) -> File:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Do nothing."""


class Pictures:
    """Pictures as a kernel sends them that draws the last one only when it is waited for."""

    def __init__(self, begin: int) -> None:
        """Take the tick of the first one."""
        self.begin, self.asked, self.cancelled = begin, Event(), Event()

    def now(self) -> float:
        self.asked.set()
        return (self.begin + (PICTURES - 1) * BETWEEN) * TICK

    def __iter__(self) -> Iterator[SimpleNamespace]:
        """Yield them."""
        for number in range(PICTURES):
            if number == PICTURES - 1 and (not self.asked.wait(60.0) or self.cancelled.wait(0.05)):
                return
            yield SimpleNamespace(pixels=None, simulation_time=(self.begin + number * BETWEEN) * TICK, number=number)
        self.cancelled.wait(60.0)

    def cancel(self) -> None:
        self.cancelled.set()


@pytest.mark.parametrize("begin", [0, 9, 17, 34, 50, 135, 100_003])
def test_the_last_picture_is_waited_for(begin: int) -> None:
    """At ticks of which some have times whose sum with a period is rounded up beyond the end."""
    pictures = Pictures(begin)
    film = FilmThread(File(), pictures, pictures.now)  # pyright: ignore[reportArgumentType]  as far as they are used
    assert film.finish() == PICTURES
