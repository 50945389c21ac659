"""A person has a seam welded from the console's page: an edge is clicked, looked along in colours, planned and run."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Page, expect
from virtualrobot import Client
from virtualrobot.v1 import motion_pb2

from tests.api.reading import step
from tests.apps.console.browsing import PLAIN, browsers, color_count, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.apps.console.test_tools import ask
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

FREE, TOUCHES, UNREACHED = (0x4C, 0xC3, 0x8A), (0xFF, 0x9E, 0x4A), (0xF0, 0x61, 0x6D)
"""Colours of a way."""
EYE, TARGET, FIELD = np.array([0.3, 0.85, 1.05]), np.array([0.65, 0.0, 0.46]), np.radians(40.0)


def a_cell(client: Client) -> virtualrobot.Robot:
    """Return an arm with a torch before a wall on a plate, whose foot is 0.46 m high; looked at from EYE."""
    arm = client.load_robot("model://puma560", name="arm")
    nozzle = virtualrobot.cylinder(0.008, 0.075, pose=virtualrobot.pose(z=0.0975))
    tip = virtualrobot.pose(z=0.15)
    client.scene.add_tool("torch", arm.flange, [nozzle], tool_center_points={"wire": tip})
    client.scene.add_part("plate", virtualrobot.box(0.4, 0.3, 0.02), pose=virtualrobot.pose(0.65, 0.0, 0.45))
    wall = virtualrobot.pose(z=0.06)
    client.scene.add_part("wall", virtualrobot.box(0.01, 0.2, 0.1), pose=wall, parent="plate")
    client.signals.create("arc")
    client.view.set_camera(EYE, TARGET, FIELD)
    return arm


def at(page: Page, point: tuple[float, float, float]) -> tuple[float, float]:
    """Return where a point (m) is in the window, by a pinhole at EYE that looks at TARGET with z up."""
    canvas = page.locator(".view .canvas canvas").bounding_box()
    assert canvas is not None
    ahead = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    seen = np.array([right, np.cross(right, ahead), ahead]) @ (np.array(point) - EYE)
    scale = canvas["height"] / 2.0 / np.tan(FIELD / 2.0) / seen[2]
    middle = canvas["x"] + canvas["width"] / 2.0, canvas["y"] + canvas["height"] / 2.0
    return middle[0] + scale * float(seen[0]), middle[1] - scale * float(seen[1])


def test_a_person_welds_an_edge_that_is_clicked(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess
) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        arm = a_cell(client)
        with opened(browser, console.url + PLAIN, 1440, 900) as page:
            row(page, "arm").click()
            page.get_by_role("tab", name="Process", exact=True).click()
            panel = page.get_by_role("region", name="What happens")
            text = panel.get_by_label("Text of the process")
            found = panel.get_by_role("list", name="What the process comes to")
            expect(panel).to_contain_text("Choose a process")
            panel.get_by_label("Process", exact=True).select_option("arc_weld")
            expect(text).to_have_value(re.compile("process: arc_weld\nrobot: arm\n"))

            # Near the foot of the wall: plate and wall are joined, and the edge between them is the seam.
            page.locator('.view .canvas[aria-busy="false"]').wait_for()
            panel.get_by_role("button", name="Pick an edge").click()
            page.mouse.click(*at(page, (0.63, 0.05, 0.46)))
            expect(text).to_have_value(re.compile(r"- \{part: plate, edge: concave, near: \[-0.005, 0, 0.01\]\}\n"))
            expect(found).to_contain_text("seam 1: 200.0 mm, reached at 30 places without touching anything")
            until(lambda: color_count(page, FREE) > 50)
            assert color_count(page, UNREACHED) == color_count(page, TOUCHES) == 0

            # Something that stands there, and less freedom: the torch would touch it, whatever turn it takes.
            post = virtualrobot.box(0.05, 0.04, 0.3)
            client.scene.add_object("post", post, pose=virtualrobot.pose(0.6, 0.05, 0.62))
            turn = panel.get_by_label("Turn about the tool, tolerance", exact=True)
            turn.fill("0")
            turn.press("Enter")
            expect(text).to_have_value(re.compile("rotation: 0, "))
            expect(found).to_contain_text("in reach, but not free")
            expect(found).to_contain_text("post")
            until(lambda: color_count(page, TOUCHES) > 20)

            # Dragged: a slider's end is any turn. Without the post the plan keeps all limits.
            client.scene.remove("post")
            slider = panel.get_by_label("Turn about the tool, tolerance by slider")
            slider.press("End")
            expect(text).to_have_value(re.compile("rotation: free, "))
            expect(found).to_contain_text("without touching anything")
            panel.get_by_role("button", name="Run").wait_for()
            expect(panel.get_by_role("button", name="Run")).to_be_disabled()
            panel.get_by_role("button", name="Plan", exact=True).click()
            expect(panel.get_by_role("status")).to_contain_text("keeps all limits and touches nothing")
            expect(found).to_contain_text("seam 1: 200.0 mm in 20.")
            expect(found).to_contain_text("arc on for 20.")
            np.testing.assert_array_equal(client.signals["arc"], False)

            # Run: while the arc burns the wire is on the foot of the wall, within the weave.
            panel.get_by_role("button", name="Run").click()
            until(lambda: stepped.motion.ListMotions(motion_pb2.ListMotionsRequest(running_only=True)).motions)
            welded = []

            def over() -> bool:
                step(stepped, 25)
                if client.signals["arc"]:
                    welded.append(arm.tcp[:3, 3])
                running = motion_pb2.ListMotionsRequest(running_only=True)
                return not stepped.motion.ListMotions(running).motions

            until(over)
            points = np.array(welded)
            assert np.ptp(points[:, 1]) == pytest.approx(0.2, abs=3e-3)
            off = np.hypot(points[:, 0] - 0.645, points[:, 2] - 0.46)
            assert off.max() < 0.0016
            expect(page.locator("#last")).to_contain_text("the program is done")

            # What is wrong is told with its line, and what was found before is gone.
            text.fill(text.input_value().replace("speed: 0.01", "sped: 0.01"))
            panel.get_by_role("button", name="Look").click()
            expect(panel.get_by_role("alert")).to_contain_text(re.compile(r"process.yaml:\d+: sped: there is no field"))
            expect(panel.get_by_role("button", name="Run")).to_be_disabled()
            until(lambda: color_count(page, FREE) == 0)


def test_files_of_the_console_s_machine_stay_there(console: Console, steps: Client) -> None:
    """G-code and curves come with the process; no other file is looked for. A corner is rounded by up to 0.1 mm."""
    text = "schema_version: 1\nprocess: mill\nrobot: arm\ncuts: [{part: plate, gcode: %s}]\nspeed: 0.1\n"
    text += "cutter: {heading: [1, 0, 0]}\n"
    a_cell(steps)
    steps.collisions.allowed.add("torch", "plate", "it mills")
    secret = Path(__file__).resolve()
    for name in (str(secret), "../a.nc", "a.nc"):
        refused = ask(console, "/processes/look", {"text": text % name, "name": "mill.yaml"})
        assert refused.status == 400 and "mill.yaml:4" in refused.json["message"]
        assert "has not come with it: open both files together" in refused.json["message"]
    for name in ("../a.nc", "/tmp/a.nc", ".."):
        refused = ask(console, "/processes/look", {"text": text % "a.nc", "files": {name: "G0 X0\n"}})
        assert "is no name of a file" in refused.json["message"]
    code = "G21 G90\nG0 X-50 Y0 Z15\nG1 Z12 F300\nG1 X-100 F900\nG0 Z20\nM2\n"
    told = ask(console, "/processes/look", {"text": text % "a.nc", "files": {"a.nc": code}})
    assert told.status == 200, told.body
    (cut,) = told.json
    assert cut["name"] == "cut 1" and set(cut["states"]) == {"free"} and cut["at"][-1] == pytest.approx(0.053, abs=3e-4)
    wrong = ask(console, "/processes/look", {"text": text % "a.nc", "files": {"a.nc": "G0 X0\nG7\n"}})
    assert "a.nc:2" in wrong.json["message"] and "/" not in wrong.json["message"].split(":")[0]


REFUSED: list[tuple[str, dict[str, object], str]] = [
    ("new", {"process": "forge"}, "'forge' is no process; there are arc_weld, cut,"),
    ("read", {"text": 5}, "'text' is a text"),
    ("read", {"text": "a: ["}, "process.yaml:1: not YAML"),
    ("change", {"text": "schema_version: 1\n", "field": "torch", "value": 1}, "a field is one of speed, rotation"),
    ("change", {"text": "schema_version: 1\n", "field": "speed", "value": "fast"}, "'speed' is 1 finite number"),
    ("edge", {"text": "schema_version: 1\n", "node": "plate", "point": [0, 0]}, "'point' is 3 finite numbers"),
    ("edge", {"text": "schema_version: 1\n", "node": "plate", "point": [0, 0, 0]}, "has no list of ways"),
    ("edge", {"text": "schema_version: 1\n", "node": "arm.link6", "point": [0, 0, 0]}, "is a link, and edges are"),
    ("edge", {"text": "schema_version: 1\n", "node": "none", "point": [0, 0, 0]}, "none"),
    ("look", {"text": "schema_version: 1\nprocess: tend\n"}, "tend has no ways to look along: plan it"),
    ("plan", {"text": "schema_version: 1\n"}, "the field 'process' is missing"),
    ("plan", {"text": "schema_version: 1\nprocess: cut\n", "files": 1}, "'files' are texts by their names"),
]
"""Requests for a process that are refused, and a part of the words."""


def test_what_is_no_process_is_refused(console: Console, steps: Client) -> None:
    a_cell(steps)
    for path, said, words in REFUSED:
        refused = ask(console, f"/processes/{path}", said)
        assert refused.status in (400, 404, 412) and words in refused.json["message"], refused.body
    text = ask(console, "/processes/new", {"process": "drill", "robot": "arm"}).json["text"]
    refused = ask(console, "/processes/edge", {"text": text, "node": "wall", "point": [0, 0, -0.05]})
    assert "'holes' are spots in this process, and no edges" in refused.json["message"]
