"""A person teaches a pick and a place with lines there and away at the console's page, and plays them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import expect
from virtualrobot.v1 import motion_pb2

from tests.api.asking import IIWA
from tests.api.reading import scene
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.apps.console.test_program_page import ended, motions, step_row
from tests.kernels import KernelProcess, Stubs

pytestmark = [*needs_page, pytest.mark.long]

HERE = (0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0)
THERE = (0.4, 0.6, 0.0, -1.0, 0.0, 0.9, 0.0)
HOME = (0.0, 0.3, 0.0, -1.5, 0.0, 0.6, 0.0)


def test_a_person_teaches_a_pick_and_a_place(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, tmp_path: Path
) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        before = len(motions(stepped))  # of other tests
        arm = client.load_robot(IIWA, name="iiwa")
        arm.postures.add("home", HOME)
        states = {"off": {}, "on": {}}
        client.scene.add_tool("cup", arm.flange, tool_center_points={"tip": virtualrobot.pose(z=0.1)}, states=states)
        client.scene.add_object("table", virtualrobot.box(0.4, 0.4, 0.02), pose=virtualrobot.pose(y=-1.0))
        arm.set_positions(THERE)
        there = arm.tcp
        arm.set_positions(HERE)
        here = arm.tcp
        client.scene.add_part("brick", virtualrobot.box(0.05, 0.05, 0.05), pose=here @ virtualrobot.pose(z=0.05))
        with opened(browser, console.url + PLAIN, 1280, 720) as page:
            row(page, "iiwa").click()

            page.get_by_role("tab", name="Program").click()
            add = page.get_by_label("Add a step")
            add.select_option(label="Pick here, with approach")
            expect(step_row(page, 1)).to_contain_text("Pick")
            part = step_row(page, 1).get_by_label("Part that is picked")
            expect(part).to_have_attribute("placeholder", "the nearest part")
            lines = step_row(page, 1).get_by_label("Length of the lines there and away")
            expect(lines).to_have_value("100")
            lines.fill("80")
            lines.press("Enter")
            arm.set_positions(THERE)
            expect(page.get_by_label("J1 lbr_iiwa_joint_1 position", exact=True)).to_have_value("22.9")
            add.select_option(label="Place here on world, with approach")
            on = step_row(page, 2).get_by_label("What it is placed on")
            expect(on).to_have_value("world")
            on.fill("table")
            on.press("Enter")
            add.select_option(label="Go to home")
            expect(step_row(page, 3)).to_contain_text("home")

            # The file has them as programs of other clients do: the tool comes open, holds, and lets go.
            with page.expect_download() as saved:
                page.locator("#save-program").click()
            file = tmp_path / saved.value.suggested_filename
            saved.value.save_as(file)
            request = motion_pb2.ReadProgramRequest(text=file.read_text(), uri=file.name)
            pick, place, home = stepped.motion.ReadProgram(request).spec.steps
            assert (pick.pick_at.goal.reference, pick.pick_at.state_before, pick.pick_at.state) == ("P1", "off", "on")
            assert pick.pick_at.approach_meters == pick.pick_at.retreat_meters == pytest.approx(0.08)
            assert (place.place_at.goal.reference, place.place_at.state) == ("P2", "off")
            assert place.place_at.parent == "table"
            assert home.move.moves[0].point_to_point.posture == "home"

            # Played: the brick is where the arm was taught, in the tool as it was picked, and the arm is at home.
            page.locator("#play").click()
            assert ended(page, stepped, before + 1).phase == motion_pb2.MOTION_PHASE_SUCCEEDED
            np.testing.assert_allclose(arm.positions, HOME, atol=1e-6)
            assert client.scene.node("brick").parent == "table"
            assert arm.state.tool_states["cup"] == "off"
            np.testing.assert_allclose(scene(stepped)["brick"], there @ virtualrobot.pose(z=0.05), atol=1e-3)

            # A part that is gone: the step is named, and nothing moves.
            part.fill("brick")
            part.press("Enter")
            client.scene.remove("brick")
            page.locator("#play").click()
            expect(page.locator("#last")).to_contain_text("brick")
            expect(page.get_by_title("End the program")).to_be_disabled()
            np.testing.assert_allclose(arm.positions, HOME, atol=1e-6)
