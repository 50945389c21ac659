"""A film of what a program does: time goes as slowly as it is drawn, and whoever watches is told how far it is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError
from virtualrobot.view.pictures import Picture

from virtualrobot_apps.demos.palletizing.pacing import Pace

FILM_RATE = 25.0
"""Pictures a second of simulation time."""


@contextmanager
def filmed(client: Client, path: Path) -> Iterator[None]:
    """Film what happens within the block; it is drawn to its end, however long that takes."""
    pace = Pace(client.clock, FILM_RATE)

    def told(picture: Picture) -> None:
        before = pace.slow
        pace.told(picture)
        if pace.slow and not before:
            print(f"film: {picture.behind:,} pictures wait, so time goes as slowly as they are drawn", flush=True)
        tell(picture)

    try:
        with client.view.start_film(path, rate=FILM_RATE, told=told):
            yield
    finally:
        with suppress(VirtualRobotError):  # its kernel may be gone
            pace.end()


def tell(picture: Picture) -> None:
    """Tell now and then how far the drawing of the film is behind what happens."""
    if picture.behind and picture.number % 100 == 0:
        print(f"film: picture {picture.number} is drawn, {picture.behind} are left", flush=True)
