"""Writes a PNG of what the viewer shows: opens its page in a Chromium without a window, on a software renderer.

Usage: python tools/screenshot.py http://127.0.0.1:8080 docs/pictures/cell.png --width 1600 --height 900 --wait 8
"""

from __future__ import annotations

import base64
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click
from playwright.sync_api import Browser, Page, sync_playwright

ARGUMENTS = (
    *("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--disable-gpu-rasterization", "--disable-gpu-compositing"),
)
"""For Chromium: draw WebGL on the processor, so that no graphics card is needed, and all else without WebGL."""


def find_chromium() -> str | None:
    """Return the path of an installed Chromium or Chrome, or None."""
    names = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
    return next((path for name in names if (path := shutil.which(name))), None)


@contextmanager
def browsers(*more: str) -> Iterator[Browser]:
    """Give a fresh browser with more arguments, and close it after."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_chromium(), args=[*ARGUMENTS, *more])
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def opened(url: str, width: int, height: int) -> Iterator[Page]:
    """Give the viewer's page in a fresh browser of that many pixels, its canvas there, and close it all after."""
    with browsers() as browser:
        page = browser.new_page(viewport={"width": width, "height": height})
        # Left to itself the page takes fewer pixels when drawing is slow.
        page.goto(f"{url}/?fixedDpr=1")
        page.wait_for_function("window.__viserMutable && window.__viserMutable.canvas !== null")
        yield page


def picture(page: Page) -> bytes:
    """Return the scene as PNG, without the panels that lie over it."""
    url: str = page.evaluate("window.__viserMutable.canvas.toDataURL('image/png')")
    return base64.b64decode(url.partition(",")[2])


@click.command()
@click.argument("url")
@click.argument("output", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--width", default=1600, show_default=True, help="Pixels.")
@click.option("--height", default=900, show_default=True, help="Pixels.")
@click.option("--wait", default=6.0, show_default=True, help="Seconds until the picture is taken.")
def main(url: str, output: Path, width: int, height: int, wait: float) -> None:
    """Write what the viewer at URL shows to OUTPUT, a PNG."""
    output.parent.mkdir(parents=True, exist_ok=True)
    with opened(url, width, height) as page:
        page.wait_for_timeout(1000.0 * wait)
        output.write_bytes(picture(page))
    click.echo(f"{output}: {width}x{height}, {output.stat().st_size // 1024} kB")


if __name__ == "__main__":
    main()
