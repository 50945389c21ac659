"""A person looks at the cell from elsewhere at the console's page: sides, saved views, along with a node, cameras."""

from __future__ import annotations

import io
import re

import numpy as np
import pytest
import virtualrobot
from PIL import Image
from playwright.sync_api import Locator, Page, expect

from tests.api.reading import step
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

RED, BLUE = (0.9, 0.05, 0.05), (0.05, 0.05, 0.9)
FIELD = 0.5
"""Vertical field of view (rad)."""

LEAST_PIXELS = 30
CORNER_PIXELS = 140
"""Room of the axes in the lower right corner."""


def shot(page: Page) -> np.ndarray:
    """Return the view as it is drawn when all is known, without the axes in its corner: shape (h, w, 3), 0 to 1."""
    page.locator('.view .canvas[aria-busy="false"]').wait_for()
    picture = Image.open(io.BytesIO(page.locator(".view .canvas canvas").screenshot())).convert("RGB")
    pixels = np.asarray(picture, float) / 255.0
    pixels[-CORNER_PIXELS:, -CORNER_PIXELS:] = 0.0
    return pixels


def middle(pixels: np.ndarray, color: tuple[float, float, float]) -> np.ndarray:
    """Return the middle of what looks like this color, as parts of the view to the right and down; NaN: nowhere."""
    strongest = int(np.argmax(color))
    others = np.delete(pixels, strongest, axis=2).max(axis=2)
    rows, columns = np.nonzero((pixels[..., strongest] > 0.3) & (pixels[..., strongest] > 2.5 * others))
    if len(rows) < LEAST_PIXELS:
        return np.full(2, np.nan)
    return np.array([columns.mean() / pixels.shape[1], rows.mean() / pixels.shape[0]])


def seen(page: Page, color: tuple[float, float, float]) -> np.ndarray:
    """Return where something of this color is seen."""
    return middle(shot(page), color)


def apart(page: Page) -> np.ndarray:
    """Return where the red cube is seen from the blue one."""
    pixels = shot(page)
    return middle(pixels, RED) - middle(pixels, BLUE)


def is_right_of(way: np.ndarray) -> bool:
    """Return whether a way in the picture leads straight to the right."""
    return bool(way[0] > 0.05 and abs(way[1]) < 0.02)


def show_views(page: Page) -> Locator:
    """Return the panel of views, without the grid in the view, whose axes are red and green."""
    page.get_by_title("Grid: 0.25 m and 1 m").click()
    page.get_by_role("tab", name="Views", exact=True).click()
    return page.locator("#views")


def show_cubes(client: virtualrobot.Client) -> None:
    """Put a red cube beside a blue one, along x, and have all look at them from the front."""
    for name, color, x in (("blue", BLUE, 0.0), ("red", RED, 0.6)):
        figure = virtualrobot.box(0.2, 0.2, 0.2, color=color)
        client.scene.add_part(name, figure, pose=virtualrobot.pose(x=x, z=0.1))
    client.view.set_camera([0.3, -4.0, 0.1], [0.3, 0.0, 0.1], FIELD)


