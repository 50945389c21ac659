"""Panel of a replay: play and pause, speed, and a slider of its moments."""

from __future__ import annotations

import time
from concurrent.futures import Future
from typing import Any

import viser

from virtualrobot_kernel.world.clock import Mode
from virtualrobot_kernel.world.past_world import PastWorld
from virtualrobot_kernel.world.state import Snapshot

SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "5", "10", "20")

UNTOUCHED_SECONDS = 0.5
"""Time (s) since somebody moved the slider after which it follows the replay again."""

SHOWN_SECONDS = 0.2
"""Least time (s) between two moments that the slider shows."""


class ReplayPanel:
    """Panel of one page. What people do in it is told to the world by the drawing thread, the newest wish alone."""

    def __init__(self, server: viser.ViserServer, world: PastWorld) -> None:
        """Add the panel to the page."""
        self._world = world
        recorded = world.clock.recorded
        assert recorded is not None  # every replay has ticks
        self._tick_seconds = world.clock.tick_seconds
        first, last = (tick * self._tick_seconds for tick in (recorded.first_tick, recorded.last_tick))
        with server.gui.add_folder("Replay"):
            self._moment = server.gui.add_slider(
                "Moment (s)", min=first, max=max(last, first + self._tick_seconds), step=self._tick_seconds,
                initial_value=first,
            )  # fmt: skip
            self._play = server.gui.add_button("Play")
            self._speed = server.gui.add_dropdown("Speed", SPEEDS, initial_value="1")
        self._moment.on_update(self._moved)
        self._play.on_click(lambda event: self._toggle())
        self._speed.on_update(lambda event: self._set_speed())
        self._wanted: int | None = None
        self._seeking: Future[Snapshot] | None = None
        self._touched = self._shown = 0.0

    def show(self, snapshot: Snapshot) -> None:
        """Go where somebody has moved the slider to, or have it show where the replay is."""
        now = time.monotonic()
        if self._wanted is not None and (self._seeking is None or self._seeking.done()):
            wanted, self._wanted = self._wanted, None
            self._seeking = self._world.seek(wanted)
        elif now - self._touched > UNTOUCHED_SECONDS and now - self._shown > SHOWN_SECONDS:
            self._shown = now
            if self._moment.value != (moment := snapshot.simulation_time):
                self._moment.value = min(max(moment, self._moment.min), self._moment.max)
        label = "Pause" if self._world.clock.mode is Mode.REALTIME else "Play"
        if self._play.label != label:
            self._play.label = label

    def _moved(self, event: Any) -> None:  # noqa: ANN401 of viser
        if event.client is not None:  # else it was this program
            self._touched = time.monotonic()
            self._wanted = round(self._moment.value / self._tick_seconds)

    def _toggle(self) -> None:
        plays = self._world.clock.mode is Mode.REALTIME
        self._world.set_clock(Mode.STEPPED if plays else Mode.REALTIME, float(self._speed.value))

    def _set_speed(self) -> None:
        self._world.set_clock(self._world.clock.mode, float(self._speed.value))
