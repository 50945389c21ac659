"""A person measures what is clicked in the view, and what is named; a node is saved as glTF by its menu."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
import trimesh
import virtualrobot
from playwright.sync_api import Page, expect

from tests.api.asking import IIWA
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess

pytestmark = [*needs_page, pytest.mark.long]

EYE_METERS, MIDDLE = 1.0, 0.15
"""Height of the eye above z = 0, and the x that it looks at."""
FIELD = np.radians(30.0)
HOLE = np.array([0.2, 0.0, 0.02])
"""Middle of the ring's upper edge (m), in the world; its hole has a radius of 10 mm."""


def at(page: Page, x: float, y: float, z: float) -> tuple[float, float]:
    """Return where a point (m) is in the window, seen by a pinhole from above with x to the right and y up."""
    canvas = page.locator(".view .canvas canvas").bounding_box()
    assert canvas is not None
    per_meter = canvas["height"] / 2 / np.tan(FIELD / 2) / (EYE_METERS - z)
    middle = canvas["x"] + canvas["width"] / 2, canvas["y"] + canvas["height"] / 2
    return middle[0] + (x - MIDDLE) * per_meter, middle[1] - y * per_meter


def click(page: Page, x: float, y: float, z: float) -> None:
    page.mouse.move(*at(page, x, y, z))
    page.mouse.click(*at(page, x, y, z))


def a_cell(client: virtualrobot.Client, folder: Path) -> None:
    """Build a plate of 200 x 100 x 20 mm, and beside it a ring of 80 and 20 mm, 40 mm high; look at them from above."""
    client.scene.add_object("plate", virtualrobot.box(0.2, 0.1, 0.02))
    ring = trimesh.creation.annulus(r_min=0.01, r_max=0.04, height=0.04, sections=48)
    ring.export(folder / "ring.stl")
    client.scene.add_object("ring", client.assets.mesh(folder / "ring.stl"), pose=virtualrobot.pose(0.2))
    # A hair off the vertical keeps the picture upright.
    client.view.set_camera((MIDDLE, -1e-5, EYE_METERS), (MIDDLE, 0.0, 0.0), FIELD)


def test_what_is_clicked_is_measured(console: Console, stepped_kernel: KernelProcess, tmp_path: Path) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        a_cell(client, tmp_path)
        with opened(browser, console.url + PLAIN, 1440, 900) as page:
            expect(row(page, "ring")).to_be_visible()
            page.locator('.view .canvas[aria-busy="false"]').wait_for()
            page.keyboard.press("d")
            panel = page.get_by_role("region", name="Measure")
            said = panel.get_by_label("Measured")

            # From a corner to the edge of the hole, which is its middle; nothing is selected by it.
            click(page, 0.099, 0.049, 0.01)
            expect(panel).to_contain_text("corner")
            click(page, 0.2, 0.0105, 0.02)
            expect(panel).to_contain_text("round edge Ø 20.00 mm")
            between = HOLE - [0.1, 0.05, 0.01]
            for words in (
                f"Distance{1000 * np.linalg.norm(between):.2f} mm",
                *(f"{1000 * one:.2f} mm" for one in between),
            ):
                expect(said).to_contain_text(words)
            expect(said).to_contain_text(f"Point to axis{1000 * np.hypot(*between[:2]):.2f} mm")
            expect(page.locator('.node[aria-selected="true"]')).to_have_count(0)

            # It goes along with what moves.
            client.scene.set_pose("ring", virtualrobot.pose(0.2, z=0.03))
            expect(said).to_contain_text("40.00 mm")
            client.scene.set_pose("ring", virtualrobot.pose(0.2))

            # Faces that are parallel, and an edge in one that is.
            click(page, 0.02, 0.02, 0.01)
            click(page, 0.2, 0.025, 0.02)
            expect(said).to_contain_text("Between faces10.00 mm")
            expect(said).to_contain_text("Angle0.00°")
            click(page, 0.099, 0.02, 0.01)
            expect(panel).to_contain_text("straight edge 100.0 mm long")
            click(page, 0.2, 0.025, 0.02)
            expect(said).to_contain_text("Edge to face10.00 mm")

            # Who wants a click for something else ends it, and is ended by it: a click does one thing.
            page.get_by_role("tab", name="Modeller").click()
            page.get_by_role("radio", name="Joint", exact=True).click()
            pick = page.get_by_role("button", name="Pick an axis")
            pick.click()
            expect(panel).to_have_count(0)
            page.locator(".view .canvas canvas").hover()
            page.keyboard.press("d")
            expect(panel).to_be_visible()
            expect(pick).to_be_visible()
            page.keyboard.press("Escape")
            expect(panel).to_have_count(0)
            page.keyboard.press("d")

            # By keys alone: origins of nodes that are named.
            for label, name in (("From", "plate"), ("To", "ring")):
                field = panel.get_by_label(f"{label}: a node's origin")
                field.fill(name)
                field.press("Enter")
            expect(said).to_contain_text("Distance200.00 mm")
            field.press("Escape")
            expect(panel).to_have_count(0)

            # What was measured is saved by its menu, as glTF with y up, and a robot as URDF with its meshes.
            saved = tmp_path / "saved"
            for name, words, file in (("ring", "Save as glTF", "ring.glb"), ("arm", "Save as URDF", "arm.zip")):
                if name == "arm":
                    client.load_robot(IIWA, name="arm")
                row(page, name).click(button="right")
                with page.expect_download() as download:
                    page.get_by_role("menuitem", name=words).click()
                assert download.value.suggested_filename == file
                download.value.save_as(saved / file)
            np.testing.assert_allclose(trimesh.load_scene(saved / "ring.glb").extents, [0.08, 0.04, 0.08], atol=1e-6)
            shutil.unpack_archive(saved / "arm.zip", saved)
            assert len(client.load_robot(saved / "arm.urdf", name="again").positions) == 7
