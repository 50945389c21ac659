"""The panel of proposals: an observer looks, an operator changes, rejects, and approves by holding; each sees it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Browser, Page, expect
from virtualrobot import Client, Phase

from tests.api.asking import IIWA
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console, consoles
from tests.kernels import StartKernel
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

HOLD = "#hold-proposal"


@contextmanager
def page_of(browser: Browser, console: Console, client: Client, role: str) -> Iterator[Page]:
    """Give the panel at the page of somebody with a role."""
    token = client.tokens.create(role, role).secret
    link = console.ask("/link", authorization=f"Bearer {token}").json["url"]
    with opened(browser, console.url + PLAIN, link=link) as page:
        page.get_by_role("tab", name="Proposals").click()
        yield page


def test_who_looks_changes_rejects_and_approves(start_kernel: StartKernel) -> None:
    kernel = start_kernel("--stepped", token=True)
    with (
        virtualrobot.connect(kernel.address, kernel.token) as client,
        consoles(kernel.address, token=kernel.token) as console,
        browsers() as browser,
        page_of(browser, console, client, "operator") as page,
    ):
        arm = client.load_robot(IIWA, name="arm")
        arm.speed_factor = 0.2
        expect(row(page, "arm")).to_have_count(1)
        proposed = page.get_by_role("listitem", name=re.compile("^Proposal"))
        words = page.get_by_label("What it is for, or why not")

        # Somebody else proposes, which is seen at once; the reason for turning it down is seen there.
        made = client.proposals.create([arm.ptp({"lbr_iiwa_joint_1": 0.6})], title="to the press")
        expect(proposed).to_contain_text(re.compile(r"to the press.*arm.*free, \d"))
        page.get_by_label("Look at to the press").click()
        words.fill("too near to the door")
        page.get_by_role("button", name="Reject", exact=True).click()
        until(lambda: client.proposals.get(made.id).reason == "too near to the door")
        expect(proposed).to_contain_text("rejected: too near to the door")
        expect(page.locator(HOLD)).to_have_attribute("aria-disabled", "true")

        # The operator gives it another goal, and takes that back.
        row(page, "arm").click()
        track = page.get_by_label(re.compile("lbr_iiwa_joint_2, °"))
        box = track.bounding_box()
        assert box
        track.click(position={"x": 0.7 * box["width"], "y": 10})
        page.get_by_role("button", name="Change", exact=True).click()
        until(lambda: client.proposals.get(made.id).undo_count == 1)
        changed = client.proposals.get(made.id)
        assert (changed.state, changed.title) == ("proposed", "to the press")
        assert changed.changed_by.startswith("operator with ")
        page.get_by_label("Take back").click()
        until(lambda: client.proposals.get(made.id).undo_count == 0)

        # An observer sees all of it, and may do nothing.
        with page_of(browser, console, client, "observer") as other:
            seen = other.get_by_role("listitem", name="Proposal to the press")
            expect(seen).to_contain_text(re.compile("free.*operator"))
            other.get_by_label("Look at to the press").click()
            for name in ("Propose", "Change", "Plan anew", "Reject"):
                expect(other.get_by_role("button", name=name, exact=True)).to_be_disabled()
            expect(other.locator(HOLD)).to_have_attribute("aria-disabled", "true")

            # An operator has leased what it moves, and is told so.
            button = page.locator(HOLD)
            expect(button).to_have_attribute("aria-disabled", "false")
            button.click()
            expect(page.get_by_label("Status")).to_contain_text("'arm' is free: press Lease at the pendant")
            page.get_by_role("button", name="Lease", exact=True).click()
            expect(page.get_by_role("button", name="Give back")).to_be_visible()
            expect(other.locator("#pendant")).to_contain_text("operator has leased it")

            # What was shown runs while the operator holds the button, and no further.
            button.hover()
            page.mouse.down()
            until(lambda: runs(client))
            expect(seen).to_contain_text(re.compile(r"approved, \d+ %"))
            page.mouse.up()
            (motion,) = client.motions()

            def stands() -> bool:
                client.clock.step(20)
                return motion.phase is Phase.PAUSED

            until(stands)
            here = arm.positions
            client.clock.step(200)
            np.testing.assert_array_equal(arm.positions, here)
            assert 0.0 < here[0] < 0.6

            # It goes on by a key that is held.
            button.focus()
            page.keyboard.down("Enter")

            def is_done() -> bool:
                client.clock.step(60)
                if motion.phase is Phase.PAUSED:  # a page that is slow for a moment lets go, and for good
                    page.keyboard.up("Enter")
                    page.keyboard.down("Enter")
                return client.proposals.get(made.id).state == "executed"

            until(is_done)
            page.keyboard.up("Enter")
            assert arm.positions[0] == 0.6
            expect(seen).to_contain_text("done")

        # What stands in another cell than it was looked at is refused, with what has changed, and planned anew.
        again = client.proposals.create([arm.ptp({"lbr_iiwa_joint_1": 0.1})])
        page.get_by_label(f"Look at {again.id}").click()
        expect(button).to_have_attribute("aria-disabled", "false")
        page.get_by_role("button", name="Give back").click()
        until(lambda: not client.leases())
        arm.set_positions([0.3] * 7)
        page.get_by_role("button", name="Lease", exact=True).click()
        expect(page.get_by_role("button", name="Give back")).to_be_visible()
        button.click()
        page.get_by_role("tab", name="Messages").click()
        expect(page.locator("#messages")).to_contain_text("another cell than was looked at")
        page.get_by_role("tab", name="Proposals").click()
        page.get_by_role("button", name="Plan anew").click()
        until(lambda: client.proposals.get(again.id).revision == 2)

        # Somebody takes the robot over, and the operator takes it back.
        taken = client.lease("arm", owner="cell 3", take=True)
        expect(page.locator("#pendant")).to_contain_text("cell 3 has leased it")
        page.get_by_role("button", name="Take over").click()
        assert "operator" in taken.wait_for_loss(timeout=60.0)
        page.get_by_role("button", name="Give back").click()
        until(lambda: not client.leases())


def runs(client: Client) -> bool:
    here = client.robot("arm").positions
    client.clock.step(2)
    return bool((client.robot("arm").positions != here).any())
