"""Writes docs/pictures/console.png: the console's page on the running demo, in a Chromium without a window.

Usage: python -m tools.picture_console docs/pictures
"""

from __future__ import annotations

import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import click
import virtualrobot
from playwright.sync_api import Browser, Page
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.demos.palletizing import palletize

from tools.screenshot import browsers

SIZE = 1456, 819
PATIENCE_MS = 120_000.0
REST_TICKS = 250
"""Enough for robots to come to rest."""


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False, exists=True))
@click.option("--box", default=9, show_default=True, help="The demo when the iiwa carries this box to its pallet.")
@click.option("--theme", type=click.Choice(["dark", "light"]), default="dark", show_default=True)
@click.option("--quality", type=click.Choice(["high", "low"]), default="high", show_default=True)
def main(folder: Path, box: int, theme: str, quality: str) -> None:
    """Write console.png to FOLDER: the page while the iiwa carries a box, with a ghost of where its joints might go."""
    with (
        KernelProcess("--no-token", headless=True) as kernel,
        virtualrobot.connect(kernel.address) as watcher,
        virtualrobot.connect(kernel.address) as client,
        browsers() as browser,
        opened_page(browser, kernel.address, theme, quality) as page,
    ):
        work = threading.Thread(target=_work, args=(client,), daemon=True)
        work.start()
        _wait(watcher, f"iiwa-box-{box}")
        watcher.clock.set_stepped()  # and nobody else steps: the world stands still
        client.close()  # so that nobody moves the robots but who looks at the page
        watcher.stop()
        watcher.clock.step(REST_TICKS)
        _arrange(page)
        page.screenshot(path=folder / "console.png")
    click.echo(f"{folder / 'console.png'}: {(folder / 'console.png').stat().st_size // 1024} kB")


@contextmanager
def opened_page(
    browser: Browser, address: str, theme: str = "dark", quality: str = "high", size: tuple[int, int] = SIZE
) -> Iterator[Page]:
    """Give the page of a console of its own for the kernel at an address."""
    command = [sys.executable, "-m", "virtualrobot", "console", "--address", address, "--port", "0"]
    console = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert console.stdout
    found = re.search(r"(http://\S+)/\?key=", console.stdout.readline())
    assert found
    page = browser.new_page(viewport={"width": size[0], "height": size[1]})
    try:
        page.set_default_timeout(PATIENCE_MS)
        page.add_init_script(f"localStorage.setItem('virtualrobot-theme', '{theme}')")
        page.goto(f"{found[1]}/?quality={quality}")
        yield page
    finally:
        page.close()
        console.terminate()


def _wait(watcher: virtualrobot.Client, name: str) -> None:
    """Return when this box is carried high above the belt."""
    for change in watcher.scene.watch():
        if name in change.poses and change.poses[name][0, 3] > 1.0:
            return


def _arrange(page: Page) -> None:
    page.get_by_role("tab", name="Views", exact=True).click()
    page.get_by_role("button", name="Look as they do").click()
    page.get_by_role("tab", name="Pendant").click()
    page.locator('.node[data-name="iiwa"]').click()
    track = page.locator(".joint .track").first
    box = track.bounding_box()
    assert box
    track.click(position={"x": 0.2 * box["width"], "y": 10})
    page.locator('.view .canvas[aria-busy="false"]').wait_for()


def _work(client: virtualrobot.Client) -> None:
    with suppress(virtualrobot.VirtualRobotError, ValueError):  # it is ended before the demo is
        palletize.main(client, headless=True)


if __name__ == "__main__":
    main()
