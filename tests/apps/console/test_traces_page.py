"""A person traces a robot's tool at the console's page, and keeps the trace in the world; the kernel is asked."""

from __future__ import annotations

import re

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import expect
from virtualrobot.v1 import motion_pb2, scene_pb2

from tests.api.asking import IIWA
from tests.api.reading import scene, step, values
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

WAY_METERS = 0.1


def test_a_person_traces_a_line(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        arm = client.load_robot(IIWA, name="iiwa")
        arm.set_positions([0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0])
        start = arm.tcp[:3, 3]
        with opened(browser, console.url + PLAIN) as page:
            row(page, "iiwa").click()
            page.get_by_role("tab", name="Traces").click()
            page.get_by_role("button", name="Trace iiwa", exact=True).click()
            traced = page.get_by_label("Trace of iiwa", exact=True)
            expect(traced).to_contain_text(re.compile(r"(?<!\d)0 mm"))

            # A line of 100 mm: the trace is as long, but for a last piece of less than 2 mm, and as straight.
            program = client.program().move(arm.linear(virtualrobot.pose(z=WAY_METERS) @ arm.tcp))
            motion = program.start(wait=False, on_disconnect="continue")

            def over() -> bool:
                step(stepped, 20)
                asked = motion_pb2.GetMotionRequest(id=motion.id)
                return stepped.motion.GetMotion(asked).motion.phase == motion_pb2.MOTION_PHASE_SUCCEEDED

            until(over)
            expect(traced).to_contain_text(re.compile(r"(?<!\d)(98|99|100) mm"))
            traced.get_by_label("Colour of the trace of iiwa").fill("#00ff00")
            traced.get_by_role("button", name="Keep").click()
            until(lambda: "trace of iiwa" in scene(stepped))
            (node,) = stepped.scene.GetScene(scene_pb2.GetSceneRequest(names=["trace of iiwa"])).nodes
            color = node.figures[0].material.color
            assert (color.red, color.green, color.blue) == (0.0, 1.0, 0.0)
            segments = values(node.figures[0].lines.segments)
            np.testing.assert_allclose(segments[0, 0], start, atol=1e-4)
            assert np.linalg.norm(segments[-1, 1] - segments[0, 0]) == pytest.approx(WAY_METERS, abs=0.002)
            np.testing.assert_allclose(
                segments[:, :, :2], np.broadcast_to(start[:2], segments[:, :, :2].shape), atol=1e-4
            )
            np.testing.assert_array_equal(segments[1:, 0], segments[:-1, 1])

            # Cleared it is empty and can't be kept; what was kept goes by undo.
            traced.get_by_title("Clear the trace of iiwa").click()
            expect(traced).to_contain_text(re.compile(r"(?<!\d)0 mm"))
            expect(traced.get_by_role("button", name="Keep")).to_be_disabled()
            page.get_by_title("Undo (Ctrl-Z)").click()
            until(lambda: "trace of iiwa" not in scene(stepped))
            traced.get_by_title("Trace iiwa no more").click()
            expect(traced).to_have_count(0)
