"""A person in the cell with an emulated headset: goals by hand, plans that are checked, motions that run while held.

What has happened is read by a second client.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Browser, expect
from virtualrobot import Client
from virtualrobot.v1 import motion_pb2

from tests.api.asking import IIWA
from tests.api.reading import state, step
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.apps.console.headsets import IWER, Person, in_room
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

needs_iwer = pytest.mark.skipif(
    not IWER.is_file(), reason="no emulated headset: npm ci in the folder web of the console"
)
pytestmark = [*needs_page, needs_iwer, pytest.mark.long]

HERE = (0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0)
SLOW = 0.25
"""Part of its speed: it is to stand before it is there."""
WAY = (-0.1, -0.08, 0.06)
"""A way of the tool in the world, m."""
FLOAT32 = 1e-4
"""Poses of headsets have single precision; and the kernel's inverse is iterative for seven joints. Meters."""

FREE = re.compile(r"Hold to run.*free, \d")

PAUSED, SUCCEEDED = motion_pb2.MOTION_PHASE_PAUSED, motion_pb2.MOTION_PHASE_SUCCEEDED
CANCELLED = motion_pb2.MOTION_PHASE_CANCELLED

HANG = (
    """(ms) => { setTimeout(() => { for (const begin = performance.now(); performance.now() < begin + ms; ); }, 0); }"""
)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with browsers() as one:
        yield one


@pytest.fixture
def client(stepped_kernel: KernelProcess, stepped: Stubs) -> Iterator[Client]:
    with virtualrobot.connect(stepped_kernel.address) as client:
        arm = client.load_robot(IIWA, name="arm")
        arm.set_positions(HERE)
        arm.speed_factor = SLOW
        yield client


def motions(stubs: Stubs) -> list[motion_pb2.Motion]:
    return list(stubs.motion.ListMotions(motion_pb2.ListMotionsRequest()).motions)


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
    browser: Browser, console: Console, stepped: Stubs, client: Client, by_hand: bool
) -> None:
    begin, before = client.robot("arm").tcp, len(motions(stepped))
    mode = "Virtual reality" if by_hand else "Augmented reality"
    with in_room(browser, console, "arm", mode=mode, by_hand=by_hand) as person:
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


def test_what_is_rejected_ends_and_what_is_undone_is_as_before(
    browser: Browser, console: Console, stepped: Stubs, client: Client
) -> None:
    with in_room(browser, console, "arm") as person:
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


def test_what_others_propose_is_seen_changed_and_approved(
    browser: Browser, console: Console, stepped: Stubs, client: Client
) -> None:
    arm = client.robot("arm")
    with in_room(browser, console, "arm") as person:
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


def test_what_was_shown_is_what_runs(browser: Browser, console: Console, stepped: Stubs, client: Client) -> None:
    tool = client.robot("arm").tcp[:3, 3]
    away, there = virtualrobot.pose(x=1.5), virtualrobot.pose(*(tool + WAY))
    client.scene.add_object("box", virtualrobot.box(0.08, 0.08, 0.08), pose=there)
    with in_room(browser, console, "arm") as person:
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


def test_a_page_that_hangs_or_is_left_lets_go(
    browser: Browser, console: Console, stepped: Stubs, client: Client
) -> None:
    with in_room(browser, console, "arm") as person:
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


def test_the_room_is_found_by_touching(browser: Browser, console: Console, stepped: Stubs, client: Client) -> None:
    """Three frames of the cell are touched where they are in the real room, which has y up."""
    places = {"touch-1": (0.5, 0.4, 0.2), "touch-2": (0.5, -0.5, 0.0), "touch-3": (-0.4, 0.3, 0.6)}
    y_up = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    world_t_room = virtualrobot.pose(0.3, -1.2, 0.1, yaw=0.4) @ y_up
    with in_room(browser, console, "arm") as person:
        person.press("register")
        expect(person.told).to_contain_text("three frames are needed")
        for name, place in places.items():
            client.scene.add_frame(name, pose=virtualrobot.pose(*place))
        expect(row(person.page, "touch-3")).to_have_count(1)
        person.press("register")
        for name, place in places.items():
            expect(person.told).to_contain_text(f"Touch {name}")
            person.touch((np.linalg.inv(world_t_room) @ [*place, 1.0])[:3].tolist())
        expect(person.told).to_contain_text("registered, points off by 0.0 mm at most")
        until(lambda: "headset" in client.scene)
        np.testing.assert_allclose(client.scene.pose("headset"), world_t_room, atol=FLOAT32)


def test_a_browser_without_a_headset_says_so(browser: Browser, console: Console, client: Client) -> None:
    with opened(browser, console.url + PLAIN) as page:
        page.get_by_role("tab", name="Views").click()
        section = page.get_by_role("region", name="In the room")
        expect(section).to_contain_text("headset")
        expect(section.get_by_role("button")).to_have_count(0)
        expect(page.get_by_title(re.compile("^(Augmented|Virtual) reality"))).to_have_count(0)
