"""A person in the cell with an emulated headset: goals by hand, plans that are checked, motions that run while held.

What has happened is read by a second client.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterator
from contextlib import ExitStack, nullcontext
from functools import partial

import cv2
import numpy as np
import pytest
import virtualrobot
from PIL import Image
from playwright.sync_api import Browser, Page, expect
from virtualrobot import Client
from virtualrobot.v1 import motion_pb2

from tests.api.asking import IIWA
from tests.api.reading import state, step
from tests.apps.console.browsing import PLAIN, PURPLE, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.apps.console.headsets import IWER, UNDRAWN, Person
from tests.apps.console.headsets import in_room as drawn_room
from tests.apps.test_registration_marker import CAMERA, FIELD, HEIGHT, WIDTH, made_picture
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

in_room = partial(drawn_room, script=UNDRAWN)
needs_iwer = pytest.mark.skipif(
    not IWER.is_file(), reason="no emulated headset: npm ci in the folder web of the console"
)
pytestmark = [*needs_page, needs_iwer, pytest.mark.long]

HERE = (0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0)
SLOW = 0.25
"""Part of its speed: it is to stand before it is there."""
WAY = (-0.1, -0.08, 0.06)
"""A way of the tool in the world, m."""
UP = np.array([0.0, 0.0, 0.01])
FLOAT32 = 1e-4
"""Poses of headsets have single precision; and the kernel's inverse is iterative for seven joints. Meters."""

FREE = re.compile(r"Hold to run.*free, \d")

PAUSED, SUCCEEDED = motion_pb2.MOTION_PHASE_PAUSED, motion_pb2.MOTION_PHASE_SUCCEEDED
CANCELLED = motion_pb2.MOTION_PHASE_CANCELLED

DENY = """() => {
  const before = navigator.mediaDevices.getUserMedia;
  window.allow = () => { navigator.mediaDevices.getUserMedia = before; };
  navigator.mediaDevices.getUserMedia = () => Promise.reject(new DOMException("", "NotAllowedError"));
}"""

HANG = (
    """(ms) => { setTimeout(() => { for (const begin = performance.now(); performance.now() < begin + ms; ); }, 0); }"""
)

STRETCH = """(part) => {
  for (const [side, sign] of [["left", -1], ["right", 1]]) {
    headset.controllers[side].position.set(sign * part, 1.2, -0.3);
    headset.controllers[side].updateButtonValue("squeeze", 1);
  }
}"""
"""Squeezes both controllers, each so far (m) to its side."""

CAMERA_T_MARKER = virtualrobot.pose(0.15, -0.1, 1.2, roll=2.6, pitch=0.2, yaw=0.4)
WORLD_T_MARKER = virtualrobot.pose(0.7, 0.2, 0.4, roll=0.5, yaw=-0.8)


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """Return a browser whose camera sees the printed marker 7, again and again."""
    picture = made_picture(CAMERA_T_MARKER, np.random.default_rng(5), number=7)
    film = tmp_path_factory.mktemp("camera") / "sheet.mjpeg"
    film.write_bytes(cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes() * 2)
    camera = "--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"
    with browsers(*camera, f"--use-file-for-fake-video-capture={film}") as one:
        yield one


@pytest.fixture
def client(stepped_kernel: KernelProcess, stepped: Stubs) -> Iterator[Client]:
    with virtualrobot.connect(stepped_kernel.address) as client:
        arm = client.load_robot(IIWA, name="arm")
        arm.set_positions(HERE)
        arm.speed_factor = SLOW
        yield client


class Room:
    """A room that tests share one after the other: to enter it takes most of a test's time."""

    def __init__(self, browser: Browser, stack: ExitStack) -> None:
        """Enter none yet."""
        self._browser, self._stack = browser, stack
        self._person: Person | None = None

    def person(self, console: Console) -> Person:
        """Return a person who has taken nothing yet, before the arm that there is."""
        person = self._person
        if person is None or person.told.count() == 0:
            person = self._person = self._stack.enter_context(in_room(self._browser, console, "arm"))
        person.let_go()
        expect(row(person.page, "arm")).to_have_count(1)
        expect(person.told).to_contain_text("Take the ball")
        person.frames(10)
        return person


@pytest.fixture(scope="module")
def room(browser: Browser) -> Iterator[Room]:
    with ExitStack() as stack:
        yield Room(browser, stack)


