"""A person makes a body at the console's page by writing and by buttons; the kernel is asked each time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
import virtualrobot
import yaml
from playwright.sync_api import expect
from virtualrobot_apps.modeller import modelling

from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytest.importorskip("manifold3d", reason="the package for bodies is not installed")

pytestmark = [*needs_page, pytest.mark.long]

BLOCK = "solid: {box: {size: [0.2, 0.1, 0.3]}}\n"


def test_a_person_models(console: Console, stepped: Stubs, stepped_kernel: KernelProcess, tmp_path: Path) -> None:
    def said() -> dict[str, Any]:
        """Return the body's words, as another client reads them."""
        return yaml.safe_load(modelling.described(client, "body"))["solid"]

    def size() -> np.ndarray:
        """Return the size of the body along the axes of glTF, x, z, -y, as another client exports it."""
        client.scene.export("body", tmp_path / "body.glb")
        return trimesh.load_scene(tmp_path / "body.glb").extents

    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        client.scene.add_object("table", virtualrobot.box(0.4, 0.4, 0.02), pose=virtualrobot.pose(y=-1.0))
        with opened(browser, console.url + PLAIN, 1280, 720) as page:
            row(page, "table").click()
            page.get_by_role("tab", name="Modeller").click()
            panel = page.get_by_label("What happens", exact=True)
            expect(panel).to_contain_text("table has no text that its body is made by")
            page.locator("#new-body").press("Enter")
            text = panel.get_by_label("Text of body", exact=True)
            expect(text).to_have_value("solid: {box: {size: [0.1, 0.1, 0.1]}}\n")

            # Written, it is there: as large as it says. A space is a space, and stops nothing.
            text.fill(BLOCK)
            text.press("End")
            text.press(" ")
            until(lambda: np.allclose(size(), [0.2, 0.3, 0.1], atol=1e-6))
            assert client.cell.stopped is None
            expect(panel.get_by_role("status")).to_contain_text("body is what is written")

            # By buttons: a hole, and a second one; then a mirrored copy of all.
            panel.get_by_role("button", name="difference").click()
            until(lambda: len(said().get("difference", [])) == 2)
            panel.get_by_role("button", name="difference").click()
            until(lambda: len(said().get("difference", [])) == 3)
            panel.get_by_role("button", name="row").click()
            until(lambda: "row" in said())
            assert said()["row"]["solid"].keys() == {"difference"}
            until(lambda: np.allclose(size(), [0.2 + 2 * 0.12, 0.3, 0.1], atol=1e-6))

            # Around what is selected in the text.
            text.fill(BLOCK)
            text.evaluate("(field) => field.setSelectionRange(7, field.value.length - 1)")
            panel.get_by_role("button", name="move").click()
            expect(text).to_have_value("solid: {move: {solid: {box: {size: [0.2, 0.1, 0.3]}}, by: [0, 0, 0.05]}}\n")
            until(lambda: "move" in said())

            # What makes no body is told with its place, and nothing changes.
            text.fill(BLOCK.replace("0.3", "-0.3"))
            expect(panel.get_by_role("alert")).to_contain_text("solid.box.size")
            assert "move" in said()
            text.fill(BLOCK)
            expect(panel.get_by_role("alert")).to_have_count(0)
            until(lambda: "box" in said())

            # Undo brings back the body before, and the text follows it.
            page.get_by_title("Undo (Ctrl-Z)").click()
            expect(text).to_have_value("solid: {move: {solid: {box: {size: [0.2, 0.1, 0.3]}}, by: [0, 0, 0.05]}}\n")
            assert "move" in said()

            # What another client makes of it is what stands here.
            client.scene.rename("body", "bracket")
            row(page, "bracket").click()
            expect(panel.get_by_label("Text of bracket", exact=True)).to_be_visible()
