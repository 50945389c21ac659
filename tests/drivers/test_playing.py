"""Player by itself, asked with times of the test: ticks are played a lead later, and every end of them is a brake.

The twin is a formula (`tests/drivers/twin.py`), and so what is due at any time is known.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_sdk.drivers.player import Play, Player
from virtualrobot_sdk.drivers.shared import CELL, CellBlock, TickRing

from tests.drivers.twin import DECELERATION, PERIOD, SECONDS, TICK_NS, Twin

BEGIN_NS, LEAD_NS = 1_000_000_000, 100_000_000
AMPLITUDES = np.array([1.0, -0.4])
FASTEST = np.pi / PERIOD
"""Greatest speed of the twin (rad/s)."""


@pytest.fixture
def cell(tmp_path: Path) -> Iterator[CellBlock]:
    block = CellBlock.create(tmp_path / CELL)
    yield block
    block.close()


@pytest.fixture
def ring(tmp_path: Path) -> Iterator[TickRing]:
    ring = TickRing.create(tmp_path / "ring", 2)
    yield ring
    ring.close()


class Course:
    """Course of a player at a rate, while the twin writes: times (n,) in s, places (n, k), states."""

    def __init__(self, player: Player, twin: Twin, rate: float = 250.0) -> None:
        """Begin when the twin does."""
        self.player, self.twin, self.period = player, twin, int(1e9 / rate)
        self.ns = BEGIN_NS
        self.braked_every = 1
        self.times: list[float] = []
        self.places: list[np.ndarray] = []
        self.velocities: list[np.ndarray] = []
        self.states: list[Play] = []

    def run(self, seconds: float, writes: bool = True) -> None:
        end = self.ns + int(seconds * 1e9)
        while self.ns < end:
            if writes:
                for tick in range(self.twin.tick + 1, (self.ns - BEGIN_NS) // TICK_NS + 1):
                    self.twin.write(tick, braked=tick % self.braked_every == 0)
            setpoint = self.player.step(self.ns)
            if setpoint is not None:
                self.times.append((self.ns - BEGIN_NS) * 1e-9)
                self.places.append(setpoint.q)
                self.velocities.append(setpoint.v)
                self.states.append(self.player.state)
            self.ns += self.period

    def accelerations(self) -> np.ndarray:
        """Return the accelerations between every three setpoints."""
        return np.diff(np.array(self.places), n=2, axis=0) / (self.period * 1e-9) ** 2


def course(ring: TickRing, cell: CellBlock, rate: float = 250.0) -> Course:
    twin = Twin({ring: AMPLITUDES}, cell, BEGIN_NS, LEAD_NS)
    return Course(Player(ring, cell, TICK_NS), twin, rate)


@pytest.mark.parametrize("rate", [125.0, 250.0, 500.0, 333.0])
def test_ticks_are_played_a_lead_later(ring: TickRing, cell: CellBlock, rate: float) -> None:
    """Between ticks too: a cubic with the right speeds is off by at most h⁴/384 times the fourth derivative."""
    one = course(ring, cell, rate)
    one.run(1.0)
    assert one.times[0] == pytest.approx(LEAD_NS * 1e-9, abs=1.0 / rate)
    for time, place, velocity in zip(one.times, one.places, one.velocities, strict=True):
        q, v = one.twin.state(ring, (time - LEAD_NS * 1e-9) / SECONDS)
        np.testing.assert_allclose(place, q, atol=SECONDS**4 / 384.0 * (2.0 * np.pi / PERIOD) ** 4)
        np.testing.assert_allclose(velocity, v, atol=1e-4)
    assert set(one.states) == {Play.PLAYING} and one.player.rate == 1.0


@pytest.mark.parametrize("begin", [0.13, 0.3, 0.5, 0.77])
def test_where_ticks_end_the_brake_is_played_and_nothing_newer(ring: TickRing, cell: CellBlock, begin: float) -> None:
    one = course(ring, cell)
    one.run(begin)
    last = one.twin.tick
    one.run(1.0, writes=False)
    assert one.player.state is Play.RESTS and one.player.on_brake
    rows = one.twin.brake(*one.twin.state(ring, last))
    np.testing.assert_array_equal(one.places[-1], rows[-1])
    assert np.abs(one.accelerations()).max() <= 1.02 * DECELERATION
    one.run(0.5)  # the kernel comes back: the robot stays
    assert one.player.state is Play.RESTS
    np.testing.assert_array_equal(one.places[-1], rows[-1])
    braking = one.states.index(Play.STARVED)
    assert one.times[braking] - LEAD_NS * 1e-9 == pytest.approx(last * SECONDS, abs=1.5 * SECONDS)


def test_a_kernel_that_is_late_by_less_than_the_lead_is_not_noticed(ring: TickRing, cell: CellBlock) -> None:
    one, other = course(ring, cell), []
    for _ in range(6):
        one.run(0.07)
        one.run(0.08, writes=False)
    for time, place in zip(one.times, one.places, strict=True):
        other.append(np.abs(place - one.twin.state(ring, (time - LEAD_NS * 1e-9) / SECONDS)[0]).max())
    assert max(other) < 1e-9 and set(one.states) == {Play.PLAYING}


@pytest.mark.parametrize("rate", [125.0, 250.0, 500.0])
def test_a_stop_brakes_at_once_on_the_path_and_no_harder(
    ring: TickRing, cell: CellBlock, rate: float, rng: np.random.Generator
) -> None:
    """Each setpoint after the flag is on the way to rest, and no joint's acceleration is more than a brake's."""
    one = course(ring, cell, rate)
    one.run(float(rng.uniform(0.3, 1.8)))
    stop_ns = one.ns - int(rng.integers(one.period))
    cell.stop(stop_ns)
    count = len(one.places)
    one.run(one.period * 1e-9)
    assert one.player.state in (Play.STOPPING, Play.RESTS), "the first setpoint after the flag is slower"
    one.run(1.0)
    assert one.player.state is Play.RESTS and one.player.rate == 0.0 and not one.player.on_brake
    for place in one.places:
        assert abs(place[1] / -0.4 - place[0]) < 1e-9  # both joints are where the other is, too: on the path
    # The last row of the twin's brake comes within a tick: up to a tenth more there.
    assert np.abs(one.accelerations()).max() <= 1.1 * DECELERATION
    speed = float(np.abs(one.twin.state(ring, ((stop_ns - BEGIN_NS - LEAD_NS) / TICK_NS))[1]).max())
    moving = [time for time, v in zip(one.times[count:], one.velocities[count:], strict=True) if v.any()]
    rest = max(moving, default=0.0) + BEGIN_NS * 1e-9 - stop_ns * 1e-9
    assert rest <= speed / DECELERATION + 2.0 * SECONDS + one.period * 1e-9


def test_a_stop_where_few_ticks_have_brakes_takes_the_next_one(ring: TickRing, cell: CellBlock) -> None:
    one = course(ring, cell)
    one.braked_every = 10
    one.run(0.405)
    cell.stop(one.ns)
    one.run(1.0)
    # Played is tick (405 - 100) / 4; the next one with a brake is 80.
    np.testing.assert_array_equal(one.places[-1], one.twin.brake(*one.twin.state(ring, 80))[-1])
    assert np.abs(one.accelerations()).max() <= 1.1 * DECELERATION


def test_what_is_refused_is_the_brake_from_the_setpoint_before(ring: TickRing, cell: CellBlock) -> None:
    one = course(ring, cell)
    one.run(0.5)
    one.ns -= one.period
    for told in (one.times, one.places, one.velocities, one.states):
        told.pop()
    before = one.ns - one.period
    assert one.player.halt(before) and not one.player.halt(before)
    one.run(1.0)
    assert one.player.state is Play.RESTS and not one.player.on_brake
    # Where the brake begins between two ticks, its first step may be off by the half of what a tick changes.
    assert np.abs(one.accelerations()).max() <= 2.0 * DECELERATION


def test_a_slow_controller_is_played_more_slowly(ring: TickRing, cell: CellBlock) -> None:
    one = course(ring, cell)
    one.run(0.5)
    before = one.player.tick
    for _ in range(25):
        one.twin.write((one.ns - BEGIN_NS) // TICK_NS)
        assert one.player.step(one.ns, 0.5) is not None
        one.ns += one.period
    assert one.player.tick == pytest.approx(before + 12.5) and one.player.rate == 0.5 and not one.player.late
    one.player.step(one.ns + 400_000_000, 0.5)
    assert one.player.late


def test_robots_of_a_cell_stay_together(tmp_path: Path, cell: CellBlock) -> None:
    """Two at other rates, of which one looks later: at each instant of the stop both are at the same place."""
    rings = [TickRing.create(tmp_path / name, 1) for name in ("a", "b")]
    twin = Twin({ring: np.ones(1) for ring in rings}, cell, BEGIN_NS, LEAD_NS)
    players = [Player(ring, cell, TICK_NS) for ring in rings]
    ns = BEGIN_NS
    while ns < BEGIN_NS + 1_500_000_000:
        if ns < BEGIN_NS + 700_000_000:
            twin.write((ns - BEGIN_NS) // TICK_NS)
        if ns == BEGIN_NS + 720_000_000:
            cell.stop(ns - 1_000_000)
        both = (ns - BEGIN_NS) % 8_000_000 == 0
        places = [player.step(ns) for player in (players if both else players[1:])]
        if both and places[0] is not None and places[1] is not None:
            np.testing.assert_allclose(places[0].q, places[1].q, atol=1e-12)
        ns += 2_000_000
    assert [player.state for player in players] == [Play.RESTS] * 2
    for ring in rings:
        ring.close()


def test_who_brakes_first_says_from_which_tick(tmp_path: Path, cell: CellBlock) -> None:
    rings = [TickRing.create(tmp_path / name, 1) for name in ("a", "b")]
    twin = Twin({ring: np.ones(1) for ring in rings}, cell, BEGIN_NS, LEAD_NS)
    first, second = (Player(ring, cell, TICK_NS) for ring in rings)
    twin.write(100)
    for player in (first, second):
        player.step(BEGIN_NS + LEAD_NS + 100 * TICK_NS)
    first.step(BEGIN_NS + LEAD_NS + 100 * TICK_NS + 1_000_000)
    twin.write(101)  # too late for one of them
    places = [player.step(BEGIN_NS + LEAD_NS + 103 * TICK_NS) for player in (first, second)]
    assert cell.committed == 100
    assert places[0] is not None and places[1] is not None
    np.testing.assert_array_equal(places[0].q, places[1].q)
    for ring in rings:
        ring.close()


def test_a_torn_record_is_read_again_or_braked_before(ring: TickRing, cell: CellBlock) -> None:
    one = course(ring, cell)
    one.run(0.4)
    last = one.twin.tick
    one.twin.write(last + 1)
    ring._floats[ring._ring_at + (last + 1) % 128 * ring._slot + 8] += 1.0  # a bit of it is not what it was
    one.run(0.5)
    assert one.player.torn > 0 and one.player.state is Play.RESTS
    rows = one.twin.brake(*one.twin.state(ring, last))
    np.testing.assert_array_equal(one.places[-1], rows[-1])


def test_ticks_without_a_brake_are_not_played(ring: TickRing, cell: CellBlock) -> None:
    one = course(ring, cell)
    one.run(0.4)
    last = one.twin.tick
    one.twin.write(last + 50, braked=False)
    one.run(1.0, writes=False)
    np.testing.assert_array_equal(one.places[-1], one.twin.brake(*one.twin.state(ring, last))[-1])


def test_velocities_are_those_of_the_places(ring: TickRing, cell: CellBlock) -> None:
    """Also while the clock slows and on the brake: the mean of two is the way between them."""
    one = course(ring, cell, 500.0)
    one.run(0.5)
    cell.stop(one.ns)
    one.run(1.5)
    for (a, b), (va, vb) in zip(pairwise(one.places), pairwise(one.velocities), strict=True):
        np.testing.assert_allclose((b - a) / (one.period * 1e-9), (va + vb) / 2.0, atol=0.02)
