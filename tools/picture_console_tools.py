"""Writes docs/pictures/console-*.png: tools of the console's page in the demo's cell, in a Chromium without a window.

Usage: python -m tools.picture_console_tools docs/pictures
"""

from __future__ import annotations

from pathlib import Path

import click
import virtualrobot
from playwright.sync_api import Page, expect, sync_playwright
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.demos.palletizing import cell

from tools.picture_console import opened_page

PLACES = {"above": (-1.2, 0.35), "grasp": (-0.8, 0.6), "beside": (-0.2, 0.4), "pallet": (0.4, 0.65)}
"""Joints 1 and 2 (radians) of the targets that the program goes through."""

PROGRAM = """
schema_version: 1
steps:
- move: {moves: [{robot: iiwa, speed_factor: 0.5, point_to_point: {pose: {reference: above}}}]}
- move: {moves: [{robot: iiwa, speed_factor: 0.3, point_to_point: {pose: {reference: grasp}}}]}
- move: {moves: [{robot: iiwa, tool_state: {tool: vacuum-gripper, state: "on"}}]}
- dwell: {seconds: 0.2}
- move: {moves: [{robot: iiwa, speed_factor: 0.3, point_to_point: {pose: {reference: beside}}}]}
- move: {moves: [{robot: iiwa, speed_factor: 0.5, point_to_point: {pose: {reference: pallet}}}]}
"""

SIGNALS = ("part at end", "belt moving", "run belt", "grip", "alarm")
CONNECTIONS = """
schema_version: 1
signals:
- {name: parts, type: integer}
connections:
  run belt: {not: part at end}
  grip: {and: [part at end, {not: belt moving}]}
  parts: {count: {up: part at end}}
"""


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False, exists=True))
@click.option("--theme", type=click.Choice(["dark", "light"]), default="dark", show_default=True)
@click.option("--quality", type=click.Choice(["high", "low"]), default="high", show_default=True)
def main(folder: Path, theme: str, quality: str) -> None:
    """Write pictures to FOLDER: of library, program, trace, a craft that drives, collisions, parts and views."""
    with (
        KernelProcess("--no-token", headless=True) as kernel,
        virtualrobot.connect(kernel.address) as client,
        sync_playwright() as playwright,
    ):
        cell.load(client)
        arm = client.robots["iiwa"]
        for name, (turn, lift) in PLACES.items():
            arm.set_positions([turn, lift, 0.0, -1.1, 0.0, 1.3, 0.0])
            arm.teach(name)
        with opened_page(playwright, kernel.address, theme, quality) as page:
            _place(page)
            _save(page, folder / "console-library.png")
            page.keyboard.press("Escape")
            _play(page)
            client.clock.set_stepped()  # and nobody steps: the world stands still
            _save(page, folder / "console-program.png")
            page.get_by_role("tab", name="Traces").click()
            _save(page, folder / "console-traces.png")
            _drive(client, page)
            page.get_by_label("Drive", exact=True).screenshot(path=folder / "console-drive.png")
            page.mouse.up()
            page.locator('.node[data-name="iiwa"]').click()
            page.get_by_title("Trace iiwa no more").click()
            _collide(client, page)
            _save(page, folder / "console-collisions.png")
            page.get_by_role("tab", name="Joints").click()
            _grasp(client, page)
            _save(page, folder / "console-parts.png")
            _look(client, page)
            _save(page, folder / "console-views.png")
        for signal in SIGNALS:
            client.signals.create(signal)
        client.clock.set_realtime()
        with opened_page(playwright, kernel.address, theme, quality) as page:
            _wire(client, page)
            _save(page, folder / "console-connections.png")
            _speeds(client, page)
            _save(page, folder / "console-speeds.png")


def _place(page: Page) -> None:
    """Choose a model of the library, and hold the pointer where it would stand."""
    page.locator('.node[data-name="iiwa"]').click()
    page.get_by_role("tab", name="Library").click()
    page.get_by_label("Kinds").get_by_role("button", name="arm", exact=True).click()
    page.get_by_label("Filter models").fill("kuka")
    page.get_by_label("Place kr16", exact=True).click()
    page.wait_for_function("document.querySelector('.cover') === null")
    box = page.locator(".view canvas").bounding_box()
    assert box
    page.mouse.move(box["x"] + 0.36 * box["width"], box["y"] + 0.8 * box["height"])


