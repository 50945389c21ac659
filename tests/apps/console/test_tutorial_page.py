"""The tutorial docs/tutorial-first-cell-in-the-page.md, done by a person at the console's page, step by step.

What is bold there is pressed and what is code is written, section by section, in this order and no other.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Locator, Page, expect
from virtualrobot import Client

from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytest.importorskip("av", reason="the package for films is not installed")

pytestmark = [*needs_page, pytest.mark.long]

TUTORIAL = Path(__file__).parents[3] / "docs" / "tutorial-first-cell-in-the-page.md"
LOOKS, LOOK_MS = 40, 50.0
"""Number of looks, and milliseconds between them, of a person who holds a button until the robot is where it goes."""

UNTOLD = {"Begin", "Where to go on"}
"""Sections in which nothing is done in the page."""


def told() -> dict[str, list[str]]:
    """Return what each section of the tutorial says to press and to write, in order."""
    parts = re.split(r"^## (.+)$", TUTORIAL.read_text("utf-8"), flags=re.MULTILINE)
    steps = re.compile(r"\*\*(.+?)\*\*|`(.+?)`")
    sections = dict(zip(parts[1::2], parts[2::2], strict=True))
    return {name: [a or b for a, b in steps.findall(text)] for name, text in sections.items() if name not in UNTOLD}


class Person:
    """A person who does what the tutorial says; what was done is remembered in the tutorial's words."""

    def __init__(self, page: Page, client: Client) -> None:
        """Sit down at a page; the client sees what becomes of it."""
        self.page = page
        self.client = client
        self.done: list[str] = []

    def press(self, words: str, there: Locator | None = None) -> None:
        self.done.append(words)
        (there or self.page.get_by_role("button", name=words, exact=True)).click()

    def tab(self, words: str) -> None:
        self.press(words, self.page.get_by_role("tab", name=words))

    def node(self, name: str) -> None:
        self.press(name, row(self.page, name))

    def key(self, key: str) -> None:
        self.done.append(key)
        self.page.keyboard.press(key)

    def write(self, text: str, label: str, within: str = "main, aside") -> None:
        """Write into a field, and leave it by Tab; a number is taken when the field says it."""
        self.done.append(text)
        field = self.page.locator(within).get_by_label(label, exact=True)
        field.fill(text)
        field.press("Tab")
        number = re.fullmatch(r"-?\d+", text)
        expect(field).to_have_value(re.compile(rf"{text}(\.0+)?" if number else text))

    def hold(self, words: str, label: str, is_so: Callable[[], object]) -> None:
        """Hold a jog's button until something is so; press it again where a late page has stopped the robot."""
        self.done.append(words)
        self.page.get_by_label(label, exact=True).hover()

        def pressed() -> object:
            self.page.mouse.down()
            for _ in range(LOOKS):
                if not is_so():
                    self.page.wait_for_timeout(LOOK_MS)
            self.page.mouse.up()
            return is_so()

        until(pressed)

    def choose(self, words: str, option: str) -> None:
        """Choose an option of the program's list of steps."""
        self.done += [words, option]
        self.page.get_by_label("Add a step").select_option(label=option)

    def pose(self, **numbers: str) -> None:
        for label, text in numbers.items():
            self.write(text, label, "#pendant")

    def go(self) -> None:
        self.press("Move to ghost")

    def arrive(self) -> None:
        """Go where the ghost is, and wait until the ghost is gone."""
        self.go()
        expect(self.page.locator("#go")).to_have_count(0)

    @property
    def tool(self) -> np.ndarray:
        return self.client.robot("arm").tcp[:3, 3]


def a_table(person: Person) -> None:
    person.press("Add …")
    person.press("Table", person.page.get_by_role("radio", name="Table"))
    person.write("bench", "Name of the new thing")
    person.write("1400", "Length along x")
    person.write("1400", "Width along y")
    person.write("750", "Height")
    person.press("Add it")
    expect(row(person.page, "bench")).to_be_visible()
    bounds = person.client.scene.bounds("bench")
    assert bounds is not None
    np.testing.assert_allclose(bounds, [[-0.7, -0.7, 0.0], [0.7, 0.7, 0.75]], atol=1e-6)


