"""Writes docs/pictures/console-*.png: tools of the console's page in the demo's cell, in a Chromium without a window.

Usage: python -m tools.picture_console_tools docs/pictures
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import click
import virtualrobot
from playwright.sync_api import Locator, Page, expect
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.demos.palletizing import cell
from virtualrobot_apps.demos.processes import CELLS, run

from tools.picture_console import SIZE, opened_page
from tools.screenshot import browsers

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
- move: {moves: [{robot: iiwa, speed_factor: 0.1, point_to_point: {pose: {reference: pallet}}}]}
"""

BRACKET = """\
solid:
  difference:
  - union:
    - {extrude: {profile: {rectangle: {size: [0.5, 0.3], corner: 0.05}}, height: 0.04}}
    - {move: {solid: {box: {size: [0.04, 0.3, 0.3]}}, by: [0.23, 0, 0.15]}}
  - row:
      solid: {move: {solid: {cylinder: {radius: 0.03, length: 0.5}}, by: [-0.15, 0, 0]}}
      count: 3
      step: [0.12, 0, 0]
"""

SORT = """\
MODULE Sorting
  CONST jointtarget rest := [[0, 0, 0, 0, 30, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST jointtarget tray := [[70, 25, 10, 0, 40, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  VAR num parts := 0;

  ! Brings one part to the tray.
  PROC bring(num part)
    MoveAbsJ tray, v200, z20, tool0;
    parts := parts + 1;
    MoveAbsJ rest, v200, fine, tool0;
    TPWrite "part " \\Num:=part;
  ENDPROC

  PROC main()
    FOR part FROM 1 TO 5 DO
      bring part;
    ENDFOR
  ENDPROC
ENDMODULE
"""

BORE = 719, 428
"""Place of the wall of its foremost bore in the page of SIZE (pixels), as the bracket is looked at."""

GAMEPAD = """() => {
  const buttons = Array.from({ length: 17 }, () => ({ pressed: false, value: 0 }));
  navigator.getGamepads = () => [{ id: "Xbox Wireless Controller", connected: true, mapping: "standard",
                                    axes: [0, 0, 0, 0], buttons }];
}"""
"""A gamepad as the browser would tell it."""

DRAWN = '.view .canvas[aria-busy="false"]'
"""The view when it shows all that there is."""

PAINTED_SECONDS = 17.0
"""Simulated time for which a hood is painted before its picture: three passes and a half."""

PRESSES = 20
"""How often a button is pressed at most: a page that comes too late, on a busy machine, stops what it drives."""

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
@click.option("--only", "names", multiple=True, metavar="NAME", help="A picture, such as traces [all].")
@click.option("--theme", type=click.Choice(["dark", "light"]), default="dark", show_default=True)
@click.option("--quality", type=click.Choice(["high", "low"]), default="high", show_default=True)
@click.option("--size", type=(int, int), default=SIZE, show_default=True, help="Of the page, in pixels.")
def main(folder: Path, names: tuple[str, ...], theme: str, quality: str, size: tuple[int, int]) -> None:
    """Write pictures of the page's tools to FOLDER, each of a cell of its own, so that none shows what another left."""
    if unknown := set(names) - PICTURES.keys():
        raise click.UsageError(f"there is no picture {unknown.pop()!r}; there are {', '.join(PICTURES)}")
    with browsers() as browser:
        for name in names or PICTURES:
            with (
                KernelProcess("--no-token", headless=True) as kernel,
                virtualrobot.connect(kernel.address) as client,
            ):
                cell.load(client)
                with opened_page(browser, kernel.address, theme, quality, size) as page:
                    page.locator('.node[data-name="iiwa"]').click()
                    page.locator(DRAWN).wait_for()
                    shown = PICTURES[name](client, page)
                    _save(shown or page, folder / f"console-{name}.png")