def test_a_person_looks_from_elsewhere(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        show_cubes(client)
        with opened(browser, console.url + PLAIN, 1280, 720) as page:
            panel = show_views(page)
            expect(panel.get_by_label("View of all")).to_be_in_viewport(ratio=1.0)

            # As the kernel's pictures: from the front, red is to the right of blue; from behind to its left.
            expect(panel.get_by_label("Vertical field of view")).to_have_value(f"{np.degrees(FIELD):.1f}")
            until(lambda: is_right_of(apart(page)))
            panel.get_by_role("button", name="Back", exact=True).click()
            until(lambda: apart(page)[0] < -0.05)
            row(page, "blue").click()
            page.keyboard.press("5")  # from the top: x to the right, y upwards
            until(lambda: is_right_of(apart(page)))

            # Saved under a name, looked at from elsewhere, and there again after the page was loaded anew.
            page.keyboard.press("1")
            until(lambda: apart(page)[0] > 0.05)
            before = apart(page)
            panel.get_by_label("Name of the view").fill("in front")
            page.keyboard.press("Enter")
            kept = panel.get_by_role("listitem", name="in front")
            expect(kept).to_be_visible()
            panel.get_by_role("button", name="Back", exact=True).press("Enter")
            until(lambda: apart(page)[0] < -0.05)
            page.reload()
            show_views(page)
            panel.get_by_role("button", name="Back", exact=True).click()
            until(lambda: apart(page)[0] < -0.05)
            kept.get_by_role("button", name="in front", exact=True).click()
            until(lambda: np.allclose(apart(page), before, atol=0.01))

            # It is a node of the cell: programs look from there, and what they add is there to look from.
            eye = client.scene.viewpoint("in front").pose[:3, 3]
            np.testing.assert_allclose(eye, [0.3, -4.0, 0.1], atol=1e-4)
            behind = virtualrobot.looking_at([0.3, 4.0, 0.1], [0.3, 0.0, 0.1])
            client.scene.add_viewpoint("behind", pose=behind, distance=4.0, field_of_view=FIELD)
            panel.get_by_role("button", name="behind", exact=True).click()
            until(lambda: np.allclose(apart(page), -before, atol=0.01))

            # Dropped it is gone, for everybody.
            kept.get_by_title("Drop the view in front").click()
            expect(kept).to_have_count(0)
            assert list(client.scene.viewpoints()) == ["behind"]


def test_a_view_goes_along_and_is_shared(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        show_cubes(client)
        with opened(browser, console.url + PLAIN, 1280, 720) as page:
            panel = show_views(page)
            until(lambda: apart(page)[0] > 0.05)
            before = apart(page)

            # Along with a node it stays where it is in the picture, as the others go.
            row(page, "red").click()
            panel.get_by_role("radio", name="Go along").click()
            here = seen(page, RED)
            client.scene.set_pose("red", virtualrobot.pose(x=0.3, z=0.1))
            until(lambda: apart(page)[0] < 0.6 * before[0])
            np.testing.assert_allclose(seen(page, RED), here, atol=0.01)
            panel.get_by_role("radio", name="Off").click()
            client.scene.set_pose("red", virtualrobot.pose(x=0.6, z=0.1))
            until(lambda: np.allclose(apart(page), before, atol=0.02))
            assert np.linalg.norm(np.subtract(seen(page, RED), here)) > 0.03

            # The view of all: pictures of the kernel are taken from there.
            page.keyboard.press("4")
            panel.get_by_role("button", name="Set from here").click()
            until(lambda: client.view.read().camera_position[0] > 3.0)
            now = client.view.read()
            np.testing.assert_allclose((now.camera_position - now.camera_target)[1:], 0.0, atol=1e-5)
            assert now.field_of_view == pytest.approx(FIELD, abs=1e-4)


def test_a_person_sees_what_a_camera_sees(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    def reads() -> bool:
        before = client.sensors.status("eye").readings
        step(stepped, 50)  # two of its pictures, of which there are 10 a second
        return client.sensors.status("eye").readings != before

    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        client.scene.add_object("wall", virtualrobot.box(4, 0.1, 4, color=RED), pose=virtualrobot.pose(y=2.0))
        settings = virtualrobot.camera(64, 48)
        client.scene.add_camera("eye", settings, pose=virtualrobot.looking_at([0, 0, 0.5], [0, 2, 0.5]))
        with opened(browser, console.url + PLAIN) as page:
            panel = show_views(page)
            panel.get_by_role("button", name="Picture").click()
            inset = page.get_by_role("figure", name="Picture of eye")
            expect(inset).to_contain_text("Waiting for a picture")

            # Steps of time have the camera read while somebody looks: the wall fills its picture.
            def pictured() -> bool:
                step(stepped, 25)
                return inset.get_by_role("img").count() == 1

            until(pictured)
            pixel = "(canvas) => [...canvas.getContext('2d').getImageData(32, 24, 1, 1).data]"
            red, green, blue, alpha = inset.get_by_role("img").evaluate(pixel)
            assert red > 100 and max(green, blue) < 60 and alpha == 255
            assert reads()

            # Closed it reads no more; a camera that is removed is gone for those who follow it.
            inset.get_by_title("Show the picture of eye no more").click()
            expect(inset).to_have_count(0)
            until(lambda: not reads())
            panel.get_by_role("button", name="Look through").click()
            expect(panel.get_by_role("radio", name="Turn with it")).to_have_attribute("aria-checked", "true")
            until(lambda: np.isfinite(seen(page, RED)).all())
            assert np.allclose(seen(page, RED), 0.5, atol=0.1)
            client.scene.remove("eye")
            expect(panel.get_by_label("Following")).to_contain_text(re.compile("eye, which is gone"))
