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
from virtualrobot_apps.demos.palletizing import cell, palletize

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
    console-library.png a robot of the library that is about to be placed; console-program.png has the same cell
    with a program, whose second step is running, and console-traces.png the ways of both arms' tools before that.
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
        _trace(page)
        _wait(watcher, f"iiwa-box-{box}")
        watcher.clock.set_stepped()  # and nobody steps: the world stands still
        _arrange(page)
        page.screenshot(path=folder / "console.png")
        page.keyboard.press("Escape")
        page.get_by_role("tab", name="Traces").click()
        page.screenshot(path=folder / "console-traces.png")
        _place(page)
        page.screenshot(path=folder / "console-library.png")
        _play(page, watcher)
        page.screenshot(path=folder / "console-program.png")
        browser.close()
        console.terminate()


def _wait(watcher: virtualrobot.Client, name: str) -> None:
    """Return when this box is carried high above the belt."""
    for change in watcher.scene.watch():
        if name in change.poses and change.poses[name][0, 3] > 1.0:
            return


def _trace(page: Page) -> None:
    """Trace both arms' tools, half a minute back."""
    page.get_by_role("tab", name="Traces").click()
    for robot in ("panda", "iiwa"):
        page.locator(f'.node[data-name="{robot}"]').click()
        page.get_by_role("button", name=f"Trace {robot}", exact=True).click()
        page.get_by_label(f"How far back the trace of {robot} goes; 0 is all").fill("30")
        page.keyboard.press("Enter")
    page.get_by_role("tab", name="Joints").click()


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


_CORNERS = ((-1.35, 0.35), (-0.9, 0.6), (-0.45, 0.75), (0.0, 0.5))
"""Joints 1 and 2 (radians) of the places that the program goes through."""

_PROGRAM = """
schema_version: 1
steps:
- move: {moves: [{robot: iiwa, speed_factor: 0.5, point_to_point: {pose: {reference: above}}}]}
- move: {moves: [{robot: iiwa, speed_factor: 0.2, point_to_point: {pose: {reference: grasp}}}]}
- move: {moves: [{robot: iiwa, tool_state: {tool: vacuum-gripper, state: "on"}}]}
- dwell: {seconds: 0.2}
- move: {moves: [{robot: iiwa, speed_factor: 0.3, point_to_point: {pose: {reference: beside}}}]}
- move: {moves: [{robot: iiwa, speed_factor: 0.5, point_to_point: {pose: {reference: pallet}}}]}
"""


def _play(page: Page, watcher: virtualrobot.Client) -> None:
    """Build the cell anew, teach targets, and run a program of the page until its second step."""
    cell.load(watcher)
    arm = watcher.robots["iiwa"]
    for name, (turn, lift) in zip(("above", "grasp", "beside", "pallet"), _CORNERS, strict=True):
        arm.set_positions([turn, lift, 0.0, -1.1, 0.0, 1.3, 0.0])
        arm.teach(name)
    page.get_by_role("tab", name="Scene").click()
    page.locator('.node[data-name="iiwa"]').click()
    page.get_by_role("tab", name="Program").click()
    page.set_input_files("#open-program", {"name": "fetch.yaml", "mimeType": "", "buffer": _PROGRAM.encode()})
    page.locator("#play").click()
    watcher.clock.set_realtime()
    page.wait_for_selector(".step.lit:nth-child(2)")
    watcher.clock.set_stepped()
    page.wait_for_timeout(5000.0)


def _work(client: virtualrobot.Client) -> None:
    with suppress(virtualrobot.VirtualRobotError):  # the kernel ends before the demo does
        palletize.main(client, headless=True)


if __name__ == "__main__":
    main()