def _library(client: virtualrobot.Client, page: Page) -> None:
    """Choose a model of the library, and hold the pointer where it would stand."""
    page.get_by_role("tab", name="Library").click()
    page.get_by_label("Kinds").get_by_role("button", name="arm", exact=True).click()
    page.get_by_label("Filter models").fill("kuka")
    page.get_by_label("Place kr16", exact=True).click()
    page.wait_for_function("document.querySelector('.cover') === null")
    box = page.locator(".view canvas").bounding_box()
    assert box
    page.mouse.move(box["x"] + 0.36 * box["width"], box["y"] + 0.8 * box["height"])


def _program(client: virtualrobot.Client, page: Page) -> None:
    """Play a program until its last move."""
    arm = client.robots["iiwa"]
    for name, (turn, lift) in PLACES.items():
        arm.set_positions([turn, lift, 0.0, -1.1, 0.0, 1.3, 0.0])
        arm.teach(name)
    page.get_by_role("tab", name="Program").click()
    page.set_input_files("#open-program", {"name": "fetch.yaml", "mimeType": "", "buffer": PROGRAM.encode()})
    page.locator("#play").click()
    page.wait_for_selector(".step.lit:nth-child(6)")
    client.clock.set_stepped()  # and nobody steps: the world stands still


def _traces(client: virtualrobot.Client, page: Page) -> None:
    """Trace the arm's tool through a program."""
    page.get_by_role("tab", name="Traces").click()
    page.get_by_role("button", name="Trace iiwa", exact=True).click()
    _program(client, page)
    page.get_by_role("tab", name="Traces").click()


def _open_code(client: virtualrobot.Client, page: Page) -> None:
    """Open a program in RAPID for an arm beside the cell."""
    client.load_robot("model://irb120", name="sorter", pose=virtualrobot.pose(0.9, -1.3, yaw=2.4))
    page.get_by_role("tab", name="Code").click()
    page.locator("#open-code").wait_for(state="attached")
    page.set_input_files("#open-code", {"name": "sort.mod", "mimeType": "", "buffer": SORT.encode()})
    page.get_by_label("Robot that it moves").select_option("sorter")


def _code(client: virtualrobot.Client, page: Page) -> None:
    """Debug a program in RAPID until its second part, while the arm is on its way."""
    _open_code(client, page)
    page.locator(".cm-breakpoints .cm-gutterElement").nth(SORT.split("parts := parts")[0].count("\n") + 1).click()
    page.locator("#run-code").click()
    page.get_by_label("Value of parts").wait_for()
    page.get_by_role("button", name="Go on", exact=True).click()
    page.locator(".cm-motion").wait_for()
    page.locator(".cm-stands").wait_for()


def _ahead(client: virtualrobot.Client, page: Page) -> Locator:
    """Run the same program, and let time stand still on the way to the tray: what is planned is drawn."""
    _open_code(client, page)
    page.locator('.node[data-name="sorter"]').click()
    page.locator("#run-code").click()
    page.locator(".cm-motion").get_by_text("tray").wait_for()
    client.clock.set_stepped()
    page.wait_for_timeout(2000.0)
    page.mouse.move(700.0, 250.0)
    page.keyboard.press("f")
    page.mouse.wheel(0.0, 800.0)
    page.wait_for_timeout(1000.0)
    return page.locator(".view")


def _trajectory(client: virtualrobot.Client, page: Page) -> None:
    """Open a trajectory that sweeps over the pallet, and go to a third of it."""
    client.robots["iiwa"].set_positions([-1.2, 0.35, 0.0, -1.1, 0.0, 1.3, 0.0])
    rows = ["time," + ",".join(f"lbr_iiwa_joint_{joint}" for joint in (1, 2, 4, 6))]
    for tick in range(101):
        turn = math.pi * tick / 50.0  # one turn in 4 s
        lift = 0.5 - 0.5 * math.cos(turn)
        ahead = 0.5 - 0.5 * math.cos(2.0 * turn)
        row = (0.04 * tick, 0.8 * lift - 1.2, 0.35 + 0.35 * ahead, 0.3 * lift - 1.1, 1.3 - 0.35 * ahead)
        rows.append(",".join(f"{value:.6f}" for value in row))
    page.get_by_role("tab", name="Trajectory").click()
    data = "\n".join(rows).encode()
    page.set_input_files("#open-trajectory", {"name": "sweep.csv", "mimeType": "", "buffer": data})
    page.get_by_text("keeps all limits").wait_for()
    slider = page.get_by_label("Time of the trajectory, s")
    slider.press("Home")
    for _ in range(3):
        slider.press("PageUp")


