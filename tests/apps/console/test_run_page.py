"""A recorded run in one file plays in a browser that has no kernel and no network."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from PIL import Image
from playwright.sync_api import expect
from virtualrobot.recording.run_page import PLAYER

from tests.api.asking import IIWA
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened
from tests.kernels import KernelProcess, Stubs

BUILT = Path(virtualrobot.__file__).parent / "recording" / PLAYER

pytestmark = [
    *needs_page,
    pytest.mark.skipif(not BUILT.is_file(), reason="the player is not built: make console"),
    pytest.mark.long,
]


def test_a_run_plays_without_a_kernel(stepped: Stubs, stepped_kernel: KernelProcess, tmp_path: Path) -> None:
    file = tmp_path / "run.html"
    with virtualrobot.connect(stepped_kernel.address) as client:
        arm = client.load_robot(IIWA, name="arm")
        with client.start_recording(file) as recording:
            motion = arm.move_joints([1.5, 0.8, 0.0, -1.2, 0.0, 0.8, 0.0], wait=False)
            while not motion.phase.ended:
                recording.step(50)
            duration = recording.simulation_time
    with browsers() as browser, opened(browser, f"{file.as_uri()}{PLAIN.removeprefix('/')}") as page:
        canvas = page.locator("canvas")
        slider = page.get_by_label("Time (s)")
        expect(canvas).to_be_visible()
        expect(page.get_by_title("Look at all of it (F)").locator("svg")).to_be_visible()

        def picture(name: str) -> np.ndarray:
            page.screenshot(path=tmp_path / f"{name}.png", clip={"x": 0, "y": 0, "width": 1100, "height": 620})
            with Image.open(tmp_path / f"{name}.png") as image:
                return np.asarray(image.convert("RGB"), float)

        # It plays by itself, to its end, which is the kernel's.
        expect(page.locator("body")).to_have_attribute("data-playing", "false")
        expect(page.locator(".bar output")).to_have_text(f"{duration:.2f} / {duration:.2f} s")
        expect(canvas).to_have_attribute("data-drawn", f"{duration:.2f}")
        at_end = picture("end")
        page.keyboard.press("Home")
        expect(slider).to_have_value("0")
        expect(canvas).to_have_attribute("data-drawn", "0.00")
        at_begin = picture("begin")
        turned = np.abs(at_end - at_begin).max(axis=2) > 40.0
        assert turned.mean() > 0.01, "the arm stands elsewhere at the end"
        page.keyboard.press("ArrowRight")
        expect(slider).to_have_value("0.1")
        page.keyboard.press(" ")
        expect(page.locator("body")).to_have_attribute("data-playing", "true")
        page.keyboard.press(" ")
        expect(page.locator("body")).to_have_attribute("data-playing", "false")
        # What the pointer is at tells its name.
        page.keyboard.press("End")
        for x in range(300, 800, 20):
            page.mouse.move(x, 350)
            if (name := page.locator(".name").inner_text()).startswith("arm"):
                break
        assert name.startswith("arm")