@pytest.fixture
def person(room: Room, console: Console, client: Client) -> Person:
    return room.person(console)


def motions(stubs: Stubs) -> list[motion_pb2.Motion]:
    return list(stubs.motion.ListMotions(motion_pb2.ListMotionsRequest()).motions)


def purple_middle(page: Page) -> np.ndarray:
    """Return the middle of what is purple in the view, pixels from its upper left corner; far away without any."""
    picture = Image.open(io.BytesIO(page.locator(".view .canvas").screenshot())).convert("RGB")
    red, green, blue = np.moveaxis(np.asarray(picture, float), 2, 0)
    rows, columns = np.nonzero((red > green + 50.0) & (blue > green + 50.0))
    return np.array([columns.mean(), rows.mean()]) if len(rows) else np.full(2, np.inf)


def runs(stubs: Stubs, person: Person) -> bool:
    person.frames(1)  # time goes by as the page sees it
    step(stubs, 2)
    return any(state(stubs, "arm").velocities)


def is_in(stubs: Stubs, phase: int, person: Person) -> bool:
    if person.page.locator("#room").count():
        person.frames(1)
    step(stubs, 60)
    return motions(stubs)[-1].phase == phase


def check_rests(stubs: Stubs) -> None:
    """Fail when an arm goes on, however much time goes by."""
    here = state(stubs, "arm").positions
    step(stubs, 200)
    assert state(stubs, "arm").positions == here


def propose(person: Person, client: Client) -> np.ndarray:
    """Propose a way of the tool, which is free, and return where its end is."""
    goal = person.take(client.robot("arm").tcp[:3, 3], WAY)
    expect(person.told).to_contain_text(FREE)
    return goal


@pytest.mark.parametrize("by_hand", [False, True])
def test_a_proposed_motion_runs_while_it_is_held(
    browser: Browser, room: Room, console: Console, stepped: Stubs, client: Client, by_hand: bool
) -> None:
    begin, before = client.robot("arm").tcp, len(motions(stepped))
    with (
        in_room(browser, console, "arm", mode="Virtual reality", by_hand=True)
        if by_hand
        else nullcontext(room.person(console))
    ) as person:
        goal = propose(person, client)
        check_rests(stepped)
        assert len(motions(stepped)) == before  # it is only shown
        seen = client.proposals.list()[-1]  # by whoever looks
        assert (seen.state, seen.robots, seen.check.ok) == ("proposed", ("arm",), True)
        person.point("hold")
        person.pull()
        until(lambda: runs(stepped, person))
        person.pull(0)
        until(lambda: is_in(stepped, PAUSED, person))
        check_rests(stepped)
        assert 0.0 < motions(stepped)[-1].progress < 1.0
        expect(person.told).to_contain_text("Paused")

        person.point("hold")
        person.pull()
        until(lambda: is_in(stepped, SUCCEEDED, person))
        person.pull(0)
        assert len(motions(stepped)) == before + 1
        end = client.robot("arm").tcp
        np.testing.assert_allclose(end[:3, 3], goal, atol=FLOAT32)
        np.testing.assert_allclose(end[:3, :3], begin[:3, :3], atol=1e-3)
        expect(person.told).to_contain_text("There")
        until(lambda: client.proposals.get(seen.id).state == "executed")


def test_a_person_in_virtual_reality_turns_and_walks(
    browser: Browser, console: Console, stepped: Stubs, client: Client
) -> None:
    """Turned by 30 degrees, the person walks until the ball is at hand; where it goes tells how the hand moves."""
    tcp = client.robot("arm").tcp[:3, 3]
    with in_room(browser, console, "arm", mode="Virtual reality") as person:
        for side in (1.0, 1.0, -1.0):
            person.push("right", right=side)
            person.frames(5)  # held, the stick turns no farther
            person.push("right")
        person.heading = -math.pi / 6.0
        ahead = np.array([math.sin(math.pi / 6.0), math.cos(math.pi / 6.0), 0.0])
        person.reach(tcp - 0.5 * ahead + 8.0 * UP)  # the ray misses it
        person.squeeze(1)
        person.frames(5)
        expect(person.told).to_contain_text("Take the ball")

        def taken() -> bool:
            person.squeeze(0)
            person.move(-UP, 1)
            person.push("left", ahead=0.5)
            person.push("left")
            person.squeeze(1)
            person.move(UP, 1)
            person.frames(2)
            return "Take the ball" not in person.told.inner_text()

        until(taken)
        person.move(WAY - UP)
        person.page.evaluate("still", 120)
        person.squeeze(0)
        expect(person.told).to_contain_text(FREE)
        person.point("hold")
        person.pull()
        until(lambda: is_in(stepped, SUCCEEDED, person))
    np.testing.assert_allclose(client.robot("arm").tcp[:3, 3], tcp + WAY, atol=FLOAT32)