def _drive(client: virtualrobot.Client, page: Page) -> Locator:
    """Drive a UGV by its button, and let time stand still while it goes."""
    client.load_robot("model://ugv", name="ugv", base="planar", pose=virtualrobot.pose(0.9, -1.3, yaw=2.4))
    page.locator('.node[data-name="ugv"]').click()
    page.get_by_label("Ahead", exact=True).hover()
    for _ in range(PRESSES):
        page.mouse.down()
        with suppress(AssertionError):
            expect(page.locator("#driven")).to_contain_text("0.30 m/s")
            break
        page.mouse.up()
    client.clock.set_stepped()
    return page.get_by_label("Drive", exact=True)


def _devices(client: virtualrobot.Client, page: Page) -> Locator:
    """Show what a gamepad means for an arm."""
    page.evaluate(GAMEPAD)
    page.get_by_role("button", name="Gamepad and space mouse").click()
    panel = page.get_by_role("region", name="Gamepad and space mouse")
    panel.get_by_text("Hold right_shoulder").wait_for()
    return panel


def _collisions(client: virtualrobot.Client, page: Page) -> None:
    """Put a post where the arm's tool is, and mark what touches."""
    client.collisions.set("monitor")
    arm = client.robots["iiwa"]
    arm.set_positions([-0.35, 0.75, 0.0, -1.1, 0.0, 1.3, 0.0])
    x, y, z = arm.tcp[:3, 3]
    client.scene.add_object("post", virtualrobot.box(0.1, 0.1, z + 0.03), pose=virtualrobot.pose(x, y, (z + 0.03) / 2))
    page.get_by_role("tab", name="Collisions").click()
    page.get_by_role("list", name="What touches now").get_by_role("listitem").first.get_by_role("button").first.click()


def _parts(client: virtualrobot.Client, page: Page) -> None:
    """Choose a box on the belt that the arm's tool is not near enough to."""
    client.robots["iiwa"].set_positions([-0.8, 0.4, 0.0, -1.1, 0.0, 1.3, 0.0])
    for number in range(1, 4):
        pose = virtualrobot.pose(0.45 - 0.3 * number, -0.02, 0.72)
        figure = virtualrobot.box(0.155, 0.10, 0.11, color="#c99a62")
        client.scene.add_part(f"box-{number}", figure, pose=pose, mass=1.0)
    page.get_by_role("tab", name="Parts", exact=True).click()
    page.locator("#parts").get_by_role("listitem").first.get_by_role("button").first.click()


def _views(client: virtualrobot.Client, page: Page) -> None:
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
    page.get_by_role("img", name="What wrist sees").wait_for()


def _connections(client: virtualrobot.Client, page: Page) -> None:
    """Connect signals, and begin with one more connection."""
    for signal in SIGNALS:
        client.signals.create(signal)
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


def _modeller(client: virtualrobot.Client, page: Page) -> None:
    """Write a bracket that lies on the belt."""
    page.get_by_role("tab", name="Modeller").click()
    page.locator("#new-body").click()
    text = page.get_by_label("Text of body", exact=True)
    text.fill(BRACKET)
    page.get_by_text("body is what is written").wait_for()
    client.scene.rename("body", "bracket")
    client.scene.set_pose("bracket", virtualrobot.pose(0.1, -0.9, 0.0, yaw=2.2))
    page.get_by_label("Text of bracket", exact=True).wait_for()
    page.get_by_role("tab", name="Properties").click()
    page.wait_for_timeout(1000.0)
    page.locator(DRAWN).wait_for()
    page.keyboard.press("f")
    page.evaluate("document.activeElement.blur()")


