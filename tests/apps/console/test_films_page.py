"""A person films the view and a camera at the console's page, and saves the films; their pictures are looked at."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Locator, Page, expect
from virtualrobot import Client

from tests.api.reading import step
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened
from tests.apps.console.consoles import Console, Reply
from tests.kernels import KernelProcess, Stubs

av: Any = pytest.importorskip("av", reason="the package for films is not installed")

pytestmark = pytest.mark.long

PICTURE_TICKS = 10
"""25 pictures a second, in ticks of 4 ms."""
PICTURES = 12
AWAY_METERS = 0.08
"""Little beside its distance, so that it goes evenly in pictures, too."""


def frames(file: Path) -> np.ndarray:
    """Return the pictures of a film, (n, height, width, 3)."""
    with av.open(str(file)) as film:
        return np.array([frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)])


def saved(page: Page, film: Locator, folder: Path) -> Path:
    """Save a film by its link."""
    with page.expect_download() as download:
        film.get_by_role("link", name="Save").click()
    file = folder / download.value.suggested_filename
    download.value.save_as(file)
    return file


def redness(pictures: np.ndarray) -> np.ndarray:
    """Return the column (n,) of the middle of what is red in each picture."""
    red = (pictures[..., 0] > 110.0) & (pictures[..., 1:].max(axis=-1) < 70.0)
    return (red * np.arange(pictures.shape[2])).sum(axis=(1, 2)) / red.sum(axis=(1, 2))


@needs_page[0]
@needs_page[1]
def test_a_person_films(console: Console, stepped: Stubs, stepped_kernel: KernelProcess, tmp_path: Path) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        client.scene.add_object("red", virtualrobot.box(0.2, 0.2, 0.2, color="red"), pose=virtualrobot.pose(z=0.1))
        settings = virtualrobot.camera(64, 48)
        client.scene.add_camera("eye", settings, pose=virtualrobot.looking_at([0, -1.2, 0.3], [0, 0, 0.1]))
        with opened(browser, console.url + PLAIN, 1280, 720) as page:
            page.get_by_title("Films", exact=True).click()
            panel = page.get_by_label("Films", exact=True)
            panel.get_by_role("radio", name="640").click()
            page.keyboard.press("4")  # from the right: what goes along y goes to the right
            page.wait_for_timeout(1000)
            panel.get_by_role("button", name="Film", exact=True).press("Enter")
            view = panel.get_by_label("film-1.mp4", exact=True)
            expect(view).to_contain_text("is taken")

            # The camera as well; a third film at a time is refused.
            panel.get_by_label("What is filmed").select_option("eye")
            panel.get_by_role("button", name="Film", exact=True).click()
            eye = panel.get_by_label("film-2.mp4", exact=True)
            expect(eye).to_contain_text("eye · is taken")
            panel.get_by_role("button", name="Film", exact=True).click()
            expect(page.locator("#last")).to_have_text("2 films are being taken already: stop one of them")

            for number in range(1, PICTURES):
                client.scene.set_pose("red", virtualrobot.pose(0.0, AWAY_METERS * number / (PICTURES - 1), 0.1))
                step(stepped, PICTURE_TICKS)
            for film in (view, eye):
                film.get_by_role("button", name="Stop").click()
                expect(film).to_contain_text("KiB")
                expect(film).to_contain_text(f"{PICTURES / 25.0:.1f} s")

            # A picture for each 40 ms of simulation time, none left out: what moved evenly moves evenly in them.
            taken = frames(saved(page, view, tmp_path))
            assert taken.shape == (PICTURES, 360, 640, 3)
            columns = redness(taken)
            assert columns[-1] - columns[0] > 20.0
            np.testing.assert_allclose(np.diff(columns), (columns[-1] - columns[0]) / (PICTURES - 1), rtol=0.3)
            seen = frames(saved(page, eye, tmp_path))
            assert seen.shape == (PICTURES, 48, 64, 3)
            last = client.view.capture("eye", format="raw").pixels
            assert np.abs(seen[-1].astype(float) - last).mean() < 8.0, "but for what a video codec loses"

            # Removed it is gone for everybody.
            eye.get_by_title("Remove film-2.mp4").click()
            expect(eye).to_have_count(0)
            assert console.ask("/films/film-2.mp4", verb="GET").status == 404
            view.get_by_title("Remove film-1.mp4").click()
            expect(view).to_have_count(0)


def test_what_is_wrong_is_told_in_words(console: Console, steps: Client) -> None:
    def refused(path: str, said: dict[str, object]) -> Reply:
        reply = console.ask(f"/films{path}", said)
        assert 400 <= reply.status < 500, reply.body
        return reply

    steps.scene.add_object("red", virtualrobot.box(0.2, 0.2, 0.2))
    before = console.ask("/films", verb="GET").json
    for said, words in [
        ({"camera": "eyes"}, "eyes"),
        ({"camera": "red"}, "red"),
        ({"camera": {"position": [0, 0, 0]}}, "position, target and field"),
        ({"camera": {"position": [0, 0, "1"], "target": [0, 0, 0], "field": 1}}, "'position' is 3 finite numbers"),
        ({"camera": 5}, "a camera is the name of a node"),
        ({"size": [5000, 10]}, "4096"),
        ({"size": [640]}, "'size' is 2 finite numbers"),
        ({"size": [1, 1]}, "2 to 4096 pixels wide and high"),
    ]:
        assert words in refused("/start", said).json["message"]  # pyright: ignore[reportArgumentType]
    assert "no film 'film-99.mp4'" in refused("/stop", {"name": "film-99.mp4"}).json["message"]
    assert "no film '../cell.mp4'" in refused("/remove", {"name": "../cell.mp4"}).json["message"]
    assert console.ask("/films/..%2fcell.mp4", verb="GET").status == 404
    assert console.ask("/films", verb="GET").json == before
