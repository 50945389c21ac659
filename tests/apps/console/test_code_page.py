"""A person writes a program at the console's page, and debugs it; one page and one kernel for all of it."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import pytest
import virtualrobot
from PIL import Image
from playwright.sync_api import Locator, Page, expect
from websockets.sync.client import connect

from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, emptied
from tests.waiting import PATIENCE_SECONDS, repeated, until

pytestmark = [*needs_page, pytest.mark.long]

SUMS = r"""MODULE Sums
  VAR num total := 0;
  PROC main()
    VAR num key;
    FOR i FROM 1 TO 3 DO
      add i;
    ENDFOR
    TPReadFK key, "total?", "Keep", "", "Drop", "", "";
    TPWrite "key" \Num:=key;
  ENDPROC
  ! Adds to the total.
  PROC add(num x)
    total := total + x;
  ENDPROC
ENDMODULE
"""
MOVES = r"""MODULE Moves
  CONST jointtarget low := [[0,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST jointtarget high := [[60,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR num rounds;
  PROC main()
    WHILE TRUE DO
      MoveAbsJ high, v100, fine, tool0;
      MoveAbsJ low, v100, fine, tool0;
      rounds := rounds + 1;
    ENDWHILE
  ENDPROC
ENDMODULE
"""


@dataclass
class Desk:
    """A person at the page."""

    page: Page
    client: virtualrobot.Client
    console: Console

    def part(self, name: str) -> Locator:
        """Return a part of the panel."""
        return self.page.get_by_role("region", name=name, exact=True)

    @property
    def text(self) -> Locator:
        """The editor."""
        return self.page.get_by_label("Program's text")

    def lines(self, kind: str) -> list[str]:
        """Return the lines that are lit so."""
        return self.page.locator(f".cm-{kind}").all_inner_texts()

    def write(self, text: str, file: str = "main.mod") -> None:
        """Have a file opened."""
        self.page.set_input_files("#open-code", {"name": file, "mimeType": "text/plain", "buffer": text.encode()})
        expect(self.page.get_by_label("File of the program")).to_have_value(file)
        expect(self.text).to_contain_text(text.splitlines()[0])

    def robot(self, name: str) -> None:
        """Choose what is moved; "" is nothing."""
        self.page.get_by_label("Robot that it moves").select_option(name)

    def stop_at(self, text: str, breakpoint: int, line: str) -> None:
        """Run a program without a robot until its breakpoint, which is in a line, or before it."""
        self.write(text)
        self.robot("")
        self.breakpoint(breakpoint)
        self.page.locator("#run-code").click()
        self.stands_at(line)

    def press(self, title: str) -> None:
        """Press a button of the bar."""
        self.page.get_by_title(re.compile(f"^{title}")).click()

    def stands_at(self, line: str) -> None:
        """Wait until the program stands before a line."""
        until(lambda: self.lines("stands") == [line])

    def says(self, words: str) -> None:
        """Wait until words are in the output."""
        expect(self.part("Output")).to_contain_text(words)

    def blue(self) -> int:
        """Return how many pixels of the view are as blue as what is planned."""
        shown = Image.open(io.BytesIO(self.page.locator(".view .canvas canvas").screenshot())).convert("RGB")
        red, _, blue = np.moveaxis(np.asarray(shown, int), 2, 0)
        return int(np.count_nonzero(blue > red + 70))

    def beside(self, line: int) -> Locator:
        """Return the place of a line's breakpoint, from 1."""
        return self.page.locator(".cm-breakpoints .cm-gutterElement").nth(line)

    def breakpoint(self, line: int) -> None:
        """Click beside a line, from 1."""
        self.beside(line).click()


@pytest.fixture(scope="module")
def desk(stepped_kernel: KernelProcess, console_of: Callable[[str], Console]) -> Iterator[Desk]:
    console = console_of(stepped_kernel.address)
    with emptied(stepped_kernel), virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        client.load_robot("model://irb120", name="arm")
        with opened(browser, console.url + PLAIN) as page:
            page.get_by_role("tab", name="Code").click()
            yield Desk(page, client, console)


def test_faults_are_told_as_the_text_is_written(desk: Desk) -> None:
    desk.write(SUMS)
    desk.robot("")
    expect(desk.page.locator("#first-fault")).to_have_count(0)
    desk.text.get_by_text("add i;").click()
    desk.page.keyboard.press("End")
    desk.page.keyboard.press("Backspace")
    expect(desk.page.locator("#first-fault")).to_contain_text("line 6: ';' is missing here")
    expect(desk.page.locator(".cm-lint-marker-error")).to_have_count(1)
    # A program that can't be read does not begin: the same words.
    desk.page.locator("#run-code").click()
    desk.says("main.mod:6:")
    desk.text.get_by_text("add i").click()
    desk.page.keyboard.press("End")
    desk.page.keyboard.type(";")
    expect(desk.page.locator("#first-fault")).to_have_count(0)
    # What a word means, and which there are.
    desk.text.get_by_text("add i").hover(position={"x": 60.0, "y": 8.0})
    expect(desk.page.locator(".cm-told")).to_contain_text("Adds to the total.")
    desk.page.keyboard.press("Enter")
    desk.page.keyboard.type("tot")
    # By the pointer: Enter within 75 ms of their coming is a new line.
    desk.page.locator(".cm-tooltip-autocomplete li").filter(has_text="total").first.click()
    desk.page.keyboard.type(":=total;")
    expect(desk.text).to_contain_text("total:=total;")
    desk.press("Lay the text out")
    expect(desk.text).to_contain_text("total := total;")


def test_a_program_is_debugged_and_answered(desk: Desk) -> None:
    desk.stop_at(SUMS, 6, "      add i;")
    expect(desk.part("Routine")).to_contain_text("i")
    desk.press("Into")
    desk.stands_at("    total := total + x;")
    assert [one.strip() for one in desk.part("Call stack").locator(".entry").all_inner_texts()] == [
        "add\n13",
        "main\n6",
    ]
    value = desk.part("Module Sums").get_by_label("Value of total")
    value.fill("10 * 2")
    value.press("Enter")
    expect(value).to_have_value("20")
    desk.press("Out")
    desk.stands_at("    FOR i FROM 1 TO 3 DO")
    desk.breakpoint(6)
    desk.page.get_by_role("button", name="Go on", exact=True).click()
    asked = desk.page.get_by_label("The program asks")
    expect(asked).to_contain_text("total?")
    assert asked.get_by_role("button").all_inner_texts() == ["Keep", "Drop"]
    until(lambda: desk.lines("runs") == ['    TPReadFK key, "total?", "Keep", "", "Drop", "", "";'])
    asked.get_by_role("button", name="Drop").click()
    desk.says("key3")
    expect(desk.page.locator("#run-code")).to_be_visible()
    assert desk.lines("runs") == desk.lines("stands") == []


def test_a_breakpoint_goes_to_the_next_statement(desk: Desk) -> None:
    desk.stop_at(SUMS, 3, "    FOR i FROM 1 TO 3 DO")
    expect(desk.beside(5).locator(".cm-breakpoint")).to_be_visible()
    expect(desk.beside(3).locator(".cm-breakpoint")).to_have_count(0)
    desk.press("End")
    expect(desk.page.locator("#run-code")).to_be_visible()


def test_a_script_moves_the_robot_that_is_chosen(desk: Desk) -> None:
    """A kernel whose time stands still refuses it, since a controller's goes on; an arm of its own moves."""
    desk.write('def there():\n  movej([0, -1.4, 1.4, -1.5, -1.4, 0.1])\n  textmsg("there")\nend\n', "there.script")
    desk.robot("arm")
    desk.page.locator("#run-code").click()
    desk.says("time stands still, and nothing would move")
    desk.robot("")
    desk.page.locator("#run-code").click()
    desk.says("there")


def test_a_robot_is_followed_and_stops_with_the_page(desk: Desk) -> None:
    desk.write(MOVES)
    desk.robot("arm")
    arm = desk.client.robot("arm")
    desk.page.mouse.move(500.0, 250.0)
    desk.page.mouse.wheel(0.0, 1500.0)  # from farther away: all of the robot is in the view
    plain = desk.blue()
    with repeated(lambda: desk.client.clock.step(4)):
        desk.page.locator("#run-code").click()
        until(lambda: "high" in "".join(desk.lines("motion")))
        # The way of the tool that is planned is drawn, and where it ends.
        until(lambda: desk.blue() > plain + 20)
        until(lambda: "low" in "".join(desk.lines("motion")))
        # Another page can't have the same robot meanwhile: its program ends by the kernel's words.
        with connect(f"{desk.console.url.replace('http', 'ws')}/editor") as other:
            launch = {"program": "moves.mod", "texts": {"moves.mod": MOVES}, "robot": "arm"}
            for number, (command, given) in enumerate(
                (("initialize", {}), ("launch", launch), ("configurationDone", {})), 1
            ):
                request = {"type": "request", "seq": number, "command": command, "arguments": given}
                other.send(json.dumps({"dap": request}))
            told = ""
            while '"exited"' not in told:
                told = str(other.recv(PATIENCE_SECONDS))
                if '"stderr"' in told:
                    assert "moves.mod:7" in told and "arm" in told
            assert '"exitCode":1' in told
        assert arm.state.motion_ids
        desk.page.reload()
        until(lambda: not arm.state.motion_ids)
        assert desk.client.motions() == []
