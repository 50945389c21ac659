"""A person says at the console's page what a node is for, and finds it by that."""

from __future__ import annotations

import pytest
import virtualrobot
from playwright.sync_api import expect

from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]


def test_a_node_is_described_and_found(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        bench = client.scene.add_object("bench", virtualrobot.box(0.3, 0.3, 0.3))
        client.scene.add_object("post", virtualrobot.box(0.1, 0.1, 1.0))
        with opened(browser, console.url + PLAIN, 1280, 720) as page:
            row(page, "bench").click()
            page.get_by_role("tab", name="Properties").click()
            about = page.get_by_label("About it")
            for label, text in (
                ("Description", "Where boxes wait"),
                ("Tags", "fixture, station 2, fixture"),
                ("Icon", "package"),
            ):
                about.get_by_label(label).fill(text)
                about.get_by_label(label).press("Enter")
            until(lambda: (bench.description, bench.info.icon) == ("Where boxes wait", "package"))
            until(lambda: bench.tags == ("fixture", "station 2"))
            expect(row(page, "bench")).to_have_attribute("title", "bench: Where boxes wait")

            # The tree is filtered by tags and descriptions as by names.
            find = page.get_by_label("Filter scene")
            for words in ("STATION", "boxes"):
                find.fill(words)
                expect(row(page, "bench")).to_be_visible()
                expect(row(page, "post")).to_have_count(0)
            find.fill("")
            about.get_by_role("switch", name="Locked").click()
            until(lambda: bench.locked)
            about.get_by_role("switch", name="Locked").click()
            until(lambda: not bench.locked)

            # What others say is there at once.
            bench.description = "Of oak"
            expect(about.get_by_label("Description")).to_have_value("Of oak")
