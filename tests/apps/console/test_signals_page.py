"""A person makes signals, sets them, and connects them at the console's page; the kernel is asked each time."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import virtualrobot
from playwright.sync_api import Locator, Page, expect
from virtualrobot_apps.connections.file import read_connections

from tests.api.asking import IIWA
from tests.api.reading import step
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened
from tests.apps.console.consoles import consoles
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

ON_SECONDS = 0.5


def part(page: Page, name: str) -> None:
    page.get_by_role("radiogroup", name="Part").get_by_role("radio", name=name, exact=True).click()


def make(page: Page, name: str, kind: str = "boolean") -> None:
    page.get_by_label("Type of the new signal").select_option(kind)
    page.get_by_label("Name of the new signal").fill(name)
    page.get_by_label("Name of the new signal").press("Enter")
    expect(page.get_by_label(f"Signal {name}", exact=True)).to_be_visible()


def connect(page: Page, target: str, logic: str, *inputs: str, seconds: str = "") -> None:
    """Write a connection into the fields, and run it."""
    page.get_by_label("Signal to drive").select_option(target)
    page.get_by_label("Logic").select_option(label=logic)
    for place, words in enumerate(inputs):
        page.get_by_label(re.compile("^Input ")).nth(place).fill(words)
    if seconds:
        page.get_by_label("seconds", exact=True).fill(seconds)
    page.get_by_role("button", name="Connect", exact=True).click()


def connection(page: Page, target: str) -> Locator:
    """Return the row of what drives a signal."""
    return page.get_by_label(f"Connection of {target}", exact=True)


def test_a_person_wires_signals(stepped: Stubs, stepped_kernel: KernelProcess, tmp_path: Path) -> None:
    with (
        virtualrobot.connect(stepped_kernel.address) as client,
        consoles(stepped_kernel.address) as console,
        browsers() as browser,
        opened(browser, console.url + PLAIN, 1280, 720) as page,
    ):
        page.get_by_role("tab", name="Signals").click()
        for name in ("start", "motor", "lamp"):
            make(page, name)
        make(page, "parts", "integer")
        make(page, "speed", "number")
        make(page, "recipe", "text")

        # By hand: a number with a comma, a text, a switch; what is no number changes nothing.
        for label, words in (("speed", "0,25"), ("recipe", "box 7"), ("parts", "three")):
            field = page.get_by_label(label, exact=True)
            field.fill(words)
            field.press("Enter")
        until(lambda: client.signals["recipe"] == "box 7")
        page.get_by_role("switch", name="lamp").click()
        until(lambda: client.signals["lamp"] is True)
        assert (client.signals["speed"], client.signals["parts"]) == (0.25, 0)

        # A delay of ten ticks, an AND with a negation of what it drives, and a counter.
        part(page, "Connections")
        connect(page, "motor", "delay on", "start", seconds="0,04")
        expect(connection(page, "motor")).to_contain_text("delay on 0.04 s (start)")
        connect(page, "lamp", "and", "start", "not motor")
        expect(connection(page, "lamp")).to_contain_text("and (start, not (motor))")
        until(lambda: client.signals["lamp"] is False)
        connect(page, "parts", "count", "start")
        expect(connection(page, "parts")).to_contain_text("count")
        client.signals["start"] = True
        until(lambda: client.signals["lamp"] is True)
        assert client.signals["motor"] is False
        step(stepped, 11)
        until(lambda: client.signals["motor"] is True and client.signals["lamp"] is False)
        assert client.signals["parts"] == 1
        expect(connection(page, "motor").get_by_role("switch")).to_have_attribute("aria-checked", "true")

        # What is wrong is told in words, and all goes on as it was.
        said = page.locator("#last")
        for target, logic, inputs, seconds, words in (
            ("start", "is", ["motor"], "", "a loop: "),
            ("lamp", "and", ["start", "speed"], "", "'speed' is number, and boolean is wanted"),
            ("lamp", "and", ["start", "moter"], "", "did you mean 'motor'?"),
            ("lamp", "pulse", ["start"], "a while", "needs a time in seconds"),
            ("lamp", "pulse", ["start"], "-1", "from 0 to 86400"),
        ):
            connect(page, target, logic, *inputs, seconds=seconds)
            expect(said).to_contain_text(words)
        expect(page.get_by_label("Connections", exact=True).get_by_role("listitem")).to_have_count(3)
        expect(page.locator("#connections-state")).to_have_text("running")

        # What is saved is a file of `virtualrobot connections`; one that is wrong is named by its line.
        with page.expect_download() as saved:
            page.locator("#save-connections").click()
        file = tmp_path / saved.value.suggested_filename
        saved.value.save_as(file)
        assert set(read_connections(file).driven()) == {"motor", "lamp", "parts"}
        broken = tmp_path / "broken.yaml"
        broken.write_text(file.read_text().replace("delay_on", "delay_no"))
        page.set_input_files("#open-connections", broken)
        line = 1 + broken.read_text()[: broken.read_text().index("delay_no")].count("\n")
        expect(said).to_contain_text(re.compile(rf"broken\.yaml:{line + 1}|broken\.yaml:{line}"))
        expect(said).to_contain_text("did you mean 'delay_on'?")

        # One that is removed drives nothing any more; the others go on.
        connection(page, "motor").get_by_title(re.compile("^Remove")).click()
        expect(connection(page, "motor")).to_have_count(0)
        client.signals["start"] = False
        until(lambda: client.signals["lamp"] is False)
        assert client.signals["motor"] is True

        # A signal that is gone ends them, which is told; without it they can be run again.
        del client.signals["parts"]
        expect(page.get_by_role("alert")).to_contain_text("'parts'")
        expect(page.locator("#connections-state")).to_have_text("at rest")
        connection(page, "parts").get_by_title(re.compile("^Remove")).click()
        expect(page.locator("#connections-state")).to_have_text("running")

        # The diagram tells how long a signal was on: 125 ticks.
        part(page, "Timing")
        client.signals["start"] = True
        step(stepped, round(ON_SECONDS / 0.004))
        client.signals["start"] = False
        expect(page.get_by_label("Timing of start")).to_contain_text(f"{ON_SECONDS:.3f} s")


def test_connections_outlive_their_page_and_end_with_the_console(stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.signals.create("eye")
        client.signals.create("run")
        with consoles(stepped_kernel.address) as console, browsers() as browser:
            with opened(browser, console.url + PLAIN) as page:
                page.get_by_role("tab", name="Signals").click()
                part(page, "Connections")
                connect(page, "run", "not", "eye")
                until(lambda: client.signals["run"] is True)
            client.signals["eye"] = True
            until(lambda: client.signals["run"] is False)
            with opened(browser, console.url + PLAIN) as page:
                page.get_by_role("tab", name="Signals").click()
                part(page, "Connections")
                expect(connection(page, "run")).to_contain_text("not (eye)")
        client.signals["eye"] = False
        step(stepped, 10)
        assert client.signals["run"] is False


def test_the_pendant_has_the_signals_of_its_robot_first(stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with (
        virtualrobot.connect(stepped_kernel.address) as client,
        consoles(stepped_kernel.address) as console,
        browsers() as browser,
    ):
        client.load_robot(IIWA, name="arm")
        for number in range(7):
            client.signals.create(f"lamp {number}")
        client.signals.create("pressure", 1.5, unit="bar", owner="arm")
        with opened(browser, console.url + PLAIN, 1280, 720) as page:
            panel = page.locator("#pendant").get_by_label("Signals of the cell")
            rows = panel.get_by_role("group", name="I/O")
            expect(rows).to_have_count(6)
            expect(rows.first).to_contain_text("pressure")
            panel.get_by_role("button", name="2 more").click()
            expect(rows).to_have_count(8)
            panel.get_by_role("switch", name="lamp 6").click()
            until(lambda: client.signals["lamp 6"] is True)
            field = panel.get_by_label("pressure", exact=True)
            field.fill("2,5")
            field.press("Enter")
            until(lambda: client.signals["pressure"] == 2.5)
