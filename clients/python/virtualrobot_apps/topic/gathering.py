"""Samples of streams, gathered for some seconds of simulation time."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import suppress

import click
from virtualrobot import Client
from virtualrobot.cli.options import Target
from virtualrobot.errors import VirtualRobotError
from virtualrobot.recording.topics import Selection
from virtualrobot.streams.sample import Sample
from virtualrobot.streams.watch import StreamWatch

from virtualrobot_apps.topic import curves as of
from virtualrobot_apps.topic.drawing import letters

CLOCK = "/clock"
"""Stream that is watched beside all others, so that time goes by where they tell nothing."""

_DRAWN_SECONDS = 0.5
"""Time (s of the wall clock) from one drawing in a terminal to the next."""


def watched(client: Client, names: Sequence[str]) -> StreamWatch:
    """Return a watch of streams by names or patterns, and of the clock; raises as `Streams.watch` does."""
    return client.streams.watch(*names, CLOCK)


def taken(watch: StreamWatch, names: Sequence[str], seconds: float | None) -> Iterator[Sample]:
    """Yield the samples of streams until some seconds of simulation time are over since the first; None: forever."""
    asked, begin = Selection(names), None
    for sample in watch:
        begin = sample.time if begin is None else begin
        if seconds is not None and sample.time - begin > seconds + 1e-9:
            return
        if sample.stream in asked:
            yield sample


def gathered(target: Target, names: Sequence[str], seconds: float | None) -> dict[str, list[tuple[Sample, float]]]:
    """Return the samples of streams by name, each with the wall time at which it came; Ctrl-C ends it, too."""
    with target.connect() as client, watched(client, names) as watch:
        asked = Selection(names)
        found: dict[str, list[tuple[Sample, float]]] = {one.name: [] for one in watch.streams if one.name in asked}
        with suppress(KeyboardInterrupt):
            for sample in taken(watch, names, seconds):
                found[sample.stream].append((sample, time.time()))
    return found


def drawn_live(
    target: Target, names: Sequence[str], curves: Sequence[str], seconds: float, shows: bool
) -> list[Sample]:
    """Return the samples of streams for some seconds, or until Ctrl-C; `shows`: curves are drawn here meanwhile."""
    samples: list[Sample] = []
    drawn = time.monotonic()
    with target.connect() as client, watched(client, names) as watch, suppress(KeyboardInterrupt):
        for sample in taken(watch, names, seconds):
            samples.append(sample)
            if shows and time.monotonic() - drawn > _DRAWN_SECONDS:
                with suppress(VirtualRobotError):  # the first numbers of a curve come later
                    wanted = [one for one in of.chosen(of.of_samples(samples), curves) if len(one.times) > 1]
                    click.echo(f"\x1b[H\x1b[2J{letters(wanted) if wanted else ''}")
                drawn = time.monotonic()
    if shows:
        click.echo("\x1b[H\x1b[2J", nl=False)
    return samples
