"""Fields of one value at the console's page, written sooner than anything is answered: none takes another back."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Page, expect
from virtualrobot.v1 import scene_pb2

from tests.api.asking import IIWA
from tests.api.reading import step
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import repeated, until

pytestmark = [*needs_page, pytest.mark.long]

TYPED = """([within, pairs]) => {
    for (const [label, text] of pairs) {
        const field = document.querySelector(`${within} [aria-label="${label}"]`);
        field.focus();
        field.value = text;
        field.dispatchEvent(new InputEvent("input", { bubbles: true }));
        field.dispatchEvent(new KeyboardEvent("keydown", { key: "Tab", bubbles: true }));
        field.blur();
    }
}"""
"""Writes into all these fields, each left by Tab, in one breath: nothing can be answered in between."""


def type_at_once(page: Page, within: str, numbers: dict[str, str]) -> None:
    page.evaluate(TYPED, [within, list(numbers.items())])


def test_each_field_keeps_what_was_written(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        client.load_robot(IIWA, name="arm")
        client.scene.add_camera("eye", virtualrobot.camera(64, 48))
        client.scene.add_object("crate", virtualrobot.box(0.1, 0.1, 0.1))
        with opened(browser, console.url + PLAIN) as page:
            row(page, "eye").click()
            page.get_by_role("tab", name="Properties").click()

            # A pose, and settings of a kind, which are one message to the kernel.
            type_at_once(page, "#properties", {"X": "-350", "Y": "20", "Z": "750", "Rz": "90"})
            until(lambda: np.allclose(client.scene.pose("eye"), virtualrobot.pose(-0.35, 0.02, 0.75, yaw=np.pi / 2)))
            type_at_once(page, "#properties", {"Width": "80", "Height": "60"})

            def size() -> tuple[int, int]:
                (node,) = stepped.scene.GetScene(scene_pb2.GetSceneRequest(names=["eye"])).nodes
                return node.camera_sensor.width, node.camera_sensor.height

            until(lambda: size() == (80, 60))

            # Edges of a figure, which belong to one list.
            row(page, "crate").click()
            type_at_once(page, "#properties", {"Size along X": "200", "Size along Y": "300", "Size along Z": "400"})

            def extent() -> np.ndarray:
                bounds = client.scene.bounds("crate")
                assert bounds is not None
                return bounds[1] - bounds[0]

            until(lambda: np.allclose(extent(), [0.2, 0.3, 0.4]))

            # Where the tool shall be: the ghost that the robot moves to is that of all of it.
            row(page, "arm").click()
            page.get_by_role("tab", name="Pendant").click()
            wanted = {"X": "450", "Y": "100", "Z": "600", "Rx": "180", "Ry": "0", "Rz": "0"}
            type_at_once(page, "#pendant", wanted)
            page.locator("#go").click()
            goal = virtualrobot.pose(0.45, 0.1, 0.6, roll=np.pi)
            with repeated(lambda: step(stepped, 50)):
                until(lambda: np.allclose(client.robot("arm").tcp, goal, atol=1e-4))
                expect(page.locator("#go")).to_have_count(0)
            # Half a turn is written and read as the same number.
            expect(page.locator("#pendant").get_by_label("Rx", exact=True)).to_have_value("180.00")
