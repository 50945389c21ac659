"""A person makes a device of bodies at the console's page: axes are picked by clicks at a bore and an edge."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
import virtualrobot
from playwright.sync_api import Page, expect

from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess
from tests.unit.plugins.importers.reading import FILES
from tests.waiting import until

pytest.importorskip("cascadio", reason="the package that reads STEP is not installed")

pytestmark = [*needs_page, pytest.mark.long]

SIZE = np.array([0.3, 0.2, 0.1])
"""Edges (m) of the STEP file's block, five times those of the file; its frame is at a corner."""
BORE = np.array([0.1, 0.075, 0.05])
"""Middle (m) of its bore of 80 mm along z."""
FROM = np.array([0.62, -0.78, 0.5]) / np.linalg.norm([0.62, -0.78, 0.5])
FIELD = np.radians(42.0)
"""Direction from which the page looks at first (the key 7), and its vertical field of view, as the page has them."""


class Look:
    """Places of points of the world in the view, which looks at a node by the keys F and 7."""

    def __init__(self, page: Page, client: virtualrobot.Client, name: str) -> None:
        """Look at a node."""
        row(page, name).click()
        for key in ("f", "7"):
            page.keyboard.press(key)
        page.locator('.view .canvas[aria-busy="false"]').wait_for()
        bounds = client.scene.bounds(name)
        canvas = page.locator(".view .canvas canvas").bounding_box()
        assert bounds is not None and canvas is not None
        corners = np.array([[bounds[i, 0], bounds[j, 1], bounds[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
        pose = client.scene.pose(name)
        around = corners @ pose[:3, :3].T + pose[:3, 3]
        low, high = around.min(axis=0), around.max(axis=0)
        self.eye = 0.5 * (low + high) + FROM * max(float(np.linalg.norm(high - low)), 0.2) * 1.25
        self.page, self.canvas = page, canvas

    def click(self, point: np.ndarray) -> None:
        """Click at a point (3,) of the world, m."""
        right = np.cross([0.0, 0.0, 1.0], FROM) / np.linalg.norm(np.cross([0.0, 0.0, 1.0], FROM))
        ray = np.asarray(point) - self.eye
        x, y, depth = ray @ right, ray @ np.cross(FROM, right), -ray @ FROM
        half = 0.5 * self.canvas["height"] / np.tan(0.5 * FIELD)
        middle = self.canvas["x"] + 0.5 * self.canvas["width"], self.canvas["y"] + 0.5 * self.canvas["height"]
        self.page.mouse.click(middle[0] + half * x / depth, middle[1] - half * y / depth)


def numbers(text: str) -> np.ndarray:
    """Return the place (mm) and the direction of what the page says of an axis."""
    found = re.search(r"at (.*) mm along (.*)$", text)
    assert found, text
    return np.array([float(one) for one in f"{found[1]} {found[2]}".split()])


def about(axis: np.ndarray, center: np.ndarray, angle: float) -> np.ndarray:
    """Return the turn about an axis through a point as a matrix (4, 4), by Rodrigues' formula."""
    cross = np.cross(np.eye(3), axis)
    turn = np.eye(4)
    turn[:3, :3] += np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    turn[:3, 3] = center - turn[:3, :3] @ center
    return turn


def test_a_device_is_made_of_bodies(console: Console, stepped_kernel: KernelProcess, tmp_path: Path) -> None:
    placed = virtualrobot.pose(0.4, 0.2, 0.5, roll=0.2, yaw=0.5)
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        client.scene.load(FILES / "bored_block.step", name="block", scale=5.0, pose=placed)
        client.scene.add_object("stand", virtualrobot.box(0.05, 0.05, 0.3), pose=virtualrobot.pose(z=0.15))
        knob = virtualrobot.pose(0.2, 0.1, 0.05)
        client.scene.add_object("knob", virtualrobot.box(0.02, 0.02, 0.02), pose=knob, parent="block")
        client.scene.add_object("slide", virtualrobot.box(0.3, 0.2, 0.1), pose=virtualrobot.pose(-1.0, yaw=0.3))
        before = client.scene.poses()
        with opened(browser, console.url + PLAIN, 1280, 800) as page:
            page.get_by_role("tab", name="Modeller").click()
            panel = page.get_by_label("What happens", exact=True)
            panel.get_by_role("radio", name="Joint").click()
            make = panel.get_by_role("button", name="Make the joint")
            expect(make).to_be_disabled()
            look = Look(page, client, "block")
            row(page, "stand").click()
            pick = panel.get_by_role("button", name="Pick an axis")
            picked = panel.locator("#picked-axis")

            # By keys alone: an axis of a node's own frame.
            node = panel.get_by_label("A node, through whose origin the axis goes")
            node.fill("knob")
            node.press("Enter")
            panel.get_by_label("The axis z of the node").press("Enter")
            expect(picked).to_have_text("frame axis of knob at 0.0 0.0 0.0 mm along 0.000 0.000 1.000")

            # A flat face has no axis.
            pick.click()
            look.click(placed[:3, :3] @ [0.25, 0.15, 0.1] + placed[:3, 3])
            page.get_by_role("tab", name="Messages").click()
            expect(panel).to_contain_text("block has no axis there")
            page.get_by_role("tab", name="Modeller").click()

            # The wall of the bore that is across, a fifth of the way down.
            across = placed[:3, :3].T @ FROM
            across = across[:2] / np.linalg.norm(across[:2])
            look.click(placed[:3, :3] @ [*(BORE[:2] - 0.04 * across), 0.08] + placed[:3, 3])
            expect(picked).to_contain_text("hole Ø 80.00 mm of block")
            said = numbers(picked.inner_text())
            np.testing.assert_allclose(said[:3], 1000.0 * BORE, atol=0.1)
            np.testing.assert_allclose(np.abs(said[3:]), [0.0, 0.0, 1.0], atol=1e-3)
            if said[5] < 0.0:
                panel.get_by_role("button", name="Other way").click()
                expect(picked).to_contain_text("along 0.000 0.000 1.000")
            expect(panel.get_by_label("The body that moves")).to_have_value("block")
            expect(panel.get_by_label("The body, or the link, that it moves on")).to_have_value("stand")
            panel.get_by_label("Name of the device").fill("hinge")
            make.click()
            until(lambda: "hinge" in client.scene)
            hinge = client.robot("hinge")
            assert hinge.joint_names == ["block"]
            assert hinge.limits["block"].upper == pytest.approx(0.5 * np.pi)
            assert "block" not in client.scene and "stand" not in client.scene
            link = client.scene.pose("hinge.block")
            np.testing.assert_allclose(client.scene.pose("knob"), before["knob"], atol=1e-6)
            hinge.set_positions([0.7])
            turn = about(placed[:3, 2], placed[:3, :3] @ BORE + placed[:3, 3], 0.7)
            np.testing.assert_allclose(client.scene.pose("hinge.block"), turn @ link, atol=2e-4)
            np.testing.assert_allclose(client.scene.pose("knob"), turn @ before["knob"], atol=2e-4)
            bounds = client.scene.bounds("hinge.block")
            assert bounds is not None
            np.testing.assert_allclose(bounds, [-BORE, SIZE - BORE], atol=2e-4)

            # Undo takes all of it back, redo makes it again.
            page.get_by_title("Undo (Ctrl-Z)").click()
            until(lambda: "hinge" not in client.scene)
            now = client.scene.poses()
            assert now.keys() == before.keys()
            for name, pose in before.items():
                np.testing.assert_allclose(now[name], pose, atol=1e-6)
            page.get_by_title("Redo").click()
            until(lambda: "hinge" in client.scene)

            # Along a straight edge of another body, which becomes a link of the same robot.
            look = Look(page, client, "slide")
            pick.click()
            there = before["slide"]
            look.click(there[:3, :3] @ [0.15, 0.05, 0.05] + there[:3, 3])
            expect(picked).to_contain_text("straight edge of slide")
            along = there[:3, :3] @ numbers(picked.inner_text())[3:]
            on = panel.get_by_label("The body, or the link, that it moves on")
            on.fill("hinge.stand")
            on.press("Enter")
            panel.get_by_role("radio", name="slides").click()
            make.click()
            until(lambda: "slide" not in client.scene)
            assert hinge.joint_names == ["block", "slide"]
            link = client.scene.pose("hinge.slide")
            hinge.set_positions({"slide": 0.05})
            np.testing.assert_allclose(client.scene.pose("hinge.slide")[:3, 3], link[:3, 3] + 0.05 * along, atol=1e-4)

            # Two bodies of one file that touch face to face, taken apart: each is a node, and undo joins them again.
            lower, upper = trimesh.creation.box([0.2, 0.2, 0.1]), trimesh.creation.box([0.2, 0.2, 0.06])
            upper.apply_translation([0.0, 0.0, 0.08])
            trimesh.util.concatenate([lower, upper]).export(tmp_path / "pair.glb")
            client.scene.load(tmp_path / "pair.glb", name="pair", pose=virtualrobot.pose(2.0, roll=0.1))
            row(page, "pair").click()
            page.locator('.view .canvas[aria-busy="false"]').wait_for()
            panel.get_by_role("button", name="Take apart").click()
            until(lambda: "pair 2" in client.scene)
            for name, body in (("pair 1", lower), ("pair 2", upper)):
                bounds = client.scene.bounds(name)
                assert bounds is not None
                np.testing.assert_allclose(bounds, body.bounds, atol=1e-6)
            page.get_by_title("Undo (Ctrl-Z)").click()
            until(lambda: "pair 2" not in client.scene)

        # An ordinary robot, as URDF too.
        client.scene.export("hinge", tmp_path / "hinge.urdf")
        assert client.load_robot(tmp_path / "hinge.urdf", name="again").joint_names == ["block", "slide"]
