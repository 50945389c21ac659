"""Robots whose controllers plan by themselves: what they are given, and how far they are off it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from virtualrobot_sdk.drivers import About, Driver, Pace
from virtualrobot_sdk.drivers.jobs import REST_TICKS, STRAIGHT, Jobs
from virtualrobot_sdk.drivers.player import Play, Setpoint
from virtualrobot_sdk.drivers.robot_side import JointSide, Mapping, RobotSide

TICK_NS = 4_000_000
SIDE = RobotSide(tuple(JointSide(name, place, -3.0, 3.0, 1.0) for place, name in enumerate(("hip", "knee"))), TICK_NS)


class Given(Driver):
    """Driver that keeps the points which it is given."""

    def run(self, points: Sequence[np.ndarray], speeds: Sequence[float], outputs: int) -> None:
        """Keep them."""
        self.points = np.array(points)


class Twin:
    """What stands for the player: a twin goes to some places, a tick at each, and then rests."""

    state = Play.PLAYING

    def __init__(self, places: np.ndarray) -> None:
        """Have the places (n, k)."""
        self._places = places

    def step(self, ns: int) -> Setpoint:
        """Return the place of a time."""
        place = self._places[min(ns // TICK_NS, len(self._places) - 1)]
        return Setpoint(place, np.zeros_like(place), 0)


def jobs_after(*corners: tuple[float, float]) -> tuple[Jobs, Given]:
    """Return what a controller was given, once a twin has gone from corner to corner."""
    share = np.linspace(0.0, 1.0, 20)[:, None]
    ends = np.array(corners)
    places = np.concatenate([a + share * (b - a) for a, b in pairwise(ends)])
    driver, twin = Given(), Twin(places)
    jobs = Jobs(driver, Mapping(SIDE, About(2, 100.0, Pace.JOBS)), SIDE, ends[0])
    for tick in range(len(places) + REST_TICKS + 2):
        jobs.step(tick * TICK_NS, twin, None)  # pyright: ignore[reportArgumentType] what it asks of a player is here
    return jobs, driver


def test_the_way_is_its_corners_and_off_it_counts_wherever_the_robot_is() -> None:
    jobs, driver = jobs_after((0.0, 0.0), (1.0, 0.0), (1.0, 0.5))
    np.testing.assert_allclose(driver.points, [(1.0, 0.0), (1.0, 0.5)], atol=STRAIGHT)
    for q, on in (
        ((0.0, 0.0), (0.0, 0.0)),
        ((0.3, 0.1), (0.3, 0.0)),
        ((1.2, 0.4), (1.0, 0.4)),
        ((1.0, 0.7), (1.0, 0.5)),
        ((-0.1, 0.0), (0.0, 0.0)),
    ):
        np.testing.assert_allclose(jobs.nearest(np.array(q)), on, atol=STRAIGHT)


def test_a_robot_that_was_given_nothing_belongs_where_it_is_held() -> None:
    jobs, _ = jobs_after((0.2, 0.1), (0.2, 0.1))
    assert (jobs.nearest(np.array([0.5, 0.5])) == [0.2, 0.1]).all()


def test_a_way_that_comes_back_to_where_it_began_has_a_nearest_place() -> None:
    jobs, _ = jobs_after((0.0, 0.0), (0.5 * STRAIGHT, 0.0), (0.0, 0.0))
    np.testing.assert_allclose(jobs.nearest(np.array([0.3, 0.0])), (0.0, 0.0), atol=STRAIGHT)