def hold_to_the_end(person: Person, stubs: Stubs) -> None:
    """Hold what is proposed until it is done; a page too slow for its beats has let go, and is pressed anew."""
    person.point("hold")

    def is_done() -> bool:
        person.pull(0)
        person.pull(1)
        return is_in(stubs, SUCCEEDED, person)

    until(is_done)
    person.pull(0)


def test_goals_are_where_they_are_shown_in_every_size(
    browser: Browser, console: Console, stepped: Stubs, client: Client
) -> None:
    """At 1:5 and 2:1 hands move a fifth of the tool's way, and twice as far; hands twice as far apart make 1:2.5."""
    with in_room(browser, console, "arm") as person:
        for button, presses, words, scale in (("smaller", 2, "1:5", 5.0), ("larger", 3, "2:1", 0.5)):
            for _ in range(presses):
                person.press(button)
            expect(person.told).to_contain_text(words)
            person.scale = scale
            goal = propose(person, client)
            hold_to_the_end(person, stepped)
            np.testing.assert_allclose(client.robot("arm").tcp[:3, 3], goal, atol=FLOAT32 * max(scale, 1.0))
            person.press("reject")
            client.robot("arm").set_positions(HERE)
        for _ in range(3):
            person.press("smaller")
        for part in (0.1, 0.2):
            person.page.evaluate(STRETCH, part)
            person.frames(5)
        expect(person.told).to_contain_text("1:2.5")
        person.page.evaluate("headset.controllers.left.updateButtonValue('squeeze', 0)")
        person.squeeze(0)
        person.press("life")
        expect(person.told).not_to_contain_text("1:2.5")
        person.scale = 1.0
        goal = propose(person, client)
        hold_to_the_end(person, stepped)
        np.testing.assert_allclose(client.robot("arm").tcp[:3, 3], goal, atol=FLOAT32)


def test_what_is_rejected_ends_and_what_is_undone_is_as_before(person: Person, stepped: Stubs, client: Client) -> None:
    propose(person, client)
    person.point("hold")
    person.pull()
    until(lambda: runs(stepped, person))
    person.pull(0)
    until(lambda: is_in(stepped, PAUSED, person))
    here = state(stepped, "arm").positions
    person.back()
    until(lambda: is_in(stepped, CANCELLED, person))
    assert motions(stepped)[-1].end_reason == "rejected in the room"
    check_rests(stepped)
    assert state(stepped, "arm").positions == here

    # Before it has begun there is nothing that could run any more.
    count = len(motions(stepped))
    propose(person, client)
    person.press("reject")
    until(lambda: client.proposals.list()[-1].reason == "rejected in the room")
    person.point("hold")
    person.pull()
    check_rests(stepped)
    person.pull(0)
    assert len(motions(stepped)) == count

    # Goals are taken back.
    first = propose(person, client)
    person.take(first, (0.0, 0.0, -0.2))
    expect(person.told).to_contain_text(FREE)
    until(lambda: client.proposals.list()[-1].undo_count == 1)
    person.press("undo")
    until(lambda: client.proposals.list()[-1].undo_count == 0)
    expect(person.told).to_contain_text(FREE)
    person.point("hold")
    person.pull()
    until(lambda: is_in(stepped, SUCCEEDED, person))
    person.pull(0)
    np.testing.assert_allclose(client.robot("arm").tcp[:3, 3], first, atol=FLOAT32)
    expect(person.told).to_contain_text("There")

    # Targets are taught into the world, and undo takes them out of it.
    person.press("teach")
    until(lambda: "P1" in client.scene)
    np.testing.assert_allclose(client.scene.pose("P1"), client.robot("arm").tcp, atol=FLOAT32)
    person.press("undo")
    until(lambda: "P1" not in client.scene)