def an_arm_on_it(person: Person) -> None:
    page, client = person.page, person.client
    person.tab("Library")
    person.write("ur5e", "Filter models")
    person.press("ur5e", page.get_by_label("Place ur5e", exact=True))
    person.write("arm", "Name of the new model")
    page.locator('.view .canvas[aria-busy="false"]').wait_for()
    person.press("the table", page.locator(".view canvas"))
    until(lambda: "arm" in client.scene)
    assert client.scene.pose("arm")[2, 3] == pytest.approx(0.75, abs=1e-6)
    person.tab("Properties")
    for label, text in {"X": "-350", "Y": "0", "Z": "750", "Rz": "180"}.items():
        person.write(text, label, "#properties")
    person.tab("Scene")
    person.done += ["arm", "bench"]
    row(page, "arm").drag_to(row(page, "bench"))
    until(lambda: client.scene.node("arm").parent == "bench")
    np.testing.assert_allclose(client.scene.pose("arm"), virtualrobot.pose(-0.35, 0.0, 0.75, yaw=np.pi), atol=1e-6)


def a_gripper(person: Person) -> None:
    person.tab("Library")
    person.write("vacuum_cup", "Filter models")
    person.press("Mount")
    until(lambda: person.client.robot("arm").tools)
    person.tab("Scene")


def a_part(person: Person) -> None:
    person.press("Add …")
    person.press("Box", person.page.get_by_role("radio", name="Box"))
    thing(person, "block", ("50", "50", "50"), ("200", "350", "750"), part=True)
    np.testing.assert_allclose(person.client.scene.pose("block")[:3, 3], [0.2, 0.35, 0.775])


def thing(person: Person, name: str, size: tuple[str, ...], stands: tuple[str, ...], part: bool = False) -> None:
    person.write(name, "Name of the new thing")
    for text, label in zip(size, ("Length along x", "Width along y", "Height"), strict=True):
        person.write(text, label)
    for text, axis in zip(stands, "XYZ", strict=True):
        person.write(text, f"Stands at {axis}")
    if part:
        person.press("Part", person.page.get_by_role("switch", name="Part"))
    person.press("Add it")
    expect(row(person.page, name)).to_be_visible()


def by_hand(person: Person) -> None:
    arm = person.client.robot("arm")
    person.node("arm")
    person.tab("Properties")
    person.press("home")
    until(lambda: np.allclose(arm.positions, list(arm.postures["home"].values()), atol=1e-3))
    person.press("Look at everything", person.page.get_by_title("Look at everything"))
    person.tab("Pendant")
    turned, height = arm.positions[0], person.tool[2]
    person.hold("J1", "J1 joint_1 plus", lambda: arm.positions[0] > turned + 0.1)
    person.hold("Z", "Z minus", lambda: person.tool[2] < height - 0.03)
    person.tab("Joints")


def five_places(person: Person) -> None:
    page = person.page
    person.tab("Program")

    def taught(name: str, words: str) -> None:
        person.arrive()
        person.press(words, page.get_by_label(f"Teach {words}", exact=True))
        expect(row(page, name)).to_be_visible()

    person.pose(X="200", Y="350", Z="950", Rx="180", Ry="0", Rz="0")
    taught("P1", "PTP")
    person.pose(Z="802")
    taught("P2", "LIN")
    person.choose("Add …", "Pick the nearest part")
    person.pose(Z="950")
    taught("P3", "LIN")
    person.pose(Y="-350")
    taught("P4", "PTP")
    person.pose(Z="802")
    taught("P5", "LIN")
    person.choose("Add …", "Place what is held on world")
    expect(page.get_by_label("Steps", exact=True).get_by_role("listitem")).to_have_count(7)
    np.testing.assert_allclose(person.client.scene.pose("P5")[:3, 3], [0.2, -0.35, 0.802], atol=1e-4)


def play_it(person: Person) -> None:
    play = person.page.locator("#play")

    def at(y: float) -> bool:
        return np.allclose(person.client.scene.pose("block")[:3, 3], [0.2, y, 0.775], atol=2e-3)

    def is_played() -> None:
        person.press("Play", play)
        expect(person.page.locator(".step.lit")).to_have_count(1)
        until(lambda: at(-0.35))
        until(lambda: person.client.scene.node("block").parent == "world")
        expect(person.page.get_by_title("End the program")).to_be_disabled()
        expect(person.page.locator("#last")).to_have_text("the program is done")

    is_played()
    person.press("Play", play)
    expect(person.page.locator("#last")).to_contain_text("step 3: the part 'block' is 7")
    person.press("Back to before Play")
    expect(person.page.locator("#last")).to_have_text("the cell is as it was before Play")
    assert at(-0.35)
    person.page.get_by_role("button", name="Back to before Play").click()
    until(lambda: at(0.35))
    is_played()


