"""A person adds simple things at the console's page, and writes where one is; the finder finds what isn't shown."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import expect
from virtualrobot.v1 import scene_pb2

from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]


def greatest(client: virtualrobot.Client, name: str) -> np.ndarray:
    """Return the greatest coordinates (3,) of a node's surface in its own frame, in meters."""
    bounds = client.scene.bounds(name)
    assert bounds is not None
    return bounds[1]


def test_a_person_adds_a_table_and_a_part(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        with opened(browser, console.url + PLAIN) as page:
            expect(page.locator("#connection")).to_have_text("connected")

            # A table as `virtualrobot add table` has it, by its edges; a length that is none is not added.
            page.get_by_role("button", name="Add …").click()
            add = page.get_by_role("button", name="Add it")
            page.get_by_label("Name of the new thing").fill("bench")
            page.get_by_label("Length along x").fill("-1")
            expect(add).to_be_disabled()
            page.get_by_label("Length along x").fill("1400,5")
            page.get_by_label("Stands at X").fill("500")
            add.click()
            expect(row(page, "bench")).to_have_attribute("aria-selected", "true")
            bounds = client.scene.bounds("bench")
            assert bounds is not None
            np.testing.assert_allclose(bounds, [[-0.70025, -0.4, 0.0], [0.70025, 0.4, 0.75]], atol=1e-6)
            np.testing.assert_allclose(client.scene.pose("bench")[:3, 3], [0.5, 0.0, 0.0])

            # A part on it: its origin is in its middle, and its mass is what was written.
            page.get_by_role("button", name="Add …").click()
            page.get_by_role("radio", name="Cylinder").click()
            page.get_by_role("switch", name="Part").click()
            page.get_by_label("Mass, 0 is unknown").fill("0.2")
            page.get_by_label("Stands at Z").fill("750")
            add.click()
            expect(row(page, "cylinder")).to_be_visible()
            np.testing.assert_allclose(client.scene.pose("cylinder")[:3, 3], [0.5, 0.0, 0.8])
            assert client.scene.node("cylinder").kind == "part"

            # A name that is taken is refused in the kernel's words, and the form stays.
            page.get_by_role("button", name="Add …").click()
            page.get_by_label("Name of the new thing").fill("bench")
            add.click()
            expect(page.locator("#last")).to_contain_text("bench")
            expect(add).to_be_visible()
            page.get_by_label("Name of the new thing").press("Escape")
            expect(add).to_have_count(0)

            # Where it is, written number by number with Tab; the fields tell what has come of it.
            page.get_by_role("tab", name="Properties").click()
            for label, text in {"X": "-350", "Y": "25", "Rz": "90"}.items():
                field = page.locator("#properties").get_by_label(label, exact=True)
                field.fill(text)
                field.press("Tab")
                expect(field).to_have_value(f"{text}.00")
            until(
                lambda: np.allclose(client.scene.pose("cylinder"), virtualrobot.pose(-0.35, 0.025, 0.8, yaw=np.pi / 2))
            )

            # Its size and its colour are changed where they stand; a size that is none is refused in words.
            figures = page.get_by_role("region", name="Figures")
            figures.get_by_label("Length", exact=True).fill("250")
            figures.get_by_label("Length", exact=True).press("Tab")
            until(lambda: np.allclose(greatest(client, "cylinder"), [0.03, 0.03, 0.125]))
            figures.get_by_label("Diameter").fill("0")
            figures.get_by_label("Diameter").press("Enter")
            expect(page.locator("#last")).to_contain_text("radius")
            figures.get_by_label("Colour").fill("#00ff00")

            def color() -> tuple[float, float, float]:
                shown = stepped.scene.GetScene(scene_pb2.GetSceneRequest()).nodes
                of = next(node for node in shown if node.name == "cylinder").figures[0].material.color
                return of.red, of.green, of.blue

            until(lambda: color() == (0.0, 1.0, 0.0))
            np.testing.assert_allclose(greatest(client, "cylinder"), [0.03, 0.03, 0.125])

            # A camera that looks at a point, as the client's own function has it, and its picture; a beam goes along x.
            eye, goal = (0.6, -0.4, 0.9), (0.0, 0.1, 0.5)
            for kind, name in (("Camera", "camera"), ("Range sensor", "range sensor")):
                page.get_by_role("button", name="Add …").click()
                page.get_by_role("radio", name=kind, exact=True).click()
                for words, point in (("Stands at", eye), ("Looks at", goal)):
                    for axis, meters in zip("XYZ", point, strict=True):
                        page.get_by_label(f"{words} {axis}").fill(f"{1000.0 * meters:g}")
                add.click()
                expect(row(page, name)).to_have_attribute("aria-selected", "true")
            np.testing.assert_allclose(client.scene.pose("camera"), virtualrobot.looking_at(eye, goal), atol=1e-6)
            expect(page.locator(".inset")).to_contain_text("camera")
            beam = client.scene.pose("range sensor")
            np.testing.assert_allclose(beam[:3, 0], virtualrobot.looking_at(eye, goal)[:3, 2], atol=1e-6)
            assert beam[2, 2] > 0.0

            # A command of a panel that isn't shown: the panel comes, and the command is done.
            page.keyboard.press("Control+k")
            page.keyboard.type("box begin modeller")
            expect(page.get_by_role("option").first).to_contain_text("A box at the origin, to begin with")
            page.keyboard.press("Enter")
            expect(page.get_by_role("tab", name="Modeller")).to_have_attribute("aria-selected", "true")
            until(lambda: "body" in client.scene)
