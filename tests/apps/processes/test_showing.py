"""Effects as they are shown: what grows in parts is what the whole is, and it follows the tool."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, pose
from virtualrobot_apps.demos.processes import CELLS, run
from virtualrobot_apps.processes.effects.chips import Cutter
from virtualrobot_apps.processes.effects.film import Jet
from virtualrobot_apps.processes.effects.growing import BeadGrowth, DepthGrowth, FilmGrowth, between

JET = Jet(0.1, 0.15, 1e-6)


def line(begin: tuple[float, float, float], end: tuple[float, float, float], count: int = 9) -> np.ndarray:
    """Return frames that point downward on a line."""
    return np.array([pose(*place, roll=np.pi) for place in np.linspace(begin, end, count).tolist()])


@pytest.fixture
def plate(steps: Client) -> Client:
    """Return a client of a world with a plate of 200 x 200 x 20 mm, somewhere."""
    steps.view.remove_coats()
    steps.scene.add_part("plate", virtualrobot.box(0.2, 0.2, 0.02), pose=pose(0.3, -0.2, 0.7, yaw=0.4))
    return steps


def test_a_part_of_a_stretch_begins_and_ends_between_its_frames() -> None:
    frames, times = line((0.0, 0.0, 0.0), (0.8, 0.0, 0.0)), np.linspace(0.0, 8.0, 9)
    found, when = between(frames, times, 2.25, 4.5)
    assert when.tolist() == [2.25, 3.0, 4.0, 4.5]
    np.testing.assert_allclose(found[:, 0, 3], 0.1 * when, atol=1e-12)
    assert len(between(frames, times, -np.inf, np.inf)[0]) == 9
    assert len(between(frames, times, 9.0, np.inf)[0]) == 0


def test_a_film_grows_to_what_it_is(plate: Client) -> None:
    """In the middle of a wide pass its mean over the passes is flow by speed and step over; nothing is below."""
    over = [line((-0.3, y, 0.16), (0.3, y, 0.16), 31) for y in np.arange(-0.3, 0.31, 0.05)]
    passes = [(frames, np.linspace(0.0, 3.0, 31)) for frames in over]
    film = FilmGrowth(plate, ["plate"], passes, JET)
    parts = np.full(0, np.nan)
    for row in range(len(passes)):
        parts = film.go(row, -np.inf, 1.1)
        parts = film.go(row, 1.1, np.inf)
    top = film.skin[0][:, 2] > 0.01
    inner = top & (np.abs(film.skin[0][:, :2]).max(axis=1) < 0.05)
    below = (film.skin[0][:, 2] < -0.01) & (np.abs(film.skin[0][:, :2]).max(axis=1) < 0.09)
    assert np.isnan(parts[below]).all() and below.any() and inner.sum() > 50
    assert parts[inner].mean() == pytest.approx(1e6 * 1e-6 / 0.2 / 0.05, rel=0.02)
    assert film.legend.high == pytest.approx(np.nanmax(parts), rel=0.1)


def test_a_bead_is_a_tube_that_is_laid_in_time() -> None:
    """Two quarter circles of 100 mm: corners are as far from the way as the bead is thick."""
    angles = np.linspace(0.0, 0.5 * np.pi, 61)
    ways = [np.array([pose(0.1 * np.cos(a), 0.1 * np.sin(a), height) for a in angles]) for height in (0.0, 0.1)]
    bead = BeadGrowth([(frames, np.linspace(0.0, 2.0, 61)) for frames in ways], 0.004)
    vertices, faces = bead.skin
    out = np.hypot(np.hypot(vertices[:, 0], vertices[:, 1]) - 0.1, vertices[:, 2] - np.round(vertices[:, 2], 1))
    np.testing.assert_allclose(out, 0.004, atol=1e-4)
    assert faces.max() == len(vertices) - 1
    assert np.isnan(bead.go(0, -np.inf, -1.0)).all()
    laid = bead.go(0, -np.inf, 1.0)
    there = ~np.isnan(laid)
    reached = np.arctan2(vertices[there, 1], vertices[there, 0])
    assert reached.max() == pytest.approx(0.25 * np.pi, abs=0.1) and not there[vertices[:, 2] > 0.05].any()
    laid = bead.go(1, -np.inf, np.inf)
    assert np.nanmax(laid) == pytest.approx(4.0) == bead.legend.high


def test_a_cutter_s_depth_is_under_its_disc(plate: Client) -> None:
    """A slot of 12 mm that gets from 0 to 6 mm deep, and a hole of 5 mm, in a plate whose upper face is 10 mm up."""
    slot = line((-0.08, 0.0, 0.01), (0.08, 0.0, 0.004), 5), np.linspace(0.0, 4.0, 5)
    hole = line((0.0, 0.06, 0.02), (0.0, 0.06, 0.005), 2), np.array([0.0, 1.0])
    cut = DepthGrowth(plate, ["plate"], [slot, hole], Cutter(0.012, 0.05))
    assert cut.legend.high == pytest.approx(6.0, abs=0.1)
    points = cut.skin[0]
    depth = cut.go(0, -np.inf, 2.0)
    assert np.isnan(depth[points[:, 0] > 0.01]).all()
    depth = cut.go(0, 2.0, np.inf)
    inner = (points[:, 2] > 0.01) & (np.abs(points[:, 1]) < 0.005) & (np.abs(points[:, 0]) < 0.07)
    # While the disc is over a place, it gets deeper still.
    ahead = points[inner, 0] + np.sqrt(0.006**2 - points[inner, 1] ** 2)
    np.testing.assert_allclose(depth[inner], 1e3 * (ahead + 0.08) * 0.006 / 0.16, atol=0.02)
    assert np.isnan(depth[np.abs(points[:, 1]) > 0.0075]).all()
    depth = cut.go(1, -np.inf, np.inf)
    at = np.linalg.norm(points[:, :2] - [0.0, 0.06], axis=1)
    np.testing.assert_allclose(depth[(at < 0.005) & (points[:, 2] > 0.01)], 5.0, atol=0.3)


@pytest.mark.long
def test_a_bead_follows_the_torch(steps: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    """The demo: corners that are laid are more and more, and all at the end."""
    monkeypatch.setattr("virtualrobot_apps.processes.showing.PERIOD", 0.0)
    steps.view.remove_coats()
    told, counts, looks = steps.view.watch_coats(), list[int](), list[None]()
    next(told)

    def look() -> None:
        if steps.signals["arc"]:
            looks.append(None)
            if len(looks) % 40 == 0:
                counts.append(int((next(told)["bead on pipes"] > 0).sum()))

    run.main(steps, CELLS / "pipes.yaml", CELLS / "weld.yaml", each=look)
    assert len(counts) > 5 and counts == sorted(counts) and 0 < counts[2] < counts[-1]
    while not (values := next(told)["bead on pipes"]).all():
        assert len(values) >= counts[-1]