def film_it(person: Person) -> None:
    page = person.page
    person.press("Films", page.get_by_title("Films", exact=True))
    panel = page.get_by_label("Films", exact=True)
    person.press("640\u00d7360", panel.get_by_role("radio", name="640\u00d7360"))
    person.press("Film", panel.locator("#film"))
    expect(panel.get_by_role("button", name="Stop")).to_be_visible()
    height = person.tool[2]
    person.hold("Z", "Z plus", lambda: person.tool[2] > height + 0.05)
    person.press("Stop", panel.get_by_role("button", name="Stop"))
    save = panel.get_by_role("link", name="Save")
    save.wait_for()
    with page.expect_download() as film:
        person.press("Save", save)
    assert film.value.suggested_filename.endswith(".mp4")
    person.press("Close", panel.get_by_title("Close"))


def take_it_back(person: Person) -> None:
    person.node("block")
    person.page.get_by_role("tree").focus()
    person.key("Delete")
    until(lambda: "block" not in person.client.scene)
    person.press("Undo", person.page.get_by_title("Undo (Ctrl-Z)"))
    until(lambda: "block" in person.client.scene)
    person.tab("History")
    expect(person.page.locator("#history .undone").first).to_be_visible()


def run_into_something(person: Person) -> None:
    page, client = person.page, person.client

    def mode(name: str) -> None:
        person.press("Modes", page.get_by_role("radio", name="Modes"))
        person.press(name, page.get_by_label("Mode of all robots").get_by_role("radio", name=name))
        until(lambda: client.collisions.settings.mode == name)

    person.tab("Collisions")
    mode("monitor")
    person.press("Add …")
    person.press("Box", page.get_by_role("radio", name="Box"))
    thing(person, "post", ("100", "100", "400"), ("200", "0", "750"))
    person.pose(Y="350")
    person.arrive()
    person.press("Events", page.get_by_role("radio", name="Events"))
    events = page.get_by_role("list", name="What began and ended")
    expect(events.get_by_text("began to touch").first).to_be_visible()
    expect(events.get_by_role("button", name="post").first).to_be_visible()
    mode("stop")
    person.pose(Y="-350")
    person.go()
    expect(page.locator("#last")).to_contain_text("post")
    expect(page.locator("#motion")).to_have_text("at rest")
    assert person.tool[1] > 0.0


def stop(person: Person) -> None:
    page, client = person.page, person.client
    person.node("post")
    page.get_by_role("tree").focus()
    person.key("Delete")
    until(lambda: "post" not in client.scene)
    page.get_by_label("Speed of all robots, %").fill("20")
    until(lambda: client.speed_factor == 0.2)
    begin = person.tool
    person.go()
    until(lambda: np.linalg.norm(person.tool - begin) > 0.02)
    person.press("STOP", page.locator("#stop"))
    expect(page.locator("#stop")).to_contain_text("STOPPED")
    assert client.cell.stopped is not None
    person.press("Release")
    until(lambda: client.cell.stopped is None)
    person.arrive()
    assert person.tool[1] == pytest.approx(-0.35, abs=1e-3)


def keep_it(person: Person) -> None:
    page = person.page
    with page.expect_download() as cell:
        person.press("Save the cell", page.locator("#save"))
    assert cell.value.suggested_filename.startswith("cell.")
    expect(page.locator("#last")).to_contain_text("saved the cell")
    person.done.append("Open a scene")
    expect(page.get_by_title("Open a scene")).to_be_visible()
    person.tab("Program")
    with page.expect_download() as program:
        person.press("Save as a program file", page.locator("#save-program"))
    assert program.value.suggested_filename == "program.yaml"


DAY = {
    "A table": a_table,
    "An arm on it": an_arm_on_it,
    "A gripper": a_gripper,
    "A part": a_part,
    "By hand": by_hand,
    "Five places": five_places,
    "Play it": play_it,
    "Film it": film_it,
    "Take it back": take_it_back,
    "Run into something": run_into_something,
    "Stop": stop,
    "Keep it": keep_it,
}
"""Doings of a person in each section."""


@pytest.fixture
def person(kernel: KernelProcess, stubs: Stubs, console_of: Callable[[str], Console]) -> Iterator[Person]:
    with virtualrobot.connect(kernel.address) as client, browsers() as browser:
        with opened(browser, console_of(kernel.address).url + PLAIN, 1280, 720) as page:
            expect(page.locator("#connection")).to_have_text("connected")
            yield Person(page, client)


def test_a_person_does_the_tutorial(person: Person) -> None:
    sections = told()
    assert list(sections) == list(DAY)
    for name, do in DAY.items():
        person.done.clear()
        do(person)
        assert person.done == sections[name], name
