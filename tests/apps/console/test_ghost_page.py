"""A ghost at the console's page goes along with the base of its robot."""

from __future__ import annotations

import io
import re

import numpy as np
import pytest
import virtualrobot
from PIL import Image
from playwright.sync_api import Page, expect

from tests.api.asking import IIWA
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]


def middle_of_blue(page: Page) -> float:
    """Return where ghosts are from left to right, in pixels of the view as it is drawn when all is known."""
    page.locator('.view .canvas[aria-busy="false"]').wait_for()
    picture = Image.open(io.BytesIO(page.locator(".view .canvas canvas").screenshot())).convert("RGB")
    red, _, blue = np.moveaxis(np.asarray(picture, float), 2, 0)
    columns = np.nonzero(blue > red + 70.0)[1]
    return float(columns.mean()) if len(columns) > 500 else -1.0


def test_a_ghost_goes_along_with_the_base_of_its_robot(console: Console, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        client.load_robot(IIWA, name="iiwa").set_positions([0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0])
        with opened(browser, console.url + PLAIN) as page:
            row(page, "iiwa").click()
            track = page.get_by_label(re.compile("lbr_iiwa_joint_2, °"))
            box = track.bounding_box()
            assert box
            track.click(position={"x": 0.9 * box["width"], "y": 10})
            row(page, "world").click()  # what is selected has a blue rim as well
            until(lambda: middle_of_blue(page) > 0.0)
            before = middle_of_blue(page)
            client.scene.set_pose("iiwa", virtualrobot.pose(x=0.3, y=0.3))
            until(lambda: middle_of_blue(page) > before + 20.0)


def test_full_turns_are_folded_into_the_postures_that_they_are_of(
    console: Console, stepped_kernel: KernelProcess
) -> None:
    """Each of the six joints of a UR5e goes from -360 to 360 degrees (data sheet): 2^6 turns of each of 8 postures."""
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        arm = client.load_robot("model://ur5e", name="arm")
        arm.set_positions([0.3, -1.2, 1.4, -1.7, -1.5, 0.2])
        with opened(browser, console.url + PLAIN) as page:
            row(page, "arm").click()
            field = page.locator("#pendant").get_by_label("Z", exact=True)
            field.fill(f"{1000.0 * arm.tcp[2, 3] - 20.0:.2f}")
            field.press("Enter")
            postures = page.get_by_label("Postures", exact=True)
            chips = postures.locator(".chips .chip")
            expect(chips).to_have_count(8)
            expect(postures.locator("h4")).to_contain_text("Postures 8")
            assert not any(re.search(r"[+-]\d", name) for name in chips.all_inner_texts())
            expect(chips.first).to_have_attribute("aria-pressed", "true")
            postures.get_by_role("button", name="Full turns").click()
            expect(chips).to_have_count(64)
            first = chips.all_inner_texts()
            assert all(name.startswith(first[0]) for name in first)
            chips.nth(1).click()
            expect(chips.nth(1)).to_have_attribute("aria-pressed", "true")
            postures.get_by_role("button", name="Full turns").click()
            expect(chips).to_have_count(8)
