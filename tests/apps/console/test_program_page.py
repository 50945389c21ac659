"""A person teaches, plays, steps and saves a program at the console's page; the kernel is asked each time."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Locator, Page, expect
from virtualrobot.v1 import motion_pb2

from tests.api.asking import IIWA
from tests.api.reading import scene, state, step
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

HERE = (0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0)
THERE = (0.4, 0.6, 0.0, -1.0, 0.0, 0.9, 0.0)


def motions(stubs: Stubs) -> list[motion_pb2.Motion]:
    return list(stubs.motion.ListMotions(motion_pb2.ListMotionsRequest()).motions)


def step_row(page: Page, number: int) -> Locator:
    """Return the row of a step, from 1."""
    return page.get_by_label("Steps", exact=True).get_by_role("listitem").nth(number - 1)


def ended(page: Page, stubs: Stubs, count: int) -> motion_pb2.Motion:
    """Return the last motion, when there are so many, it has ended and the page knows; time goes on meanwhile."""

    def over() -> bool:
        step(stubs, 20)
        return len(motions(stubs)) == count and motions(stubs)[-1].phase in (
            motion_pb2.MOTION_PHASE_SUCCEEDED,
            motion_pb2.MOTION_PHASE_CANCELLED,
        )

    until(over)
    expect(page.get_by_title("End the program")).to_be_disabled()
    return motions(stubs)[-1]


def test_a_person_teaches_and_plays_a_program(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, tmp_path: Path
) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        arm = client.load_robot(IIWA, name="iiwa")
        arm.set_positions(HERE)
        before = len(motions(stepped))  # of other tests
        client.signals.create("part")
        with opened(browser, console.url + PLAIN) as page:
            row(page, "iiwa").click()
            page.get_by_role("tab", name="Program").click()

            # Two places, a wait and a signal; the second move becomes a line, at a tenth of the speed.
            teach = page.get_by_title("A target here, reached with all joints together")
            teach.click()
            until(lambda: "P1" in scene(stepped))
            arm.set_positions(THERE)
            there = arm.tcp
            # The page has been told when its pendant shows it: 0.4 rad are 22.9°.
            expect(page.get_by_label("J1 lbr_iiwa_joint_1 position", exact=True)).to_have_value("22.9")
            teach.click()
            until(lambda: "P2" in scene(stepped))
            step_row(page, 2).get_by_role("button", name="PTP", exact=True).click()
            expect(step_row(page, 2)).to_contain_text("LIN")
            speed = step_row(page, 2).get_by_label("Speed", exact=True)
            speed.fill("10")
            speed.press("Enter")
            page.get_by_label("Add a step").select_option(label="Wait for a time")
            page.get_by_label("Add a step").select_option(label="Set part")
            step_row(page, 4).get_by_role("radio", name="on", exact=True).click()

            # What is saved is a program file of the project, which other clients read.
            with page.expect_download() as saved:
                page.locator("#save-program").click()
            file = tmp_path / saved.value.suggested_filename
            saved.value.save_as(file)
            request = motion_pb2.ReadProgramRequest(text=file.read_text(), uri=file.name)
            steps = stepped.motion.ReadProgram(request).spec.steps
            assert [one.WhichOneof("step") for one in steps] == ["move", "move", "dwell", "set_signal"]
            assert steps[1].move.moves[0].linear.goal.reference == "P2"
            assert steps[1].move.moves[0].speed_factor == pytest.approx(0.1)
            assert steps[3].set_signal.value.boolean

            # Played from the first step: the step that runs is lit, and at the end the arm is where it was taught.
            page.locator("#play").click()

            def is_lit(number: int) -> bool:
                step(stepped, 20)
                return step_row(page, number).get_attribute("aria-current") == "step"

            for number in (1, 2, 3):
                until(lambda number=number: is_lit(number))
            assert ended(page, stepped, before + 1).phase == motion_pb2.MOTION_PHASE_SUCCEEDED
            assert client.signals["part"] is True
            # A line keeps no posture: the elbow of this arm is free.
            np.testing.assert_allclose(arm.tcp, there, atol=1e-3)

            # Two steps back are no motion, for waits and signals have no way back; the third leads to the first place.
            for _ in range(3):
                page.get_by_title("One step back").click()
            ended(page, stepped, before + 2)
            np.testing.assert_allclose(state(stepped, "iiwa").positions, HERE, atol=1e-3)
            expect(step_row(page, 2)).to_have_class(re.compile(r"\bnext\b"))

            # One step forward, ended on its way.
            page.get_by_title("One step", exact=True).click()
            until(lambda: is_lit(2))
            page.get_by_title("End the program").click()
            motion = ended(page, stepped, before + 3)
            assert (motion.phase, motion.end_cause) == (motion_pb2.MOTION_PHASE_CANCELLED, motion_pb2.END_CAUSE_CALL)

            # A file in place of it, and one that is none: the kernel's words, and the steps stay.
            page.get_by_title("Drop all steps").click()
            expect(page.get_by_text("Bring the robot somewhere")).to_be_visible()
            page.set_input_files("#open-program", file)
            expect(page.get_by_label("Steps", exact=True).get_by_role("listitem")).to_have_count(4)
            broken = tmp_path / "broken.yaml"
            broken.write_text(file.read_text().replace("dwell", "dwel"))
            page.set_input_files("#open-program", broken)
            said = page.get_by_role("alert")
            expect(said).to_contain_text("broken.yaml")
            expect(said).to_contain_text("dwell")
            said.get_by_title("Close").click()
            expect(page.get_by_label("Steps", exact=True).get_by_role("listitem")).to_have_count(4)

            # A target that is gone: the step is named, and nothing moves.
            client.scene.remove("P2")
            page.locator("#play").click()
            expect(page.locator("#last")).to_contain_text("step 2: ")
            expect(page.locator("#last")).to_contain_text("P2")
            assert len(motions(stepped)) == before + 3
