"""Things that the picture of all viewers has, at the page: ghosts where robots would be, and least distances."""

from __future__ import annotations

import io
from collections.abc import Iterator

import numpy as np
import pytest
import virtualrobot
from PIL import Image
from playwright.sync_api import Page
from virtualrobot import Client

from tests.api.asking import IIWA
from tests.apps.console.browsing import PLAIN, WRITTEN, browsers, color_count, needs_page, opened, purple_count, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

BLUE = (63, 182, 217)
"""Color of least distances."""
HERE, THERE = [0.2, 0.9, 0.0, -0.9, 0.0, 0.5, 0.0], [2.9, 0.9, 0.0, -0.9, 0.0, 0.5, 0.0]


@pytest.fixture
def client(stepped_kernel: KernelProcess, stepped: Stubs) -> Iterator[Client]:
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.load_robot(IIWA, name="arm").set_positions(HERE)
        yield client


def look(page: Page) -> None:
    """Look at all that there is from ahead, once it is drawn."""
    page.locator('.view .canvas[aria-busy="false"]').wait_for()
    page.keyboard.press("1")


def seen(page: Page) -> np.ndarray:
    """Return the middle of the view's picture, without what lies over it, as it is drawn when all is known."""
    page.locator('.view .canvas[aria-busy="false"]').wait_for()
    picture = Image.open(io.BytesIO(page.locator(".view .canvas canvas").screenshot())).convert("RGB")
    return np.asarray(picture, float)[60:330]


def purple(picture: np.ndarray) -> np.ndarray:
    """Return which pixels of a picture are purple in whatever light."""
    red, green, blue = np.moveaxis(picture, 2, 0)
    return (red > green + 50.0) & (blue > green + 50.0)


def test_ghosts_are_where_the_robot_would_be(console: Console, client: Client) -> None:
    """A solid ghost covers what the robot itself covers there, but for its foot, which no joint moves."""
    arm = client.robot("arm")
    client.scene.add_frame("origin")  # else the page would say that there is nothing, at the end
    with browsers() as browser, opened(browser, console.url + PLAIN) as page:
        row(page, "arm").wait_for()
        look(page)
        here = seen(page)
        assert purple_count(page) == 0
        client.view.ghosts = {"goal": virtualrobot.Ghost("arm", [THERE], color="#cc00cc", opacity=1.0)}
        until(lambda: purple_count(page) > 0)
        ghost = purple(seen(page))

        # Where the base goes the ghost goes, too.
        client.scene.set_pose("arm", virtualrobot.pose(x=0.4))
        until(lambda: abs(np.nonzero(purple(seen(page)))[1].mean() - np.nonzero(ghost)[1].mean()) > 20.0)
        client.scene.set_pose("arm", np.eye(4))
        client.view.ghosts = {}
        until(lambda: purple_count(page) == 0)

        arm.set_positions(THERE)
        until(lambda: np.abs(seen(page) - here).max() > 100.0)
        there = seen(page)
        client.scene.remove("arm")
        until(lambda: row(page, "arm").count() == 0)
        empty = seen(page)
    robot, other = (np.abs(one - empty).max(axis=2) > 40.0 for one in (there, here))
    covered, wanted = ghost & ~other, robot & ~other
    assert wanted.sum() > 800
    assert (covered & wanted).sum() > 0.85 * max(covered.sum(), wanted.sum())  # the rest is rims, a pixel wide


def test_least_distances_are_lines(console: Console, client: Client) -> None:
    """Lines have the distance that the kernel measures, which is less the paddings."""
    box = virtualrobot.box(0.1, 0.1, 0.1)
    client.scene.add_object("box", box, pose=virtualrobot.pose(x=0.5, z=0.05))
    client.collisions.set(paddings={"box": 0.05})
    with browsers() as browser, opened(browser, console.url + PLAIN, script=WRITTEN) as page:
        row(page, "box").wait_for()
        look(page)
        assert color_count(page, BLUE) == 0
        client.view.clearances = {"gap": ("arm", "box")}
        until(lambda: color_count(page, BLUE) > 0)
        near = color_count(page, BLUE)
        pair = client.collisions.distance("arm", to=["box"])
        assert np.linalg.norm(pair.points[0] - pair.points[1]) - pair.distance > 0.04
        until(lambda: page.evaluate("written").count(f"{1000.0 * pair.distance:.0f} mm") > 0)
        client.scene.set_pose("box", virtualrobot.pose(x=1.0, z=0.05))
        until(lambda: color_count(page, BLUE) > 1.3 * near)
        client.view.clearances = {}
        until(lambda: color_count(page, BLUE) == 0)