def test_what_others_propose_is_seen_changed_and_approved(person: Person, stepped: Stubs, client: Client) -> None:
    arm = client.robot("arm")
    made = client.proposals.create([arm.ptp({"lbr_iiwa_joint_1": 0.4})], title="to the press")
    expect(person.told).to_contain_text(re.compile("Hold to run.*to the press.*free"))
    client.proposals.reject(made, "too near to the door")
    expect(person.told).to_contain_text(re.compile("Not so.*rejected by .*too near to the door"))
    seen = client.proposals.update(made.id, [arm.ptp({"lbr_iiwa_joint_1": 0.2})])
    expect(person.told).to_contain_text(re.compile("Hold to run.*to the press.*free"))
    # Taken by hand it is the same one, with another goal; what the other one does with it then is seen, too.
    propose(person, client)
    until(lambda: client.proposals.get(made.id).revision == seen.revision + 1)
    changed = client.proposals.get(made.id)
    assert changed.title == "to the press"
    back = client.proposals.undo(changed)
    expect(person.told).to_contain_text(re.compile("Hold to run.*to the press.*free"))
    person.point("hold")
    person.pull()
    until(lambda: is_in(stepped, SUCCEEDED, person))
    person.pull(0)
    until(lambda: client.proposals.get(back.id).state == "executed")
    assert arm.positions[0] == 0.2


def test_what_was_shown_is_what_runs(person: Person, stepped: Stubs, client: Client) -> None:
    tool = client.robot("arm").tcp[:3, 3]
    away, there = virtualrobot.pose(x=1.5), virtualrobot.pose(*(tool + WAY))
    client.scene.add_object("box", virtualrobot.box(0.08, 0.08, 0.08), pose=there)
    # What touches something does not run.
    person.take(tool, WAY)
    expect(person.told).to_contain_text(re.compile("Not so.*box"))
    count = len(motions(stepped))
    client.scene.set_pose("box", away)
    person.point("hold")
    person.pull()
    expect(person.told).to_contain_text(FREE)
    check_rests(stepped)
    person.pull(0)
    # Somebody puts something there after it was looked at.
    client.scene.set_pose("box", there)
    person.pull()
    expect(person.told).to_contain_text(re.compile("Not so.*box"))
    check_rests(stepped)
    person.pull(0)
    client.scene.set_pose("box", away)
    person.pull()
    expect(person.told).to_contain_text(FREE)
    check_rests(stepped)
    assert len(motions(stepped)) == count  # though the trigger is held: it is to be looked at first
    person.pull(0)
    person.pull()
    until(lambda: is_in(stepped, SUCCEEDED, person))
    person.pull(0)
    np.testing.assert_allclose(client.robot("arm").tcp[:3, 3], tool + WAY, atol=FLOAT32)

    # Out of reach it says by how much, in lengths and angles.
    person.take(tool + WAY, (0.0, 3.0, 0.0))
    expect(person.told).to_contain_text(re.compile(r"Not so.*\d mm and [\d.]+° off"))


def test_a_page_that_hangs_or_is_left_lets_go(person: Person, stepped: Stubs, client: Client) -> None:
    propose(person, client)
    person.point("hold")
    person.pull()
    until(lambda: runs(stepped, person))
    person.page.evaluate(HANG, 1400)
    until(lambda: is_in(stepped, PAUSED, person))
    person.frames(10)  # the page is there again, and the trigger still held
    check_rests(stepped)
    assert motions(stepped)[-1].phase == PAUSED

    person.pull(0)
    person.pull()
    until(lambda: runs(stepped, person))
    person.page.evaluate("() => headset.activeSession.end()")
    until(lambda: is_in(stepped, CANCELLED, person))
    expect(person.told).to_have_count(0)
    check_rests(stepped)


def test_the_room_is_found_by_touching(person: Person, stepped: Stubs, client: Client) -> None:
    """Three frames of the cell are touched where they are in the real room, which has y up."""
    places = {"touch-1": (0.5, 0.4, 0.2), "touch-2": (0.5, -0.5, 0.0), "touch-3": (-0.4, 0.3, 0.6)}
    y_up = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    world_t_room = virtualrobot.pose(0.3, -1.2, 0.1, yaw=0.4) @ y_up
    person.press("register")
    expect(person.told).to_contain_text("three frames are needed")
    for name, place in places.items():
        client.scene.add_frame(name, pose=virtualrobot.pose(*place))
    expect(row(person.page, "touch-3")).to_have_count(1)
    person.register(places, world_t_room)
    until(lambda: "headset" in client.scene)
    np.testing.assert_allclose(client.scene.pose("headset"), world_t_room, atol=FLOAT32)
    person.page.evaluate("() => headset.activeSession.end()")  # other tests have the room elsewhere
    expect(person.told).to_have_count(0)


