"""The console's page in a real browser, used as a person uses it."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from urllib.parse import urlsplit

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Locator, Page, expect
from virtualrobot_apps.console.page_files import is_built

from tools.screenshot import browsers as browsers
from tools.screenshot import find_chromium

WIDTH, HEIGHT = 1100, 700
PLAIN = "/?quality=low"
"""Address of the page without shadows, which are slow without a graphics card."""

PURPLE = (0.8, 0.0, 0.8)

WRITTEN = """
window.written = [];
const fill = CanvasRenderingContext2D.prototype.fillText;
CanvasRenderingContext2D.prototype.fillText = function (text, ...more) {
  window.written.push(text);
  fill.call(this, text, ...more);
};
"""
"""Script that keeps what the page writes on canvases."""

PATIENCE_MS = 60_000.0
expect.set_options(timeout=PATIENCE_MS)

needs_browser = pytest.mark.skipif(find_chromium() is None, reason="no Chromium: install the package chromium")
needs_page = [
    needs_browser,
    pytest.mark.skipif(not is_built(), reason="the console's page is not built: make console"),
]


@contextmanager
def opened(
    browser: Browser, url: str, width: int = WIDTH, height: int = HEIGHT, script: str = "", link: str = ""
) -> Iterator[Page]:
    """Give the page at an address; what it complains of fails the test, and so does what it asks of other machines.

    `script` runs before the page's own code; `link` lets the page in. Any certificate will do.
    """
    page = browser.new_page(viewport={"width": width, "height": height}, color_scheme="dark", ignore_https_errors=True)
    page.add_init_script(script)
    page.set_default_timeout(PATIENCE_MS)
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda said: complaints.append(said.text) if "Content Security Policy" in said.text else None)
    page.on("request", lambda asked: None if _is_own(asked.url, url) else complaints.append(f"asked for {asked.url}"))
    try:
        if link:
            assert page.request.get(link).ok  # its session is the page's, too
        page.goto(url)
        yield page
        assert complaints == []
    finally:
        page.close()


def row(page: Page, name: str) -> Locator:
    """Return a node's row in the tree."""
    return page.locator(f'.node[data-name="{name}"]')


def hold(page: Page, label: str) -> None:
    """Press the button of this label and don't let it go."""
    page.get_by_label(label, exact=True).hover()
    page.mouse.down()


def color_count(page: Page, color: tuple[int, int, int]) -> int:
    """Return how many pixels of the view, as it is drawn when all is known, have nearly this color."""
    page.locator('.view .canvas[aria-busy="false"]').wait_for()
    picture = Image.open(io.BytesIO(page.locator(".view .canvas canvas").screenshot())).convert("RGB")
    return int(np.count_nonzero(np.abs(np.asarray(picture, float) - color).max(axis=2) < 12.0))


def purple_count(page: Page) -> int:
    """Return how many pixels of the view, as it is drawn when all is known, are purple in whatever light."""
    page.locator('.view .canvas[aria-busy="false"]').wait_for()
    picture = Image.open(io.BytesIO(page.locator(".view .canvas canvas").screenshot())).convert("RGB")
    red, green, blue = np.moveaxis(np.asarray(picture, float), 2, 0)
    return int(np.count_nonzero((red > green + 50.0) & (blue > green + 50.0)))


def _is_own(asked: str, url: str) -> bool:
    """Return whether an address that a page asks for is of the page's own machine, or is none of a machine."""
    own = {"127.0.0.1", urlsplit(url).hostname}
    return asked.startswith(("blob:null/", "data:")) or urlsplit(asked.removeprefix("blob:")).hostname in own
