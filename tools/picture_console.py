"""Writes docs/pictures/console*.png: the console's page on the running demo, in a Chromium without a window.

Usage: python -m tools.picture_console docs/pictures
"""

from __future__ import annotations

import re
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path

import click
import virtualrobot
from playwright.sync_api import Page, sync_playwright
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.demos.palletizing import palletize

from tools.screenshot import ARGUMENTS, find_chromium

SIZE = 1456, 819
PATIENCE_MS = 120_000.0


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False, exists=True))
@click.option("--box", default=9, show_default=True, help="The demo when the iiwa carries this box to its pallet.")
@click.option("--theme", type=click.Choice(["dark", "light"]), default="dark", show_default=True)
@click.option("--quality", type=click.Choice(["high", "low"]), default="high", show_default=True)
def main(folder: Path, box: int, theme: str, quality: str) -> None:
    """Write pictures of the page to FOLDER.

    console.png has the page while the iiwa carries a box, with a ghost of where its joints might go, and
    console-library.png a robot of the library that is about to be placed.
    """
    with (
        KernelProcess("--no-token", headless=True) as kernel,
        virtualrobot.connect(kernel.address) as watcher,
        virtualrobot.connect(kernel.address) as client,
        sync_playwright() as playwright,
    ):
        console = subprocess.Popen(
            [sys.executable, "-m", "virtualrobot", "console", "--address", kernel.address, "--port", "0"],
            stdout=subprocess.PIPE,
            text=True,
        )
        assert console.stdout
        found = re.search(r"(http://\S+)/\?key=", console.stdout.readline())
        assert found
        browser = playwright.chromium.launch(executable_path=find_chromium(), args=list(ARGUMENTS))
        page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
        page.set_default_timeout(PATIENCE_MS)
        page.add_init_script(f"localStorage.setItem('virtualrobot-theme', '{theme}')")
        work = threading.Thread(target=_work, args=(client,), daemon=True)
        work.start()
        page.goto(f"{found[1]}/?quality={quality}")
        _wait(watcher, f"iiwa-box-{box}")
        watcher.clock.set_stepped()  # and nobody steps: the world stands still
        _arrange(page)
        page.screenshot(path=folder / "console.png")
        _place(page)
        page.screenshot(path=folder / "console-library.png")
        browser.close()
        console.terminate()


def _wait(watcher: virtualrobot.Client, name: str) -> None:
    """Return when this box is carried high above the belt."""
    for change in watcher.scene.watch():
        if name in change.poses and change.poses[name][0, 3] > 1.0:
            return


def _arrange(page: Page) -> None:
    page.locator('.node[data-name="iiwa"]').click()
    track = page.locator(".joint .track").first
    box = track.bounding_box()
    assert box
    track.click(position={"x": 0.2 * box["width"], "y": 10})
    page.wait_for_function("document.querySelector('.cover') === null")
    page.wait_for_timeout(8000.0)


def _place(page: Page) -> None:
    """Choose a model of the library, and hold the pointer where it would stand, beside the fence."""
    page.keyboard.press("Escape")
    page.get_by_role("tab", name="Library").click()
    page.get_by_label("Kinds").get_by_role("button", name="arm", exact=True).click()
    page.get_by_label("Filter models").fill("kuka")
    page.get_by_label("Place kr16", exact=True).click()
    box = page.locator(".view canvas").bounding_box()
    assert box
    page.mouse.move(box["x"] + 0.36 * box["width"], box["y"] + 0.82 * box["height"])
    page.wait_for_timeout(3000.0)


def _work(client: virtualrobot.Client) -> None:
    with suppress(virtualrobot.VirtualRobotError):  # the kernel ends before the demo does
        palletize.main(client, headless=True)


if __name__ == "__main__":
    main()