def _joints(client: virtualrobot.Client, page: Page) -> None:
    """Pick the axis of a bracket's bore, about which it is to turn."""
    _modeller(client, page)
    page.locator(DRAWN).wait_for()
    panel = page.get_by_label("What happens", exact=True)
    panel.get_by_role("radio", name="Joint").click()
    panel.get_by_role("button", name="Pick an axis").click()
    page.mouse.click(*BORE)
    panel.get_by_label("The body, or the link, that it moves on").fill("floor")
    panel.get_by_label("The body, or the link, that it moves on").press("Enter")
    panel.get_by_label("Name of the device").fill("latch")
    page.evaluate("document.activeElement.blur()")


def _films(client: virtualrobot.Client, page: Page) -> None:
    """Film the view while the arm moves, beside a film that is whole."""
    page.get_by_title("Films", exact=True).click()
    panel = page.get_by_label("Films", exact=True)
    panel.get_by_role("radio", name="640").click()
    film = panel.get_by_role("button", name="Film", exact=True)
    film.click()
    arm = client.robots["iiwa"]
    arm.move_joints({"lbr_iiwa_joint_1": -0.4, "lbr_iiwa_joint_2": 0.6})
    panel.get_by_role("button", name="Stop").click()
    panel.get_by_role("link", name="Save").wait_for()
    film.click()
    panel.get_by_text("is taken").wait_for()


def _process(client: virtualrobot.Client, page: Page) -> None:
    """Look along the saddle of the demo's pipes, in their own cell, with a torch that may not turn."""
    client.clock.set_stepped()
    client.scene.load_scene(CELLS / "pipes.yaml")
    page.locator('.node[data-name="arm"]').click()
    page.get_by_role("tab", name="Process", exact=True).click()
    page.locator(DRAWN).wait_for()
    page.locator('.node[data-name="pipes"]').click()
    page.keyboard.press("f")
    page.wait_for_timeout(1000.0)
    page.locator('.node[data-name="arm"]').click()
    text = (CELLS / "weld.yaml").read_text("utf-8").replace("rotation: free", "rotation: 0")
    page.set_input_files("#open-process", {"name": "weld.yaml", "mimeType": "", "buffer": text.encode()})
    panel = page.get_by_label("What happens", exact=True)
    panel.get_by_role("button", name="Look").click()
    panel.get_by_text("out of reach: ").first.wait_for()
    page.evaluate("document.activeElement.blur()")


class _HalfwayError(Exception):
    """End of what is done before a picture."""


def _film(client: virtualrobot.Client, page: Page) -> None:
    """Paint some of the demo's hood, in its own cell."""
    begun = client.clock.simulation_time

    def halfway() -> None:
        if client.clock.simulation_time - begun > PAINTED_SECONDS:
            raise _HalfwayError

    with suppress(_HalfwayError):
        run.main(client, CELLS / "booth.yaml", CELLS / "paint.yaml", 3.0, halfway)
    page.locator(DRAWN).wait_for()
    page.locator('.node[data-name="hood"]').click()
    page.keyboard.press("f")
    page.wait_for_timeout(1000.0)
    page.locator('.node[data-name="arm"]').click()
    page.evaluate("document.activeElement.blur()")


def _save(shown: Page | Locator, file: Path) -> None:
    page = shown.page if isinstance(shown, Locator) else shown
    page.locator(DRAWN).wait_for()
    page.wait_for_timeout(2000.0)  # what is asked again and again is told anew
    shown.screenshot(path=file)
    click.echo(f"{file}: {file.stat().st_size // 1024} kB")


PICTURES: dict[str, Callable[[virtualrobot.Client, Page], Locator | None]] = {
    "library": _library,
    "program": _program,
    "code": _code,
    "ahead": _ahead,
    "trajectory": _trajectory,
    "traces": _traces,
    "drive": _drive,
    "devices": _devices,
    "collisions": _collisions,
    "parts": _parts,
    "views": _views,
    "connections": _connections,
    "speeds": _speeds,
    "films": _films,
    "process": _process,
    "film": _film,
    "modeller": _modeller,
    "joints": _joints,
}
"""Steps that bring the page to where its picture is taken, of the page or of a part of it."""


if __name__ == "__main__":
    main()