def test_a_hand_leads_the_tool_itself(person: Person, stepped: Stubs, client: Client) -> None:
    """The dead man's switch counts simulation time: whatever the page needs for a picture, ten of them may be lost."""
    begin = client.robot("arm").tcp

    def leads() -> bool:
        person.frames(1)
        step(stepped, 5)
        return float(np.linalg.norm(client.robot("arm").tcp[:3, 3] - goal)) < FLOAT32

    person.press("lead")
    expect(person.told).to_contain_text("The ball leads the tool")
    person.reach(begin[:3, 3])
    person.squeeze(1)
    goal = begin[:3, 3] + WAY
    person.move(WAY)
    until(leads)
    expect(person.told).to_contain_text("0 mm behind")
    np.testing.assert_allclose(client.robot("arm").tcp[:3, :3], begin[:3, :3], atol=1e-3)
    (led,) = client.motions()
    assert led.robots == ("arm",)
    above = goal + np.array([0.0, 0.0, 0.3])
    # A page that hangs leads nothing, though the hand goes on.
    person.page.evaluate("([x, y, z]) => atHand().position.set(x, y, z)", person.room(above))
    person.page.evaluate(HANG, 1400)
    step(stepped, 200)
    check_rests(stepped)
    assert motions(stepped)[-1].end_cause == motion_pb2.END_CAUSE_SETPOINT_TIMEOUT
    assert client.robot("arm").tcp[2, 3] < goal[2] + 0.29
    person.squeeze(0)
    person.press("lead")
    expect(person.told).to_contain_text("Take the ball")


def test_a_phone_shows_the_cell_over_its_camera(
    browser: Browser, console: Console, stepped: Stubs, client: Client
) -> None:
    """A thing on the sheet is drawn where a pinhole has it in the camera's picture, which covers the view."""
    client.scene.add_frame("marker", pose=WORLD_T_MARKER)
    dice = virtualrobot.box(0.05, 0.05, 0.05, color=PURPLE)
    client.scene.add_object("dice", dice, pose=WORLD_T_MARKER @ virtualrobot.pose(x=-0.2, z=0.05))
    width, height = 900, 500
    with opened(browser, console.url + PLAIN, width=width, height=height) as page:
        page.get_by_role("tab", name="Views").click()
        section = page.get_by_role("region", name="In the room")
        # There is no headset here, and another device gets in by no code.
        expect(section).to_contain_text("headset")
        expect(page.get_by_title(re.compile("^(Augmented|Virtual) reality"))).to_have_count(0)
        section.get_by_role("button", name="Code for a phone or headset").click()
        expect(section).to_contain_text("listens to this machine alone")

        page.evaluate(DENY)
        section.get_by_role("button", name="Over the camera").click()
        expect(page.locator("#overlaid")).to_contain_text("was not allowed to see by the camera")
        page.evaluate("allow()")
        section.get_by_role("button", name="Over the camera").click()
        field = page.get_by_label("Horizontal field of view of the camera")
        field.fill(f"{math.degrees(FIELD):.3f}")
        field.press("Enter")
        expect(page.locator("#overlaid")).to_contain_text("the cell stands by the sheet of marker")
        size = page.locator(".view .canvas").bounding_box()
        assert size
        u, v, depth = CAMERA @ (CAMERA_T_MARKER @ [-0.2, 0.0, 0.05, 1.0])[:3]
        scale = max(size["width"] / WIDTH, size["height"] / HEIGHT)
        there = np.array([u / depth - WIDTH / 2, v / depth - HEIGHT / 2]) * scale
        there += [size["width"] / 2, size["height"] / 2]
        until(lambda: np.linalg.norm(purple_middle(page) - there) < 3.0)
        section.get_by_role("button", name="Leave the camera").click()
        expect(page.locator(".view video")).to_have_count(0)