def _play(page: Page) -> None:
    """Trace the arm's tool while a program runs, until its last move."""
    page.get_by_role("tab", name="Scene").click()
    page.get_by_role("tab", name="Traces").click()
    page.get_by_role("button", name="Trace iiwa", exact=True).click()
    page.get_by_role("tab", name="Program").click()
    page.set_input_files("#open-program", {"name": "fetch.yaml", "mimeType": "", "buffer": PROGRAM.encode()})
    page.locator("#play").click()
    page.wait_for_selector(".step.lit:nth-child(6)")


def _drive(client: virtualrobot.Client, page: Page) -> None:
    """Drive a UGV by its button, and let time stand still while it goes."""
    client.load_robot("model://ugv", name="ugv", base="planar", pose=virtualrobot.pose(0.9, -1.3, yaw=2.4))
    page.get_by_role("tab", name="Scene").click()
    page.locator('.node[data-name="ugv"]').click()
    client.clock.set_realtime()
    page.get_by_label("Ahead", exact=True).hover()
    page.mouse.down()
    expect(page.locator("#driven")).to_contain_text("0.30 m/s", timeout=60_000.0)
    client.clock.set_stepped()


def _collide(client: virtualrobot.Client, page: Page) -> None:
    """Put a post where the arm's tool is, and mark what touches."""
    client.stop()
    client.clock.step(1000)
    client.collisions.set("monitor")
    arm = client.robots["iiwa"]
    arm.set_positions([-0.35, 0.75, 0.0, -1.1, 0.0, 1.3, 0.0])
    x, y, z = arm.tcp[:3, 3]
    client.scene.add_object("post", virtualrobot.box(0.1, 0.1, z + 0.03), pose=virtualrobot.pose(x, y, (z + 0.03) / 2))
    page.get_by_role("tab", name="Collisions").click()
    page.get_by_role("list", name="What touches now").get_by_role("listitem").first.get_by_role("button").first.click()


def _grasp(client: virtualrobot.Client, page: Page) -> None:
    """Choose a box on the belt that the arm's tool is not near enough to."""
    client.scene.remove("post")
    client.robots["iiwa"].set_positions([-0.8, 0.4, 0.0, -1.1, 0.0, 1.3, 0.0])
    for number in range(1, 4):
        pose = virtualrobot.pose(0.45 - 0.3 * number, -0.02, 0.72)
        figure = virtualrobot.box(0.155, 0.10, 0.11, color="#c99a62")
        client.scene.add_part(f"box-{number}", figure, pose=pose, mass=1.0)
    page.get_by_role("tab", name="Parts", exact=True).click()
    page.locator("#parts").get_by_role("listitem").first.get_by_role("button").first.click()


def _look(client: virtualrobot.Client, page: Page) -> None:
    """Look along with the arm's tool, and show what a camera on it sees."""
    arm = client.robots["iiwa"]
    pose = virtualrobot.pose(0.0, -0.08, 0.05)
    client.scene.add_camera("wrist", virtualrobot.camera(320, 240), pose=pose, parent=arm.flange)
    page.get_by_role("tab", name="Views", exact=True).click()
    page.get_by_label("Name of the view").fill("pallet of the iiwa")
    page.keyboard.press("Enter")
    panel = page.locator("#views")
    panel.get_by_role("button", name="Picture").click()
    panel.get_by_role("button", name="Right", exact=True).click()
    panel.get_by_role("radio", name="Go along").click()
    client.clock.step(50)
    page.get_by_role("img", name="What wrist sees").wait_for()


def _wire(client: virtualrobot.Client, page: Page) -> None:
    """Connect signals, and begin with one more connection."""
    page.get_by_role("tab", name="Signals").click()
    page.get_by_label("Part").get_by_role("radio", name="Connections", exact=True).click()
    page.set_input_files("#open-connections", {"name": "belt.yaml", "mimeType": "", "buffer": CONNECTIONS.encode()})
    page.get_by_label("Connection of run belt").wait_for()
    client.signals["part at end"] = True
    page.get_by_label("Signal to drive").select_option("alarm")
    page.get_by_label("Logic").select_option(label="delay on")
    page.get_by_label("Input input").fill("part at end")
    page.get_by_label("seconds", exact=True).fill("5")


def _speeds(client: virtualrobot.Client, page: Page) -> None:
    """Show the speeds of the robots."""
    client.speed_factor, client.robots["panda"].speed_factor = 0.8, 0.5
    client.robots["iiwa"].tcp_speed_limit = 0.25
    page.get_by_title("Speed of each robot, and of time").click()


def _save(page: Page, file: Path) -> None:
    page.wait_for_timeout(4000.0)
    page.screenshot(path=file)
    click.echo(f"{file}: {file.stat().st_size // 1024} kB")


if __name__ == "__main__":
    main()
