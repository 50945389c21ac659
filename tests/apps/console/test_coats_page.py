"""Coats at the console's page: in the view, in a legend, and as they change."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import expect

from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened
from tests.apps.console.consoles import Console
from tests.apps.console.test_views_page import shot
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

CORNERS = np.array([[-1, -0.11, -1], [1, -0.11, -1], [1, -0.11, 1], [-1, -0.11, 1]])
FACES = [[0, 1, 2], [0, 2, 3]]


def test_a_person_sees_what_a_process_leaves(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    """Heat is red at a third of its range; a triangle is drawn where all its corners have a value."""
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        client.view.remove_coats()
        client.scene.add_part("plate", virtualrobot.box(2.0, 0.2, 2.0, color=(0.05, 0.05, 0.6)))
        client.view.set_camera([0.0, -4.0, 0.0], [0.0, 0.0, 0.0], 0.5)
        with opened(browser, console.url + PLAIN, 1280, 720) as page:

            def is_red(right: float, down: float) -> bool:
                pixels = shot(page)
                color = pixels[int(down * pixels.shape[0]), int(right * pixels.shape[1])]
                return bool(color[0] > 0.3 and color[0] > 2.5 * color[1:].max())

            legends = page.get_by_label("Legends")
            expect(legends).to_have_count(0)
            film = client.view.add_coat(
                "film", "plate", CORNERS, FACES, low=0.0, high=30.0, unit="µm", title="Film", color_map="heat"
            )
            film.paint([9.9, 9.9, 9.9, np.nan])
            until(lambda: is_red(0.55, 0.6) and not is_red(0.45, 0.4))
            expect(legends.get_by_label("Film: 0 to 30 µm", exact=False)).to_contain_text("µm")
            expect(legends).to_contain_text("15")
            film.paint([9.9, 9.9, 9.9, 9.9])
            until(lambda: is_red(0.45, 0.4))
            page.reload()
            until(lambda: is_red(0.45, 0.4) and is_red(0.55, 0.6))
            client.scene["plate"].rename("panel")
            client.scene["panel"].hide()
            until(lambda: not is_red(0.45, 0.4))
            client.scene["panel"].hide(False)
            until(lambda: is_red(0.45, 0.4))
            film.remove()
            until(lambda: not is_red(0.45, 0.4))
            expect(legends).to_have_count(0)
