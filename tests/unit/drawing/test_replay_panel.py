"""The panel of a replay does what people want of it, the newest wish alone, and follows the replay otherwise."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
import pytest
import viser
from virtualrobot_kernel.drawing import replay_panel
from virtualrobot_kernel.drawing.replay_panel import ReplayPanel
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.past_world import PastWorld

from tests.unit.history.runs import random_run
from tests.unit.world.builders import TICK
from tests.unit.world.test_past_world import Played

GUARD = 30.0
SOMEBODY, NOBODY = SimpleNamespace(client=object()), SimpleNamespace(client=None)


@pytest.fixture
def world(rng: np.random.Generator) -> Iterator[PastWorld]:
    made = PastWorld(world_poses, Clock(Mode.STEPPED, 1.0, round(TICK * 1e9)), Played(random_run(rng, 20)))
    made.start()
    yield made
    made.close()


@pytest.fixture
def panel(world: PastWorld) -> Iterator[ReplayPanel]:
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield ReplayPanel(server, world)
    server.stop()


def test_it_plays_pauses_and_sets_the_speed(panel: ReplayPanel, world: PastWorld) -> None:
    assert panel._play.label == "Play"
    panel._speed.value = "0.1"
    panel._toggle()
    world.seek(0).result(GUARD)  # what was told before is done
    assert (world.clock.mode, world.clock.speed_factor) == (Mode.REALTIME, 0.1)
    panel.show(world.snapshot)
    assert panel._play.label == "Pause"
    panel._toggle()
    assert world.step(1).result(GUARD)
    assert world.clock.mode is Mode.STEPPED


def test_the_newest_moment_that_somebody_wants_counts(panel: ReplayPanel, world: PastWorld) -> None:
    for tick in (50, 7, 42):
        panel._moment.value = tick * TICK
        panel._moved(SOMEBODY)
    panel.show(world.snapshot)
    assert panel._seeking is not None and panel._seeking.result(GUARD).state.tick == 42
    assert world.snapshot.state.epoch == 1  # it went there once


def test_the_slider_follows_the_replay_unless_it_is_being_moved(
    panel: ReplayPanel, world: PastWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(replay_panel, "SHOWN_SECONDS", -1.0)
    world.step(30).result(GUARD)
    panel._touched = -1e9
    panel.show(world.snapshot)
    assert panel._moment.value == pytest.approx(30 * TICK)
    panel._moved(NOBODY)
    assert panel._wanted is None
    panel._moment.value = 3 * TICK
    panel._moved(SOMEBODY)
    assert panel._wanted == 3
