"""Writes docs/pictures/room-*.png: a proposal as it is seen in a headset, an emulated one, and at the page.

Usage: python -m tools.picture_room docs/pictures
"""

from __future__ import annotations

import re
from pathlib import Path

import click
import virtualrobot
from playwright.sync_api import Locator, Page, expect
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps import console

from tools.picture_console import opened_page
from tools.picture_console_tools import DRAWN
from tools.screenshot import browsers

IWER = Path(console.__file__).parent / "web" / "node_modules" / "iwer" / "build" / "iwer.min.js"
"""Meta's emulator of WebXR, which the page's tests bring."""

HEADSET = """;
window.headset = new IWER.XRDevice(IWER.metaQuest3);
headset.stereoEnabled = false;
headset.installRuntime({ forceInstall: true });
headset.position.set(0.15, 1.45, -0.3);
headset.quaternion.set(-0.16, -0.1, 0, 0.98);
"""
SIZE = 1200, 750
HERE, GOAL = (-0.6, 0.5, 0.0, -1.2, 0.0, 0.9, 0.0), (0.9, 0.7, 0.0, -0.9, 0.0, 1.2, 0.0)


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False, exists=True))
@click.option("--quality", type=click.Choice(["high", "low"]), default="high", show_default=True)
def main(folder: Path, quality: str) -> None:
    """Write the pictures to FOLDER."""
    with (
        KernelProcess("--no-token", headless=True) as kernel,
        virtualrobot.connect(kernel.address) as client,
        browsers() as browser,
    ):
        arm = client.load_robot("model://iiwa", name="iiwa")
        arm.set_positions(HERE)
        client.scene.add_object("press", virtualrobot.box(0.3, 0.3, 0.4), pose=virtualrobot.pose(0.75, 0.65, 0.2))
        client.proposals.create([arm.ptp(GOAL)], title="to the press")
        with opened_page(browser, kernel.address, "dark", quality, SIZE) as page:
            page.get_by_role("tab", name="Proposals").click()
            page.get_by_label("Look at to the press").click()
            page.locator(DRAWN).wait_for()
            page.get_by_title("Look at everything").click()
            page.locator(DRAWN).wait_for()
            _save(page, folder / "room-page.png")
            page.add_init_script(IWER.read_text("utf-8") + HEADSET)
            page.reload()
            page.locator('.node[data-name="iiwa"]').click()
            page.get_by_role("toolbar", name="View").get_by_title(re.compile("^Virtual reality")).click()
            expect(page.locator("#room")).to_contain_text(re.compile("Hold to run.*to the press"), timeout=120_000)
            page.evaluate("new Promise((go) => headset.activeSession.requestAnimationFrame(go))")
            _save(page.locator("[data-webxr_runtime] canvas").last, folder / "room-headset.png")


def _save(seen: Page | Locator, file: Path) -> None:
    page = seen if isinstance(seen, Page) else seen.page
    page.wait_for_timeout(3000.0)  # ghosts come one after the other
    seen.screenshot(path=file)
    click.echo(f"{file}: {file.stat().st_size // 1024} kB")


if __name__ == "__main__":
    main()
