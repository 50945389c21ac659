"""A ghost at the console's page goes along with the base of its robot."""

from __future__ import annotations

import io
import re

import numpy as np
import pytest
import virtualrobot
from PIL import Image
from playwright.sync_api import Page

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
