"""A person looks after collisions at the console's page: what touches, how near things are, modes, what may touch."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import virtualrobot
from playwright.sync_api import expect
from virtualrobot.v1 import motion_pb2

from tests.api.moving import motion
from tests.api.reading import step
from tests.apps.console.browsing import PLAIN, browsers, color_count, needs_page, opened
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

SLIDER = """<robot name="slider">
  <link name="base"/>
  <link name="carriage">
    <visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual>
    <collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>
  </link>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="carriage"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" velocity="0.5" effort="1"/></joint>
</robot>"""
"""A cube of 0.1 m that goes along x: where it is at q, its face is 0.85 - q (m) from a cube of 0.2 m at x = 1."""

MARKED = (0xFF, 0x2E, 0x63)


def test_a_person_looks_after_collisions(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, tmp_path: Path
) -> None:
    (tmp_path / "slider.urdf").write_text(SLIDER, "utf-8")
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        slider = client.load_robot(str(tmp_path / "slider.urdf"), name="slider")
        slider.set_positions([0.25])
        client.scene.add_object("block", virtualrobot.box(0.2, 0.2, 0.2), pose=virtualrobot.pose(x=1.0))
        with opened(browser, console.url + PLAIN, 1280, 720) as page:
            page.get_by_role("tab", name="Collisions").click()
            expect(page.get_by_text("Nothing touches that may not.")).to_be_visible()
            expect(page.get_by_text("Every robot's mode is off")).to_be_visible()
            about = page.get_by_role("group", name="About collisions")
            said = page.locator("#last")

            def show(part: str) -> None:
                about.get_by_role("radio", name=part, exact=True).click()

            # Distances, which go along with the robot; a name that there is not; the nearest pair alone.
            show("Distances")
            expect(about.get_by_label("Measured from")).to_have_value("slider")
            near = page.get_by_role("list", name="Distances")
            expect(near).to_contain_text("Nothing is so near.")
            expect(about.get_by_label("Farthest pairs")).to_be_in_viewport(ratio=1.0)
            reach = about.get_by_label("Farthest pairs")
            reach.fill("0,7")
            reach.press("Enter")
            expect(reach).to_have_value("1")
            reach.fill("700")
            reach.press("Enter")
            pair = near.get_by_role("listitem", name="slider.carriage and block")
            expect(pair).to_contain_text("600.0 mm")
            slider.set_positions([0.45])
            expect(pair).to_contain_text("400.0 mm")
            other = about.get_by_label("Measured to")
            other.fill("blok")
            other.press("Enter")
            expect(near.get_by_role("alert")).to_contain_text("blok")
            other.fill("block")
            other.press("Enter")
            expect(pair).to_contain_text("400.0 mm")
            reach.fill("0")
            reach.press("Enter")
            expect(near.get_by_role("listitem")).to_have_count(1)

            # A pair that is chosen, by key, is marked in the view, both of it, and no more when it is chosen again.
            pair.get_by_title("Look at slider.carriage and block").press("Enter")
            assert color_count(page, MARKED) == 0
            button = pair.get_by_title("Mark both in the view")
            button.press("Enter")
            expect(button).to_have_attribute("aria-pressed", "true")
            until(lambda: color_count(page, MARKED) > 100)
            button.press("Enter")
            until(lambda: color_count(page, MARKED) == 0)

            # What is done: told for all, this robot is stopped; a look-ahead out of range changes nothing.
            show("Modes")
            page.get_by_role("radiogroup", name="Mode of all robots").get_by_role("radio", name="monitor").click()
            until(lambda: client.collisions.settings.mode == "monitor")
            page.get_by_role("radiogroup", name="Mode of slider").get_by_role("radio", name="stop").click()
            until(lambda: client.collisions.settings.robots == {"slider": "stop"})
            ahead = page.get_by_label("How far ahead running motions are checked")
            expect(ahead).to_have_value("1.0")  # what the first robot that is to be stopped makes it
            ahead.fill("99")
            ahead.press("Enter")
            expect(said).to_contain_text("60")
            assert client.collisions.settings.look_ahead == 1.0
            ahead.fill("0")
            ahead.press("Enter")
            until(lambda: client.collisions.settings.look_ahead == 0.0)

            # It runs into the block and is stopped: told with its time, and how deep as long as it touches.
            began = slider.move_joints([0.9], speed_factor=0.5, wait=False, on_disconnect="continue")

            def over() -> bool:
                step(stepped, 20)
                return motion(stepped, began.id).phase == motion_pb2.MOTION_PHASE_ABORTED

            until(over)
            assert motion(stepped, began.id).end_cause == motion_pb2.END_CAUSE_COLLISION
            (touching,) = next(client.collisions.watch()).touching
            show("Events")
            events = page.get_by_role("list", name="What began and ended").get_by_role("listitem")
            expect(events.nth(0)).to_contain_text("slider stopped: ")
            expect(events.nth(1)).to_contain_text("began to touch")
            expect(events.nth(1)).to_contain_text(f"{touching.simulation_time:.3f} s")
            slider.set_positions([0.9])
            show("Now")
            now = page.get_by_role("list", name="What touches now").get_by_role("listitem")
            expect(now).to_contain_text(re.compile(r"(?<!\d)50\.0 mm deep"))
            expect(now).to_contain_text(f"since {touching.simulation_time:.2f} s")

            until(lambda: color_count(page, MARKED) > 100)  # without being chosen

            # Let them touch, with the reason; and no more.
            now.get_by_role("button", name="Allow").click()
            expect(page.get_by_label("Reason", exact=True)).to_be_focused()
            expect(page.get_by_role("button", name="Allow", exact=True)).to_be_in_viewport(ratio=1.0)
            page.keyboard.type("it shall push")
            page.keyboard.press("Enter")
            rows = page.get_by_role("list", name="Pairs that may touch").get_by_role("listitem")
            expect(rows).to_contain_text("it shall push")
            (pushed,) = client.collisions.allowed.list("block")
            assert (pushed.cause, pushed.reason) == ("client", "it shall push")
            assert {pushed.first, pushed.second} == {"slider.carriage", "block"}
            show("Now")
            expect(page.get_by_text("Nothing touches that may not.")).to_be_visible()
            until(lambda: color_count(page, MARKED) == 0)
            show("Events")
            expect(events.nth(0)).to_contain_text("is watched no more with")

            # A node that there is not, in the kernel's words; what is so by rule can't be taken back.
            show("Allowed")
            page.get_by_label("First node", exact=True).fill("blok")
            page.get_by_label("Second node", exact=True).fill("block")
            page.get_by_role("button", name="Allow", exact=True).click()
            expect(said).to_contain_text("blok")
            assert len(client.collisions.allowed.list("block")) == 1
            page.get_by_role("button", name="by rule, too").click()
            expect(rows).to_have_count(len(client.collisions.allowed.list()))
            page.get_by_label("Filter pairs").fill("push")
            expect(rows).to_have_count(1)
            rows.get_by_title("touch no more").click()
            until(lambda: client.collisions.allowed.list("block") == [])
            show("Now")
            expect(now).to_contain_text("50.0 mm deep")
