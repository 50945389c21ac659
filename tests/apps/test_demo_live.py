"""The demo as people meet it: seen in a browser, and going on with `loop`."""

from __future__ import annotations

import io
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout, suppress

import numpy as np
import pytest
import virtualrobot
from PIL import Image
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.demos.palletizing import palletize

from tools.screenshot import find_chromium, opened, picture

GUARD_SECONDS = 100.0


class Lines(io.StringIO):
    """What is printed; `wait_for` waits until it holds a text so often."""

    def wait_for(self, text: str, times: int = 1) -> None:
        """Return when it was printed so often; fail after a long while."""
        deadline = time.monotonic() + GUARD_SECONDS
        while self.getvalue().count(text) < times:
            assert time.monotonic() < deadline, self.getvalue()
            time.sleep(0.05)


@contextmanager
def running(kernel: KernelProcess, speed: float, **options: bool | int) -> Iterator[Lines]:
    """Run the demo in a thread; at the end close its connection, which ends it."""

    def work() -> None:
        with suppress(virtualrobot.VirtualRobotError):  # its connection was closed
            palletize.main(client, **options)  # pyright: ignore[reportArgumentType] the options of main

    with virtualrobot.connect(kernel.address) as client, redirect_stdout(Lines()) as lines:
        client.clock.speed_factor = speed
        thread = threading.Thread(target=work, daemon=True)
        thread.start()
        try:
            yield lines
        finally:
            client.close()
            thread.join(GUARD_SECONDS)
    assert not thread.is_alive(), "the demo did not hear that its connection was closed"


@pytest.mark.long
def test_loop_clears_the_pallets_and_starts_over() -> None:
    with KernelProcess(headless=True) as kernel, virtualrobot.connect(kernel.address) as watcher:
        with running(kernel, 20.0, loop=True, layers=1) as lines:
            lines.wait_for("total     12 in")
            lines.wait_for("box  3 of 12", 2)
            parts = [node.parent for node in watcher.scene.nodes("part")]
            assert parts.count("pallet-iiwa") + parts.count("pallet-panda") <= 12, "boxes of the first round are left"
        # Nobody watches the arms any more: the kernel stops them.
        deadline = time.monotonic() + GUARD_SECONDS
        while watcher.motions():
            assert time.monotonic() < deadline, "arms go on without their program"


@pytest.mark.long
@pytest.mark.skipif(find_chromium() is None, reason="no Chromium: install the package chromium to see the demo")
def test_a_browser_shows_the_cell_at_work() -> None:
    with (
        KernelProcess("--viewer-port", "0") as kernel,
        running(kernel, 4.0, headless=True) as lines,
        opened(kernel.viewer_url, 640, 400) as page,
    ):
        lines.wait_for(f"viewer at {kernel.viewer_url}")
        lines.wait_for("box  4 of")
        deadline = time.monotonic() + GUARD_SECONDS
        while True:
            first = np.asarray(Image.open(io.BytesIO(picture(page))).convert("RGB")).astype(int)
            page.wait_for_timeout(500)
            second = np.asarray(Image.open(io.BytesIO(picture(page))).convert("RGB")).astype(int)
            red, green, blue = first[..., 0], first[..., 1], first[..., 2]
            orange = (red > 180) & (green > 60) & (green < 140) & (blue < 70)  # of the iiwa's joints
            yellow = (red > 180) & (green > 140) & (blue < 100)  # of the fence
            blues = (blue > 100) & (red < 60) & (green < 140)  # of the feeder and the small boxes
            moved = np.abs(second - first).max(axis=2) > 40
            if min(orange.sum(), yellow.sum(), blues.sum(), moved.sum()) > 150:
                return
            assert time.monotonic() < deadline, (orange.sum(), yellow.sum(), blues.sum(), moved.sum())
